"""The escape from deadlocks at any period and any length: the same robots, from centimetres to hundreds of
metres, with a world, messages and lines."""

from dataclasses import replace

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.scenario.model import Scenario, Workspace

pytestmark = pytest.mark.slow


def scaled(name: str, workspace: float, period: float, pace: str) -> Scenario:
    """A scenario of the library in another workspace (m), robots as many times faster, at a period (s)."""
    base = load(name)
    factor = workspace / base.workspace.radius
    robots = tuple(
        replace(
            each,
            radius=factor * each.radius,
            start=(factor * each.start[0], factor * each.start[1]),
            goal=(factor * each.goal[0], factor * each.goal[1]),
        )
        for each in base.robots
    )
    control = base.control if pace == "common" else base.control.without("pace")
    tolerance = factor * base.time.tolerance
    return replace(
        base,
        robots=robots,
        workspace=Workspace(workspace),
        control=replace(control, speed=factor * base.control.speed),
        time=replace(
            base.time, step=period, limit=120.0, tolerance=tolerance, fence=20.0 * period, deadlock=30.0
        ),
    )


@pytest.mark.parametrize("name", ["head-on", "swap-3"])
@pytest.mark.parametrize(
    ("period", "workspace", "pace"), [(0.01, 0.02, "common"), (0.25, 0.02, "own"), (0.5, 200.0, "common")]
)
def test_symmetric_robots_arrive_at_any_period_and_length(
    name: str, period: float, workspace: float, pace: str
) -> None:
    report = LocalFleet(scaled(name, workspace, period, pace)).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0), report["reason"]
