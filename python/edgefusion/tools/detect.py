# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion detect`: the main job, on a recording."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from edgefusion.tools.arguments import whole_number
from edgefusion.tools.recording_options import FORMATS, add_recording, open_asked

if TYPE_CHECKING:
    from edgefusion.config import Config
    from edgefusion.perception.classifier import Classifier

EXAMPLES = f"""examples:
  edgefusion detect drive --model models/resnet18
  edgefusion detect drive --model models/resnet18 --objects 1 --images --out out/drive
  edgefusion detect drive --model models/resnet18 --find car --find 'traffic light'
  edgefusion detect drive.mcap --model models/resnet18 --image-topic /camera/image_raw
  edgefusion detect drive --model net.onnx --labels labels.txt --calibration calibration.toml --json

{FORMATS}
Exit codes: 0 done, 1 failed while running, 2 refused input, 130 interrupted; what was written before stays."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "detect",
        help="names and distances of the objects in a recording",
        description="Finds, names and measures the objects in front of the robot in a recorded drive.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_recording(parser)
    parser.add_argument("--model", type=Path, required=True, help="model folder, or an .onnx file with --labels")
    parser.add_argument("--labels", type=Path, help="one label per line, for a bare .onnx file")
    parser.add_argument("--calibration", type=Path, help="instead of the recording's own")
    parser.add_argument("--config", type=Path, help="TOML file with [perception] and [sync] settings")
    parser.add_argument(
        "--objects", type=whole_number(1, 100), metavar="N", help="the N nearest objects (the paper: 1)"
    )
    find_help = "keep only objects of this label or group, such as car or lamp (again for more)"
    parser.add_argument("--find", action="append", default=[], metavar="NAME", help=find_help)
    parser.add_argument("--groups", type=Path, help="TOML file of label groups instead of edgefusion's own")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the results (default: out/RECORDING)")
    parser.add_argument("--overwrite", action="store_true", help="replace the results in DIR")
    parser.add_argument("--images", action="store_true", help="write annotated images and pictures of the scans")
    parser.add_argument("--provider", default="auto", help="auto, tensorrt, cuda or cpu (default: auto)")
    parser.add_argument("--require", metavar="PROVIDER", help="refuse to run on any other provider")
    parser.add_argument("--threads", type=int, default=0, help="threads of the network (default: all cores)")
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Detects in a whole recording. Raises RefusedError."""
    from edgefusion.clock import system_clock
    from edgefusion.perception.detector import Detector
    from edgefusion.perception.groups import LabelGroups
    from edgefusion.tools.recording_calibration import find_calibration
    from edgefusion.tools.results import ResultsFolder, results_path
    from edgefusion.tools.run_recording import detect_all

    config = _load_config(args)
    recording = open_asked(args)
    calibration, source = find_calibration(recording, args.calibration)
    classifier = _open_classifier(args)
    groups = LabelGroups.load(args.groups)
    wanted = {label for name in args.find for label in groups.labels_of(name, classifier.labels)}
    detector = Detector(classifier, calibration, config.perception, groups, system_clock)
    out = results_path(args.out, args.recording.resolve().name, args.overwrite)
    with ResultsFolder(out, args.overwrite) as results:
        tally = detect_all(recording, detector, calibration, config, results, args.images, wanted)
        summary = {"provider": classifier.provider, "calibration": source, **tally.summary(out)}
        results.write_summary(summary)
    print(msgspec.json.encode(summary).decode() if args.json else _as_text(summary))
    return 0


def _load_config(args: argparse.Namespace) -> Config:
    from edgefusion.config import load_config

    config = load_config(args.config)
    if args.objects is None:
        return config
    perception = msgspec.structs.replace(config.perception, objects=args.objects)
    return msgspec.structs.replace(config, perception=perception)


def _open_classifier(args: argparse.Namespace) -> Classifier:
    from edgefusion.perception.classifier import open_classifier
    from edgefusion.perception.network import RuntimeOptions

    options = RuntimeOptions(provider=args.provider, require=args.require, threads=args.threads)
    return open_classifier(args.model, labels=args.labels, options=options)


def _as_text(summary: dict[str, Any]) -> str:
    found = ", ".join(f"{label} {n}" for label, n in list(summary["labels"].items())[:8])
    sync = ", ".join(f"{ending} {n}" for ending, n in summary["sync"].items())
    stages = ", ".join(f"{stage} {ms:g}" for stage, ms in summary["median_ms"].items())
    return "\n".join(
        [
            f"{summary['frames']} frames, {summary['detections']} detections on {summary['provider']}",
            f"found:           {found or 'nothing'}",
            f"calibration:     {summary['calibration']}",
            f"pairing:         {sync}",
            f"median ms:       {stages}",
            f"peak memory:     {summary['peak_memory_mb']} MB",
            f"results:         {summary['out']}",
        ]
    )
