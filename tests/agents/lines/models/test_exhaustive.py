"""The invariant in every reachable state of a small model; `test_mutants` shows that it would notice."""

from __future__ import annotations

import pytest

from tests.agents.lines.models.product import Product
from tests.agents.lines.models.small_model import Bounds, search

PRODUCT = Product()


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("bounds", "at_least"),
    [
        pytest.param(Bounds(proposals=5, outstanding=3), 4_900, id="five proposals, three unanswered"),
        pytest.param(Bounds((1, 2)), 1_500, id="the follower restarts"),
        pytest.param(Bounds((1, 1), proposals=1, fences=1), 400, id="one is fenced"),
        pytest.param(Bounds((1, 2), proposals=1, founding=(1,)), 1_300, id="a founding life comes late"),
        pytest.param(Bounds((1, 1), proposals=1, founding=(2,)), 150, id="the owner comes late"),
        pytest.param(
            Bounds((1, 2), proposals=1, founding=(2,), versions=4, talks_on=True),
            5_300,
            id="an old life of the follower talks on with a late owner",
        ),
        pytest.param(
            Bounds((2, 1), proposals=1, founding=(1,), versions=4, talks_on=True),
            7_700,
            id="an old life of the owner talks on with a late follower",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            Bounds((1, 2), proposals=1, fences=1, talks_on=True),
            11_400,
            id="fenced and restarted, and talks on",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            Bounds((1, 1), proposals=1, founding=(1,), removals=1, appearances=1),
            700,
            id="a disk is taken away and appears",
        ),
        pytest.param(
            Bounds((1, 2), proposals=1, fences=1), 5_000, id="fenced and restarted", marks=pytest.mark.slow
        ),
        pytest.param(Bounds((2, 1)), 4_900, id="the owner restarts", marks=pytest.mark.slow),
        pytest.param(Bounds((2, 2), proposals=1), 9_900, id="both restart", marks=pytest.mark.slow),
        pytest.param(
            Bounds((2, 1), proposals=1, fences=1), 10_000, id="the owner, fenced too", marks=pytest.mark.slow
        ),
        pytest.param(
            Bounds((1, 2), proposals=1, fences=1, deaths=1, versions=3),
            1_000,
            id="the coordinator dies",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_no_order_of_events_breaks_the_invariant(bounds: Bounds, at_least: int) -> None:
    result = search(bounds, PRODUCT)
    assert result.violation == ""
    assert result.visited >= at_least
