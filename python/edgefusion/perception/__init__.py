# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The perception system of the paper: a scan and a frame in, names and distances out."""
