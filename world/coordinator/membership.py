"""Membership of the fleet: robots that are added and removed during the run.

An added disk appears once every robot keeps clear of its place, static until its process joins. A removed
robot ends with the open tick, and its disk disappears then.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import msgspec

from protocol.geometry import Disk
from protocol.messages import Id, Member, Vector
from protocol.scenario.checks import misfits
from protocol.scenario.model import RobotSpec, Scenario, gain_for_fleet
from world.coordinator.lives import Lives
from world.coordinator.missions import obstruction

_MOST = 1000  # robots at a time, limited by the size of a State
_MOST_IDS = 1200  # ids in a run, which a roster lists


class FleetChange(msgspec.Struct):
    """The fleet at a tick, and its pending changes."""

    robots: tuple[RobotSpec, ...] | None = None  # that are there; None: those of the scenario
    # Whose disks have not appeared yet, and whether their processes must join as soon as they have.
    announced: dict[Id, tuple[RobotSpec, bool]] = {}
    leaving: set[Id] = set()  # that leave with the open tick


class Membership:
    """Changes of the fleet between two ticks; `fleet` is the state of an earlier coordinator."""

    def __init__(self, scenario: Scenario, lives: Lives, fleet: FleetChange | None = None) -> None:
        self._first, self.fleet = scenario, FleetChange() if fleet is None else fleet
        # With the present robots.
        self.scenario = scenario if self.fleet.robots is None else self._with(self.fleet.robots)
        self._lives = lives

    def add(self, spec: RobotSpec, *, awaited: bool) -> None:
        """Announce a disk that is not `unfit`; `awaited`: whether the run waits for its process."""
        lives = self._lives
        known = lives.roster.members.get(spec.id)
        life = 0 if known is None else known.incarnation
        lives.roster.put(Member(spec.id, life, "appearing", spec.radius, spec.start))
        lives.keeper.announce(spec.id, Disk(*spec.start, spec.radius))
        self.fleet.announced[spec.id] = spec, awaited

    def remove(self, robot: int) -> str:
        """Remove a robot; returns the reason of a refusal, otherwise ""."""
        ids = self.scenario.ids
        if robot in self.fleet.announced:
            self._lives.roster.alter(robot, status="gone", position=None)
            self._lives.keeper.remove(robot)
            del self.fleet.announced[robot]
            return ""
        if robot not in ids:
            return f"no robot {robot} in the fleet; there are {', '.join(map(str, ids))}"
        if set(ids) <= self.fleet.leaving | {robot}:
            return f"robot {robot} is the last one: stop the run instead"
        self.fleet.leaving.add(robot)
        return ""

    def turn_over(self, tick: int, places: Mapping[int, Vector]) -> bool:
        """Before `tick`, with all disks at `places` (m), let announced disks appear, and remove those that
        leave. Returns whether `scenario` has changed.
        """
        fleet = self.fleet
        settled = [robot for robot in fleet.announced if self._lives.keeper.appear(robot)]
        left, fleet.leaving = fleet.leaving, set()
        if not settled and not left:
            return False
        new = []
        for robot in settled:
            spec, awaited = fleet.announced.pop(robot)
            new.append(spec)
            self._lives.put_up(tick, robot, awaited)
        for robot in sorted(left):
            self._lives.remove(tick, robot, places[robot])
        stay = [spec for spec in self.scenario.robots if spec.id not in left]
        fleet.robots = (*stay, *new)
        self.scenario = self._with(fleet.robots)
        return True

    def _with(self, robots: tuple[RobotSpec, ...]) -> Scenario:
        first = self._first
        k = gain_for_fleet(first.k, len(first.robots), len(robots))
        interest: Literal["near", "all"] = "near" if first.hears_near else "all"  # permanently
        network, control = replace(first.network, interest=interest), replace(first.control, k=k)
        return replace(first, robots=robots, control=control, network=network)

    def unfit(self, spec: RobotSpec) -> str:
        """The reason why a robot cannot be added; "" if it can."""
        robot = spec.id
        for problem in misfits(spec, self.scenario.body):
            return f"robot {robot}: {problem}"
        if (status := self._lives.roster.status(robot)) not in ("", "gone"):
            return f"robot {robot} is {status}: use another id, or remove it first"
        if len(self.scenario.robots) + len(self.fleet.announced) >= _MOST:
            return f"robot {robot}: a run can have at most {_MOST} robots at a time"
        if not status and len(self._lives.roster.members) >= _MOST_IDS:
            return f"robot {robot}: this run has used {_MOST_IDS} ids; use that of a robot that has left"
        obstacles, standing = self._lives.obstacles.standing, self._lives.roster.standing
        at_start = obstruction(self.scenario, robot, spec.radius, spec.start, standing, obstacles)
        return at_start or obstruction(self.scenario, robot, spec.radius, spec.goal, (), obstacles)
