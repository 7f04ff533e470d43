"""Random walks of the kernel with the product's geometry: in any order of messages no disks overlap.

Robots 1 to 3 and a part 4 are disks on a track, the x-axis. Every Tick, proposal, answer and acknowledgement
may arrive at any time, again or never; processes of earlier lives go on sending.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field
from itertools import combinations
from random import Random
from typing import Any

from agents.lines.own_set import Cover, CoverGeometry, OwnSet
from protocol.geometry import Disk
from protocol.kernel.ledger import Ledger
from protocol.kernel.pair import Follower, Owner
from protocol.kernel.records import NO, PRESENT, RefusedError, require
from protocol.kernel.robot import OwnEnd, RobotLife
from protocol.line import Line
from protocol.region import EVERYWHERE, Region, RegionGeometry, distance
from tests.proof.link import Facts
from tests.proof.model import bindings_of

Robot = RobotLife[Region, Line, Cover]


def span(left: float, right: float) -> Disk:
    """The disk with these ends on the track."""
    return Disk(0.5 * (left + right), 0.0, 0.5 * (right - left))


def widened(disk: Disk, left: float, right: float) -> Disk:
    """A disk extended to the left and right."""
    return span(disk.x - disk.radius - left, disk.x + disk.radius + right)


def hull(one: Disk, other: Disk) -> Disk:
    """The smallest disk around two."""
    ends = [edge for each in (one, other) for edge in (each.x - each.radius, each.x + each.radius)]
    return span(min(ends), max(ends))


def region(disk: Disk, left: float = 0.0, right: float = 0.0) -> Region:
    """A region around a disk extended to the left and right, with a margin."""
    return Region(widened(disk, left + ROOM, right + ROOM))


def cover(disk: Disk) -> Cover:
    """A disk as a robot's body."""
    return Cover(OwnSet(disk.x, disk.y, 0.0), disk.radius)


def covered(body: Cover) -> Disk:
    return Disk(body.own.x, body.own.y, body.radius)


LENGTH, PART = 24, 4
NOWHERE = Disk(0.0, 0.0, 0.0)
ROOM = 2.0**-6  # m, between a body and its region, and a region and a line; sums with integers are exact
WEIGHTS = {
    "fence": 0.1, "settle": 1.0, "part": 0.1, "remove": 0.1, "restart": 0.3, "rejoin": 1.0, "grant": 2.0,
    "introduce": 2.0, "ask": 3.0, "announce": 0.5, "appear": 1.0, "message": 4.0, "receive": 6.0,
    "command": 12.0, "reach": 6.0, "take_up": 4.0, "adopt_region": 6.0, "acknowledge": 3.0, "freeze": 8.0,
    "answer": 6.0, "turn": 3.0, "propose": 4.0, "adopt": 6.0, "read_answer": 4.0,
}  # fmt: skip
_FACTORS = (0.2, 0.5, 1.0, 1.0, 2.0, 4.0)  # factors of these: no two walks have the same character


