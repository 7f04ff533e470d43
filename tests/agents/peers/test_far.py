"""Far disks in a robot's slice: exact at one place, close around it, without peers that are known better."""

import math
from random import Random

import numpy as np
import pytest

from agents.law.gradient import Slice
from agents.peers.far import NOTHING, FarField, FarPicture, SummaryPlaces
from agents.peers.state import Peer
from protocol.messages import Summary
from world.coordinator.exchange import runs

OWN, PLACE, GOAL, WORKSPACE = 0.04, (0.1, -0.2), (0.5, 0.3), 3.0


def crowd(seed: int, count: int, least: float) -> list[Peer]:
    """Disks at least so far from PLACE, m."""
    random = Random(seed)
    peers: list[Peer] = []
    while len(peers) < count:
        x, y, gamma = np.float32(
            [random.uniform(-2.5, 2.5), random.uniform(-2.5, 2.5), random.uniform(0.0, 4.0)]
        ).tolist()
        if math.dist((x, y), PLACE) > least:
            peers.append(Peer(x, y, random.uniform(0.02, 0.06), gamma))
    return peers


def field_of(far: list[Peer], slices: list[float], known: list[int] | None = None) -> FarField:
    """That of disks with the ids from 1 on, for a robot that knows some of them, by index."""
    places, gammas = np.float32([(each.x, each.y) for each in far]), np.float32([each.gamma for each in far])
    ids = runs(list(range(1, len(far) + 1)))
    summary = Summary(3, ids, places.tobytes(), gammas.tobytes(), np.float32(slices).tobytes())
    picture = FarPicture(SummaryPlaces(summary), {n: each.radius for n, each in enumerate(far, 1)})
    return picture.field(PLACE, OWN, [1 + index for index in known or ()])


def slices(near: list[Peer], far: list[Peer], known: list[int] | None = None) -> tuple[Slice, Slice]:
    """With all of them one by one, and with a field in place of the far ones."""
    field = field_of(far, [each.gamma for each in far], known)
    left = [each for index, each in enumerate(far) if index not in (known or ())]
    every = Slice(GOAL, OWN, WORKSPACE, 50.0, [*near, *left])
    return every, Slice(GOAL, OWN, WORKSPACE, 50.0, near, field)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("known", [[], [0, 7, 3]])
def test_it_is_exact_where_it_was_taken(seed: int, known: list[int]) -> None:
    exact, short = slices(crowd(seed, 6, 0.12), crowd(seed + 100, 60, 0.4), known)
    assert short(*PLACE) == pytest.approx(exact(*PLACE), rel=1e-12)
    one, other = exact.gradient(*PLACE), short.gradient(*PLACE)
    assert [other.dx, other.dy, other.xx, other.xy, other.yx, other.yy] == pytest.approx(
        [one.dx, one.dy, one.xx, one.xy, one.yx, one.yy], rel=1e-12
    )


def test_around_it_the_error_is_of_second_order() -> None:
    exact, short = slices([], crowd(1, 60, 0.4))
    errors = []
    for size in (0.04, 0.02):
        x, y = PLACE[0] + size, PLACE[1] - size
        errors.append(math.dist(exact(x, y), short(x, y)))
    assert errors[1] < 0.3 * errors[0] < 0.01 * math.hypot(*exact(*PLACE))


def test_the_derivative_is_that_of_the_field() -> None:
    _, short = slices(crowd(2, 3, 0.15), crowd(3, 40, 0.4))
    x, y = PLACE[0] + 0.03, PLACE[1]
    step, found = 1e-6, short.gradient(x, y)
    ahead, behind = short(x + step, y), short(x - step, y)
    assert (ahead[0] - behind[0]) / (2.0 * step) == pytest.approx(found.xx, rel=1e-5)
    assert (ahead[1] - behind[1]) / (2.0 * step) == pytest.approx(found.yx, rel=1e-5)


def test_disks_that_may_touch_are_left_out_and_an_empty_field_is_nothing() -> None:
    touching = field_of([Peer(*PLACE, 0.06, 2.0)], [1.5])
    assert (touching.log_x, touching.xx) == (0.0, 0.0)
    assert (touching.gamma, touching.largest, touching.slice) == (2.0, 2.0, 1.5)
    for empty in (NOTHING, field_of([Peer(0.0, 0.0, 0.96, 1.0)], [1.0], [0])):
        assert (empty.count, empty.gamma, empty.slice) == (0, 0.0, 0.0)
