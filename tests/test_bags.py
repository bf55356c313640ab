# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Bags of every kind give the drive that was put into them; their topics and their calibration are found."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Writer1
from rosbags.typesys import Stores, get_typestore

from bag_scenes import KINDS, OFFSET_NS, Sample, samples, write_ours, write_theirs, written_as
from edgefusion.errors import RefusedError
from edgefusion.messages import ros_name
from edgefusion.messages.cdr import encode
from edgefusion.messages.sensor_msgs import CameraInfo, CompressedImage, LaserScan
from edgefusion.messages.std_msgs import String
from edgefusion.recording.bag_recording import BagRecording
from edgefusion.recording.folder import FolderRecording
from edgefusion.recording.mcap_bag import McapBag
from edgefusion.recording.recording import open_bag, open_recording
from edgefusion.recording.topic_choice import TopicNames
from edgefusion.tools.recording_calibration import find_calibration
from edgefusion.types import Frame, Scan
from scene import FRAMES, write_recording


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("bags") / "drive")


def opened(path: Path, **names: str) -> BagRecording:
    recording = open_recording(path, TopicNames(**names))
    assert isinstance(recording, BagRecording)
    return recording


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_bag_gives_the_scans_and_frames_that_were_put_into_it(
    drive: Path, tmp_path: Path, kind: str
) -> None:
    recording = opened(written_as(kind, tmp_path, samples(drive)))
    folder = FolderRecording(drive)
    messages = list(recording.messages())
    scans = [message for message in messages if isinstance(message, Scan)]
    frames = [message for message in messages if isinstance(message, Frame)]
    assert recording.frames == len(frames) == len(scans) == FRAMES
    for i, (scan, frame) in enumerate(zip(scans, frames)):
        assert (scan.stamp_ns, frame.stamp_ns) == tuple(
            OFFSET_NS + message.stamp_ns for message in (folder.scan(i), folder.frame(i))
        )
        assert (scan.ranges_m == folder.scan(i).ranges_m).all()
        assert scan.angles == pytest.approx(folder.scan(i).angles, abs=1e-5)
        assert (frame.image == folder.frame(i).image).all()


@pytest.mark.parametrize("kind", KINDS)
def test_camera_info_and_tf_static_give_the_calibration_that_the_folder_has(
    drive: Path, tmp_path: Path, kind: str
) -> None:
    found, source = find_calibration(opened(written_as(kind, tmp_path, samples(drive))), None)
    expected, _ = find_calibration(FolderRecording(drive), None)
    assert source == "/camera_info and the transforms of laser, camera_optical and base_link"
    assert found.K == pytest.approx(expected.K)
    assert found.image_size == expected.image_size
    assert found.T_camera_laser == pytest.approx(expected.T_camera_laser)
    assert found.T_base_laser == pytest.approx(expected.T_base_laser)
    assert found.laser_height_m == pytest.approx(expected.laser_height_m)


@pytest.mark.skipif("mcap" not in KINDS, reason="the newest rosbags for Python 3.8 reads no single files of MCAP")
def test_what_we_record_is_what_rosbags_reads(drive: Path, tmp_path: Path) -> None:
    messages = list(samples(drive))
    path = write_ours(tmp_path / "drive.mcap", iter(messages))
    with AnyReader([path]) as reader:
        found = [(c.topic, log_ns, bytes(data)) for c, log_ns, data in reader.messages()]
        scans = [reader.deserialize(data, c.msgtype) for c, _, data in reader.messages() if c.topic == "/scan"]
    assert sorted(found) == sorted((topic, log_ns, encode(message)) for topic, message, log_ns in messages)
    assert [np.asarray(scan.ranges).tolist() for scan in scans] == [
        message.ranges for _, message, _ in messages if isinstance(message, LaserScan)
    ]


@pytest.mark.skipif("mcap" not in KINDS, reason="the newest rosbags for Python 3.8 reads no single files of MCAP")
@pytest.mark.parametrize("made", ["theirs.bag", "theirs"])
def test_what_we_record_is_converted_by_rosbags_to_ros_1_and_rosbag2_with_every_message(
    drive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, made: str
) -> None:
    from rosbags.convert.cli import main as rosbags_convert  # which that of Python 3.8 has elsewhere

    messages = list(samples(drive))
    path = write_ours(tmp_path / "drive.mcap", iter(messages))
    monkeypatch.setattr(sys, "argv", ["rosbags-convert", "--src", str(path), "--dst", str(tmp_path / made)])
    with pytest.raises(SystemExit) as ended:
        rosbags_convert()
    assert not ended.value.code
    bag = open_bag(tmp_path / made)
    assert bag is not None
    assert sorted((m.topic, m.type_name, m.log_ns, m.data) for m in bag.read()) == sorted(
        (topic, ros_name(type(message)), log_ns, encode(message)) for topic, message, log_ns in messages
    )


