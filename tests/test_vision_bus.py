# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Vision on a real bus: what it says to whom, and what it is told."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any, Callable, Dict

import numpy as np
import pytest

from bus_lab import Sink, until
from edgefusion.bus import topics
from edgefusion.bus.healths import Healths
from edgefusion.bus.liveliness import Alive
from edgefusion.clock import system_clock
from edgefusion.config import PerceptionConfig
from edgefusion.messages import from_image
from edgefusion.messages.cdr import decode
from edgefusion.messages.picture_exchange import PictureRequestDetail, from_picture_exchange
from edgefusion.messages.pictures import decode_picture, encode_jpeg
from edgefusion.messages.sensor_msgs import CameraInfo, CompressedImage
from edgefusion.messages.to_detections_detail import to_detections_detail
from edgefusion.messages.vision_msgs import Detection2DArray
from edgefusion.perception.detector import Detector
from edgefusion.service.picture_exchange import picture_answer
from edgefusion.types import Health, HealthState
from make_colour_network import open_colour_network
from scene import HEIGHT, OBJECTS, WIDTH
from vision_lab import LOST, VisionLab
from vision_scenes import ToldDetector

COLOURS = {solid.name: solid.color for solid in OBJECTS}
NAMES = set(COLOURS)


@pytest.fixture(scope="module")
def classifier(tmp_path_factory):
    return open_colour_network(tmp_path_factory.mktemp("network"), COLOURS)


@pytest.fixture
def vision_lab(tmp_path, classifier) -> Any:
    with ExitStack() as stack:

        def lab(make_detector: Callable[[Any], Any] | None = None, **bus: object) -> VisionLab:
            def real(calibration: Any) -> Detector:
                return Detector(classifier, calibration, PerceptionConfig(max_object_width_m=1.2))

            return VisionLab(stack, tmp_path, make_detector or real, **bus)

        yield lab


def healths(lab: VisionLab) -> Callable[[], Dict[str, Health]]:
    heard = Healths(lab.laptop, "robot", system_clock)
    return lambda: {report.health.component: report.health for report in heard.reports}


def test_what_the_camera_sees_is_named_and_measured_on_the_bus(vision_lab) -> None:
    lab = vision_lab()
    detail = lab.hear(topics.DETECTIONS_DETAIL, to_detections_detail)
    array = lab.hear(topics.DETECTIONS, lambda message: message)
    lab.until(lambda: detail.value and array.value)
    found, boxes = detail.value, array.value  # each once: the next may come at any time
    assert {detection.label for detection in found.detections} == NAMES
    assert isinstance(boxes, Detection2DArray)
    assert {each.results[0].hypothesis.class_id for each in boxes.detections} == NAMES
    assert found.stamp_ns == found.detections[0].stamp_ns


def test_scans_of_another_clock_are_refused_and_the_states_say_so(vision_lab) -> None:
    lab = vision_lab()
    lab.base.clock = "another-boot"
    detail, states = lab.hear(topics.DETECTIONS_DETAIL, to_detections_detail), healths(lab)
    health = lab.until(lambda: next((h for h in states().values() if "SCANS_REFUSED" in h.reason), None))
    assert (health.component, health.state) == ("detector", HealthState.FAILED)
    assert "got one of another-boot" in health.reason
    assert detail.value is None


def test_images_are_made_only_while_somebody_listens_and_hold_the_frame(vision_lab, monkeypatch) -> None:
    made = []

    def counted(image: Any, quality: int) -> bytes:
        made.append(quality)
        return encode_jpeg(image, quality)

    monkeypatch.setattr(from_image, "encode_jpeg", counted)
    lab = vision_lab(lambda _: ToldDetector(), image_hz=50.0, jpeg_quality=61)
    states = healths(lab)
    lab.until(lambda: states().get("detector", LOST).state is HealthState.OK)
    assert not made
    image, info = lab.hear(topics.IMAGE, lambda message: message), lab.hear(topics.CAMERA_INFO, lambda message: message)
    lab.until(lambda: image.value and info.value)
    assert set(made) == {61}
    assert isinstance(image.value, CompressedImage)
    assert decode_picture(bytes(image.value.data)).shape == (HEIGHT, WIDTH, 3)
    assert isinstance(info.value, CameraInfo)
    assert (info.value.width, info.value.height) == (WIDTH, HEIGHT)


