# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Names and distances of the objects in front of a robot, from a 2D laser and a camera."""

from importlib.metadata import version

__version__ = version("edgefusion")
