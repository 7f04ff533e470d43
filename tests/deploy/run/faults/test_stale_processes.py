"""Processes that live on although their robots' lives are over, while routers and worlds come and go: each is
told so, takes nobody's place, keeps nobody waiting, and no trajectory shows it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from agents.shell.node import RobotNode
from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.local import FaultInjector, LocalFleet
from deploy.run.options import RunOptions
from deploy.studies.falsify.runs.skipped_waits import skipped_waits
from protocol.bus.events import Event, Presence, Request
from protocol.bus.local import LocalBus
from protocol.keys import robot_key, world_key
from protocol.messages import Truth
from protocol.requests.joining import (
    Admission,
    Finished,
    Join,
    Refusal,
    Reply,
    Wait,
    decode_reply,
    encode_request,
)
from protocol.scenario.model import Order, ProcessFault, RobotSpec
from protocol.wire.codec import decode
from tests.deploy.run.orders.turnover import asked
from world.coordinator.life import Life
from world.judge import trajectory
from world.shell.persistence.journal import Journal

SWAP = load("swap-4")
ENDLESS = replace(SWAP, time=replace(SWAP.time, endless=True))
RESTARTED = replace(SWAP, process=(ProcessFault(2, 0.5, "restart"),))
AGAIN = RobotSpec(2, 0.02, (0.0, -0.2), (0.1, -0.2))
GUEST = RobotSpec(7, 0.03, (0.0, 0.0), (0.0, 0.22))


class Overheard:
    """The world's node; once `when` holds after an event, `then` is done."""

    def __init__(self, fleet: LocalFleet) -> None:
        self._fleet = fleet
        self.when: Callable[[], bool] = lambda: False
        self.then: Callable[[], None] = lambda: None
        fleet.world_bus.node = self

    @property
    def finished(self) -> bool:
        return self._fleet.world.finished

    @property
    def deadline(self) -> float:
        return self._fleet.world.deadline

    def wake(self, now: float) -> None:
        self._fleet.world.wake(now)

    def handle(self, event: Event) -> None:
        self._fleet.world.handle(event)
        if self.when():
            self.when = lambda: False
            self.then()


def kept(folder: Path, scenario: object = RESTARTED) -> LocalFleet:
    """A fleet whose world keeps a journal."""
    Journal.create(folder / "journal", "local", [scenario])  # type: ignore[list-item]
    return LocalFleet([scenario], journal=folder / "journal")  # type: ignore[list-item]


def injector(fleet: LocalFleet) -> LocalBus:
    """The bus of the launcher."""
    return next(bus for bus in fleet.network._buses if isinstance(bus.node, FaultInjector))


def go(fleet: LocalFleet, ticks: int, seconds: float = 5.0) -> None:
    """On for some ticks, or not that far in this time."""
    tick, deadline = fleet.world.world.tick + ticks, time.monotonic() + seconds
    fleet.network.run(lambda: fleet.world.world.tick >= tick or time.monotonic() > deadline)


def life(fleet: LocalFleet, robot: int = 2) -> Life:
    return fleet.world.world.coordinator.lives.of[robot]


def status(fleet: LocalFleet, robot: int = 2) -> str:
    return fleet.world.world.coordinator.lives.status_of(robot)


def answer(fleet: LocalFleet, session: str, robot: int = 2) -> Reply:
    """What the world answers to a process that asks to join."""
    replies: list[bytes] = []
    payload = encode_request(Join(robot, session))
    fleet.world.handle(Request(robot_key(fleet.run, robot, "join"), payload, replies.append))
    return decode_reply(replies[0])


def deafened(fleet: LocalFleet, then: Callable[[], object]) -> tuple[LocalBus, RobotNode]:
    """Robot 2's process, which hears nothing any more from the moment on in which it has commanded."""
    world, ears, bus = fleet.world.world, Overheard(fleet), fleet.robots[2]
    node = bus.node
    assert isinstance(node, RobotNode)

    def deafen() -> None:
        bus.node = None
        then()

    ears.when = lambda: world.is_open and 2 in world.coordinator.commands.velocities
    ears.then = deafen
    deadline = time.monotonic() + 5.0
    fleet.network.run(lambda: bus.node is None or time.monotonic() > deadline)
    return bus, node


