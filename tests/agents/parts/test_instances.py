"""Random instances that take more than bringing the nearest part next."""

import pytest

from deploy.library.load import load
from tests.campaigns.movers import SECONDS, run

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("seed", "kill"),
    [
        pytest.param(37, False, id="three claim at once what goes together in one order only"),
        pytest.param(
            344,
            False,
            id="two without a part share the room that a third one comes into",
            marks=pytest.mark.campaign,
        ),
        pytest.param(
            14,
            True,
            id="a robot dies, and no order remains but by putting elsewhere what another has",
            marks=pytest.mark.campaign,
        ),
        pytest.param(
            11,
            True,
            id="an idle robot stands where the part of a dead one is taken over",
            marks=pytest.mark.campaign,
        ),
        pytest.param(6103, False, id="three give up parts for claims that have lost themselves"),
        pytest.param(1703, True, id="a part is put down beside a dead robot whose own one was taken over"),
        pytest.param(2500, True, id="a carrier that is enclosed with a part puts it back"),
    ],
)
def test_all_parts_get_in_place(seed: int, kill: bool) -> None:
    outcome = run(load("parts-8", [f"time.limit={SECONDS}"], seed), kill)
    assert not outcome.apart
    assert (outcome.left, outcome.contacts) == ((), 0)
    assert outcome.clearance > 0.0
