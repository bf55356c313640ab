# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""From the bus into a file, until somebody ends it or the disk is full."""

from __future__ import annotations

import logging
import select
import sys
import time
from pathlib import Path
from typing import List, Optional, Sequence, Tuple

import zenoh
from tqdm import tqdm

from edgefusion.bus.subscriber import Received, Subscriber
from edgefusion.bus.tags import SampleTag, read_tag
from edgefusion.bus.topics import Topic, Urgency, key_of
from edgefusion.clock import Clock, system_clock
from edgefusion.errors import RefusedError
from edgefusion.recording.recorder import Recorder
from edgefusion.service.signal_pipe import ENDS, SignalPipe

log = logging.getLogger(__name__)

TURN_S = 0.05
NEWEST, NEWEST_IMAGES = 500, 60
"""So many messages of a topic wait while the disk is slow, some seconds' worth; older ones are dropped and counted."""


class Tap:
    """A topic that is listened to."""

    def __init__(self, session: zenoh.Session, robot: str, topic: Topic) -> None:
        self.topic = topic
        newest = NEWEST_IMAGES if topic.urgency is Urgency.BULK else NEWEST
        self._subscriber = Subscriber(session, key_of(robot, topic.name), newest)
        self.take = self._subscriber.take

    @property
    def dropped(self) -> int:
        """How many came faster than they could be written."""
        return self._subscriber.dropped


def record(
    path: Path, recorder: Recorder, taps: Sequence[Tap], clock: Clock = system_clock, offset_ns: Optional[int] = None
) -> int:
    """Records until a signal comes, or the disk takes no more. Returns the exit code.

    offset_ns: what UTC is ahead of the clock. Looked at once, so that a wall clock that is set moves nothing.
    """
    ahead_ns = time.time_ns() - clock() if offset_ns is None else offset_ns
    failure = None
    try:
        with SignalPipe() as signals, tqdm(unit="B", unit_scale=True, disable=None, file=sys.stderr) as bar:
            while not _asked_to_end(signals):
                for topic, received in _news(taps):
                    data, log_ns = received.payload, received.received_ns + ahead_ns
                    recorder.add(f"/{topic.name}", topic.message, data, log_ns, _number(received))
                recorder.sync_if_due(clock())
                bar.update(recorder.bytes - bar.n)
    except OSError as error:
        failure = error
    finally:
        failure = _closed(recorder) or failure
    if failure is not None:
        log.error("%s: the recording ends here: %s", path, failure.strerror or failure)
    print(_in_words(path, recorder, taps))
    return 0 if failure is None else 1


def _asked_to_end(signals: SignalPipe) -> bool:
    """Waits for the next turn."""
    select.select([signals], [], [], TURN_S)
    return any(number in ENDS for number in signals.take())


def _news(taps: Sequence[Tap]) -> List[Tuple[Topic, Received]]:
    """What came on all topics since the last time, as it came."""
    news = [(tap.topic, received) for tap in taps for received in tap.take()]
    return sorted(news, key=lambda each: each[1].received_ns)


def _number(received: Received) -> int:
    """The sender's, where it gives one."""
    try:
        return 0 if received.attachment is None else read_tag(SampleTag, received.attachment).seq
    except RefusedError:
        return 0


def _closed(recorder: Recorder) -> Optional[OSError]:
    try:
        recorder.close()
    except OSError as error:
        return error
    return None


def _in_words(path: Path, recorder: Recorder, taps: Sequence[Tap]) -> str:
    dropped = {tap.topic.name: tap.dropped for tap in taps if tap.dropped}
    lost = ", ".join(f"{name} {number}" for name, number in dropped.items())
    if not recorder.messages:
        return f"{path}: nothing came: is the robot's name right, and does it run?"
    contents = f"{recorder.messages} messages of {recorder.topics} topics, {recorder.bytes / 1e6:.1f} MB"
    return f"{path}: {contents}" + (f"; dropped, since the disk is slow: {lost}" if lost else "")
