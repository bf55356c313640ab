# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
import sys
from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from edgefusion.errors import RefusedError
from edgefusion.perception.network import Network, RuntimeOptions
from make_onnx import tiny_network

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "models"))
from onnx_surgery import body_of, with_head

sys.path.pop(0)


def run(model, inputs):
    return Network(model.SerializeToString(), "a test", RuntimeOptions(provider="cpu")).run(inputs)


def network(nodes, weights, *, opset=13, ir_version=7, weights_are_inputs=False):
    """A convolution to 4 features, "f" [n, 4, height, width], and what comes behind it."""
    rng = np.random.default_rng(5)
    weights = {"conv": rng.normal(0, 1, (4, 3, 3, 3)).astype(np.float32), **weights}
    inputs = [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n", 3, "h", "w"])]
    if weights_are_inputs:
        inputs += [helper.make_tensor_value_info(name, TensorProto.FLOAT, w.shape) for name, w in weights.items()]
    graph = helper.make_graph(
        [helper.make_node("Conv", ["x", "conv"], ["c"]), helper.make_node("Relu", ["c"], ["f"]), *nodes],
        "base",
        inputs,
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, ["n", "k"])],
        [numpy_helper.from_array(value, name) for name, value in weights.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)], ir_version=ir_version)
    return onnx.shape_inference.infer_shapes(model)


def node(operator, inputs, output, **attributes):
    return helper.make_node(operator, inputs.split(), [output], **attributes)


RNG = np.random.default_rng(6)
WEIGHTS, BIAS = RNG.normal(0, 1, (4, 3)).astype(np.float32), RNG.normal(0, 1, 3).astype(np.float32)
POOLED = [node("GlobalAveragePool", "f", "p"), node("Flatten", "p", "v")]
GEMM = [*POOLED, node("Gemm", "v w b", "y")]
AS_CONV = {"w": np.ascontiguousarray(WEIGHTS.T)[:, :, None, None], "b": BIAS}
PLAIN = {"w": WEIGHTS, "b": BIAS}
NETWORKS = {
    "Gemm": (GEMM, PLAIN),
    "Gemm transposed": ([*POOLED, node("Gemm", "v w b", "y", transB=1)], {**PLAIN, "w": WEIGHTS.T.copy()}),
    "MatMul and Add": ([*POOLED, node("MatMul", "v w", "m"), node("Add", "b m", "y")], PLAIN),
    "Gemm and Dropout": ([*POOLED, node("Gemm", "v w b", "g"), node("Dropout", "g", "y")], PLAIN),
    "Conv and pooling": (
        [node("Conv", "f w b", "g"), node("GlobalAveragePool", "g", "q"), node("Flatten", "q", "y")],
        AS_CONV,
    ),
    "Conv behind pooling": (
        [node("GlobalAveragePool", "f", "p"), node("Conv", "p w b", "g"), node("Flatten", "g", "y")],
        AS_CONV,
    ),
    "a size that is computed": (
        [
            node("Conv", "f w b", "g"),
            node("GlobalAveragePool", "g", "q"),
            node("Shape", "q", "s"),
            node("Gather", "s zero", "n"),
            node("Concat", "n rest", "shape", axis=0),
            node("Reshape", "q shape", "y"),
        ],
        {**AS_CONV, "zero": np.zeros(1, np.int64), "rest": np.full(1, -1)},
    ),
    "float16 inside": (
        [
            node("Cast", "f", "fh", to=TensorProto.FLOAT16),
            node("GlobalAveragePool", "fh", "p"),
            node("Flatten", "p", "v"),
            node("Gemm", "v w b", "g"),
            node("Cast", "g", "y", to=TensorProto.FLOAT),
        ],
        {"w": WEIGHTS.astype(np.float16), "b": BIAS.astype(np.float16)},
    ),
}


X = np.random.default_rng(7).normal(0, 1, (3, 3, 9, 7)).astype(np.float32)


@pytest.mark.parametrize("kind", NETWORKS)
def test_with_its_own_last_layer_put_back_a_network_answers_as_before(kind):
    base = network(*NETWORKS[kind])
    model = with_head(body_of(base.SerializeToString(), "y", "base"), WEIGHTS, BIAS, "y", "base")
    tolerance = 5e-3 if "float16" in kind else 1e-5
    np.testing.assert_allclose(run(model, X), run(base, X), atol=tolerance)


def test_a_softmax_behind_the_last_layer_goes_with_it():
    logits = run(network(*NETWORKS["Gemm"]), X)
    base = network([*POOLED, node("Gemm", "v w b", "g"), node("Softmax", "g", "y", axis=1)], PLAIN)
    model = with_head(body_of(base.SerializeToString(), "y", "base"), WEIGHTS, BIAS, "y", "base")
    np.testing.assert_allclose(run(model, X), logits, atol=1e-6)


def test_a_base_of_the_time_when_weights_were_inputs_is_cut_too():
    base = network(GEMM, PLAIN, opset=9, ir_version=3, weights_are_inputs=True)
    model = with_head(body_of(base.SerializeToString(), "y", "base"), WEIGHTS, BIAS, "y", "base")
    assert (model.ir_version, model.opset_import[0].version) == (4, 9)
    np.testing.assert_allclose(run(model, X), run(base, X), atol=1e-6)


@pytest.mark.parametrize(
    ("nodes", "came"),
    [
        ([node("GlobalAveragePool", "f", "p"), node("Flatten", "p", "y")], "got Conv (c)"),
        ([*POOLED, node("Gemm", "v w b", "g"), node("Add", "g g", "y")], "got Add (y)"),
        ([*POOLED, node("Gemm", "v w b", "g"), node("Tanh", "g", "y")], "got Tanh (y)"),
        ([*POOLED, node("Transpose", "v", "t"), node("MatMul", "v t", "y")], "got MatMul (y)"),
        ([node("Flatten", "x", "y")], "got none"),
    ],
)
def test_a_base_without_a_last_layer_is_refused_with_what_was_looked_for(nodes, came):
    base = network(nodes, PLAIN)
    with pytest.raises(RefusedError) as caught:
        body_of(base.SerializeToString(), "y", "base")
    assert "base: expected a last layer of Gemm, MatMul or Conv 1x1" in str(caught.value)
    assert came in str(caught.value)


@pytest.mark.parametrize("versions", [{"opset": 17}, {"ir_version": 9}, {"opset": 6}])
def test_a_base_that_the_jetsons_runtime_does_not_read_is_refused(versions):
    base = tiny_network(**versions)
    with pytest.raises(RefusedError, match="expected opset 7 to 16 and IR version 8 at most, got"):
        body_of(base.SerializeToString(), "y", "base")
