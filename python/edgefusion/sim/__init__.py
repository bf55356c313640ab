# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The simulator: worlds, a camera, a laser and a robot with ground truth."""
