# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Settings of the process that sees: its model, its calibration, and what the network runs on."""

from __future__ import annotations

import sys
from typing import Literal, Optional

import msgspec

from edgefusion.config.strict import FilePath, check_fields
from edgefusion.errors import RefusedError

if sys.version_info >= (3, 9):
    from typing import Annotated
else:
    from typing_extensions import Annotated


class VisionConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The process that names what the camera sees. Without a model there is none, and the robot only drives."""

    model: Optional[FilePath] = None
    """A model folder (docs/models.md)."""
    calibration: Optional[FilePath] = None
    """Where the sensors are (docs/calibration.md); needed beside a model."""
    groups: Optional[FilePath] = None
    """A TOML file of label groups. Left out: those that ship."""
    provider: Literal["auto", "tensorrt", "cuda", "cpu"] = "auto"
    """What the network runs on; "auto" takes the first of the others that is there."""
    require_provider: bool = False
    """Refuse to run on another one, at the start and when a GPU fails."""
    threads: Annotated[int, msgspec.Meta(ge=0, le=64)] = 0
    """Of the network on a CPU; 0: one for each core. [threads]"""

    def __post_init__(self) -> None:
        check_fields(self)
        if (self.model is None) != (self.calibration is None):
            raise RefusedError(f"model, calibration: expected both or neither, got {self.model}, {self.calibration}")
        if self.require_provider and self.provider == "auto":
            raise RefusedError("require_provider: expected a provider beside it, got auto")
