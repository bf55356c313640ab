# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The processes of a robot, as its configuration wants them."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Dict, Tuple

from edgefusion.config import Config, ServiceConfig
from edgefusion.service.child_spec import ChildSpec, GiveUp

_VISION_NICE = 10
"""Its threads fill all processors; the others need little, but at once."""

_VISION_OOM = 500
"""When memory runs out it is vision that is killed: it has most of it, and nothing moves by it."""


def children_of(config: Config, path: Path) -> Tuple[ChildSpec, ...]:
    """path: of the configuration, for each of them to read."""
    service = config.service
    bus = _spec("bus", service, path, service.bus_start_s, service.bus_silence_s)
    base = _spec("base", service, path, service.base_start_s, service.base_silence_s)
    vision = _spec("vision", service, path, service.vision_start_s, service.vision_silence_s)
    specs: Dict[str, ChildSpec] = {
        "bus": bus,
        "base": replace(base, drives=True),
        "vision": replace(
            vision,
            give_up=GiveUp(service.vision_failures, service.vision_failures_within_s),
            required=not service.drive_without_vision or "base" not in config.processes,
            nice=_VISION_NICE,
            oom_score_adj=_VISION_OOM,
        ),
    }
    return tuple(specs[name] for name in config.processes)


def _spec(name: str, config: ServiceConfig, path: Path, start_s: float, silence_s: float) -> ChildSpec:
    """With this very interpreter, in whatever environment that is installed."""
    argv = (sys.executable, "-m", "edgefusion.cli", name, "--config", str(path))
    return ChildSpec(
        name, argv, start_s, silence_s, first_pause_s=config.first_pause_s, longest_pause_s=config.longest_pause_s
    )
