"""The recorder: a node that receives all recorded streams of a run and writes them in batches; its process.

If the process is killed, at most the last half second is lost.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from math import inf
from pathlib import Path

from deploy.telemetry.recording.writer import RecordingWriter, Rotation, next_free
from protocol.bus.bus import Bus, Event, Presence, Sample, follow
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.errors import BusError, MessageError
from protocol.joining import overview
from protocol.keys import checked_run, everything, robot_key, world_key, world_tokens
from protocol.messages import Result
from protocol.process.signals import STOP
from protocol.scenario.model import Scenario

PATIENCE = 30.0  # s to wait for the world
_BATCH = 512  # messages
_PERIOD = 0.01  # s between batches; samples left longer would block the network's buffers
_FLUSH_PERIOD = 0.4  # s between chunks
_LAST_WORDS = 0.2  # s after the result, for late messages of robots
_RESULT = 3.0  # s to wait for the result after a signal
_SUPERVISOR = 8.0  # s to wait for the supervisor's signal after one that was sent to all processes at once
_ASK_TIMEOUT = 5.0
_ASK_AGAIN = 0.5  # s
_NICENESS = 5  # the fleet goes first


def awaited_scenario(bus: Bus, run: str, patience: float = PATIENCE) -> Scenario:
    """The present scenario of a run, as soon as its world sends it; raises BusError after `patience` s."""
    until = time.monotonic() + patience
    while (reply := overview(bus, run, _ASK_TIMEOUT)) is None:
        if time.monotonic() >= until:
            raise BusError(f"run {run!r}: no world has sent its scenario within {patience:g} s")
        STOP.wait(_ASK_AGAIN)
    return reply.scenario


class Recorder:
    """Records one run, from now to its result; a node on any bus.

    Args:
        bus: subscribed to all recorded streams, or with `take` to the result only.
        take: returns keys and payloads that have arrived since its last call.
        grace: time for a lost world to return, s; 0: the recording ends with it.

    """

    def __init__(
        self,
        bus: Bus,
        run: str,
        file: RecordingWriter,
        *,
        take: Callable[[], Sequence[tuple[str, bytes]]] = tuple,
        grace: float = 0.0,
    ) -> None:
        self.finished = False
        self.result: str | None = None  # published result of the run (JSON), once received
        self._bus, self._grace, self._back_by = bus, grace, inf
        self._file, self._take = file, take
        self._arrived: list[tuple[str, bytes]] = []
        self._worlds: set[str] = set()  # tokens
        self._result_key = world_key(run, "result")
        self._result_due = inf
        self._flush_at = self.deadline = time.monotonic()
        bus.watch(world_tokens(run))

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            if event.key == self._result_key:
                self._on_result(event)
            else:
                self._arrived.append((event.key, event.payload))
                if len(self._arrived) >= _BATCH:
                    self._write()
        elif isinstance(event, Presence):
            (self._worlds.add if event.alive else self._worlds.discard)(event.key)
            self._back_by = inf if self._worlds else time.monotonic() + self._grace
            if not self._worlds and not self._grace:
                self.close()

    def on_timer(self, now: float) -> None:
        if now >= min(self._result_due, self._back_by):
            self.close()
            return
        self._write()
        if now >= self._flush_at:
            self._flush_at = now + _FLUSH_PERIOD
            self._file.flush()
        self.deadline = now + _PERIOD

    @property
    def over(self) -> bool:
        """Whether the run has ended, or its world has left."""
        return self.result is not None or not self._worlds

    def close(self) -> None:
        """Write all messages that have arrived, and stop."""
        while not self.finished and (event := self._bus.receive(0.0)) is not None:
            self.handle(event)
        if not self.finished:
            self.finished, self.deadline = True, inf
            self._write()
            self._file.flush()

    def finish(self, result: str | None = None) -> None:
        """Close the file with the complete result (JSON), or the published one."""
        self._file.finish(result or self.result)

    def wind_up(self, patience: float) -> None:
        """Continue until the result arrives, at most `patience` s, after a signal."""
        until = time.monotonic() + patience
        while not self.finished and self.result is None and (rest := until - time.monotonic()) > 0.0:
            event = self._bus.receive(rest)
            if event is not None:
                self.handle(event)
        self.close()

    def _write(self) -> None:
        batch, self._arrived = [*self._arrived, *self._take()], []
        self._file.write(batch)

    def _on_result(self, sample: Sample) -> None:
        with suppress(MessageError):  # of another sender
            message = decode(sample.key, sample.payload)
            if isinstance(message, Result) and self.result is None:
                self.result, self._result_due = message.report, time.monotonic() + _LAST_WORDS


def main(
    connection: Connection,
    run: str,
    path: Path,
    result: Path,
    rotation: Rotation,
    grace: float,
    again: bool,
    ready: Callable[[str], None],
) -> int:
    """Record `run` until a signal; returns 0.

    Args:
        path: first file.
        result: file that may hold the complete result (JSON) when the signal arrives; otherwise the world's
            result is recorded.
        rotation: when another file follows.
        grace: as in `Recorder`.
        again: whether this process replaces a failed one, whose file is kept: it uses the next free name.
        ready: called with the name of each file; no message published after the first call is missed.

    Raises:
        DisknavError: no network, no world, or the file cannot be created.
    """
    os.nice(max(0, _NICENESS - os.nice(0)))
    if sys.platform == "linux":  # never with the fleet's real-time priority
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    with closing(ZenohBus(connection)) as bus:
        take = bus.bursts(everything(checked_run(run)))  # one subscription keeps the order of arrival
        bus.subscribe(world_key(run, "result"))
        scenario = awaited_scenario(bus, run)
        streams = ("tick", "state", "command")
        bus.expect(robot_key(run, robot, stream) for robot in scenario.ids for stream in streams)
        file = RecordingWriter(next_free(path) if again else path, run, scenario, rotation, ready)
        recorder = Recorder(bus, run, file, take=take, grace=grace)
        follow(recorder, bus)
        recorder.wind_up(_RESULT)
    STOP.wait()  # the result is complete once all other processes have ended
    until = time.monotonic() + _SUPERVISOR
    while recorder.over and not result.exists() and STOP.count < 2 and time.monotonic() < until:
        time.sleep(_PERIOD)
    recorder.finish(result.read_text(encoding="utf-8") if result.exists() else None)
    return 0
