"""One run within this process, watched: its report, and where everybody was."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from random import Random
from typing import Any

from agents.shell.node import RobotNode
from deploy.run.local import LocalFleet
from deploy.studies.falsify.runs.exposure import Sides
from deploy.studies.falsify.runs.skipped_waits import skipped_waits
from deploy.studies.falsify.runs.violation import Violation, raised, violations
from protocol.bus.events import Event, Sample
from protocol.keys import every_robot, world_key
from protocol.messages import Clock, Command, State, Truth
from protocol.scenario.model import Scenario
from protocol.wire.codec import decode

PATIENCE = 120.0  # s that a run may take, skipped waits included; the world itself gives up sooner
_CUT = "interrupted"  # verdict of a run that is not waited for
_HOLDUP, _HOLDUPS = 0.7, 80  # s after which a tick is told again; in a run
_OFTEN = 0.05  # of the messages in which it may happen
_GRACE = 0.01  # s after the verdict for those to report who can


@dataclass(frozen=True)
class Observation:
    """What came of a run; no report if it has not come to its end.

    Attributes:
        report: of the scenario, the last one if there was one before.
        truths: of all scenarios, as are `sides` and `violations`.
    """

    report: dict[str, Any] | None
    truths: list[Truth]
    sides: list[Sides]
    violations: list[Violation]

    @property
    def trajectory(self) -> str:
        """Digest of the trajectory, empty if there is none."""
        return "" if self.report is None else str(self.report["trajectory_sha256"])


class Watch:
    """Hears the truth, looks at the lines that robots keep to, and ends a run once it is judged.

    A world waits some seconds for the last reports of robots that the scenario has stopped; nobody
    needs them here.

    Args:
        busy: see `observe`.
        last: number of the scenario, of several on the same robots, with which the run ends.
    """

    def __init__(self, busy: int = 0, last: int = 0) -> None:
        self.finished = False
        self.truths: list[Truth] = []
        self.sides: list[Sides] = []
        self.deadline = inf
        self._judged = False
        self._moments = Random(busy) if busy else None
        self._holdups, self._held_up = _HOLDUPS, (0, -1)
        self._number, self._last = 0, last

    def begin(self, fleet: LocalFleet) -> None:
        """The run of this fleet begins now."""
        self._fleet = fleet
        bus = self._bus = fleet.network.connect()
        run = fleet.run
        bus.subscribe(world_key(run, "truth"), world_key(run, "clock"), every_robot(run, "command"))
        if self._moments is not None:
            bus.subscribe(every_robot(run, "state"))
        bus.node = self
        self.deadline = time.monotonic() + PATIENCE * (self._last + 1)

    def handle(self, event: Event) -> None:
        if not isinstance(event, Sample):
            return
        message = decode(event.key, event.payload)
        if isinstance(message, Truth):
            self.truths.append(message)
        elif isinstance(message, Command):
            self._look(message)
        elif isinstance(message, Clock):
            self._number = message.run_number
            if message.verdict and self._number == self._last and not self._judged:
                self._judged, self.deadline = True, time.monotonic() + _GRACE
        if self._moments is not None and isinstance(message, State | Command):
            self._hold_up(self._moments)

    def _hold_up(self, moments: Random) -> None:
        """Let time pass in the middle of a tick; once in it, so that nobody is given up."""
        moment = self._number, self._fleet.world.world.tick  # what is heard may be of an earlier one
        if moment > self._held_up and self._holdups and moments.random() < _OFTEN:
            self._held_up, self._holdups = moment, self._holdups - 1
            time.sleep(_HOLDUP)
            self._fleet.world.wake(time.monotonic())

    def _look(self, command: Command) -> None:
        """Note what the robot that has just commanded keeps to."""
        node = self._fleet.robots[command.robot].node
        if command.velocity == (0.0, 0.0):
            return  # it stands, or brakes
        if isinstance(node, RobotNode) and node.core is not None and node.core.tick == command.tick:
            self.sides.append((command.tick, command.robot, node.core.health(0, 0, {}).lines))

    def wake(self, now: float) -> None:  # noqa: ARG002
        self.deadline = inf
        self.finished = True

    def hear_out(self) -> None:
        """Take in what was said at the end."""
        self._bus.drain()

    def enough(self) -> bool:
        """Whether nobody need wait any longer."""
        return self.finished or time.monotonic() > self.deadline


def observe(
    scenario: Scenario,
    joining: Sequence[int] | None = None,
    *,
    busy: int = 0,
    before: Sequence[Scenario] = (),
) -> Observation:
    """Run a scenario (k a number).

    Args:
        scenario: what to run.
        joining: the order in which robots join, of their ids unless given.
        busy: seeds the moments at which the machine is so busy that the world has the open tick said again,
            and the order in which messages are heard; 0 for none, and as they were said.
        before: scenarios that are run before it on the same robots.
    """
    scenarios, watch = (*before, scenario), Watch(busy, len(before))
    with skipped_waits():
        try:
            reports = _run(scenarios, joining, watch, Random(busy) if busy else None)
        except Exception as error:  # noqa: BLE001  whatever it is, it is what is looked for
            return Observation(None, watch.truths, watch.sides, [raised(error)])
    found = [each for report in reports for each in violations(report)]
    if reports[-1]["verdict"] == _CUT:
        found.append(Violation("endless", reports[-1]["reason"]))
    ended = len(reports) == len(scenarios)
    return Observation(reports[-1] if ended else None, watch.truths, watch.sides, found)


def _run(
    scenarios: Sequence[Scenario], joining: Sequence[int] | None, watch: Watch, order: Random | None
) -> list[dict[str, Any]]:
    fleet = LocalFleet(scenarios, joining=joining, order=order)
    watch.begin(fleet)
    fleet.network.run(lambda: fleet.world.finished or watch.enough())
    fleet.world.interrupt(_CUT, f"has not ended within {PATIENCE:g} s")
    watch.hear_out()
    return fleet.reports
