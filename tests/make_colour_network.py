# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A real ONNX classifier with known answers: it names a crop by the colour that most of it has."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from onnx import TensorProto, helper, numpy_helper, save

from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.preprocessing import DEFAULT


def save_colour_network(folder: Path, colours: dict[str, tuple[int, int, int]], sharpness: float = 40.0) -> Path:
    """Writes net.onnx and labels.txt; colours: label -> BGR. The class is the nearest hue of the mean pixel.

    Pooling and a linear layer: the mean pixel along each colour's direction, both normalized as for ImageNet, so that
    padding, which is 0, changes how sure it is but not what it says.
    """
    rgb = np.array([colour[::-1] for colour in colours.values()], float) / 255
    normalized = (rgb - np.array(DEFAULT.mean)) / np.array(DEFAULT.std)
    weights = sharpness * normalized / np.linalg.norm(normalized, axis=1, keepdims=True)
    bias = np.zeros(len(colours))
    graph = helper.make_graph(
        [
            helper.make_node("GlobalAveragePool", ["x"], ["pooled"]),
            helper.make_node("Flatten", ["pooled"], ["flat"]),
            helper.make_node("Gemm", ["flat", "w", "b"], ["logits"], transB=1),
            helper.make_node("Softmax", ["logits"], ["y"], axis=1),
        ],
        "colours",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n", 3, "h", "w"])],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, ["n", len(colours)])],
        [
            numpy_helper.from_array(weights.astype(np.float32), "w"),
            numpy_helper.from_array(bias.astype(np.float32), "b"),
        ],
    )
    folder.mkdir(parents=True, exist_ok=True)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=7)
    save(model, str(folder / "net.onnx"))
    (folder / "labels.txt").write_text("".join(f"{label}\n" for label in colours), encoding="utf-8")
    return folder / "net.onnx"


def open_colour_network(folder: Path, colours: dict[str, tuple[int, int, int]]) -> Classifier:
    """The network of `save_colour_network`, opened as any other."""
    path = save_colour_network(folder, colours)
    return open_classifier(path, labels=folder / "labels.txt")
