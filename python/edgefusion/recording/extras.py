# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is installed only where somebody wants it."""

from __future__ import annotations

import importlib

from edgefusion.errors import RefusedError


def require(module: str, extra: str, what: str) -> None:
    """Raises RefusedError, with what to install, where a module that comes with one of edgefusion's extras is absent.

    what: that needs it, as the beginning of the sentence.
    """
    try:
        importlib.import_module(module)
    except ImportError:
        raise RefusedError(
            f"{what} needs {module}, which is not installed: pip install 'edgefusion[{extra}]'"
        ) from None
