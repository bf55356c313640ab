# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The frames' names on the bus, as in ROS REP 103 and 105."""

ODOM = "odom"
BASE_LINK = "base_link"
LASER = "laser"
CAMERA_OPTICAL = "camera_optical"
