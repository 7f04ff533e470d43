"""The product without each rule that keeps a base safe when something fails: a test of `test_floor` fails."""

import math

import pytest

from agents.bases.drive import Drive, Lease
from agents.bases.senses import LinkDelay, Senses
from tests.agents.bases import test_floor as shown
from world.external import External


def without_lease(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Lease, "heard", lambda lease, _tick: setattr(lease, "until", math.inf))


def without_hold_time(patch: pytest.MonkeyPatch) -> None:
    made = Drive.__init__

    def patient(drive: Drive, *arguments: object) -> None:
        made(drive, *arguments)
        drive._grace = 60.0  # s

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
    "a tick moves only under the lease": (
        without_lease,
        shown.test_a_robot_does_not_move_on_ticks_that_come_when_it_is_fenced,
    ),
    "a velocity is not held for ever": (
        without_hold_time,
        shown.test_a_fleet_cut_off_from_its_coordinator_stands_within_hold_and_braking_and_then_drives_on,
    ),
    "odometry must be young": (
        without_age,
        lambda: shown.test_a_robot_stands_while_a_stream_is_unsound_says_why_and_goes_on("odometry", "stops"),
    ),
    "odometry is as old as its link is slow": (
        with_age_since_arrival,
        shown.test_a_robot_stands_while_its_odometry_comes_later_and_later_and_then_late_alike,
    ),
    "a silent robot may have gone on": (
        without_the_way,
        lambda: shown.test_a_process_that_was_stopped_is_fenced_where_it_is_and_does_not_move_on_stale_ticks(
            1
        ),
    ),
}


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_can_be_left_out(rule: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The names that this replaces are those of the product."""
    RULES[rule][0](monkeypatch)


@pytest.mark.campaign
@pytest.mark.parametrize("rule", RULES)
def test_without_this_rule_something_goes_wrong(rule, monkeypatch):
    leave_out, show = RULES[rule]
    leave_out(monkeypatch)
    with pytest.raises(AssertionError):
        show()
