# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The devices: what speaks to the robot, the laser and the camera. Clocks and ports are passed in."""
