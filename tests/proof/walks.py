"""Random walks of the kernel as it runs, among intervals of a line: nothing overlaps, whatever comes when.

Robots 1 to 3 and a part 4 are on a track. Every Tick, proposal, answer and acknowledgement ever said may
arrive at any time, again or never; processes whose lives are over talk on.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import combinations
from random import Random
from typing import Any, NamedTuple

from protocol.kernel.ledger import Ledger
from protocol.kernel.pair import Follower, Owner
from protocol.kernel.records import GONE, NO, PRESENT, DiskRecord, Held, RefusedError, require
from protocol.kernel.robot import Bound, RobotLife
from tests.proof.link import Facts, broken, record
from tests.proof.model import bindings_of

Span = tuple[int, int]
Robot = RobotLife[Span, "Line", Span]


class Line(NamedTuple):
    """The low end stays where `sign` times its place is at most `sign` times `at`."""

    sign: int
    at: int


class Track:
    """Geometry of intervals; the answers of both halves of the kernel."""

    def __init__(self) -> None:
        self._noted: dict[int, list[Span]] = {}

    def note(self, disk: DiskRecord[Span]) -> None:
        self._noted[disk.name] = [] if disk.phase == GONE else [region for _, region in disk.held.regions]

    def around(self, disk: DiskRecord[Span], region: Span) -> list[int]:
        mine = [*self._noted[disk.name], region]
        return [
            name for name, theirs in self._noted.items() if any(overlap(a, b) for a in mine for b in theirs)
        ]

    def apart(self, one: Held[Span], other: Held[Span]) -> bool:
        return all(self.clear(other, region) for _, region in one.regions)

    def clear(self, held: Held[Span], region: Span) -> bool:
        return all(not overlap(mine, region) for _, mine in held.regions)

    def beside(self, held: Held[Span], line: Line, low: bool) -> bool:
        return all(self.fits(region, line, low) for _, region in held.regions)

    def within(self, place: Span, held: Held[Span]) -> bool:
        return any(self.inside(place, region) for _, region in held.regions)

    def inside(self, body: Span, region: Span) -> bool:
        return region[0] <= body[0] and body[1] <= region[1]

    def fits(self, body: Span, line: Line, low: bool) -> bool:
        side = line.sign if low else -line.sign
        return all(side * x <= side * line.at for x in body)

    def behind(self, place: Span, line: Line, low: bool) -> bool:
        return self.fits(place, line, low)

    def keeps(self, body: Span, bound: Bound[Span, Line]) -> bool:
        return all(self.fits(body, line, bound.low) for line in bound.obeyed)


def overlap(one: Span, other: Span) -> bool:
    return max(one[0], other[0]) < min(one[1], other[1])


class TrackFacts(Facts):
    """What the track says of a record of two disks."""

    def inside(self, x: str, body: Span, region: int) -> bool:
        return region in self.regions[x] and Track().inside(body, self.regions[x][region])

    def fits(self, x: str, body: Span, line: Line) -> bool:
        return Track().fits(body, line, x == "A")

    def disjoint(self, a: Span, b: Span) -> bool:
        return not overlap(a, b)


LENGTH, PART = 24, 4
EVERYWHERE: Span = (-1000, 1000)
_SHARES = {
    "fence": 0.1, "settle": 1.0, "part": 0.1, "remove": 0.1, "restart": 0.3, "rejoin": 1.0, "grant": 2.0,
    "introduce": 2.0,
    "ask": 3.0, "announce": 0.5, "appear": 1.0, "tell": 4.0, "hear": 6.0, "command": 12.0, "reach": 6.0,
    "take_up": 4.0, "adopt_region": 6.0, "acknowledge": 3.0, "freeze": 8.0, "answer": 6.0, "turn": 3.0,
    "propose": 4.0, "adopt": 6.0, "read_answer": 4.0,
}  # fmt: skip
_SWARM = (0.2, 0.5, 1.0, 1.0, 2.0, 4.0)  # factors of these: no two walks have the same character


@dataclass
class Walk:
    """One walk; every rule is a method that raises if it is refused."""

    random: Random
    taken: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        starts = self.random.sample(range(0, LENGTH, 4), 4)
        self.truth: dict[int, Span] = {
            name: (at, at + 2) for name, at in zip((1, 2, 3, PART), starts, strict=True)
        }
        self.ledger: Ledger[Span, Line] = Ledger(1, dict(self.truth), Track())
        self.robots: dict[tuple[int, int], Robot] = {}  # by disk and life
        self.said: dict[str, list[Any]] = defaultdict(list)  # of each kind, with whom or what it concerns
        self.carrier = NO
        self.shares = [share * self.random.choice(_SWARM) for share in _SHARES.values()]
        self.rules: dict[str, Callable[[], None]] = {
            name.removeprefix("do_"): getattr(self, name) for name in dir(self) if name.startswith("do_")
        }

    # -- choices

    def disk(self) -> Any:
        return self.random.choice(list(self.ledger.disks.values()))

    def robot(self) -> Robot:
        require(bool(self.robots), "no disk is present")
        robots = [*self.robots.values()]
        lives = [each for each in robots if self.is_current(each)]
        return self.random.choice(lives if lives and self.random.random() < 0.8 else robots)

    def is_current(self, robot: Robot) -> bool:
        return self.ledger.disks[robot.name].life == robot.life

    def bound(self, kind: type = object) -> tuple[Robot, Any]:
        """An end of a binding, with lines of this kind."""
        robot = self.robot()
        ends = [each for each in robot.bound.values() if isinstance(each.lines, kind)]
        require(bool(ends), "no disk is bound")
        return robot, self.random.choice(ends)

    def hears(self, kind: str, of: int) -> Any:
        """What was ever said of one disk or binding, often the newest."""
        said = [each for concerns, *each in self.said[kind] if concerns == of]
        require(bool(said), "nothing was said")
        return said[-1] if self.random.random() < 0.7 else self.random.choice(said)

    def line(self, robot: Robot, bound: Bound[Span, Line]) -> Line:
        body = robot.body_towards(bound)
        at, sign = self.random.randint(-2, LENGTH + 2), self.random.choice((-1, 1))
        if self.random.random() < 0.7:  # one that the body touches
            at = body[1] if (sign > 0) == bound.low else body[0]
        return Line(sign, at)

    # -- the coordinator

    def do_rejoin(self) -> None:
        disk = self.disk()
        require(disk.name != PART, "a part has no life")
        self.ledger.rejoin(disk)
        body = self.truth[disk.name]
        self.robots[disk.name, disk.life] = RobotLife(disk.name, disk.life, body, Track())

    def do_fence(self) -> None:
        disk = self.disk()
        lo, hi = self.truth.get(disk.name, (0, 0))
        before, after = self.random.choices((0, 0, 1, 3), k=2)  # where it stands need not be known exactly
        self.ledger.fence(disk, (lo - before, hi + after))
        if self.carrier == disk.name and self.ledger.disks[PART].phase == PRESENT:
            self.carrier = NO

    def do_settle(self) -> None:
        disk = self.disk()
        require(disk.name in self.truth, "it is not there")
        self.ledger.settle(disk, self.truth[disk.name])

    def do_grant(self) -> None:
        disk = self.disk()
        lo, hi = self.truth.get(disk.name, (0, 0))
        region = self.random.choice(
            (EVERYWHERE, (lo - self.random.randint(0, 5), hi + self.random.randint(0, 5)))
        )
        self.ledger.grant(disk, region)

    def do_acknowledge(self) -> None:
        disk = self.disk()
        self.ledger.acknowledge(disk, *self.hears("region", disk.name))

    def do_introduce(self) -> None:
        one, other = sorted((self.disk(), self.disk()), key=lambda disk: disk.name)
        sign = 1 if one.held.regions[0][1] < other.held.regions[0][1] else -1
        edge = one.held.regions[-1][1][1 if sign > 0 else 0]
        self.ledger.introduce(one, other, Line(sign, edge + sign * self.random.randint(0, 2)))

    def do_ask(self) -> None:
        one, other = self.disk(), self.disk()
        require(one is not other, "twice the same")
        self.ledger.ask(one, other)

    def do_answer(self) -> None:
        pairs = self.ledger.pairs[self.disk().name].values()
        bindings = [each for pair in pairs for each in (pair.living, pair.static) if each is not None]
        require(bool(bindings), "no disk is bound")
        binding = self.random.choice(bindings)
        self.ledger.answer(binding, *self.hears("first line", binding.number))

    def do_part(self) -> None:
        one, other = self.disk(), self.disk()
        require(one is not other and other.name in self.ledger.pairs[one.name], "not bound")
        self.ledger.part(one, other)

    def do_announce(self) -> None:
        at = self.random.randint(0, LENGTH)
        place = (at, at + 2)
        if self.carrier:
            disk = self.ledger.disks[self.carrier]
            require(disk.life != NO, "no robot puts it down")
            end = self.truth[self.carrier][1]
            place = (end - 1, end)
        self.ledger.announce(PART, place)

    def do_appear(self) -> None:
        disk = self.ledger.disks[PART]
        (place,) = [region for _, region in disk.held.regions]
        carrier = (
            self.robots.get((self.carrier, self.ledger.disks[self.carrier].life)) if self.carrier else None
        )
        puts_down = carrier is not None and carrier.part == PART
        require(not self.carrier or puts_down, "its carrier does not put it down")
        self.ledger.appear(disk)
        if carrier is not None:
            self.truth[self.carrier] = carrier.own
            self.carrier = NO
        self.truth[PART] = place

    def do_remove(self) -> None:
        disk = self.disk()
        require(disk.name == PART, "robots stay")
        self.ledger.remove(disk)
        self.truth.pop(PART, None)

    def do_take_up(self) -> None:
        robot, part = self.robot(), self.ledger.disks[PART]
        require(robot.part == PART and self.is_current(robot), "no robot reaches for it")
        require(part.phase == PRESENT and not self.carrier, "it is not there")
        require(Track().inside(self.truth[PART], robot.body), "it is not in reach")
        self.ledger.remove(part)
        del self.truth[PART]
        self.carrier, self.truth[robot.name] = robot.name, robot.body

    def do_restart(self) -> None:
        require(self.random.random() <= 0.05, "seldom")
        version = self.ledger.version + self.random.randint(1, 100)
        self.ledger = Ledger(version, dict(self.truth), Track())
        if PART not in self.ledger.disks and not self.carrier:
            self.ledger.announce(PART, (0, 2))
            self.ledger.remove(self.ledger.disks[PART])
        elif PART not in self.ledger.disks:
            self.carrier = NO
            self.ledger.announce(PART, (LENGTH + 9, LENGTH + 11))

    # -- robots

    def do_tell(self) -> None:
        disk = self.disk()
        require(disk.life != NO, "no life is listening")
        self.said["Tick"].append((disk.name, self.ledger.told(disk)))

    def do_hear(self) -> None:
        robot = self.robot()
        robot.hear(*self.hears("Tick", robot.name))

    def do_freeze(self) -> None:
        robot, bound = self.bound()
        line = self.random.choice([*robot.kept(bound), self.line(robot, bound)])
        robot.freeze(bound, line)
        self.said["first line"].append((bound.number, line))

    def do_turn(self) -> None:
        robot, bound = self.bound()
        robot.turn(bound, self.line(robot, bound))

    def do_adopt_region(self) -> None:
        robot = self.robot()
        robot.adopt()
        self.said["region"].append((robot.name, robot.number))

    def do_command(self) -> None:
        robot = self.robot()
        lo, hi = self.truth[robot.name]
        step = self.random.randint(-3, 3)
        swept = (min(lo, lo + step), max(hi, hi + step))
        carries = self.carrier == robot.name and PART not in self.truth
        part = self.random.choice((NO, PART)) if carries else NO
        robot.command(swept, (swept[0], max(swept[0], swept[1] - 1)) if part else swept, part)
        self._execute(robot, (lo + step, hi + step), part)

    def do_reach(self) -> None:
        robot, part = self.robot(), self.truth.get(PART)
        if part is None or self.carrier == robot.name:
            raise RefusedError("there is none")
        lo, hi = self.truth[robot.name]
        require(min(abs(part[0] - hi), abs(lo - part[1])) <= 4, "too far")
        robot.command((min(lo, part[0]), max(hi, part[1])), (lo, hi), PART)

    def _execute(self, robot: Robot, after: Span, part: int) -> None:
        if self.ledger.disks[robot.name].phase == PRESENT and self.is_current(
            robot
        ):  # its base executes commands of this life
            self.truth[robot.name] = after
        body = self.truth[robot.name]
        robot.locate(body, (body[0], body[1] - 1) if part else body)

    def do_propose(self) -> None:
        robot, bound = self.bound(Owner)
        line = self.line(robot, bound)
        bound.lines.propose(line, robot.fits(bound, line))
        self.said["proposal"].append((bound.number, bound.lines.number, line))

    def do_adopt(self) -> None:
        robot, bound = self.bound(Follower)
        number, line = self.hears("proposal", bound.number)
        bound.lines.on_proposal(number, line, robot.fits(bound, line))
        self.said["answer"].append((bound.number, bound.lines.held_number, bound.lines.seen))

    def do_read_answer(self) -> None:
        _, bound = self.bound(Owner)
        bound.lines.on_answer(*self.hears("answer", bound.number))

    # -- the walk

    def step(self) -> str:
        """One event; what it broke, or ""."""
        (rule,) = self.random.choices(list(_SHARES), self.shares)
        try:
            self.rules[rule]()
        except RefusedError:
            return ""
        self.taken[rule] += 1
        return self.violation()

    def violation(self) -> str:
        """What is not as the kernel promises."""
        for one, other in combinations(sorted(self.truth), 2):
            if overlap(self.truth[one], self.truth[other]):
                return f"{one} and {other} overlap at {self.truth[one]} and {self.truth[other]}"
        one, other = sorted(self.random.sample(sorted(self.ledger.disks), 2))
        return ", ".join(self.broken(one, other))

    def broken(self, low: int, high: int) -> list[str]:
        """Conjuncts of the invariant that do not hold of two disks."""
        ledger = self.ledger
        s = record(ledger, self.robots, low, high)
        facts = TrackFacts(ledger, low, high, s)
        for x, name in (("A", low), ("B", high)):
            if s[f"{x}.body"] is None:
                s[f"{x}.body"] = s[f"{x}.own"] = self.truth.get(name, ledger.disks[name].held.regions[0][1])
            said = [number for one, number in self.said["region"] if one == name]
            s[f"{x}.said"] = self.random.choice(said or [0])
        for b, binding in bindings_of(ledger, low, high).items():
            s[f"{b}.frozen"] = any(number == binding.number for number, _ in self.said["first line"])
            answers = [each for number, *each in self.said["answer"] if number == binding.number]
            for h, seen in (("h", "s"), ("h2", "s2")):
                s[f"{b}.{h}"], s[f"{b}.{seen}"] = self.random.choice(answers or [(0, 0)])
        return broken(s, facts)


def walk(seed: int, steps: int) -> tuple[str, Counter[str]]:
    """What a walk breaks, "" if nothing; and how often each rule was taken."""
    made = Walk(Random(seed))
    for number in range(steps):
        if broken := made.step():
            return f"seed {seed}, step {number}: {broken}", made.taken
    return "", made.taken
