# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the system refuses to whoever writes files, as a refusal that names the path."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

from edgefusion.errors import RefusedError


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Raises RefusedError naming the path for what the system refuses."""
    try:
        yield
    except OSError as error:
        raise RefusedError(f"{error.filename or path}: cannot write there: {error.strerror or error}") from error