def blink(fleet: LocalFleet) -> None:
    """The router goes and comes back: so do all tokens."""
    for alive in (False, True):
        for robot, bus in fleet.robots.items():
            fleet.world.handle(Presence(robot_key(fleet.run, robot, "alive"), alive))
            assert bus.node is not None
            bus.node.handle(Presence(world_key(fleet.run, "alive"), alive))


@pytest.fixture(scope="module")
def undisturbed() -> str:
    sha: str = LocalFleet([RESTARTED]).execute()[0]["trajectory_sha256"]
    return sha


def test_who_is_to_be_restarted_is_not_its_own_successor_when_a_router_goes(
    tmp_path: Path, undisturbed: str
) -> None:
    """Its launcher gets to it late, and it asks what became of it."""
    fleet, faults = kept(tmp_path), list[ProcessFault]()
    launcher = injector(fleet)
    late = launcher.node
    assert isinstance(late, FaultInjector)
    late._carry_out = faults.append  # type: ignore[method-assign]
    fleet.network.run(lambda: bool(faults))
    blink(fleet)
    go(fleet, 1, seconds=0.5)
    assert (fleet.world.world.tick, life(fleet).incarnation) == (10, 1)
    for fault in faults:
        FaultInjector._carry_out(late, fault)
    report = fleet.execute()[0]
    assert (report["trajectory_sha256"], report["faults"]["given_up"]) == (undisturbed, [])


def test_a_successor_that_is_heard_before_the_world_is_itself_again_is_no_victim(
    tmp_path: Path, undisturbed: str
) -> None:
    """The world died as the tick of the restart opened, when its launcher had heard of it."""
    fleet = kept(tmp_path)
    injector(fleet).node = None
    dead, ears = list[bool](), Overheard(fleet)
    ears.when = lambda: not life(fleet).joined and fleet.world.world.tick == 10
    ears.then = lambda: dead.append(True)
    fleet.network.run(lambda: bool(dead))
    fleet.kill_world()
    fleet.kill(2)
    successor = fleet.start(2)
    fleet.start_world()
    successor.wake(math.inf)
    deadline = time.monotonic() + 10.0
    fleet.network.run(lambda: fleet.world.finished or time.monotonic() > deadline)
    report = fleet.world.report
    assert report is not None
    assert (report["trajectory_sha256"], report["faults"]["given_up"]) == (undisturbed, [])


