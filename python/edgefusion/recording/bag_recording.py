# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A bag as a recorded drive: its laser and its camera."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Iterator, Union

from edgefusion.messages import ros_name
from edgefusion.messages.cdr import decode
from edgefusion.messages.sensor_msgs import CompressedImage, Image, LaserScan
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.to_image import to_image
from edgefusion.messages.to_raw_image import to_raw_image
from edgefusion.messages.to_scan import to_scan
from edgefusion.recording.bag import Bag, BagMessage, naming
from edgefusion.recording.topic_choice import ANY, TopicNames, image_topic, scan_topic
from edgefusion.types import Frame, Scan

UTC = Stamper()


class BagRecording:
    """Scans and frames of a bag, stamped with UTC. Raises RefusedError where their topics are not found."""

    def __init__(self, bag: Bag, names: TopicNames = ANY) -> None:
        self.bag, self.names = bag, names
        self.scan_topic, self.image_topic = scan_topic(bag, names), image_topic(bag, names)

    @property
    def path(self) -> Path:
        """The bag's."""
        return self.bag.path

    @property
    def frames(self) -> int:
        """How many frames there are."""
        return self.image_topic.messages

    def frame_name(self, index: int) -> str:
        """What says which frame it is."""
        return f"{self.path}: image {index} of {self.image_topic.name}"

    def messages(self, laser_latency_ns: int = 0, camera_latency_ns: int = 0) -> Iterator[Union[Scan, Frame]]:
        """Scans and frames in the order in which they were recorded, stamped with when they were captured.

        Latencies: from capture to the stamp that the recording carries.
        """
        for message in self.bag.read({self.scan_topic.name, self.image_topic.name}):
            if message.topic == self.scan_topic.name:
                scan = scan_of(self.bag, message)
                yield replace(scan, stamp_ns=scan.stamp_ns - laser_latency_ns)
            else:
                frame = frame_of(self.bag, message)
                yield replace(frame, stamp_ns=frame.stamp_ns - camera_latency_ns)


def scan_of(bag: Bag, message: BagMessage) -> Scan:
    """Of a LaserScan. Raises RefusedError, naming bag, topic and time, for one that is none."""
    with naming(bag, message):
        return to_scan(decode(LaserScan, message.data), UTC)


def frame_of(bag: Bag, message: BagMessage) -> Frame:
    """Of an image, raw or compressed. Raises RefusedError, naming bag, topic and time, for one that is none."""
    with naming(bag, message):
        if message.type_name == ros_name(Image):
            return to_raw_image(decode(Image, message.data), UTC)
        return to_image(decode(CompressedImage, message.data), UTC)
