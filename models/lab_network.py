# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The small network of the simulator's kinds: a residual net of plain convolutions, a quarter of a million weights."""

from __future__ import annotations

from typing import Any

import torch
from torch import nn

CHANNELS = (16, 32, 64, 96)
"""Of its four stages; each halves the picture's sides."""


def _convolution(channels_in: int, channels_out: int, stride: int) -> list[nn.Module]:
    return [
        nn.Conv2d(channels_in, channels_out, 3, stride, 1, bias=False),
        nn.BatchNorm2d(channels_out),
    ]


class _Residual(nn.Module):  # type: ignore[misc]
    def __init__(self, channels: int) -> None:
        super().__init__()
        inner = [*_convolution(channels, channels, 1), nn.ReLU(), *_convolution(channels, channels, 1)]
        self.inner = nn.Sequential(*inner)

    def forward(self, x: Any) -> Any:
        return torch.relu(x + self.inner(x))


class LabNetwork(nn.Module):  # type: ignore[misc]
    """float32 [n, 3, size, size] to logits [n, classes], size a multiple of 32."""

    def __init__(self, classes: int, size: int) -> None:
        super().__init__()
        stages: list[nn.Module] = []
        channels_in = 3
        for i, channels in enumerate(CHANNELS):
            stages += [*_convolution(channels_in, channels, 2), nn.ReLU()]
            if i >= 2:
                stages.append(_Residual(channels))
            channels_in = channels
        self.body = nn.Sequential(*stages)
        # Where in the picture a feature is tells whether the box fits: mean alone would forget it.
        self.rows = nn.AvgPool2d(2)
        self.head = nn.Sequential(nn.Flatten(), nn.Dropout(0.2), nn.Linear((size // 32) ** 2 * channels_in, classes))

    def forward(self, x: Any) -> Any:
        return self.head(self.rows(self.body(x)))