@pytest.mark.parametrize("death", ["", "appearing", "standing", "later"])
def test_a_deaf_process_of_a_removed_robot_is_not_the_next_ones(
    tmp_path: Path, death: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether or not the world dies, when the next disk is to appear, or is there, or from a snapshot."""
    monkeypatch.setattr(trajectory, "LINK", 20)
    fleet = kept(tmp_path, ENDLESS)
    injector(fleet).node = None
    go(fleet, 12)
    _, node = deafened(fleet, lambda: asked(fleet, {"remove": 2}))
    session = node._world._session
    go(fleet, 1)
    assert asked(fleet, {"add": AGAIN}).accepted
    assert answer(fleet, session) == Finished("removed")
    assert isinstance(answer(fleet, "next"), Wait)  # its disk has not appeared
    for moment, ticks in (("appearing", 3), ("standing", 1), ("later", 8)):
        if moment == "later":
            go(fleet, 5)
        if death == moment:
            fleet.kill_world()
            fleet.start_world()
        go(fleet, ticks)
    assert status(fleet) == "standing"
    assert answer(fleet, session) == Finished("removed")
    fleet.world.handle(Presence(robot_key("local", 2, "alive"), False))
    assert isinstance(answer(fleet, "next"), Admission)
    assert answer(fleet, session) == Finished("removed")


def test_the_next_one_waits_for_the_token_of_the_one_before() -> None:
    """There is one for both, so the world could not tell whose it is that goes."""
    fleet = LocalFleet([ENDLESS])
    injector(fleet).node = None
    go(fleet, 10)
    bus, _ = deafened(fleet, lambda: asked(fleet, {"remove": 2}))
    go(fleet, 1)
    assert asked(fleet, {"add": AGAIN}).accepted
    go(fleet, 4)
    successor = fleet.start(2)
    successor.wake(math.inf)
    assert (status(fleet), life(fleet).joined) == ("standing", False)
    go(fleet, 20)  # nobody waits for it
    bus.close()
    go(fleet, 1)
    successor.wake(math.inf)
    go(fleet, 20)
    assert (status(fleet), life(fleet).joined) == ("live", True)
    assert fleet.world.world.coordinator.lives.given_up == []


def test_a_late_farewell_makes_nobody_wait_for_the_next() -> None:
    fleet = LocalFleet([ENDLESS])
    injector(fleet).node = None
    fleet.world._failures._restarts = 1
    go(fleet, 10)
    bus, _ = deafened(fleet, lambda: asked(fleet, {"remove": 2}))
    go(fleet, 1)
    assert asked(fleet, {"add": AGAIN}).accepted
    go(fleet, 4)
    bus.close()
    before = fleet.world.world.tick
    go(fleet, 20)
    assert fleet.world.world.tick - before >= 20
    assert not fleet.world._failures.expected  # nobody was waited for


def test_a_deaf_process_of_one_run_takes_no_part_in_the_next() -> None:
    """Its robot has the same id there; it comes later than this process is woken."""
    runs = [replace(SWAP, orders=(Order(at, add=GUEST),)) for at in (0.2, 0.5)]
    fleet = LocalFleet(runs)
    fleet.network.run(lambda: fleet.world.finished or fleet.world.world.tick >= 13)
    bus = fleet.robots[7]
    node = bus.node
    assert isinstance(node, RobotNode)
    bus.node = None
    fleet.world.handle(Presence(robot_key("local", 7, "alive"), False))
    fleet.network.run(lambda: fleet.world.finished or 7 in fleet.world.world.coordinator.newcomers)
    assert fleet.world._run.number == 1
    assert answer(fleet, node._world._session, 7) == Finished("removed")
    bus.close()
    assert fleet.execute()[-1]["verdict"] == "arrived"


def test_a_stranger_that_asks_for_a_removed_robot_keeps_its_process_from_nothing() -> None:
    """It asks while the world waits for somebody else, before that process could be told."""
    orders, faults = (Order(0.5, remove=2), Order(1.0, add=AGAIN)), (ProcessFault(3, 0.5, "restart"),)
    scenario, found = replace(SWAP, orders=orders, process=faults), []
    for stranger in (False, True):
        with skipped_waits():
            fleet, told = LocalFleet([scenario]), list[Reply]()
            ears, world = Overheard(fleet), fleet.world.world
            ears.when = lambda world=world, fleet=fleet: (  # type: ignore[misc]
                status(fleet) == "gone" and not world.is_open
            )
            if stranger:
                ears.then = lambda fleet=fleet, told=told: told.append(  # type: ignore[misc]
                    answer(fleet, "stranger")
                )
            report = fleet.execute()[0]
        assert len(told) == stranger
        found.append((report["verdict"], report["faults"]["given_up"], report["trajectory_sha256"]))
    assert found[0] == found[1]


def test_who_comes_while_its_robot_is_gone_waits_if_that_is_to_come_again() -> None:
    comings = Order(0.2, add=GUEST), Order(1.0, remove=7), Order(1.3, add=GUEST)
    fleet = LocalFleet([replace(SWAP, orders=comings)])
    fleet.network.run(lambda: fleet.world.world.tick >= 22 or fleet.world.finished)
    assert status(fleet, 7) == "gone"
    assert isinstance(answer(fleet, "next", 7), Wait)
    before = fleet.world._admissions.processes.newest[7]
    assert answer(fleet, before, 7) == Finished("removed")
    fleet.network.run(lambda: fleet.world.world.tick >= 27 or fleet.world.finished)
    assert status(fleet, 7) != "gone"


@pytest.mark.parametrize("given_up", [False, True], ids=["between two runs", "given up"])
def test_nobody_takes_the_seat_of_a_process_that_is_there_when_the_world_comes_back(
    tmp_path: Path, given_up: bool
) -> None:
    runs = [ENDLESS] if given_up else [SWAP, SWAP]
    Journal.create(tmp_path / "journal", "local", runs)
    fleet = LocalFleet(runs, journal=tmp_path / "journal")
    injector(fleet).node = None
    if given_up:
        go(fleet, 10)
        fleet.world.world.coordinator.lost(2, "hangs")
    else:
        dead, ears = list[bool](), Overheard(fleet)
        ears.when = lambda: fleet.world._run.number == 1
        ears.then = lambda: dead.append(True)
        fleet.network.run(lambda: bool(dead))
    assert not life(fleet).goes_on
    node = fleet.robots[2].node
    assert isinstance(node, RobotNode)
    assert isinstance(answer(fleet, "stranger"), Refusal)
    fleet.kill_world()
    fleet.start_world()
    fleet.world_bus.drain()  # the tokens
    assert isinstance(answer(fleet, "stranger"), Refusal)
    assert isinstance(answer(fleet, node._world._session), Admission)


def test_the_guest_of_the_next_run_waits_for_the_token_of_the_one_before() -> None:
    """It would not be told from its own, and the world would wait for that in vain."""
    guested = replace(SWAP, orders=(Order(0.2, add=GUEST),))
    with skipped_waits():
        fleet = LocalFleet([guested, guested])
        fleet.network.run(lambda: fleet.world.finished or fleet.world.world.tick >= 13)
        bus = fleet.robots[7]
        bus.node = None
        fleet.network.run(
            lambda: fleet.world._run.number == 1 and bool(fleet.world.world.coordinator.newcomers)
        )
        assert isinstance(answer(fleet, "next", 7), Wait)
        bus.close()
        fleet.world_bus.drain()
        assert isinstance(answer(fleet, "next", 7), Admission)


def test_who_comes_late_for_a_guest_of_the_run_before_is_told_that_it_is_removed() -> None:
    """Its disk appeared as that run ended, and nobody had asked."""
    guested = replace(SWAP, orders=(Order(0.2, add=GUEST),), time=replace(SWAP.time, limit=0.25))
    fleet = LocalFleet([guested, SWAP])
    injector(fleet).node = None
    fleet.network.run(lambda: fleet.world._run.number == 1)
    assert answer(fleet, "late", 7) == Finished("removed")


def test_watchers_are_told_every_tick_over_snapshots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trajectory, "LINK", 20)
    fleet, ticks = kept(tmp_path), list[int]()

    class Watching:
        finished, deadline = False, math.inf

        def handle(self, event: Event) -> None:
            message = decode(event.key, event.payload)  # type: ignore[union-attr]
            assert isinstance(message, Truth)
            ticks.append(message.tick)

        def wake(self, now: float) -> None: ...

    bus = fleet.network.connect()
    bus.subscribe(world_key("local", "truth"))
    bus.node = Watching()
    report = fleet.execute()[0]
    bus.drain()
    assert ticks == list(range(report["ticks"] + 1))


@pytest.mark.process
@pytest.mark.timeout(120)
@pytest.mark.long(15)
def test_who_is_frozen_for_longer_than_its_token_lives_goes_on() -> None:
    """At any speed: a token lives for two seconds."""
    faults = (ProcessFault(2, 0.5, "pause"), ProcessFault(2, 4.0, "resume"))
    scenario = replace(SWAP, process=faults, time=replace(SWAP.time, fence=6.0))
    with Fleet([scenario], RunOptions("routed", speed=1.0)) as fleet:
        (report,) = fleet.execute()
    assert (report["verdict"], report["faults"]["given_up"]) == ("arrived", [])
    assert report["trajectory_sha256"] == LocalFleet([scenario]).execute()[0]["trajectory_sha256"]
