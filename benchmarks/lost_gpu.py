# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""An ONNX Runtime whose GPU, which really is the CPU, is not there or fails at a run: for machines without one."""

from __future__ import annotations

from contextlib import contextmanager
from typing import Any, Iterator, List

from edgefusion.perception import network

_CPU, _CUDA = "CPUExecutionProvider", "CUDAExecutionProvider"


class LostGpu:
    """starts: whether a session can be opened on it. runs: how many it does before it fails; may be set at any time.

    failures: how often it was asked since it is lost.
    """

    def __init__(self, real: Any, starts: bool, runs: int) -> None:
        self._real, self.starts, self.runs, self.failures = real, starts, runs, 0
        self.SessionOptions, self.__version__ = real.SessionOptions, real.__version__

    def get_available_providers(self) -> List[str]:
        """As of a runtime that was built for CUDA."""
        return [_CUDA, _CPU]

    def InferenceSession(self, model: bytes, settings: Any, providers: List[str], **_: Any) -> Any:
        """On the CPU, whatever it says. Raises RuntimeError as ONNX Runtime does where CUDA finds nothing."""
        if providers[0] == _CUDA and not self.starts:
            self.failures += 1
            raise RuntimeError("CUDA failure 100: no CUDA-capable device is detected")
        session = self._real.InferenceSession(model, settings, providers=[_CPU])
        return _OnGpu(self, session) if providers[0] == _CUDA else session

    def spend(self) -> None:
        """One run. Raises RuntimeError when there is none left."""
        self.runs -= 1
        if self.runs < 0:
            self.failures += 1
            raise RuntimeError("CUDA failure 719: unspecified launch failure")


class _OnGpu:
    def __init__(self, gpu: LostGpu, session: Any) -> None:
        self._gpu, self._session = gpu, session
        self.get_inputs, self.get_outputs = session.get_inputs, session.get_outputs
        self.disable_fallback = session.disable_fallback

    def get_providers(self) -> List[str]:
        return [_CUDA, _CPU]

    def run(self, names: List[str], inputs: Any) -> Any:
        self._gpu.spend()
        return self._session.run(names, inputs)


@contextmanager
def lost_gpu(starts: bool = True, runs: int = 10**9) -> Iterator[LostGpu]:
    """While it lasts, networks find this runtime."""
    usual = network.import_onnxruntime
    gpu = LostGpu(usual(), starts, runs)
    network.import_onnxruntime = lambda: gpu
    try:
        yield gpu
    finally:
        network.import_onnxruntime = usual
