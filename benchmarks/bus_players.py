# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who else is on the bus while faults are injected: each is a process of its own, `python -m benchmarks.bus_players`.

Each prints a line when it is there, and then does what it is for until it is killed, or has done it.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Callable, Dict

import zenoh

from edgefusion.bus.heartbeat import Heartbeat
from edgefusion.bus.publisher import CommandPublisher
from edgefusion.bus.router import open_router
from edgefusion.bus.session import open_client
from edgefusion.bus.subscriber import Subscriber
from edgefusion.bus.tags import Tagger
from edgefusion.bus.topics import CMD_VEL, IMAGE, MISSION, key_of
from edgefusion.config.bus import BusConfig
from edgefusion.messages.geometry_msgs import Twist, Vector3

ROBOT = "robot"
AHEAD = Twist(Vector3(x=0.2))
FOR_EVER_S = 3600.0


def router(listen: str, keys: str, max_command_hz: str) -> None:
    """Routes."""
    config = BusConfig(listen=tuple(listen.split(",")), keys=keys, max_command_hz=float(max_command_hz))
    session = open_router(config)
    _ready()
    time.sleep(FOR_EVER_S)
    _leave(session)


def operator(endpoint: str, keys: str) -> None:
    """Beats."""
    session = _join(endpoint, keys)
    with Heartbeat(session, ROBOT, Tagger()):
        _ready()
        time.sleep(FOR_EVER_S)


def driver(endpoint: str, keys: str, hz: str, count: str) -> None:
    """Commands a velocity so often and so many times."""
    session = _join(endpoint, keys)
    publisher = CommandPublisher(session, ROBOT, CMD_VEL, Tagger(), 1000)
    _ready()
    due_s = time.monotonic()
    for _ in range(int(count)):
        publisher.put(AHEAD)
        due_s += 1 / float(hz)
        time.sleep(max(0.0, due_s - time.monotonic()))
    time.sleep(0.5)  # what was put last is still on its way
    _leave(session)


def patient(endpoint: str, keys: str, count: str) -> None:
    """Commands a velocity so many times, the next one when the robot has reported something."""
    session = _join(endpoint, keys)
    publisher = CommandPublisher(session, ROBOT, CMD_VEL, Tagger(), 1000)
    reports = Subscriber(session, key_of(ROBOT, MISSION.name))
    while not publisher.heard:
        time.sleep(0.01)
    _ready()
    for _ in range(int(count)):
        publisher.put(AHEAD)
        reports.wait(1.0)
        time.sleep(0.001)
    _leave(session)


def watcher(endpoint: str, keys: str, seconds: str, pause_s: str) -> None:
    """Watches the images, with a pause after each, and says at the end how many there were."""
    session = _join(endpoint, keys)
    subscriber = Subscriber(session, key_of(ROBOT, IMAGE.name), wake=lambda: time.sleep(float(pause_s)))
    _ready()
    time.sleep(float(seconds))
    print(subscriber.received, flush=True)
    _leave(session)


def _join(endpoint: str, keys: str) -> zenoh.Session:
    """keys: a folder; empty: by loopback without."""
    return open_client(endpoint, Path(keys) if keys else None)


def _ready() -> None:
    print("ready", flush=True)


def _leave(session: zenoh.Session) -> None:
    session.close()  # type: ignore[no-untyped-call]


PLAYERS: Dict[str, Callable[..., None]] = {each.__name__: each for each in (router, operator, driver, patient, watcher)}

if __name__ == "__main__":
    PLAYERS[sys.argv[1]](*sys.argv[2:])
