# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where and how a network runs, as the configuration means it."""

from __future__ import annotations

from edgefusion.config import VisionConfig
from edgefusion.perception.network import RuntimeOptions


def runtime_options(settings: VisionConfig) -> RuntimeOptions:
    """Raises RefusedError."""
    require = settings.provider if settings.require_provider and settings.provider != "auto" else None
    return RuntimeOptions(provider=settings.provider, require=require, threads=settings.threads)
