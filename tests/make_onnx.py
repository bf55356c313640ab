# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Builds tiny ONNX classifiers, so that no test needs a trained one, and forges their folders."""

from pathlib import Path

import msgspec
import numpy as np
import tomli_w
from onnx import ModelProto, TensorProto, helper, numpy_helper, save

from edgefusion.perception.model_folder import sealed

LABELS = ("bottle", "chair", "crane", "crane", "plant")
"""Of the tiny networks' five classes; ImageNet, too, has two cranes."""


def tiny_network(
    *,
    seed=0,
    classes=5,
    batch="n",
    size="s",
    softmax=False,
    half=False,
    opset=13,
    ir_version=7,
    input_type=TensorProto.FLOAT,
    outputs=("y",),
    liveliness=20.0,
    only_size=None,
) -> ModelProto:
    """Convolution, ReLU, mean over the image, a linear layer; liveliness 0 = the same answer to everything.

    batch, size: a number fixes them. half: the linear layer's weights are float16. only_size: as VGG, without
    the mean: it runs at this size only, though its input says any.
    """
    rng = np.random.default_rng(seed)
    features = 8 if only_size is None else 8 * ((only_size - 3) // 2 + 1) ** 2
    pooled = "means" if only_size is None else "positive"
    weights = {
        "conv": rng.normal(0, 0.3, (8, 3, 3, 3)),
        "linear": liveliness * rng.normal(0, 0.3, (features, classes)),
        "bias": np.zeros(classes),
    }
    nodes = [
        helper.make_node("Conv", ["x", "conv"], ["features"], strides=[2, 2]),
        helper.make_node("Relu", ["features"], ["positive"]),
        helper.make_node("GlobalAveragePool", ["positive"], ["means"]),
        helper.make_node("Flatten", [pooled], ["flat"]),
        helper.make_node("Cast", ["linear"], ["wide"], to=TensorProto.FLOAT),
        helper.make_node("Gemm", ["flat", "wide", "bias"], ["scores" if softmax else "y"]),
    ]
    if softmax:
        nodes.append(helper.make_node("Softmax", ["scores"], ["y"], axis=1))
    nodes += [helper.make_node("Identity", ["y"], [name]) for name in outputs if name != "y"]
    initializers = [
        numpy_helper.from_array(value.astype(np.float16 if half and name == "linear" else np.float32), name)
        for name, value in weights.items()
    ]
    graph = helper.make_graph(
        nodes,
        "tiny",
        [helper.make_tensor_value_info("x", input_type, [batch, 3, size, size])],
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, [batch, classes]) for name in outputs],
        initializers,
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)], ir_version=ir_version)


def save_tiny(path: Path, **options) -> Path:
    """Writes a tiny network; the options of `tiny_network`."""
    save(tiny_network(**options), str(path))
    return path


def save_labels(path: Path, labels=LABELS) -> Path:
    path.write_text("".join(f"{label}\n" for label in labels), encoding="utf-8")
    return path


def edit_manifest(folder: Path, change) -> None:
    """Changes the manifest as a table, and seals it anew."""
    path = folder / "manifest.toml"
    table = msgspec.toml.decode(path.read_bytes())
    del table["sha256"]["manifest.toml"]
    change(table)
    path.write_bytes(sealed(tomli_w.dumps(table).encode()))
