# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Our messages are those of ROS 2: as rosbags writes, reads and defines them."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from any_message import any_message, as_rosbags
from edgefusion.messages.cdr import decode, encode
from edgefusion.messages.definitions import definition
from edgefusion.messages.idl import Message
from edgefusion.messages.registry import MESSAGES

typesys = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed")
VISION_MSGS = {
    "Point2D": "float64 x\nfloat64 y",
    "Pose2D": "vision_msgs/Point2D position\nfloat64 theta",
    "BoundingBox2D": "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y",
    "ObjectHypothesis": "string class_id\nfloat64 score",
    "ObjectHypothesisWithPose": "ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose",
    "Detection2D": "std_msgs/Header header\nObjectHypothesisWithPose[] results\nBoundingBox2D bbox\nstring id",
    "Detection2DArray": "std_msgs/Header header\nDetection2D[] detections",
}
"""The fields of vision_msgs 4 (Humble and later); of all other packages rosbags brings the definitions itself."""

every_type = pytest.mark.parametrize("name", sorted(MESSAGES))


def parsed(cls: type[Message], name: str) -> Any:
    """What rosbags understands of our definition, by the names of the types in it."""
    return typesys.get_types_from_msg(definition(cls), name)


@pytest.fixture(scope="module")
def store() -> Any:
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    for name, text in VISION_MSGS.items():
        store.register(typesys.get_types_from_msg(text, f"vision_msgs/msg/{name}"))
    return store


@every_type
@settings(max_examples=15)
@given(data=st.data())
def test_the_bytes_are_those_that_rosbags_writes(store: Any, name: str, data: st.DataObject) -> None:
    message = data.draw(any_message(MESSAGES[name]))
    assert encode(message) == bytes(store.serialize_cdr(as_rosbags(message, store), name))


@every_type
@settings(max_examples=10)
@given(data=st.data())
def test_what_rosbags_writes_in_either_byte_order_is_read(store: Any, name: str, data: st.DataObject) -> None:
    message = data.draw(any_message(MESSAGES[name]))
    for little_endian in (True, False):
        written = bytes(store.serialize_cdr(as_rosbags(message, store), name, little_endian=little_endian))
        # Compared as bytes: NaN is not equal to itself.
        assert encode(decode(MESSAGES[name], written)) == encode(message)


@every_type
def test_rosbags_reads_what_we_write(store: Any, name: str) -> None:
    message = MESSAGES[name]()
    read = store.deserialize_cdr(encode(message), name)
    assert bytes(store.serialize_cdr(read, name)) == encode(message)


@every_type
def test_a_definition_has_the_fields_and_constants_of_ros_2(store: Any, name: str) -> None:
    types = parsed(MESSAGES[name], name)
    for each, (constants, members) in types.items():
        theirs = (getattr(store, "fielddefs", None) or store.FIELDDEFS)[each]  # old rosbags shouts
        assert list(members) == list(theirs[1]), each
        assert list(constants) == list(theirs[0]), each


def test_of_vision_msgs_every_type_on_the_bus_is_compared_with_its_public_definition() -> None:
    ours = {name for name in MESSAGES if name.startswith("vision_msgs/")}
    assert ours == {f"vision_msgs/msg/{name}" for name in VISION_MSGS}


@every_type
def test_a_definition_holds_all_that_the_type_contains_once(name: str) -> None:
    headings = [line for line in definition(MESSAGES[name]).splitlines() if line.startswith("MSG: ")]
    assert len(headings) == len(set(headings))
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    store.register(parsed(MESSAGES[name], name))
    assert bytes(store.serialize_cdr(as_rosbags(MESSAGES[name](), store), name)) == encode(MESSAGES[name]())
