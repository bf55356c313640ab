# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion sim`: the robot, its laser and its camera, simulated in real time, for any client of theirs."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict

from edgefusion.errors import RefusedError

if TYPE_CHECKING:
    from edgefusion.sim.live_devices import LiveDevices, LiveSetup

EXAMPLES = """examples:
  edgefusion sim
  edgefusion sim office --links /tmp/sim
  edgefusion sim --robot p3dx --config-packet wrong --laser-left-at 38400
  edgefusion sim --fault laser=stuck@10+5 --fault robot=garbage:0.01

In another terminal, with what the first one prints:
  edgefusion robot socket://127.0.0.1:8101
  edgefusion laser /tmp/sim/laser
  edgefusion run --config /tmp/sim/robot.toml

A fault is COMPONENT=KIND[:VALUE][@FROM_S[+FOR_S]], for robot, laser and camera: off, stuck, garbage (share of the
bytes), wrong (a camera's brightness), slow (one of so many comes), delayed (seconds), intermittent (share that does
not come)."""

_PAUSE_S = 0.002
_STATUS_NS = 1_000_000_000


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The verb's options."""
    parser = subparsers.add_parser(
        "sim",
        help="serve a simulated robot, laser and camera on ports of this machine",
        description="Serves a Pioneer 3-DX (SIP), an LMS200 and a camera in one simulated world, in real time, until "
        "Ctrl-C. What speaks to the real ones speaks to these.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("world", nargs="?", default="laboratory", help="one that ships, or a TOML file (default: laboratory)")
    add("--robot", default="p3dx-sh", choices=("p3dx", "p3dx-sh"), help="its board (default: p3dx-sh)")
    add("--config-packet", default="right", choices=("right", "wrong", "missing"), help="how its CONFIGpac comes")
    add("--laser-left-at", type=int, choices=(9600, 19200, 38400, 500000), metavar="BAUD", help="streaming, at a speed")
    add("--power-up", type=float, default=0.0, metavar="S", help="so long the laser is off at first")
    add("--port", type=int, default=8101, metavar="N", help="the robot's TCP port, 0: any (default: 8101)")
    add("--camera-port", type=int, default=0, metavar="N", help="the camera's HTTP port (default: any)")
    add("--no-camera", action="store_true", help="needs no renderer then")
    links = "make DIR/robot and DIR/laser, links to the serial ports, and DIR/robot.toml for `edgefusion run`"
    add("--links", type=Path, metavar="DIR", help=links)
    add("--fault", action="append", default=[], metavar="FAULT", help="what goes wrong; may be given again")
    add("--seed", type=int, default=0, metavar="N", help="of noise and faults (default: 0)")
    add("--for", dest="for_s", type=float, default=math.inf, metavar="S", help="end after so many seconds")
    add("--json", action="store_true", help="one line of JSON that says where what is served")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Serves until it is interrupted, which is how it ends well. Raises RefusedError."""
    import contextlib
    import time

    from edgefusion.service.signals import ended_by_signals
    from edgefusion.sim.live_devices import LiveDevices
    from edgefusion.tools.sim_config import remove_config, write_config

    _check(args)
    setup = _setup(args)
    with ended_by_signals():
        devices = LiveDevices(setup, time.monotonic_ns())
        written: Dict[Path, str] = {}
        try:
            with contextlib.suppress(KeyboardInterrupt):
                written = {} if args.links is None else write_config(args.links, devices)
                _announce(devices, next(iter(written), None), args.json)
                _pump(devices, args)
        finally:
            devices.close()
            remove_config(written)
    return 0


def _check(args: argparse.Namespace) -> None:
    from edgefusion.tools.sim_config import check_free

    if not args.for_s > 0:
        raise RefusedError(f"--for {args.for_s:g}: expected seconds above 0")
    if not 0 <= args.power_up < math.inf:
        raise RefusedError(f"--power-up {args.power_up:g}: expected seconds of at least 0")
    for name, port in (("--port", args.port), ("--camera-port", args.camera_port)):
        if not 0 <= port <= 65535:
            raise RefusedError(f"{name} {port}: expected 0 to 65535")
    if args.links is not None:
        check_free(args.links)
    if args.seed < 0:
        raise RefusedError(f"--seed {args.seed}: expected at least 0")


def _setup(args: argparse.Namespace) -> LiveSetup:
    from dataclasses import replace

    from edgefusion.sim.faults import parse_fault
    from edgefusion.sim.live_devices import LiveSetup
    from edgefusion.sim.sip_robot_character import CHARACTERS
    from edgefusion.sim.world_file import load_world

    return LiveSetup(
        world=load_world(args.world),
        seed=args.seed,
        character=replace(CHARACTERS[args.robot], config_packet=args.config_packet),
        robot_port=args.port,
        camera_port=args.camera_port,
        links=args.links,
        laser_left_at=args.laser_left_at,
        laser_power_up_s=args.power_up,
        camera=not args.no_camera,
        faults=tuple(parse_fault(text) for text in args.fault),
    )


def _announce(devices: LiveDevices, config: Path | None, as_json: bool) -> None:
    import json
    import sys

    served = {**_served(devices), "config": None if config is None else str(config)}
    if as_json:
        print(json.dumps(served), flush=True)
        return
    print(f"robot:   {served['robot']}")
    print(f"         {served['robot_tcp']}")
    print(f"laser:   {served['laser']}")
    print(f"camera:  {served['camera'] or 'none'}")
    if config is not None:
        print(f"config:  {config}, for `edgefusion run --config` it")
    sys.stdout.flush()


def _served(devices: LiveDevices) -> dict[str, Any]:
    camera = None if devices.pictures is None else devices.pictures.url + "stream"
    return {
        "robot": devices.robot_pty.name,
        "robot_tcp": devices.robot_tcp.name,
        "laser": devices.laser_pty.name,
        "camera": camera,
    }


def _pump(devices: LiveDevices, args: argparse.Namespace) -> None:
    """Until the time is over; a line of status each second where somebody looks."""
    import sys
    import time

    from edgefusion.tools.terminal import Screen

    start_ns = time.monotonic_ns()
    said_ns, fault, screen = start_ns, "", Screen(sys.stderr)
    while (now_ns := time.monotonic_ns()) - start_ns < args.for_s * 1e9:
        devices.pump(now_ns)
        if devices.camera is not None and devices.camera.fault != fault:
            fault = devices.camera.fault
            print(f"camera:  none: {fault}", file=sys.stderr, flush=True)
            screen = Screen(sys.stderr)  # below that line
        if sys.stderr.isatty() and now_ns - said_ns >= _STATUS_NS:
            said_ns = now_ns
            screen.show([_status(devices)])
        time.sleep(_PAUSE_S)


def _status(devices: LiveDevices) -> str:
    body, robot = devices.world.body, devices.robot
    pose, twist = body.pose, body.twist
    session = "open" if robot.open else "closed"
    motors = "on" if robot.drive.motors else "off"
    streams = "streams" if devices.laser.streaming else "waits"
    return (
        f"at ({pose.x_m:.2f}, {pose.y_m:.2f}) m, {math.degrees(pose.theta):.0f} deg, {twist.v_mps:.2f} m/s; "
        f"session {session}, motors {motors}; laser {streams} at {devices.laser.line.baudrate}"
    )
