# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Takes the last layer off a classifier's ONNX graph and puts another one on what is left."""

from __future__ import annotations

from typing import Any, Iterator, Sequence

import numpy as np
import numpy.typing as npt
import onnx
from onnx import TensorProto, helper, numpy_helper

from edgefusion.errors import RefusedError
from edgefusion.perception.network import one_line

# From the first opset whose Gemm broadcasts its bias to the last one that ONNX Runtime 1.11 reads, and up to its IR
# version. Before IR version 4, every weight had to be an input, too.
OPSETS, NEWEST_IR, WEIGHTS_ALONE_IR = range(7, 17), 8, 4

BEHIND_THE_LAYER = frozenset(
    [
        "Add",
        "AveragePool",
        "Cast",
        "Clip",
        "DequantizeLinear",
        "Dropout",
        "Flatten",
        "GlobalAveragePool",
        "Identity",
        "LogSoftmax",
        "QuantizeLinear",
        "ReduceMean",
        "Relu",
        "Reshape",
        "Sigmoid",
        "Softmax",
        "Squeeze",
    ]
)
"""Operators that may stand between the last layer and the output."""

LAYERS = "a last layer of Gemm, MatMul or Conv 1x1, with only pooling, activations and reshaping behind it"


def body_of(base: bytes, output: str, source: str) -> onnx.ModelProto:
    """The network without its last layer and all behind it: float32[n, 3, height, width] -> [n, features].

    A last layer that is a convolution reads a feature map, of which the mean is taken. output: the name of the base's
    output. source: what to call it in a refusal. Raises RefusedError where no last layer is found.
    """
    model = onnx.load_model_from_string(base)
    _expect_versions(model, source)
    layer = _last_layer(model.graph, output, source)
    features = layer.input[0]
    is_half = _is_half(model, features)
    _keep_up_to(model, features)
    nodes: list[onnx.NodeProto] = []
    if is_half:
        nodes.append(helper.make_node("Cast", [features], [f"{output}/float"], to=TensorProto.FLOAT))
    if layer.op_type == "Conv":
        nodes.append(helper.make_node("GlobalAveragePool", [_end(nodes, features)], [f"{output}/pooled"]))
        nodes.append(helper.make_node("Flatten", [f"{output}/pooled"], [f"{output}/features"]))
    model.graph.node.extend(nodes)
    _set_output(model.graph, _end(nodes, features), None)
    return _checked(model, source)


def with_head(
    body: onnx.ModelProto, weights: npt.NDArray[np.float32], bias: npt.NDArray[np.float32], output: str, source: str
) -> onnx.ModelProto:
    """The body with a linear layer behind its features: float32[n, 3, height, width] -> logits [n, classes].

    weights: [features, classes]. bias: [classes]. output: what to call the logits; the body has no such tensor.
    """
    model = onnx.ModelProto()
    model.CopyFrom(body)
    names = [model.graph.output[0].name, f"{output}/weights", f"{output}/bias"]
    model.graph.node.append(helper.make_node("Gemm", names, [output]))
    model.graph.initializer.append(numpy_helper.from_array(weights, names[1]))
    model.graph.initializer.append(numpy_helper.from_array(bias, names[2]))
    _set_output(model.graph, output, len(bias))
    return _checked(model, source)


def _expect_versions(model: onnx.ModelProto, source: str) -> None:
    """Also lifts the IR version of old ones to the first that permits weights that are no inputs."""
    opset = max((each.version for each in model.opset_import if each.domain in ("", "ai.onnx")), default=0)
    if opset not in OPSETS or model.ir_version > NEWEST_IR:
        expected = f"expected opset {OPSETS[0]} to {OPSETS[-1]} and IR version {NEWEST_IR} at most"
        raise RefusedError(f"{source}: {expected}, got {opset} and {model.ir_version}")
    model.ir_version = max(model.ir_version, WEIGHTS_ALONE_IR)


