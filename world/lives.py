"""Lives: which process stands for each robot id, what the scenario does to it, who is fenced.

A robot id may live several times. A life begins by joining and is numbered by its incarnation;
it may be interrupted by the scenario (pause), be given up on, and ends when it is fenced, killed
or followed by the next.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto

from protocol.errors import JoinError
from protocol.messages import Down, Vector
from protocol.scenario import ProcessFault, Scenario


class Status(Enum):
    """What the world takes the process of a robot to be."""

    UP = auto()  # takes part
    PAUSED = auto()  # stopped by the scenario: hears nothing
    GONE = auto()  # not there, or ended by the scenario
    LOST = auto()  # given up on or fenced; may still listen


@dataclass(slots=True)
class Life:
    """The newest life of one robot id."""

    incarnation: int
    status: Status = Status.GONE
    joined: bool = False  # some process has joined under this id in this run
    awaited: bool = True  # the scenario says that it must be up
    heard: int = -1  # tick of its newest command; the tick before it joined until there is one
    down: Down | None = None  # set once it is fenced


class Lives:
    """The lives of all robots of a scenario."""

    def __init__(self, scenario: Scenario, incarnations: Mapping[int, int]) -> None:
        self.applied: list[tuple[int, ProcessFault]] = []  # tick and fault, as they happened
        self.fenced: list[tuple[int, Down]] = []  # tick and who was announced, as it happened
        self.of = {robot: Life(incarnations.get(robot, 0)) for robot in scenario.ids}
        self._name = scenario.name
        self._silence = max(1, scenario.ticks(scenario.time.fence))
        schedule = [(scenario.ticks(fault.at), fault) for fault in scenario.process]
        self._schedule = sorted(schedule, key=lambda entry: entry[0])  # stable: as written within a tick

    @property
    def incarnations(self) -> dict[int, int]:
        """Newest incarnation of every robot."""
        return {robot: life.incarnation for robot, life in self.of.items()}

    @property
    def up(self) -> tuple[int, ...]:
        """Ids that take part."""
        return tuple(robot for robot, life in self.of.items() if life.status is Status.UP)

    @property
    def ended(self) -> frozenset[int]:
        """Ids whose process is not there, as the scenario has it."""
        return frozenset(robot for robot, life in self.of.items() if life.status is Status.GONE)

    @property
    def down(self) -> tuple[Down, ...]:
        """Fenced lives that no newer one has followed."""
        return tuple(life.down for life in self.of.values() if life.down is not None)

    @property
    def awaited(self) -> frozenset[int]:
        """Ids that must join before the run goes on."""
        return frozenset(robot for robot, life in self.of.items() if life.awaited)

    def join(self, robot: int, heard: int) -> int:
        """Begin a new life; `heard` is the last tick in which it has no part. Returns its incarnation.

        Raises:
            JoinError: unknown id, or an id that runs or is held down by the scenario.
        """
        life = self.of.get(robot)
        if life is None:
            known = ", ".join(map(str, self.of))
            raise JoinError(f"no robot {robot} in scenario {self._name!r}; there are {known}")
        if life.status is Status.UP:
            raise JoinError(f"robot {robot} is already running; stop it or use another id")
        if life.status is Status.PAUSED and life.joined and life.down is None:
            raise JoinError(f"robot {robot} is paused by the scenario; wait for it to be resumed")
        if life.status is Status.GONE and not life.joined and not life.awaited:
            raise JoinError(f"robot {robot} is kept down by the scenario from its start")
        life.incarnation += 1
        life.joined, life.awaited, life.heard, life.down = True, False, heard, None
        if life.status is not Status.PAUSED:
            life.status = Status.UP
        return life.incarnation

    def lose(self, robot: int) -> None:
        """The process of a life that was up is gone or given up on."""
        life = self.of[robot]
        if life.status is Status.UP:
            life.status = Status.LOST

    def expect(self, robot: int) -> None:
        """A life that was lost will be followed by another: it must be there before the run goes on."""
        life = self.of[robot]
        if life.status is Status.LOST:
            life.awaited = True

    def give_up(self, robot: int) -> None:
        """Go on without a robot that has not joined in time; it may still come later."""
        life = self.of[robot]
        if life.awaited:
            life.awaited, life.status = False, Status.LOST

    def apply_faults(self, tick: int) -> None:
        """Let everything happen that the scenario has in store up to and including `tick`."""
        while self._schedule and self._schedule[0][0] <= tick:
            _, fault = self._schedule.pop(0)
            self.applied.append((tick, fault))
            _EVENTS[fault.event](self.of[fault.robot])

    def fence(self, tick: int, robot: int, position: Vector) -> None:
        """Announce a life as down if it has been silent for long enough at the end of `tick`."""
        life = self.of[robot]
        if life.down is None and tick - life.heard >= self._silence:
            life.down = Down(robot, life.incarnation, position)
            self.fenced.append((tick + 1, life.down))
            if life.status is Status.UP:
                life.status = Status.LOST

    def listeners(self) -> list[tuple[int, Life]]:
        """Lives whose process may listen: whoever takes part, and whoever should learn of not doing so."""
        may = (Status.UP, Status.LOST)
        return [(robot, life) for robot, life in self.of.items() if life.status in may and life.joined]

    def gone_for_good(self, tick: int) -> bool:
        """Whether nobody who is not up can be expected again.

        A fenced life whose process still runs learns of it and joins again: it is given as long
        again as the silence that fenced it.
        """
        returning = {fault.robot for _, fault in self._schedule if fault.event in ("resume", "restart")}
        return all(
            life.down is not None and tick - life.heard >= 2 * self._silence and robot not in returning
            for robot, life in self.of.items()
            if life.status is not Status.UP
        )


def _kill(life: Life) -> None:
    life.status, life.awaited = Status.GONE, False


def _pause(life: Life) -> None:
    if life.awaited or life.status in (Status.UP, Status.LOST):
        life.status, life.awaited = Status.PAUSED, False


def _resume(life: Life) -> None:
    if life.status is Status.PAUSED:
        goes_on = life.joined and life.down is None
        life.status, life.awaited = (Status.UP, False) if goes_on else (Status.LOST, True)


def _restart(life: Life) -> None:
    life.status, life.awaited = Status.GONE, True


_EVENTS = {"kill": _kill, "pause": _pause, "resume": _resume, "restart": _restart}
