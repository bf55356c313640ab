# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What other threads want from the loop: it does it between two steps, and they get the answer."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future
from typing import Any, Callable, Deque, Tuple, TypeVar

from edgefusion.waiting import Wake

R = TypeVar("R")

ANSWER_S = 1.0


class Requests:
    """wake: makes the loop come by at once."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake = wake
        self._waiting: Deque[Tuple[Callable[[], Any], Future[Any]]] = deque()

    def ask(self, call: Callable[[], R], timeout_s: float = ANSWER_S, late_too: bool = False) -> R:
        """What the call returns in the loop's thread, or raises. Raises TimeoutError where the loop does not come by
        in time: the call is not made then, unless late_too."""
        future: Future[R] = Future()
        done = Wake()
        future.add_done_callback(lambda _: done())
        self._waiting.append((call, future))
        self._wake()
        if not done.wait(timeout_s) and not future.running() and (late_too or future.cancel()):
            raise TimeoutError(f"expected an answer within {timeout_s:g} s, got none: the loop is late")
        return future.result()  # it is made, or just being made

    def serve(self) -> None:
        """Makes the calls, in the order in which they came."""
        while self._waiting:
            call, future = self._waiting.popleft()
            if not future.set_running_or_notify_cancel():
                continue
            try:
                result = call()
            except Exception as error:
                future.set_exception(error)
            else:
                future.set_result(result)
