"""A view of three robots, and what it hears."""

from __future__ import annotations

from deploy.telemetry.monitor import snapshot as telling
from deploy.telemetry.monitor.live import FleetView
from protocol.messages import Clock, Health, Standing, Truth
from protocol.scenario.model import RobotSpec, Scenario, Time

SCENARIO = Scenario(
    tuple(RobotSpec(i, 0.03, (0.1 * i - 0.2, 0.0), (0.1 * i - 0.2, 0.1)) for i in (1, 2, 3)),
    name="three",
    time=Time(step=0.05),
)


def view(*, alive: bool = True, lockstep: bool = True) -> FleetView:
    it = FleetView("r")
    it.begin(SCENARIO, lockstep)
    for robot in (None, 1, 2, 3):
        it.present(robot, alive)
    return it


def clock(
    tick: int, active: tuple[int, ...] = (1, 2, 3), verdict: str = "", down: tuple[Standing, ...] = ()
) -> Clock:
    return Clock(tick, tick * 0.05, active, down, verdict)


def truth(tick: int, y: float = 0.0, clearance: float = 0.02, phi: float = 0.5) -> Truth:
    return Truth(tick, (1, 2, 3), tuple((0.1 * i - 0.2, y) for i in (1, 2, 3)), clearance, phi)


def health(
    robot: int, tick: int, *, life: int = 1, published: int = 0, heard: tuple[tuple[int, int], ...] = ()
) -> Health:
    rejected = {"shape": 2, "version": 1}
    return Health(robot, life, tick, 0.001, published, 9, rejected, heard, ((2, 1.0, 0.0, 0.1),))


def rows(it: FleetView, now: float) -> dict[int, dict[str, object]]:
    return {row["id"]: row for row in telling.snapshot(it, now)["robots"]}


def statuses(it: FleetView, now: float) -> list[object]:
    return [row["status"] for row in rows(it, now).values()]


def run_to(it: FleetView, tick: int, now: float, active: tuple[int, ...] = (1, 2, 3)) -> None:
    it.on_message(clock(tick - 1, active), now)
    it.on_message(truth(tick, y=0.001 * tick), now)
