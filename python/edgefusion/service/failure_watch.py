# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Sees every failure of a device, also one that came and went between two looks."""

from __future__ import annotations

from typing import Any, Tuple

from edgefusion.service.device_news import DeviceNews
from edgefusion.types import Health, HealthState


class FailureWatch:
    """Of one device."""

    def __init__(self) -> None:
        self._seen = 0

    def look(self, news: DeviceNews[Any]) -> Tuple[Health, ...]:
        """The device's health, and its failure since the last look, where it is over by now."""
        missed = news.failures != self._seen and news.health.state is not HealthState.FAILED
        self._seen = news.failures
        over = Health(news.health.component, HealthState.FAILED, news.failure) if missed else None
        return (news.health,) if over is None else (news.health, over)


def first_failure(healths: Tuple[Health, ...]) -> Health | None:
    """Of those that are FAILED; None where none is."""
    return next((health for health in healths if health.state is HealthState.FAILED), None)
