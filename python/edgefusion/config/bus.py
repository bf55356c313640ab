# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of the bus: where it listens, whom it lets in, whose commands count, and how often what is published."""

from __future__ import annotations

import sys
from typing import Optional, Tuple

import msgspec

from edgefusion.config.endpoint import Endpoint, parse_endpoint
from edgefusion.config.strict import FilePath, Seconds, UpTo100, check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated

RobotName = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_-]*$", max_length=64)]
EndpointText = Annotated[str, msgspec.Meta(min_length=1, max_length=300)]

ANY_HOST = ("0.0.0.0", "[::]")


class BusConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the robot is reached. By default by nobody but the programs on its own computer."""

    robot: RobotName = "robot"
    """The first part of every key on the bus: what tells robots under one router apart."""
    listen: Annotated[Tuple[EndpointText, ...], msgspec.Meta(min_length=1, max_length=8)] = ("tcp/127.0.0.1:7447",)
    """Where the router listens: "tcp/HOST:PORT" on loopback, where all programs of this computer may do everything;
    "tls/HOST:PORT" anywhere, with keys."""
    connect: Optional[EndpointText] = None
    """Where base and vision find the router. Left out: on this computer. Where it is set vision asks base for the clock
    that everything is stamped with."""
    keys: Optional[FilePath] = None
    """The folder with this computer's keys, as `edgefusion keys init` makes it for the robot. Left out: no TLS."""
    allow_plain_ros: bool = False
    """Whether commands count that carry no session and number, as those of RViz and of teleoperation nodes."""
    require_operator: bool = False
    """Whether the robot drives only while an operator's heartbeat arrives."""
    operator_timeout_s: Seconds = 0.5
    """After so long without a heartbeat the robot stops, where an operator is required."""
    cmd_vel_timeout_s: Annotated[float, msgspec.Meta(ge=0.05, le=1)] = 0.2
    """So long a cmd_vel is followed; then the robot stands until the next one."""
    max_command_bytes: Annotated[int, msgspec.Meta(ge=256, le=1_000_000)] = 4096
    """What is larger is no command."""
    max_command_hz: Annotated[float, msgspec.Meta(ge=1, le=1000)] = 50.0
    """Of commands of one kind that come faster, the rest is dropped."""
    lease_s: Annotated[float, msgspec.Meta(ge=0.1, le=60)] = 1.0
    """A connection that is silent for so long is given up."""
    pose_hz: UpTo100 = 20.0
    """How often odometry and transforms are published at most. Scans and detections are all published."""
    image_hz: UpTo100 = 10.0
    """How often the camera's images are published at most, while somebody listens."""
    annotated_hz: UpTo100 = 5.0
    """How often images with boxes and labels are published at most, while somebody listens."""
    state_hz: Annotated[float, msgspec.Meta(ge=1, le=100)] = 2.0
    """How often states are published at least; changes are published at once."""
    jpeg_quality: Annotated[int, msgspec.Meta(ge=1, le=100)] = 80
    """Of the images. [%]"""

    def __post_init__(self) -> None:
        check_fields(self)
        endpoints = [check_endpoint("listen", text, self.keys is not None) for text in self.listen]
        ports = [endpoint.port for endpoint in endpoints]
        if len(set(ports)) < len(ports):
            raise RefusedError(f"listen: expected a different port for each, got {', '.join(self.listen)}")
        if self.connect is not None:
            check_endpoint("connect", self.connect, self.keys is not None)

    @property
    def router(self) -> str:
        """The endpoint by which the robot's own processes find the router: the first on loopback, else by TLS."""
        if self.connect is not None:
            return self.connect
        endpoints = [parse_endpoint("listen", text) for text in self.listen]
        for endpoint in endpoints:
            if endpoint.protocol == "tcp":
                return str(endpoint)
        first = endpoints[0]
        return str(Endpoint("tls", "localhost" if first.host in ANY_HOST else first.host, first.port))


def check_endpoint(name: str, text: str, has_keys: bool) -> Endpoint:
    """To listen on or to connect to. Raises RefusedError for clear text over a network, and for tls without keys."""
    endpoint = parse_endpoint(name, text)
    if endpoint.protocol == "tcp" and not endpoint.is_loopback:
        raise RefusedError(
            f"{name}: expected tcp on loopback only, or tls with keys, got {text}: open to everybody on the network"
        )
    if endpoint.protocol == "tls" and not has_keys:
        raise RefusedError(f"{name}: expected keys for {text}: `edgefusion keys init` makes them")
    return endpoint
