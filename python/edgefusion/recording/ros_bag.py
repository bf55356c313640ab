# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Bags of ROS 1 and of rosbag2, by the library rosbags, as bags of CDR."""

from __future__ import annotations

from collections import Counter
from contextlib import contextmanager
from pathlib import Path
from typing import AbstractSet, Any, Dict, Iterator, Optional, Tuple

from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from edgefusion.errors import RefusedError
from edgefusion.recording.bag import BagMessage, BagTopic

_HEADER = "std_msgs/msg/Header"


class RosBag:
    """A .bag of ROS 1, a folder of rosbag2, or a .db3 of its own. Raises RefusedError for what is none."""

    def __init__(self, path: Path) -> None:
        self.path = path
        counts: Counter[str] = Counter()
        types: Dict[str, str] = {}
        with self._reading() as reader:
            for connection in reader.connections:
                counts[connection.topic] += connection.msgcount
                types.setdefault(connection.topic, connection.msgtype)
        self.topics: Tuple[BagTopic, ...] = tuple(BagTopic(name, types[name], counts[name]) for name in sorted(types))

    def read(self, topics: Optional[AbstractSet[str]] = None) -> Iterator[BagMessage]:
        """By the time of recording."""
        with self._reading() as reader:
            wanted = [c for c in reader.connections if topics is None or c.topic in topics]
            if not wanted:  # which rosbags would take for all
                return
            store = None if reader.is2 else _with_headers_of_ros2(reader.typestore)
            for connection, log_ns, data in reader.messages(wanted):
                cdr = data if store is None else store.ros1_to_cdr(data, connection.msgtype)
                yield BagMessage(connection.topic, connection.msgtype, log_ns, bytes(cdr))

    @contextmanager
    def _reading(self) -> Iterator[AnyReader]:
        try:
            # Bags of older ROS 2 do not say how their types are defined.
            with AnyReader([self.path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
                yield reader
        except RefusedError:
            raise
        except Exception as error:  # of a damaged bag rosbags, its storages and its decompressors raise a dozen kinds
            reason = " ".join(str(error).split())[:200] or type(error).__name__
            raise RefusedError(f"{self.path}: expected a bag of ROS: {reason}") from error


def _with_headers_of_ros2(types: Typestore) -> Typestore:
    """The types of a bag of ROS 1 as they are in CDR, where headers have no number."""
    store = get_typestore(Stores.EMPTY)
    header = _fields(get_typestore(Stores.ROS2_HUMBLE))[_HEADER]
    store.register({**_fields(types), _HEADER: header})
    return store


def _fields(types: Any) -> Dict[str, Any]:
    """rosbags for Python 3.8 has them under another name."""
    fields: Dict[str, Any] = getattr(types, "fielddefs", None) or types.FIELDDEFS
    return fields