@dataclass
class Walk:
    """One walk. Each rule is a method `do_RULE`, which raises RefusedError if it is not possible."""

    random: Random
    executed: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        starts = zip((1, 2, 3, PART), self.random.sample(range(0, LENGTH, 4), 4), strict=True)
        self.truth = {name: Disk(at, 0.0, 1.0 - 2.0 * ROOM) for name, at in starts}
        self.ledger = self.begun(1)
        self.robots: dict[tuple[int, int], Robot] = {}  # by disk and life
        self.sent: dict[str, list[Any]] = defaultdict(list)  # by kind; each begins with its disk or binding
        self.carrier = NO
        self.weights = [weight * self.random.choice(_FACTORS) for weight in WEIGHTS.values()]

    def begun(self, version: int) -> Ledger[Region, Line]:
        """A new ledger of the present disks."""
        places = {name: region(disk) for name, disk in self.truth.items()}
        return Ledger(version, places, RegionGeometry())

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

    def end(self, kind: type = object) -> tuple[Robot, Any]:
        """An end of a binding, with lines of this kind."""
        robot = self.robot()
        ends = [each for each in robot.ends.values() if isinstance(each.lines, kind)]
        require(bool(ends), "no disk is bound")
        return robot, self.random.choice(ends)

    def received(self, kind: str, of: int) -> Any:
        """Any message of this kind for one disk or binding, often the newest."""
        sent = [each for concerns, *each in self.sent[kind] if concerns == of]
        require(bool(sent), "no message was sent")
        return sent[-1] if self.random.random() < 0.7 else self.random.choice(sent)

    def line(self, robot: Robot, end: OwnEnd[Region, Line]) -> Line:
        sign = self.random.choice((-1, 1))
        offset = float(self.random.randint(-2, LENGTH + 2))
        if self.random.random() < 0.7:  # one close to the body
            side = 1 if end.low else -1
            offset = side * (covered(robot.body_towards(end)).support(side * sign, 0.0) + ROOM)
        return Line(sign, 0.0, offset)

    # -- the coordinator

    def do_rejoin(self) -> None:
        disk = self.disk()
        require(disk.name != PART, "a part has no life")
        self.ledger.rejoin(disk)
        body = cover(self.truth[disk.name])
        self.robots[disk.name, disk.life] = RobotLife(disk.name, disk.life, body, CoverGeometry())

    def do_fence(self) -> None:
        disk = self.disk()
        known = self.random.choices((0, 0, 1, 3), k=2)  # its place need not be known exactly
        self.ledger.fence(disk, region(self.truth.get(disk.name, NOWHERE), *known))
        if self.carrier == disk.name and self.ledger.disks[PART].phase == PRESENT:
            self.carrier = NO

    def do_settle(self) -> None:
        disk = self.disk()
        require(disk.name in self.truth, "it is not there")
        self.ledger.settle(disk, region(self.truth[disk.name]))

    def do_grant(self) -> None:
        disk = self.disk()
        around = region(self.truth.get(disk.name, NOWHERE), *self.random.choices(range(6), k=2))
        self.ledger.grant(disk, self.random.choice((EVERYWHERE, around)))

    def do_acknowledge(self) -> None:
        disk = self.disk()
        self.ledger.acknowledge(disk, *self.received("region", disk.name))

    def do_introduce(self) -> None:
        one, other = sorted((self.disk(), self.disk()), key=lambda disk: disk.name)
        sign = 1 if one.held.regions[0][1].shape.x < other.held.regions[0][1].shape.x else -1
        edge = one.held.regions[-1][1].shape.support(sign, 0.0)
        self.ledger.introduce(one, other, Line(sign, 0.0, edge + ROOM + self.random.randint(0, 2)))

    def do_ask(self) -> None:
        one, other = self.disk(), self.disk()
        require(one is not other, "twice the same")
        self.ledger.ask(one, other)

    def do_answer(self) -> None:
        pairs = self.ledger.pairs[self.disk().name].values()
        bindings = [each for pair in pairs for each in (pair.living, pair.static) if each is not None]
        require(bool(bindings), "no disk is bound")
        binding = self.random.choice(bindings)
        self.ledger.answer(binding, *self.received("first line", binding.number))

    def do_part(self) -> None:
        one, other = self.disk(), self.disk()
        require(one is not other and other.name in self.ledger.pairs[one.name], "not bound")
        self.ledger.part(one, other)

    def do_announce(self) -> None:
        place = Disk(self.random.randint(0, LENGTH), 0.0, 1.0 - 2.0 * ROOM)
        if self.carrier:
            disk = self.ledger.disks[self.carrier]
            require(disk.life != NO, "no robot puts it down")
            body = self.truth[self.carrier]
            end = body.x + body.radius
            place = span(end - 1.0 + 2.0 * ROOM, end)
        self.ledger.announce(PART, region(place))

    def do_appear(self) -> None:
        disk = self.ledger.disks[PART]
        (place,) = [each.shape.around for _, each in disk.held.regions]
        lives = [each for each in self.robots.values() if self.is_current(each) and each.part == PART]
        carriers = [each for each in lives if each.name == self.carrier]
        require(bool(carriers) or not self.carrier, "its carrier does not put it down")
        self.ledger.appear(disk)
        self.truth |= {each.name: covered(each.own) for each in carriers}
        self.truth[PART], self.carrier = widened(place, -ROOM, -ROOM), NO

    def do_remove(self) -> None:
        disk = self.disk()
        require(disk.name == PART, "robots stay")
        self.ledger.remove(disk)
        self.truth.pop(PART, None)

    def do_take_up(self) -> None:
        robot, part = self.robot(), self.ledger.disks[PART]
        require(robot.part == PART and self.is_current(robot), "no robot reaches for it")
        require(part.phase == PRESENT and not self.carrier, "it is not there")
        body = covered(robot.body)
        require(hull(body, self.truth[PART]) == body, "it is not in reach")
        self.ledger.remove(part)
        del self.truth[PART]
        self.carrier, self.truth[robot.name] = robot.name, body

    def do_restart(self) -> None:
        require(self.random.random() <= 0.05, "seldom")
        self.ledger = self.begun(self.ledger.version + self.random.randint(1, 100))
        if PART not in self.ledger.disks:
            self.ledger.remove(self.ledger.announce(PART, Region(NOWHERE)))

    # -- robots

    def do_message(self) -> None:
        disk = self.disk()
        require(disk.life != NO, "no life is listening")
        self.sent["Tick"].append((disk.name, self.ledger.grants_of(disk)))

    def do_receive(self) -> None:
        robot = self.robot()
        robot.receive(*self.received("Tick", robot.name))

    def do_freeze(self) -> None:
        robot, end = self.end()
        line = self.random.choice([*robot.kept(end), self.line(robot, end)])
        robot.freeze(end, line)
        self.sent["first line"].append((end.number, line))

    def do_turn(self) -> None:
        robot, end = self.end()
        robot.turn(end, self.line(robot, end))

    def do_adopt_region(self) -> None:
        robot = self.robot()
        robot.adopt()
        self.sent["region"].append((robot.name, robot.number))

    def do_command(self) -> None:
        robot = self.robot()
        body, step = self.truth[robot.name], self.random.randint(-3, 3)
        swept = widened(body, max(0, -step), max(0, step))
        carries = self.carrier == robot.name and PART not in self.truth
        part = self.random.choice((NO, PART)) if carries else NO
        robot.command(cover(swept), cover(widened(swept, 0.0, -1.0) if part else swept), part)
        if self.ledger.disks[robot.name].phase == PRESENT and self.is_current(robot):
            body = self.truth[robot.name] = Disk(body.x + step, 0.0, body.radius)  # its base executes it
        robot.locate(cover(body), cover(widened(body, 0.0, -1.0) if part else body))

    def do_reach(self) -> None:
        robot, part = self.robot(), self.truth.get(PART, NOWHERE)
        require(PART in self.truth and self.carrier != robot.name, "there is none")
        body = self.truth[robot.name]
        require(distance(body, part) <= 4.0, "too far")
        robot.command(cover(hull(body, part)), cover(body), PART)

    def do_propose(self) -> None:
        robot, end = self.end(Owner)
        line = self.line(robot, end)
        end.lines.propose(line, robot.fits(end, line))
        self.sent["proposal"].append((end.number, end.lines.number, line))

    def do_adopt(self) -> None:
        robot, end = self.end(Follower)
        number, line = self.received("proposal", end.number)
        end.lines.on_proposal(number, line, robot.fits(end, line))
        self.sent["answer"].append((end.number, end.lines.held_number, end.lines.seen))

    def do_read_answer(self) -> None:
        _, end = self.end(Owner)
        end.lines.on_answer(*self.received("answer", end.number))

    # -- the walk

    def step(self) -> str:
        """Execute one rule; returns the violation, or ""."""
        (rule,) = self.random.choices(list(WEIGHTS), self.weights)
        try:
            getattr(self, f"do_{rule}")()
        except RefusedError:
            return ""
        self.executed[rule] += 1
        return self.violation()

    def violation(self) -> str:
        """An overlap, or violated conjuncts; "" if there are none."""
        for one, other in combinations(sorted(self.truth), 2):
            if distance(self.truth[one], self.truth[other]) < 0.0:
                return f"{one} and {other} overlap at {self.truth[one]} and {self.truth[other]}"
        one, other = sorted(self.random.sample(sorted(self.ledger.disks), 2))
        return ", ".join(self.broken(one, other))

    def broken(self, low: int, high: int) -> list[str]:
        """Conjuncts of the invariant that two disks violate."""
        facts = Facts(self.ledger, self.robots, low, high)
        s = facts.s
        for x, name in (("A", low), ("B", high)):
            place = self.truth.get(name, self.ledger.disks[name].held.regions[0][1].shape)
            for body in (f"{x}.body", f"{x}.own"):
                s[body] = place if s[body] is None else covered(s[body])
            sent = [number for one, number in self.sent["region"] if one == name]
            s[f"{x}.said"] = self.random.choice(sent or [0])
        for b, binding in bindings_of(self.ledger, low, high).items():
            s[f"{b}.frozen"] = any(number == binding.number for number, _ in self.sent["first line"])
            answers = [each for number, *each in self.sent["answer"] if number == binding.number]
            for h, seen in (("h", "s"), ("h2", "s2")):
                s[f"{b}.{h}"], s[f"{b}.{seen}"] = self.random.choice(answers or [(0, 0)])
        return facts.broken()


def walk(seed: int, steps: int) -> tuple[str, Counter[str]]:
    """The violation of a walk, or ""; and how often each rule was executed."""
    made = Walk(Random(seed))
    for number in range(steps):
        if broken := made.step():
            return f"seed {seed}, step {number}: {broken}", made.executed
    return "", made.executed
