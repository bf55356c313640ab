# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What an ONNX file says about itself, read without the package onnx: that one is not on the robot.

Only the handful of protobuf fields that a refusal or a tolerance depends on; numbers as in onnx.proto.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Literal

Precision = Literal["fp32", "fp16", "int8"]

_MODEL_IR_VERSION, _MODEL_GRAPH, _MODEL_OPSET = 1, 7, 8
_OPSET_DOMAIN, _OPSET_VERSION = 1, 2
_GRAPH_NODE, _GRAPH_INITIALIZER = 1, 5
_NODE_OP_TYPE = 4
_TENSOR_DATA_TYPE, _TENSOR_DATA_LOCATION = 2, 14
_FLOAT16, _EXTERNAL = 10, 1
_QUANTIZED = ("Quantize", "Dequantize", "DynamicQuantize", "QLinear", "ConvInteger", "MatMulInteger")


@dataclass(frozen=True)
class OnnxHeader:
    """ir_version; opset: of the default domain, 0 = none. external: weights lie in another file."""

    ir_version: int
    opset: int
    precision: Precision
    external: bool


def read_onnx_header(model: bytes) -> OnnxHeader:
    """Raises ValueError for bytes that are no ONNX model, or end too early."""
    ir_version, opset, graph = 0, 0, None
    for number, value in _fields(memoryview(model)):
        if number == _MODEL_IR_VERSION and isinstance(value, int):
            ir_version = value
        elif number == _MODEL_OPSET and isinstance(value, memoryview):
            opset = _default_opset(value) or opset
        elif number == _MODEL_GRAPH and isinstance(value, memoryview):
            graph = value
    if graph is None:
        raise ValueError("it holds no graph")
    operators, types, external = _graph(graph)
    return OnnxHeader(ir_version, opset, _precision(operators, types), external)


def _precision(operators: set[str], types: set[int]) -> Precision:
    if any(operator.startswith(_QUANTIZED) for operator in operators):
        return "int8"
    return "fp16" if _FLOAT16 in types else "fp32"


def _graph(graph: memoryview) -> tuple[set[str], set[int], bool]:
    """Its operators, the data types of its weights, and whether some of them lie in another file."""
    operators: set[str] = set()
    types: set[int] = set()
    external = False
    for number, value in _fields(graph):
        if not isinstance(value, memoryview):
            continue
        if number == _GRAPH_NODE:
            named = [v for n, v in _fields(value) if n == _NODE_OP_TYPE and isinstance(v, memoryview)]
            operators.update(bytes(name).decode() for name in named)
        elif number == _GRAPH_INITIALIZER:
            tensor = [(n, v) for n, v in _fields(value) if isinstance(v, int)]
            types.update(v for n, v in tensor if n == _TENSOR_DATA_TYPE)
            external = external or (_TENSOR_DATA_LOCATION, _EXTERNAL) in tensor
    return operators, types, external


def _default_opset(entry: memoryview) -> int:
    """The version of an opset import, 0 for one of another domain."""
    domain, version = b"", 0
    for number, value in _fields(entry):
        if number == _OPSET_DOMAIN and isinstance(value, memoryview):
            domain = bytes(value)
        elif number == _OPSET_VERSION and isinstance(value, int):
            version = value
    return version if domain in (b"", b"ai.onnx") else 0


def _fields(message: memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """Number and value of every field of a protobuf message; fixed-width ones as their bytes."""
    at = 0
    while at < len(message):
        key, at = _varint(message, at)
        kind = key & 7
        if kind == 0:
            value, at = _varint(message, at)
            yield key >> 3, value
            continue
        if kind == 2:
            size, at = _varint(message, at)
        elif kind in (1, 5):
            size = 8 if kind == 1 else 4
        else:
            raise ValueError(f"byte {at} is no protobuf")
        if at + size > len(message):
            raise ValueError(f"it ends {at + size - len(message)} bytes too early")
        yield key >> 3, message[at : at + size]
        at += size


def _varint(message: memoryview, at: int) -> tuple[int, int]:
    """A number and the offset behind it."""
    value = 0
    for shift in range(0, 70, 7):
        if at >= len(message):
            raise ValueError("it ends inside a number")
        value |= (message[at] & 0x7F) << shift
        at += 1
        if message[at - 1] < 0x80:
            return value, at
    raise ValueError(f"byte {at} is no protobuf")
