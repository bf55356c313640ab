# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether the simulator's pictures look like things: what a real network with 1000 classes calls each kind.

Each kind stands in a room by itself and is looked at from 1 to 3 m, at most 40 degrees off its front; the box is the
true one. A kind is named where most views get its label, or one of the same group.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path
from typing import Iterator, Sequence

import cv2
import numpy as np
import numpy.typing as npt
from benchmarks.run import markdown, write_results

from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.groups import LabelGroups
from edgefusion.sim.built_world import build
from edgefusion.sim.exposure import CameraSpec, exposed
from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.kinds.kind import Kind
from edgefusion.sim.light import random_light
from edgefusion.sim.random_world import random_world
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.truth import box_of
from edgefusion.sim.world import Thing, World
from edgefusion.types import UNKNOWN, Box, Pose2D

EXAMPLES = """examples:
  python -m benchmarks.kinds
  python -m benchmarks.kinds --views 50 --pictures out/kinds
  python -m benchmarks.kinds --model models/resnet18"""

MODELS = Path(__file__).resolve().parents[2] / "shared" / "data" / "models"
SIZE, FOCAL_PX = (1280, 960), 920.0
NEAREST_M, FARTHEST_M, OFF_FRONT, OFF_AXIS = 1.0, 3.0, 0.7, 0.15
FIRST_SEED = 4_000_000
Image = npt.NDArray[np.uint8]


def views(kind: Kind, count: int, rig: Rig, renderer: Renderer) -> Iterator[tuple[Image, Box]]:
    """Pictures of objects of a kind, each of another seed in another room, and their boxes."""
    for i in range(count):
        rng = np.random.default_rng([FIRST_SEED, i])
        built = build(_alone(kind, FIRST_SEED + i), rig.laser_height_m)
        renderer.show(built)
        around = float(rng.uniform(-OFF_FRONT, OFF_FRONT))
        away_m = float(rng.uniform(NEAREST_M, FARTHEST_M)) + built.sizes_m[0][0] / 2
        heading = around + np.pi + float(rng.uniform(-OFF_AXIS, OFF_AXIS))
        base = Pose2D(away_m * float(np.cos(around)), away_m * float(np.sin(around)), heading)
        picture = exposed(CameraSpec(), renderer.image(base, random_light(rng)), FOCAL_PX, 0.0, rng)
        yield picture, box_of(renderer.mask_alone(base, 0))


def _alone(kind: Kind, seed: int) -> World:
    """A random room with nothing in it but one object, in its middle, looking along x."""
    room = random_world(seed, [kind], things=0)
    thing = Thing(kind.name, kind, Pose2D(), seed)
    return World(room.name, seed, room.floor, room.ceiling_m, room.walls, (thing,), Pose2D(), Pose2D())


def said_of(
    classifier: Classifier, groups: LabelGroups, kind: Kind, pictures: Sequence[tuple[Image, Box]]
) -> Counter[str]:
    """What the network says of each picture: the kind's own label also where it says another of its group."""
    said: Counter[str] = Counter()
    for picture, box in pictures:
        label = classifier.labels[int(classifier.probabilities(picture, [box])[0].argmax())]
        group = groups.group_of(kind.label)
        said[kind.label if group and groups.group_of(label) == group else label] += 1
    return said


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.kinds",
        description=__doc__,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--model", type=Path, default=MODELS / "mobilenetv2_fp32_dequant.onnx")
    parser.add_argument(
        "--labels", type=Path, help="for a bare .onnx file (default: ImageNet's, for the default model)"
    )
    parser.add_argument("--views", type=int, default=20, help="of each kind (default: 20)")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="keep a sheet of each kind's views there")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), metavar="DIR", help="default: out/bench")
    args = parser.parse_args(argv)
    if not args.model.exists():
        print(f"skipped: {args.model} is not on this machine", file=sys.stderr)
        return 0
    labels = args.labels or (MODELS / "imagenet_classes.txt" if args.model.suffix == ".onnx" else None)
    classifier, groups = open_classifier(args.model, labels), LabelGroups.load()
    rig = Rig(image_size=SIZE, K=np.array([[FOCAL_PX, 0, 640], [0, FOCAL_PX, 480], [0, 0, 1]]))
    records: list[dict[str, object]] = []
    with Renderer(rig) as renderer:
        for kind in (each for each in CATALOGUE.values() if each.label != UNKNOWN):
            pictures = list(views(kind, args.views, rig, renderer))
            said = said_of(classifier, groups, kind, pictures)
            share = said[kind.label] / args.views
            records.append({"kind": kind.name, "label": kind.label, "share": share, "said": said.most_common(3)})
            if args.pictures:
                _write_sheet(args.pictures / f"{kind.name.replace(' ', '-')}.jpg", pictures)
    named = sum(float(str(record["share"])) > 0.5 for record in records)
    table = markdown(("kind", "label", "named in", "said most"), [_cells(record) for record in records])
    print(f"{table}\n\nnamed in most views: {named} of {len(records)} kinds")
    print(f"written to {write_results(args.out, 'kinds', records, table)}", file=sys.stderr)
    return 0


def _cells(record: dict[str, object]) -> list[str]:
    said = record["said"]
    assert isinstance(said, list)
    most = ", ".join(f"{label} {count}" for label, count in said)
    return [str(record["kind"]), str(record["label"]), f"{100 * float(str(record['share'])):.0f} %", most]


def _write_sheet(path: Path, pictures: Sequence[tuple[Image, Box]]) -> None:
    """The boxes of up to 12 views, side by side."""
    tiles = [
        cv2.resize(p[y0:y1, x0:x1], (160, 200), interpolation=cv2.INTER_AREA) for p, (x0, y0, x1, y1) in pictures[:12]
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(cv2.imencode(".jpg", np.hstack(tiles))[1].tobytes())


if __name__ == "__main__":
    sys.exit(main())
