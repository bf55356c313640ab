# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Zenoh: which topics there are, sessions, the router and its access control, and whose commands count."""
