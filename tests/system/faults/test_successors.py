"""Processes of one robot that follow each other, while launchers are late, and worlds and routers come
and go: no other one takes a successor's place, and no trajectory shows any of it."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from agents.shell.node import RobotNode
from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.launcher import Launcher
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from protocol.bus.bus import Event, Presence, Query
from protocol.bus.local import LocalBus
from protocol.joining import Admission, Finished, Join, JoinReply, Refusal, Wait, decode_reply, encode_request
from protocol.keys import robot_key
from protocol.scenario.model import ProcessFault, RobotSpec, Scenario
from protocol.scenario.network import Link
from tests.mortal import MortalFleet
from tests.proxy import Proxy
from tests.skipped_waits import skipped_waits
from tests.system.orders.turnover import ENDLESS, SWAP, asked, status
from tests.world.driving import token
from world.coordinator.records import Life

RESTARTED = replace(SWAP, process=(ProcessFault(2, 0.5, "restart"),))
AGAIN = RobotSpec(2, 0.02, (0.0, -0.2), (0.1, -0.2))


def overhear(fleet: LocalFleet, when: Callable[[], bool], then: Callable[[], object]) -> None:
    done: list[bool] = []

    def handle(event: Event) -> None:
        fleet.world.handle(event)
        if not done and when():
            done.append(True)
            then()

    fleet.world_bus.node = Proxy(fleet.world, handle=handle)


def kept(folder: Path, scenario: Scenario = RESTARTED, *, deaf: bool = True) -> MortalFleet:
    """A fleet whose world keeps a checkpoint, and whose launcher hears nothing if it is deaf."""
    fleet = MortalFleet(scenario, folder / "checkpoint")
    if deaf:
        fleet.launcher.follow = lambda _: None  # type: ignore[method-assign]
    return fleet


def go(fleet: LocalFleet, ticks: int, seconds: float = 5.0) -> None:
    """On for some ticks, or not that far in this time."""
    tick, deadline = fleet.world.world.tick + ticks, time.monotonic() + seconds
    fleet.network.run(lambda: fleet.world.world.tick >= tick or time.monotonic() > deadline)


def life(fleet: LocalFleet) -> Life:
    return fleet.world.world.lives.of[2]


def answer(fleet: LocalFleet, session: str) -> JoinReply:
    """What the world answers to a process that asks to join as robot 2."""
    replies: list[bytes] = []
    payload = encode_request(Join(2, session))
    fleet.world.handle(Query(robot_key(fleet.run, 2, "join"), payload, replies.append))
    return decode_reply(replies[0])


def deafened(fleet: LocalFleet, then: Callable[[], object]) -> tuple[LocalBus, RobotNode]:
    """Robot 2's process, which hears nothing any more from the moment on in which it has commanded."""
    world, bus = fleet.world.world, fleet.robots[2]
    node = bus.node

    def deafen() -> None:
        bus.node = None
        then()

    overhear(fleet, lambda: world.is_open and 2 in world.exchange.taken, deafen)
    fleet.network.run(lambda: bus.node is None)
    return bus, node


@pytest.mark.slow
@pytest.mark.parametrize("death", ["", "appearing", "standing", "later"])
def test_a_deaf_process_of_a_removed_robot_is_not_the_next_ones(tmp_path: Path, death: str) -> None:
    """Whether or not the world dies, when the next disk is to appear, or is there, or later."""
    fleet = kept(tmp_path, ENDLESS)
    go(fleet, 12)
    _, node = deafened(fleet, lambda: asked(fleet, {"remove": 2}))
    go(fleet, 1)
    assert asked(fleet, {"add": AGAIN}).accepted
    assert answer(fleet, node._world.session) == Finished("removed")
    assert isinstance(answer(fleet, "next"), Wait)  # its disk has not appeared
    for moment, ticks in (("appearing", 3), ("standing", 1), ("later", 8)):
        if moment == "later":
            go(fleet, 5)
        if death == moment:
            fleet.kill_world()
            fleet.start_world()
        go(fleet, ticks)
    assert status(fleet, 2) == "standing"
    assert answer(fleet, node._world.session) == Finished("removed")
    fleet.world.handle(Presence(token(fleet.network, 2), False))
    assert isinstance(answer(fleet, "next"), Admission)
    assert answer(fleet, node._world.session) == Finished("removed")


@pytest.mark.slow
def test_the_next_one_does_not_wait_for_the_token_of_the_one_before(tmp_path: Path) -> None:
    fleet = kept(tmp_path, ENDLESS)
    go(fleet, 10)
    bus, _ = deafened(fleet, lambda: asked(fleet, {"remove": 2}))
    go(fleet, 1)
    assert asked(fleet, {"add": AGAIN}).accepted
    go(fleet, 4)
    successor = fleet.start(2)
    successor.on_timer(math.inf)
    go(fleet, 20)
    assert (status(fleet, 2), life(fleet).joined) == ("live", True)
    bus.close()  # the token that goes is not that of the successor
    go(fleet, 20)
    assert (status(fleet, 2), life(fleet).joined) == ("live", True)
    assert fleet.world.world.lives.given_up == []


