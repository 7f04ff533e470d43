"""The filter as a function: nothing touches, harmless wishes are kept, bad input is named."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import disknav
from disknav import UsageError

PERIOD = 0.1


def spread(seed: int, worlds: int, count: int) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    random = np.random.default_rng(seed)
    grid = np.array([(x, y) for x in range(4) for y in range(4)], dtype=float)[:count]
    at = grid + random.uniform(-0.2, 0.2, (worlds, count, 2)) - 1.5
    return at, random.uniform(0.05, 0.28, (worlds, count))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_nothing_touches_whatever_is_wished_and_whatever_part_of_it_the_others_do(seed: int) -> None:
    random = np.random.default_rng(seed)
    at, radii = spread(seed, 3, 9)
    for _ in range(15):
        wishes = random.uniform(-20.0, 20.0, at.shape)
        given_ = disknav.filtered(at, radii, wishes, period=PERIOD, speed=5.0, workspace=3.0)
        assert np.hypot(*np.moveaxis(given_, -1, 0)).max() <= 5.0 + 1e-9
        at = at + PERIOD * random.uniform(0.0, 1.0, (*at.shape[:-1], 1)) * given_
        apart = np.linalg.norm(at[:, :, None] - at[:, None], axis=-1) - radii[:, :, None] - radii[:, None]
        assert apart[:, ~np.eye(9, dtype=bool)].min() > 0.0
        assert (np.linalg.norm(at, axis=-1) + radii).max() < 3.0


def test_harmless_wishes_are_kept_and_worlds_do_not_know_each_other() -> None:
    at, radii = spread(1, 4, 6)
    wishes = np.random.default_rng(2).uniform(-0.3, 0.3, at.shape)
    together = disknav.filtered(at, radii, wishes, period=0.01)
    assert together == pytest.approx(wishes)
    hard = np.random.default_rng(3).uniform(-9.0, 9.0, at.shape)
    for each in range(4):
        alone = disknav.filtered(at[each], radii[each], hard[each], period=PERIOD)
        assert alone == pytest.approx(disknav.filtered(at, radii, hard, period=PERIOD)[each])


def test_a_disk_slides_along_what_is_in_its_way_and_comes_no_closer_to_what_it_touches() -> None:
    at = [[0.0, 0.0], [0.6, 0.0]]
    velocity = disknav.filtered(at, [0.25, 0.25], [[1.0, 1.0], [0.0, 0.0]], period=0.1)
    assert velocity[0] == pytest.approx((0.5, 1.0), abs=1e-6)
    touching = disknav.filtered(at, [0.3, 0.3], [[1.0, 1.0], [-1.0, 0.0]], period=0.1)
    assert touching == pytest.approx(np.array([(0.0, 1.0), (0.0, 0.0)]))


@pytest.mark.parametrize("x", [0.9, 0.95], ids=["at the rim", "over it"])
def test_a_disk_leaves_the_rim_inwards_and_goes_no_farther_out(x: float) -> None:
    at = [[x, 0.0]] * 3
    wishes = [[-0.1, 0.0], [0.1, 0.0], [-0.1, 9.0]]
    velocity = disknav.filtered(
        np.array(at)[:, None], [0.1], np.array(wishes)[:, None], period=0.1, workspace=1.0
    )
    assert velocity[:2, 0] == pytest.approx(np.array([(-0.1, 0.0), (0.0, 0.0)]))
    assert np.hypot(*(np.array(at) + 0.1 * velocity[:, 0]).T) == pytest.approx((x - 0.01, x, x))


@pytest.mark.parametrize(
    "wrong",
    [
        {"wishes": [[np.nan, 0.0]]},
        {"radii": [-0.1]},
        {"radii": [0.1, 0.1]},
        {"positions": [0.0, 0.0], "wishes": [0.0, 0.0]},
        {"period": 0.0},
        {"period": np.inf},
        {"workspace": np.nan},
        {"workspace": -1.0},
    ],
)
def test_bad_input_is_named(wrong: dict[str, Any]) -> None:
    given_ = {"positions": [[0.0, 0.0]], "radii": [0.1], "wishes": [[0.0, 0.0]], "period": 0.1}
    with pytest.raises(UsageError):
        disknav.filtered(**{**given_, **wrong})
