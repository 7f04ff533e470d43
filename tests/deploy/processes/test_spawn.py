"""The fork server: what becomes of a process, what it says, and that none is left behind."""

import os
import re
import signal
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from deploy.processes.fork_server import FAULT
from deploy.processes.spawn import Exited, News, Process, ProcessReport, Spawner
from protocol.errors import ProcessError
from tests.deploy.processes import children
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(60)]

PATIENCE = 20.0  # s


def until_exit(spawner: Spawner) -> list[News]:
    heard: list[News] = []
    until(lambda: heard.extend(spawner.news(1.0)) or (heard and isinstance(heard[-1], Exited)), PATIENCE)
    return heard


def gone(pid: int) -> bool:
    """Whether a process is no more, or dead and not yet waited for."""
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


@pytest.mark.parametrize(
    ("function", "code", "reports", "said"),
    [
        ("divide_by_zero", FAULT, [], r"calculator: failed:\nTraceback .*return 1 / 0.*"),
        ("fail_politely", FAULT, [], r"calculator: the cable is unplugged\n"),
        ("print_and_report", 0, ["reported"], r"printed\n"),
    ],
)
def test_what_a_process_prints_goes_to_standard_error(
    function: str, code: int, reports: list[str], said: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with closing(children.spawner()) as spawner:  # whose standard error is that of this test
        spawner.start(Process("calculator", f"{children.__name__}:{function}", reports=bool(reports)))
        heard = until_exit(spawner)
        assert [news.text for news in heard if isinstance(news, ProcessReport)] == reports
        assert (heard[-1].code, heard[-1].max_rss_mb > 1.0) == (code, True)
        printed = capfd.readouterr()
        assert printed.out == ""
        assert re.fullmatch(said, printed.err, re.DOTALL)


def test_a_dead_fork_server_takes_all_with_it_and_is_named() -> None:
    with closing(children.spawner()) as spawner:
        life = spawner.start(Process("one", "tests.deploy.processes.children:wait"))
        (started,) = spawner.news(PATIENCE)
        os.kill(psutil.Process(started.pid).ppid(), signal.SIGKILL)
        until(lambda: gone(started.pid))
        with pytest.raises(ProcessError, match="fork server"):
            list(spawner.news(PATIENCE))
        with pytest.raises(ProcessError, match="fork server"):
            spawner.signal(life, signal.SIGTERM)


def test_a_signal_to_all_processes_leaves_the_end_to_the_supervisor() -> None:
    with closing(children.spawner()) as spawner:
        life = spawner.start(Process("one", "tests.deploy.processes.children:wait"))
        (started,) = spawner.news(PATIENCE)
        os.kill(psutil.Process(started.pid).ppid(), signal.SIGTERM)
        spawner.signal(life, signal.SIGKILL)
        assert until_exit(spawner)[-1].code == -signal.SIGKILL


def test_no_orphans_when_the_supervisor_is_killed_though_one_is_frozen(tmp_path: Path) -> None:
    path = tmp_path / "pids"
    code = f"from tests.deploy.processes.children import supervise; supervise({str(path)!r}, ['a', 'b', 'c'])"
    supervisor = subprocess.Popen([sys.executable, "-c", code])
    until(lambda: path.exists() or supervisor.poll() is not None)
    pids = [int(pid) for pid in path.read_text().split()]
    assert len(pids) == 3
    os.kill(pids[0], signal.SIGSTOP)
    supervisor.kill()
    supervisor.wait()
    until(lambda: all(map(gone, pids)))


def test_without_help_of_the_kernel_a_pipe_ends_a_process() -> None:
    code = "import sys, time; from deploy.processes.fork_server import end_with_pipe as end"
    reading, writing = os.pipe()
    call = [sys.executable, "-c", f"{code}; end(int(sys.argv[1])); time.sleep(60.0)", str(reading)]
    with subprocess.Popen(call, pass_fds=[reading]) as process:
        os.close(reading)
        os.close(writing)
        assert process.wait(PATIENCE) == -signal.SIGKILL