@skipped_waits()
def test_a_process_to_be_restarted_is_not_its_own_successor_when_a_router_goes(tmp_path: Path) -> None:
    """Its launcher gets to it late, and it asks what became of it."""
    fleet, faults = kept(tmp_path, deaf=False), list[ProcessFault]()
    fleet.launcher.carry_out = faults.append  # type: ignore[method-assign]
    fleet.network.run(lambda: bool(faults))
    for alive in (False, True):  # with the router all tokens go, and come back
        for robot, bus in fleet.robots.items():
            fleet.world.handle(Presence(token(fleet.network, robot), alive))
            bus.node.handle(Presence(token(fleet.network), alive))
    go(fleet, 1, seconds=0.5)
    assert (fleet.world.world.tick, life(fleet).incarnation) == (10, 1)
    for fault in faults:
        Launcher.carry_out(fleet.launcher, fault)
    report = fleet.execute()
    undisturbed = LocalFleet(RESTARTED).execute()
    assert report["trajectory_sha256"] == undisturbed["trajectory_sha256"]
    assert report["faults"]["given_up"] == []


@pytest.mark.slow
def test_a_successor_that_is_heard_before_the_world_is_itself_again_is_no_victim(tmp_path: Path) -> None:
    """The world died as the tick of the restart opened, when its launcher had heard of it."""
    fleet, dead = kept(tmp_path), list[bool]()
    world = fleet.world.world
    overhear(fleet, lambda: not life(fleet).joined and world.tick == 10, lambda: dead.append(True))
    fleet.network.run(lambda: bool(dead))
    fleet.kill_world()
    fleet.kill(2)
    successor = fleet.start(2)
    fleet.start_world()
    successor.on_timer(math.inf)
    fleet.network.run(lambda: fleet.world.finished)
    report = fleet.world.report
    assert (report["verdict"], report["faults"]["given_up"], report["worlds"]) == ("arrived", [], [10])


def test_no_process_takes_the_seat_of_one_that_is_there_when_the_world_comes_back(tmp_path: Path) -> None:
    fleet = kept(tmp_path, ENDLESS)
    go(fleet, 10)
    fleet.world.world.lost(2, "hangs")
    assert not life(fleet).goes_on
    node = fleet.robots[2].node
    assert isinstance(answer(fleet, "stranger"), Refusal)
    fleet.kill_world()
    fleet.start_world()
    fleet.world_bus.drain()  # the tokens
    assert isinstance(answer(fleet, "stranger"), Refusal)
    assert isinstance(answer(fleet, node._world.session), Admission)


# -- one trajectory on every bus, and no contact


def late(*faults: tuple[int, float, str]) -> Scenario:
    """A swap in which processes come and go, while States are a second late."""
    scenario = load("swap-4", [], 1)
    return replace(
        scenario,
        link=Link(delay=1.0),
        process=tuple(ProcessFault(*fault) for fault in faults),  # type: ignore[arg-type]
        time=replace(scenario.time, limit=30.0),
    )


# The first life of robot 1 publishes nothing; a new life of another robot never had the initial line with it.
LATE = [
    late((1, 0.0, "kill"), (2, 2.0, "restart"), (1, 10.0, "restart")),
    late((1, 0.0, "pause"), (2, 2.0, "restart"), (1, 10.0, "resume")),
    late((3, 0.0, "restart"), (4, 0.05, "restart"), (3, 0.1, "restart")),
    late((4, 0.0, "kill"), (1, 0.5, "restart"), (2, 0.5, "kill"), (4, 0.9, "restart"), (2, 6.0, "restart")),
]


@pytest.mark.slow
@pytest.mark.parametrize("scenario", LATE)
def test_a_late_life_touches_no_robot(scenario: Scenario) -> None:
    report = LocalFleet(scenario).execute()
    assert (report["collisions"], report["faults"]["given_up"]) == (0, [])
    assert report["ticks"] > 100


FROZEN = replace(
    SWAP,
    process=(ProcessFault(2, 0.2, "pause"), ProcessFault(2, 3.2, "resume")),
    time=replace(SWAP.time, fence=6.0, limit=4.5),
)


@pytest.mark.process
@pytest.mark.timeout(120)
@pytest.mark.long(7)
def test_a_process_that_is_frozen_for_longer_than_its_token_lives_goes_on() -> None:
    """At any speed: a token lives for two seconds."""
    with Fleet(FROZEN, RunOptions("routed", speed=1.0)) as fleet:
        report = fleet.execute()
    assert (report["verdict"], report["down"], report["faults"]["given_up"]) == ("timeout", [], [])
    assert report["trajectory_sha256"] == LocalFleet(FROZEN).execute()["trajectory_sha256"]
