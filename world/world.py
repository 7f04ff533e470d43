"""The world: one run of a scenario, by coordinator, simulation and referee.

Sans-I/O: no clock, no socket; the caller reports when robots join or leave, and when a tick is over. One
tick: `open_tick` (and `join` for each awaited robot), `accept` Commands, `close_tick`. The modules for
membership, Commands and grants (`world.coordinator`) receive positions from here, not the truth.
"""

from __future__ import annotations

from collections import Counter

import msgspec

from protocol.messages import Command, GoalStatus, Tick, Truth
from protocol.operations import Outcome
from protocol.scenario.model import Journey, Obstacle, Operation, RobotSpec, Scenario
from world.coordinator.exchange import Exchange
from world.coordinator.lives import Lives
from world.coordinator.membership import Membership
from world.coordinator.missions import Missions, Schedule
from world.coordinator.parts import Parts
from world.external import External
from world.judge.verdict import Referee
from world.past import Past
from world.simulation import SimulatedFleet


class WorldCore:
    """One run of a scenario.

    Args:
        scenario: with the gain k a number.
        past: of an earlier world that has ended. Its robots are static until their processes have joined this
            one; its open tick is opened again.
        returning: time for which a fenced robot may still return before the run ends without it, s.
    """

    def __init__(self, scenario: Scenario, past: Past = Past(), *, returning: float = 0.0) -> None:
        self.stopped = past.stopped  # whether an emergency stop is in force
        self.stops = past.stops  # requests for an emergency stop so far
        self.contested = False  # whether there is another coordinator of this run
        self._scheduled = past.scheduled  # number of the scenario's latest stop
        self._misplaced = ""  # why the run ends with the open tick: a disk is not where the ledger has it
        lives = self.lives = Lives(scenario, returning, past.lives, past.tick)
        self.membership = Membership(scenario, lives, past.fleet)
        fleet = self.membership.scenario
        self.missions = Missions(fleet, past.missions, past.numbered)
        self.parts = Parts(fleet, lives)
        self.schedule = Schedule(scenario, past.orders)
        self.exchange = Exchange(scenario, lives, self.missions, past.tick)
        self.exchange.missed, self.exchange.refused = past.missed, Counter(past.refused)
        self.simulation: External | SimulatedFleet  # disks and measurements; of external robots, reports
        if fleet.is_external:
            self.simulation = External(fleet, past.disks, self.tick)
        else:
            self.simulation = SimulatedFleet(fleet, past.disks)
        plant, obstacles = self.simulation.plant, lives.obstacles.standing
        self.referee = Referee(self.parts.loaded, plant.positions, plant.parts, past.referee, obstacles)
        if past.founded:
            self._found()
            self._turn_over()
        if self.halted:
            self.simulation.stop(self.tick)

    @property
    def past(self) -> Past:
        return Past(
            tick=self.tick,
            founded=self.lives.founded,
            stopped=self.stopped,
            stops=self.stops,
            scheduled=self._scheduled,
            lives=self.lives.past,
            missions=self.missions.past,
            numbered=self.missions.numbered,
            fleet=self.membership.fleet,
            orders=self.schedule.past,
            missed=self.exchange.missed,
            refused=self.exchange.refused,
            disks=self.simulation.past,
            referee=self.referee.past,
        )

    @property
    def tick(self) -> int:
        """The open tick, or the next one."""
        return self.exchange.tick

    @property
    def is_open(self) -> bool:
        """Whether `tick` has begun."""
        return self.exchange.ticks is not None

    @property
    def scenario(self) -> Scenario:
        """The scenario with the present robots."""
        return self.membership.scenario

    @property
    def truth(self) -> Truth:
        """Position of every disk at the start of `tick`."""
        return self.referee.record.totals.truth

    @property
    def verdict(self) -> str:
        """Verdict of the run; empty while it continues."""
        return self.referee.verdict

    # -- joining and leaving

    def join(self, robot: int) -> int:
        """A process takes over a robot, from the next opening of a tick on; returns its incarnation.

        Raises:
            JoinError: unknown id, or an id that is running or held down by the scenario.
        """
        return self.lives.join(robot, heard=self.tick if self.is_open else self.tick - 1)

    def lost(self, robot: int, reason: str = "") -> bool:
        """Exclude a robot whose process has failed: from now on it is static. False if it was not active.

        In an open tick, its Ticks inform the others. `reason` is for the report.
        """
        took_part = self.lives.lose(self.tick, robot, reason)
        self.exchange.drop(robot)
        return took_part

    def give_up_waiting(self, robot: int, reason: str = "") -> bool:
        """Continue without a robot of `lives.awaited`, which may still join later; otherwise as `lost`."""
        return self.lives.give_up(self.tick, robot, reason)

    # -- a tick

    def open_tick(self) -> dict[int, Tick]:
        """Begin the tick; returns the Tick for each robot that may listen. Idempotent until `close_tick`.

        The scenario's orders and process faults of this tick are applied first, those of the first tick after
        all robots have joined, so that all begin the run in any order of joining. While robots are awaited
        the tick does not begin: then only fenced robots that are not yet informed receive a Tick.
        """
        lives, simulation = self.lives, self.simulation
        if self.exchange.ticks is not None:
            return self.exchange.ticks
        if not lives.founded and not lives.awaited:
            self._found()
        if lives.founded:
            self.schedule.carry_out(self.tick, self)
            lives.apply_faults(self.tick)
        if not lives.founded or lives.awaited:
            return self.exchange.fenced(self.halted)
        sensed = simulation.sense(self.tick)
        self._misplaced = lives.begin(simulation.resting(), simulation.bounds, simulation.unsettled)
        return self.exchange.open(self.scenario, sensed, self.halted)

    def accept(self, command: Command) -> bool:
        """Accept the first command of an active life for the open tick, or count its refusal."""
        taken = self.exchange.accept(command)
        if taken:
            self.simulation.on_command(command)
        return taken

    def close_tick(self) -> None:
        """End the tick: move, judge, advance. Robots without a Command stand, after silence fenced."""
        if not self.is_open:
            raise RuntimeError(f"tick {self.tick} is not open: call open_tick, and join for those awaited")
        simulation, record = self.simulation, self.referee.record
        taken = self.exchange.taken
        if self.halted:
            simulation.brake(self.tick)
        else:
            simulation.move({robot: each.velocity for robot, each in taken.items()}, self.tick)
        bounds = simulation.bounds
        for robot, position in simulation.resting().items():
            if robot not in taken:
                self.lives.fence(self.tick, robot, position, bounds.get(robot, 0.0))
        self.exchange.close()
        plant = simulation.plant
        record.add(plant.positions, plant.between, plant.touched())
        resized = self._handle()
        if self.lives.settle():
            record.set_obstacles(self.lives.obstacles.standing)
            resized |= self.parts.settle()
        if resized:
            self._judge_anew()
        self._turn_over()
        record.begin()
        self._decide()

    def _found(self) -> None:
        """Begin the ledger on the places of all disks."""
        radii = {spec.id: spec.radius for spec in self.parts.loaded.robots}
        self.lives.found(radii, self.simulation.places, self.simulation.founding_bounds)

    def _handle(self) -> bool:
        """Execute the requests for parts; returns whether a disk changed."""
        if not self.scenario.parts or self.halted:
            return False
        live = {
            robot: command.handles
            for robot, command in self.exchange.taken.items()
            if self.lives.roster.status(robot) == "live" and robot not in self.membership.fleet.leaving
        }
        return self.parts.handle(live, self.simulation.places)

    def _judge_anew(self) -> None:
        """Continue with the present disks, loaded carriers included, and the present obstacles."""
        obstacles = self.lives.obstacles.standing
        self.referee.set_fleet(self.parts.loaded, self.simulation.plant.positions, obstacles, self.tick)

    def _turn_over(self) -> None:
        """Between two ticks, let added robots appear, and remove robots."""
        if self.membership.turn_over(self.tick, self.simulation.places):
            self.simulation.set_fleet(self.scenario)
            self.missions.set_fleet(self.scenario)
            self.parts.set_fleet(self.scenario)
            self._judge_anew()

    def _decide(self) -> None:
        plant, lives = self.simulation.plant, self.lives
        if self.halted:
            self.referee.reset_deadlock_timer(self.tick)
        for robot in self.missions.advance(self.tick, plant.ids, plant.positions):
            self._redirect(robot)
        if self._misplaced:
            self.finish("aborted", self._misplaced)
        if not self.verdict and not self.scenario.time.endless:
            self.referee.decide(self.tick, plant.positions, lives.up, self._is_alone(), self._pending())

    def _pending(self) -> str:
        """Unfinished orders, scheduled orders and parts, as text; "" if none."""
        kinds = (
            (self.missions.pending, "orders are under way"),
            (self.membership.fleet.announced, "robots are still to appear"),
            (self.schedule.pending, "orders are still to come"),
            (self.parts.pending, "parts are not at their goals"),
        )
        return ", ".join(text for pending, text in kinds if pending)

    def _is_alone(self) -> bool:
        """Whether missing robots are lost permanently; False for external bases, which may return."""
        if self.scenario.is_external or self.schedule.pending:
            return False
        return len(self.lives.up) < len(self.scenario.ids) and self.lives.gone_for_good(self.tick - 1)

    def finish(self, verdict: str, reason: str) -> None:
        """End the run, e.g. as interrupted or aborted; a collision has priority, later verdicts none."""
        self.referee.finish(verdict, reason)

    # -- operations

    def operate(self, operation: Operation, *, scheduled: bool = False) -> Outcome:
        """Execute an operation; a refused one changes nothing.

        Args:
            scheduled: whether it is the scenario's: the run waits for the process of an added robot, and a
                release lifts no stop by an operator.
        """
        if operation.goal is not None:
            return self._order(operation.goal)
        if operation.add is not None:
            return self._add(operation.add, awaited=scheduled)
        if operation.remove is not None:
            return self._remove(operation.remove)
        if operation.place is not None:
            return self._place(operation.place)
        if operation.take is not None:
            return self._take(operation.take)
        return self._halt(bool(operation.halt), operation.release, scheduled=scheduled)

    def _order(self, order: Journey) -> Outcome:
        standing, obstacles = self.lives.roster.standing, self.lives.obstacles.standing
        if refusal := self.missions.refusal(order, standing, obstacles):
            return Outcome(False, text=refusal)
        outcome = self.missions.accept(order, self.tick, self.simulation.places[order.robot])
        self._redirect(order.robot)
        return outcome

    def _redirect(self, robot: int) -> None:
        goal = self.missions.goal(robot)
        assert goal is not None
        self.referee.set_goal(robot, goal, self.tick)

    def goal_statuses(self) -> tuple[GoalStatus, ...]:
        """Status of the goals of all robots, by increasing id."""
        arrived = set(self.referee.arrived(self.simulation.plant.positions))
        statuses = map(self.missions.status, self.scenario.ids)
        return tuple(
            msgspec.structs.replace(status, tick=self.tick, status="arrived")
            if status.number == 0 and status.robot in arrived
            else status
            for status in statuses
        )

    def _add(self, spec: RobotSpec, *, awaited: bool) -> Outcome:
        """Announce the disk of another robot; it appears once every robot keeps clear of its start."""
        reason = self._fixed or self.membership.unfit(spec) or self.simulation.plant.refusal(spec)
        if not reason:
            self.membership.add(spec, awaited=awaited)
        return Outcome(not reason, text=reason)

    def _remove(self, robot: int) -> Outcome:
        """End a robot and remove its disk, at the end of the open tick or otherwise now."""
        part = self.parts.carried_by(robot)
        reason = f"robot {robot} carries part {part}" if part else ""
        reason = reason or self._fixed or self.membership.remove(robot)
        if not reason and not self.is_open:
            self._turn_over()
        return Outcome(not reason, text=reason)

    @property
    def _fixed(self) -> str:
        """The reason why robots cannot be added or removed; "" if they can."""
        if not self.lives.founded or self.verdict:
            return "the run has not begun, or is over"
        return self.simulation.plant.fixed

    def _place(self, order: Obstacle) -> Outcome:
        """Announce an obstacle, which appears once robots keep clear. Refused before the first tick."""
        positions = self.simulation.plant.positions
        refusal = "" if self.lives.founded else "the run has not begun"
        refusal = refusal or self.lives.obstacles.refusal(order, self.parts.loaded, positions)
        if refusal:
            return Outcome(False, text=refusal)
        number = self.lives.announce(order.shape)
        self.referee.reset_deadlock_timer(self.tick)
        return Outcome(True, number, self.missions.covered(order.shape))

    def _take(self, number: int) -> Outcome:
        if part := self.parts.owns(number):
            return Outcome(False, text=f"obstacle {number} is part {part}, which robots carry")
        if not (self.lives.founded and self.lives.take_away(number)):
            return Outcome(False, text=f"there is no obstacle {number}")
        self.referee.set_obstacles(self.lives.obstacles.standing, self.tick)
        return Outcome(True, number)

    # -- the emergency stop

    @property
    def halted(self) -> bool:
        """Whether all robots must stand."""
        return self.stopped or self.contested

    def _halt(self, stopped: bool, seen: int | None, *, scheduled: bool) -> Outcome:
        """Stop or release the robots; a release that knows of fewer stops was long on its way."""
        if seen is not None and seen != self.stops:
            return Outcome(False, text="the robots have been stopped again")
        if scheduled and self.stopped and self.stops != self._scheduled and not stopped:
            return Outcome(False, text="an operator has stopped the robots")
        self.stops += stopped
        if scheduled and stopped and not self.stopped:
            self._scheduled = self.stops
        self._stand(stopped, self.contested)
        return Outcome(True)

    def contest(self, contested: bool) -> None:
        """Set whether there is another coordinator of this run: then all robots stand, also if released."""
        self._stand(self.stopped, contested)

    def _stand(self, stopped: bool, contested: bool) -> None:
        """Stop all robots from the open tick on, or release them."""
        before, self.stopped, self.contested = self.halted, stopped, contested
        if self.halted and not before:
            self.simulation.stop(self.tick + self.is_open)

    @property
    def moving(self) -> tuple[int, ...]:
        """Robots that still move after an emergency stop; none once the run is over."""
        if not self.halted or self.verdict:
            return ()
        return tuple(sorted(self.simulation.moving()))
