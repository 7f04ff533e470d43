"""A robot that lies is given up alone, or does not keep the others from going on once it is gone."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

import msgspec
import pytest

from agents.peers.state import PeerReader, plausible
from agents.robot import Robot
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.codec import decode, encode
from protocol.errors import JoinError, MessageError
from protocol.messages import (
    HIGHEST_ID,
    LARGEST,
    UNIT,
    Answer,
    Claim,
    Command,
    FirstLine,
    Proposal,
    Sense,
    State,
    Tick,
    Vector,
)
from protocol.scenario.model import Order
from protocol.streams import Stream
from tests.skipped_waits import skipped_waits

LIAR, FROM = 2, 5
MOST = 2**53
LAWS = ("gradient", "reciprocal")
SWAP = load("swap-4")
LIMITS = plausible(SWAP)


def lines(one: float, other: float, offset: float) -> dict[str, Any]:
    known = [(peer, life, number) for peer in (1, 3, 4, HIGHEST_ID) for life, number in ((1, 1), (1, MOST))]
    return {
        "proposals": tuple(Proposal(*each, one, other, offset) for each in known),
        "answers": tuple(Answer(*each, number) for each in known for number in (0, MOST)),
    }


def lies() -> Iterator[dict[str, Any]]:
    """What a State may say at the very most, one field or several at a time."""
    for x, y in itertools.product((-LIMITS.place, 0.0, LIMITS.place), repeat=2):
        yield {"position": (x, y)}
        yield {"position": (x, y), "desired": (LARGEST, -LARGEST), "bound": LIMITS.bound}
    for number in (0.0, 5e-324, LIMITS.gamma):
        yield {"gamma": number}
        yield {"gamma": number, "slice": LARGEST, "bound": LIMITS.bound}
    for number in (0.0, 5e-324, LARGEST):
        yield {"slice": number}
        yield {"desired": (number, -number)}
        yield {"claim": Claim(HIGHEST_ID, number, number)}
        yield {"claim": Claim(1, 0.0, number)}
        for one, other in ((UNIT, -UNIT), (0.0, 0.0), (5e-324, UNIT)):
            yield lines(one, other, -number)
    yield {"position": None}


def told(fleet: LocalFleet, turn: Callable[[Any], Any]) -> dict[str, Any]:
    """The report of a fleet in which robot 2 says something else than it is to."""
    bus = fleet.robots[LIAR]
    publisher = bus.publisher

    def lying(stream: Stream, key: str) -> Callable[[bytes], None]:
        publish = publisher(stream, key)

        def say(payload: bytes) -> None:
            message = decode(key, payload)
            publish(encode(turn(message)) if getattr(message, "tick", -1) >= FROM else payload)

        return say

    bus.publisher = lying  # type: ignore[method-assign]
    return fleet.execute()


@pytest.mark.parametrize("law", LAWS)
def test_whatever_a_state_may_say_stops_nobody_else(law: str) -> None:
    scenario = replace(load("swap-4", [f"control.law={law}"]), orders=(Order(3.0, remove=LIAR),))
    fleet, lie = LocalFleet(scenario), itertools.cycle(lies())

    def turn(message: Any) -> Any:
        return msgspec.structs.replace(message, **next(lie)) if isinstance(message, State) else message

    report = told(fleet, turn)
    assert {each["robot"] for each in report["faults"]["given_up"]} <= {LIAR}
    assert report["arrived"] == [1, 3, 4], (report["verdict"], report["reason"])
    others = [contact for contact in report["contacts"] if LIAR not in contact["pair"]]
    assert others == []


@pytest.mark.parametrize(
    "field",
    [
        {"slice": LARGEST},
        {"roster": MOST},
        {"firsts": tuple(FirstLine(number, UNIT, UNIT, LARGEST) for number in (0, 1, 9, MOST))},
    ],
)
def test_whatever_a_command_may_say_stops_nobody_else(field: dict[str, Any]) -> None:
    def turn(message: Any) -> Any:
        return msgspec.structs.replace(message, **field) if isinstance(message, Command) else message

    report = told(LocalFleet(SWAP), turn)
    assert {each["robot"] for each in report["faults"]["given_up"]} <= {LIAR}
    assert set(report["arrived"]) >= {1, 3, 4}, (report["verdict"], report["reason"])


@pytest.mark.slow
@pytest.mark.parametrize("field", ["version", "region"])
def test_a_command_that_obeys_what_was_never_granted_is_refused(field: str) -> None:
    def turn(message: Any) -> Any:
        return msgspec.structs.replace(message, **{field: MOST}) if isinstance(message, Command) else message

    with skipped_waits(), suppress(JoinError):  # it is given up, and in the end refused
        fleet = LocalFleet(SWAP)
        told(fleet, turn)
    assert fleet.world.world.coordinator.commands.refused["ledger"] > 0


@pytest.mark.parametrize(
    "lie",
    [
        {"gamma": 1e99},
        {"gamma": 1.01 * LIMITS.gamma},
        {"position": (1.01 * LIMITS.place, 0.0)},
        {"position": (0.0, -LARGEST)},
        {"bound": 1.01 * LIMITS.bound},
        {"slice": 1e99},
        {"desired": (0.0, 1e99)},
        {"proposals": (Proposal(1, 1, 1, 2.0, 0.0, 0.0),)},
        {"proposals": (Proposal(3, 1, 1, 1.0, 0.0, 1e99),)},
    ],
)
def test_what_cannot_be_is_refused_by_all_alike(lie: dict[str, Any]) -> None:
    said = State(LIAR, 1, 7, (0.1, 0.2), 0.0, 1.0, 2.0, (0.0, 0.1))
    assert PeerReader(1, LIAR, limits=LIMITS).read(encode(said)).x == 0.1
    for robot in (1, 3, 4):
        with pytest.raises(MessageError) as refused:
            PeerReader(robot, LIAR, limits=LIMITS).read(encode(msgspec.structs.replace(said, **lie)))
        assert refused.value.reason == "shape"


def test_a_robot_does_not_claim_a_disk_that_no_part_makes() -> None:
    said = State(LIAR, 1, 7, (0.1, 0.2), 0.0, 1.0, 2.0, (0.0, 0.1), claim=Claim(1, 0.0, LARGEST))
    heard = PeerReader(1, LIAR, limits=LIMITS).read(encode(said))
    heard.size(0.04)
    assert heard.radius == 0.04


def test_a_robot_that_cannot_be_where_it_is_told_to_be_does_not_know_where_it_is() -> None:
    """Else its peers would refuse what it says, and give it up."""
    robot = Robot(SWAP, 1, 1)
    far = Sense((2.0 * LIMITS.place, 0.0), 0, 0.0, (0.0, 0.0))
    assert robot.begin(Tick(1, 1, 0, (1,), sense=far)).position is None
    assert Robot(SWAP, 1, 1).begin(Tick(1, 1, 0, (1,), sense=replaced(far, (0.1, 0.1)))).position == (
        0.1,
        0.1,
    )


def replaced(sense: Sense, position: Vector) -> Sense:
    return msgspec.structs.replace(sense, position=position)
