"""A base on the bus, whose computer may sleep."""

import time
from dataclasses import replace
from types import SimpleNamespace

import pytest

from agents.bases.base import topics_of
from agents.bases.dialects import ODOMETRY, TWIST, Topic
from agents.bases.ros2 import Ros2Base
from agents.robot import Robot
from agents.shell.attached_base import AttachedBase
from agents.shell.ros_link import RosLink
from deploy.library.load import load
from protocol.bus.bus import Presence
from protocol.bus.local import LocalNetwork
from protocol.messages import Sense, Tick
from protocol.scenario.body import Base


class Told:
    """A base that notes what time it is told, and wants to be woken 0.1 s later."""

    topics, drives, due = (), Topic("cmd_vel", TWIST), 0.0
    senses = SimpleNamespace(fault="waits")

    def on_timer(self, now):
        self.now, self.due = now, now + 0.1
        return b""

    def begin(self, tick, now):
        return None

    def stand(self, now):
        self.stood = now
        return b""


def test_time_passes_for_a_base_while_its_computer_is_suspended(monkeypatch: pytest.MonkeyPatch):
    asleep = 0.0
    monkeypatch.setattr(time, "clock_gettime", lambda _: time.monotonic() + asleep)
    base = Told()
    link = RosLink(LocalNetwork().connect(), Base())
    attached = AttachedBase(base, link, lambda _: None)
    core = Robot(load("turtlebots-2"), 1, 1)
    attached.on_timer(core, founded=True)
    before = base.now
    assert attached.due == pytest.approx(time.monotonic() + 0.1, abs=0.09)  # monotonic, and to come
    asleep = 3600.0
    assert attached.due < time.monotonic() - 3000.0  # long over
    attached.stand(core, founded=True)
    assert base.now - before >= 3600.0 <= base.stood - before


def test_a_robot_whose_measurements_contradict_each_other_is_lost_until_its_base_begins_anew():
    base, core, faults = Told(), Robot(load("turtlebots-2"), 1, 1), []
    for tick in (0, 1):
        core.begin(Tick(1, 1, tick, (1,)), Sense((0.1 * tick, 0.0), tick, 0.0, (0.0, 0.0)))
    attached = AttachedBase(base, RosLink(LocalNetwork().connect(), Base()), lambda _: None)
    for fault, anew in (("", False), ("waits", False), ("", True)):
        base.senses = SimpleNamespace(fault=fault, take_reset=[anew].pop, invalidate=faults.append)
        assert core.lost
        attached.begin(core, Tick(1, 1, 2, (1,)))
        assert len(faults) == 1
    assert not core.lost
    assert "exclude each other" in faults[0]


@pytest.mark.parametrize("founded", [False, True])
def test_a_robot_is_in_place_at_its_start_or_anywhere_once_its_run_has_begun(founded: bool) -> None:
    base, core, said = Told(), Robot(load("turtlebots-2"), 1, 1), list[str]()
    attached = AttachedBase(base, RosLink(LocalNetwork().connect(), Base()), said.append)
    (x, y), told = core.scenario.spec(1).start, list[tuple[bool, str, int]]()
    for away in 9.0, 8.0, 0.0, 9.0:
        base.senses = SimpleNamespace(fault="", place=lambda away=away: ((x + away, y), 0.01))
        attached.on_timer(core, founded=founded)
        told.append((attached.in_place, attached.trouble[:8], len(said)))
    expected = [(False, "stands 9", 1), (False, "stands 8", 1), (True, "", 2), (True, "", 2)]
    assert told == ([(True, "", 0)] * 4 if founded else expected)


def test_two_processes_that_drive_one_base_stand_until_one_is_gone():
    """Of one run or two, whatever ROS domain they name, since a bridge's topics have none; a robot whose base
    is its own is not disturbed."""
    scenario, network = load("turtlebots-2", ["world.plant=external"]), LocalNetwork()
    buses = [network.connect() for _ in range(3)]
    bases = [
        Ros2Base(scenario, robot, topics_of(scenario, robot, "/same" if robot == 1 else "/other"))
        for robot in (1, 1, 2)
    ]
    attached = [
        AttachedBase(base, RosLink(bus, replace(scenario.base_of(1), domain=number)), lambda _: None)
        for number, (base, bus) in enumerate(zip(bases, buses, strict=True))
    ]

    def on_message() -> None:
        for each, bus in zip(attached, buses, strict=True):
            each.on_driver(each._own, alive=True)
            while (event := bus.receive(0.0)) is not None:
                if isinstance(event, Presence):
                    each.on_driver(event.key, event.alive)

    on_message()
    text = "another process drives same/cmd_vel, of this or another run"
    assert [base.senses.fault for base in bases] == [text, text, "waits for odometry and a pose"]
    odometry = Topic("same/odom", ODOMETRY)
    bases[0].on_message(odometry, b"", 0.0)
    assert bases[0].senses.fault == text  # whatever its base says meanwhile
    buses[1].close()
    on_message()
    bases[0].on_message(odometry, b"", 0.0)
    assert bases[0].senses.fault.startswith("odometry: ")
