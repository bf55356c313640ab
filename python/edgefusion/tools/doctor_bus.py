# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether the bus opens, and lets in nobody but who has keys: by the sockets that its router really opens."""

from __future__ import annotations

import socket
import ssl
import time
from pathlib import Path
from typing import Any, Callable, Iterator, List, Sequence

from edgefusion.config.bus import ANY_HOST, BusConfig
from edgefusion.config.endpoint import Endpoint, parse_endpoint
from edgefusion.errors import RefusedError
from edgefusion.tools.doctor_finding import Examination, Finding, State
from edgefusion.tools.doctor_sockets import Socket, own_sockets

_HANDSHAKE_S = 3.0
_COMMON_NAME = bytes.fromhex("0603550403")
"""The number of that field, X.520's 2.5.4.3, in a certificate."""

_SOON_S = 30 * 86400
_NEW_KEYS = "make them anew: `edgefusion keys init`"
_OTHER = "a router is there already: end it, or `systemctl stop edgefusion` for this check; `ss -ltnp` says who"


def check_bus(
    exam: Examination,
    open_router: Callable[[BusConfig], Any] | None = None,
    now: Callable[[], float] = time.time,
    connect_s: float = 3.0,
) -> Iterator[Finding]:
    """Opens the router for a moment, or asks for so long for the one on another machine. now: seconds since 1970."""
    try:
        if exam.runs("bus"):
            yield from _router(exam.config.bus, open_router, now)
        else:
            yield from _client(exam.config.bus, connect_s)
    except ModuleNotFoundError as error:
        yield Finding("bus", State.FAILED, f"expected the package {error.name}, got none", f"pip install {error.name}")
    except RefusedError as error:
        yield Finding("bus", State.FAILED, str(error), "mend [bus] keys")


def _router(
    config: BusConfig, open_router: Callable[[BusConfig], Any] | None, now: Callable[[], float]
) -> Iterator[Finding]:
    from edgefusion.bus import router

    before = own_sockets()
    listen = ", ".join(config.listen)
    try:
        opened = (open_router or router.open_router)(config)
    except OSError:  # its text is Zenoh's
        yield Finding("bus", State.FAILED, f"cannot listen on {listen}", _OTHER)
        return
    try:
        new = [each for each in own_sockets() if each not in before]
        yield from _judged(config, exposures(new, config.listen), now)
    finally:
        opened.close()


def exposures(sockets: Sequence[Socket], listen: Sequence[str]) -> List[str]:
    """What of these lets in more than programs of this computer and who has keys. listen: endpoints of the router."""
    endpoints = [parse_endpoint("listen", text) for text in listen]
    secure = {endpoint.port for endpoint in endpoints if endpoint.protocol == "tls"}
    found = []
    for each in sockets:
        if each.protocol == "udp":
            found.append(f"it looks for others by UDP, on {each.address}:{each.port}")
        elif each.listens and not each.is_loopback and each.port not in secure:
            found.append(f"it listens without TLS on {each.address}:{each.port}, open to everybody on the network")
    return found


def _judged(config: BusConfig, exposed: List[str], now: Callable[[], float]) -> Iterator[Finding]:
    for text in exposed:
        yield Finding("bus", State.FAILED, text, "mend [bus] listen; nothing else may open it")
    endpoints = [parse_endpoint("listen", text) for text in config.listen]
    keyed = [each for each in endpoints if each.protocol == "tls"]
    findings = [_keys(config, each, now) for each in keyed]
    bad = [finding for finding in findings if finding.state is not State.OK]
    if not exposed and not bad:
        told = findings[0].text if findings else "only programs of this computer reach it"
        yield Finding("bus", State.OK, f"listens on {', '.join(config.listen)}, no multicast; {told}")
    yield from bad


def _keys(config: BusConfig, endpoint: Endpoint, now: Callable[[], float]) -> Finding:
    """By a handshake with the router itself, as the robot's other processes make it."""
    host = "localhost" if endpoint.host in ANY_HOST else endpoint.host.strip("[]")
    try:
        certificate = _certificate(host, endpoint.port, Path(str(config.keys)))
    except OSError as error:  # of which ssl's errors are
        reason = getattr(error, "verify_message", "") or error.strerror or str(error)
        return Finding("bus", State.FAILED, f"tls/{host}:{endpoint.port}: {reason}", _NEW_KEYS)
    names = {name: value for pairs in certificate["subject"] for name, value in pairs}
    role, ends_s = names.get("commonName", ""), ssl.cert_time_to_seconds(certificate["notAfter"])
    until = time.strftime("%Y-%m-%d", time.gmtime(ends_s))
    if role != "robot":
        text = f"{config.keys}: expected a robot's keys, got {role or 'another'}'s"
        return Finding("bus", State.FAILED, text, _NEW_KEYS)
    if ends_s - now() < _SOON_S:
        return Finding("bus", State.WARNING, f"{config.keys}: these keys end on {until}", _NEW_KEYS)
    return Finding("bus", State.OK, f"its keys are good until {until}")


def _certificate(host: str, port: int, keys: Path) -> Any:
    """The router's, checked against its CA, its host and today's date. Raises OSError, RefusedError."""
    from edgefusion.bus.key_files import find_keys

    files = find_keys(keys)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.load_verify_locations(files.ca)
    context.load_cert_chain(files.certificate, files.key)
    raw = socket.create_connection((host, port), _HANDSHAKE_S)
    with raw, context.wrap_socket(raw, server_hostname=host) as secure:
        return secure.getpeercert()


def _client(config: BusConfig, connect_s: float) -> Iterator[Finding]:
    from edgefusion.bus.session import UnreachableError, open_client

    keys = None if config.keys is None else Path(config.keys)
    try:
        session: Any = open_client(config.router, keys, connect_s)
    except UnreachableError as error:
        cure = "start the machine with the router; [bus] connect says where it is"
        yield Finding("bus", State.FAILED, str(error), cure)
        return
    session.close()
    by_tls = parse_endpoint("connect", config.router).protocol == "tls"  # else they are of no account
    role = _role(keys) if by_tls and keys is not None else "robot"
    if role != "robot":
        text = f"{keys}: expected a robot's keys, got {role or 'another'}'s: nothing that it says would pass"
        yield Finding("bus", State.FAILED, text, "make it some: `edgefusion keys add NAME --role robot`")
        return
    yield Finding("bus", State.OK, f"the router at {config.router} lets this machine in")


def _role(keys: Path) -> str:
    """Which role its certificate was issued to: the last common name in it; the one before is its issuer's."""
    from edgefusion.bus.key_files import find_keys

    certificate = ssl.PEM_cert_to_DER_cert(find_keys(keys).certificate.read_text(encoding="ascii"))
    name = certificate.rpartition(_COMMON_NAME)[2]
    return name[2 : 2 + name[1]].decode("utf-8", "replace")
