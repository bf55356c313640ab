# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What `edgefusion replay` does with a bus."""

from __future__ import annotations

import argparse
import sys
import time
import uuid
from contextlib import contextmanager
from typing import Callable, Collection, Iterator, NamedTuple, Optional, Sequence

import zenoh
from tqdm import tqdm

from edgefusion.bus.router import open_router
from edgefusion.bus.session import open_client
from edgefusion.bus.topics import CAMERA_INFO, IMAGE, SCAN, TF_STATIC, Topic
from edgefusion.errors import RefusedError
from edgefusion.recording.bag import Bag
from edgefusion.recording.carmen_recording import CarmenRecording
from edgefusion.recording.folder import FolderRecording
from edgefusion.recording.recording import Recording, open_bag, open_recording
from edgefusion.tools.bus_options import asked_endpoint, bus_config
from edgefusion.tools.recording_options import topic_names
from edgefusion.tools.replay_loop import Pace, Stage
from edgefusion.tools.replay_samples import Sample, bag_samples, drive_samples, plan

BETWEEN_S = 0.1
"""From the end of a round to the next: a recording of a single moment shall not fill the bus."""


class Programme(NamedTuple):
    """What is to be put: on which topics, how many samples where that is known, and what makes them anew."""

    topics: Sequence[Topic]
    total: Optional[int]
    samples: Callable[[], Iterator[Sample]]


def play(args: argparse.Namespace) -> int:
    """Puts a recording on a bus. Raises RefusedError, OSError where the bus fails."""
    programme, speed = _programme(args), 1.0 if args.speed is None else args.speed
    if programme.total == 0:
        raise RefusedError(f"{args.recording}: has nothing to play: expected a message at least")
    with _session(args) as (session, robot, where):
        stage = Stage(session, robot, programme.topics, f"replay-{uuid.uuid4().hex}")
        waits = ", as soon as somebody listens" if args.wait else ""
        print(f"edgefusion: replay: on the bus at {where}, as the robot {robot!r}{waits}", file=sys.stderr)
        if args.wait:
            stage.wait_for_listeners()
        count = _play_once(programme, stage, Pace(speed))
        while args.loop and count:
            time.sleep(BETWEEN_S)
            _play_once(programme, stage, Pace(speed))
    print(f"{args.recording}: {count} messages")
    return 0


def _play_once(programme: Programme, stage: Stage, pace: Pace) -> int:
    count = 0
    for sample in tqdm(programme.samples(), total=programme.total, unit="message", disable=None, file=sys.stderr):
        pace.wait(sample.at_ns)
        stage.put(sample)
        count += 1
    return count


def _programme(args: argparse.Namespace) -> Programme:
    bag = open_bag(args.recording)
    if bag is not None:
        return _of_bag(bag, args) if args.calibration is None else _of_calibrated_bag(bag, args)
    recording = open_recording(args.recording)
    calibration = None
    if args.calibration is not None or isinstance(recording, FolderRecording):
        from edgefusion.tools.recording_calibration import find_calibration  # with the core, which bags do not need

        calibration, _ = find_calibration(recording, args.calibration)
    return Programme(
        [SCAN, IMAGE, CAMERA_INFO, TF_STATIC],
        _samples_of(recording, calibration is not None),
        lambda: drive_samples(recording, calibration),
    )


def _of_bag(bag: Bag, args: argparse.Namespace) -> Programme:
    planned = plan(bag, topic_names(args))
    return Programme(list(planned.values()), _messages(bag, planned), lambda: bag_samples(bag, planned))


def _of_calibrated_bag(bag: Bag, args: argparse.Namespace) -> Programme:
    from edgefusion.perception.calibration import load_calibration  # with the core, which bags do not need
    from edgefusion.tools.replay_calibrated import CalibratedBag

    calibration = load_calibration(args.calibration)
    planned = plan(bag, topic_names(args), calibrated=True)
    infos = _messages(bag, [name for name, topic in planned.items() if topic is IMAGE])
    total = _messages(bag, planned)
    return Programme(
        list(dict.fromkeys([*planned.values(), CAMERA_INFO, TF_STATIC])),
        total + infos + 1 if total else 0,
        CalibratedBag(bag, planned, calibration).samples,
    )


def _messages(bag: Bag, names: Collection[str]) -> int:
    return sum(topic.messages for topic in bag.topics if topic.name in names)


def _samples_of(recording: Recording, calibrated: bool) -> Optional[int]:
    """How many samples a folder or a log gives; None where that is not known."""
    if isinstance(recording, CarmenRecording):
        scans = recording.scans
        return scans + calibrated if scans else 0
    if isinstance(recording, FolderRecording):
        return len(recording) + recording.frames * (1 + calibrated) + calibrated
    return None


@contextmanager
def _session(args: argparse.Namespace) -> Iterator[tuple[zenoh.Session, str, str]]:
    """A bus of its own, or that to which it shall connect; the robot's name there, and where it is."""
    if args.connect is None:
        config = bus_config(args)
        with open_router(config) as session:
            yield session, config.robot, ", ".join(config.listen)
    else:
        endpoint = asked_endpoint(args)
        with open_client(endpoint.address, endpoint.keys, lease_s=endpoint.lease_s) as session:
            yield session, endpoint.robot, endpoint.address
