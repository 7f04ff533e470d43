"""A fleet of real processes: started, watched and stopped."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from resource import RLIMIT_NOFILE, getrlimit
from typing import Any

from deploy.processes import table
from deploy.processes.supervisor import Exit
from deploy.run.assembly import Assembly, Topology, places
from deploy.run.launcher import Launcher, OnClock
from deploy.run.options import RunOptions
from deploy.run.result import INTERRUPTED, RunReport, read_report, unjudged
from deploy.security.roster import MONITOR, WORLD, robot_role
from protocol.bus.bus import Event, Sample
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.errors import MessageError, ProcessError, RecordingError, RunTakenError
from protocol.keys import world_key
from protocol.messages import Clock
from protocol.process.log import LOG
from protocol.process.signals import STOP
from protocol.scenario.model import FaultKind, Scenario
from world.process import REFUSED

_LAST_WORDS = 5.0  # s for the report of an interrupted world
_LEAVING = 2.0  # s for processes to end by themselves after the run
_POLL = 0.02  # s
_FILES = 32  # that a process has open, besides one for each robot
_TOGETHER = 0.3  # s in which a signal that was sent to all processes arrives here, too
_IMPATIENT = 2  # signals after which the report is not waited for
ENOUGH = "ended as planned"  # reason of a run that `enough` ends


class Fleet:
    """The processes of a run, whose scenario has k as a number; a context manager.

    `watch` is called with every Clock received.

    Raises:
        ProcessError, BusError: a process did not start, or an endpoint is taken.
    """

    def __init__(
        self,
        scenario: Scenario,
        options: RunOptions,
        *,
        watch: OnClock = lambda _: None,
        record: Path | None = None,
    ) -> None:
        self._scenario, self._options = scenario, options
        self._watch, self._record = watch, record
        self._launcher = Launcher(scenario, self)
        self._clock: Clock | None = None
        self._succeeded = False  # whether a world has ended; its successor may find its token still there
        self._began = time.monotonic()
        self._report: RunReport | None = None
        self._leaving = _LEAVING
        self._stack = ExitStack()
        self.rejected: Counter[str] = Counter()  # invalid messages, by reason

    def __enter__(self) -> Fleet:
        needed = _FILES + len(self._scenario.robots)
        if 0 <= getrlimit(RLIMIT_NOFILE)[0] < needed:
            raise ProcessError(f"too few files may be open in a process: allow more by `ulimit -n {needed}`")
        with ExitStack() as stack:
            self._assembly = Assembly(self._scenario, self._options, self._record, stack)
            self.supervisor = self._assembly.supervisor
            self._listen(stack)  # before the robots start, so that no Clock of a short run is missed
            self.supervisor.start(self._assembly.robots())
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *details: object) -> None:
        self._stack.close()

    @property
    def topology(self) -> Topology:
        """Endpoints and links of all processes."""
        return self._assembly.topology

    def _listen(self, stack: ExitStack) -> None:
        self._bus = ZenohBus(self.topology.connection(MONITOR))
        stack.callback(self._bus.close)
        self._bus.subscribe(world_key(self._options.run, "clock"))

    def execute(self, enough: Callable[[], bool] = lambda: False) -> RunReport:
        """Watch the run until its report arrives, or `enough` returns true.

        Signals and lost processes also end the run; its report then gives the reason and the world's measures
        so far. After a second signal the world is not waited for. Raises RunTakenError.
        """
        verdict, reason = self._ending(enough)
        if verdict:
            LOG.info(f"{verdict}: {reason}")
            self._await_last_words()
        report = self._report
        if report is None:
            report = unjudged(self._scenario, self._clock, time.monotonic() - self._began)
        if self._report is None or (verdict and report["verdict"] == "interrupted"):
            report.update(verdict=verdict, reason=reason)
        return report

    def _ending(self, enough: Callable[[], bool]) -> tuple[str, str]:
        """Watch the run; verdict and reason if it is cut short, empty otherwise."""
        while not (self._report or STOP.requested or enough()):
            self._take(self._bus.receive(_POLL))
            if (loss := self._loss(self._poll())) and not STOP.wait(_TOGETHER):
                return "aborted", loss
        if self._report:
            return "", ""
        return "interrupted", INTERRUPTED if STOP.requested else ENOUGH

    def processes(self) -> list[dict[str, Any]]:
        """Wait for the processes, stop the rest except the recorder, and return the resources of each."""
        deadline = time.monotonic() + self._leaving
        while not all(map(table.outlasts, self.supervisor.running())) and time.monotonic() < deadline:
            self.supervisor.poll(_POLL)
        self.supervisor.stop(spare=(table.RECORDER,))
        hosts = places(self._options.hosts)
        used = self.supervisor.usage()
        return [each._asdict() | ({"host": hosts[each.name]} if each.name in hosts else {}) for each in used]

    def recordings(self) -> list[str]:
        """Files of the recording: several if it rotates, or its recorder was restarted."""
        return [] if self._assembly.result is None else self.supervisor.heard(table.RECORDER)

    def record(self, result: Mapping[str, Any]) -> None:
        """Finish the recording, if any, with the result; raises RecordingError if the recorder failed."""
        if self._assembly.result is None:
            return
        self._assembly.result.write_text(json.dumps(result), encoding="utf-8")
        self.supervisor.stop()
        (code,) = (usage.exit_code for usage in self.supervisor.usage() if usage.name == table.RECORDER)
        if code != 0:
            raise RecordingError(f"{self._record} is incomplete: its recorder ended with status {code}")

    def _take(self, event: Event | None) -> None:
        if not isinstance(event, Sample):
            return
        try:
            message = decode(event.key, event.payload)
        except MessageError as error:
            self.rejected[error.reason] += 1
            return
        if isinstance(message, Clock):
            self._clock = message
            self.supervisor.up((WORLD, *map(robot_role, message.active)))
            self._launcher.follow(message)
            self._watch(message)

    def _poll(self) -> list[Exit]:
        """Ended processes. The world reports over its pipe here: a published result may be lost, or arrive
        after its end. A restarted world may report again.
        """
        exits = self.supervisor.poll()
        for text in self.supervisor.heard(WORLD):
            try:
                report = read_report(text)
            except MessageError as error:  # from a host that an attacker controls
                self.rejected[error.reason] += 1
                continue
            if self._report is None:
                if report["verdict"] != "arrived":
                    report["reason"] = f"{report['reason']}{self._assembly.expired}".removeprefix("; ")
                self._report = report
        return exits

    # -- RobotProcesses

    def knows(self, robot: int) -> bool:
        return robot_role(robot) in self.supervisor.names

    def runs(self, robot: int) -> bool:
        return robot_role(robot) in self.supervisor.running()

    def act(self, robot: int, event: FaultKind) -> None:
        getattr(self.supervisor, event)(robot_role(robot))

    def welcome(self, robot: int) -> bool:
        self._assembly.start_newcomer(robot)
        return True

    def _loss(self, exits: Sequence[Exit]) -> str:
        """Take note of ended processes. Returns why the run cannot continue: without world or router, or if
        a process failed before the first tick; otherwise "".
        """
        for exit_ in exits:
            LOG.info(str(exit_))
            if exit_.process.name == WORLD:
                if exit_.code == REFUSED and not self._succeeded:
                    raise RunTakenError(f"run {self._options.run!r} is another world's: choose another name")
                self._succeeded = True
            robot = table.robot_of(exit_.process.name)
            if exit_.code == 0 and robot is not None:  # the robot was removed
                self._launcher.removed(robot)
            if exit_.again and not exit_.expected:
                LOG.warning(f"{exit_}; restarting it")
            if exit_.again:
                continue
            if exit_.process.name == table.RECORDER:
                LOG.error(f"{exit_}; the recording ends there")
            tolerable = exit_.expected or (self._clock is not None and self._clock.tick > 0)
            if (exit_.process.vital and not self._report) or not tolerable:
                return f"{exit_}{self._assembly.expired}"
        return ""

    def _await_last_words(self) -> None:
        self._poll()
        if self._options.restarts:
            self._leaving = 0.0  # robots would wait for a restarted world
        if WORLD in self.supervisor.running():
            self.supervisor.kill(WORLD, gently=True)
            deadline = time.monotonic() + _LAST_WORDS
            while (
                WORLD in self.supervisor.running() and time.monotonic() < deadline and STOP.count < _IMPATIENT
            ):
                self._take(self._bus.receive(_POLL))
                self._poll()
