"""The recorder: hears all recorded streams of a run and hands them to who writes the file.

What arrives is put aside as it is and handed over in batches, so that hearing costs next to nothing and
the network never waits. Half a second at most is lost when this process is killed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from math import inf

from deploy.telemetry.recording.writer import RecordingFile
from deploy.telemetry.recording.writer_process import Writer
from protocol import joining
from protocol.bus.bus import Bus, Event, Presence, Sample
from protocol.codec import decode
from protocol.errors import BusError, MessageError, RecordingError
from protocol.keys import robot_key, world_key, world_tokens
from protocol.messages import Result
from protocol.scenario.model import Scenario

PATIENCE = 30.0  # s that the world may take to appear
_BATCH = 512  # messages put aside at most
_WRITE_PERIOD = 0.1  # s between batches
_HEARING_PERIOD = 0.01  # s; what waits longer keeps the network from using its buffers again
_FLUSH_PERIOD = 0.4  # s between chunks
_LAST_WORDS = 0.2  # s for what robots said before the result to arrive after it
_ASK_TIMEOUT = 5.0
_ASK_AGAIN = 0.5  # s


class Recorder:
    """Records one run, from now to its result; a node on any bus. It does not finish the file.

    Args:
        bus: it has subscribed to all that is to be recorded, or to the result alone if there is `heard`.
        run: name of the run.
        file: takes what is heard.
        on_ready: called once the scenario is known; nothing that is published from then on can be missed.
        heard: gives the keys and payloads that have arrived since it was called last.
        patience: s that the world may take to appear and to say which scenario it runs.
        away: s that it, or who writes, may be gone later and come back; 0: the recording ends with it.

    Raises:
        BusError: no world within `patience` s, or none that says which scenario it runs.
    """

    def __init__(
        self,
        bus: Bus,
        run: str,
        file: RecordingFile | Writer,
        *,
        on_ready: Callable[[], None] | None = None,
        heard: Callable[[], list[tuple[str, bytes]]] | None = None,
        patience: float = PATIENCE,
        away: float = 0.0,
    ) -> None:
        self.finished = False
        self._bus, self._run, self._patience = bus, run, patience
        self._away, self._back_by = away, inf
        self._on_ready, self._ready = on_ready, False
        self._file, self._heard = file, heard
        self._aside: list[tuple[str, bytes]] = []
        self._result: str | None = None
        self._worlds: set[str] = set()  # tokens
        self._world_is_there = False
        self._result_key = world_key(run, "result")
        self._result_due = inf
        self._written = self._flushed = time.monotonic()
        self._overdue = self.deadline = self._written + patience
        self._given_up = inf  # when who writes counts as gone for good
        bus.watch(world_tokens(run))

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            if event.key == self._result_key:
                self._on_result(event)
                return
            if self._heard is None:
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
        self._listen()
        if now >= self._written + _WRITE_PERIOD:
            self._write(now)
        self.deadline = now + (_WRITE_PERIOD if self._heard is None else _HEARING_PERIOD)

    def close(self) -> None:
        """Hand over what is there; what happens later is not recorded."""
        while not self.finished and (event := self._bus.receive(0.0)) is not None:
            self.handle(event)
        if not self.finished:
            self.finished, self.deadline = True, inf
            self._listen()
            self._write(time.monotonic(), last=True)
            if self._result is not None:
                self._file.report(self._result)

    def wind_up(self, patience: float) -> None:
        """Go on until the result is there, `patience` (s) at most: for a process told to stop."""
        until = time.monotonic() + patience
        while not self.finished and self._result is None and (rest := until - time.monotonic()) > 0.0:
            event = self._bus.receive(rest)
            if event is not None:
                self.handle(event)
        self.close()

    def _on_world(self, alive: bool) -> None:
        self._world_is_there = alive
        self._back_by = inf if alive else time.monotonic() + self._away
        if not alive and not self._away:
            self.close()
        elif alive and not self._ready:
            self._begin(time.monotonic())

    def _begin(self, now: float) -> None:
        """Ask for the scenario; whoever does not answer, or not as a world does, is asked again."""
        scenario = self._scenario() if self._world_is_there else None
        if scenario is None:
            if now >= self._overdue:
                lacking = (
                    "the world does not send its scenario" if self._world_is_there else "no world to record"
                )
                raise BusError(f"run {self._run!r}: {lacking} within {self._patience:g} s")
            self.deadline = min(self._overdue, now + _ASK_AGAIN) if self._world_is_there else self._overdue
            return
        self._file.begin(self._run, scenario)
        self._bus.expect(_every_tick(self._run, scenario.ids))
        self._ready = True
        self.deadline = time.monotonic()
        if self._on_ready is not None:
            self._on_ready()

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
            if self._heard is None:
                self._aside.append((sample.key, sample.payload))  # to be counted with the others
            return
        if isinstance(message, Result) and self._result is None:
            self._result, self._result_due = message.report, time.monotonic() + _LAST_WORDS

    def _listen(self) -> None:
        if self._heard is not None:
            self._aside += self._heard()

    def _write(self, now: float, *, last: bool = False) -> None:
        if not self._ready:
            return
        self._written = now
        try:
            if self._aside:
                self._file.write(self._aside)
                self._aside = []
            if last or now >= self._flushed + _FLUSH_PERIOD:
                self._flushed = now
                self._file.flush()
            self._given_up = inf
        except RecordingError:
            self._given_up = min(self._given_up, now + self._away)
            if last or now >= self._given_up:
                raise


def _every_tick(run: str, robots: Iterable[int]) -> Iterator[str]:
    """The keys under which most is said."""
    for robot in robots:
        for stream in ("tick", "state", "command"):
            yield robot_key(run, robot, stream)
