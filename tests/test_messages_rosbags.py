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
from edgefusion.messages.vision_msgs import Detection2DArray

typesys = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed")
OURS_ALONE = "vision_msgs/"
"""rosbags brings the definitions of all other packages itself."""

every_type = pytest.mark.parametrize("name", sorted(MESSAGES))


def parsed(cls: type[Message], name: str) -> Any:
    """What rosbags understands of our definition, by the names of the types in it."""
    return typesys.get_types_from_msg(definition(cls), name)


@pytest.fixture(scope="module")
def store() -> Any:
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    types = parsed(Detection2DArray, "vision_msgs/msg/Detection2DArray")
    store.register({name: types[name] for name in types if name.startswith(OURS_ALONE)})
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


@every_type
def test_a_definition_holds_all_that_the_type_contains_once(name: str) -> None:
    headings = [line for line in definition(MESSAGES[name]).splitlines() if line.startswith("MSG: ")]
    assert len(headings) == len(set(headings))
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    store.register(parsed(MESSAGES[name], name))
    assert bytes(store.serialize_cdr(as_rosbags(MESSAGES[name](), store), name)) == encode(MESSAGES[name]())
