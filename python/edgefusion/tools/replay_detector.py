# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What `edgefusion replay` does with a model: detections as lines, and a checksum of them."""

from __future__ import annotations

import argparse
import hashlib
import sys

from tqdm import tqdm

from edgefusion.clock import system_clock
from edgefusion.config import load_config
from edgefusion.perception.classifier import open_classifier
from edgefusion.perception.detector import Detector
from edgefusion.perception.groups import LabelGroups
from edgefusion.recording.detections import to_json_line
from edgefusion.tools.recording_calibration import find_calibration
from edgefusion.tools.recording_options import open_asked
from edgefusion.tools.run_recording import CapturedTogether, check_size


def detect_lines(args: argparse.Namespace) -> int:
    """Writes a line for every detection to standard output. Raises RefusedError.

    No clock has a part in it: the same recording, model and configuration give the same bytes.
    """
    config, recording = load_config(args.config), open_asked(args)
    calibration, _ = find_calibration(recording, args.calibration)
    classifier = open_classifier(args.model, labels=args.labels)
    detector = Detector(classifier, calibration, config.perception, LabelGroups.load(None), system_clock)
    pairs = CapturedTogether(recording, calibration, config.sync)
    checksum, count = hashlib.sha256(), 0
    for index, pair in tqdm(pairs, total=recording.frames, unit="frame", disable=None, file=sys.stderr):
        check_size(recording, index, pair.frame, calibration)
        for detection in detector.detect(pair.scan, pair.frame):
            line = to_json_line(index, detection)
            checksum.update(line)
            sys.stdout.buffer.write(line)
            count += 1
    pairs.check_any()
    print(f"{args.recording}: {count} detections, sha256 {checksum.hexdigest()}", file=sys.stderr)
    return 0
