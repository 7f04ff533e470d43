"""Processes beside the fleet end with the launcher's word, and by nothing that the whole group is told."""

from __future__ import annotations

import os
import signal
import socket
import time
from multiprocessing.connection import Connection as Channel
from typing import Any

import pytest

from deploy.run.topology import Routed
from deploy.studies.endurance import side_process
from deploy.studies.endurance.cables import Cables
from deploy.studies.flooding.flooder import Flooder
from protocol.bus.connection import Connection
from protocol.errors import ProcessError
from protocol.process.signals import ENDING
from tests.deploy.processes.test_spawn import gone
from tests.scripts import ended


def test_cables_end_with_the_launcher_alone() -> None:
    with Cables(Routed("tcp/127.0.0.1:1"), [1], "test") as cables:
        cables.topology()
        for number in ENDING:
            os.kill(cables.pid, number)
        cables._process.join(0.3)
        assert cables._process.is_alive()
        pid = cables.pid
    assert gone(pid)


@pytest.mark.process
def test_a_flooder_that_a_silent_router_holds_up_ends_before_the_router(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The fleet, and its router with it, is taken down once whoever floods it is."""
    monkeypatch.setattr(side_process, "_PATIENCE", 1.5)
    monkeypatch.setattr(side_process, "_LEAVING", 0.1, raising=False)
    with socket.create_server(("127.0.0.1", 0)) as router:  # links come up, and nobody ever speaks
        endpoint = f"tcp/127.0.0.1:{router.getsockname()[1]}"
        flooder = Flooder(Connection(connect=(endpoint,), timeout=60.0), "test", (1,), 1.0)
        with pytest.raises(ProcessError, match="'flooder' sends nothing"), flooder:
            flooder.connected()
        assert not flooder._process.is_alive()


def hold_out(channel: Channel[Any, Any]) -> None:
    """Whatever it is told, and whoever is gone."""
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)
    channel.send(None)
    while True:
        time.sleep(1.0)


@pytest.mark.process
def test_one_that_nobody_has_entered_does_not_hold_up_the_end_of_the_command() -> None:
    done = ended("""
from deploy.studies.endurance import side_process
from tests.deploy.studies.endurance.test_side_process import hold_out
side_process._LEAVING = 0.1
beside = side_process.SideProcess("stuck", hold_out)
beside._hear()
""")
    assert (done.returncode, done.stderr) == (0, "")
