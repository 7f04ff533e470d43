"""One sick robot costs one robot: the others go on, and the result names it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.shell.node import RobotNode
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Sample
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.codec import decode
from protocol.errors import JoinError, MessageError
from protocol.messages import Command, Proposal, State, Tick
from tests.skipped_waits import skipped_waits
from tests.world.driving import joined, two
from world.coordinator.commands import blamed
from world.shell.admission import CHANCES
from world.shell.node import WorldNode

pytestmark = pytest.mark.slow

SCENARIO = load("swap-4", ["time.fence=0.2"], 1)
SICK, FROM = 2, 30  # the faulty robot, from which tick on
OTHERS = [robot for robot in SCENARIO.ids if robot != SICK]
LONG = 0.05  # s of patience, beyond the first repetition


@dataclass
class Patient:
    """A robot's node that is not well from some tick on: it hears only what it `takes`."""

    node: RobotNode
    takes: Callable[[Any], bool]
    tick: int = -1
    dead: list[str] = field(default_factory=list)

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            try:
                message = decode(event.key, event.payload)
            except MessageError:
                message = None
            if isinstance(message, Tick):
                self.tick = max(self.tick, message.tick)
            if self.tick >= FROM and not self.takes(message):
                return
        self.node.handle(event)

    def wake(self, now: float) -> None:
        if self.tick < FROM or self.takes(None):
            try:
                self.node.wake(now)
            except JoinError as error:  # the process would end here
                self.dead.append(str(error))
                self.node._bus.close()

    @property
    def deadline(self) -> float:
        return self.node.deadline if self.tick < FROM or self.takes(None) else float("inf")

    @property
    def finished(self) -> bool:
        return bool(self.dead) or self.node.finished


@dataclass
class Rogue:
    """A bus on which States are damaged from some tick on."""

    bus: LocalBus
    damage: Callable[[State, bytes], bytes]

    def publisher(self, stream: Any, key: str) -> Callable[[bytes], None]:
        publish = self.bus.publisher(stream, key)

        def say(payload: bytes) -> None:
            message = decode(key, payload)
            sick = isinstance(message, State) and message.tick >= FROM
            publish(self.damage(message, payload) if sick else payload)

        return say

    def __getattr__(self, name: str) -> Any:
        return getattr(self.bus, name)


class Ward:
    """A world and its robots in one thread, one of them sick; slow enough for the sick one to come back."""

    @skipped_waits()
    def __init__(
        self,
        takes: Callable[[Any], bool] | None = None,
        damage: Callable[[State, bytes], bytes] | None = None,
        speed: float = 20.0,
    ) -> None:
        network = LocalNetwork()
        bus = network.connect()
        self.said: list[str] = []
        self.world = bus.node = WorldNode(
            bus, "w", SCENARIO, patience=LONG, speed=speed, say=self.said.append
        )
        self.patient: Patient | None = None
        for robot in SCENARIO.ids:
            bus = network.connect()
            if robot == SICK and damage is not None:
                bus.node = RobotNode(Rogue(bus, damage), "w", robot)  # type: ignore[arg-type]
            else:
                bus.node = RobotNode(bus, "w", robot)
            if robot == SICK:
                self.patient = bus.node = Patient(bus.node, takes or (lambda _: True))
        network.run(lambda: self.world.finished)
        assert self.world.report is not None
        self.report = self.world.report

    def assert_the_others_arrived(self) -> None:
        report = self.report
        assert report["arrived"] == OTHERS, (report["verdict"], report["reason"])
        assert report["collisions"] == 0
        given_up = report["faults"]["given_up"]
        assert {each["robot"] for each in given_up} == {SICK}
        assert given_up[0]["tick"] in (FROM - 1, FROM)
        assert given_up[0]["incarnation"] == 1
        assert [f"robot {SICK}, which {each['reason']}" in " ".join(self.said) for each in given_up]
        assert len(self.said) == len(given_up)


def test_one_that_hangs_is_given_up_alone() -> None:
    ward = Ward(takes=lambda _: False)
    ward.assert_the_others_arrived()
    (only,) = ward.report["faults"]["given_up"]
    assert only["tick"] == FROM
    assert "hangs" in only["reason"] or "lack it" in only["reason"]


