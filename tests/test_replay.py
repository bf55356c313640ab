# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion replay`: recordings of every kind onto a bus, at any speed, and into the detector, always the same."""

from __future__ import annotations

import hashlib
import json
import math
import re
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Iterator

import cv2
import numpy as np
import pytest

from bag_scenes import KINDS, OFFSET_NS, STAMPER, Sample, samples, write_ours, written_as
from bus_lab import Lab, Sink, until, wait_for_listener
from edgefusion.bus.session import open_client
from edgefusion.bus.tags import SampleTag, read_tag
from edgefusion.bus.topics import ANNOTATED, CAMERA_INFO, IMAGE, INSPECTION, MISSION, SCAN, TF_STATIC, Topic
from edgefusion.cli import build_parser, main
from edgefusion.clock import SimClock
from edgefusion.errors import RefusedError
from edgefusion.messages import Message, ros_name
from edgefusion.messages.cdr import decode, encode
from edgefusion.messages.definitions import definition
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.geometry_msgs import Twist
from edgefusion.messages.sensor_msgs import CompressedImage, Image, LaserScan
from edgefusion.messages.std_msgs import String
from edgefusion.messages.tf2_msgs import TFMessage
from edgefusion.messages.transform import FrameTransform
from edgefusion.recording.folder import FolderRecording
from edgefusion.recording.mcap_bag import McapBag
from edgefusion.recording.mcap_writer import McapWriter
from edgefusion.recording.record_file import RecordFile
from edgefusion.recording.topic_choice import TopicNames
from edgefusion.tools.recording_calibration import find_calibration
from edgefusion.tools.replay_loop import Pace, Stage
from edgefusion.tools.replay_samples import Sample as ReplaySample
from edgefusion.tools.replay_samples import bag_samples, drive_samples, plan
from make_colour_network import save_colour_network
from scene import FRAMES, OBJECTS, write_recording

S = 1_000_000_000


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("replay") / "drive")


@pytest.fixture
def lab() -> Iterator[Lab]:
    with ExitStack() as stack:
        yield Lab(stack)


def bag_of(path: Path, messages: list[Sample]) -> McapBag:
    return McapBag(write_ours(path, iter(messages)))


def test_our_own_topics_go_to_the_bus_as_they_were_recorded_and_commands_do_not(drive: Path, tmp_path: Path) -> None:
    commands = [Sample("/cmd_vel", Twist(), OFFSET_NS + 5)]
    other = [Sample("/mission", String("{}"), OFFSET_NS + 6), Sample("/chatter", String("hello"), OFFSET_NS + 7)]
    recorded = sorted([*samples(drive), *commands, *other], key=lambda sample: sample.log_ns)
    bag = bag_of(tmp_path / "a.mcap", recorded)
    planned = plan(bag, TopicNames())
    assert planned == {
        "/scan": SCAN, "/image/compressed": IMAGE, "/camera_info": CAMERA_INFO, "/tf_static": TF_STATIC,
        "/mission": MISSION,
    }  # fmt: skip
    told = [sample for sample in recorded if sample.topic in planned]
    assert [(f"/{s.topic.name}", s.payload, s.at_ns) for s in bag_samples(bag, planned)] == [
        (topic, encode(message), log_ns) for topic, message, log_ns in told
    ]
    scans_ns = [s.stamp_ns for s in bag_samples(bag, planned) if s.topic is SCAN]
    assert scans_ns == [OFFSET_NS + FolderRecording(drive).scan(i).stamp_ns for i in range(FRAMES)]


def test_topics_of_other_robots_are_those_of_the_bus_by_their_meaning(drive: Path, tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "a.mcap", list(samples(drive, "/robot/base_scan", "/robot/camera/image_raw/compressed")))
    expected = {"/robot/base_scan": SCAN, "/robot/camera/image_raw/compressed": IMAGE}
    expected.update({"/robot/camera/camera_info": CAMERA_INFO, "/tf_static": TF_STATIC})
    assert plan(bag, TopicNames()) == expected


def test_the_topic_that_was_asked_for_takes_the_place_of_that_of_the_same_name(drive: Path, tmp_path: Path) -> None:
    rear = [Sample("/rear", message, log_ns) for topic, message, log_ns in samples(drive) if topic == "/scan"]
    planned = plan(bag_of(tmp_path / "a.mcap", [*samples(drive), *rear]), TopicNames(scan="/rear"))
    assert planned["/rear"] is SCAN and "/scan" not in planned


