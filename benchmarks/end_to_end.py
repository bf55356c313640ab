# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The paper's experiment in real time, end to end: simulated devices on ptys, all processes of the robot, a laptop.

A laptop's process gives the goal and gets the picture of what was inspected; it notes when it knew the objects of each
frame. Printed are the drive, how old a detection was then and where that time went, and the memory of each process.
Other figures are no reason to fail here: exit code 1 means that the robot did not arrive, touched something, or brought
no picture.
"""

from __future__ import annotations

import argparse
import math
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any, Dict, List, Sequence

from benchmarks.end_to_end_figures import DriveFigures, Spread, drive_figures, latencies, stages_ms
from benchmarks.end_to_end_picture import draw_drive
from benchmarks.end_to_end_robot import RobotSetup
from benchmarks.end_to_end_run import EndToEnd, run
from benchmarks.run import markdown, write_results

from edgefusion.errors import RefusedError
from edgefusion.service.signals import ended_by_signals
from edgefusion.sim.live_devices import LiveSetup
from edgefusion.sim.world_file import load_world
from edgefusion.tools.arguments import LAB_MODEL, seed_number, whole_number
from edgefusion.tools.experiment import LABORATORY, placed_by_seed

EXAMPLES = """examples:
  python -m benchmarks.end_to_end
  python -m benchmarks.end_to_end --seed 3 --baudrate 38400 --out out/end-to-end-38400

Exit codes: 0 arrived, with a picture and without a contact, 1 otherwise, 2 refused."""

LABEL = "oscilloscope"


def main(argv: Sequence[str] | None = None) -> int:
    parser = _parser()
    args = parser.parse_args(argv)
    args.out.mkdir(parents=True, exist_ok=True)
    try:
        world = LiveSetup(placed_by_seed(load_world(LABORATORY), args.seed), seed=args.seed, robot_port=0)
        with ended_by_signals(1), tempfile.TemporaryDirectory() as folder:
            result = run(world, RobotSetup(args.model, args.baudrate, args.threads), LABEL, Path(folder))
            _keep(Path(folder), args.out)
    except RefusedError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    drive = drive_figures(result)
    tables = [_drive_table(drive, result)]
    record: Dict[str, Any] = {**vars(args), "model": str(args.model), "out": str(args.out), **drive._asdict()}
    if result.laptop:
        times, stages = latencies(result), stages_ms(result)
        tables += [_latency_table(times, stages), _memory_table(result)]
        record.update(latency={name: each._asdict() for name, each in times.items()}, stages_ms=stages)
        draw_drive(args.out / "drive.png", result)
    record.update(_own(result))
    table = "\n\n".join(tables)
    print(table)
    print(f"written to {write_results(args.out, 'end-to-end', [record], table)}", file=sys.stderr)
    if not drive.good:
        print(f"expected an arrival with a picture and without a contact, got: {drive.said}", file=sys.stderr)
    return int(not drive.good)


def _keep(folder: Path, out: Path) -> None:
    """The picture that the laptop got, and the robot's log, in the place of those of an earlier run."""
    for old in out.glob("delivered-*.jpg"):
        old.unlink()
    for path in (*folder.glob("delivered-*.jpg"), folder / "robot.log"):
        shutil.copy(path, out)


def _own(result: EndToEnd) -> Dict[str, Any]:
    return {
        "first_detection_s": result.seen_s,
        "ended_s": result.ended_s,
        "memory_at_rest_mb": {name: each._asdict() for name, each in result.at_rest.items()},
        "memory_at_work_mb": {name: each._asdict() for name, each in result.at_work.items()},
    }


def _drive_table(drive: DriveFigures, result: EndToEnd) -> str:
    rows = [
        ["the drive", drive.said],
        ["pictures delivered of what was to be inspected", str(drive.pictures)],
        ["contacts", "some" if drive.touched else "none"],
        ["time", f"{drive.duration_s:.1f} s"],
        ["off the goal, in truth", f"{100 * drive.error_m:.1f} cm, {math.degrees(drive.error):.1f} deg"],
        ["least clearance", f"{100 * drive.clearance_m:.0f} cm"],
        ["from `edgefusion run` to the first detection on the laptop", f"{result.seen_s:.1f} s"],
        ["from SIGTERM to the end of all processes", f"{result.ended_s:.1f} s"],
    ]
    return markdown(("what", "came of it"), rows)


def _latency_table(times: Dict[str, Spread], stages: Dict[str, float]) -> str:
    rows: List[List[str]] = [
        [name, f"{each.p50:.0f} ms", f"{each.p99:.0f} ms", f"{each.worst:.0f} ms", str(each.number)]
        for name, each in times.items()
    ]
    rows += [[f"of it, {name}", f"{ms:.1f} ms", "", "", ""] for name, ms in stages.items()]
    rest = times["driver's stamp to the laptop"].p50 - sum(stages.values())
    rows.append(["of it, told over the bus and decoded (the rest)", f"{rest:.1f} ms", "", "", ""])
    return markdown(("from, to", "p50", "p99", "worst", "frames"), rows)


def _memory_table(result: EndToEnd) -> str:
    rows = []
    for name, rest in result.at_rest.items():
        work = result.at_work.get(name, rest)
        values = (rest.rss_mb, rest.pss_mb, work.rss_mb, work.pss_mb)
        rows.append([name, *(f"{value:.0f} MB" for value in values)])
    return markdown(("process", "at rest, RSS", "PSS", "at work, RSS", "PSS"), rows)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.end_to_end",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--seed", type=seed_number, default=0, help="where the object stands, and of noise (default: 0)")
    add("--baudrate", type=int, choices=(38400, 500000), default=500000, help="the laser's (default: 500000)")
    add("--threads", type=whole_number(0, 64), default=0, metavar="N", help="of the network; 0: one a core (default)")
    add("--model", type=Path, default=LAB_MODEL, help="model folder (default: the simulator's own)")
    add("--out", type=Path, default=Path("out/end-to-end"), metavar="DIR", help="default: out/end-to-end")
    return parser


if __name__ == "__main__":
    sys.exit(main())
