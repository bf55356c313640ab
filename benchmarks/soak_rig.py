# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What is soaked: simulated devices in this process, all processes of a robot, a recorder and an operator."""

from __future__ import annotations

import os
import signal
import time
from collections import Counter
from pathlib import Path
from typing import Callable, Dict, List

import numpy as np
from benchmarks.end_to_end_robot import RobotProcess, RobotSetup, free_endpoint, write_config
from benchmarks.fault_row import ALLOWED
from benchmarks.process_memory import CAMERA, processes
from benchmarks.soak_health import Traces
from benchmarks.soak_lives import Lives
from benchmarks.soak_player import Player
from benchmarks.soak_told import ToldWatch

from edgefusion.bus.topics import ANNOTATED, IMAGE, TOPICS
from edgefusion.errors import RefusedError
from edgefusion.service.real_time import run_in_real_time
from edgefusion.sim.live_devices import LiveDevices, LiveSetup
from edgefusion.sim.world_file import load_world
from edgefusion.tools.arguments import LAB_MODEL
from edgefusion.types import Pose2D

GOALS = ((5.0, 5.5), (0.0, 0.0), (4.8, 3.9), (0.9, 3.2), (5.2, 0.3), (1.5, 5.6))
"""In the laboratory, with room around them."""

READY_S, ENDS_S = 120.0, 3.0
STAND_S, SPEED_MPS = 2.0, 0.15
_PAUSE_S, _LOOK_NS = 0.001, 2_000_000_000
_RECORDED = [name for name in TOPICS if name not in (IMAGE.name, ANNOTATED.name)]


