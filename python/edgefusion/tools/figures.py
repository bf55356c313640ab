# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From single objects to the figures of a table: shares, means, percentiles."""

from __future__ import annotations

from typing import Any, Callable, Iterable, Sequence

import numpy as np

from edgefusion.tools.evaluation import Outcome
from edgefusion.tools.measure import Claim, Seen

RANGES_M = ((0.5, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 4.0), (4.0, 5.0))


def figures(seen: Sequence[Seen]) -> dict[str, Any]:
    """The figures of some objects; None where there is nothing to take them of."""
    found = [each for each in seen if each.found]
    height = _values(found, "height_error")
    width = _values(found, "width_error_px")
    distance, sigma = _values(found, "distance_error_m"), _values(found, "sigma_m")
    return {
        "objects": len(seen),
        "recall": _mean([each.found for each in seen]),
        "label_accuracy": _mean([each.named for each in found]),
        "mean_iou": _mean(_values(found, "iou")),
        "height_error_median": _percentile(np.abs(height), 50),
        "height_error_p95": _percentile(np.abs(height), 95),
        "width_error_px_median": _percentile(np.abs(width), 50),
        "width_error_px_p95": _percentile(np.abs(width), 95),
        "distance_bias_mm": _scaled(_mean(distance), 1e3),
        "distance_p95_mm": _scaled(_percentile(np.abs(distance), 95), 1e3),
        "within_2_sigma": _mean(np.abs(distance) <= 2 * sigma),
    }


def precision(claims: Sequence[Claim]) -> dict[str, Any]:
    """detections: how many; precision: the share that is an object's; named_right: of those with a name, the share
    with the right one."""
    named = [claim for claim in claims if claim.named]
    return {
        "detections": len(claims),
        "precision": _mean([claim.real for claim in claims]),
        "named": len(named),
        "named_right": _mean([claim.right for claim in named]),
    }


def summary(outcome: Outcome) -> dict[str, Any]:
    """All figures of one setting: of every object, of those that the aims are about, by kind and by range."""
    seen = outcome.seen
    free = [each for each in seen if each.free]
    return {
        "all": figures(seen),
        "free": figures(free),
        "touching": figures([each for each in seen if each.touching]),
        "precision": precision(outcome.claims),
        "by_kind": _by(free, lambda each: each.kind),
        "by_range": {
            f"{least:g}-{most:g} m": figures([each for each in free if least <= each.range_m < most])
            for least, most in RANGES_M
        },
    }


def _by(seen: Iterable[Seen], key: Callable[[Seen], str]) -> dict[str, Any]:
    groups: dict[str, list[Seen]] = {}
    for each in seen:
        groups.setdefault(key(each), []).append(each)
    return {name: figures(group) for name, group in sorted(groups.items())}


def _values(seen: Sequence[Seen], name: str) -> Any:
    return np.array([getattr(each, name) for each in seen], float)


def _mean(values: Any) -> float | None:
    return float(np.mean(values)) if len(values) else None


def _percentile(values: Any, percent: float) -> float | None:
    return float(np.percentile(values, percent)) if len(values) else None


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor
