# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Networks from darknet's layer lists are the ones that everybody knows, in layers, parameters and shapes."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

onnx = pytest.importorskip("onnx")

from benchmarks.darknet import build_network, count_parameters, load_network, parse, resnet18_cfg  # noqa: E402

TINY = """
[net]
width=8
height=6
channels=3
# a comment
[convolutional]
filters=4
size=3
pad=1
activation=leaky

[maxpool]
size=2
stride=1

[convolutional]
filters=4
size=1
activation=linear

[shortcut]
from=-2
activation=linear

[maxpool]
size=2
stride=2

[upsample]
stride=2

[route]
layers=-1,0

[yolo]
"""


def ops(model) -> Counter:
    return Counter(node.op_type for node in model.graph.node)


def output_shapes(model) -> list[list[int]]:
    return [[d.dim_value for d in o.type.tensor_type.shape.dim][1:] for o in model.graph.output]


def test_a_tiny_network_has_the_layers_it_lists() -> None:
    model = build_network(TINY)
    onnx.checker.check_model(model, full_check=True)
    assert ops(model) == {"Conv": 2, "LeakyRelu": 1, "MaxPool": 2, "Add": 1, "Resize": 1, "Concat": 1}
    assert count_parameters(model) == (4 * 3 * 9 + 4) + (4 * 4 + 4)
    assert output_shapes(model) == [[8, 6, 8]]


def test_the_runtime_gives_the_shapes_that_were_computed() -> None:
    runtime = pytest.importorskip("onnxruntime")
    session = runtime.InferenceSession(build_network(TINY).SerializeToString(), providers=["CPUExecutionProvider"])
    (out,) = session.run(None, {"image": np.zeros((2, 3, 6, 8), np.float32)})
    assert out.shape == (2, 8, 6, 8)


def test_the_same_seed_gives_the_same_weights() -> None:
    assert build_network(TINY, seed=1) == build_network(TINY, seed=1)
    assert build_network(TINY, seed=1) != build_network(TINY, seed=2)


def test_resnet18_is_torchvisions() -> None:
    model = build_network(resnet18_cfg(256))
    onnx.checker.check_model(model, full_check=True)
    batch_norms = 4800  # torchvision counts a scale beside each shift; ours are folded into the weights
    assert count_parameters(model) == 11_689_512 - batch_norms
    assert ops(model) == {"Conv": 21, "Relu": 17, "MaxPool": 1, "Add": 8, "GlobalAveragePool": 1}
    assert output_shapes(model) == [[1000, 1, 1]]


def test_yolov3_is_the_known_one(shared_data: Path) -> None:
    model = load_network(shared_data / "yolo-cfg" / "yolov3.cfg", side=416)
    assert output_shapes(model) == [[255, 13, 13], [255, 26, 26], [255, 52, 52]]
    assert ops(model) == {"Conv": 75, "LeakyRelu": 72, "Add": 23, "Resize": 2, "Concat": 2}
    assert count_parameters(model) / 1e6 == pytest.approx(61.9, abs=0.05)


@pytest.mark.parametrize(("name", "filters"), [("yolov2-tiny", 425), ("yolov2-tiny-voc", 125)])
def test_tiny_yolov2_is_the_known_one(shared_data: Path, name: str, filters: int) -> None:
    model = load_network(shared_data / "yolo-cfg" / f"{name}.cfg")
    assert output_shapes(model) == [[filters, 13, 13]]
    assert ops(model) == {"Conv": 9, "LeakyRelu": 8, "MaxPool": 6}


@pytest.mark.parametrize(
    ("cfg", "message"),
    [
        ("[net]\n[lstm]", r"got \[lstm\]"),
        ("[convolutional]", r"expected \[net\] first, got convolutional"),
        ("[net]\n[convolutional]\nactivation=mish", "got activation=mish"),
        ("[net]\n[route]\nlayers=-1", "expected an earlier layer, got -1"),
        ("[net]\nwidth", "line 2: expected a .section. or key=value"),
    ],
)
def test_what_is_not_known_is_refused_by_name(cfg: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        build_network(cfg)


def test_a_section_that_repeats_stays_apart() -> None:
    assert [section.kind for section in parse("[net]\n[maxpool]\nsize=2\n[maxpool]\nsize=3")] == [
        "net",
        "maxpool",
        "maxpool",
    ]
