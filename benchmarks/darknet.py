# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Networks of random weights from darknet's layer lists: as costly as the trained ones, which is all that timing needs.

Batch normalization is folded into the convolutions, as every exporter for inference does. The outputs are the
inputs of the [yolo] and [region] sections: the decoding of boxes is left out, which favours the peers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Mapping, NamedTuple, Sequence

import numpy as np
from onnx import TensorProto, helper, numpy_helper

OPSET, IR_VERSION = 13, 7
"""What ONNX Runtime 1.11, the last one for the Jetson TX2, reads."""


@dataclass(frozen=True)
class Section:
    """One [section] of a layer list."""

    kind: str
    options: Mapping[str, str]

    def number(self, key: str, default: int) -> int:
        return int(self.options.get(key, default))

    def numbers(self, key: str) -> list[int]:
        return [int(number) for number in self.options[key].split(",")]


class Tensor(NamedTuple):
    """A layer's output, without the batch."""

    name: str
    channels: int
    height: int
    width: int


def load_network(path: Path, side: int | None = None) -> Any:
    """The ONNX model (ModelProto) of a darknet .cfg file. Raises as `build_network` does."""
    return build_network(path.read_text(encoding="utf-8"), side)


def build_network(cfg: str, side: int | None = None, seed: int = 0) -> Any:
    """The ONNX model (ModelProto) of a layer list: float32[n, channels, height, width] in.

    side: of its input, instead of the list's width and height.
    Raises ValueError for a section or an activation that is not known.
    """
    sections = parse(cfg)
    if not sections or sections[0].kind != "net":
        raise ValueError(f"darknet: expected [net] first, got {sections[0].kind if sections else 'nothing'}")
    return _Builder(sections[0], side, np.random.default_rng(seed)).build(sections[1:])


def parse(cfg: str) -> list[Section]:
    """The sections of a layer list, in order. Raises ValueError that names the line."""
    sections: list[Section] = []
    for number, line in enumerate(cfg.splitlines(), 1):
        text = line.split("#")[0].strip()
        if text.startswith("["):
            sections.append(Section(text.strip("[]"), {}))
        elif text:
            key, equals, value = text.partition("=")
            if not equals or not sections:
                raise ValueError(f"darknet: line {number}: expected a [section] or key=value, got {line!r}")
            options = dict(sections[-1].options, **{key.strip(): value.strip()})
            sections[-1] = Section(sections[-1].kind, options)
    return sections


