"""ORCA and barriers: they avoid with fresh information, are reproducible, and need their libraries."""

from typing import Any

import pytest

from agents.law import GuardedLaw, Law, View
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.errors import LawError, UsageError
from protocol.messages import Member, Roster, Vector
from protocol.scenario.model import Control, RobotSpec, Scenario, Time

LAWS = ("Orca", "Barrier")
STILL, GOAL = (0.0, 0.0), (0.2, 0.0)


def named(law: str) -> str:
    return f"deploy.studies.peers.laws:{law}"


def bare(law: str, *robots: RobotSpec) -> Scenario:
    return Scenario(robots, control=Control(law=named(law), k=60.0, filter="none"), time=Time(limit=40.0))


def crossing(law: str) -> Scenario:
    """Two robots that face each other, a little off the line between them."""
    one, other = (RobotSpec(1, 0.04, (-0.2, 0.01), (0.2, 0.0)), RobotSpec(2, 0.04, (0.2, -0.01), (-0.2, 0.0)))
    return bare(law, one, other)


def run(scenario: Scenario) -> dict[str, Any]:
    return LocalFleet(scenario).execute()


def heard(x: float, y: float, velocity: Vector = STILL, tick: int = 0) -> Neighbours:
    known = Neighbours({2: 0.04})
    known.on_state(PeerState(2, 1, tick, True, x, y, 0.0, 0.0, 0.0, *velocity, radius=0.04), tick)
    return known


def view(
    position: Vector, displacement: Vector, neighbours: Neighbours, tick: int = 0, goal: Vector = GOAL
) -> View:
    return View(tick=tick, position=position, goal=goal, displacement=displacement, neighbours=neighbours)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_two_that_hear_each_other_at_once_pass_in_equal_runs(law: str) -> None:
    report, again = (run(crossing(f"{law}(noise=0.1)")) for _ in range(2))
    assert report["verdict"] == "arrived"
    assert 0.0 < report["min_clearance"] < 0.02  # they did come close
    assert report["nrl"] > 1.0
    assert report["trajectory_sha256"] == again["trajectory_sha256"]
    assert report["trajectory_sha256"] != run(crossing(f"{law}(noise=0.2)"))["trajectory_sha256"]


@pytest.mark.parametrize(("law", "library"), [("Orca", "pyrvo"), ("Barrier", "daqp")])
def test_a_missing_library_is_named_first(law: str, library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("deploy.studies.peers.laws.find_spec", lambda _: None)
    with pytest.raises(UsageError, match=rf"{law}.*{library}.*pip install .*\[peers\]"):
        load("head-on", [f"control.law={named(law)}"])


@pytest.mark.parametrize("arguments", ["(gap=1.0)", "(1.0)", "(noise=nothing)", "(noise=0.1"])
def test_an_argument_that_a_law_does_not_take_is_refused(arguments: str) -> None:
    with pytest.raises((UsageError, LawError), match="Orca"):
        load("head-on", [f"control.law={named('Orca')}{arguments}"])


@pytest.mark.parametrize("law", LAWS)
def test_alone_it_goes_straight_to_any_goal_and_slows_to_arrive(law: str) -> None:
    own = GuardedLaw(bare(f"{law}(noise=0.0)", RobotSpec(1, 0.04, (-0.2, 0.0), GOAL)), 1)
    nobody = Neighbours({})
    assert own.velocity(view((-0.2, 0.0), STILL, nobody)) == pytest.approx((0.1, 0.0), abs=1e-6)
    assert own.velocity(view((0.197, 0.0), (0.005, 0.0), nobody, 1)) == pytest.approx((0.06, 0.0), abs=1e-6)
    assert own.velocity(view(GOAL, STILL, nobody, 2)) == pytest.approx(STILL, abs=1e-6)
    assert own.slice_norm(STILL, GOAL) == pytest.approx(0.4)
    elsewhere = view(STILL, STILL, nobody, 3, goal=(0.0, 0.1))
    assert own.velocity(elsewhere) == pytest.approx((0.0, 0.1), abs=5e-3)


@pytest.mark.parametrize("law", LAWS)
def test_a_peer_stands_where_its_velocity_has_taken_it_since(law: str) -> None:
    """Old news of a peer in motion ask for what fresh news of its present place ask for."""

    def wish(known: Neighbours) -> Vector:
        own: Law = GuardedLaw(crossing(f"{law}(noise=0.0)"), 1)
        return own.velocity(view((0.0, 0.01), (0.005, 0.0), known, 10))

    late, fresh = heard(0.15, 0.0, (-0.1, 0.0), 0), heard(0.10, 0.0, (-0.1, 0.0), 10)
    assert wish(late) == pytest.approx(wish(fresh), abs=1e-6)
    assert wish(heard(0.15, 0.0, tick=10)) != pytest.approx(wish(fresh), abs=1e-3)


def test_a_barrier_binds_with_equality_and_a_robot_that_is_down_takes_no_half_of_it() -> None:
    own = GuardedLaw(crossing("Barrier(gain=1.0, noise=0.0, margin=0.0)"), 1)
    known = heard(0.1, 0.0)
    vx, vy = own.velocity(view(STILL, STILL, known))
    assert 2.0 * 0.1 * vx == pytest.approx(0.5 * (0.1**2 - 0.08**2), rel=1e-6)
    assert vy == pytest.approx(0.0, abs=1e-9)
    known.on_roster(Roster(1, (Member(2, 1, "standing", 0.04, (0.1, 0.0)),)))
    assert 2.0 * 0.1 * own.velocity(view(STILL, STILL, known))[0] == pytest.approx(0.1**2 - 0.08**2)


def test_orca_goes_around_within_its_horizon_and_farther_with_a_margin() -> None:
    def wish(arguments: str) -> Vector:
        own = GuardedLaw(crossing(f"Orca(noise=0.0, {arguments})"), 1)
        return own.velocity(view((0.0, 0.01), (0.005, 0.0), heard(0.19, 0.0, (-0.1, 0.0))))

    assert 0.003 < wish("margin=0.0")[1] < wish("margin=0.01")[1]
    assert wish("horizon=0.2")[0] > 0.099  # not yet within the horizon
