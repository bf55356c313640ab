# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A model that is not the one it was, and a GPU that is lost: I1 and I2, with the one that ships and a real one."""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Iterable, List, Sequence

from benchmarks.fault_row import FaultRow
from benchmarks.faults_model_gpu import Tick, gone, lost
from benchmarks.model_damage import CUTS, FLIPS, LAB_MODEL, ModelCopy

from edgefusion.errors import RefusedError
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.make_model import make_model_folder
from edgefusion.perception.model_folder import LABELS, MODEL, read_labels

REAL = Path(__file__).resolve().parents[2] / "shared" / "data" / "models" / "mobilenetv2_fp32_dequant.onnx"
_FORGED = 60


def rows(seeds: int, tick: Tick = lambda: None) -> List[FaultRow]:
    """Every figure with as many seeds. tick: called after each run."""
    found: List[FaultRow] = []
    with tempfile.TemporaryDirectory() as name:
        for model in _models(Path(name)):
            copy = ModelCopy(model, Path(name) / f"copy of {model.name}")
            found += [_damaged(copy, model.name, tick), _forged(copy, model.name, tick)]
            found += [lost(model, seeds, tick), gone(model, seeds, tick)]
        found.append(_processes(Path(name), tick))
    return found


def _models(folder: Path) -> List[Path]:
    """The one that ships, and a real one where this machine has it."""
    if not REAL.is_file():
        return [LAB_MODEL]
    labels = read_labels(REAL.parent / "imagenet_classes.txt")
    made = make_model_folder(
        REAL, labels, folder / "mobilenet", name="mobilenet", origin="a benchmark", licence="Apache-2.0"
    )
    return [LAB_MODEL, made.path]


def _damaged(model: ModelCopy, name: str, tick: Tick) -> FaultRow:
    flips, cuts = (_refused(model, contents) for contents in (model.flips(0), model.cuts()))
    tick()
    failed = (flips, cuts) != (FLIPS, CUTS)
    remark = f"{flips} of {FLIPS} flips and {cuts} of {CUTS} truncations refused, each with one line"
    return FaultRow("I1", f"{name}: bits flipped, truncated", "all refused", math.inf, remark=remark, failed=failed)


def _refused(model: ModelCopy, contents: Iterable[bytes], forged: bool = False) -> int:
    count = 0
    for content in contents:
        with model.with_file(MODEL, content, forged) as folder:
            count += _is_refused(folder)
    return count


def _is_refused(folder: Path) -> bool:
    """In one line."""
    try:
        open_classifier(folder)
    except RefusedError as error:
        return "\n" not in str(error)
    return False


def _forged(model: ModelCopy, name: str, tick: Tick) -> FaultRow:
    """With a manifest that vouches for what is there: only what the network is and answers tells then."""
    wrong = [(MODEL, content) for content in model.wrong_models.values()]
    wrong += [(LABELS, content) for content in model.wrong_labels.values()]
    count = 0
    for file, content in wrong:
        with model.with_file(file, content, forged=True) as folder:
            count += _is_refused(folder)
    told = _refused(model, model.flips(0, _FORGED), forged=True)
    tick()
    remark = f"{count} of {len(wrong)} refused; without checksums {told} of {_FORGED} flips would be"
    what = f"{name}: wrong file, labels not its outputs, with checksums forged"
    return FaultRow("I1", what, "all refused", math.inf, remark=remark, failed=count < len(wrong))


def _processes(folder: Path, tick: Tick) -> FaultRow:
    """As they are started."""
    copy = ModelCopy(LAB_MODEL, folder / "of processes")
    config = _configuration(folder, copy.path)
    damages = [(MODEL, next(copy.flips(3))), (MODEL, b""), (LABELS, copy.wrong_labels["one less"])]
    wrong: List[str] = []
    for name, content in damages:
        with copy.with_file(name, content, forged=name == LABELS):
            for code, arguments in ((2, ["vision"]), (14, ["doctor", "--only", "model"])):
                wrong += _told(code, [*arguments, "--config", str(config)])
                tick()
    required = _configuration(folder, copy.path, 'provider = "cuda"\nrequire_provider = true\n')
    wrong += _told(2, ["vision", "--config", str(required)])
    tick()
    count = 2 * len(damages) + 1
    remark = f"{count - len(wrong)} of {count} did{': ' if wrong else ''}{'; '.join(wrong)}"
    what = "`vision` and `doctor` as processes: damaged models, CUDA required where there is none"
    return FaultRow("I1, I2", what, "exit code 2 or 14, one line", math.inf, remark=remark, failed=bool(wrong))


def _configuration(folder: Path, model: Path, more: str = "") -> Path:
    (folder / "calibration.toml").write_text(
        "version = 1\nimage_size = [640, 480]\nK = [[457.0, 0, 319.5], [0, 457.0, 239.5], [0, 0, 1]]\n"
        "T_camera_laser = [[0, -1, 0, 0], [0, 0, -1, 0.2], [1, 0, 0, 0], [0, 0, 0, 1]]\nlaser_height_m = 0.25\n",
        encoding="utf-8",
    )
    path = folder / f"robot{len(more)}.toml"
    path.write_text(f'[vision]\nmodel = "{model}"\ncalibration = "calibration.toml"\n{more}', encoding="utf-8")
    return path


def _told(code: int, arguments: Sequence[str]) -> List[str]:
    """What is not as it should be."""
    command = [sys.executable, "-m", "edgefusion.cli", *arguments]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    said = [line for line in (ended.stderr + ended.stdout).splitlines() if "expected" in line]
    if ended.returncode == code and len(said) == 1:
        return []
    return [f"{arguments[0]} ended with {ended.returncode} and {len(said)} lines"]
