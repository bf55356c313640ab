# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who else is on the bus of a robot in a soak, each in a process of its own: `python -m benchmarks.soak_players WHO
ENDPOINT`. An operator who always wants the next goal, a watcher that is slow, and one that sends what is nothing.
"""

from __future__ import annotations

import json
import sys
import time
from contextlib import suppress
from typing import Callable, Dict, Iterator

import numpy as np

from edgefusion.bus.client import Errand, Robot, connect
from edgefusion.bus.requests import GoalRequest
from edgefusion.bus.session import UnreachableError, open_client
from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.topics import DETECTIONS_DETAIL, IMAGE, QUERIES, SCAN, TOPICS, key_of
from edgefusion.errors import RefusedError

ROBOT = "robot"
_PAUSE_S, _SLOW_S, _STOPPED_S = 0.3, 0.5, 1.0
_HOSTILE_HZ, _MOST_BYTES = 200, 6000


def operator(endpoint: str) -> None:
    """For each line `X Y THETA [LABEL]` it drives there, as seen from where the robot is, and says how that ended."""
    while True:
        try:
            with connect(endpoint, timeout_s=2.0) as robot:
                _say("joined")
                for line in iter(sys.stdin.readline, ""):
                    _say(_driven(robot, line.split()))
                return
        except UnreachableError as error:
            _say(f"unreachable: {error}")
            time.sleep(_PAUSE_S)


def _driven(robot: Robot, words: list[str]) -> str:
    x_m, y_m, theta = map(float, words[:3])
    try:
        return _followed(robot, robot.goto_all([GoalRequest(x_m, y_m, theta, "base_link")], inspect=words[3:]))
    except RefusedError as error:
        time.sleep(_PAUSE_S)
        _resumed(robot)
        return f"refused: {error}"
    except UnreachableError as error:
        return f"lost: {error}"


def _followed(robot: Robot, errand: Errand) -> str:
    """What stands for a while is resumed."""
    stopped_s = None
    for report in robot.progress(errand):
        if report.state != "stopped":
            stopped_s = None
        elif stopped_s is None:
            stopped_s = time.monotonic()
        elif time.monotonic() - stopped_s > _STOPPED_S:
            stopped_s = time.monotonic()
            _resumed(robot)
    return f"{report.state}: {report.reason}" if report.reason else report.state


def _resumed(robot: Robot) -> None:
    """Where anything is to be."""
    with suppress(RefusedError):
        robot.resume()


def slow(endpoint: str) -> None:
    """Takes half a second for each thing that it hears."""
    session = open_client(endpoint)
    topics = (IMAGE, SCAN, DETECTIONS_DETAIL)
    kept = [Subscriber(session, key_of(ROBOT, each.name), wake=lambda: time.sleep(_SLOW_S)) for each in topics]
    _say(f"joined {len(kept)}")
    time.sleep(3600.0)


def hostile(endpoint: str) -> None:
    """Random bytes, on every key that there is, with tags that are none."""
    session, rng = open_client(endpoint), np.random.default_rng(0)
    keys = [key_of(ROBOT, name) for name in TOPICS]
    _say("joined")
    for number in _ticks(_HOSTILE_HZ):
        payload, tag = rng.bytes(int(rng.integers(0, _MOST_BYTES))), rng.bytes(int(rng.integers(0, 200)))
        if number % 10:
            session.put(keys[number % len(keys)], payload, attachment=tag)
        else:
            name = QUERIES[number // 10 % len(QUERIES)]
            session.get(key_of(ROBOT, name), lambda _: None, payload=payload, attachment=tag, timeout=1.0)


def _ticks(hz: float) -> Iterator[int]:
    for number in range(10**9):
        yield number
        time.sleep(1 / hz)


def _say(event: str) -> None:
    print(json.dumps({"event": event, "ns": time.monotonic_ns()}), flush=True)


PLAYERS: Dict[str, Callable[[str], None]] = {each.__name__: each for each in (operator, slow, hostile)}

if __name__ == "__main__":
    PLAYERS[sys.argv[1]](sys.argv[2])
