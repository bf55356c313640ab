# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What the base tells on the bus: told of every step of its loop, it publishes what is due and wanted."""

from __future__ import annotations

from typing import Callable, List, Mapping, Sequence

import zenoh

from edgefusion.bus import topics
from edgefusion.bus.publisher import Publisher
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import Topic
from edgefusion.config import BusConfig
from edgefusion.messages.frames import LASER
from edgefusion.messages.from_battery import from_battery
from edgefusion.messages.from_healths import from_healths
from edgefusion.messages.from_mission import from_mission
from edgefusion.messages.from_odometry import from_odometry
from edgefusion.messages.from_path import from_path
from edgefusion.messages.from_scan import from_scan
from edgefusion.messages.from_transforms import from_transforms
from edgefusion.messages.stamps import Stamper
from edgefusion.messages.transform import FrameTransform, robot_transform
from edgefusion.service.base_inputs import Outputs
from edgefusion.service.base_inspections import InspectionOutlet
from edgefusion.service.base_reports import COMPONENT, base_health, mission_report, way_poses
from edgefusion.service.instant_scans import InstantScans
from edgefusion.service.on_change import OnChange
from edgefusion.types import Health, Scan

STATIC_HZ = 1.0

Figures = Callable[[], Mapping[str, str]]


class BaseOutlet:
    """For one thread, and not the loop's. mounting: of the sensors, which never moves. clock_id: whose stamps it says.

    figures: what there is to say of the base, each with its unit, as it is now.
    """

    def __init__(
        self,
        session: zenoh.Session,
        config: BusConfig,
        mounting: Sequence[FrameTransform],
        clock_id: str,
        stamper: Stamper,
        figures: Figures,
    ) -> None:
        self._stamper, self._figures, self._mounting = stamper, figures, mounting
        tagger = Tagger()

        def publisher(topic: Topic, max_hz: float = 1e9) -> Publisher:
            return Publisher(session, config.robot, topic, tagger, clock_id, max_hz)

        self._scan, self._path, self._mission = map(publisher, (topics.SCAN, topics.PATH, topics.MISSION))
        self._odom, self._tf = publisher(topics.ODOM, config.pose_hz), publisher(topics.TF, config.pose_hz)
        self._tf_static = publisher(topics.TF_STATIC, STATIC_HZ)
        self._battery, self._diagnostics = publisher(topics.BATTERY, config.state_hz), publisher(topics.DIAGNOSTICS)
        self._inspections = InspectionOutlet(publisher, stamper)
        (T_base_laser,) = (each.T_parent_child for each in mounting if each.child == LASER)
        self._scans = InstantScans(T_base_laser)
        period_ns = round(1e9 / config.state_hz)
        self._mission_change, self._health_change = OnChange(period_ns), OnChange(period_ns)
        self._state_ns = 0

    def tell(self, outputs: Outputs) -> None:
        """Publishes what is due of a step, the steps in their order."""
        self._tell_place(outputs)
        self._tell_mission(outputs)
        self._tell_healths(outputs)
        self._inspections.tell(outputs)

    def tell_scan(self, scan: Scan) -> None:
        """Publishes a scan: at once, since who pairs frames with scans waits for them."""
        if self._scan.wanted(scan.stamp_ns):
            told = self._scans.of(scan)
            if told is not None:
                self._scan.put(from_scan(told, self._stamper), told.stamp_ns)

    def _tell_place(self, outputs: Outputs) -> None:
        """Where the robot is by its newest report, whose stamp that is."""
        now_ns, state = outputs.stamp_ns, outputs.robot
        if self._tf_static.wanted(now_ns):
            self._tf_static.put(from_transforms(now_ns, self._mounting, self._stamper), now_ns)
        if state is None or state.stamp_ns == self._state_ns:
            return
        self._state_ns = stamp_ns = state.stamp_ns
        self._scans.reported(state)
        if self._odom.wanted(now_ns):
            self._odom.put(from_odometry(stamp_ns, state.odometry, state.twist, self._stamper), stamp_ns)
        if self._tf.wanted(now_ns):
            self._tf.put(from_transforms(stamp_ns, [robot_transform(state.odometry)], self._stamper), stamp_ns)
        if self._battery.wanted(now_ns):
            self._battery.put(from_battery(stamp_ns, state.battery_v, self._stamper, state.charging), stamp_ns)

    def _tell_mission(self, outputs: Outputs) -> None:
        now_ns, way_m = outputs.stamp_ns, outputs.way_m
        if way_m is not None and self._path.wanted(now_ns):
            self._path.put(from_path(now_ns, way_poses(way_m), self._stamper), now_ns)
        report = mission_report(outputs)
        goal = report.goal_id, report.goal_m
        what = report.state, report.reason, goal, report.paused, report.note, report.result
        if self._mission_change.due(now_ns, what) and self._mission.wanted(now_ns):
            self._mission.put(from_mission(report), now_ns)

    def _tell_healths(self, outputs: Outputs) -> None:
        now_ns, healths = outputs.stamp_ns, self._healths(outputs)
        if self._health_change.due(now_ns, tuple(healths)) and self._diagnostics.wanted(now_ns):
            figures = {COMPONENT: self._figures()}
            self._diagnostics.put(from_healths(now_ns, healths, self._stamper, figures), now_ns)

    def _healths(self, outputs: Outputs) -> List[Health]:
        """Of a component that failed and is well again, how it is now."""
        newest = {health.component: health for health in reversed(outputs.healths)}
        return [*newest.values(), base_health(outputs)]
