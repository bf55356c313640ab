# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Recordings: reading what robots wrote down."""
