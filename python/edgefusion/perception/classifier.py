# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Names the boxes of an image: one batch through ONNX Runtime for all of them."""

import logging
from pathlib import Path
from typing import Optional, Sequence

import msgspec
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.perception.golden import Golden, golden_picture
from edgefusion.perception.model_folder import Boxes as CandidateBoxes
from edgefusion.perception.model_folder import ModelFolder, kind_of, load_model_folder, read_file, read_labels
from edgefusion.perception.network import (
    Network,
    RuntimeOptions,
    as_probabilities,
    expect_distributions,
    expect_finite,
    needs_softmax,
    one_line,
)
from edgefusion.perception.preprocessing import DEFAULT, Boxes, Fit, Preprocessing, whole

log = logging.getLogger(__name__)


class Classifier:
    """Probabilities of every class for every box. For one thread at a time: the crops share one buffer.

    labels: in the order of the classes; two may be equal. preprocessing: the model's. boxes: those that it was trained
    to tell apart, None where nothing is known of that. provider and
    provider_note: what the network runs on, and why that is not what was wished for ("" where it is).
    golden_difference: the largest difference to the golden answer, None where there is none.

    When a GPU fails while running, the CPU takes over for good, after a golden check of its own: a warning
    and provider_note say so. With `require` it raises RuntimeError instead. A network that was exported for a
    fixed batch runs once per that many boxes, which takes as much longer.
    """

    def __init__(
        self,
        model: bytes,
        source: str,
        labels: Sequence[str],
        preprocessing: Optional[Preprocessing] = None,
        *,
        softmax: Optional[bool] = None,
        golden: Optional[Golden] = None,
        boxes: Optional[CandidateBoxes] = None,
        input_name: Optional[str] = None,
        output_name: Optional[str] = None,
        options: Optional[RuntimeOptions] = None,
    ) -> None:
        """source: what to call the model in a refusal. softmax: None = found out. Raises RefusedError.

        preprocessing: None = DEFAULT, at the size that the network is fixed to if it is to one.
        """
        self.labels, self.boxes = tuple(labels), boxes
        self.golden_difference: Optional[float] = None
        self._model, self._source = model, source
        self._names = (input_name, output_name)
        self._softmax, self._golden = softmax, golden
        self._options = options or RuntimeOptions()
        self._network = Network(model, source, self._options, *self._names)
        size = self._network.size or DEFAULT.size
        self.preprocessing = preprocessing or msgspec.structs.replace(DEFAULT, size=size)
        self._network.expect_size(self.preprocessing.size)
        self._buffer = np.empty((0, 3, self.preprocessing.size, self.preprocessing.size), np.float32)
        self.provider, self.provider_note = self._network.provider, self._network.provider_note
        self._check_first()

    def crop(self, image: npt.NDArray[np.uint8], boxes: Boxes) -> npt.NDArray[np.float32]:
        """The batch float32[n, 3, size, size] of boxes [n, 4] of a BGR image; valid until the next call.

        Raises ValueError for a box that is empty or not inside the image.
        """
        count = len(boxes)
        if count > len(self._buffer):
            self._buffer = np.empty((count, *self._buffer.shape[1:]), np.float32)
        return self.preprocessing.apply(image, boxes, self._buffer[:count])

    def infer(self, batch: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Probabilities float32[n, classes] of a batch [n, 3, size, size].

        A row of which any number is not finite is all NaN: that box has no vote, the others keep theirs.
        Raises ValueError for a batch of another shape, RuntimeError where the device failed for good.
        """
        expected = self._buffer.shape[1:]
        if batch.dtype != np.float32 or batch.shape[1:] != expected:
            came = f"{batch.dtype} {list(batch.shape)}"
            raise ValueError(f"batch: expected float32 [n, {', '.join(map(str, expected))}], got {came}")
        if len(batch) == 0:
            return np.zeros((0, len(self.labels)), np.float32)
        return as_probabilities(self._run(batch), bool(self._softmax))

    def probabilities(self, image: npt.NDArray[np.uint8], boxes: Boxes) -> npt.NDArray[np.float32]:
        """Probabilities float32[n, classes] of boxes [n, 4] of a BGR image. Raises as the two do."""
        return self.infer(self.crop(image, boxes))

    def _check_first(self) -> None:
        """A network that fails at once is refused; one that fails later raises RuntimeError."""
        try:
            self._check()
        except RuntimeError as error:
            size, came = self.preprocessing.size, one_line(error.__cause__ or error)
            expected = f"expected a network that runs at {size} x {size}"
            raise RefusedError(f"{self._source} on {self.provider}: {expected}, got: {came}") from error

    def _check(self) -> None:
        """The first run of a session: the golden answer, or at least as many outputs as labels."""
        picture = self._golden.picture if self._golden else golden_picture(0, self.preprocessing.size)
        outputs = self._run(self.crop(picture, whole(picture)))
        source = f"{self._source} on {self.provider}"
        self._network.expect_classes(len(self.labels), outputs)
        expect_finite(outputs, source)
        if self._softmax is None:
            self._softmax = needs_softmax(outputs)
        if not self._softmax:
            expect_distributions(outputs, source)
        if self._golden is None:
            return
        try:
            self.golden_difference = self._golden.compare(as_probabilities(outputs, self._softmax)[0], self.labels)
        except ValueError as error:
            raise RefusedError(f"{source}: {error}") from error

    def _run(self, batch: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        try:
            return self._network.run(batch)
        except Exception as error:
            if self.provider == "cpu" or self._options.require:
                raise RuntimeError(f"{self._source}: {self.provider} failed: {one_line(error)}") from error
            self._fall_back(error)
        return self._run(batch)

    def _fall_back(self, error: Exception) -> None:
        """Goes on with the CPU."""
        note = f"{self.provider} failed, cpu has taken over: {one_line(error)}"
        log.warning("%s: %s", self._source, note)
        options = msgspec.structs.replace(self._options, provider="cpu")
        self._network = Network(self._model, self._source, options, *self._names)
        self.provider, self.provider_note = self._network.provider, note
        # The check crops too, and the boxes that are waiting lie in the buffer.
        waiting, self._buffer = self._buffer, self._buffer[:0]
        self._check()
        self._buffer = waiting


def open_classifier(
    path: Path, labels: Optional[Path] = None, options: Optional[RuntimeOptions] = None, fit: Optional[Fit] = None
) -> Classifier:
    """A classifier from a model folder, or from a bare .onnx file and its labels. Raises RefusedError.

    fit: another than the model folder's own, to compare; its golden answer, which goes through the fit, is not checked
    then.

    Nothing vouches for a bare file, which a warning says; its preprocessing is DEFAULT, at the size that
    the network is fixed to if it is to one.
    """
    kind = kind_of(path)
    if kind == "nothing":
        raise RefusedError(f"{path}: expected a model folder or an ONNX file, got nothing")
    if kind == "a file":
        return _from_file(path, labels, options)
    if labels is not None:
        raise RefusedError(f"{labels}: expected no labels beside a model folder, which has its own, got some")
    return _from_folder(load_model_folder(path), options, fit)


def _from_folder(folder: ModelFolder, options: Optional[RuntimeOptions], fit: Optional[Fit]) -> Classifier:
    manifest = folder.manifest
    own = fit is None or fit == manifest.input.fit
    return Classifier(
        folder.model,
        str(folder.path),
        folder.labels,
        manifest.input if own else msgspec.structs.replace(manifest.input, fit=fit, crop_fraction=1.0),
        softmax=manifest.output.softmax,
        golden=folder.golden if own else None,
        boxes=manifest.boxes,
        input_name=manifest.input.name,
        output_name=manifest.output.name,
        options=options,
    )


def _from_file(path: Path, labels: Optional[Path], options: Optional[RuntimeOptions]) -> Classifier:
    if labels is None:
        raise RefusedError(f"{path}: expected a file of labels for a bare model, got none")
    log.warning("%s: nothing vouches for a bare model; `edgefusion model add` makes a model folder of it", path)
    return Classifier(read_file(path), str(path), read_labels(labels), options=options)