def _last_layer(graph: onnx.GraphProto, output: str, source: str) -> onnx.NodeProto:
    """Walks back from the output, along what depends on the image."""
    makers = {name: node for node in graph.node for name in node.output}
    varying = _varying(graph)
    tensor = output
    while tensor in makers:
        node = makers[tensor]
        if _is_linear(node, graph) and [name for name in node.input if name in varying] == [node.input[0]]:
            return node
        # A residual's Add has two; a Reshape's second one may be a size that was computed.
        sources = [name for name in node.input if name in varying]
        if node.op_type not in BEHIND_THE_LAYER or (node.op_type == "Add" and len(sources) > 1):
            raise RefusedError(f"{source}: expected {LAYERS}, got {node.op_type} ({node.output[0]})")
        tensor = sources[0] if sources else ""
    raise RefusedError(f"{source}: expected {LAYERS}, got none")


def _varying(graph: onnx.GraphProto) -> set[str]:
    """The tensors that depend on the image; the graph's nodes are in the order in which they run."""
    varying = {each.name for each in graph.input} - {each.name for each in graph.initializer}
    for node in graph.node:
        if varying.intersection(_reads(node)):
            varying.update(node.output)
    return varying


def _is_linear(node: onnx.NodeProto, graph: onnx.GraphProto) -> bool:
    if node.op_type == "Conv":
        attributes = {each.name: helper.get_attribute_value(each) for each in node.attribute}
        kernel = attributes.get("kernel_shape") or _sides(node.input[1], graph)
        return attributes.get("group", 1) == 1 and list(kernel) == [1, 1]
    transposed = any(each.name == "transA" and each.i for each in node.attribute)
    return node.op_type in ("Gemm", "MatMul") and not transposed


def _sides(weights: str, graph: onnx.GraphProto) -> Sequence[int]:
    return next((each.dims[2:] for each in graph.initializer if each.name == weights), ())


def _is_half(model: onnx.ModelProto, tensor: str) -> bool:
    inferred = onnx.shape_inference.infer_shapes(model).graph.value_info
    return any(each.name == tensor and each.type.tensor_type.elem_type == TensorProto.FLOAT16 for each in inferred)


def _keep_up_to(model: onnx.ModelProto, tensor: str) -> None:
    """Removes all that the tensor does not need."""
    graph, needed, kept = model.graph, {tensor}, []
    for node in reversed(graph.node):
        if needed.intersection(node.output):
            needed.update(node.output, _reads(node))
            kept.append(node)
    _replace(graph.node, kept[::-1])
    _replace(graph.initializer, [each for each in graph.initializer if each.name in needed])
    # The tensor itself becomes an output, and must not be declared twice.
    _replace(graph.value_info, [each for each in graph.value_info if each.name in needed and each.name != tensor])
    _replace(graph.quantization_annotation, [q for q in graph.quantization_annotation if q.tensor_name in needed])
    weights = {each.name for each in graph.initializer}
    _replace(graph.input, [each for each in graph.input if each.name in needed - weights])


def _reads(node: onnx.NodeProto) -> Iterator[str]:
    """What a node reads, also inside its branches and loops."""
    yield from node.input
    for attribute in node.attribute:
        for graph in [*attribute.graphs, *([attribute.g] if attribute.HasField("g") else [])]:
            for inner in graph.node:
                yield from _reads(inner)


def _end(nodes: Sequence[onnx.NodeProto], start: str) -> str:
    return str(nodes[-1].output[0]) if nodes else start


def _set_output(graph: onnx.GraphProto, name: str, size: int | None) -> None:
    """One output float32[n, size], n named or fixed as the input's."""
    value = helper.make_tensor_value_info(name, TensorProto.FLOAT, [None, size])
    value.type.tensor_type.shape.dim[0].CopyFrom(graph.input[0].type.tensor_type.shape.dim[0])
    _replace(graph.output, [value])


def _replace(field: Any, values: Sequence[Any]) -> None:
    """Of a repeated protobuf field; the values may be its own."""
    copies = list(values)
    del field[:]
    field.extend(copies)


def _checked(model: onnx.ModelProto, source: str) -> onnx.ModelProto:
    try:
        onnx.checker.check_model(model)
    except onnx.checker.ValidationError as error:
        raise RefusedError(f"{source}: expected a graph that can be cut, got: {one_line(error)[:300]}") from error
    return model
