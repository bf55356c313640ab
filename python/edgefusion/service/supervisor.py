# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The supervisor at work: processes, signals, systemd and the robot's last stop around a `Supervision`."""

from __future__ import annotations

import os
import selectors
import signal
from typing import Dict, Mapping, Sequence, Tuple

from edgefusion.clock import Clock, system_clock
from edgefusion.service import heartbeat, notify, utc
from edgefusion.service.child_process import ChildProcess
from edgefusion.service.child_spec import ChildSpec
from edgefusion.service.last_stop import stop_robot
from edgefusion.service.notify import Notifier
from edgefusion.service.robot_stops import RobotStops, Stopper
from edgefusion.service.signal_pipe import ENDS, SignalPipe
from edgefusion.service.supervision import Supervision
from edgefusion.service.supervision_actions import Action, Start, StopRobot
from edgefusion.types import Health

TURN_S = 0.05
"""It comes by at least so often."""


class Supervisor:
    """run() is for the main thread, once. environment: the children's, without what systemd says to this process alone,
    and with the offset to UTC."""

    def __init__(
        self,
        specs: Sequence[ChildSpec],
        environment: Mapping[str, str] | None = None,
        clock: Clock = system_clock,
        stop: Stopper = stop_robot,
    ) -> None:
        environment = dict(os.environ if environment is None else environment)
        self._notifier = Notifier(environment, clock)
        self._environment = {name: value for name, value in environment.items() if name not in notify.VARIABLES}
        self._environment[utc.ENVIRONMENT] = str(utc.taken_offset_ns(clock))
        self._clock, self._supervision = clock, Supervision(specs)
        self._children: Dict[str, ChildProcess] = {}
        self._selector = selectors.DefaultSelector()
        self._signals = SignalPipe()
        self._stops = RobotStops(self._signals.wake, stop)
        self._told: Tuple[Health, ...] = ()

    def run(self) -> int:
        """Until a signal asks for the end, or no more can be done; all children are gone then, and the robot was told
        to stop. The exit code, as Supervision's."""
        with self._signals, self._selector:
            self._selector.register(self._signals, selectors.EVENT_READ)
            try:
                while not self._supervision.has_ended(self._clock()):
                    self._turn()
            finally:
                self._abandon()
        return self._supervision.exit_code

    def _turn(self) -> None:
        self._selector.select(TURN_S)
        now_ns = self._clock()
        for number in self._signals.take():
            if number in ENDS:
                self._supervision.end(now_ns, f"asked to by {number.name}")
        for child in list(self._children.values()):
            self._listen(child, now_ns)
        for name, stopped in self._stops.take():
            self._supervision.robot_stopped(name, stopped)
        for action in self._supervision.step(now_ns):
            self._do(action, now_ns)
        self._tell()

    def _listen(self, child: ChildProcess, now_ns: int) -> None:
        """Looks first whether it is gone: nothing that it said before that is missed then."""
        code = child.poll()
        for status in child.beats():
            self._supervision.beat(now_ns, child.name, status)
        if code is not None:
            del self._children[child.name]
            self._supervision.exited(now_ns, child.name, code)
        if (code is not None or child.hung_up) and child in self._selector.get_map():
            self._selector.unregister(child)
        if code is not None:
            child.close()

    def _do(self, action: Action, now_ns: int) -> None:
        if isinstance(action, Start):
            self._start(action, now_ns)
        elif isinstance(action, StopRobot):
            self._stops.begin(action.name, action.status, action.by_ns)
        elif action.name in self._children:
            self._children[action.name].send(action.number)

    def _start(self, start: Start, now_ns: int) -> None:
        spec = start.spec
        try:
            child = ChildProcess(spec, {**self._environment, heartbeat.STOPPED: heartbeat.carried(start.stopped)})
        except OSError as error:
            self._supervision.not_started(now_ns, spec.name, f"cannot be run: {error}")
            return
        self._children[spec.name] = child
        self._selector.register(child, selectors.EVENT_READ)
        self._supervision.started(now_ns, spec.name)
        self._told = ()  # the new one has not heard how the others are

    def _tell(self) -> None:
        """systemd that this loop lives and what is new, the children how the others are."""
        self._notifier.alive()
        self._notifier.status(self._supervision.in_words())
        if self._supervision.ending:
            self._notifier.stopping()
        elif self._supervision.ready:
            self._notifier.ready()
        healths = self._supervision.healths()
        if healths != self._told:
            self._told = healths
            for child in self._children.values():
                child.tell([health for health in healths if health.component != child.name])

    def _abandon(self) -> None:
        """Whoever is left, as after an error in here, is asked to end, and to stop its robot itself."""
        for child in self._children.values():
            child.send(signal.SIGTERM)
            child.close()
        self._notifier.close()
