"""A Tick that names no robot means those that the world named last, and the robot does the same."""

from __future__ import annotations

from dataclasses import replace

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.scenario.model import ProcessFault
from protocol.scenario.network import Network
from tests.skipped_waits import skipped_waits


def test_who_missed_when_others_came_near_waits_for_nobody_who_is_gone() -> None:
    base, ids = load("random-14"), (1, 4, 5, 8, 10, 12, 13)
    scenario = replace(
        base,
        robots=tuple(spec for spec in base.robots if spec.id in ids),
        network=Network("near", 0.1),
        process=tuple(
            ProcessFault(robot, tick * 0.05, event)
            for robot, tick, event in ((1, 42, "pause"), (5, 47, "kill"), (1, 50, "resume"))
        ),
        time=replace(base.time, limit=4.0),
    )
    with skipped_waits(), LocalFleet(scenario) as fleet:
        assert fleet.execute()["faults"]["given_up"] == []
