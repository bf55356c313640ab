# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""One network in ONNX Runtime: where it runs is chosen, checked and said, never silently changed."""

import logging
import re
from typing import Any, Dict, List, Literal, Optional, Tuple, get_args

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.perception.onnx_header import OnnxHeader, read_onnx_header

Provider = Literal["tensorrt", "cuda", "cpu"]

_NAMES: Dict[str, str] = {
    "tensorrt": "TensorrtExecutionProvider",
    "cuda": "CUDAExecutionProvider",
    "cpu": "CPUExecutionProvider",
}
"""In the order in which they are tried."""

_OPTIONS: Dict[str, Dict[str, str]] = {
    # The default, an exhaustive search, starts anew for every number of boxes: seconds on a Jetson.
    "cuda": {"cudnn_conv_algo_search": "HEURISTIC"},
}

_LIMITS = {
    "an IR version": re.compile(r"max supported IR version: (\d+)"),
    "an opset": re.compile(r"is till opset (\d+)"),
}
"""Where ONNX Runtime's refusals say what it reads."""

_SUM_TOLERANCE = 0.1
"""On the sum of probabilities: a softmax in int8 rounds every class to a 256th."""

_ROUNDING = 4e-7
"""On a single one: a few steps of float32."""

_ERRORS_ONLY = 3  # an int8 model prints 60 warnings otherwise

_MOST_THREADS = 1024

log = logging.getLogger(__name__)


