"""Where an owner puts a line: between what both will sweep while they obey it."""

import math
from itertools import product
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from agents.lines.negotiation import (
    OUTSTANDING,
    Bond,
    MovingDisk,
    Negotiation,
    _closest,
    deficit,
    fit_line,
    tangent,
)
from agents.peers.state import PeerState
from protocol.geometry import ConvexPolygon, Disk
from protocol.kernel.records import Listed
from protocol.kernel.robot import ASKED, LINES, OwnEnd, RobotLife
from protocol.line import Line
from protocol.messages import Vector

place = st.floats(-1.0, 1.0)
velocity = st.floats(-0.5, 0.5)
seconds = st.floats(0.0, 2.0)
RADIUS = 0.1


@settings(max_examples=200, deadline=None)
@given(place, place, *[st.tuples(velocity, velocity)] * 3, seconds, seconds, seconds)
def test_the_owner_satisfies_every_line_now_and_leaves_the_other_where_it_was_seen_to_be_going(
    x: float, y: float, own: Vector, wanted: Vector, seen: Vector, ahead: float, begin: float, longer: float
) -> None:
    (vx, vy), (wx, wy), (ux, uy) = own, wanted, seen
    me, peer = MovingDisk(0.0, 0.0, RADIUS, vx, vy), MovingDisk(x, y, RADIUS, wx, wy, ux, uy)
    end = begin + longer
    found, parts = math.dist(*_closest(me, peer, ahead, begin, end)), [n / 8.0 for n in range(9)]
    for s, t in product(parts, repeat=2):
        at = [p + (1.0 - t) * begin * u + t * end * w for p, u, w in ((x, ux, wx), (y, uy, wy))]
        assert found <= math.dist((s * ahead * vx, s * ahead * vy), at) + 1e-9
    line = fit_line(me, peer, ahead=ahead, begin=begin, end=end)
    if line is None:
        assert math.hypot(x, y) < 2.0 * RADIUS + 1e-8
        return
    assert line.gap(0.0, 0.0) >= RADIUS

    def kept(part: float) -> bool:
        own = line.gap(part * ahead * vx, part * ahead * vy)
        first = -line.gap(x + part * begin * ux, y + part * begin * uy)
        last = -line.gap(x + part * end * wx, y + part * end * wy)
        return min(own, first, last) >= RADIUS - 1e-9

    # All times are the same fraction of what they should be.
    assert any(kept(part / 256.0) for part in range(257))


@pytest.mark.parametrize(
    ("changes", "number"),
    [
        ({}, 1),
        ({"fits": False}, 0),
        ({"placed": False}, 0),
        ({"state": ASKED}, 0),
        ({"held": 0.25}, 0),  # as good as the new one
        ({"x": 2.0, "held": 1.0}, 0),  # neither can reach it
        ({"x": 2.0, "held": 0.85}, 1),
        ({"x": 1.85, "held": 1.0}, 1),
        ({"x": 2.0, "held": 1.0, "bound": 0.15}, 1),
        ({"x": 2.0, "held": 0.99, "tick": 4}, 1),
        ({"open": OUTSTANDING - 1}, OUTSTANDING),
        ({"open": OUTSTANDING}, OUTSTANDING),
    ],
)
def test_an_owner_proposes_what_its_body_fits_once_either_may_come_to_the_line(
    changes: dict[str, Any], number: int
) -> None:
    usual = {"fits": True, "placed": True, "state": LINES, "held": 0.3, "open": 0}
    it = SimpleNamespace(**usual | {"x": 0.5, "bound": 0.0, "tick": 5} | changes)
    end = OwnEnd(Listed(7, 2, Line(1.0, 0.0, it.held), None, False), True)
    end.state = it.state
    for _ in range(it.open):
        end.lines.propose(end.lines.held, True)
    peer = PeerState(2, 1, it.tick, it.placed, it.x, 0.0, it.bound, 1.0, 0.0, 0.0, 0.0, radius=RADIUS)
    kernel = RobotLife(1, 1, None, SimpleNamespace(fits=lambda *_: it.fits))
    bond, me = Bond(end, RADIUS, peer), MovingDisk(0.0, 0.0, RADIUS)
    proposals, _ = Negotiation(0.2, 1.0).entries(5, [bond], me, kernel, standing=False)
    assert [each.number for each in proposals] == [number] * bool(number)


@given(place, place, *[velocity] * 4, seconds, st.floats(0.0, 0.1))
def test_a_standoff_is_left_on_either_side_as_far_as_there_is_any_and_first_to_the_owner(
    x: float, y: float, vx: float, vy: float, wx: float, wy: float, ahead: float, standoff: float
) -> None:
    me, peer = MovingDisk(0.3, -0.2, RADIUS, vx, vy), MovingDisk(x + 0.3, y - 0.2, RADIUS, wx, wy)
    gap = math.hypot(x, y) - 2.0 * RADIUS
    assume(gap > 1e-8)
    line = fit_line(me, peer, ahead=ahead, end=ahead, standoff=standoff)
    room = 0.98 * gap
    assert line.gap(0.3, -0.2) >= RADIUS + min(standoff, room) - 1e-9
    assert -line.gap(x + 0.3, y - 0.2) >= RADIUS + min(standoff, max(0.0, room - standoff)) - 1e-9


@pytest.mark.parametrize(("seen", "way"), [(0.1, 0.12), (0.0, 0.0)], ids=["it does", "it only wants to"])
def test_behind_one_that_drives_off_the_line_follows_it(seen: float, way: float) -> None:
    """Seen 0.6 s ago at 0.3 m, driving off at 0.1 m/s or not at all; obeyed 0.6 s from now."""
    me, peer = MovingDisk(0.2, 0.7, RADIUS, 0.1, 0.0), MovingDisk(0.5, 0.7, RADIUS, 0.1, 0.0, seen, 0.0)
    line = fit_line(me, peer, begin=1.2, end=1.3, share=1.0)
    assert line.offset == pytest.approx(0.5 + way - RADIUS)


@pytest.mark.parametrize(("x", "way"), [(0.0, 0.0), (0.02, -0.01), (0.09, -0.08), (0.1, 0.09), (0.2, 0.0)])
def test_what_backs_off_from_a_disk_goes_straight_away_from_it_as_far_as_it_lacks(
    x: float, way: float
) -> None:
    assert deficit(Disk(0.1, 0.0, 0.04), x, 0.0, 0.05) == pytest.approx((way, 0.0))
    across = (way, 0.0) if x == 0.1 else (0.0, way)
    assert deficit(Disk(0.0, 0.1, 0.04), 0.0, x, 0.05) == pytest.approx(across)


@pytest.mark.parametrize("low", [True, False])
@pytest.mark.parametrize(("near", "gap"), [(0.5, math.hypot(0.3, 1.55) - math.hypot(1.0, 0.05)), (0.6, 1.5)])
def test_the_line_to_a_wall_touches_it_if_that_is_near_else_the_disk_around_it(
    low: bool, near: float, gap: float
) -> None:
    wall = ConvexPolygon(((-0.9, 0.5), (1.1, 0.5), (1.1, 0.6), (-0.9, 0.6)))
    line = tangent(wall, 0.4, -1.0, low, near)
    assert (line.gap(0.4, -1.0) if low else -line.gap(0.4, -1.0)) == pytest.approx(gap)
    assert tangent(wall, 0.1, 0.55, low, near) is None
