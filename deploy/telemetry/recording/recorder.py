"""The recorder: a node that receives all recorded streams of a run and writes them, and its process.

What arrives is put aside as it is and written in batches. What the last half second brought may be lost
when this process is killed; all before that is in the file.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from math import inf
from pathlib import Path

from deploy.telemetry.recording.writer import RecordingWriter, Rotation, next_free
from protocol import joining
from protocol.bus.bus import Bus, Event, Presence, Sample, follow
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.errors import BusError, MessageError
from protocol.keys import checked_run, everything, robot_key, world_key, world_tokens
from protocol.messages import Result
from protocol.process.signals import STOP
from protocol.scenario.model import Scenario

PATIENCE = 30.0  # s that the world may take to appear
_BATCH = 512  # messages put aside at most
_WRITE_PERIOD = 0.1  # s between batches
_TAKE_PERIOD = 0.01  # s; samples that wait longer keep the network from using its buffers again
_FLUSH_PERIOD = 0.4  # s between chunks
_LAST_WORDS = 0.2  # s for what robots said before the result to arrive after it
_RESULT = 3.0  # s for the result to arrive after this process was asked to stop
_ASK_TIMEOUT = 5.0
_ASK_AGAIN = 0.5  # s
_NICENESS = 5  # the fleet first, and yet a share of a busy machine


class Recorder:
    """Records one run, from now to its result; a node on any bus. It does not finish the file.

    Args:
        bus: has subscribed to all that is to be recorded, or to the result alone if there is `take`.
        run: name of the run.
        file: begun once the scenario is known; no message published from then on can be missed.
        take: gives the keys and payloads that have arrived since it was called last.
        patience: s that the world may take to appear and to send its scenario.
        away: s that the world may be gone and come back; 0: the recording ends with it.

    Attributes:
        result: what the world published as the result of the run (JSON); None before that.

    Raises:
        BusError: no world within `patience` s, or none that sends its scenario.
        UsageError: the file cannot be created.
    """

    def __init__(
        self,
        bus: Bus,
        run: str,
        file: RecordingWriter,
        *,
        take: Callable[[], list[tuple[str, bytes]]] | None = None,
        patience: float = PATIENCE,
        away: float = 0.0,
    ) -> None:
        self.finished = False
        self.result: str | None = None
        self._bus, self._run, self._patience = bus, run, patience
        self._away, self._back_by = away, inf
        self._file, self._take = file, take
        self._ready = False
        self._aside: list[tuple[str, bytes]] = []
        self._worlds: set[str] = set()  # tokens
        self._result_key = world_key(run, "result")
        self._result_due = inf
        self._written = self._flushed = time.monotonic()
        self._overdue = self.deadline = self._written + patience
        bus.watch(world_tokens(run))

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            if event.key == self._result_key:
                self._on_result(event)
                return
            if self._take is None:
                self._aside.append((event.key, event.payload))
            if len(self._aside) >= _BATCH and self._ready:
                self._write(time.monotonic())
        elif isinstance(event, Presence):
            (self._worlds.add if event.alive else self._worlds.discard)(event.key)
            self._on_world(bool(self._worlds))

    def wake(self, now: float) -> None:
        if not self._ready:
            self._begin(now)
            return
        if now >= min(self._result_due, self._back_by):
            self.close()
            return
        self._take_all()
        if now >= self._written + _WRITE_PERIOD:
            self._write(now)
        self.deadline = now + (_WRITE_PERIOD if self._take is None else _TAKE_PERIOD)

    def close(self) -> None:
        """Write what has arrived; what happens later is not recorded."""
        while not self.finished and (event := self._bus.receive(0.0)) is not None:
            self.handle(event)
        if not self.finished:
            self.finished, self.deadline = True, inf
            self._take_all()
            self._write(time.monotonic(), last=True)

    def wind_up(self, patience: float) -> None:
        """Go on until the result is there, `patience` (s) at most: for a process told to stop."""
        until = time.monotonic() + patience
        while self._awaits_result and (rest := until - time.monotonic()) > 0.0:
            event = self._bus.receive(rest)
            if event is not None:
                self.handle(event)
        self.close()

    @property
    def _awaits_result(self) -> bool:
        return self._ready and not self.finished and self.result is None

    def _on_world(self, alive: bool) -> None:
        self._back_by = inf if alive else time.monotonic() + self._away
        if not alive and not self._away:
            self.close()
        elif alive and not self._ready:
            self._begin(time.monotonic())

    def _begin(self, now: float) -> None:
        """Ask for the scenario; a world that does not send it is asked again."""
        scenario = self._scenario() if self._worlds else None
        if scenario is None:
            if now >= self._overdue:
                lacking = "the world does not send its scenario" if self._worlds else "no world to record"
                raise BusError(f"run {self._run!r}: {lacking} within {self._patience:g} s")
            self.deadline = min(self._overdue, now + _ASK_AGAIN) if self._worlds else self._overdue
            return
        self._bus.expect(_every_tick(self._run, scenario.ids))
        self._file.begin(self._run, scenario)
        self._ready = True
        self.deadline = time.monotonic()

    def _scenario(self) -> Scenario | None:
        try:
            reply = joining.decode_reply(
                self._bus.ask(world_key(self._run, "scenario"), b"", _ASK_TIMEOUT)[0]
            )
        except (BusError, MessageError):
            return None
        return reply.scenario if isinstance(reply, joining.Overview) else None

    def _on_result(self, sample: Sample) -> None:
        try:
            message = decode(sample.key, sample.payload)
        except MessageError:
            if self._take is None:
                self._aside.append((sample.key, sample.payload))  # to be counted with the others
            return
        if isinstance(message, Result) and self.result is None:
            self.result, self._result_due = message.report, time.monotonic() + _LAST_WORDS

    def _take_all(self) -> None:
        if self._take is not None:
            self._aside += self._take()

    def _write(self, now: float, *, last: bool = False) -> None:
        if not self._ready:
            return
        self._written = now
        aside, self._aside = self._aside, []
        self._file.write(aside)
        if last or now >= self._flushed + _FLUSH_PERIOD:
            self._flushed = now
            self._file.flush()


def _every_tick(run: str, robots: Iterable[int]) -> Iterator[str]:
    """The keys under which most is published."""
    for robot in robots:
        for stream in ("tick", "state", "command"):
            yield robot_key(run, robot, stream)


def main(
    connection: Connection,
    run: str,
    path: Path,
    result: Path,
    rotation: Rotation,
    away: float,
    again: bool,
    ready: Callable[[str], None],
) -> int:
    """Record `run` until a signal asks this process to end; returns 0.

    Args:
        connection: to the network.
        run: name of the run.
        path: of the first file.
        result: a file that may hold the complete result (JSON) when the signal comes; else the recording ends
            with the world's.
        rotation: when another file follows.
        away: as in `Recorder`.
        again: whether this process replaces one that died: its file is left as it is, and the next free name
            is taken.
        ready: is told the name of each file; no message published after the first call is missed.

    Raises:
        DisknavError: no network, no world, or the file cannot be created.
    """
    os.nice(max(0, _NICENESS - os.nice(0)))
    if sys.platform == "linux":  # where the fleet has real-time priority, its recorder has none
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    bus = ZenohBus(connection)
    try:
        file = RecordingWriter(next_free(path) if again else path, rotation, ready)
        take = bus.bursts(everything(checked_run(run)))  # one subscription, which keeps the order of arrival
        bus.subscribe(world_key(run, "result"))
        recorder = Recorder(bus, run, file, take=take, away=away)
        follow(recorder, bus)
        recorder.wind_up(_RESULT)
    finally:
        bus.close()
    STOP.wait()  # the complete result is known once all other processes have ended
    file.finish(result.read_text(encoding="utf-8") if result.exists() else recorder.result)
    return 0