@pytest.mark.parametrize("camera", ["/image/compressed", None])
def test_pictures_that_are_drawn_over_are_replayed_as_what_they_are(
    drive: Path, tmp_path: Path, camera: str | None
) -> None:
    pictures = [s for s in samples(drive) if s.topic == "/image/compressed"]
    drawn = [s._replace(topic=f"/{name}/compressed") for s in pictures for name in ("annotated", "inspection")]
    rest = [s for s in samples(drive) if s.topic in ("/scan", camera)]
    planned = plan(bag_of(tmp_path / "a.mcap", [*rest, *drawn]), TopicNames())
    expected = {"/scan": SCAN, "/annotated/compressed": ANNOTATED, "/inspection/compressed": INSPECTION}
    assert planned == {**expected, **({} if camera is None else {camera: IMAGE})}


def test_pictures_that_are_drawn_over_are_the_cameras_where_that_was_asked_for(drive: Path, tmp_path: Path) -> None:
    pictures = [s._replace(topic="/annotated/compressed") for s in samples(drive) if s.topic == "/image/compressed"]
    planned = plan(bag_of(tmp_path / "a.mcap", pictures), TopicNames(image="annotated/compressed"))
    assert planned == {"/annotated/compressed": IMAGE}


def test_a_raw_image_becomes_a_jpeg_of_the_same_stamp(tmp_path: Path) -> None:
    pixels = cv2.GaussianBlur(np.random.default_rng(1).integers(0, 256, (48, 64, 3), np.uint8), (15, 15), 0)
    raw = Image(STAMPER.header(7 * S, "camera"), 48, 64, "rgb8", 0, 64 * 3, pixels[..., ::-1].tobytes())
    bag = bag_of(tmp_path / "a.mcap", [Sample("/image_raw", raw, OFFSET_NS)])
    (sample,) = bag_samples(bag, plan(bag, TopicNames()))
    shown = cv2.imdecode(np.frombuffer(decode(CompressedImage, sample.payload).data, np.uint8), cv2.IMREAD_COLOR)
    assert (sample.topic, sample.stamp_ns) == (IMAGE, OFFSET_NS + 7 * S)
    assert decode(CompressedImage, sample.payload).header == raw.header
    assert np.abs(shown.astype(int) - pixels).mean() < 4


def test_a_bag_without_anything_for_the_bus_is_refused_with_what_it_has(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "a.mcap", [Sample("/chatter", String("hello"), OFFSET_NS)])
    with pytest.raises(RefusedError, match=r"a.mcap: expected .*, found /chatter \(std_msgs/msg/String, 1\)"):
        plan(bag, TopicNames())


def test_a_message_that_is_none_is_refused_by_name(drive: Path, tmp_path: Path) -> None:
    path = write_ours(tmp_path / "a.mcap", samples(drive))
    bag = McapBag(path)
    planned = {"/image/compressed": SCAN}
    with pytest.raises(RefusedError, match=r"a.mcap: /image/compressed at \d+\.\d+ s: sensor_msgs/msg/LaserScan: "):
        list(bag_samples(bag, planned))


def test_a_folder_tells_scans_images_and_where_the_sensors_are(drive: Path) -> None:
    recording = FolderRecording(drive)
    told = list(drive_samples(recording, find_calibration(recording, None).calibration))
    assert [sample.topic.name for sample in told] == [
        "tf_static", *["scan", "camera_info", "image/compressed"] * FRAMES,
    ]  # fmt: skip
    scans = [decode(LaserScan, sample.payload) for sample in told if sample.topic is SCAN]
    assert [np.float32(scan.ranges).tolist() for scan in scans] == [
        recording.scan(i).ranges_m.tolist() for i in range(FRAMES)
    ]
    assert [sample.topic.name for sample in drive_samples(recording, None)] == ["scan", "image/compressed"] * FRAMES


