# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""torchvision, also where its compiled part does not load.

torchvision's wheel beside a CPU build of torch may be built for CUDA. Its compiled operators then do not
load, and `import torchvision` fails with "operator torchvision::nms does not exist", although no classifier
uses one of them: declaring those that the import looks for is enough.
"""

from __future__ import annotations

import sys
from typing import Any

_DETECTION_OPERATORS = (
    "nms(Tensor dets, Tensor scores, float iou_threshold) -> Tensor",
    "qnms(Tensor dets, Tensor scores, float iou_threshold) -> Tensor",
)
_declared: list[Any] = []  # a library's declarations last as long as it does


def import_torchvision() -> Any:
    """The module torchvision. Raises ImportError or RuntimeError where it cannot be had at all."""
    try:
        import torchvision
    except RuntimeError as error:
        if "torchvision::" not in str(error):
            raise
        _declare_operators()
        _forget_half_imported()
        import torchvision
    return torchvision


def _declare_operators() -> None:
    import torch

    library = torch.library.Library("torchvision", "FRAGMENT")
    for operator in _DETECTION_OPERATORS:
        library.define(operator)
    _declared.append(library)


def _forget_half_imported() -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "torchvision"]:
        del sys.modules[name]