def test_the_number_in_a_header_of_ros_1_is_left_out(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS1_NOETIC)
    header = store.types["std_msgs/msg/Header"]
    stamp = store.types["builtin_interfaces/msg/Time"](sec=1_700_000_000, nanosec=5)
    scan = store.types["sensor_msgs/msg/LaserScan"](
        header(seq=77, stamp=stamp, frame_id="laser"), -1.0, 1.0, 1.0, 0.0, 0.1, 0.0, 9.0,
        np.array([1, 2, 3], np.float32), np.zeros(0, np.float32),
    )  # fmt: skip
    with Writer1(tmp_path / "a.bag") as writer:
        connection = writer.add_connection("/scan", "sensor_msgs/msg/LaserScan", typestore=store)
        writer.write(connection, OFFSET_NS, store.serialize_ros1(scan, "sensor_msgs/msg/LaserScan"))
    bag = open_bag(tmp_path / "a.bag")
    assert bag is not None
    ((_, _, log_ns, data),) = bag.read()
    assert log_ns == OFFSET_NS
    expected = get_typestore(Stores.ROS2_HUMBLE).deserialize_cdr(data, "sensor_msgs/msg/LaserScan")
    assert (expected.header.stamp.nanosec, expected.header.frame_id) == (5, "laser")
    assert expected.ranges.tolist() == [1, 2, 3]


def test_latencies_are_taken_from_the_stamps(drive: Path, tmp_path: Path) -> None:
    recording = opened(write_ours(tmp_path / "a.mcap", samples(drive)))
    frame, scan, *_ = recording.messages(laser_latency_ns=50, camera_latency_ns=7)
    assert (frame.stamp_ns, scan.stamp_ns) == (OFFSET_NS - 7, OFFSET_NS - 50)


@pytest.mark.parametrize(
    ("scan", "image"),
    [
        ("/scan", "/image_raw/compressed"),
        ("/base_scan", "/camera/image_raw/compressed"),
        ("/robot/scan", "/robot/camera/color/image_raw/compressed"),
        ("/lidar_7", "/eye"),
    ],
)
def test_the_usual_names_and_single_topics_are_found(drive: Path, tmp_path: Path, scan: str, image: str) -> None:
    recording = opened(write_ours(tmp_path / "a.mcap", samples(drive, scan, image)))
    assert (recording.scan_topic.name, recording.image_topic.name) == (scan, image)
    find_calibration(recording, None)


def test_of_several_topics_the_usual_one_is_taken_and_options_take_another(drive: Path, tmp_path: Path) -> None:
    rear = [Sample("/rear_scan", m, t) for name, m, t in samples(drive) if name == "/scan"]
    path = write_ours(tmp_path / "a.mcap", iter([*samples(drive), *rear]))
    assert opened(path).scan_topic.name == "/scan"
    assert opened(path, scan="rear_scan").scan_topic.name == "/rear_scan"


def test_where_several_are_equally_usual_the_option_is_named(drive: Path, tmp_path: Path) -> None:
    two = [Sample(f"/{side}{name}", m, t) for side in ("left", "right") for name, m, t in samples(drive)]
    path = write_ours(tmp_path / "a.mcap", iter(two))
    with pytest.raises(RefusedError, match="several topics of laser scans, /left/scan, /right/scan: --scan-topic"):
        open_recording(path)


def test_a_topic_that_is_not_there_is_refused_with_those_that_are(drive: Path, tmp_path: Path) -> None:
    path = write_ours(tmp_path / "a.mcap", samples(drive))
    listed = re.escape("/camera_info (sensor_msgs/msg/CameraInfo, 6), /image/compressed")
    with pytest.raises(RefusedError, match=f"/laser: expected a topic of sensor_msgs/msg/LaserScan .*{listed}"):
        open_recording(path, TopicNames(scan="/laser"))
    without = write_ours(tmp_path / "b.mcap", (s for s in samples(drive) if not isinstance(s.message, LaserScan)))
    with pytest.raises(RefusedError, match=f"b.mcap: expected a topic of laser scans .*, found {listed}"):
        open_recording(without)


