# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""MCAP files as bags: ours and ROS 2's, also those that end in the middle."""

from __future__ import annotations

import logging
from collections import Counter
from contextlib import contextmanager
from pathlib import Path
from typing import AbstractSet, BinaryIO, Dict, Iterator, Mapping, NamedTuple, Optional, Tuple

from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message, Schema

from edgefusion.errors import RefusedError
from edgefusion.recording.bag import BagMessage, BagTopic
from edgefusion.recording.mcap_records import Record, parsed, read_content, read_records, records_of_chunk
from edgefusion.recording.mcap_survey import is_ended, survey

log = logging.getLogger(__name__)

ENCODING = "cdr"


class _Contents(NamedTuple):
    """messages: how many each channel has. end: where what is whole ends, where the file has no end of its own."""

    channels: Mapping[int, Channel]
    schemas: Mapping[int, Schema]
    messages: Mapping[int, int]
    end: Optional[int] = None

    def type_name(self, channel: Channel) -> str:
        schema = self.schemas.get(channel.schema_id)
        return schema.name if schema else "of no type"


class McapBag:
    """An MCAP file of messages in CDR. One without its end is read as far as it goes; that is logged, once.

    Raises RefusedError for what is no MCAP file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._reading() as file:
            self._contents = _contents(file)
        if self._contents.end is not None:
            log.warning("%s: has no end; what is whole is read, and `edgefusion recover` mends it", path)

    @property
    def topics(self) -> Tuple[BagTopic, ...]:
        """All topics, by name; of the type of their first channel."""
        found: Dict[str, BagTopic] = {}
        for number, channel in self._contents.channels.items():
            before = found.get(channel.topic, BagTopic(channel.topic, self._contents.type_name(channel), 0))
            found[channel.topic] = before._replace(messages=before.messages + self._contents.messages.get(number, 0))
        return tuple(found[name] for name in sorted(found))

    def read(self, topics: Optional[AbstractSet[str]] = None) -> Iterator[BagMessage]:
        """By the time of recording where the file has an index, else as they stand there."""
        channels = self._channels(topics)
        with self._reading() as file:
            for message in self._messages(file, {channel.topic for channel in channels.values()}):
                channel = channels.get(message.channel_id)
                if channel is not None:
                    type_name = self._contents.type_name(channel)
                    yield BagMessage(channel.topic, type_name, message.log_time, message.data)

    def _channels(self, topics: Optional[AbstractSet[str]]) -> Dict[int, Channel]:
        channels = {n: c for n, c in self._contents.channels.items() if topics is None or c.topic in topics}
        for channel in channels.values():
            if channel.message_encoding != ENCODING:
                raise RefusedError(
                    f"{self.path}: {channel.topic}: expected messages in CDR, got {channel.message_encoding!r}"
                )
        return channels

    def _messages(self, file: BinaryIO, topics: AbstractSet[str]) -> Iterator[Message]:
        if self._contents.end is None:
            for _, _, message in make_reader(file, validate_crcs=True).iter_messages(topics=topics):
                yield message
        else:
            yield from _messages_before(file, self._contents.end)

    @contextmanager
    def _reading(self) -> Iterator[BinaryIO]:
        try:
            with self.path.open("rb") as file:
                yield file
        except RefusedError:
            raise
        except OSError as error:
            raise RefusedError(f"{self.path}: cannot be read: {error.strerror or error}") from error
        except Exception as error:  # of a damaged file mcap, struct and the decompressors raise a dozen kinds
            raise RefusedError(f"{self.path}: {error or type(error).__name__}") from error


def _contents(file: BinaryIO) -> _Contents:
    if is_ended(file):
        file.seek(0)
        summary = make_reader(file).get_summary()
        if summary is not None and summary.statistics is not None and summary.channels:
            return _Contents(summary.channels, summary.schemas, summary.statistics.channel_message_counts)
    found = survey(file)
    index = found.index
    return _Contents(index.channels, index.schemas, Counter(index.messages), None if found.whole else found.end)


def _messages_before(file: BinaryIO, end: int) -> Iterator[Message]:
    for record in read_records(file):
        if record.offset >= end:
            return
        inner = records_of_chunk(parsed(record, Chunk)) if record.opcode == Opcode.CHUNK else [record]
        yield from _only_messages(inner)


def _only_messages(records: list[Record]) -> Iterator[Message]:
    for record in records:
        content = read_content(record)
        if isinstance(content, Message):
            yield content
