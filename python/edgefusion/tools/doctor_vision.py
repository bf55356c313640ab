# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Whether the model is intact and runs where it shall, and whether the calibration fits the camera and the base."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Iterator, List

from edgefusion.errors import RefusedError
from edgefusion.perception.calibration import Calibration, load_calibration
from edgefusion.perception.classifier import Classifier, open_classifier
from edgefusion.perception.groups import LabelGroups
from edgefusion.perception.runtime_options import runtime_options
from edgefusion.tools.doctor_finding import Examination, Finding, State
from edgefusion.types import Pose2D

_OFF_M, _OFF_RAD = 0.02, math.radians(2)
"""So far apart configuration and calibration may place the laser: rulers and protractors are no better."""


def check_model(exam: Examination) -> Iterator[Finding]:
    """Its files, its golden answer on the provider, and whether it knows what the mission looks for."""
    vision = exam.config.vision
    if not exam.runs("vision"):
        yield Finding("model", State.SKIPPED, exam.why_no_vision())
        return
    try:
        classifier = open_classifier(Path(str(vision.model)), options=runtime_options(vision))
    except RefusedError as error:
        yield Finding("model", State.FAILED, str(error), "`edgefusion model check` it, or copy it anew: docs/models.md")
        return
    yield _provider(str(vision.model), classifier)
    yield from _interest(exam, classifier)


def _provider(model: str, classifier: Classifier) -> Finding:
    text = f"{model}: {len(classifier.labels)} labels, on {classifier.provider}"
    if classifier.golden_difference is not None:
        text += f", its golden answer is within {classifier.golden_difference:.2g}"
    if classifier.provider_note:
        cure = "install ONNX Runtime for it, or set [vision] provider to what there is"
        return Finding("model", State.WARNING, f"{text}; {classifier.provider_note}", cure)
    return Finding("model", State.OK, text)


def _interest(exam: Examination, classifier: Classifier) -> Iterator[Finding]:
    groups = exam.config.vision.groups
    try:
        known = LabelGroups.load(None if groups is None else Path(groups))
        for name in exam.config.mission.interest:
            known.labels_of(name, classifier.labels)
    except RefusedError as error:
        cure = "set [mission] interest to labels or groups of this model, or to [], or [vision] groups"
        yield Finding("model", State.FAILED, f"[mission] interest: {error}", cure)


def check_calibration(exam: Examination) -> Iterator[Finding]:
    """Whether it can be, and whether it is of this camera and this base."""
    if not exam.runs("vision"):
        yield Finding("calibration", State.SKIPPED, exam.why_no_vision())
        return
    path = str(exam.config.vision.calibration)
    try:
        calibration = load_calibration(Path(path))
    except RefusedError as error:
        yield Finding("calibration", State.FAILED, str(error), "mend the file: docs/calibration.md")
        return
    problems = list(_misfits(exam, path, calibration))
    width, height = calibration.image_size
    text = f"{path}: for pictures of {width}x{height}, the laser {calibration.laser_height_m:g} m above the ground"
    yield from problems or [Finding("calibration", State.OK, text)]


def _misfits(exam: Examination, path: str, calibration: Calibration) -> List[Finding]:
    found = []
    expected, got = calibration.image_size, exam.picture_size
    if got is not None and got != expected:
        text = f"{path}: for pictures of {expected[0]}x{expected[1]}, the camera gives {got[0]}x{got[1]}"
        found.append(Finding("calibration", State.FAILED, text, "set [camera] width and height, or calibrate anew"))
    there, T = Pose2D(*exam.config.base.laser_pose), calibration.T_base_laser
    here = Pose2D(float(T[0, 3]), float(T[1, 3]), math.atan2(T[1, 0], T[0, 0]))
    between = here.relative_to(there)
    if math.hypot(between.x_m, between.y_m) > _OFF_M or abs(between.theta) > _OFF_RAD:
        text = f"{path}: the laser is at {_at(here)} by T_base_laser, and at {_at(there)} by [base] laser_pose"
        found.append(Finding("calibration", State.WARNING, text, "measure it, and say the same in both"))
    return found


def _at(pose: Pose2D) -> str:
    return f"({pose.x_m:.2f}, {pose.y_m:.2f}) m, {math.degrees(pose.theta):.0f} degrees"