def test_latencies_do_not_lead_to_before_1970(drive: Path) -> None:
    recording = FolderRecording(drive)
    calibration = replace(find_calibration(recording, None).calibration, laser_latency_ns=S // 5)
    told = list(drive_samples(recording, calibration))
    scans = [decode(LaserScan, sample.payload).header.stamp for sample in told if sample.topic is SCAN]
    images = [decode(CompressedImage, sample.payload).header.stamp for sample in told if sample.topic is IMAGE]
    assert (scans[0].sec, scans[0].nanosec) == (0, 0)
    assert (images[0].sec, images[0].nanosec) == (0, S // 5)
    assert min(sample.stamp_ns for sample in told) == 0


@pytest.mark.parametrize("speed", [0.5, 1.0, 20.0])
def test_samples_are_as_far_apart_as_they_were_recorded_divided_by_the_speed(speed: float) -> None:
    clock = SimClock(start_ns=77)
    pace = Pace(speed, clock, lambda seconds: clock.advance(round(seconds * 1e9)))
    times_ns = []
    for at_ns in (OFFSET_NS, OFFSET_NS + S, OFFSET_NS + S - 10, OFFSET_NS + 3 * S):
        pace.wait(at_ns)
        times_ns.append(clock() - 77)
    assert times_ns == [0, round(S / speed), round(S / speed), round(3 * S / speed)]


def test_who_is_late_catches_up_and_does_not_wait() -> None:
    clock = SimClock()
    pace = Pace(1.0, clock, lambda seconds: clock.advance(round(seconds * 1e9)))
    pace.wait(0)
    clock.advance(5 * S)  # a slow sample
    for at_ns in (1 * S, 4 * S):
        pace.wait(at_ns)
        assert clock() == 5 * S
    pace.wait(6 * S)
    assert clock() == 6 * S


def test_at_most_speed_nothing_waits() -> None:
    clock = SimClock()
    pace = Pace(math.inf, clock, lambda _: pytest.fail("slept"))
    for at_ns in (0, 100 * S):
        pace.wait(at_ns)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "fast"])
def test_a_speed_that_is_none_is_refused(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        build_parser().parse_args(["replay", "a.mcap", "--speed", text])
    assert f"expected a number above 0, or max, got '{text}'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--labels", "a.txt"], "--labels: is for a model"),
        (["--keys", "keys"], "--keys: is for a bus elsewhere"),
        (["--model", "m", "--speed", "1"], "--speed: is for a bus"),
        (["--model", "m", "--loop", "--wait", "--connect", "tcp/a:1"], "--loop, --wait, --connect: is for a bus"),
        (["--model", "m", "--robot", "rover", "--keys", "k"], "--keys, --robot: is for a bus"),
    ],
)
def test_options_that_would_have_no_part_in_it_are_refused(
    drive: Path, capsys: pytest.CaptureFixture[str], options: list[str], named: str
) -> None:
    assert main(["replay", str(drive), *options]) == 2
    assert f"edgefusion: {named}" in capsys.readouterr().err


@pytest.mark.parametrize("calibrated", [False, True])
def test_a_recording_of_nothing_is_refused_instead_of_played_again_and_again(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], calibrated: bool
) -> None:
    writer = McapWriter(RecordFile.create(tmp_path / "a.mcap"))
    writer.add_channel("/mission", ros_name(String), definition(String))
    writer.close()
    (tmp_path / "a.log").write_text("# nothing\n", encoding="ascii")
    options = ["--calibration", str(drive / "calibration.toml")] if calibrated else []
    for name in ("a.mcap", "a.log"):
        assert main(["replay", str(tmp_path / name), "--loop", *options]) == 2
        assert f"{name}: " in capsys.readouterr().err


def test_who_comes_late_is_told_every_place_that_never_moves(lab: Lab) -> None:
    session, clock = lab.router(), SimClock()
    stage = Stage(session, "robot", [TF_STATIC, MISSION], "replay", clock)

    def put(topic: Topic, message: Message) -> None:
        stage.put(ReplaySample(topic, encode(message), OFFSET_NS, clock()))

    def static(child: str, x: float) -> TFMessage:
        T = np.eye(4)
        T[0, 3] = x
        return from_transforms(0, [FrameTransform("base_link", child, T)], STAMPER)

    for child, x in (("laser", 1.0), ("camera_optical", 2.0), ("laser", 3.0)):
        put(TF_STATIC, static(child, x))
    sink = Sink(session, "robot/tf_static")
    clock.advance(S)
    put(MISSION, String("{}"))
    until(lambda: sink.samples, 30)
    told = [each for payload in sink.payloads() for each in decode(TFMessage, payload).transforms]
    assert [(each.child_frame_id, each.transform.translation.x) for each in told] == [
        ("laser", 3.0), ("camera_optical", 2.0),
    ]  # fmt: skip
    clock.advance(S - 1)
    put(MISSION, String("{}"))
    put(TF_STATIC, static("arm", 4.0))
    until(lambda: len(sink.samples) > 1, 30)
    assert [each.child_frame_id for each in decode(TFMessage, sink.payloads()[1]).transforms] == ["arm"]


