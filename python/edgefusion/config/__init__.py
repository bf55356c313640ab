# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The strict TOML configuration: a file for each of its sections, and what reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Tuple

import msgspec

from edgefusion.config.bus import BusConfig
from edgefusion.config.camera import CameraConfig
from edgefusion.config.combinations import check_combinations
from edgefusion.config.laser import LaserConfig
from edgefusion.config.load import load
from edgefusion.config.mission import MissionConfig
from edgefusion.config.navigation import BaseConfig, KhatibConfig, NavigationConfig
from edgefusion.config.perception import USUAL_HEIGHTS, HeightRule, Heights, PerceptionConfig, SyncConfig
from edgefusion.config.pioneer import PioneerConfig
from edgefusion.config.safety import SafetyConfig
from edgefusion.config.service import Process, ServiceConfig
from edgefusion.config.strict import convert, read_toml
from edgefusion.config.vision import VisionConfig

__all__ = [
    "USUAL_HEIGHTS",
    "BaseConfig",
    "BusConfig",
    "CameraConfig",
    "Config",
    "HeightRule",
    "Heights",
    "KhatibConfig",
    "LaserConfig",
    "MissionConfig",
    "NavigationConfig",
    "PerceptionConfig",
    "PioneerConfig",
    "SafetyConfig",
    "ServiceConfig",
    "SyncConfig",
    "VisionConfig",
    "convert",
    "load_config",
    "read_toml",
]


class Config(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The whole configuration file."""

    version: Literal[1] = 1
    """Of this format."""
    perception: PerceptionConfig = PerceptionConfig()
    sync: SyncConfig = SyncConfig()
    base: BaseConfig = BaseConfig()
    navigation: NavigationConfig = NavigationConfig()
    safety: SafetyConfig = SafetyConfig()
    mission: MissionConfig = MissionConfig()
    robot: PioneerConfig = PioneerConfig()
    laser: LaserConfig = LaserConfig()
    camera: CameraConfig = CameraConfig()
    vision: VisionConfig = VisionConfig()
    bus: BusConfig = BusConfig()
    service: ServiceConfig = ServiceConfig()

    def __post_init__(self) -> None:
        check_combinations(self)

    @property
    def processes(self) -> Tuple[Process, ...]:
        """What this machine runs: what it is to, but no vision without a model."""
        return tuple(name for name in self.service.processes if name != "vision" or self.vision.model is not None)


def load_config(path: Path | None) -> Config:
    """The configuration of a TOML file, or the defaults. Raises RefusedError with file, line, key and reason."""
    return Config() if path is None else load(path, Config).config
