"""Encounters ahead, and the place that all of them go round."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from agents.law import View
from agents.law.roundabout import STEEPEST, WIDE, Encounter, Encounters, Roundabout, roundabout
from agents.peers.far import FarPicture, SummaryPlaces
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library.encounters import circle
from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.messages import Member, Roster, Summary, Vector
from world.coordinator.exchange import runs

RADIUS, PERIOD, AHEAD, BETWEEN = 0.25, 0.5, 20.0, 2
WAY = (1.0, 0.0)
number = st.integers(-16, 16).map(lambda n: n / 8.0)  # exact in single precision
vector = st.tuples(number, number)


def _said(tick: int, places: dict[int, Vector]) -> Summary:
    flat, nothing = np.array([places[each] for each in sorted(places)], dtype="<f4"), bytes(4 * len(places))
    return Summary(tick, runs(sorted(places)), flat.tobytes(), nothing, nothing)


def _picture(places: dict[int, Vector], velocities: dict[int, Vector]) -> FarPicture:
    """Of tick BETWEEN, when every robot is at its place."""
    radii = dict.fromkeys(places, RADIUS)
    ago = BETWEEN * PERIOD
    earlier = {
        each: (x - ago * velocities[each][0], y - ago * velocities[each][1])
        for each, (x, y) in places.items()
    }
    before = FarPicture(SummaryPlaces(_said(0, earlier)), radii)
    return FarPicture(SummaryPlaces(_said(BETWEEN, places)), radii, before)


def _view(tick: int, neighbours: Neighbours) -> View:
    return View(
        tick=tick, position=(0.0, 0.0), goal=(9.0, 0.0), displacement=(0.0, 0.0), neighbours=neighbours
    )


def _nearest(place: Vector, velocity: Vector) -> float:
    """Brute force, of a robot that goes WAY from the origin."""
    times = np.linspace(0.0, AHEAD, 20001)
    x = place[0] + times * (velocity[0] - WAY[0])
    y = place[1] + times * (velocity[1] - WAY[1])
    return float(np.hypot(x, y).min())


@given(place=vector, velocity=vector, age=st.integers(0, 3))
def test_near_and_far_the_same_are_met_as_on_straight_ways(place: Vector, velocity: Vector, age: int) -> None:
    there = place[0] + age * PERIOD * velocity[0], place[1] + age * PERIOD * velocity[1]
    gap = _nearest(there, velocity) - 2.0 * RADIUS
    assume(abs(gap) > 1e-2)
    near = Neighbours({2: RADIUS})
    near.on_state(PeerState(2, 1, BETWEEN, True, *place, 0.0, 0.0, 0.0, *velocity, radius=RADIUS), BETWEEN)
    far = Neighbours({2: RADIUS})
    far.picture = _picture({1: (0.0, 0.0), 2: place}, {1: WAY, 2: velocity})
    for known in near, far:
        met = Encounters(1, RADIUS, PERIOD, AHEAD).met(_view(BETWEEN + age, known), WAY)
        assert [each[:3] for each in met] == ([(*there, RADIUS)] if gap < 0.0 else [])


def test_a_robot_that_is_heard_too_counts_once_and_one_that_stands_does_not() -> None:
    ahead, back = (3.0, 0.0), (-1.0, 0.0)
    picture = _picture({1: (0.0, 0.0), 2: ahead}, {1: WAY, 2: back})
    known = Neighbours({2: RADIUS})
    known.picture = picture
    encounters = Encounters(1, RADIUS, PERIOD, AHEAD)
    once = [Encounter(*ahead, RADIUS, 1.5)]
    assert encounters.met(_view(BETWEEN, known), WAY) == once
    known.on_state(PeerState(2, 1, BETWEEN, True, *ahead, 0.0, 0.0, 0.0, *back, radius=RADIUS), BETWEEN)
    assert encounters.met(_view(BETWEEN, known), WAY) == once
    known.on_roster(Roster(1, (Member(2, 1, "standing", RADIUS, ahead),)))
    assert encounters.met(_view(BETWEEN, known), WAY) == []


@pytest.mark.campaign
def test_a_crowd_that_hears_those_near_goes_round_in_time() -> None:
    """Without summaries some go through the middle, and are stopped there: 210 to 250 s."""
    scenario = circle(40, 0.5, seed=200)
    control = replace(scenario.control, law="reciprocal")
    report = LocalFleet(resolved(replace(scenario, control=control))).execute()
    assert report["verdict"] == "arrived"
    assert not report["collisions"]
    assert report["sim_time"] < 1.1 * 400.0 / scenario.control.speed
    assert math.isclose(report["nrl"], 1.0, abs_tol=0.05)


RADIUS, FAR = 0.03, 0.4


def _swap(count: int, heard: int) -> list[Encounter]:
    """Peers that the robot at (-FAR, 0) meets of `count` on a circle, receiving `heard` on each side."""
    met = []
    for index in [*range(1, heard + 1), *range(-heard, 0)]:
        angle = math.pi + 2.0 * math.pi * index / count
        met.append(Encounter(FAR * math.cos(angle), FAR * math.sin(angle), RADIUS, FAR))
    return met


@given(count=st.integers(5, 60), part=st.floats(0.1, 1.0))
def test_all_that_meet_have_room_on_the_circle_although_few_are_heard(count: int, part: float) -> None:
    heard = max(1, int(part * ((count - 1) // 2)))
    place = roundabout((-FAR, 0.0), (1.0, 0.0), _swap(count, heard))
    assert math.hypot(place.x, place.y) < 1e-9
    between = 2.0 * place.radius * math.sin(math.pi / count)
    assert between == pytest.approx(WIDE * 2.0 * RADIUS)


@given(
    x=st.floats(-5.0, 5.0),
    y=st.floats(-5.0, 5.0),
    angle=st.floats(-math.pi, math.pi),
    radius=st.floats(0.01, 3.0),
    room=st.floats(1.0, 2.0),
)
def test_a_turned_way_touches_the_circle_and_has_it_to_its_right(
    x: float, y: float, angle: float, radius: float, room: float
) -> None:
    way = math.cos(angle), math.sin(angle)
    turn = Roundabout(0.0, 0.0, radius).turn((x, y), way, room)
    assert 0.0 <= turn <= STEEPEST
    if 0.0 < turn < STEEPEST and math.hypot(x, y) > room * radius:
        vx, vy = math.cos(angle + turn), math.sin(angle + turn)
        assert vx * y - vy * x == pytest.approx(room * radius, abs=1e-6)
