# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion laser`, as a user starts it, on a simulated scanner's port."""

from __future__ import annotations

import fcntl
import json
import math
import os
import re
import struct
import subprocess
import sys
import termios
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import cv2
import numpy as np
import pytest

from edgefusion.cli import main
from edgefusion.sim.fault_frames import LMS
from edgefusion.sim.fault_wire import FaultyWire
from edgefusion.sim.faults import parse_fault
from edgefusion.sim.laser import LaserSpec, SimLaser
from edgefusion.sim.lms_scanner import LmsScanner
from edgefusion.sim.wire_pty import PtyWire
from edgefusion.sim.wire_server import WireServer
from edgefusion.tools.scan_plot import ROWS, scan_lines
from edgefusion.types import Pose2D, Scan

COLUMNS = 4 * ROWS
DRAWN = b"\x1b[J"  # ends each drawing
ROOM = np.array([[3, -3, 3, 3], [3, 3, -3, 3], [-3, 3, -3, -3], [-3, -3, 3, -3]], float)


@contextmanager
def scanner(fault: str = "laser=stuck", **how):
    """A simulated scanner in a room of 6 m, on a port; the event injects the fault."""
    rng = np.random.default_rng(0)

    def scan_at(stamp_ns: int, spec: LaserSpec) -> Scan:
        return SimLaser(spec).scan(stamp_ns, ROOM, lambda ns: Pose2D(), rng)[0]

    wire, over = PtyWire(), threading.Event()
    device, stuck = LmsScanner(scan_at, time.monotonic_ns(), **how), threading.Event()
    server = WireServer([(device, (wire,))])

    def pump() -> None:
        is_stuck = False
        while not over.is_set():
            if stuck.is_set() and not is_stuck:
                is_stuck = True
                server.replace(0, FaultyWire(device, LMS, parse_fault(fault), rng, time.monotonic_ns()))
            server.pump(time.monotonic_ns())
            over.wait(0.002)

    thread = threading.Thread(target=pump)
    thread.start()
    try:
        yield wire.name, stuck
    finally:
        over.set()
        thread.join()
        wire.close()


