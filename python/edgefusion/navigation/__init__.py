# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Drives to a goal among what the laser sees, and stops to inspect what the camera names."""
