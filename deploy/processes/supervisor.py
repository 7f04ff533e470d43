"""Starts, watches and stops the processes of a table. One per fleet; no process outlives it.

After the second failure in a row a restart is delayed, exponentially with a cap, as by systemd's RestartSteps
and Kubernetes' CrashLoopBackOff.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from types import MappingProxyType
from typing import NamedTuple, Self

import psutil

from deploy.processes.fork_server import FAULT
from deploy.processes.spawn import BEAT, MAX_NEWS, Exited, News, Process, ProcessReport, Spawner, Started
from protocol.errors import ProcessError, StartError
from protocol.process.log import LOG
from protocol.process.signals import STOP

STEADY = 60.0  # s of run time after which a failure counts as the first
_FIRST = 0.25  # s, after the second failure in a row
_LONGEST = 10.0  # s, well below the time that a world waits for a robot
_MOST = 1000  # unread reports
_UNHEARD = 2 * MAX_NEWS  # characters of unread reports


class Exit(NamedTuple):
    """End of a process."""

    process: Process
    code: int
    expected: bool  # it was told to end, or finished with status 0
    again: bool = False  # it is restarted automatically
    why: str = ""  # reason, if the code does not tell it

    def __str__(self) -> str:
        if self.why:
            return f"{self.process.name}: {self.why}"
        if self.code >= 0:
            return f"{self.process.name}: exit status {self.code}"
        known = {each.value: each.name for each in signal.Signals}
        return f"{self.process.name}: killed by {known.get(-self.code, f'signal {-self.code}')}"


class Usage(NamedTuple):
    """Resources used by all processes of one row so far."""

    name: str
    pid: int  # of the latest process
    exit_code: int | None  # of the latest process; None while it runs
    restarts: int
    cpu_s: float
    max_rss_mb: float


@dataclass
class ProcessLife:
    """One row with its latest process."""

    process: Process
    spawner: Spawner  # of its host
    number: int = 0  # given by its spawner; 0: it could not be started
    pid: int = 0
    exit_code: int | None = None
    up: bool = False  # a process of the row has worked, or ended without saying why: another may be started
    told_to_end: bool = False
    again: bool = False  # restart it as soon as it has ended
    began: float = 0.0  # s, monotonic: start of the latest process
    due: float | None = None  # s, monotonic: start of the next process, if one is scheduled
    in_a_row: int = 0  # failures without a steady life between them
    restarts: int = 0
    failures: int = 0
    report: str | None = None  # the first of the latest process
    unheard: list[str] = field(default_factory=list)  # all unread reports
    cpu_s: float = 0.0  # of ended processes
    max_rss_mb: float = 0.0

    def on_report(self, text: str) -> None:
        """Keep the newest unread reports of a process; a hostile host may never stop sending."""
        if not self.process.reports:
            return
        self.up = True
        self.report = self.report or text
        self.unheard.append(text)
        while len(self.unheard) > _MOST or sum(map(len, self.unheard)) > _UNHEARD:
            del self.unheard[0]

    def wait(self, lived: float) -> float:
        """Delay before the next restart, s, after a failure at the age of `lived` s."""
        self.in_a_row = 1 if lived >= STEADY else self.in_a_row + 1
        return 0.0 if self.in_a_row == 1 else min(_LONGEST, _FIRST * 2.0 ** min(self.in_a_row - 2, 16))

    @property
    def over(self) -> bool:
        """Whether its process has ended, and no restart is scheduled."""
        return self.exit_code is not None and self.due is None

    def usage(self) -> Usage:
        """Resources used so far, including those of a running process."""
        cpu, rss = self.cpu_s, self.max_rss_mb
        if self.exit_code is None and self.pid:
            try:
                now = psutil.Process(self.pid)
                times = now.cpu_times()
                cpu, rss = cpu + times.user + times.system, max(rss, now.memory_info().rss / 1e6)
            except psutil.Error:  # it has ended since the last poll
                pass
        return Usage(self.process.name, self.pid, self.exit_code, self.restarts, cpu, rss)


_POLL = 0.05  # s
_SAID, _LAST = (2, 3, 4), 4  # exit statuses: the reason is reported; no successor could go on, either
_STOPPING = 30.0  # s from SIGKILL to the end of a process


class Supervisor:
    """A context manager that stops all processes when it is left.

    The processes of a lost host count as ended, with a reason; that is no error.

    Args:
        here: starts processes on this machine; a new `Spawner` by default.
        there: start processes on other hosts, by the names of these.
        places: name of a process -> name of its host; all others are started here.

    Raises:
        ProcessError: the fork server of this machine is gone, and with it all processes.
    """

    def __init__(
        self,
        here: Spawner | None = None,
        there: Mapping[str, Spawner] = MappingProxyType({}),
        places: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._here = Spawner() if here is None else here
        self._there, self._places = there, places
        self._lives: dict[str, ProcessLife] = {}
        self._running: dict[tuple[Spawner, int], ProcessLife] = {}  # by number, which its spawner gave
        self._exits: list[Exit] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.stop()
        finally:
            for spawner in (self._here, *self._there.values()):
                spawner.hang_up()
            for spawner in (self._here, *self._there.values()):
                spawner.close()

    def start(self, table: Iterable[Process]) -> None:
        """Start the rows in order, without waiting."""
        for process in table:
            if process.name in self._lives:
                raise ProcessError(f"{process.name} is in the table twice; names must be unique")
            spawner = self._there.get(self._places.get(process.name, ""), self._here)
            self._spawn(ProcessLife(process, spawner))

    def report(self, name: str, timeout: float) -> str:
        """First text from a reporting process.

        Raises:
            StartError: it could not start; its message is on standard error.
            ProcessError: it was killed, or sent no text within `timeout` s.
            Stopped: a signal tells this process to end.
        """
        life = self._life(name)
        self._advance(timeout, lambda: life.report is not None or life.over or STOP.requested)
        STOP.check()
        code = life.exit_code if life.over else None
        if life.report is None and code in _SAID:
            raise StartError(f"{name} could not start; see its output above")
        if life.report is None and code is not None:
            raise ProcessError(f"{Exit(life.process, code, expected=False)} before it had started")
        if life.report is None:
            raise ProcessError(f"{name} did not answer within {timeout:g} s; see its output above")
        return life.report

    def up(self, names: Iterable[str]) -> None:
        """Mark processes that work; those that report are marked automatically.

        A process that ends with status 2 or 3 before it is marked could not start, and is not restarted
        automatically; nor is one that ends with status 4, since none could go on.
        """
        for name in names:
            if name in self._lives:
                self._lives[name].up = True

    def amend(self, process: Process) -> None:
        """Replace the row of this name, for its next process."""
        self._life(process.name).process = process

    def heard(self, name: str) -> list[str]:
        """Unread texts from the processes of this row."""
        life = self._life(name)
        heard, life.unheard = life.unheard, []
        return heard

    def poll(self, timeout: float = 0.0) -> list[Exit]:
        """Exits since the last call; waits at most `timeout` s for the first."""
        self._read(timeout)
        exits, self._exits = self._exits, []
        return exits

    def signal(self, name: str, number: int) -> None:
        """Send any signal to one process, if it runs."""
        life = self._life(name)
        if (life.spawner, life.number) in self._running:
            try:
                life.spawner.signal(life.number, number)
            except ProcessError as error:
                self._lose(life.spawner, error)

    def kill(self, name: str, *, gently: bool = False) -> None:
        """Send SIGKILL, `gently` SIGTERM, and do not restart it automatically."""
        life = self._life(name)
        life.told_to_end, life.again, life.due = True, False, None
        self.signal(name, signal.SIGTERM if gently else signal.SIGKILL)

    def pause(self, name: str) -> None:
        """Send SIGSTOP."""
        self.signal(name, signal.SIGSTOP)

    def resume(self, name: str) -> None:
        """Send SIGCONT."""
        self.signal(name, signal.SIGCONT)

    def restart(self, name: str) -> None:
        """Kill the process if it runs, and start it again once it has ended."""
        life = self._life(name)
        if life.exit_code is not None:
            self._again(life)
            return
        before = life.number
        life.told_to_end = life.again = True
        self.signal(name, signal.SIGKILL)
        self._advance(_STOPPING, lambda: life.number != before)

    @property
    def names(self) -> tuple[str, ...]:

        return tuple(self._lives)

    def running(self) -> list[str]:
        """Names of the running processes, as of the last `poll`."""
        return [name for name, life in self._lives.items() if life.exit_code is None]

    def stop(self, spare: Collection[str] = ()) -> None:
        """Send SIGTERM, then SIGCONT, to all but those to `spare`; SIGKILL after the patience of each row."""

        def left() -> list[str]:
            return [name for name in self.running() if name not in spare]

        for name, life in self._lives.items():
            if name not in spare:
                life.told_to_end, life.again, life.due = True, False, None
        if self._here.gone:
            return
        self._signal(left(), signal.SIGTERM, signal.SIGCONT)
        patience = {name: self._lives[name].process.patience for name in left()}
        began = time.monotonic()
        for limit in sorted(set(patience.values())):
            self._advance(began + limit - time.monotonic(), lambda: not left())
            self._signal([name for name in left() if patience[name] <= limit], signal.SIGKILL)
        self._advance(_STOPPING, lambda: not left())
        if left():
            raise ProcessError(f"not even SIGKILL ended {', '.join(left())}")

    def usage(self) -> list[Usage]:
        """Resources used by each row so far."""
        return [life.usage() for life in self._lives.values()]

    def _spawners(self) -> Iterator[Spawner]:
        """Those that can start processes."""
        return (each for each in (self._here, *self._there.values()) if not each.gone)

    def _life(self, name: str) -> ProcessLife:
        if name not in self._lives:
            raise ProcessError(f"no process {name!r}; there are {', '.join(self._lives)}")
        return self._lives[name]

    def _spawn(self, life: ProcessLife) -> None:
        process = life.process
        self._lives[process.name] = life
        life.exit_code, life.report, life.told_to_end, life.again = None, None, False, False
        life.began, life.due, life.number = time.monotonic(), None, 0
        if life.spawner.gone:
            self._ended(life, FAULT, why=f"{life.spawner.name} is lost")
            return
        try:
            life.number = life.spawner.start(process)
        except ProcessError as error:
            self._lose(life.spawner, error)
            self._ended(life, FAULT, why=str(error))
        else:
            self._running[life.spawner, life.number] = life

    def _again(self, life: ProcessLife) -> None:
        life.restarts += 1
        self._spawn(life)

    def _signal(self, names: Iterable[str], *numbers: int) -> None:
        for number in numbers:
            for name in names:
                self.signal(name, number)

    def _advance(self, timeout: float, done: Callable[[], bool]) -> None:
        deadline = time.monotonic() + timeout
        while not done() and (remaining := deadline - time.monotonic()) > 0.0:
            self._read(min(_POLL, remaining))

    def _read(self, timeout: float) -> None:
        channels = [spawner.fileno() for spawner in self._spawners()]
        due = [life.due - time.monotonic() for life in self._lives.values() if life.due is not None]
        wait(channels, max(0.0, min([timeout, BEAT, *due])))
        for spawner in self._spawners():  # also those without news: they send heartbeats
            try:
                for news in spawner.news(0.0):
                    self._take(spawner, news)
            except ProcessError as error:
                self._lose(spawner, error)
        for life in self._lives.values():
            if life.due is not None and time.monotonic() >= life.due:
                self._again(life)

    def _take(self, spawner: Spawner, news: News) -> None:
        life = self._running.get((spawner, news.life))
        if life is None:
            raise ProcessError(f"{spawner.name} reports a process that it was not asked for")
        if isinstance(news, Started):
            life.pid = news.pid
        elif isinstance(news, ProcessReport):
            life.on_report(news.text)
        elif isinstance(news, Exited):
            life.cpu_s += news.cpu_s
            life.max_rss_mb = max(life.max_rss_mb, news.max_rss_mb)
            self._ended(life, news.code)

    def _lose(self, spawner: Spawner, error: ProcessError) -> None:
        if spawner is self._here:
            raise error
        LOG.error(error)
        spawner.gone = True
        spawner.hang_up()
        for life in [life for (host, _), life in self._running.items() if host is spawner]:
            self._ended(life, FAULT, why=str(error))

    def _ended(self, life: ProcessLife, code: int, why: str = "") -> None:
        self._running.pop((life.spawner, life.number), None)
        life.exit_code = code
        failed = code != 0 and not life.told_to_end
        life.failures += failed
        life.up = code not in _SAID or (life.up and code != _LAST)
        again = life.again or (
            failed and life.up and not life.spawner.gone and life.failures <= life.process.restarts
        )
        self._exits.append(Exit(life.process, code, not failed, again, why))
        if life.again:
            self._again(life)
        elif again:
            life.due = time.monotonic() + life.wait(time.monotonic() - life.began)