@pytest.mark.parametrize("kind", ["ours", "ros1", "folder"])
def test_a_replay_is_on_the_bus_from_beginning_to_end(drive: Path, tmp_path: Path, lab: Lab, kind: str) -> None:
    path = drive if kind == "folder" else written_as(kind, tmp_path, samples(drive))
    session = lab.router()
    scans, images = Sink(session, "robot/scan"), Sink(session, "robot/image/compressed")
    wait_for_listener(lab.client(), "robot/scan")
    assert main(["replay", str(path), "--connect", lab.tcp, "--speed", "4", "--wait"]) == 0
    until(lambda: len(scans.samples) == len(images.samples) == FRAMES)
    tags = [read_tag(SampleTag, sample.attachment.to_bytes()) for sample in scans.samples]
    offset_ns = 0 if kind == "folder" else OFFSET_NS
    assert [tag.stamp_ns - offset_ns for tag in tags] == [
        FolderRecording(drive).scan(i).stamp_ns for i in range(FRAMES)
    ]
    assert {tag.clock.startswith("replay-") for tag in tags} == {True}
    assert [tag.seq for tag in tags] == sorted(tag.seq for tag in tags)


def test_without_connect_it_is_a_bus_of_its_own_that_one_may_join(drive: Path, tmp_path: Path, lab: Lab) -> None:
    config = tmp_path / "robot.toml"
    config.write_text(f'version = 1\n[bus]\nlisten = ["{lab.tcp}"]\nrobot = "rover"\n', encoding="utf-8")
    command = [sys.executable, "-m", "edgefusion.cli", "replay", str(drive), "--config", str(config), "--wait"]
    with subprocess.Popen([*command, "--speed", "max", "--loop"], stderr=subprocess.PIPE) as process:
        try:
            sink = Sink(lab.keep(open_client(lab.tcp, timeout_s=30)), "rover/scan")
            until(lambda: len(sink.samples) > 2 * FRAMES, 30)
        finally:
            process.kill()


def test_where_a_router_is_a_replay_does_not_come_between(drive: Path, tmp_path: Path, lab: Lab) -> None:
    config = tmp_path / "robot.toml"
    config.write_text(f'version = 1\n[bus]\nlisten = ["{lab.tcp}"]\n', encoding="utf-8")
    lab.router()
    args = build_parser().parse_args(["replay", str(drive), "--config", str(config)])
    with pytest.raises(OSError, match="is another router there"):
        args.run(args)


def test_bags_are_recorded_and_replayed_where_the_core_is_not_installed() -> None:
    code = (
        "import sys; sys.modules['edgefusion._core'] = None; sys.modules['onnxruntime'] = None; "
        "import edgefusion.tools.replay_bus, edgefusion.tools.record_loop, edgefusion.recording.recover"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    path = save_colour_network(tmp_path_factory.mktemp("network"), {s.name: s.color for s in OBJECTS})
    return ["--model", str(path), "--labels", str(path.parent / "labels.txt")]


@pytest.mark.parametrize("kind", KINDS)
def test_into_the_detector_it_gives_the_same_bytes_again_and_says_their_checksum(
    drive: Path, model: list[str], tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes], kind: str
) -> None:
    path = written_as(kind, tmp_path, samples(drive))
    runs = []
    for _ in range(2):
        assert main(["replay", str(path), *model]) == 0
        runs.append(capfdbinary.readouterr())
    assert runs[0].out == runs[1].out
    lines = [json.loads(line) for line in runs[0].out.splitlines()]
    assert {line["frame"] for line in lines} == set(range(FRAMES))
    expected = hashlib.sha256(runs[0].out).hexdigest()
    assert f"{path}: {len(lines)} detections, sha256 {expected}" in runs[0].err.decode()


def test_what_is_a_centimetre_nearer_has_another_checksum(
    drive: Path, model: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def nearer(sample: Sample) -> Sample:
        if not isinstance(sample.message, LaserScan):
            return sample
        return sample._replace(message=replace(sample.message, ranges=[r - 0.01 for r in sample.message.ranges]))

    for name, messages in (("a", samples(drive)), ("b", map(nearer, samples(drive)))):
        assert main(["replay", str(write_ours(tmp_path / f"{name}.mcap", messages)), *model]) == 0
    assert len(set(re.findall(r"sha256 (\w{64})", capfd.readouterr().err))) == 2
