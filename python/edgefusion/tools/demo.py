# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion demo`: the main job on the small scene that comes with the project, without a robot."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from edgefusion.errors import RefusedError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from edgefusion.types import Detection

EXAMPLES = """examples:
  edgefusion demo
  edgefusion demo --out out/demo --seed 3

Exit codes: 0 done, 1 failed while running, 2 refused input, 130 interrupted."""

MODEL = Path(__file__).resolve().parents[1] / "data" / "random-model"
NOTE = (
    "The labels mean nothing yet, nor does the height that wins: the network that comes with the project has random\n"
    "weights. Clusters, widths and distances are real. For 1000 real classes: python models/export.py --out\n"
    "models/resnet18, then edgefusion demo --model models/resnet18."
)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "demo",
        help="see it work without a robot",
        description="Runs the detector on a small scene of known truth and shows what it finds.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the results (default: out/demo)")
    parser.add_argument("--overwrite", action="store_true", help="replace the results in DIR")
    parser.add_argument("--model", type=Path, default=MODEL, help="model folder (default: random weights)")
    parser.add_argument("--seed", type=int, default=0, help="of the noise of both sensors")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Writes the scene as a recording, detects in it, prints what was found beside the truth."""
    from edgefusion.config import Config
    from edgefusion.perception.calibration import load_calibration
    from edgefusion.perception.classifier import open_classifier
    from edgefusion.perception.detector import Detector
    from edgefusion.recording.folder import FolderRecording
    from edgefusion.tools.results import ResultsFolder, results_path
    from edgefusion.tools.run_recording import detect_all

    out = results_path(args.out, "demo", args.overwrite)
    with ResultsFolder(out, args.overwrite) as results:
        recording = FolderRecording(_write_scene(out / "scene", args.seed))
        calibration = load_calibration(recording.calibration_path)
        detector = Detector(open_classifier(args.model), calibration)
        tally = detect_all(recording, detector, calibration, Config(), results, images=True)
        results.write_summary(tally.summary(out))
    print(_table(tally.first_frame))
    print(f"\nimages with boxes:    {out / 'annotated'}\nscans from above:     {out / 'scans'}")
    print(f"every detection:      {out / 'detections.jsonl'}")
    if args.model == MODEL:
        print(f"\n{NOTE}")
    return 0


def _write_scene(path: Path, seed: int) -> Path:
    from edgefusion.tools.scene import write_recording

    try:
        return write_recording(path, seed)
    except OSError as error:
        raise RefusedError(f"{path}: cannot write there: {error.strerror}") from error


def _table(detections: list[Detection]) -> str:
    from edgefusion.tools.scene import OBJECTS, ROOM, nearest_m

    rows = ["first frame    measured           truth     label       box"]
    for detection in detections:
        truth = min(OBJECTS + ROOM, key=lambda solid: _apart_m(solid.outline, detection.position_m))
        rows.append(
            f"{truth.name:13}  {detection.distance_m:.3f} +- {detection.distance_sigma_m:.3f} m  "
            f"{nearest_m(truth, 0.0):.3f} m   {detection.label:10}  {list(detection.box)}"
        )
    return "\n".join(rows)


def _apart_m(outline: npt.NDArray[np.float64], position_m: tuple[float, float]) -> float:
    """From a point to the nearest edge of an outline [n, 2]."""
    import numpy as np

    a = outline - position_m
    edge = np.roll(a, -1, axis=0) - a
    along = np.clip(-(a * edge).sum(axis=1) / (edge * edge).sum(axis=1), 0, 1)
    return float(np.hypot(*(a + along[:, None] * edge).T).min())
