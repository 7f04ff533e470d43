"""ORCA and barriers as laws: they avoid with fresh information, are reproducible, need their libraries."""

from __future__ import annotations

import math
import subprocess
import sys
from typing import Any

import pytest

from agents.law import Law, View, choose, require
from agents.law.comparison.nominal import Nominal
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.errors import UsageError
from protocol.messages import Member
from protocol.scenario.model import Control, RobotSpec, Scenario, Time

LAWS = ("orca", "barrier")
STILL = (0.0, 0.0)
GOAL = (0.2, 0.0)
Vector = tuple[float, float]


def crossing(law: str, **control: Any) -> Scenario:
    """Two robots that face each other, a little off the line between them."""
    robots = (RobotSpec(1, 0.04, (-0.2, 0.01), (0.2, 0.0)), RobotSpec(2, 0.04, (0.2, -0.01), (-0.2, 0.0)))
    laws: Any = {"law": law, "k": 60.0, "filter": "none"} | control
    return Scenario(robots, control=Control(**laws), time=Time(limit=40.0))


def run(scenario: Scenario) -> dict[str, Any]:
    (report,) = LocalFleet([scenario]).execute()
    return report


def heard(x: float, y: float, velocity: tuple[float, float] = STILL, tick: int = 0) -> Neighbours:
    """Robot 2 as robot 1 last heard it."""
    known = Neighbours({2: 0.04})
    known.on_state(PeerState(2, 1, tick, True, x, y, 0.0, 0.0, 0.0, *velocity, radius=0.04))
    return known


def wish(
    own: Law,
    position: Vector,
    displacement: Vector,
    neighbours: Neighbours,
    tick: int,
    goal: Vector = GOAL,
) -> Vector:
    view = View(tick=tick, position=position, goal=goal, displacement=displacement, neighbours=neighbours)
    return own.velocity(view)


@pytest.mark.parametrize("law", LAWS)
def test_two_that_hear_each_other_at_once_pass(law: str) -> None:
    report = run(crossing(law))
    assert report["verdict"] == "arrived"
    assert 0.0 < report["min_clearance"] < 0.02  # they did come close
    assert report["nrl"] > 1.0


@pytest.mark.parametrize("law", LAWS)
def test_same_seed_same_trajectory(law: str) -> None:
    one, again = (run(crossing(law, symmetry_noise=0.1))["trajectory_sha256"] for _ in range(2))
    assert one == again
    assert one != run(crossing(law, symmetry_noise=0.2))["trajectory_sha256"]