@pytest.mark.parametrize(
    ("left_out", "named"),
    [("/tf_static", "expected static transforms between .*--calibration"), ("/camera_info", "the camera's calib")],
)
def test_a_bag_without_calibration_says_what_is_missing(drive: Path, tmp_path: Path, left_out: str, named: str) -> None:
    path = write_ours(tmp_path / "a.mcap", (sample for sample in samples(drive) if sample.topic != left_out))
    with pytest.raises(RefusedError, match=f"a.mcap: {named}" if left_out == "/tf_static" else named):
        find_calibration(opened(path), None)


def test_a_calibration_that_cannot_be_is_refused_with_where_it_is_from(drive: Path, tmp_path: Path) -> None:
    blank = [
        sample._replace(message=replace(sample.message, k=[0.0] * 9)) if sample.topic == "/camera_info" else sample
        for sample in samples(drive)
    ]
    with pytest.raises(RefusedError, match=r"a.mcap: /camera_info: camera_info: K: expected .* focal lengths"):
        find_calibration(opened(write_ours(tmp_path / "a.mcap", iter(blank))), None)


@pytest.mark.parametrize("cls", [LaserScan, CompressedImage])
def test_a_message_that_is_damaged_is_refused_by_topic_and_time(drive: Path, tmp_path: Path, cls: type) -> None:
    bad = {LaserScan: {"range_min": -1.0}, CompressedImage: {"data": b"\xff\xd8\xff"}}[cls]
    messages = [
        sample._replace(message=replace(sample.message, **bad)) if isinstance(sample.message, cls) else sample
        for sample in samples(drive)
    ]
    recording = opened(write_ours(tmp_path / "a.mcap", iter(messages)))
    with pytest.raises(RefusedError, match=r"a.mcap: /\S+ at 17000000\d\d\.\d\d\d s: "):
        list(recording.messages())


def test_a_file_without_its_end_is_read_as_far_as_it_goes_with_a_warning(
    drive: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    whole = write_ours(tmp_path / "a.mcap", samples(drive))
    (tmp_path / "b.mcap").write_bytes(whole.read_bytes()[:-1])
    bag = McapBag(tmp_path / "b.mcap")
    assert [record.message for record in caplog.records] == [
        f"{bag.path}: has no end; what is whole is read, and `edgefusion recover` mends it"
    ]
    assert sorted(bag.read()) == sorted(McapBag(whole).read())
    assert bag.topics == McapBag(whole).topics


# rosbags for Python 3.8 leaves files open.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("name", ["a.mcap", "a.bag", "a.db3", "bag/metadata.yaml"])
@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n", b"SQLite format 3\x00", b"{}"])
def test_what_only_looks_like_a_bag_is_refused_by_name(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_bytes(content)
    path = tmp_path / name.split("/")[0]
    with pytest.raises(RefusedError, match=str(path)):
        open_recording(path)


@pytest.mark.parametrize(("module", "extra"), [("mcap", "record"), ("rosbags", "ros")])
def test_a_missing_library_is_refused_with_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, extra: str
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    path = tmp_path / ("a.mcap" if extra == "record" else "a.bag")
    path.write_bytes(b"")
    with pytest.raises(RefusedError, match=re.escape(f"pip install 'edgefusion[{extra}]'")):
        open_recording(path)


def test_a_bag_of_something_else_is_listed(tmp_path: Path) -> None:
    path = write_theirs(tmp_path / "bag", iter([Sample("/chatter", String("hello"), OFFSET_NS)]), "sqlite")
    with pytest.raises(RefusedError, match=re.escape("found /chatter (std_msgs/msg/String, 1)")):
        open_recording(path)


def test_a_rectified_picture_has_the_projection_of_camera_info(drive: Path, tmp_path: Path) -> None:
    def projected(sample: Sample) -> Sample:
        if not isinstance(sample.message, CameraInfo):
            return sample
        p = [500.0, 0.0, 320.0, 0.0, 0.0, 510.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        return sample._replace(message=replace(sample.message, p=p, d=[0.1, 0.0, 0.0, 0.0, 0.0]))

    messages = map(projected, samples(drive, image="/camera/image_rect/compressed"))
    found, _ = find_calibration(opened(write_ours(tmp_path / "a.mcap", messages)), None)
    assert found.K.tolist() == [[500, 0, 320], [0, 510, 240], [0, 0, 1]]
    assert found.distortion == ()
