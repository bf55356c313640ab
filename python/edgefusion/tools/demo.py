# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion demo`: the main job on the small scene that comes with the project, without a robot."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from edgefusion.types import Detection

EXAMPLES = """examples:
  edgefusion demo
  edgefusion demo --out out/demo --seed 3"""

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
    from edgefusion.tools.results import ResultsFolder, free_folder
    from edgefusion.tools.run_recording import detect_all
    from edgefusion.tools.scene import write_recording

    out = args.out or free_folder(Path("out"), "demo")
    with ResultsFolder(out) as results:
        recording = FolderRecording(write_recording(out / "scene", args.seed))
        calibration = load_calibration(recording.calibration_path)
        detector = Detector(open_classifier(args.model), calibration)
        tally = detect_all(recording, detector, calibration, Config(), results, images=True)
        detections = detector.detect(recording.scan(0), recording.frame(0))
        results.write_summary(tally.summary(out))
    print(_table(detections))
    print(f"\nimages with boxes:    {out / 'annotated'}\nscans from above:     {out / 'scans'}")
    print(f"every detection:      {out / 'detections.jsonl'}")
    if args.model == MODEL:
        print(f"\n{NOTE}")
    return 0


def _table(detections: list[Detection]) -> str:
    from edgefusion.tools.scene import OBJECTS, ROOM, nearest_m

    rows = ["first frame    measured           truth     label       box"]
    for detection in detections:
        truth = min(OBJECTS + ROOM, key=lambda solid: abs(nearest_m(solid, 0.0) - detection.distance_m))
        rows.append(
            f"{truth.name:13}  {detection.distance_m:.3f} +- {detection.distance_sigma_m:.3f} m  "
            f"{nearest_m(truth, 0.0):.3f} m   {detection.label:10}  {list(detection.box)}"
        )
    return "\n".join(rows)