def test_one_that_hears_nobody_is_given_up_alone() -> None:
    ward = Ward(takes=lambda message: not isinstance(message, State), speed=2.0)  # time for five refusals
    ward.assert_the_others_arrived()
    given_up = ward.report["faults"]["given_up"]
    assert "does not hear" in given_up[0]["reason"]
    assert [each["incarnation"] for each in given_up] == list(range(1, CHANCES + 1))
    assert ward.patient is not None
    assert "start another" in ward.patient.dead[0]


def _shortened(state: State, _: bytes) -> bytes:
    return msgspec.msgpack.encode(msgspec.to_builtins(state)[:-4])


def _nonsense_to_one(state: State, _: bytes) -> bytes:
    """SICK owns a line with robot 3 only; what it offers is no number."""
    offer = Proposal(3, 1, 2**40, float("nan"), 0.0, 0.0)
    return msgspec.msgpack.encode(msgspec.structs.replace(state, proposals=(*state.proposals, offer)))


@pytest.mark.parametrize("damage", [_shortened, _nonsense_to_one], ids=["shape", "to-one"])
def test_one_whose_states_are_refused_is_given_up_alone(damage: Callable[[State, bytes], bytes]) -> None:
    ward = Ward(damage=damage)
    ward.assert_the_others_arrived()
    assert "3 of 3 lack it" in ward.report["faults"]["given_up"][0]["reason"]
    assert ward.report["messages"]["rejected"]


# -- whom it shows


def among(active: Collection[int]) -> dict[int, int]:
    """Every robot receives all States."""
    return dict.fromkeys(sorted(active), len(active))


def test_only_those_count_who_hear_it() -> None:
    """Of four, two are near robot 2, and both lack its State."""
    lacking: dict[int, tuple[int, ...]] = {1: (2,), 3: (2,)}
    assert blamed({1: 2, 2: 3, 3: 2, 4: 1}, {1, 3}, lacking).keys() == {2}


robots = st.frozensets(st.integers(1, 8), min_size=1)


@given(robots, robots, st.dictionaries(st.integers(1, 9), st.lists(st.integers(1, 9))))
def test_somebody_who_takes_part_is_blamed(
    active: frozenset[int], waiting: frozenset[int], lacking: dict[int, list[int]]
) -> None:
    waiting &= active
    found = blamed(among(active), waiting, lacking)
    assert found.keys() <= active
    assert bool(found) == bool(waiting)
    assert all(found.values())


@given(robots.filter(lambda each: len(each) > 2), st.data())
def test_one_sick_robot_never_costs_another(active: frozenset[int], data: st.DataObject) -> None:
    """It says what it likes, or nothing; the others are well and lack its State, or nothing."""
    sick = data.draw(st.sampled_from(sorted(active)))
    well = active - {sick}
    heard = data.draw(st.booleans())
    lacking = {} if heard else dict.fromkeys(well, (sick,))
    waiting = set() if heard else set(well)
    if data.draw(st.booleans()):
        waiting.add(sick)
        lacking[sick] = tuple(data.draw(st.lists(st.sampled_from(sorted(well)))))
    if waiting:
        assert blamed(among(active), waiting, lacking).keys() == {sick}


def test_a_complaint_is_no_command() -> None:
    world = joined(two())
    world.open_tick()
    assert not world.accept(Command(1, 1, 0, (0.1, 0.0), roster=0, awaits=(2,)))
    assert world.coordinator.waiting == {1, 2}
    assert world.coordinator.blamed().keys() == {2}
    assert world.accept(Command(1, 1, 0, (0.1, 0.0)))
    world.close_tick()
    assert world.truth.positions[0][0] > -0.1


@pytest.mark.timeout(60)
def test_a_world_in_which_all_have_died_hears_who_comes() -> None:
    """In lock-step the world waits for no robot then, and a run that is endless does not end."""
    fleet = LocalFleet(load("swap-4", ["time.endless=true"]))
    for _ in range(10):
        assert fleet.step()
    for robot in fleet.robots:
        fleet.kill(robot)
    assert fleet.step()
    for robot in fleet.robots:
        fleet.start(robot)
    lives = fleet.world.world.coordinator.lives
    fleet.network.run(lambda: lives.up == (1, 2, 3, 4))
    for _ in range(10):
        assert fleet.step()
