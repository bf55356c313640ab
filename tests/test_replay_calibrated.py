# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion replay --calibration`: a bag goes onto the bus with that calibration, whatever it has of its own."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Callable, Iterator, List

import numpy as np
import pytest

from bag_scenes import OFFSET_NS, STAMPER, Sample, samples, write_ours, written_as
from bus_lab import Lab, Sink, until, wait_for_listener
from edgefusion.bus.topics import CAMERA_INFO, IMAGE, SCAN, TF_STATIC
from edgefusion.cli import main
from edgefusion.errors import RefusedError
from edgefusion.messages.cdr import decode
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.sensor_msgs import CameraInfo, CompressedImage, LaserScan
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.to_transforms import to_transforms
from edgefusion.messages.transform import FrameTransform
from edgefusion.perception.calibration import Calibration, load_calibration
from edgefusion.recording.folder import FolderRecording
from edgefusion.recording.frame_tree import FrameTree
from edgefusion.recording.mcap_bag import McapBag
from edgefusion.recording.topic_choice import ANY
from edgefusion.tools.replay_calibrated import CalibratedBag
from edgefusion.tools.replay_samples import Sample as Told
from edgefusion.tools.replay_samples import plan
from scene import FRAMES, write_recording

BARE = ("/scan", "/image/compressed")


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("calibrated") / "drive")


@pytest.fixture(scope="module")
def calibration(drive: Path) -> Calibration:
    return load_calibration(drive / "calibration.toml")


@pytest.fixture
def lab() -> Iterator[Lab]:
    with ExitStack() as stack:
        yield Lab(stack)


def told_of(path: Path, messages: Iterator[Sample], calibration: Calibration) -> List[Told]:
    bag = McapBag(write_ours(path, messages))
    return list(CalibratedBag(bag, plan(bag, ANY, calibrated=True), calibration).samples())


def in_frames(laser: str, camera: str) -> Callable[[Sample], Sample]:
    """The same message, of those frames."""

    def renamed(sample: Sample) -> Sample:
        frame = {LaserScan: laser, CompressedImage: camera, CameraInfo: camera}.get(type(sample.message))
        if frame is None:
            return sample
        header = replace(sample.message.header, frame_id=frame)
        return sample._replace(message=replace(sample.message, header=header))

    return renamed


def tree_of(payloads: List[bytes]) -> FrameTree:
    tree = FrameTree()
    for payload in payloads:
        for each in to_transforms(decode(TFMessage, payload), Stamper()):
            tree.add(each.transform)
    return tree


@pytest.mark.parametrize("kind", ["ours", "ros1"])
def test_a_bag_without_a_calibration_is_on_the_bus_with_that_of_the_file(
    drive: Path, calibration: Calibration, tmp_path: Path, lab: Lab, kind: str
) -> None:
    path = written_as(kind, tmp_path, (sample for sample in samples(drive) if sample.topic in BARE))
    session = lab.router()
    infos, statics = Sink(session, "robot/camera_info"), Sink(session, "robot/tf_static")
    scans = Sink(session, "robot/scan")
    wait_for_listener(lab.client(), "robot/scan")
    file = str(drive / "calibration.toml")
    assert main(["replay", str(path), "--calibration", file, "--connect", lab.tcp, "--speed", "4", "--wait"]) == 0
    until(lambda: len(infos.samples) == len(scans.samples) == FRAMES and statics.samples, 30)
    found = [decode(CameraInfo, payload) for payload in infos.payloads()]
    assert [STAMPER.to_ns(info.header.stamp) for info in found] == [
        FolderRecording(drive).frame(i).stamp_ns for i in range(FRAMES)
    ]
    assert {tuple(info.k) for info in found} == {tuple(calibration.K.ravel())}
    tree = tree_of(statics.payloads())
    assert tree.transform("base_link", "laser") == pytest.approx(calibration.T_base_laser)
    assert tree.transform("camera_optical", "laser") == pytest.approx(calibration.T_camera_laser)


def test_the_calibration_takes_the_place_of_the_bags_own_and_its_other_frames_stay(
    drive: Path, calibration: Calibration, tmp_path: Path
) -> None:
    moved = calibration.T_base_laser + 0.0
    moved[0, 3] += 1.0
    own = [FrameTransform("base_link", "front_laser", moved), FrameTransform("base_link", "arm", np.eye(4))]
    statics = [
        Sample("/tf_static", from_transforms(0, [each], STAMPER), OFFSET_NS) for each in own
    ]  # each of its own publisher, as in ROS
    names = ("/robot/base_scan", "/robot/camera/image_raw/compressed")
    rest = [s for s in samples(drive, *names) if s.topic != "/tf_static"]
    recorded = map(in_frames("/front_laser", "eye"), [*statics, *rest])
    wrong_k = (
        s._replace(message=replace(s.message, k=[9.0] * 9)) if isinstance(s.message, CameraInfo) else s
        for s in recorded
    )
    told = told_of(tmp_path / "a.mcap", wrong_k, calibration)
    assert [s.topic for s in told] == [TF_STATIC, TF_STATIC, *[CAMERA_INFO, IMAGE, SCAN] * FRAMES]
    tree = tree_of([s.payload for s in told if s.topic is TF_STATIC])
    assert tree.frames == ["arm", "base_link", "eye", "front_laser"]
    assert tree.transform("base_link", "front_laser") == pytest.approx(calibration.T_base_laser)
    assert tree.transform("eye", "front_laser") == pytest.approx(calibration.T_camera_laser)
    infos = [decode(CameraInfo, s.payload) for s in told if s.topic is CAMERA_INFO]
    assert {(info.header.frame_id, tuple(info.k)) for info in infos} == {("eye", tuple(calibration.K.ravel()))}


def test_its_latencies_are_taken_off_the_stamps(drive: Path, calibration: Calibration, tmp_path: Path) -> None:
    late = replace(calibration, laser_latency_ns=50, camera_latency_ns=7)
    told = told_of(tmp_path / "a.mcap", samples(drive), late)
    folder = FolderRecording(drive)
    for topic, expected_ns in (
        (SCAN, [OFFSET_NS + folder.scan(i).stamp_ns - 50 for i in range(FRAMES)]),
        (IMAGE, [OFFSET_NS + folder.frame(i).stamp_ns - 7 for i in range(FRAMES)]),
        (CAMERA_INFO, [OFFSET_NS + folder.frame(i).stamp_ns - 7 for i in range(FRAMES)]),
    ):
        of_topic = [s for s in told if s.topic is topic]
        headers = [decode(topic.message, s.payload).header for s in of_topic]
        assert [s.stamp_ns for s in of_topic] == [Stamper().to_ns(h.stamp) for h in headers] == expected_ns


def test_scans_and_images_that_are_said_to_be_in_one_frame_cannot_be_calibrated(
    drive: Path, calibration: Calibration, tmp_path: Path
) -> None:
    with pytest.raises(RefusedError, match=r"a.mcap: --calibration: expected .*, found base_link and eye"):
        told_of(tmp_path / "a.mcap", map(in_frames("base_link", "eye"), samples(drive)), calibration)
