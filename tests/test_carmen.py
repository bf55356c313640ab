# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from edgefusion.errors import RefusedError
from edgefusion.recording.carmen import PERIOD_NS, read_carmen

POSE = "1.5 0 0 1.5 0 0 1.1e+09 robot 1.1e+09"


def flaser(ranges: list[str], beams: object = None, pose: str = POSE) -> str:
    return f"FLASER {len(ranges) if beams is None else beams} {' '.join(ranges)} {pose}\n"


def written(folder: Path, *lines: str, name: str = "drive.log") -> Path:
    path = folder / name
    text = "".join(lines).encode()
    path.write_bytes(gzip.compress(text) if name.endswith(".gz") else text)
    return path


@pytest.mark.parametrize("name", ["drive.log", "drive.log.gz"])
def test_plain_and_gzipped_logs_read_alike(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, "# comment\nODOM 1 2 3\n", flaser(["2.5"] * 361), flaser(["3.5"] * 181), name=name)
    half_degree, degree = read_carmen(path)
    assert (half_degree.ranges_m == 2.5).all() and len(half_degree.ranges_m) == 361
    assert (degree.ranges_m == 3.5).all() and len(degree.ranges_m) == 181


def test_the_beams_go_from_right_to_left(tmp_path: Path) -> None:
    (scan,) = read_carmen(written(tmp_path, flaser(["1"] * 361)))
    assert scan.angles[0] == -math.pi / 2
    assert scan.angles[180] == pytest.approx(0, abs=1e-12)
    assert scan.angles[360] == pytest.approx(math.pi / 2)


def test_stamps_count_the_scans_since_the_logged_time_is_useless(tmp_path: Path) -> None:
    scans = read_carmen(written(tmp_path, flaser(["1"] * 361), "ODOM\n", flaser(["1"] * 361)))
    assert [scan.stamp_ns for scan in scans] == [0, PERIOD_NS]


def test_what_never_came_back_is_infinitely_far(tmp_path: Path) -> None:
    (scan,) = read_carmen(written(tmp_path, flaser(["81.91", "81.83", "51.12", "51.36", "79.34"] + ["1"] * 356)))
    assert np.isinf(scan.ranges_m[:3]).all()
    assert np.isfinite(scan.ranges_m[3:]).all()


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        (flaser(["1"] * 360), "expected 181 or 361 beams, got 360"),
        (flaser(["1"] * 360, beams=361), "expected 372 fields for 361 beams, got 371"),
        (flaser(["1"] * 361, pose="1 2"), "expected 372 fields for 361 beams, got 365"),
        (flaser(["1"] * 361, beams="many"), "invalid literal for int"),
        (flaser(["far"] + ["1"] * 360), "could not convert string to float"),
        (flaser(["1", "-2.5"] + ["1"] * 359), "expected ranges of 0 m and more, got -2.5 for beam 1"),
        (flaser(["nan"] + ["1"] * 360), "expected ranges of 0 m and more, got nan for beam 0"),
        ("FLASER \n", "expected the number of beams, got nothing"),
    ],
)
def test_a_malformed_line_is_refused_by_file_and_line(tmp_path: Path, line: str, complaint: str) -> None:
    path = written(tmp_path, "# comment\n", flaser(["1"] * 361), line)
    with pytest.raises(RefusedError, match=complaint) as refusal:
        list(read_carmen(path))
    assert str(refusal.value).startswith(f"{path}:3: ")


@pytest.mark.parametrize("keep", [5, 60, 200])
def test_a_cut_off_gzip_file_is_refused(tmp_path: Path, keep: int) -> None:
    random = np.random.default_rng(0)
    path = written(tmp_path, flaser([f"{r:.2f}" for r in random.uniform(0, 50, 361)]), name="drive.log.gz")
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(RefusedError, match="expected a whole gzip file"):
        list(read_carmen(path))


def test_something_else_named_gz_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "drive.log.gz"
    path.write_bytes(b"not a gzip file")
    with pytest.raises(RefusedError, match="expected a whole gzip file"):
        list(read_carmen(path))


@pytest.mark.parametrize("name", ["none.log", "none.log.gz"])
def test_a_log_that_is_not_there_is_refused_by_name(tmp_path: Path, name: str) -> None:
    with pytest.raises(RefusedError, match=f"{name}: cannot be read: No such file"):
        list(read_carmen(tmp_path / name))


@pytest.mark.parametrize(("log", "scans"), [("belgioioso", 395), ("csail", 406)])
def test_real_logs_read_whole(shared_data: Path, log: str, scans: int) -> None:
    read = list(read_carmen(shared_data / "carmen" / f"{log}-corrected.log.gz"))
    assert len(read) == scans
    assert all(len(scan.ranges_m) == 361 for scan in read)
    assert max(scan.ranges_m[np.isfinite(scan.ranges_m)].max() for scan in read) < 80
