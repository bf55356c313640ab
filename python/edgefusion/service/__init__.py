# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The processes on the robot: threads that own a device each, and the loop that joins them to mission and gate."""
