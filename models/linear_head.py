# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A linear classifier on the features of a frozen network: multinomial logistic regression, held back by L2."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import confusion_matrix
from sklearn.model_selection import GridSearchCV, StratifiedKFold, StratifiedShuffleSplit
from threadpoolctl import threadpool_limits

from edgefusion.errors import RefusedError

Features = npt.NDArray[np.float32]
Indices = npt.NDArray[np.intp]

HELD_OUT = 0.2
FOLDS = 5
STRENGTHS = (0.001, 0.01, 0.1, 1.0, 10.0, 100.0)
"""Inverse strengths of the L2 term, as scikit-learn counts them, for features of unit variance."""

_ITERATIONS = 10_000


@dataclass(frozen=True)
class Head:
    """weights: float32[features, classes]. bias: float32[classes]."""

    weights: npt.NDArray[np.float32]
    bias: npt.NDArray[np.float32]

    def logits(self, features: Features) -> npt.NDArray[np.float32]:
        """float32[n, classes] of features [n, features]; their mean over the classes is 0."""
        return features @ self.weights + self.bias


@dataclass(frozen=True)
class HeldOut:
    """How a head did on images that it was not fitted to. confusion: int[truth, said]. strength: the chosen one."""

    confusion: Indices
    strength: float

    @property
    def accuracy(self) -> float:
        """The share that was named right."""
        return float(np.trace(self.confusion) / self.confusion.sum())


def hold_out(features: Features, classes: Indices, seed: int) -> HeldOut:
    """Holds a fifth of every class out, and asks a head that was fitted to the rest, and chosen by it.

    classes: of five images each at least. Raises RefusedError for features that are all the same.
    """
    splitter = StratifiedShuffleSplit(1, test_size=HELD_OUT, random_state=seed)
    ((fitted, asked),) = splitter.split(classes, classes)
    strength = choose_strength(features[fitted], classes[fitted], seed)
    said = fit_head(features[fitted], classes[fitted], strength).logits(features[asked]).argmax(axis=1)
    everything = np.arange(classes.max() + 1)
    return HeldOut(confusion_matrix(classes[asked], said, labels=everything), strength)


def choose_strength(features: Features, classes: Indices, seed: int) -> float:
    """The strength with the best probabilities (log loss) under cross-validation, the strongest of equals."""
    folds = StratifiedKFold(min(FOLDS, int(np.bincount(classes).min())), shuffle=True, random_state=seed)
    search = GridSearchCV(
        LogisticRegression(max_iter=_ITERATIONS), {"C": STRENGTHS}, scoring="neg_log_loss", cv=folds, refit=False
    )
    mean, scale = _scaling(features)
    with _one_thread():
        search.fit((features - mean) / scale, classes)
    return float(search.best_params_["C"])


def fit_head(features: Features, classes: Indices, strength: float) -> Head:
    """features: [n, features]. classes: [n], each of 0..classes - 1 at least once. Raises as `hold_out` does."""
    mean, scale = _scaling(features)
    model = LogisticRegression(C=strength, max_iter=_ITERATIONS)
    with _one_thread():
        model.fit((features - mean) / scale, classes)
    coefficients, intercept = model.coef_, model.intercept_
    if len(coefficients) == 1:  # two classes: the sigmoid of z is the softmax of -z/2 and z/2
        coefficients, intercept = (np.concatenate([-each, each]) / 2 for each in (coefficients, intercept))
    weights = coefficients.T / scale
    return Head(weights.astype(np.float32), (intercept - mean @ weights).astype(np.float32))


def _one_thread() -> threadpool_limits:
    """The products are small: more threads wait for each other, ten times as long beside other processes."""
    return threadpool_limits(limits=1)


def _scaling(features: Features) -> tuple[npt.NDArray[np.float64], float]:
    """One scale for all features: those that hardly ever respond are not blown up."""
    mean = features.mean(axis=0, dtype=np.float64)
    scale = float((features - mean).std())
    if scale == 0:
        raise RefusedError("base: expected features that differ from image to image, got the same of all")
    return mean, scale
