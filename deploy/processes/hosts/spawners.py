"""Starts the processes of a table of hosts, each on its host."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator, Mapping
from itertools import count
from multiprocessing.connection import wait
from pathlib import Path

from deploy.processes.fork_server import FAULT
from deploy.processes.hosts.ssh import BEAT, SshSpawner
from deploy.processes.hosts.table import HostsTable
from deploy.processes.spawn import Exited, News, Process, Spawner
from protocol.errors import ProcessError
from protocol.process.log import LOG

_GREETING = 30.0  # s for all hosts to answer


class HostSpawners:
    """Spawners of this machine and of all other hosts, with the interface of a `Spawner`.

    The processes of a lost host count as ended, with a reason; that is no error.

    Args:
        table: the hosts; those without ssh are this machine; None: this machine alone.
        places: name of a process -> name of its host; all others are started here.
        run: name of the run, for process titles.
        logs: folder of the log files of this machine's processes and of every host, if any.

    Raises:
        ProcessError: a host cannot be reached.
    """

    def __init__(
        self,
        table: HostsTable | None,
        places: Mapping[str, str],
        run: str,
        logs: Path | None = None,
    ) -> None:
        self._places = places
        self._numbers = count(1)  # of processes, on all hosts
        self._here = Spawner(run=run, logs=logs, lives=self._numbers)
        there = [host for host in table.hosts if host.ssh] if table is not None else []
        self._there = {host.name: SshSpawner(host, run, logs, self._numbers) for host in there}
        self._lives: dict[int, Spawner] = {}  # process number -> spawner, of running processes
        self._own: deque[News] = deque()  # of processes on lost hosts

    @property
    def gone(self) -> bool:
        """Whether this machine's own fork server has ended."""
        return self._here.gone

    def greet(self) -> None:
        """Wait until every host answers."""
        deadline = time.monotonic() + _GREETING
        for spawner in self._there.values():
            spawner.greet(deadline - time.monotonic())

    def folder(self, host: str) -> str | None:
        """Folder of a host for files of its processes; None for this machine."""
        return self._there[host].folder if host in self._there else None

    def store(self, host: str, path: Path) -> None:
        """Copy a file to a host's folder, with mode 0600; ignored for a lost host."""
        if self._there[host].gone:
            return
        self._there[host].store(path.name, path.read_bytes())

    def start(self, process: Process) -> int:
        """`Spawner.start`, on the host of the process."""
        spawner = self._there.get(self._places.get(process.name, ""), self._here)
        if not spawner.gone:
            try:
                life = spawner.start(process)
            except ProcessError as error:
                self._lose(spawner, error)
            else:
                self._lives[life] = spawner
                return life
        life = next(self._numbers)
        self._own.append(Exited(life, FAULT, 0.0, 0.0, f"{self._name(spawner)} is lost"))
        return life

    def signal(self, life: int, number: int) -> None:
        """`Spawner.signal`."""
        if life not in self._lives:
            return
        spawner = self._lives[life]
        try:
            spawner.signal(life, number)
        except ProcessError as error:
            self._lose(spawner, error)

    def news(self, timeout: float) -> Iterator[News]:
        """`Spawner.news`, of all hosts."""
        spawners = {each.fileno(): each for each in self._all() if not each.gone}
        # Never wait longer than the interval of heartbeats.
        ready = wait(list(spawners), 0.0 if self._own else min(timeout, BEAT))
        del ready  # each process with news is read below
        for spawner in spawners.values():
            try:
                for news in spawner.news(0.0):
                    yield self._checked(spawner, news)
            except ProcessError as error:
                self._lose(spawner, error)
        while self._own:
            yield self._own.popleft()

    def close(self) -> None:
        """End all fork servers and their processes, on all hosts that can be reached."""
        for spawner in self._all():
            spawner.hang_up()
        for spawner in self._all():
            spawner.close()

    def _all(self) -> list[Spawner]:
        return [self._here, *self._there.values()]

    def _checked(self, spawner: Spawner, news: News) -> News:
        if self._lives.get(news.life) is not spawner:
            raise ProcessError(f"{self._name(spawner)} reports a process that it was not asked for")
        if isinstance(news, Exited):
            del self._lives[news.life]
        return news

    def _name(self, spawner: Spawner) -> str:
        return next((f"host {name}" for name, each in self._there.items() if each is spawner), "this host")

    def _lose(self, spawner: Spawner, error: ProcessError) -> None:
        if spawner is self._here:
            raise error
        LOG.error(error)
        spawner.gone = True
        spawner.hang_up()
        for life in [life for life, of in self._lives.items() if of is spawner]:
            del self._lives[life]
            self._own.append(Exited(life, FAULT, 0.0, 0.0, str(error)))
