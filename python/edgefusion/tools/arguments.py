# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What several verbs take on the command line; argparse turns the errors into one line and exit code 2."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Callable

LAB_MODEL = Path(__file__).resolve().parents[1] / "data" / "lab-model"
"""The simulator's own classifier."""


def whole_number(least: int, most: int) -> Callable[[str], int]:
    """A parser of whole numbers within limits, both included."""

    def parse(text: str) -> int:
        if not (text.isdecimal() and least <= int(text) <= most):
            raise argparse.ArgumentTypeError(f"expected a whole number from {least} to {most}, got {text!r}")
        return int(text)

    return parse


seed_number = whole_number(0, 2**31 - 1)
"""A parser of seeds."""