class _Builder:
    """Grows the graph layer by layer."""

    def __init__(self, net: Section, side: int | None, random: np.random.Generator) -> None:
        self._random = random
        self._nodes: list[Any] = []
        self._weights: list[Any] = []
        width, height = side or net.number("width", 416), side or net.number("height", 416)
        self._input = Tensor("image", net.number("channels", 3), height, width)
        self._layers: list[Tensor] = []
        self._outputs: list[Tensor] = []

    def build(self, sections: Sequence[Section]) -> Any:
        for section in sections:
            self._layers.append(self._layer(section))
        graph = helper.make_graph(
            self._nodes,
            "darknet",
            [_value_info(self._input)],
            [_value_info(output) for output in self._outputs or self._layers[-1:]],
            self._weights,
        )
        opset = helper.make_opsetid("", OPSET)
        return helper.make_model(graph, opset_imports=[opset], ir_version=IR_VERSION)

    def _layer(self, section: Section) -> Tensor:
        kinds: Mapping[str, Callable[[Section, Tensor], Tensor]] = {
            "convolutional": self._convolutional,
            "maxpool": self._maxpool,
            "avgpool": self._avgpool,
            "softmax": self._softmax,
            "route": self._route,
            "shortcut": self._shortcut,
            "upsample": self._upsample,
            "yolo": self._output,
            "region": self._output,
        }
        if section.kind not in kinds:
            raise ValueError(f"darknet: section {len(self._layers)}: expected {', '.join(kinds)}, got [{section.kind}]")
        return kinds[section.kind](section, self._layers[-1] if self._layers else self._input)

    def _convolutional(self, section: Section, x: Tensor) -> Tensor:
        filters, size, stride = section.number("filters", 1), section.number("size", 1), section.number("stride", 1)
        pad = size // 2 if section.number("pad", 0) else section.number("padding", 0)
        # He's initialization: values stay in a range where no arithmetic is slow.
        spread = np.sqrt(2 / (x.channels * size * size))
        weights = self._random.standard_normal((filters, x.channels, size, size), np.float32) * np.float32(spread)
        inputs = [x.name, self._constant("weights", weights), self._constant("bias", np.zeros(filters, np.float32))]
        name = self._node("Conv", inputs, kernel_shape=[size] * 2, strides=[stride] * 2, pads=[pad] * 4)
        height, width = ((side + 2 * pad - size) // stride + 1 for side in (x.height, x.width))
        return self._activated(section, Tensor(name, filters, height, width))

    def _activated(self, section: Section, x: Tensor) -> Tensor:
        activation = section.options.get("activation", "linear")
        if activation == "linear":
            return x
        if activation == "relu":
            return x._replace(name=self._node("Relu", [x.name]))
        if activation == "leaky":
            return x._replace(name=self._node("LeakyRelu", [x.name], alpha=0.1))
        raise ValueError(
            f"darknet: section {len(self._layers)}: expected linear, relu or leaky, got activation={activation}"
        )

    def _maxpool(self, section: Section, x: Tensor) -> Tensor:
        stride = section.number("stride", 1)
        size = section.number("size", stride)
        padding = section.number("padding", size - 1)  # of both ends together, the odd one at the end
        begin, end = padding // 2, padding - padding // 2
        pads = [begin, begin, end, end]
        name = self._node("MaxPool", [x.name], kernel_shape=[size] * 2, strides=[stride] * 2, pads=pads)
        height, width = ((side + padding - size) // stride + 1 for side in (x.height, x.width))
        return Tensor(name, x.channels, height, width)

    def _avgpool(self, section: Section, x: Tensor) -> Tensor:
        return Tensor(self._node("GlobalAveragePool", [x.name]), x.channels, 1, 1)

    def _softmax(self, section: Section, x: Tensor) -> Tensor:
        return x._replace(name=self._node("Softmax", [x.name], axis=1))

    def _route(self, section: Section, x: Tensor) -> Tensor:
        parts = [self._earlier(index) for index in section.numbers("layers")]
        if len(parts) == 1:
            return parts[0]
        if len({part[2:] for part in parts}) > 1:
            raise ValueError(f"darknet: section {len(self._layers)}: route: expected one size, got {parts}")
        name = self._node("Concat", [part.name for part in parts], axis=1)
        return parts[0]._replace(name=name, channels=sum(part.channels for part in parts))

    def _shortcut(self, section: Section, x: Tensor) -> Tensor:
        other = self._earlier(section.number("from", -1))
        if other[1:] != x[1:]:
            raise ValueError(f"darknet: section {len(self._layers)}: shortcut: expected {x[1:]}, got {other[1:]}")
        return self._activated(section, x._replace(name=self._node("Add", [x.name, other.name])))

    def _upsample(self, section: Section, x: Tensor) -> Tensor:
        stride = section.number("stride", 2)
        scales = self._constant("scales", np.array([1, 1, stride, stride], np.float32))
        name = self._node(
            "Resize",
            [x.name, "", scales],
            mode="nearest",
            coordinate_transformation_mode="asymmetric",
            nearest_mode="floor",
        )
        return Tensor(name, x.channels, x.height * stride, x.width * stride)

    def _output(self, section: Section, x: Tensor) -> Tensor:
        self._outputs.append(x)
        return x

    def _earlier(self, index: int) -> Tensor:
        """A layer by its number, or counted back from this one where negative."""
        number = index if index >= 0 else len(self._layers) + index
        if not 0 <= number < len(self._layers):
            raise ValueError(f"darknet: section {len(self._layers)}: expected an earlier layer, got {index}")
        return self._layers[number]

    def _node(self, kind: str, inputs: Sequence[str], **attributes: object) -> str:
        name = f"{kind}_{len(self._nodes)}"
        self._nodes.append(helper.make_node(kind, inputs, [name], name=name, **attributes))
        return name

    def _constant(self, name: str, values: np.ndarray[Any, np.dtype[np.float32]]) -> str:
        unique = f"{name}_{len(self._weights)}"
        self._weights.append(numpy_helper.from_array(values, unique))
        return unique


def _value_info(x: Tensor) -> Any:
    return helper.make_tensor_value_info(x.name, TensorProto.FLOAT, ["n", x.channels, x.height, x.width])


def count_parameters(model: Any) -> int:
    """Weights and biases of a model's convolutions."""
    learnt = {name for node in model.graph.node if node.op_type == "Conv" for name in node.input}
    return sum(math.prod(weight.dims) for weight in model.graph.initializer if weight.name in learnt)


def resnet18_cfg(size: int, classes: int = 1000) -> str:
    """torchvision's ResNet18 as a layer list: darknet's own has no projections where a block halves the size."""
    lines = [f"[net]\nwidth={size}\nheight={size}\nchannels=3", _conv(64, 7, 2, "relu"), "[maxpool]\nsize=3\nstride=2"]
    lines += [_block(64), _block(64)]
    for filters in (128, 256, 512):
        lines += [_halving_block(filters), _block(filters)]
    return "\n".join([*lines, "[avgpool]", _conv(classes, 1, 1, "linear")])


def _conv(filters: int, size: int, stride: int, activation: str) -> str:
    options = f"filters={filters}\nsize={size}\nstride={stride}\npad=1\nactivation={activation}"
    return f"[convolutional]\n{options}"


def _block(filters: int) -> str:
    add = "[shortcut]\nfrom=-3\nactivation=relu"
    return "\n".join([_conv(filters, 3, 1, "relu"), _conv(filters, 3, 1, "linear"), add])


def _halving_block(filters: int) -> str:
    project = f"[route]\nlayers=-3\n{_conv(filters, 1, 2, 'linear')}"
    add = "[shortcut]\nfrom=-3\nactivation=relu"
    return "\n".join([_conv(filters, 3, 2, "relu"), _conv(filters, 3, 1, "linear"), project, add])
