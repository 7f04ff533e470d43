"""Random instances that take more than bringing the nearest part next."""

import pytest

from deploy.library.load import load
from protocol.scenario.model import Carrying, Control, Obstacle, Part, RobotSpec, Scenario, Workspace
from tests.campaigns.movers import SECONDS, run

pytestmark = pytest.mark.slow


CASES = {
    "three claim at once what goes together in one order only": (37, False),
    "two without a part share the room that a third one comes into": (344, False),
    "a robot dies, and no order remains but by putting elsewhere what another has": (14, True),
    "an idle robot stands where the part of a dead one is taken over": (11, True),
    "three give up parts for claims that have lost themselves": (6103, False),
    "a part is put down beside a dead robot whose own one was taken over": (1703, True),
    "a carrier that is enclosed with a part puts it back": (2500, True),
}
LATER = dict.fromkeys((344, 14, 11), pytest.mark.campaign)


@pytest.mark.parametrize(
    ("seed", "kill"),
    [pytest.param(*case, id=name, marks=LATER.get(case[0], ())) for name, case in CASES.items()],
)
def test_all_parts_get_in_place(seed: int, kill: bool) -> None:
    outcome = run(load("parts-8", [f"time.limit={SECONDS}"], seed), kill)
    assert (outcome.left, outcome.contacts) == ((), 0)
    assert outcome.clearance > 0.0


def test_a_part_in_place_that_bars_the_way_of_another_is_carried_aside_and_back() -> None:
    room = Workspace(points=((-0.4, -0.25), (0.4, -0.25), (0.4, 0.25), (-0.4, 0.25)))
    walls = (
        Obstacle(points=((-0.01, low), (0.01, low), (0.01, high), (-0.01, high)))
        for low, high in ((-0.25, -0.06), (0.06, 0.25))
    )
    robot, door = RobotSpec(1, 0.03, (-0.33, 0.15), (-0.33, 0.15)), (0.0, 0.0)
    scenario = Scenario(
        (robot,),
        workspace=room,
        obstacles=tuple(walls),
        control=Control(k=3.0),
        parts=(Part(0.04, door, door), Part(0.04, (-0.2, 0.0), (0.25, 0.0))),
        carrying=Carrying(0.03),
    )
    outcome = run(scenario)
    assert (outcome.left, outcome.contacts) == ((), 0)
