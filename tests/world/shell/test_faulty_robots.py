"""One robot that hangs, hears nothing, talks nonsense or lies costs one robot: the others arrive."""

import itertools
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

import msgspec
import pytest

from agents.peers.state import plausible
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Sample
from protocol.codec import decode, encode
from protocol.errors import JoinError
from protocol.keys import Stream
from protocol.line import UNIT
from protocol.messages import HIGHEST_ID, LARGEST, Answer, Claim, Command, FirstLine, Proposal, State
from protocol.scenario.model import Order, Scenario
from tests.proxy import Proxy
from tests.skipped_waits import skipped_waits
from world.shell.admission import CHANCES

pytestmark = pytest.mark.slow

SWAP = load("swap-4", ["time.fence=0.2"], 1)
FAULTY, FROM = 2, 30  # the robot, from which tick on
OTHERS = [robot for robot in SWAP.ids if robot != FAULTY]
MOST = 2**53
LIMITS = plausible(SWAP)


@pytest.fixture(autouse=True)
def _skipped_waits() -> Iterator[None]:
    with skipped_waits():
        yield


class Ward:
    """A fleet of which robot 2 hears and says something else from tick FROM on.

    Args:
        hears: whether its node is told of an event.
        says: what is published in place of a message and its payload.
        speed: simulated seconds per second: one that is given up has time to come back.
    """

    def __init__(
        self,
        hears: Callable[[Event], bool] = lambda _: True,
        says: Callable[[Any, bytes], bytes] = lambda _, payload: payload,
        scenario: Scenario = SWAP,
        speed: float = 20.0,
    ) -> None:
        self.fleet = LocalFleet(scenario, speed=speed)
        self._bus, self._says = self.fleet.robots[FAULTY], says
        self._publisher = self._bus.publisher
        self._bus.publisher = self._speaking  # type: ignore[method-assign]
        node = self._bus.node

        def handle(event: Event) -> None:
            if not self.is_faulty or hears(event):
                node.handle(event)

        self._bus.node = Proxy(node, handle=handle)

    @property
    def is_faulty(self) -> bool:
        return self.fleet.world.world.tick >= FROM

    def _speaking(self, stream: Stream, key: str) -> Callable[[bytes], None]:
        publish = self._publisher(stream, key)

        def say(payload: bytes) -> None:
            publish(self._says(decode(key, payload), payload) if self.is_faulty else payload)

        return say

    def execute(self) -> dict[str, Any]:
        """The report; the others have arrived, and no other was given up."""
        report = self.fleet.execute()
        assert {each["robot"] for each in report["faults"]["given_up"]} <= {FAULTY}
        assert set(report["arrived"]) >= set(OTHERS), (report["verdict"], report["reason"])
        return report


def given_up(ward: Ward) -> list[dict[str, Any]]:
    """What is said of the robot, which is given up at once."""
    found = ward.execute()["faults"]["given_up"]
    assert found[0]["tick"] in (FROM - 1, FROM, FROM + 1)
    assert found[0]["incarnation"] == 1
    return found


def test_one_that_hangs_is_given_up_alone() -> None:
    ward = Ward()
    while not ward.is_faulty:
        ward.fleet.step()
    ward.fleet.robots[FAULTY].node = None
    (only,) = given_up(ward)
    assert "hangs" in only["reason"] or "lack it" in only["reason"]


def test_one_that_hears_no_peer_is_given_up_alone() -> None:
    def hears(event: Event) -> bool:
        return not (isinstance(event, Sample) and event.key.endswith("/state"))

    found = given_up(Ward(hears, speed=2.0))  # time for five refusals
    assert "lacks the State of" in found[0]["reason"]
    assert [each["incarnation"] for each in found] == list(range(1, CHANCES + 1))


def _shortened(state: State) -> bytes:
    return msgspec.msgpack.encode(msgspec.to_builtins(state)[:-4])


def _nonsense_to_one(state: State) -> bytes:
    """It owns a line with robot 3 only; what it offers is no number."""
    offer = Proposal(3, 1, 2**40, float("nan"), 0.0, 0.0)
    return msgspec.msgpack.encode(msgspec.structs.replace(state, proposals=(*state.proposals, offer)))


@pytest.mark.parametrize("damage", [_shortened, _nonsense_to_one], ids=["shape", "to-one"])
def test_one_whose_states_are_refused_is_given_up_alone(damage: Callable[[State], bytes]) -> None:
    ward = Ward(says=lambda message, payload: damage(message) if isinstance(message, State) else payload)
    assert "3 of 3 lack it" in given_up(ward)[0]["reason"]


def _lines(one: float, other: float, offset: float) -> dict[str, Any]:
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
            yield _lines(one, other, -number)
    yield {"position": None}


@pytest.mark.parametrize("law", ["gradient", "reciprocal"])
def test_whatever_a_state_may_say_stops_no_other_robot(law: str) -> None:
    scenario = replace(load("swap-4", [f"control.law={law}"]), orders=(Order(3.0, remove=FAULTY),))
    lie = itertools.cycle(lies())

    def says(message: Any, payload: bytes) -> bytes:
        if not isinstance(message, State):
            return payload
        return encode(msgspec.structs.replace(message, **next(lie)))

    report = Ward(says=says, scenario=scenario, speed=0.0).execute()
    assert [contact for contact in report["contacts"] if FAULTY not in contact["pair"]] == []


def commanding(field: dict[str, Any]) -> Ward:
    """It says something else of itself in its Commands."""

    def says(message: Any, payload: bytes) -> bytes:
        if not isinstance(message, Command):
            return payload
        return encode(msgspec.structs.replace(message, **field))

    return Ward(says=says, speed=0.0)


@pytest.mark.parametrize(
    "field",
    [
        {"slice": LARGEST},
        {"roster": MOST},
        {"firsts": tuple(FirstLine(number, 0.6, -0.8, LARGEST) for number in (0, 1, 9, MOST))},
    ],
)
def test_whatever_a_command_may_say_stops_no_other_robot(field: dict[str, Any]) -> None:
    commanding(field).execute()


@pytest.mark.parametrize("field", ["version", "region"])
def test_a_command_that_obeys_what_was_never_granted_is_refused(field: str) -> None:
    ward = commanding({field: MOST})
    with suppress(JoinError):  # it is given up, and in the end refused
        ward.execute()
    assert ward.fleet.world.world.exchange.refused["ledger"] > 0


@pytest.mark.timeout(60)
def test_a_world_in_which_all_have_died_hears_a_robot_that_comes() -> None:
    """In lock-step the world waits for no robot then, and a run that is endless does not end."""
    fleet = LocalFleet(load("swap-4", ["time.endless=true"]))
    for _ in range(10):
        assert fleet.step()
    for robot in fleet.robots:
        fleet.kill(robot)
    assert fleet.step()
    for robot in fleet.robots:
        fleet.start(robot)
    lives = fleet.world.world.lives
    fleet.network.run(lambda: lives.up == (1, 2, 3, 4))
    for _ in range(10):
        assert fleet.step()
