"""A base on the bus, whose computer may sleep."""

from __future__ import annotations

import time

import pytest

from agents.bases.dialects import TWIST, Topic
from agents.robot import Robot
from agents.shell.attached_base import AttachedBase
from agents.shell.ros_link import RosLink
from deploy.library.load import load
from protocol.bus.local import LocalNetwork
from protocol.scenario.body import Base


class Told:
    """A base that notes what time it is told, and wants to be woken 0.1 s later."""

    hears, tells, note, due = (), Topic("cmd_vel", TWIST), "waits", 0.0

    def wake(self, now):
        self.now, self.due = now, now + 0.1
        return ()

    stand = wake


def test_time_passes_for_a_base_while_its_computer_is_suspended():
    asleep = 0.0
    base = Told()
    link = RosLink(LocalNetwork().connect(), Base())
    attached = AttachedBase(base, link, lambda _: None, lambda: time.monotonic() + asleep)
    core = Robot(load("turtlebots-2"), 1, 1)
    attached.wake(core, founded=True)
    before = base.now
    assert attached.due == pytest.approx(time.monotonic() + 0.1, abs=0.09)  # monotonic, and to come
    asleep = 3600.0
    assert attached.due < time.monotonic() - 3000.0  # long over
    attached.stand(core, founded=True)
    assert base.now - before >= 3600.0
