# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Readers of recorded laser and camera data."""