def test_every_image_has_a_camera_info_of_its_stamp_whenever_who_wants_them_came(vision_lab) -> None:
    lab = vision_lab(lambda _: ToldDetector())
    infos = Sink(lab.laptop, "robot/camera_info")
    lab.until(lambda: infos.samples)
    images = Sink(lab.laptop, "robot/image/compressed")

    def stamps(sink: Sink, kind: Any) -> list[Any]:
        return [decode(kind, payload).header.stamp for payload in sink.payloads()]

    lab.until(lambda: len(images.samples) > 5)
    wanted = stamps(images, CompressedImage)
    lab.until(lambda: all(stamp in stamps(infos, CameraInfo) for stamp in wanted))


def test_the_annotated_image_has_the_boxes_and_the_clusters_have_their_points(vision_lab) -> None:
    lab = vision_lab()
    annotated, clusters = (lab.hear(topic, lambda message: message) for topic in (topics.ANNOTATED, topics.CLUSTERS))
    lab.until(lambda: annotated.value and clusters.value)
    shown = decode_picture(bytes(annotated.value.data))
    assert np.abs(shown.astype(int) - lab.camera.latest(1.0).image).max() > 100
    assert len(clusters.value.markers) > len(OBJECTS)


def test_base_is_answered_with_a_picture_of_what_it_asked_for_and_what_was_seen_in_it(vision_lab) -> None:
    lab = vision_lab()
    detail = lab.hear(topics.DETECTIONS_DETAIL, to_detections_detail)
    lab.until(lambda: detail.value)
    post = next(each for each in detail.value.detections if each.label == "post")
    now_ns = system_clock()
    place_m = 1.0 + post.position_m[0], 2.0 + post.position_m[1]  # where the base says that it is
    request = from_picture_exchange(
        PictureRequestDetail(
            id="inspection-7", label="post", group="", place_m=place_m, stamp_ns=now_ns,
            deadline_ns=now_ns + 20_000_000_000,
        )
    )  # fmt: skip
    answer = lab.hear(topics.INSPECTION_ANSWER, picture_answer)

    def answered() -> bool:
        lab.base.put(topics.INSPECTION_REQUEST, request, now_ns)
        return answer.value is not None

    lab.until(answered)
    assert answer.value.request_id == "inspection-7"
    assert answer.value.detection.label == "post"
    assert answer.value.stamp_ns >= now_ns
    assert decode_picture(answer.value.image).shape == (HEIGHT, WIDTH, 3)


def test_a_gpu_that_is_lost_is_said_while_the_cpu_goes_on(vision_lab) -> None:
    lab = vision_lab()
    states = healths(lab)
    lab.until(lambda: states().get("detector", LOST).state is HealthState.OK)
    lab.note = "cuda failed, cpu has taken over: CUDA failure 719"
    health = lab.until(lambda: next((h for h in states().values() if h.state is HealthState.DEGRADED), None))
    assert (health.component, health.reason) == ("detector", lab.note)
    detail = lab.hear(topics.DETECTIONS_DETAIL, to_detections_detail)
    lab.until(lambda: detail.value)


def test_a_camera_that_is_lost_is_said_also_while_the_detector_is_at_work(vision_lab) -> None:
    detector = ToldDetector()
    lab = vision_lab(lambda _: detector)
    states, said = healths(lab), []
    lab.until(lambda: states().get("detector", LOST).state is HealthState.OK)

    def lose() -> None:
        lab.camera.says = LOST
        until(lambda: states()["camera"] == LOST)
        said.append(True)

    detector.meanwhile = lose
    lab.until(lambda: said)


def test_scans_that_show_nothing_drop_boxes_and_stop_nothing(vision_lab) -> None:
    lab = vision_lab()
    detail = lab.hear(topics.DETECTIONS_DETAIL, to_detections_detail)
    good = lab.base.scan
    for ranges_m in (np.full(361, np.nan), np.full(361, np.inf), np.zeros(361), np.full(361, 1e-6), np.ones(1)):
        lab.base.scan = type(good)(1, ranges_m.astype(np.float32), good.angle_min, good.angle_increment)
        lab.go_on(0.25)
    lab.base.scan = good
    lab.until(lambda: detail.value and {each.label for each in detail.value.detections} == NAMES)


def test_it_goes_on_when_the_router_comes_back(vision_lab) -> None:
    lab = vision_lab(lambda _: ToldDetector())
    sink = Sink(lab.laptop, "robot/detections/detail")
    lab.until(lambda: sink.samples)
    lab.router.close()
    lab.go_on(0.2)
    lab.lab.router()
    before = len(sink.samples)
    lab.until(lambda: len(sink.samples) > before)


def test_it_is_alive_on_the_bus(vision_lab) -> None:
    lab = vision_lab(lambda _: ToldDetector())
    alive = Alive(lab.laptop, "robot")
    lab.until(lambda: "vision" in alive.components)
