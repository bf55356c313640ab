# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the verbs that read recordings take: the recording and, of a bag, its topics."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from edgefusion.errors import RefusedError

if TYPE_CHECKING:
    from edgefusion.recording.recording import Recording
    from edgefusion.recording.topic_choice import TopicNames

FORMATS = """RECORDING is a folder with images/000000.jpg ..., scans.npz and calibration.toml or .json; an MCAP file, as
`edgefusion record` or ROS 2 writes it; a bag of ROS 1 or rosbag2; or a CARMEN log. The topics of a bag are found by
ROS's usual names, its calibration in camera_info and tf_static."""


def add_recording(parser: argparse.ArgumentParser) -> None:
    """The recording and its topics."""
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="what was recorded, see below")
    parser.add_argument("--scan-topic", metavar="TOPIC", help="of a bag: the laser's scans, as /scan")
    parser.add_argument("--image-topic", metavar="TOPIC", help="of a bag: the camera's images, as /camera/image_raw")
    parser.add_argument("--camera-info-topic", metavar="TOPIC", help="of a bag: the camera's calibration")


def open_asked(args: argparse.Namespace) -> Recording:
    """The recording, for a detector. Raises RefusedError, also for one without images."""
    from edgefusion.recording.recording import open_recording

    recording = open_recording(args.recording, topic_names(args))
    if not recording.frames:
        raise RefusedError(f"{args.recording}: has no images, and what is only in the laser's scans has no name")
    return recording


def topic_names(args: argparse.Namespace) -> TopicNames:
    """The topics that were asked for."""
    from edgefusion.recording.topic_choice import TopicNames

    return TopicNames(args.scan_topic, args.image_topic, args.camera_info_topic)
