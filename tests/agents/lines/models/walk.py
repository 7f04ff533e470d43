"""Random walks through the track: two to four robots, and everything at once.

A run draws what it begins with and how often what happens, then some hundred events; all from its seed.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

from tests.agents.lines.models.product import Product
from tests.agents.lines.models.track import Setting, Track

EVENTS = 150
SPACING = 1.0  # m, between starts
_GRID = 0.25  # m, of places and lines
_SHARES = {
    "converse": 12.0,
    "hear": 25.0,
    "speak": 15.0,
    "tell": 8.0,
    "move": 25.0,
    "acknowledge": 4.0,
    "settle": 4.0,
    "locate": 3.0,
    "join": 2.0,
    "fence": 1.0,
    "remove": 1.0,
    "announce": 2.0,
    "withdraw": 0.1,
    "restart": 0.7,
}
_SWARM = (0.2, 0.5, 1.0, 1.0, 2.0, 4.0)  # factors of the shares: no two runs have the same character


def violation_of(seed: int, product: Product, saved: bool = True, events: int = EVENTS) -> str:
    """What goes wrong in the run with this seed; "" if nothing does.

    Args:
        saved: whether the coordinator writes down what it decided before it tells anybody.
        events: how many happen.
    """
    rng = Random(seed)
    walk = _Walk(rng, Track(product, _setting(rng, saved)))
    if rng.random() < 0.3:
        walk.track.remove(walk._such("standing"))
    kinds = list(_SHARES)
    shares = [share * rng.choice(_SWARM) for share in _SHARES.values()]
    for number, kind in enumerate(rng.choices(kinds, shares, k=events)):
        if walk.does[kind]():
            violation = walk.track.violation()
            if violation:
                return f"after event {number}, {kind}: {violation}"
    return ""


def _setting(rng: Random, saved: bool) -> Setting:
    robots = rng.choice((2, 3, 3, 4))
    starts = {robot: SPACING * place for place, robot in enumerate(rng.sample(range(1, robots + 1), robots))}
    there = frozenset(robot for robot in starts if rng.random() < 0.75)
    bound = rng.choice((0.0, 0.0, _GRID / 2))
    length = SPACING * (robots - 1) + rng.choice((0.0, 1.0))
    founding = there or frozenset(starts)
    return Setting(dict(sorted(starts.items())), length=length, founding=founding, bound=bound, saved=saved)


class _Walk:
    """One run; every event returns whether it changed anything."""

    def __init__(self, rng: Random, track: Track) -> None:
        self.rng, self.track = rng, track
        self.robots = list(track.setting.starts)
        self.does: dict[str, Callable[[], bool]] = {
            "converse": self._converse,
            "hear": self._hear,
            "speak": self._speak,
            "tell": self._tell,
            "move": self._move,
            "acknowledge": lambda: track.acknowledge(self._robot()),
            "settle": track.settle,
            "join": lambda: track.join(self._robot(), again=rng.random() < 0.1),
            "locate": self._locate,
            "fence": lambda: track.fence(self._robot()),
            "announce": lambda: track.announce(self._such("gone"), self._place()),
            "remove": lambda: track.remove(self._such("standing")),
            "withdraw": lambda: track.withdraw(self._such("appearing")),
            "restart": track.restart,
        }

    def _robot(self) -> int:
        return self.rng.choice(self.robots)

    def _such(self, status: str) -> int:
        """Mostly a robot with that status, if there is one."""
        members = self.track.coordinator.roster.message.members
        such = [each.robot for each in members if each.status == status]
        return self.rng.choice(such) if such and self.rng.random() < 0.8 else self._robot()

    def _place(self) -> float:
        return _GRID * self.rng.randint(0, round(self.track.setting.length / _GRID))

    def _someone(self) -> Any:
        """An incarnation that talks and listens, mostly one of the newest."""
        robot, newest = self._robot(), self.track.newest
        if self.rng.random() < 0.9 and robot in newest:
            return robot, newest[robot]
        return self.rng.choice(list(self.track.seats))

    def _one_of(self, things: Any) -> Any:
        """Any of those that were said, and half of the time one of the last few."""
        if self.rng.random() < 0.5:
            return things[-1 - self.rng.randrange(min(len(things), 2 * len(self.robots)))]
        return self.rng.choice(things)

    def _hear(self) -> bool:
        track = self.track
        return bool(track.sent) and track.hear(self._someone(), self._one_of(track.sent))

    def _tell(self) -> bool:
        return self.track.be_told(self._someone(), self._one_of(self.track.coordinator.announced))

    def _speak(self) -> bool:
        return self._say(self._someone())

    def _say(self, who: Any) -> bool:
        return self.track.entries(who, lambda peer: self._line(who[0], peer))

    def _line(self, robot: int, peer: int) -> Any:
        """A line that touches the own disk, or the peer's, or is somewhere between or near; or none."""
        rng, truth = self.rng, self.track.truth
        mine, theirs = truth[robot], truth[peer]
        if rng.random() < 0.3 or mine is None:
            return None
        theirs = self._place() if theirs is None or rng.random() < 0.2 else theirs
        normal = 1.0 if mine <= theirs else -1.0
        margin = self.track.setting.radius + self.track.setting.bound + 2e-9
        near, far = normal * mine + margin, normal * theirs - margin
        drawn = near + _GRID * rng.randint(-1, 4)
        return self.track.product.Line(normal, 0.0, rng.choice((near, far, 0.5 * (near + far), drawn)))

    def _converse(self) -> bool:
        """A moment in which the network carries nearly all, in any order."""
        rng, track = self.rng, self.track
        lives = rng.sample(sorted(track.newest.items()), len(track.newest))
        for who in lives:
            if rng.random() < 0.8:
                announced = track.coordinator.announced
                track.be_told(who, announced[-1] if rng.random() < 0.8 else self._one_of(announced))
            self._say(who)
        for who in lives:
            for state in track.sent[-2 * len(lives) :]:
                if rng.random() < 0.7:
                    track.hear(who, state)
            track.acknowledge(who[0])
        track.settle()
        return True

    def _move(self) -> bool:
        """To one end of the reach, or to somewhere in it."""
        robot = self._robot()
        if self.track.truth[robot] is None or not self.track.moves(robot):
            return False
        low, high = self.track.reach(robot)
        low, high = max(low, 0.0), min(high, self.track.setting.length)
        if low > high:
            return False
        return self.track.move(robot, self.rng.choice((low, high, self.rng.uniform(low, high))))

    def _locate(self) -> bool:
        bound = self.track.setting.bound
        return bound > 0.0 and self.track.locate(self._robot(), self.rng.choice((-bound, 0.0, bound)))
