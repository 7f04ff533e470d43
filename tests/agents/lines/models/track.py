"""Robots on a track, the coordinator, and a network that does what it likes: what the searches explore.

The rosters, the ledgers and all that is in them are the real ones. The model adds what is physical (where
each disk is, or that it is not there), and keeps whatever was once said: it can be heard at any later moment,
any number of times, in any order, or never. A roster can reach every incarnation that it names, sooner or
later. Robots propose any line of a given choice, not only the one that they would place. A fenced incarnation
talks on.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from agents.peers.state import addressed_to
from protocol.messages import Roster, State
from tests.agents.lines.models.coordinator import Coordinator
from tests.agents.lines.models.product import Product
from tests.agents.lines.models.seat import Seat

TOLERANCE = 1e-6  # m; what the real margins for rounding may add up to


class Setting(NamedTuple):
    """What a track begins with."""

    starts: dict[int, float]  # m, by robot
    radius: float = 0.25  # m, of all
    length: float = 3.0  # m; places are 0 to that
    founding: frozenset[int] | None = None  # who is there before the first tick; None: all
    bound: float = 0.0  # m, of the error of every estimate
    saved: bool = True  # whether the coordinator writes down what it decided before it tells anybody


Who = tuple[int, int]  # a robot and one of its incarnations


class Track:
    """One state of the model. What an event needs to be possible is checked where it happens: each returns
    whether anything did."""

    def __init__(self, product: Product, setting: Setting) -> None:
        self.product, self.setting = product, setting
        self.radii = dict.fromkeys(setting.starts, setting.radius)
        self.truth: dict[int, float | None] = dict(setting.starts)  # None: the disk is not there
        self.error = dict.fromkeys(setting.starts, 0.0)
        self.seats: dict[Who, Seat] = {}  # of whoever may still talk
        self.newest: dict[int, int] = {}  # incarnation of each robot
        self.sent: tuple[State, ...] = ()
        self._said: frozenset[int] = frozenset()  # their numbers
        self._keys: dict[Any, int] = {}  # small numbers for what is compared often
        self.coordinator = Coordinator(product, setting.saved)
        there = setting.founding if setting.founding is not None else frozenset(setting.starts)
        places = {robot: (place, 0.0) for robot, place in setting.starts.items()}
        self._decide(lambda roster: roster.found(dict.fromkeys(there, 1), places, self.radii))
        for robot in sorted(there):
            self._seat(robot, 1)

    # -- what a walk needs

    def _number(self, thing: Any) -> int:
        return self._keys.setdefault(thing, len(self._keys) + 1)

    def _decide(self, act: Callable[[Any], object]) -> bool:
        """The coordinator changes the roster and announces it; False if it refuses, or nothing changes."""
        return self.coordinator.decide(act)

    def seat(self, robot: int) -> Seat | None:
        """The newest incarnation of a robot, if there was any."""
        return self.seats.get((robot, self.newest.get(robot, 0)))

    def reach(self, robot: int) -> tuple[float, float]:
        """From where to where a disk's centre may get without another message."""
        place, seat = self.truth[robot], self.seat(robot)
        assert place is not None
        if seat is None or not self.moves(robot):
            return place, place
        margin = self.setting.bound + 2.0 * self.product.ROUNDING
        low, high = -10.0, self.setting.length + 10.0
        for side in seat.ledger.half_planes():
            if side.nx > 0.0:
                high = min(high, side.limit + margin)
            else:
                low = max(low, -side.limit - margin)
        return low, high

    def moves(self, robot: int) -> bool:
        """Whether commands of the robot's newest incarnation would be executed, and it gives any."""
        seat = self.seat(robot)
        return seat is not None and self._lives(seat) and seat.ledger is not None and seat.ledger.ready

    def violation(self) -> str:
        """Which part of the invariant does not hold; "" if all does. Two that may reach a common place by
        themselves will touch some day, and so will one that is not on its own side of what it obeys."""
        there = sorted((place, robot) for robot, place in self.truth.items() if place is not None)
        spans = {robot: self.reach(robot) for _, robot in there}
        for place, robot in there:
            low, high = spans[robot]
            if not low - TOLERANCE <= place <= high + TOLERANCE:
                return f"robot {robot} at {place:g} has to be within {low:g} and {high:g}"
        for number, (_, left) in enumerate(there):
            for _, right in there[number + 1 :]:
                gap = spans[right][0] - spans[left][1] - self.radii[left] - self.radii[right]
                if gap < -TOLERANCE:
                    return (
                        f"robot {left} within {spans[left]} and robot {right} within {spans[right]} may touch"
                    )
        return ""

    # -- what robots do

    def locate(self, robot: int, error: float) -> bool:
        """The newest incarnation's estimate is off by `error`, m."""
        self.error[robot] = error
        seat, place = self.seat(robot), self.truth[robot]
        if seat is not None and seat.ledger is not None and place is not None:
            estimate = (place + error, 0.0)
            bound = self.setting.bound
            seat.ledger.locate(0, estimate, bound)
        return True

    def move(self, robot: int, place: float) -> bool:
        """The newest incarnation drives to a place; everything between is passed."""
        if self.truth[robot] is None or not self.moves(robot):
            return False
        low, high = self.reach(robot)
        if place == self.truth[robot] or not low - TOLERANCE <= place <= high + TOLERANCE:
            return False
        self.truth[robot] = place
        return self.locate(robot, self.error[robot])

    def entries(self, who: Who, choose: Callable[[int], Any] = lambda _: None) -> bool:
        """An incarnation publishes a State; `choose` gives the line that is placed between it and each
        peer."""
        if self.seats[who].ledger is None:
            return False
        state = self.seats[who].speak(self.product, self.setting, choose)
        number = self._number(state)
        if number in self._said:
            return False
        self.sent, self._said = (*self.sent, state), self._said | {number}
        return True

    def hear(self, who: Who, state: State) -> bool:
        """An incarnation hears what was once said."""
        if self.seats[who].ledger is None or state.robot == who[0]:
            return False
        radius = self.setting.radius
        self.seats[who].ledger.on_state(addressed_to(who[0], state, radius))
        return True

    def be_told(self, who: Who, roster: Roster) -> bool:
        """An incarnation hears a version of the roster that was told while it was the newest
        (`Robot._follow`)."""
        if all((each.robot, each.incarnation) != who for each in roster.members):
            return False
        robot, incarnation = who
        place, estimate = self.truth[robot], None
        if self.newest[robot] == incarnation and place is not None:
            estimate = (place + self.error[robot], 0.0)
        self.seats[who].follow(roster, self.product, self.setting, estimate)
        return True

    def acknowledge(self, robot: int) -> bool:
        """A Command of the newest incarnation is taken (`Robot.command`)."""
        seat = self.seat(robot)
        if seat is None or seat.ledger is None or not self._lives(seat) or not seat.ledger.keeps_clear:
            return False
        self.coordinator.roster.acknowledge(robot, seat.incarnation, seat.known.version)
        return True

    # -- what the coordinator and the operator do

    def join(self, robot: int, again: bool = False) -> bool:
        """A process begins a new incarnation of the robot, or `again` claims the number of the present
        one."""
        newest = max((each.incarnation for each in self.members() if each.robot == robot), default=0)
        incarnation = newest if again else newest + 1
        if not self._decide(lambda roster: roster.admit(robot, incarnation)):
            return False
        self._seat(robot, incarnation)
        return True

    def fence(self, robot: int) -> bool:
        """The newest incarnation was silent for too long."""
        place = self.truth[robot]
        return place is not None and self._decide(lambda roster: roster.fence(robot, (place, 0.0)))

    def remove(self, robot: int) -> bool:
        """The operator takes a disk away if it stands; that it may not strike off one that does not, the
        roster has to know."""
        stands = any(each.robot == robot for each in self.coordinator.roster.standing)
        if not self._decide(lambda roster: roster.remove(robot)):
            return False
        if stands:
            self.truth[robot] = None
        return True

    def announce(self, robot: int, place: float) -> bool:
        """A disk is to appear."""
        if self.truth[robot] is not None:
            return False
        return self._decide(lambda roster: roster.announce(robot, self.setting.radius, (place, 0.0)))

    def restart(self) -> bool:
        """The coordinator dies, and goes on from what it has written down."""
        self.coordinator.restart()
        return True

    def withdraw(self, robot: int) -> bool:
        """It is not to appear after all."""
        return self._decide(lambda roster: roster.withdraw(robot))

    def settle(self) -> bool:
        """What was announced is put in its place as soon as the roster allows."""
        settled: list[int] = []
        if not self._decide(lambda roster: settled.extend(roster.settle())):
            return False
        for each in self.members():
            if each.robot in settled and each.position is not None:
                self.truth[each.robot], self.error[each.robot] = each.position[0], 0.0
        return True

    def members(self) -> Collection[Any]:
        """Of the coordinator's present roster."""
        return self.coordinator.roster._members.values()

    def _lives(self, seat: Seat) -> bool:
        """Whether the coordinator has commands of this incarnation executed."""
        return any(
            (each.robot, each.incarnation, each.status) == (seat.robot, seat.incarnation, "live")
            for each in self.members()
        )

    def _seat(self, robot: int, incarnation: int) -> None:
        self.error[robot], self.newest[robot] = 0.0, incarnation
        self.seats[robot, incarnation] = Seat(
            robot, incarnation, self.product.KnownRoster(robot, incarnation)
        )