class RuntimeOptions(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where and how a network runs.

    provider: the wish; what comes after it in TensorRT > CUDA > CPU stands in for it, which is said.
    require: the same without a stand-in. threads: 0 = one per core. spinning: idle threads keep a core busy;
    faster on an idle machine, slower on a robot's.
    """

    provider: Literal["auto", "tensorrt", "cuda", "cpu"] = "auto"
    require: Optional[Provider] = None
    threads: int = 0
    spinning: bool = False

    def __post_init__(self) -> None:
        if self.provider != "auto" and self.provider not in _NAMES:
            raise RefusedError(f"provider: expected auto, {', '.join(_NAMES)}, got {self.provider}")
        if self.require is not None and self.require not in get_args(Provider):
            raise RefusedError(f"require: expected {', '.join(_NAMES)}, got {self.require}")
        if self.require and self.provider not in ("auto", self.require):
            raise RefusedError(f"require: expected the same as provider, {self.provider}, got {self.require}")
        if not 0 <= self.threads <= _MOST_THREADS:
            raise RefusedError(f"threads: expected 0 to {_MOST_THREADS}, got {self.threads}")


class Network:
    """float32[n, 3, height, width] in, float32[n, classes] out, as the network gives it (no softmax).

    provider: the one in use. provider_note: why it is not the one wished for, or "". batch, size: what the
    network is fixed to, None where it takes any; one fixed to a batch runs once per that many inputs.
    classes: None where only a run can tell.
    """

    def __init__(
        self,
        model: bytes,
        source: str,
        options: Optional[RuntimeOptions] = None,
        input_name: Optional[str] = None,
        output_name: Optional[str] = None,
    ) -> None:
        """source: what to call the model in a refusal. The names may be left out where there is only one.

        Raises RefusedError for a model that cannot be read or is no classifier of images, for one that the
        installed runtime is too old for, and for a required provider that is not to be had.
        """
        self._source = source
        self.header = _header(model, source)
        self._session, self.provider, self.provider_note = _open(
            model, source, self.header, options or RuntimeOptions()
        )
        self.input_name, shape = self._input(input_name)
        self.output_name, self.classes = self._output(output_name)
        self.batch = shape[0] if isinstance(shape[0], int) else None
        self.size = shape[2] if isinstance(shape[2], int) else None

    def run(self, batch: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """The outputs float32[n, classes] of n inputs; one of n = 0 needs no run.

        Raises what ONNX Runtime raises, where the device has failed.
        """
        if len(batch) == 0:
            return np.zeros((0, self.classes or 0), np.float32)
        if self.batch is None:
            return self._run(batch)
        parts = [self._run_padded(batch[i : i + self.batch]) for i in range(0, len(batch), self.batch)]
        return np.concatenate(parts)

    def expect_size(self, size: int) -> None:
        """Raises RefusedError for a network that is fixed to inputs of another size."""
        if self.size not in (None, size):
            self._refuse(f"size = {self.size}, its input's", str(size))

    def expect_classes(self, labels: int, outputs: npt.NDArray[np.float32]) -> None:
        """Raises RefusedError where outputs [n, classes] have not one class per label."""
        if outputs.shape[1] != labels:
            self._refuse(f"a label for each of its {outputs.shape[1]} outputs", f"{labels} labels")

    def _run_padded(self, part: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """The last inputs may be fewer than the batch that the network is fixed to."""
        missing = (self.batch or 0) - len(part)
        padded = np.concatenate([part, np.zeros((missing, *part.shape[1:]), np.float32)]) if missing else part
        return self._run(padded)[: len(part)]

    def _run(self, batch: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        (out,) = self._session.run([self.output_name], {self.input_name: batch})
        return np.asarray(out, np.float32).reshape(len(batch), -1)

    def _input(self, name: Optional[str]) -> Tuple[str, List[Any]]:
        tensor = self._pick("input", self._session.get_inputs(), name)
        shape = tensor.shape
        came = f"{tensor.type} {shape}"
        if tensor.type != "tensor(float)" or len(shape) != 4 or (isinstance(shape[1], int) and shape[1] != 3):
            self._refuse(f"its input {tensor.name} to be float32 [n, 3, height, width]", came)
        if isinstance(shape[2], int) != isinstance(shape[3], int) or (
            isinstance(shape[2], int) and shape[2] != shape[3]
        ):
            self._refuse(f"its input {tensor.name} to be square", came)
        return tensor.name, shape

    def _output(self, name: Optional[str]) -> Tuple[str, Optional[int]]:
        tensor = self._pick("output", self._session.get_outputs(), name)
        shape = tensor.shape
        is_vector = len(shape) >= 2 and all(side == 1 for side in shape[2:])
        if tensor.type not in ("tensor(float)", "tensor(float16)") or not is_vector:
            self._refuse(f"its output {tensor.name} to be float [n, classes]", f"{tensor.type} {shape}")
        return tensor.name, shape[1] if isinstance(shape[1], int) else None

    def _pick(self, kind: str, tensors: List[Any], name: Optional[str]) -> Any:
        names = [tensor.name for tensor in tensors]
        if name is None and len(names) != 1:
            self._refuse(f"one {kind}, or the name of one of them", ", ".join(names))
        if name is not None and name not in names:
            self._refuse(f"an {kind} {name}", ", ".join(names))
        return tensors[0 if name is None else names.index(name)]

    def _refuse(self, expected: str, came: str) -> None:
        raise RefusedError(f"{self._source}: expected {expected}, got {came}")


def as_probabilities(outputs: npt.NDArray[np.float32], softmax: bool) -> npt.NDArray[np.float32]:
    """Outputs float32[n, classes] as probabilities; a row of which any is not finite becomes all NaN."""
    if softmax:
        with np.errstate(invalid="ignore", over="ignore"):  # inf - inf: the row becomes NaN
            powers = np.exp(outputs - outputs.max(axis=1, keepdims=True, initial=-np.inf))
            outputs = powers / powers.sum(axis=1, keepdims=True)
    return np.where(np.isfinite(outputs).all(axis=1, keepdims=True), outputs, np.float32(np.nan))


def expect_finite(outputs: npt.NDArray[np.float32], source: str) -> None:
    """Raises RefusedError for outputs of which any is not finite."""
    if not np.isfinite(outputs).all():
        raise RefusedError(f"{source}: expected finite outputs for a made-up or golden picture, got NaN or infinity")


def needs_softmax(outputs: npt.NDArray[np.float32]) -> bool:
    """False where every row float32[n, classes] already is a distribution."""
    return not _are_distributions(outputs, 1e-2)


def expect_distributions(outputs: npt.NDArray[np.float32], source: str) -> None:
    """Raises RefusedError for a row float32[n, classes] that is none, though nobody applies a softmax to it."""
    if not _are_distributions(outputs, _SUM_TOLERANCE):
        total = outputs.sum(axis=1, dtype=np.float64).max()
        came = f"{outputs.min():.4g}..{outputs.max():.4g} with a sum of {total:.4g}"
        raise RefusedError(f"{source}: expected probabilities, as softmax is off, got {came}")


def _are_distributions(outputs: npt.NDArray[np.float32], tolerance: float) -> bool:
    """NaN is none."""
    if not ((outputs >= -_ROUNDING) & (outputs <= 1 + _ROUNDING)).all():
        return False
    return bool((np.abs(outputs.sum(axis=1) - 1) <= tolerance).all())


def import_onnxruntime() -> Any:
    """The runtime, imported only where a network runs. Raises RefusedError where it is not installed."""
    try:
        import onnxruntime
    except ImportError as error:
        expected = "expected it to be installed (pip install 'edgefusion[cpu]')"
        raise RefusedError(f"onnxruntime: {expected}, got: {one_line(error)}") from error
    return onnxruntime


def _header(model: bytes, source: str) -> OnnxHeader:
    try:
        header = read_onnx_header(model)
    except ValueError as error:
        raise RefusedError(
            f"{source}: expected an ONNX model, got {len(model)} bytes that are none: {error}"
        ) from error
    if header.external:
        raise RefusedError(f"{source}: expected all weights in this one file, got some in another")
    return header


def _open(model: bytes, source: str, header: OnnxHeader, options: RuntimeOptions) -> Tuple[Any, str, str]:
    """A session, its provider, and why that is not the one wished for."""
    runtime = import_onnxruntime()
    wanted, reasons = _wanted(options, runtime.get_available_providers(), runtime.__version__)
    asked = options.require or options.provider
    wish = wanted[0] if asked == "auto" else asked
    for first, candidate in enumerate(wanted):
        try:
            session = _session(runtime, model, wanted[first:], options)
            break
        except Exception as error:
            if first + 1 == len(wanted):
                raise RefusedError(_why_refused(source, header, runtime.__version__, error)) from error
            reasons.append(("" if candidate == wish else f"{candidate}: ") + one_line(error))
    return _said_aloud(session, wish, reasons, options)


def _wanted(options: RuntimeOptions, available: List[str], version: str) -> Tuple[List[str], List[str]]:
    """The providers to try, best first, and what is missing for the one asked for."""
    order = [name for name, long_name in _NAMES.items() if long_name in available]
    asked = options.require or options.provider
    if asked == "auto":
        return order, []
    missing = [] if asked in order else [f"onnxruntime {version} here has {', '.join(order)} only"]
    if options.require:
        if missing:
            raise RefusedError(f"require: expected {asked}, got a runtime without it: {missing[0]}")
        return [asked], []
    later = list(_NAMES)[list(_NAMES).index(asked) :]
    return [name for name in order if name in later], missing


def _session(runtime: Any, model: bytes, providers: List[str], options: RuntimeOptions) -> Any:
    settings = runtime.SessionOptions()
    settings.log_severity_level = _ERRORS_ONLY
    settings.intra_op_num_threads = options.threads
    settings.add_session_config_entry("session.intra_op.allow_spinning", "1" if options.spinning else "0")
    # The CPU also takes over single operators that a GPU provider lacks.
    names = providers if "cpu" in providers else [*providers, "cpu"]
    session = runtime.InferenceSession(
        model,
        settings,
        providers=[_NAMES[name] for name in names],
        provider_options=[_OPTIONS.get(name, {}) for name in names],
        enable_fallback=0,
    )
    # Otherwise ONNX Runtime itself goes on with the CPU when a GPU fails, and only prints so.
    session.disable_fallback()
    return session


def _said_aloud(session: Any, wish: str, reasons: List[str], options: RuntimeOptions) -> Tuple[Any, str, str]:
    """The session with the provider it really got."""
    long_name = session.get_providers()[0]
    provider = next((name for name in _NAMES if _NAMES[name] == long_name), long_name)
    if provider == wish:
        return session, provider, ""
    if options.require:
        raise RefusedError(f"require: expected {options.require}, got {provider}: the runtime has said why")
    why = "; ".join(reasons) or "it could not be started"
    asked = options.provider != "auto"
    note = f"asked for {wish}, got {provider}: {why}" if asked else f"{wish} is not usable ({why}): {provider}"
    log.warning("%s", note)
    return session, provider, note


def _why_refused(source: str, header: OnnxHeader, version: str, error: Exception) -> str:
    """One line; a runtime that is too old for the model is named as such."""
    said = one_line(error)
    model = f"opset {header.opset}, IR version {header.ir_version}"
    for what, limit in _LIMITS.items():
        found = limit.search(said)
        if found:
            expected = f"{what} up to {found.group(1)}, all that onnxruntime {version} reads"
            return f"{source}: expected {expected}, got {model}"
    return f"{source}: expected a model that onnxruntime {version} can run, got one ({model}) it refuses: {said}"


def one_line(error: BaseException) -> str:
    """What an exception says, without its line breaks."""
    return " ".join(str(error).split()) or type(error).__name__
