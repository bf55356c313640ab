# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion replay`: a recording onto a bus, as the robot told it, or into the detector."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Sequence

from edgefusion.errors import RefusedError
from edgefusion.tools.bus_options import add_bus
from edgefusion.tools.recording_options import FORMATS, add_recording

EXAMPLES = f"""examples:
  edgefusion replay drive.mcap
  edgefusion replay drive.bag --speed 4 --wait --loop
  edgefusion replay belgioioso.log.gz --speed 2
  edgefusion replay drive --speed max --connect tcp/127.0.0.1:7448
  edgefusion replay drive.mcap --model models/resnet18 > detections.jsonl

Without --model it is put on a bus of its own, where [bus] of --config says, or on that at --connect: not on that of a
robot which drives. Commands that were recorded are never put there. With --model every line of standard output is a
detection; the same recording gives the same bytes, whose checksum is told at the end.

{FORMATS}
Exit codes: 0 done, 1 the bus failed, 2 refused input, 130 interrupted."""

MAX = "max"


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "replay",
        help="play a recording onto a bus, or into the detector",
        description="Plays a recording onto a bus at any speed, or into the detector.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_recording(parser)
    speed_help = "times as fast as it was recorded, or max (default: 1)"
    parser.add_argument("--speed", type=_speed, metavar="X", help=speed_help)
    parser.add_argument("--loop", action="store_true", help="again and again, until it is interrupted")
    parser.add_argument("--wait", action="store_true", help="begin when somebody listens")
    add_bus(parser)
    calibration_help = "instead of the recording's own, also on the bus"
    parser.add_argument("--calibration", type=Path, metavar="FILE", help=calibration_help)
    parser.add_argument("--model", type=Path, help="into the detector with it: model folder, or .onnx with --labels")
    parser.add_argument("--labels", type=Path, help="one label per line, for a bare .onnx file")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Plays a recording. Raises RefusedError."""
    _check_used(args)
    if args.model is not None:
        from edgefusion.tools.replay_detector import detect_lines

        return detect_lines(args)
    from edgefusion.tools.replay_bus import play

    return play(args)


_OF_A_BUS = ("speed", "loop", "wait", "connect", "keys", "robot")


def _check_used(args: argparse.Namespace) -> None:
    """What was asked for and would have no part in it is refused. Raises RefusedError."""
    asked = [name for name in ("labels", *_OF_A_BUS) if getattr(args, name) not in (None, False)]
    if args.model is not None:
        _refuse([name for name in asked if name in _OF_A_BUS], "is for a bus, and with --model none has a part in it")
    else:
        _refuse([name for name in asked if name == "labels"], "is for a model, which --model gives")
        if args.connect is None:
            _refuse([name for name in asked if name == "keys"], "is for a bus elsewhere, which --connect gives")


def _refuse(names: Sequence[str], why: str) -> None:
    if names:
        raise RefusedError(f"{', '.join(f'--{name}' for name in names)}: {why}")


def _speed(text: str) -> float:
    """Infinite: as fast as it can."""
    if text == MAX:
        return math.inf
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if not 0 < speed < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0, or {MAX}, got {text!r}")
    return speed
