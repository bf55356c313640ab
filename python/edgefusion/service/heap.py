# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Processes that run for months must not grow with what they have once held."""

from __future__ import annotations

from types import MappingProxyType
from typing import Mapping

ENVIRONMENT: Mapping[str, str] = MappingProxyType(
    {"MALLOC_ARENA_MAX": "2", "MALLOC_MMAP_THRESHOLD_": "262144", "MALLOC_TRIM_THRESHOLD_": "262144"}
)
"""With these glibc gives back what is large as soon as it is freed; other C libraries know nothing of them.

Pictures, tensors and messages are allocated and freed by turns in a dozen threads. By itself glibc gives each thread an
arena of its own, and keeps ever larger pieces in it once it has seen one freed: each arena fills up and none is given
back. It reads them before the program begins, so they are for whoever starts it.
"""
