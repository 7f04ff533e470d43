from collections.abc import Callable

import pytest

from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Obstacle, RobotSpec, Scenario, Time, Workspace

RADIUS = 0.1
NEEDLE = Obstacle(points=((-0.01, -1.0), (0.01, -1.0), (0.0, 0.0)))
DISK = Obstacle(center=(0.0, -1.0), radius=1.0)


def face(width: float) -> Obstacle:
    return Obstacle(points=((-0.5, width), (0.5, width), (0.5, 1.9), (-0.5, 1.9)))


def corner(width: float) -> Obstacle:
    return Obstacle(points=((-0.3, 1.8), (0.3, 1.8), (0.0, width)))


@pytest.mark.slow
@pytest.mark.parametrize("slack", [1e-3, 1e-2, 1e-1])
@pytest.mark.parametrize(
    ("below", "above"),
    [(NEEDLE, face), (DISK, lambda width: Obstacle(center=(0.0, width + 0.9), radius=0.9)), (DISK, corner)],
    ids=["needle and face", "disks", "disk and corner"],
)
def test_a_robot_passes_a_gap_that_is_little_wider_than_its_disk(
    below: Obstacle, above: Callable[[float], Obstacle], slack: float
) -> None:
    scenario = Scenario(
        (RobotSpec(1, RADIUS, (-1.5, 0.3), (1.5, 0.3)),),
        workspace=Workspace(points=((-2.0, -1.05), (2.0, -1.05), (2.0, 1.95), (-2.0, 1.95))),
        time=Time(limit=20.0, tolerance=0.02),
        control=Control(speed=0.5),
        obstacles=(below, above(2.0 * RADIUS * (1.0 + slack))),
    )
    result = LocalFleet(resolved(validated(scenario))).execute()
    assert result["verdict"] == "arrived"
    assert result["min_clearance"] > 0.0
