# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The vision of a simulated robot: pairs scans and frames, detects, takes pictures, and is late, as on a robot."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Deque, Iterator, Sequence

from edgefusion.config import Config
from edgefusion.navigation.inspection_result import PictureAnswer, PictureRequest
from edgefusion.perception.detector import Detector, StageTimes
from edgefusion.perception.sync import Pair, Synchronizer
from edgefusion.sim.simulation import Simulation
from edgefusion.sim.snapshot import Snapshot
from edgefusion.tools.look_pictures import LookPictures
from edgefusion.tools.measure import owner_of
from edgefusion.types import Detection, Pose2D, Scan

LOOK_NS = 250_000_000
"""The detector takes the first frame after so long, of the camera's 30 a second every eighth; only those are
rendered."""

STANDING_LOOK_NS = 800_000_000
"""While the robot stands before an object: nothing else moves in these worlds, so the next look shows the same."""

LATE_NS = 300_000_000
"""From a frame's stamp until the mission has what was seen in it: 40 ms of exposure and transfer, 160 ms for a frame at
the 6.2 per second of the paper, and a wait of up to 100 ms for the frame before it."""


@dataclass(frozen=True)
class Look:
    """One frame through the detector. number: of the frame in the drive. believed: the base's pose in the world by
    its odometry at the frame's stamp. shot: what the sensors delivered, and the truth. times: the detector's."""

    number: int
    believed: Pose2D
    shot: Snapshot
    detections: list[Detection]
    times: StageTimes


class Vision:
    """Told of scans, it looks at the simulation's frames; what it saw and was asked for arrives LATE_NS after a frame.

    objects: of every picture with the object in it, by the request's id, the thing that most of its beams met.
    """

    def __init__(self, simulation: Simulation, detector: Detector, config: Config, pictures: LookPictures) -> None:
        self._simulation, self._detector, self._pictures = simulation, detector, pictures
        self._sync = Synchronizer(round(config.sync.tolerance_s * 1e9), round(config.sync.horizon_s * 1e9))
        self._same_place_m = config.mission.same_place_m
        self._frame_ns, self._looks = -LOOK_NS, 0  # the newest frame taken, and how many came to a look
        self._late: Deque[Look] = deque()
        self._request: PictureRequest | None = None
        self._answers: list[PictureAnswer] = []
        self.newest_ns: int | None = None
        self.objects: dict[str, str | None] = {}

    @property
    def pairing(self) -> dict[str, int]:
        """How many scans and frames ended how."""
        return self._sync.counts

    def ask(self, request: PictureRequest) -> None:
        """For a picture, of the next frame."""
        self._request = request

    def look(self, scans: Sequence[Scan], standing: bool) -> Iterator[Look]:
        """What came since the last time, as far as it is paired."""
        for pair in self._pairs(scans, STANDING_LOOK_NS if standing else LOOK_NS):
            look = self._detect(pair)
            self._late.append(look)
            if self._request is not None and pair.frame.stamp_ns >= self._request.stamp_ns:
                self._answers.append(self._picture(self._request, look))
                self._request = None
            yield look

    def arrived(self, now_ns: int) -> tuple[list[Detection], list[PictureAnswer]]:
        """What reaches the mission now, each once. newest_ns: the stamp of the frame that it is from."""
        detections: list[Detection] = []
        while self._late and self._late[0].shot.frame.stamp_ns + LATE_NS <= now_ns:
            look = self._late.popleft()
            self.newest_ns = look.shot.frame.stamp_ns
            detections += look.detections
        answers = [answer for answer in self._answers if answer.stamp_ns + LATE_NS <= now_ns]
        self._answers = [answer for answer in self._answers if answer.stamp_ns + LATE_NS > now_ns]
        return detections, answers

    def _pairs(self, scans: Sequence[Scan], period_ns: int) -> list[Pair]:
        pairs = [pair for scan in scans for pair in self._sync.add_scan(scan)]
        for stamp_ns in self._simulation.frame_stamps(self._frame_ns):
            due_ns = self._frame_ns + period_ns
            if self._request is not None and self._frame_ns < self._request.stamp_ns:
                due_ns = min(due_ns, self._request.stamp_ns)
            if stamp_ns >= due_ns:
                self._frame_ns = stamp_ns
                pairs += self._sync.add_frame(self._simulation.frame(stamp_ns))
        return pairs

    def _detect(self, pair: Pair) -> Look:
        simulation, (scan, frame) = self._simulation, pair
        before, now = simulation.odometry_at(scan.stamp_ns), simulation.odometry_at(frame.stamp_ns)
        motion = now.relative_to(before)
        detections = self._detector.detect(scan, frame, motion)
        shot = Snapshot(
            scan=scan,
            frame=frame,
            motion=motion,
            owners=simulation.owners(scan.stamp_ns),
            truth=tuple(simulation.truth(scan.stamp_ns, frame.stamp_ns)),
        )
        self._looks += 1
        believed = simulation.world.world.start.compose(now)
        return Look(self._looks - 1, believed, shot, detections, self._detector.times)

    def _picture(self, request: PictureRequest, look: Look) -> PictureAnswer:
        """With the object's box where it was seen in it, and without one where it was not."""
        odometry = self._simulation.odometry_at(look.shot.frame.stamp_ns)
        shown = [each for each in look.detections if self._is_asked_for(each, request, odometry)][:1]
        image = self._pictures.camera(look.shot, shown)
        if not shown:
            return PictureAnswer(request.id, look.shot.frame.stamp_ns, image)
        owner = owner_of(look.shot, shown[0])
        self.objects[request.id] = self._simulation.world.world.things[owner].name if owner >= 0 else None
        return PictureAnswer(request.id, look.shot.frame.stamp_ns, image, shown[0])

    def _is_asked_for(self, detection: Detection, request: PictureRequest, odometry: Pose2D) -> bool:
        place, (x_m, y_m) = odometry.compose(Pose2D(*detection.position_m)), request.place_m
        named = detection.label == request.label or (detection.group != "" and detection.group == request.group)
        return named and math.hypot(place.x_m - x_m, place.y_m - y_m) <= self._same_place_m
