"""`disknav check`: the named clusters, the bounds, the words, the JSON."""

import json
from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deploy.library.load import load, read
from deploy.theory.check import CheckReport, mirrored_triples, report, scope
from deploy.theory.facts import plain
from deploy.theory.function import FleetProblem
from deploy.theory.surrounded import surrounded, theorem_for
from protocol.scenario.model import Control, RobotSpec, Scenario, Workspace
from tests.deploy.printed import printed


@cache
def checked(name: str) -> CheckReport:
    return report(load(name))


@cache
def checked_ring() -> CheckReport:
    """Three robots, at a k that is far from its bound."""
    return report(ring(3, 0.30, 0.90, k=60.0))


def ring(count: int, circle: float, workspace: float, k: float) -> Scenario:
    angle = 2 * np.pi * np.arange(count) / count
    places = [(float(circle * np.cos(a)), float(circle * np.sin(a))) for a in angle]
    robots = tuple(
        RobotSpec(i + 1, 0.04, (places[i][0] + 0.03, places[i][1]), places[(i + 1) % count])
        for i in range(count)
    )
    return Scenario(robots, name="ring", workspace=Workspace(workspace), control=Control(k=k))


def test_figure_2_names_the_violated_clusters_and_by_how_much() -> None:
    found = checked("figure-2")
    assert found.assumption_1.status == "violated"
    everyone = found.assumption_1.shortfalls[-1]
    assert everyone.robots == (1, 2, 3)
    robots = read("figure-2").robots
    spread = sum(float(np.hypot(*np.subtract(a.goal, b.goal))) for a in robots for b in robots if a.id < b.id)
    d = 2 * robots[0].radius
    assert everyone.margin == pytest.approx(spread - 12 * d)  # Lambda' of three equal disks: 4 d + 8 d
    assert "robots 1, 2, 3: violated, short by" in printed(found.render())
    assert found.bounds is None
    assert not found.guaranteed


@pytest.mark.slow
def test_an_admissible_scenario_prints_its_bound_and_says_whether_k_reaches_it() -> None:
    low = checked_ring()
    assert low.assumption_1.status == low.assumption_2.status == "holds"
    assert not low.guaranteed
    assert f"for k > {low.bounds.polar:.4g}" in printed(low.render())
    high = report(ring(3, 0.30, 0.90, k=1.1 * low.bounds.polar))
    assert high.guaranteed
    assert "guaranteed" in printed(high.render())


def test_what_is_seen_in_practice_is_reported() -> None:
    seen = checked_ring().practice
    assert seen.arrived
    assert seen.random_arrived == seen.random_starts == 10
    assert seen.other_minima == 0
    assert sum(seen.equilibria.values()) >= 3  # one saddle at least for every pair


@pytest.mark.slow
def test_too_small_a_k_shows_another_minimum() -> None:
    scenario = read("figure-3e")
    found = report(replace(scenario, control=Control(k=3.0)))
    assert found.practice.random_arrived < found.practice.random_starts
    assert found.practice.other_minima >= 1
    assert "Raise k" in printed(found.render())


def test_a_head_on_start_is_told_apart_from_a_trap() -> None:
    found = checked("head-on")
    assert found.practice.rest == "saddle of index 1"
    assert "measure zero" in printed(found.render())


def test_an_unreachable_order_is_said_to_be_unreachable() -> None:
    angle = 2 * np.pi * np.arange(3) / 3
    places = [(float(0.06 * np.cos(a)), float(0.06 * np.sin(a))) for a in angle]
    robots = tuple(
        RobotSpec(i, 0.035, start, goal)
        for i, start, goal in zip((4, 7, 9), places, places[::-1], strict=True)
    )
    found = report(Scenario(robots, workspace=Workspace(0.10), control=Control(k=60.0)))
    assert found.unreachable == ((4, 7, 9),)
    assert "UNREACHABLE by any controller: robots 4, 7, 9" in printed(found.render())


@pytest.mark.parametrize("name", ["figure-2", "head-on"])
def test_json_is_plain_and_complete(name: str) -> None:
    found = checked(name)
    told = json.loads(json.dumps(plain(found), allow_nan=False))
    assert told["scenario"] == found.facts.scenario
    assert told["assumption_1"]["status"] == found.assumption_1.status
    assert told["guaranteed"] is found.guaranteed
    if found.bounds is not None:
        assert told["bounds"]["polar"] == found.bounds.polar
        assert told["bounds"]["n2"] is None


def test_one_robot_and_forty_robots_are_checked_too() -> None:
    one = report(ring(1, 0.05, 0.30, k=60.0))
    assert one.guaranteed
    many = report(load("random-40"))
    assert not many.every_cluster
    assert many.practice is None
    assert "not tried" in printed(many.render())


def test_parts_have_no_theorem_and_may_have_an_order() -> None:
    found = surrounded(load("parts-4", [], 1))
    assert (found.theorem, found.parts, found.order) == (None, 4, True)


def test_two_parts_that_change_places_have_no_order_and_a_robot_with_parts_no_sphere_world() -> None:
    drawn = load("parts-2", [], 0)
    one, other = drawn.parts
    swapped = (replace(one, goal=other.start), replace(other, goal=one.start))
    assert surrounded(replace(drawn, parts=swapped)).order is False
    theorem, reasons = theorem_for(replace(drawn, robots=drawn.robots[:1]))
    assert theorem is None
    assert "carried parts" in reasons[0]


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(0.5, 5.0), min_size=3, max_size=7), st.floats(3.0, 14.0))
def test_a_mirror_image_is_unreachable_for_the_wide_triples(radii: list[float], workspace: float) -> None:
    angle = 2.4 * np.arange(len(radii))
    start = np.stack([np.cos(angle), np.sin(angle)], axis=1) * workspace
    problem = FleetProblem(start * (1.0, -1.0), np.array(radii), workspace, 60.0)
    triples = combinations(range(len(radii)), 3)
    wide = [triple for triple in triples if problem.radii[list(triple)].sum() > workspace]
    assert mirrored_triples(problem, start) == wide
    assert mirrored_triples(FleetProblem(start, problem.radii, workspace, 60.0), start) == []


def test_of_another_law_and_of_external_bases_it_says_what_holds() -> None:
    fleet = load("turtlebots-2", ["world.plant=external", "control.law=reciprocal", "world.lease=0.8"])
    law, _, general, bases = scope(fleet)
    assert "arrival with reciprocal is not proven" in law
    assert "stated bounds" in general
    assert bases.startswith("each of robots 1, 2: continues for 0.1 s without ticks")
    assert scope(load("figure-1")) == []
