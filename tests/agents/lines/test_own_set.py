"""The polygon: supports are exact, cuts keep exactly what they should, by brute force over its corners. Whole
robots that know themselves badly: none leaves the workspace; one that is told nonsense stands.
"""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from agents.lines.own_set import DIRECTIONS, SIDES, OwnSet, Polygon, around
from deploy.run.local import LocalFleet
from protocol.bodies.sweep import Sweep
from protocol.bus.bus import Event, Sample
from protocol.codec import decode, encode
from protocol.line import HalfPlane
from protocol.scenario.model import Control, RobotSpec, Scenario, Sensing, Time
from tests.proxy import Proxy

angles = st.floats(0.0, 2.0 * math.pi)
cuts = st.lists(st.tuples(angles, st.floats(-0.5, 1.0)), max_size=40)
TINY = 1e-12


def unit(angle: float) -> tuple[float, float]:
    return math.cos(angle), math.sin(angle)


@given(cuts, angles, st.floats(0.0, 1.0))
def test_a_point_is_inside_as_long_as_no_cut_excludes_it(edges, angle, share) -> None:
    x, y = (share * part for part in unit(angle))
    polygon = around(1.0)
    for turn, limit in edges:
        nx, ny = unit(turn)
        left = polygon.cut(nx, ny, limit)
        if nx * x + ny * y <= limit - TINY:
            assert left is not None
        if left is None or nx * x + ny * y > limit:
            continue
        polygon = left
        for direction in range(48):
            nx, ny = unit(direction * math.pi / 24.0)
            assert nx * x + ny * y <= polygon.extent(nx, ny) + TINY


@given(st.lists(st.tuples(st.integers(0, SIDES - 1), st.floats(0.05, 1.0)), max_size=30), angles)
def test_the_support_is_that_of_all_points_that_satisfy_every_cut(edges, angle) -> None:
    """A linear program by brute force: the largest n.x over all crossings of two edges that are allowed."""
    limits = dict.fromkeys(range(SIDES), 1.0)
    polygon = around(1.0)
    for side, limit in edges:
        left = polygon.cut(*DIRECTIONS[side], limit)
        polygon, limits[side] = left, min(limits[side], limit)
    planes = [(*DIRECTIONS[side], limit) for side, limit in limits.items()]
    nx, ny = unit(angle)
    best = -math.inf
    for a, b, c in planes:
        for d, e, f in planes:
            if abs(a * e - b * d) > 1e-9:
                x, y = (c * e - b * f) / (a * e - b * d), (a * f - c * d) / (a * e - b * d)
                if all(p * x + q * y <= r + 1e-9 for p, q, r in planes):
                    best = max(best, nx * x + ny * y)
    assert polygon.extent(nx, ny) == pytest.approx(best, abs=1e-8)


def test_nothing_is_left_beyond_the_farthest_corner() -> None:
    assert around(1.0).cut(1.0, 0.0, -1.1) is None


@pytest.mark.parametrize(("swept", "most"), [(None, 0.1), (Sweep([0.0, 0.2], [0.0] * 2, [0.0, 0.05]), 0.35)])
def test_a_set_counts_with_all_its_further_motion(swept: Sweep | None, most: float) -> None:
    own = OwnSet(0.0, 0.0, 0.1, None, swept)
    for room, enough in ((most - 1e-6, False), (most + 1e-6, True)):
        assert own.satisfies(HalfPlane(1.0, 0.0, room)) is enough
        assert own.within(0.0, 0.0, room) is enough


def lied_to(policy: str, caplog: pytest.LogCaptureFixture) -> tuple[dict, str]:
    """A run in which measurements are off by five times their bound from tick 20 on, and what it says."""
    sensing = Sensing(noise=0.002, noise_bound=0.004, contradiction=policy)
    scenario = Scenario(
        (RobotSpec(1, 0.04, (-0.2, 0.0), (0.2, 0.0)),),
        control=Control(k=60.0).without("pace"),
        time=Time(limit=15.0, deadlock=2.0),
        sensing=(sensing,),
    )
    fleet = LocalFleet(scenario)
    node = fleet.robots[1].node

    def handle(event: Event) -> None:
        if isinstance(event, Sample) and event.key.endswith("tick"):
            told = decode(event.key, event.payload)
            sense = told.sense
            if told.tick >= 20 and sense is not None and sense.position is not None:
                x, y = sense.position
                told = structs.replace(told, sense=structs.replace(sense, position=(x + 0.02, y)))
            event = Sample(event.key, encode(told))
        node.handle(event)

    fleet.robots[1].node = Proxy(node, handle=handle)
    report = fleet.execute()
    note = node.core.health(0, 0, {}).note
    assert caplog.messages == [f"robot-1: {note}"]
    return report, note


def test_a_robot_whose_measurements_exclude_each_other_stands_still_and_says_so(caplog) -> None:
    report, note = lied_to("stand", caplog)
    assert report["verdict"] == "deadlock"
    assert report["positions"]["1"][0] < -0.09  # of 0.4 m, 0.1 m were driven by tick 20
    assert "exclude each other by" in note
    assert note.endswith("stands still")


def test_it_goes_on_from_the_newest_measurement_where_it_may(caplog) -> None:
    report, note = lied_to("newest", caplog)
    assert report["positions"]["1"] == pytest.approx([0.18, 0.0], abs=0.005)
    assert note.endswith("starts over from the newest measurement")


def test_radius_supports_and_cuts_count_the_margin() -> None:
    polygon = Polygon([0.0, 3.0, 0.0], [-1.0, 4.0, 2.0], 0.5)
    assert polygon.radius == 5.5
    assert (polygon.extent(0.0, 1.0), polygon.extent(-1.0, 0.0)) == (4.5, 0.5)
    assert polygon.extents() == [polygon.extent(nx, ny) for nx, ny in DIRECTIONS]
    left = polygon.cut(0.0, 1.0, 3.0)
    assert left is not None
    assert left.extent(0.0, 1.0) == 4.0  # a place at 3.0 may be within the margin of a corner at 3.5
    assert polygon.cut(0.0, 1.0, -1.6) is None


def test_the_support_of_an_own_set_is_that_of_its_shape_and_its_sweep() -> None:
    shape, swept = Polygon([0.0, 3.0, 0.0], [-1.0, 4.0, 2.0]), Sweep([0.0, 0.5], [0.0, 0.25], [0.0, 0.0])
    own = OwnSet(10.0, 20.0, shape.radius, shape, swept)
    for nx, ny, extent, passed in ((1.0, 0.0, 3.0, 3.5), (0.0, 1.0, 4.0, 4.25), (0.0, -1.0, 1.0, 1.0)):
        assert (own.extent(nx, ny), own.passed(nx, ny)) == pytest.approx((extent, passed))
        limit = nx * own.x + ny * own.y + passed
        assert own.satisfies(HalfPlane(nx, ny, limit + 1e-6))
        assert not own.satisfies(HalfPlane(nx, ny, limit - 1e-6))
