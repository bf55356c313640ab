# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The robot of the demo: a Pioneer 3-DX with sensors, a detector, and what it is interested in."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

from edgefusion.config import Config, MissionConfig
from edgefusion.perception.calibration import Calibration
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.perception.groups import LabelGroups
from edgefusion.sim.built_world import BuiltWorld
from edgefusion.sim.renderer import Renderer
from edgefusion.sim.rig import Rig
from edgefusion.sim.robot import BaseSpec
from edgefusion.sim.simulation import Simulation
from edgefusion.tools.drive import Drive, Pacing
from edgefusion.tools.geometry import calibration_of
from edgefusion.tools.look_pictures import LookPictures

BASE = BaseSpec(slip_m=0.002, left_drift_percent=0.1)
"""A base whose odometry is off by one to four percent of its way in the end, as that of one in use is."""

NEAR_M = 2.5
"""Objects are inspected from no farther: the picture shall show more than a trolley with something on it, and the
laboratory's second oscilloscope, by the wall, is none that the robot comes upon on its way."""


@dataclass(frozen=True)
class DemoRobot:
    """What is the same for every drive."""

    rig: Rig
    config: Config
    calibration: Calibration
    detector: Detector
    pictures: LookPictures

    def drive(self, world: BuiltWorld, renderer: Renderer, seed: int, pace: Pacing) -> Drive:
        """A drive through a world, from its start to its goal."""
        simulation = Simulation(world, self.rig, renderer, seed, BASE)
        return Drive(simulation, self.detector, self.pictures, self.config, pace)


def demo_robot(model: Path, interest: Sequence[str]) -> DemoRobot:
    """interest: labels and groups that it inspects, none: it only drives. Raises RefusedError, with the names that come
    closest, for what the model cannot answer."""
    classifier, groups = open_classifier(model), LabelGroups.load()
    for name in interest:
        groups.labels_of(name, classifier.labels)
    rig, config = Rig(), Config(mission=MissionConfig(interest=tuple(interest), max_distance_m=NEAR_M))
    calibration = calibration_of(rig)
    detector = Detector(classifier, calibration, config.perception, groups)
    return DemoRobot(rig, config, calibration, detector, LookPictures(calibration, config.perception))
