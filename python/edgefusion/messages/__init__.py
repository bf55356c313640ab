# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Messages of ROS 2: their types as dataclasses, their bytes, and what they are in the types of edgefusion."""

from edgefusion.messages.idl import Message, ros_name

__all__ = ["Message", "ros_name"]
