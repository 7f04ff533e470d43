"""The commands of one tick: the robots that owe one, those taken, why others are refused, and which robots to
give up when a lock-step tick does not end, so that one faulty process costs one robot.

When the tick is told again, a robot that cannot command names the States that it lacks. Given up are:

1. a robot that owes a command and is silent: it hangs, though its session lives;
2. one whose State more than half of its receivers lack: it sends none, or one that all refuse;
3. if there is neither, one that cannot command: it does not receive what the others receive.

Half of all receivers, not of those that wait: one deaf robot must not have all others given up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping

from protocol.messages import Command
from world.coordinator.lives import Lives


class Commands:
    """A command counts for the open tick only, from an active life, once.

    One that comes too late is still a sign of life where a robot obeys its own commands.

    Args:
        lives: of the robots that command.
        external: whether robots obey their own commands.

    Attributes:
        taken: in this tick, by robot.
        waiting: robots that still owe one.
        lacking: ids of missing States, by the robot that lacks them.
        missed: commands that never came, over all active robots and ticks.
        refused: commands that were not taken, by reason: late, early, incarnation (of another
            life), fenced, inactive, duplicate, unknown, ledger (it obeys what was never
            granted).
    """

    def __init__(self, lives: Lives, external: bool = False) -> None:
        self.taken: dict[int, Command] = {}
        self.lacking: dict[int, tuple[int, ...]] = {}
        self.waiting: set[int] = set()
        self.missed = 0
        self.refused: Counter[str] = Counter()
        self._lives, self._external = lives, external
        self._tick = 0
        self._open = False

    def open(self, tick: int, active: Iterable[int]) -> None:
        """Begin a tick in which `active` robots owe a command."""
        self._tick, self._open = tick, True
        self.taken, self.lacking, self.waiting = {}, {}, set(active)

    def close(self) -> None:
        """End the tick: what is outstanding was missed."""
        self._tick, self._open = self._tick + 1, False
        self.missed += len(self.waiting)
        self.waiting = set()

    def drop(self, robot: int) -> None:
        """A robot leaves the open tick; its Command is discarded."""
        if self._open:
            self.missed += 1
            self.waiting.discard(robot)
            self.taken.pop(robot, None)

    def accept(self, command: Command) -> bool:
        """Take a command, or count why not; a robot that cannot command yet says which States it lacks."""
        reason = self._refusal(command)
        if reason:
            self.refused[reason] += 1
            return reason == "late" and self._external and self._heard_late(command)
        if command.awaits:
            self.lacking[command.robot] = command.awaits
            return False
        self.waiting.discard(command.robot)
        self.taken[command.robot] = command
        self._lives.of[command.robot].heard = self._tick
        self._lives.acknowledge(command)
        return True

    def _heard_late(self, command: Command) -> bool:
        life = self._lives.of[command.robot]
        news = command.tick > life.heard
        if news:
            life.heard = command.tick
            self._lives.acknowledge(command)
        return news

    def _refusal(self, command: Command) -> str:
        life = self._lives.of.get(command.robot)
        if life is None:
            return "unknown"
        if command.incarnation != life.incarnation:
            return "incarnation"
        if life.fenced:
            return "fenced"
        if command.tick != self._tick or not self._open:
            return "late" if command.tick < self._tick else "early"
        if command.robot not in self.waiting:
            return "duplicate" if command.robot in self.taken else "inactive"
        return "ledger" if self._lives.keeper.refuses(command) else ""


SILENT = "hangs: it does not answer"


def blamed(
    heard_by: Mapping[int, int], waiting: Collection[int], lacking: Mapping[int, Collection[int]]
) -> dict[int, str]:
    """Robots to give up, with reasons, in a tick that was told again; at least one, if any is waited for.

    Args:
        heard_by: number of receivers of each active robot's State, itself included.
        waiting: those of them that owe a command.
        lacking: ids of the States that each of these lacks, by its reports since the tick was told again.
    """
    silent = {robot: SILENT for robot in sorted(waiting) if not lacking.get(robot)}
    lack = Counter(peer for robot in waiting for peer in set(lacking.get(robot, ())) if peer in heard_by)
    unheard = {
        robot: f"sends no State that its peers take: {count} of {heard_by[robot] - 1} lack it"
        for robot, count in sorted(lack.items())
        if 2 * count > heard_by[robot] - 1
    }
    return (unheard | silent) or {
        robot: f"does not hear its peers: it lacks the State of {_names(lacking[robot])}"
        for robot in sorted(waiting)
    }


def _names(robots: Collection[int]) -> str:
    shown = sorted(robots)[:3]
    more = len(robots) - len(shown)
    return f"robot {', '.join(map(str, shown))}" + (f" and {more} more" if more else "")
