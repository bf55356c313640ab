# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A robot as a laptop's program sees it: `edgefusion.connect`. It needs neither the C++ core nor ONNX Runtime."""

from __future__ import annotations

import os
import uuid
from pathlib import Path
from types import TracebackType
from typing import Iterator, NamedTuple, Optional, Sequence, Tuple, Type, Union

import msgspec
import zenoh

from edgefusion.bus.heartbeat import Heartbeat
from edgefusion.bus.key_files import usual_folder
from edgefusion.bus.listener import Listener
from edgefusion.bus.publisher import CommandPublisher
from edgefusion.bus.queries import ask
from edgefusion.bus.requests import Answer, GoalRequest, GotoRequest, InspectRequest, ResumeRequest, StopRequest
from edgefusion.bus.session import Closable, UnreachableError, open_client
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import CMD_VEL, GOTO, INSPECT, RESUME, STOP, key_of
from edgefusion.errors import RefusedError
from edgefusion.messages.from_cmd_vel import from_cmd_vel
from edgefusion.messages.mission_report import MissionReport
from edgefusion.types import Twist2D

HERE = "tcp/127.0.0.1:7447"
CMD_VEL_TTL_MS = 200
SILENCE_S = 5.0
ENDS = ("arrived", "blocked", "idle")


class Errand(NamedTuple):
    """Goals that the robot has accepted. since_ns: by its clock; what it says later is of these."""

    goal_ids: Tuple[str, ...]
    since_ns: int


def connect(
    endpoint: str = HERE, robot: str = "robot", keys: Union[str, Path, None] = None, timeout_s: float = 5.0
) -> Robot:
    """A robot, by its router at tcp/HOST:PORT on this computer or tls/HOST:PORT.

    robot: its name, where it has another than usual. keys: the folder with this computer's, for tls; usually
    $EDGEFUSION_KEYS or ~/.config/edgefusion/keys.
    Raises RefusedError for what will not do, UnreachableError where no router lets us in in time.
    """
    if keys is None and endpoint.startswith("tls/"):
        keys = usual_folder(os.environ, Path.home())
    return Robot(open_client(endpoint, None if keys is None else Path(keys), timeout_s), robot)


class Robot(Listener):
    """What a robot says, and commands to it, for which an operator's keys are needed. It ends with its `with`.

    Commands raise RefusedError with the robot's reason, and UnreachableError where it does not answer.
    """

    def __init__(self, session: zenoh.Session, name: str) -> None:
        super().__init__(session, name)
        self._tagger = Tagger()
        self._cmd_vel = CommandPublisher(session, name, CMD_VEL, self._tagger, CMD_VEL_TTL_MS)

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def close(self) -> None:
        """Nothing more is heard or sent."""
        session: Closable = self.session
        session.close()

    def goto(
        self, x_m: float, y_m: float, theta: Optional[float] = None, inspect: Optional[Sequence[str]] = None
    ) -> Errand:
        """Drive there, in `odom`, instead of to the goals that are left. theta [rad]: to look in this direction there.

        inspect: labels of what to inspect on the way; None: as before.
        """
        return self.goto_all([GoalRequest(x_m, y_m, theta)], inspect)

    def goto_all(self, goals: Sequence[GoalRequest], inspect: Optional[Sequence[str]] = None) -> Errand:
        """Drive to these, in this order, instead of to the goals that are left. Those without an id are given one."""
        run = uuid.uuid4().hex[:8]
        named = tuple(
            goal if goal.id else msgspec.structs.replace(goal, id=f"{run}-{number}")
            for number, goal in enumerate(goals, start=1)
        )
        answer = self._ask(GOTO, GotoRequest(named, None if inspect is None else tuple(inspect)))
        return Errand(tuple(goal.id for goal in named), answer.stamp_ns)

    def progress(self, errand: Errand, timeout_s: float = SILENCE_S) -> Iterator[MissionReport]:
        """How the mission is, until it has ended: the last one says how. It has, too, when somebody else gave other
        goals. One that is stopped with goals left may be resumed, and has not ended."""
        return _until_ended(self.missions(timeout_s), errand)

    def stop(self, reason: str = "asked by an operator", cancel: bool = False) -> None:
        """Stand still, until `resume`. cancel: and give up the goals that are left."""
        self._ask(STOP, StopRequest(reason, cancel))

    def resume(self) -> None:
        """Leave a stop, and give the robot back to its mission after `drive`."""
        self._ask(RESUME, ResumeRequest())

    def inspect(self, labels: Sequence[str]) -> None:
        """What to inspect from now on."""
        self._ask(INSPECT, InspectRequest(tuple(labels)))

    def drive(self, twist: Twist2D) -> None:
        """Drive so for the moment: to be called ten times a second. The mission pauses until `resume`."""
        if not self._cmd_vel.heard:
            raise UnreachableError(
                f"{key_of(self.name, CMD_VEL.name)}: nobody listens: is the base running, and may these keys command?"
            )
        self._cmd_vel.put(from_cmd_vel(twist))

    def attend(self) -> Heartbeat:
        """`with robot.attend():` an operator is there; a robot that requires one stops when that ends."""
        return Heartbeat(self.session, self.name, self._tagger)

    def _ask(self, name: str, request: msgspec.Struct) -> Answer:
        try:  # what was built in Python is checked as strictly as what comes as JSON
            msgspec.convert(msgspec.to_builtins(request), type(request))
        except msgspec.ValidationError as error:
            raise RefusedError(f"{name}: {error}") from error
        return ask(self.session, key_of(self.name, name), request, self._tagger)


def _until_ended(reports: Iterator[MissionReport], errand: Errand) -> Iterator[MissionReport]:
    for report in reports:
        if report.stamp_ns < errand.since_ns:
            continue
        yield report
        given_up = report.state == "stopped" and not report.goal_id
        if report.state in ENDS or given_up or (report.goal_id and report.goal_id not in errand.goal_ids):
            return
