"""The world: one run of a scenario, as coordinator, simulation and referee make it together.

Sans-I/O: no clock, no socket; the caller says when robots joined, went, and when a tick is over.
One tick: `open_tick` (and `coordinator.join` for each awaited robot), `accept` commands, `close_tick`.
"""

from __future__ import annotations

import msgspec

from protocol.messages import Command, GoalStatus, Tick, Truth
from protocol.operations import Outcome
from protocol.scenario.model import Journey, Obstacle, Operation, RobotSpec, Scenario
from world.coordinator.coordinator import Coordinator, PastCoordinator
from world.external import External
from world.judge.verdict import PastReferee, Referee
from world.plants.plant import PastDisks
from world.simulation import SimulatedFleet


class Past(msgspec.Struct, frozen=True):
    """What a world leaves behind for another one, which goes on with the same run.

    It is not the state of a process: lives, lines, grants and messages under way end with their world.
    """

    coordinator: PastCoordinator = PastCoordinator()
    disks: PastDisks | None = None
    referee: PastReferee | None = None


class WorldCore:
    """One run of a scenario.

    Args:
        scenario: with the gain k a number.
        past: of an earlier world, which is no more. Its robots stand where it left them, until their
            processes have joined this one; its open tick is opened again.
        returning: s for which a robot that was fenced may yet come back, before the run is over without it.

    Attributes:
        coordinator: membership, commands, orders.
        simulation: where the disks are, and what robots sense; of an external fleet, what it reports.
        referee: what happened, and how the run ended.
    """

    def __init__(self, scenario: Scenario, past: Past = Past(), *, returning: float = 0.0) -> None:
        coordinator = self.coordinator = Coordinator(scenario, returning, past.coordinator)
        fleet, obstacles = coordinator.scenario, coordinator.lives.obstacles.standing
        self.simulation: External | SimulatedFleet
        if fleet.is_external:
            self.simulation = External(fleet, past.disks, self.tick)
        else:
            self.simulation = SimulatedFleet(fleet, past.disks)
        plant, loaded = self.simulation.plant, coordinator.parts.loaded(fleet)
        self.referee = Referee(loaded, plant.positions, plant.parts, past.referee, obstacles)
        if past.coordinator.founded:
            coordinator.found(self.simulation.places, self.simulation.founding_bounds)
            self._turn_over()
        if coordinator.halted:
            self.simulation.stop(self.tick)

    @property
    def past(self) -> Past:
        """What another world needs to go on from here."""
        return Past(self.coordinator.past, self.simulation.past, self.referee.past)

    @property
    def tick(self) -> int:
        """The tick that is open, or that is to be opened next."""
        return self.coordinator.tick

    @property
    def is_open(self) -> bool:
        """Whether `tick` has begun."""
        return self.coordinator.told is not None

    @property
    def scenario(self) -> Scenario:
        """The scenario with the robots that are there now."""
        return self.coordinator.scenario

    @property
    def truth(self) -> Truth:
        """Where every disk is at the start of `tick`."""
        return self.referee.record.totals.truth

    def news(self) -> list[Truth]:
        """The truth of every tick up to `tick` that was not handed out yet; each is handed out once."""
        return self.referee.record.news()

    @property
    def verdict(self) -> str:
        """How the run ended; empty while it goes on."""
        return self.referee.verdict

    @property
    def reason(self) -> str:
        """Why it ended; empty while it goes on."""
        return self.referee.reason

    # -- a tick

    def open_tick(self) -> dict[int, Tick]:
        """Begin the tick; returns the Tick for each robot that may listen. Idempotent until `close_tick`.

        The scenario's orders and process faults of this tick happen first, those of the first tick once all
        robots have joined: all of them begin the run, in any order of joining. While robots are awaited the
        tick does not begin: only those receive a Tick that have to learn that they were fenced.
        """
        coordinator = self.coordinator
        if coordinator.told is not None:
            return coordinator.told
        simulation = self.simulation
        if not coordinator.opens(simulation.places, simulation.founding_bounds, self):
            return coordinator.tell_fenced()
        sensed = simulation.sense(self.tick)
        return coordinator.open(sensed, simulation.resting(), simulation.bounds, simulation.unsettled)

    def accept(self, command: Command) -> bool:
        """Take a command if it is of the open tick, of an active life and the first; else count why not."""
        taken = self.coordinator.accept(command)
        if taken:
            self.simulation.hear(command)
        return taken

    def close_tick(self) -> None:
        """End the tick: move everything, judge, advance. Missing commands mean standing still."""
        if not self.is_open:
            raise RuntimeError(
                f"tick {self.tick} is not open: call open_tick, and coordinator.join for those awaited"
            )
        coordinator, simulation, referee = self.coordinator, self.simulation, self.referee
        coordinator.commands.close()
        if coordinator.halted:
            simulation.brake(self.tick)
        else:
            taken = coordinator.commands.taken
            simulation.move({robot: each.velocity for robot, each in taken.items()}, self.tick)
        coordinator.close(simulation.resting(), simulation.bounds)
        plant = simulation.plant
        referee.record.add(plant.positions, plant.between, plant.touched())
        resized = self._handle()
        if coordinator.lives.settle():
            referee.record.set_obstacles(coordinator.lives.obstacles.standing)
            resized |= coordinator.parts.settle()
        if resized:
            self._judge_anew()
        self._turn_over()
        self._decide()

    def _handle(self) -> bool:
        """Let robots take up parts and put them down; returns whether a disk changed."""
        coordinator = self.coordinator
        if not self.scenario.parts or coordinator.halted:
            return False
        leaving = coordinator.membership.fleet.leaving
        live = {
            robot: command.handles
            for robot, command in coordinator.commands.taken.items()
            if coordinator.lives.roster.status(robot) == "live" and robot not in leaving
        }
        return coordinator.parts.handle(live, self.simulation.places)

    def _judge_anew(self) -> None:
        """Judge from now on by the present disks, loaded carriers included, and the present obstacles."""
        loaded = self.coordinator.parts.loaded(self.scenario)
        obstacles = self.coordinator.lives.obstacles
        self.referee.set_fleet(loaded, self.simulation.plant.positions, obstacles.standing, self.tick)

    def _turn_over(self) -> None:
        """Between two ticks: let robots appear that were added, and vanish that were removed."""
        coordinator, simulation = self.coordinator, self.simulation
        if not coordinator.membership.turn_over(self.tick, simulation.places):
            return
        simulation.set_fleet(self.scenario)
        coordinator.missions.recast(self.scenario)
        coordinator.parts.recast(self.scenario)
        self._judge_anew()

    def _decide(self) -> None:
        coordinator, referee, plant = self.coordinator, self.referee, self.simulation.plant
        if coordinator.halted:
            referee.reset_deadlock_timer(self.tick)
        for robot in coordinator.missions.advance(self.tick, plant.ids, plant.positions):
            self._redirect(robot)
        if not self.verdict and not self.scenario.time.endless:
            up = coordinator.lives.up
            referee.decide(self.tick, plant.positions, up, coordinator.is_alone(), coordinator.pending)

    def finish(self, verdict: str, reason: str) -> None:
        """End the run, e.g. as interrupted or aborted; a collision outranks, a second verdict is ignored."""
        self.referee.finish(verdict, reason)

    # -- operations

    def operate(self, operation: Operation, *, awaited: bool = False) -> Outcome:
        """Carry out an operation; a refused one changes nothing.

        Args:
            awaited: whether the run goes on only once the process of a robot that is added has joined.
        """
        if operation.goal is not None:
            return self._order(operation.goal)
        if operation.add is not None:
            return self._add(operation.add, awaited)
        if operation.remove is not None:
            return self._remove(operation.remove)
        if operation.place is not None:
            return self._place(operation.place)
        if operation.take is not None:
            return self._take(operation.take)
        return self._halt(bool(operation.halt))

    def _order(self, order: Journey) -> Outcome:
        """Set a robot's goal, from the next opened tick on."""
        coordinator, robot = self.coordinator, order.robot
        obstacles = coordinator.lives.obstacles.standing
        refusal = coordinator.missions.refusal(order, coordinator.lives.roster.standing, obstacles)
        if refusal:
            return Outcome(False, text=refusal)
        outcome = coordinator.missions.accept(order, self.tick, self.simulation.places[robot])
        self._redirect(robot)
        return outcome

    def _redirect(self, robot: int) -> None:
        goal = self.coordinator.missions.goal(robot)
        assert goal is not None
        self.referee.set_goal(robot, goal, self.tick)

    def goal_statuses(self) -> tuple[GoalStatus, ...]:
        """Status of the goals of all robots, by increasing id."""
        arrived = set(self.referee.arrived(self.simulation.plant.positions))
        statuses = map(self.coordinator.missions.status, self.scenario.ids)
        return tuple(
            msgspec.structs.replace(status, tick=self.tick, status="arrived")
            if status.number == 0 and status.robot in arrived
            else status
            for status in statuses
        )

    def goal_news(self) -> list[GoalStatus]:
        """Changes of order status since the last call."""
        return self.coordinator.missions.news()

    def _add(self, spec: RobotSpec, awaited: bool) -> Outcome:
        """Announce the disk of another robot; it appears once every robot keeps clear of its start."""
        membership, plant = self.coordinator.membership, self.simulation.plant
        reason = self._fixed or membership.unfit(spec) or plant.refusal(spec)
        if not reason:
            membership.add(spec, awaited=awaited)
        return Outcome(not reason, text=reason)

    def _remove(self, robot: int) -> Outcome:
        """End a robot and take its disk away, at the end of the open tick or else now."""
        part = self.coordinator.parts.carried_by(robot)
        reason = f"robot {robot} carries part {part}" if part else ""
        reason = reason or self._fixed or self.coordinator.membership.remove(robot)
        if not reason and not self.is_open:
            self._turn_over()
        return Outcome(not reason, text=reason)

    @property
    def _fixed(self) -> str:
        """Why no robot can come or go; "" if that is possible."""
        if not self.coordinator.lives.founded or self.verdict:
            return "the run has not begun, or is over"
        return self.simulation.plant.fixed

    def _place(self, order: Obstacle) -> Outcome:
        """Announce an obstacle; it appears once every robot keeps clear of its place. Refused before the
        first tick.
        """
        coordinator = self.coordinator
        refusal = "" if coordinator.lives.founded else "the run has not begun"
        loaded, positions = coordinator.parts.loaded(self.scenario), self.simulation.plant.positions
        refusal = refusal or coordinator.lives.obstacles.refusal(order, loaded, positions)
        if refusal:
            return Outcome(False, text=refusal)
        number = coordinator.lives.announce(order.shape)
        self.referee.reset_deadlock_timer(self.tick)
        return Outcome(True, number, coordinator.missions.covered(order.shape))

    def _take(self, number: int) -> Outcome:
        """Remove an obstacle, or withdraw its announcement."""
        coordinator = self.coordinator
        if part := coordinator.parts.owns(number):
            return Outcome(False, text=f"obstacle {number} is part {part}, which robots carry")
        if not (coordinator.lives.founded and coordinator.lives.take_away(number)):
            return Outcome(False, text=f"there is no obstacle {number}")
        self.referee.set_obstacles(coordinator.lives.obstacles.standing, self.tick)
        return Outcome(True, number)

    def _halt(self, halted: bool) -> Outcome:
        """Have all robots stand, from the open tick on, or release them."""
        if halted != self.coordinator.stopped:
            before, self.coordinator.stopped = self.coordinator.halted, halted
            self._stop(before)
        return Outcome(True)

    def contest(self, contested: bool) -> None:
        """Another coordinator of this run appeared or left: all robots stand meanwhile, even if a stop is
        released."""
        if contested != self.coordinator.contested:
            before, self.coordinator.contested = self.coordinator.halted, contested
            self._stop(before)

    def _stop(self, before: bool) -> None:
        if self.coordinator.halted and not before:
            self.simulation.stop(self.tick + self.is_open)

    @property
    def moving(self) -> tuple[int, ...]:
        """Robots that an emergency stop has not brought to a stand yet; none once the run is over."""
        if not self.coordinator.halted or self.verdict:
            return ()
        return tuple(sorted(self.simulation.moving()))
