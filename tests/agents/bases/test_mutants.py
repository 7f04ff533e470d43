"""The product without each rule that keeps a base safe when something fails: each is found out."""

from __future__ import annotations

import math

import pytest

from agents.bases.drive import Drive, Lease
from agents.bases.senses import LinkDelay, Senses
from tests.agents.bases.floor import Floor
from tests.agents.bases.test_floor import FROM, STOPPED, late
from tests.agents.bases.test_senses import PAIR, fleet
from world.external import External

THREE = fleet(3)


def moves_on_stale_ticks() -> bool:
    """A robot's Ticks are under way for longer than its coordinator waits for it."""
    floor = Floor(THREE, 1).run(FROM)
    floor.late = 1
    floor.run(FROM + 3.0)
    floor.cut = True
    del floor.held[5:]
    floor.release()
    told = {floor.run(FROM + 3.0 + 0.01 * step).crews[1].wheels.aims for step in range(100)}
    return told != {(0.0, 0.0)}


def drives_on_without_a_coordinator() -> bool:
    floor = Floor(PAIR, 1).run(FROM)
    floor.cut = True
    return bool(floor.run(FROM + STOPPED).moving())


def drives_on_without_odometry() -> bool:
    floor = Floor(PAIR, 1).run(FROM)
    floor._odometry = lambda robot, _now, message: None if robot == 1 else message
    return any(1 in floor.run(FROM + STOPPED + 0.1 * later).moving() for later in range(3, 8))


def drives_on_with_late_odometry() -> bool:
    return (
        1
        in Floor(PAIR, 2, held_up=lambda robot, now: late(now) if robot == 1 else 0.0)
        .run(FROM + 5.0)
        .moving()
    )


def is_taken_for_where_it_is_not() -> bool:
    floor = Floor(THREE, 1).run(FROM)
    floor.crews[1].alive = False
    floor.run(FROM + 3.0)
    (member,) = [each for each in floor.world.lives.roster.message.members if each.status == "standing"]
    return math.dist(member.position, floor.crews[1].wheels.control) > member.bound


def without_lease(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Lease, "heard", lambda lease, _tick: setattr(lease, "until", math.inf))


def without_hold_time(patch: pytest.MonkeyPatch) -> None:
    made = Drive.__init__

    def patient(drive: Drive, *arguments: object) -> None:
        made(drive, *arguments)
        drive._grace = math.inf

    patch.setattr(Drive, "__init__", patient)
    without_lease(patch)


def without_age(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Senses, "age", lambda *_: 0.0)
    patch.setattr("agents.bases.senses.SILENCE", math.inf)


def with_age_since_arrival(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(LinkDelay, "age", lambda link, _stamp, now: now - link._arrived)


def without_the_way(patch: pytest.MonkeyPatch) -> None:
    resting = External.resting

    def exact(outside: External) -> dict[int, tuple[float, float]]:
        places = resting(outside)
        outside.bounds = {robot: outside._reports[robot][1].bound for robot in places}
        return places

    patch.setattr(External, "resting", exact)


RULES = {
    "a tick moves only under the lease": (without_lease, moves_on_stale_ticks),
    "a velocity is not held for ever": (without_hold_time, drives_on_without_a_coordinator),
    "odometry must be young": (without_age, drives_on_without_odometry),
    "odometry is as old as its link is slow": (with_age_since_arrival, drives_on_with_late_odometry),
    "a silent robot may have gone on": (without_the_way, is_taken_for_where_it_is_not),
}


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_can_be_left_out(rule: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The names that this replaces are those of the product."""
    RULES[rule][0](monkeypatch)


@pytest.mark.campaign
@pytest.mark.parametrize("rule", RULES)
def test_without_this_rule_something_goes_wrong(rule, monkeypatch):
    leave_out, goes_wrong = RULES[rule]
    assert not goes_wrong()
    leave_out(monkeypatch)
    assert goes_wrong()
