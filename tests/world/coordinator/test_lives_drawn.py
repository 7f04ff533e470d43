"""The diagrams of docs/concepts/states.md show what a life and the roster go through: no more, no less."""

from __future__ import annotations

from collections.abc import Hashable, Iterator

from protocol.scenario.model import Control, RobotSpec, Scenario
from tests.docs.drawn import drawn, made
from world.coordinator.lives import Lives
from world.coordinator.roster import Roster

HERE = (0.0, 0.0)
SPEC = RobotSpec(1, 0.03, HERE, (0.1, 0.0))
SCENARIO = Scenario((SPEC,), control=Control(k=4.0))
LONG = 1000  # ticks: whoever says nothing for so long is fenced
AWAITED = {"GONE": "Awaited", "LOST": "Missed"}


class OneLife:
    """The lives of the only robot of a scenario."""

    def __init__(self) -> None:
        self._lives, self._tick = Lives(SCENARIO, {}), 0

    @property
    def state(self) -> str:
        if self._disk in ("gone", "appearing"):
            return "[*]"
        life = self._lives.of[1]
        return AWAITED[life.status.name] if life.awaited else life.status.name

    @property
    def key(self) -> Hashable:
        life = self._lives.of[1]
        return life.status, life.awaited, life.joined, life.fenced, self._disk

    @property
    def _disk(self) -> str:
        return self._lives.status_of(1)

    def events(self) -> list[str]:
        life, names = self._lives.of[1], ["give_up", "lose", "expect"]
        if life.status.name not in ("UP", "PAUSED") and self.state != "[*]":
            names.append("join")
        if not self._lives.founded and not life.awaited:
            names.append("found")
        if self._disk in ("live", "standing"):
            names += ["kill", "pause", "resume", "restart", "fence", "remove"]
        return names if self._disk != "gone" else [*names, "settle_robots", "settle_robots: awaited"]

    def do(self, event: str) -> Iterator[str]:
        self._tick += LONG
        lives, name = self._lives, event.partition(":")[0]
        if name in ("kill", "pause", "resume", "restart"):
            getattr(lives.of[1], name)()
        elif name == "settle_robots":
            lives.announce_robot(SPEC)
            lives.settle_robots(self._tick, [1] if event != name else [])
        elif name == "found":
            lives.found({1: HERE}, {})
        elif name == "join":
            lives.join(1, self._tick)
        elif name == "fence":
            lives.fence(self._tick, 1, HERE, 0.0)
        elif name == "remove":
            lives.remove(self._tick, 1, HERE)
        else:
            getattr(lives, name)(1)
        yield name


def test_a_life_goes_through_what_is_drawn() -> None:
    assert made(OneLife, 8) | {("[*]", "the scenario begins", OneLife().state)} == drawn("lives")


class OneDisk:
    """What a roster says of the only robot that it names."""

    def __init__(self) -> None:
        self._roster = Roster()

    @property
    def state(self) -> str:
        return self._roster.status(1) or "[*]"

    @property
    def key(self) -> Hashable:
        return self.state

    def events(self) -> list[tuple[str, int]]:
        return {
            "[*]": [("found", 0), ("found", 1), ("announce", 0)],
            "live": [("fence", 0), ("admit", 0)],
            "standing": [("admit", 0), ("remove", 0)],
            "appearing": [("put_up", 0), ("withdraw", 0)],
            "gone": [("announce", 0)],
        }[self.state]

    def do(self, event: tuple[str, int]) -> Iterator[str]:
        roster, (name, lives) = self._roster, event
        if name == "found":
            roster.found({1: lives}, {1: HERE}, {1: 0.03})
        elif name == "announce":
            roster.announce(1, 0.03, HERE)
        elif name == "admit":
            roster.admit(1, roster.message.members[0].incarnation + 1)
        elif name == "fence":
            roster.fence(1, HERE)
        else:
            getattr(roster, name)(1)
        yield name


def test_a_disk_of_the_roster_goes_through_what_is_drawn() -> None:
    assert made(OneDisk, 6) == drawn("roster")