@pytest.mark.parametrize(("law", "library"), [("orca", "pyrvo"), ("barrier", "daqp")])
def test_a_missing_library_is_named_before_anything_starts(
    law: str, library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agents.law.choice.find_spec", lambda name: None if name == library else name)
    with pytest.raises(UsageError, match=rf"{law}.*{library}.*pip install .*\[peers\]"):
        load("head-on", [f"control.law={law}"])
    with pytest.raises(UsageError, match=library):
        choose(crossing(law), 1)
    require("gradient")


def test_the_papers_law_loads_no_library_to_compare_with() -> None:
    code = (
        "import sys; from agents.law import choose; from deploy.library.load import load;"
        "choose(load('head-on'), 1); sys.exit('pyrvo' in sys.modules or 'daqp' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0


def lonely(law: str) -> Law:
    control: Any = {"law": law, "k": 60.0, "filter": "none", "symmetry_noise": 0.0}
    return choose(Scenario((RobotSpec(1, 0.04, (-0.2, 0.0), (0.2, 0.0)),), control=Control(**control)), 1)


@pytest.mark.parametrize("law", LAWS)
def test_alone_it_goes_straight_to_the_goal_and_slows_to_arrive(law: str) -> None:
    own, nobody = lonely(law), Neighbours({})
    assert wish(own, (-0.2, 0.0), STILL, nobody, 0) == pytest.approx((0.1, 0.0), abs=1e-6)
    assert wish(own, (0.197, 0.0), (0.005, 0.0), nobody, 1) == pytest.approx((0.06, 0.0), abs=1e-6)
    assert wish(own, (0.2, 0.0), STILL, nobody, 2) == pytest.approx(STILL, abs=1e-6)
    assert own.slice_norm((0.0, 0.0), GOAL) == pytest.approx(0.4)


@pytest.mark.parametrize("law", ["gradient", *LAWS])
def test_the_goal_may_be_another_one_in_every_tick(law: str) -> None:
    own, nobody = lonely(law), Neighbours({})
    assert wish(own, STILL, STILL, nobody, 0) == pytest.approx((0.1, 0.0), abs=5e-3)
    assert own.slice_norm(STILL, (0.0, 0.1)) == pytest.approx(0.2)
    assert wish(own, STILL, STILL, nobody, 1, (0.0, 0.1)) == pytest.approx((0.0, 0.1), abs=5e-3)


@pytest.mark.parametrize("law", LAWS)
def test_nobody_is_pressed_out_of_the_workspace(law: str) -> None:
    """A robot at the boundary that a peer runs into from the middle."""
    control: Any = {"law": law, "k": 60.0, "filter": "none", "symmetry_noise": 1.0}
    robots = (RobotSpec(1, 0.04, (0.0, 0.25), (0.0, -0.25)), RobotSpec(2, 0.04, (0.0, 0.1), (0.0, 0.2)))
    own = choose(Scenario(robots, control=Control(**control)), 1)
    for tick in range(0, 400, 20):
        vx, vy = wish(own, (0.0, 0.259), STILL, heard(0.0, 0.165, (0.0, 0.1), tick), tick, (0.0, -0.25))
        assert math.hypot(0.05 * vx, 0.259 + 0.05 * vy) <= 0.26 + 1e-9
        assert math.hypot(vx, vy) <= 0.1 + 1e-9


@pytest.mark.parametrize("law", LAWS)
def test_a_peer_stands_where_its_velocity_has_taken_it_since(law: str) -> None:
    """Old news of a peer in motion ask for what fresh news of its present place ask for."""
    scenario = crossing(law, symmetry_noise=0.0)
    late, fresh = heard(0.15, 0.0, (-0.1, 0.0), 0), heard(0.10, 0.0, (-0.1, 0.0), 10)
    velocities = [wish(choose(scenario, 1), (0.0, 0.01), (0.005, 0.0), known, 10) for known in (late, fresh)]
    assert velocities[0] == pytest.approx(velocities[1], abs=1e-6)
    unmoved = wish(choose(scenario, 1), (0.0, 0.01), (0.005, 0.0), heard(0.15, 0.0, tick=10), 10)
    assert unmoved != pytest.approx(velocities[0], abs=1e-3)


def test_barriers_hold_with_equality_where_they_bind() -> None:
    own = choose(crossing("barrier", symmetry_noise=0.0, barrier_gain=1.0, margin=0.0), 1)
    vx, vy = wish(own, (0.0, 0.0), STILL, heard(0.1, 0.0), 0)
    assert 2.0 * 0.1 * vx == pytest.approx(0.5 * (0.1**2 - 0.08**2), rel=1e-6)
    assert vy == pytest.approx(0.0, abs=1e-9)


def test_a_fenced_robot_takes_no_half_of_a_barrier() -> None:
    own = choose(crossing("barrier", symmetry_noise=0.0, barrier_gain=1.0, margin=0.0), 1)
    known = heard(0.1, 0.0)
    known.on_member(Member(2, 1, "standing", 0.04, (0.1, 0.0)))
    assert 2.0 * 0.1 * wish(own, (0.0, 0.0), STILL, known, 0)[0] == pytest.approx(0.1**2 - 0.08**2)


def test_orca_goes_around_and_a_margin_takes_it_further() -> None:
    known = heard(0.19, 0.0, (-0.1, 0.0))
    aside = [
        wish(
            choose(crossing("orca", symmetry_noise=0.0, margin=margin), 1),
            (0.0, 0.01),
            (0.005, 0.0),
            known,
            0,
        )[1]
        for margin in (0.0, 0.01)
    ]
    assert 0.003 < aside[0] < aside[1]
    short = choose(crossing("orca", symmetry_noise=0.0, horizon=0.2), 1)
    vx, _ = wish(short, (0.0, 0.01), (0.005, 0.0), known, 0)
    assert vx > 0.099  # not yet within the horizon


def test_noise_is_bounded_and_drawn_by_tick() -> None:
    quiet, loud = (Nominal(crossing("orca"), 1, noise) for noise in (0.0, 0.2))
    nominal = quiet.velocity(STILL, GOAL, 0)
    assert nominal == pytest.approx((0.1, 0.0))
    wishes = [loud.velocity(STILL, GOAL, tick) for tick in range(600)]
    assert all(math.dist(nominal, each) <= 0.02 + 1e-12 for each in wishes)
    assert len(set(wishes)) >= 30
    assert loud.velocity(STILL, GOAL, 3) == wishes[3]
