"""Processes beside the fleet end with the launcher's word, and by nothing that the whole group is told."""

from __future__ import annotations

import os

from deploy.run.topology import Routed
from deploy.studies.endurance.cables import Cables
from protocol.process.signals import ENDING
from tests.deploy.processes.test_spawn import gone


def test_cables_end_with_the_launcher_alone() -> None:
    with Cables(Routed("tcp/127.0.0.1:1"), [1], "test") as cables:
        cables.topology()
        for number in ENDING:
            os.kill(cables.pid, number)
        cables._process.join(0.3)
        assert cables._process.is_alive()
        pid = cables.pid
    assert gone(pid)
