# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From a torch network to an ONNX file that old runtimes read, checked against torch."""

from __future__ import annotations

import inspect
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from edgefusion.errors import RefusedError
from edgefusion.perception.network import Network, RuntimeOptions, one_line

# ONNX Runtime 1.11, the last one for a Jetson TX2, reads opsets up to 16 and IR versions up to 8.
OPSET, NEWEST_IR = 13, 8
TOLERANCE = 1e-4


def export_onnx(torch: Any, model: Any, path: Path, size: int, fixed_size: bool) -> None:
    """Writes a network as ONNX, with any number of pictures a batch, of any size unless fixed. Raises RefusedError."""
    axes = {0: "batch"} if fixed_size else {0: "batch", 2: "height", 3: "width"}
    try:
        # The newer exporter cannot write an opset that is old enough; torch warns that this one is older.
        with warnings.catch_warnings(), torch.no_grad():
            warnings.simplefilter("ignore")
            torch.onnx.export(
                model,
                (torch.zeros(1, 3, size, size),),
                str(path),
                opset_version=OPSET,
                input_names=["input"],
                output_names=["logits"],
                dynamic_axes={"input": axes, "logits": {0: "batch"}},
                **_old_exporter(torch),
            )
    except Exception as error:
        came = one_line(error)[:300] + ("" if fixed_size else "; --fixed-size may help")
        raise RefusedError(f"export: expected a network that can be written, got: {came}") from error


def _old_exporter(torch: Any) -> dict[str, bool]:
    """Older versions of torch know neither the newer exporter nor this switch."""
    return {"dynamo": False} if "dynamo" in inspect.signature(torch.onnx.export).parameters else {}


def describe(onnx_file: Path) -> str:
    """Versions and left-over batch norms of an ONNX file. Raises RefusedError for too new ones."""
    import onnx

    model = onnx.load(str(onnx_file))
    opset = model.opset_import[0].version
    if opset > OPSET or model.ir_version > NEWEST_IR:
        expected = f"expected opset {OPSET} and IR version {NEWEST_IR} at most"
        raise RefusedError(f"export: {expected}, got {opset} and {model.ir_version}")
    norms = sum(node.op_type == "BatchNormalization" for node in model.graph.node)
    folded = f"{norms} batch norms that no convolution precedes" if norms else "all batch norms folded"
    return f"opset {opset}, IR version {model.ir_version}, {len(model.graph.node)} operators, {folded}"


def compare(torch: Any, model: Any, onnx_file: Path, size: int, fixed_size: bool) -> float:
    """The largest difference to torch over several shapes, relative to large outputs. Raises RefusedError."""
    network = Network(onnx_file.read_bytes(), onnx_file.name, RuntimeOptions(provider="cpu"))
    rng = np.random.default_rng(0)
    shapes = [(1, size, size), (3, size, size), (8, size, size)]
    if not fixed_size:
        shapes += [(2, size + 32, size), (1, size, 2 * size)]
    largest = 0.0
    for n, height, width in shapes:
        batch = rng.standard_normal((n, 3, height, width), np.float32)
        with torch.no_grad():
            expected = model(torch.from_numpy(batch)).numpy()
        difference = float(np.abs(network.run(batch) - expected).max() / max(1.0, np.abs(expected).max()))
        if not difference <= TOLERANCE:
            came = f"{difference:.2g} for a batch of {n} at {height} x {width}"
            raise RefusedError(f"export: expected torch's outputs within {TOLERANCE:g}, got a difference of {came}")
        largest = max(largest, difference)
    return largest