def said(*options: object) -> str:
    command = [sys.executable, "-m", "edgefusion.cli", "laser", *map(str, options)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    return done.stdout


def test_it_says_what_is_connected_and_what_it_sees(tmp_path: Path) -> None:
    with scanner(left_at=38400) as (port, _):
        lines = said(port, "--once", "--png", tmp_path / "scan.png").splitlines()
    assert lines[:4] == [
        "type:    LMS200;301063;V02.10",
        "speed:   38400 baud",
        "scan:    180 degrees, every 0.5",
        "ranges:  measuring mode 0, in mm",
    ]
    assert lines[4] == "health:  ok" and "361 beams" in lines[-1] and "nearest 2.9" in lines[-1]
    picture = cv2.imread(str(tmp_path / "scan.png"))
    assert picture is not None and (picture != 255).any()


def test_with_a_picture_as_json_each_line_is_still_a_scan(tmp_path: Path, capsys) -> None:
    with scanner() as (port, _):
        assert main(["laser", port, "--once", "--json", "--png", str(tmp_path / "scan.png")]) == 0
    told = capsys.readouterr()
    assert len(json.loads(told.out)["ranges_m"]) == 361
    assert "scan.png" in told.err and (tmp_path / "scan.png").exists()


def test_once_without_a_scan_is_exit_code_1(capsys) -> None:
    with scanner() as (port, _):
        assert main(["laser", port, "--once", "--seconds", "0.001"]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "health:  ok"


def test_as_json_each_scan_is_a_line() -> None:
    command = [sys.executable, "-m", "edgefusion.cli", "laser", "--json", "--baudrate", "500000", "--beams", "181"]
    with scanner() as (port, _), subprocess.Popen([*command, port], stdout=subprocess.PIPE, text=True) as process:
        scans = [json.loads(process.stdout.readline()) for _ in range(11)]
        process.terminate()
        process.stdout.read()
    assert process.returncode == 0 and all(len(scan["ranges_m"]) == 181 for scan in scans)
    assert scans[0]["ranges_m"][90] == pytest.approx(3.0, abs=0.1) or scans[0]["ranges_m"][90] == "nan"
    assert sorted(scan["stamp_ns"] for scan in scans) == [scan["stamp_ns"] for scan in scans]


def test_a_port_that_is_held_is_refused_with_the_holders_name() -> None:
    with scanner() as (port, _):
        holder = subprocess.Popen(
            [sys.executable, "-m", "edgefusion.cli", "laser", port, "--json"], stdout=subprocess.PIPE, text=True
        )
        with holder:
            assert holder.stdout is not None and holder.stdout.readline()
            second = subprocess.run(
                [sys.executable, "-m", "edgefusion.cli", "laser", port], capture_output=True, text=True, check=False
            )
            holder.terminate()
    assert second.returncode == 2
    assert f"{port}: expected a free port, it is held by edgefusion laser (pid {holder.pid})" in second.stderr


def test_scans_that_are_not_to_be_believed_are_not_shown_and_it_says_why() -> None:
    command = [sys.executable, "-m", "edgefusion.cli", "laser", "--json"]
    with scanner() as (port, stuck):
        process = subprocess.Popen([*command, port], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        with process:
            first = json.loads(process.stdout.readline())
            stuck.set()
            said = process.stderr.readline()
            process.terminate()
            process.stdout.read()
    assert first["health"] == "ok" and said.startswith("health:  failed: ") and process.returncode == 0


def test_a_scanner_that_was_lost_is_found_again_and_both_are_said() -> None:
    command = [sys.executable, "-m", "edgefusion.cli", "laser", "--json", "--baudrate", "500000"]
    with scanner("laser=off@0+0.5") as (port, off):
        process = subprocess.Popen([*command, port], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        with process:
            before = json.loads(process.stdout.readline())
            off.set()
            said = list(iter(process.stderr.readline, "health:  ok\n"))
            stamps = (json.loads(line)["stamp_ns"] for line in process.stdout)
            assert next(stamp for stamp in stamps if stamp > before["stamp_ns"] + 500_000_000)
            process.terminate()
            process.stdout.read()
    assert any(line.startswith(f"health:  failed: {port}: nothing came for") for line in said)
    assert process.returncode == 0


def in_terminal(*options: object, columns: int, rows: int) -> str:
    """What it writes to a terminal of that size, until it has drawn twice and was told to end."""
    master, slave = os.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    command = [sys.executable, "-m", "edgefusion.cli", "laser", *map(str, options)]
    environment = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
    process = subprocess.Popen(command, stdout=slave, env=environment)
    os.close(slave)
    written = b""
    with suppress(OSError):  # how a terminal says that nobody writes to it any more
        while True:
            was_enough = written.count(DRAWN) >= 2
            written += os.read(master, 65536)
            if written.count(DRAWN) >= 2 and not was_enough:
                process.terminate()
    os.close(master)
    assert process.wait(timeout=30) == 0
    return written.decode()


@pytest.mark.parametrize(("columns", "rows", "plot"), [(100, 40, 19), (50, 40, 12), (100, 12, 9)])
def test_in_a_terminal_the_scan_is_drawn_in_place_and_fits(columns: int, rows: int, plot: int) -> None:
    with scanner() as (port, _):
        written = in_terminal(port, "--baudrate", 500000, columns=columns, rows=rows)
    drawn = [line for line in written.split("\r\n") if "\x1b[2K" in line]
    assert max(len(re.sub(r"\x1b\[\d*\w", "", line)) for line in drawn) <= columns
    ups = {int(up) for up in re.findall(r"\x1b\[(\d+)A", written)}
    assert ups == {plot + 2} and len(drawn) % (plot + 2) == 0
    assert "361 beams" in drawn[plot + 1] or columns < 60
    assert any(ord(sign) > 0x2800 for sign in drawn[0] + drawn[plot - 1])


def test_where_no_scanner_is_it_says_so_with_exit_code_1(capsys) -> None:
    assert main(["laser", "/dev/nothing-here"]) == 1
    assert capsys.readouterr().err.startswith("edgefusion: /dev/nothing-here: cannot be opened")


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["--seconds", "0"], "--seconds: expected more than 0, got 0"),
        (["--png", "x.jpg"], "expected a name that ends in .png"),
    ],
)
def test_what_it_cannot_do_is_refused(options: list[str], why: str, capsys) -> None:
    assert main(["laser", "/dev/null", *options]) == 2
    assert why in capsys.readouterr().err


def test_the_plot_puts_what_is_ahead_above_and_what_is_left_to_the_left() -> None:
    def lines(bearing: float) -> list[str]:
        ranges = np.full(361, np.inf, np.float32)
        ranges[round((math.degrees(bearing) + 90) * 2)] = 0.9
        return scan_lines(Scan(0, ranges, -math.pi / 2, math.radians(0.5)))

    def where(plot: list[str]) -> tuple[int, int]:
        (at,) = [(r, c) for r, line in enumerate(plot[:-1]) for c, sign in enumerate(line) if ord(sign) > 0x2800]
        return at

    assert len(lines(0.0)) == ROWS + 1 and len(lines(0.0)[0]) == COLUMNS
    assert where(lines(0.0)) == (2, COLUMNS // 2)
    row, column = where(lines(math.pi / 2 - 0.01))
    assert row == ROWS - 1 and column < 5
    assert where(lines(-math.pi / 2 + 0.01))[1] > COLUMNS - 6