class SoakRig:
    """From its making until close(). contacts: how often the hull met something. crashes: processes that ended though
    nobody meant them to. goals: how goals ended, by how often."""

    def __init__(self, folder: Path, seed: int, warm_s: float) -> None:
        self.folder, self.rng = folder, np.random.default_rng(seed)
        self.told, self.traces = ToldWatch(), Traces(warm_s)
        self.contacts = 0
        self.crashes: List[str] = []
        self.goals: Dict[str, int] = Counter()
        self._diary = (folder / "diary.txt").open("w", encoding="utf-8")
        self._players: Dict[str, Player] = {}
        self._lives, self._looks = Lives(CAMERA), 0
        self._touches, self._looked_ns, self._goal = False, 0, 0
        setup = LiveSetup(load_world("laboratory"), seed, robot_port=0, links=folder)
        self.devices = LiveDevices(setup, time.monotonic_ns())
        run_in_real_time()  # as firmware has its processor for itself
        self._robot: RobotProcess | None = None

    def begin(self) -> None:
        """Returns when the robot drives. Raises RefusedError where it does not come to that."""
        camera = self.devices.camera
        assert camera is not None
        if not self.until(lambda: camera.ready or camera.fault, READY_S) or camera.fault:
            raise RefusedError(f"the simulated camera: {camera.fault or 'it was not ready in time'}")
        self.endpoint = free_endpoint()
        config = write_config(self.folder, self.devices, RobotSetup(LAB_MODEL, stand_s=STAND_S), self.endpoint)
        self.robot = self._robot = RobotProcess(config, self.folder / "robot.log")
        self.begun_ns = time.monotonic_ns()
        self.play("operator")
        if not self.until(lambda: self.goals["joined"], READY_S):
            raise RefusedError("expected a bus that an operator may join, got none in time")
        topics = [word for name in _RECORDED for word in ("--topic", name)]
        recording = str(self.folder / "soak.mcap")
        record = ["-m", "edgefusion.cli", "record", recording, "--overwrite", "--connect", self.endpoint, *topics]
        self._players["recorder"] = Player(self.folder / "recorder.log", *record)
        if not self.until(lambda: self.drives and self._looks, READY_S):
            raise RefusedError(f"expected a robot that drives, got one of which the operator hears: {dict(self.goals)}")

    def play(self, who: str) -> Player:
        """One more on the bus."""
        player = Player(self.folder / f"{who}.log", "-m", "benchmarks.soak_players", who, self.endpoint)
        self._players[who] = player
        if who == "operator":
            self._give_goal(player)
        return player

    def leave(self, who: str) -> None:
        """One that has played."""
        self._lives.doom(who)
        self._players.pop(who).end(kill=True)

    def kill(self, name: str, number: int = signal.SIGKILL) -> None:
        """One of the robot's processes, of which that is no crash."""
        pid = processes(self.robot.pid).get(name)
        if pid is None:
            return
        self._lives.doom(name)
        os.kill(pid, number)

    @property
    def now_s(self) -> float:
        """By the clock of everything here."""
        return time.monotonic_ns() / 1e9

    @property
    def drives(self) -> bool:
        """At speed, and it was told so."""
        return self.told.v_mps >= SPEED_MPS and self.devices.world.body.twist.v_mps >= SPEED_MPS

    @property
    def stands(self) -> bool:
        """In truth."""
        twist = self.devices.world.body.twist
        return abs(twist.v_mps) < 0.01 and abs(twist.w_radps) < 0.02

    def until(self, holds: Callable[[], object], within_s: float) -> bool:
        """Lets the time pass until something is so; whether it came to that in time."""
        end_ns = time.monotonic_ns() + round(within_s * 1e9)
        while not holds():
            now_ns = time.monotonic_ns()
            if now_ns > end_ns:
                return False
            self._turn(now_ns)
            time.sleep(_PAUSE_S)
        return True

    def _turn(self, now_ns: int) -> None:
        self.devices.pump(now_ns)
        self.told.look(self.devices.robot.heard)
        touches = any(any(side) for side in self.devices.world.body.bumpers)
        if touches and not self._touches:
            self.contacts += 1
            self.note("contact")
        self._touches = touches
        operator = self._players.get("operator")
        if operator is not None:
            self._serve(operator)
        if self._robot is not None and now_ns - self._looked_ns > _LOOK_NS:
            self._looked_ns = now_ns
            self._look(now_ns)

    def _serve(self, operator: Player) -> None:
        """It gets a goal for each that has ended."""
        for event in operator.take():
            word = event.split(":")[0]
            self.goals[word] += 1
            self.note(f"operator: {event}")
            if word not in ("joined", "unreachable"):
                self._give_goal(operator)

    def _give_goal(self, operator: Player) -> None:
        """Another than the last one; at every third it may stop for what is of interest."""
        others = [number for number in range(len(GOALS)) if number != self._goal]
        self._goal = int(self.rng.choice(others))
        goal = Pose2D(*GOALS[self._goal], float(self.rng.uniform(-np.pi, np.pi)))
        relative = goal.relative_to(self.devices.world.body.pose)
        words = [f"{value:.3f}" for value in (relative.x_m, relative.y_m, relative.theta)]
        operator.tell(" ".join([*words, *(["oscilloscope"] if self.rng.random() < 1 / 3 else [])]))

    def _look(self, now_ns: int) -> None:
        """Who lives, and how large they are."""
        pids = processes(self.robot.pid)
        lives = {**pids, **{name: player.pid for name, player in self._players.items() if player.lives}}
        for name in self._lives.look(lives):
            self._crash(f"{name} ended")
        self._looks += 1
        self.traces.look((now_ns - self.begun_ns) / 1e9, lives)

    def _crash(self, what: str) -> None:
        self.crashes.append(f"{what} at {(time.monotonic_ns() - self.begun_ns) / 1e9:.0f} s")
        self.note(what)

    def note(self, what: str) -> None:
        """With the time of day, by which the logs of the processes go."""
        self._diary.write(f"{time.strftime('%H:%M:%S')} {what}\n")
        self._diary.flush()

    def close(self) -> List[str]:
        """What did not end as it should have."""
        wrong = []
        for name, player in self._players.items():
            code = player.end()
            if name == "recorder" and code != 0:
                wrong.append(f"recorder: exit code {code}")
        if self._robot is not None:
            took_s = self._robot.end()
            if took_s > ALLOWED * ENDS_S:
                wrong.append(f"the robot's processes took {took_s:.1f} s to end")
        self.devices.close()
        self._diary.close()
        return wrong
