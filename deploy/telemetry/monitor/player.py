"""A recording in place of a running fleet: what was said is heard again, at a chosen speed."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from concurrent.futures import Future
from functools import partial

from deploy.telemetry.monitor.live import View
from deploy.telemetry.monitor.snapshot import Steerable
from protocol.messages import Message
from protocol.operations import Outcome, Steer, Steering
from protocol.scenario.model import Operation, Scenario

_NAP = 0.01  # s, longest wait before steering is looked at again


class Player(Steerable):
    """Plays on a thread of its own until the end or `close`; pause, step and speed act on the playback."""

    def __init__(
        self, scenario: Scenario, run: str, entries: Iterable[tuple[float, Message]], *, speed: float = 1.0
    ) -> None:
        """Args:
        scenario: what was run.
        run: its name.
        entries: simulated time (s, never falling) and message.
        speed: recorded seconds per second; 0 is as fast as the machine allows.
        """
        super().__init__(run)
        self._steering = Steering(speed=speed)
        self._changed = threading.Lock()
        self._closed = False
        self.change(lambda view, _: view.begin(scenario, True))
        self._show()
        self._thread = threading.Thread(
            target=self._play, args=(entries,), name=f"replay of {run}", daemon=True
        )
        self._thread.start()

    def steer(self, steer: Steer) -> None:
        """See `Steerable.steer`."""
        with self._changed:
            self._steering.apply(steer)
        self._show()

    def operate(self, operation: Operation) -> Future[Outcome]:  # noqa: ARG002
        """Refuse: what was recorded has happened."""
        answer: Future[Outcome] = Future()
        answer.set_result(Outcome(False, text="this is a recording: its robots go where they went"))
        return answer

    def close(self) -> None:
        """Stop playing; may be called twice."""
        self._closed = True
        self._thread.join()

    def join(self, timeout: float | None = None) -> bool:
        """Wait for the end of the recording; whether it was reached."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _show(self) -> None:
        steering = Steering(self._steering.paused, 0, self._steering.speed)
        self.change(lambda view, _: setattr(view, "steering", steering))

    def _play(self, entries: Iterable[tuple[float, Message]]) -> None:
        played = 0.0
        for moment, message in entries:
            if moment > played:
                self._wait(moment - played)
                played = moment
            if self._closed:
                return
            self.change(partial(_hear, message))

    def _wait(self, seconds: float) -> None:
        """Let recorded time pass: at the speed that is set, in steps, or not at all while paused."""
        while seconds > 0.0 and not self._closed:
            began = time.monotonic()
            with self._changed:
                paused, speed = self._steering.paused, self._steering.speed
                if (paused and self._steering.allow()) or (not paused and speed == 0.0):
                    return
            time.sleep(_NAP if paused else min(_NAP, seconds / speed))
            if not paused:
                seconds -= (time.monotonic() - began) * speed


def _hear(message: Message, view: View, now: float) -> None:
    view.on_message(message, now)
