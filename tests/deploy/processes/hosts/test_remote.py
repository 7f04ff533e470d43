"""The far end of a connection: it leaves nothing behind, however the connection ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from deploy.processes.spawn import News, ProcessReport, Start, Store, decode_news
from deploy.software import SOFTWARE, code_digest
from tests.deploy.processes.children import row, wait
from tests.deploy.processes.test_spawn import gone
from tests.system.hosts.testbed.ssh_server import ROOT
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(60)]

CODE = (
    "import signal; signal.signal(signal.SIGHUP, signal.SIG_DFL); "  # nohup has hangups ignored
    "from deploy.processes.hosts.remote import main; main(('tests.deploy.processes.children',), {patience})"
)


class FarEnd(NamedTuple):
    process: subprocess.Popen[bytes]
    requests: Channel[Any, Any]
    answers: Channel[Any, Any]
    folder: Path

    def news(self) -> News:
        assert self.answers.poll(20.0)
        return decode_news(self.answers.recv_bytes())

    def start(self) -> int:
        self.requests.send(Start(1, row("one", wait, reports=True)))
        started, report = self.news(), self.news()
        assert isinstance(report, ProcessReport)
        return started.pid


@contextmanager
def far_end(patience: float = 60.0) -> Iterator[FarEnd]:
    process = subprocess.Popen(
        [sys.executable, "-c", CODE.format(patience=patience)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        bufsize=0,
    )
    greeting = process.stdout.readline().decode().split()
    assert greeting[:2] == ["disknav-host", code_digest(SOFTWARE)]
    requests: Channel[Any, Any] = Channel(os.dup(process.stdin.fileno()), readable=False)
    answers: Channel[Any, Any] = Channel(os.dup(process.stdout.fileno()), writable=False)
    process.stdin.close()
    process.stdout.close()
    try:
        yield FarEnd(process, requests, answers, Path(greeting[2]))
    finally:
        for channel in (requests, answers):
            with suppress(OSError):
                channel.close()
        process.terminate()
        process.wait(20.0)


@pytest.mark.parametrize("number", [0, signal.SIGTERM, signal.SIGHUP], ids=["silence", "term", "hangup"])
def test_a_host_that_goes_down_or_hears_nothing_keeps_neither_keys_nor_processes(number: int) -> None:
    with far_end(patience=60.0 if number else 2.0) as far:
        far.requests.send(Store("robot-1.key", b"secret"))
        pid = far.start()
        assert (far.folder / "robot-1.key").exists()
        far.process.send_signal(number)
        assert far.process.wait(20.0) == 0
        until(lambda: gone(pid))
        assert not far.folder.exists()


def test_files_are_their_owners_alone_and_stay_in_the_folder() -> None:
    with far_end() as far:
        for name in ("robot-1.key", "../robot-2.key", "robot-1.key"):
            far.requests.send(Store(name, b"secret"))
        far.start()
        modes = {path.name: oct(path.stat().st_mode & 0o777) for path in far.folder.iterdir()}
        assert modes == {"robot-1.key": "0o600", "robot-2.key": "0o600"}
        assert far.folder.stat().st_mode & 0o777 == 0o700
