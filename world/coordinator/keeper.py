"""Applies the ledger's rules: binds robots, grants regions, and prepares the grants for each robot's Ticks.

Safety is ensured elsewhere: every change is a rule of `protocol.kernel.ledger`, which refuses it unless its
preconditions hold. This module decides when to apply which rule.

In a small fleet every region is the whole plane, and every robot is bound to all disks and obstacles. In a
large one a region is a disk around the last known position, and two robots are bound when a region to be
granted intersects the other's.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from protocol.crowd import slack_of
from protocol.geometry import Disk as Circle
from protocol.geometry import Shape, points_of
from protocol.kernel.ledger import Ledger
from protocol.kernel.records import ANNOUNCED, NO, PRESENT, Binding, DiskRecord, Held, LifeGrants
from protocol.line import ROUNDING, Line
from protocol.messages import Command, Grants, Vector
from protocol.messages import ListedBinding as Listing
from protocol.region import Region, RegionGeometry, distance, parting
from protocol.scenario.model import Scenario

_RENEWED: Final = 1.0 / 3.0  # share of the slack that a robot may use before another region is granted
_PARTED: Final = 0.5  # distance of the regions of two robots, in slacks, at which their binding ends


class Keeper:
    """The ledger of one run, from its first tick on.

    Disks have the ids of robots; obstacles have their numbers, less than 0. `version` is the newest of an
    earlier ledger of the same coordinator.
    """

    def __init__(self, scenario: Scenario, version: int = 0) -> None:
        self._slack = slack_of(scenario) if scenario.hears_near else math.inf
        self._geometry = RegionGeometry()
        self._first = version
        self._ledger: Ledger[Region, Line] = Ledger(version, {}, self._geometry)
        self._changed: dict[int, int] = {}  # version of the last change of a disk's grants
        self._bound: dict[int, set[int]] = {}  # as `bound`, until the next change
        self._known: dict[int, int] = {}  # version adopted by the present life of a robot
        self._moved: set[int] = set()  # disks whose regions have shrunk

    @property
    def version(self) -> int:
        """Newest version of the ledger."""
        return self._ledger.version

    def found(self, places: Mapping[int, Circle], obstacles: Mapping[int, Shape]) -> None:
        """Begin with everything static: robots by id, obstacles by number."""
        regions = {-number: Region(shape, True) for number, shape in obstacles.items()}
        regions |= {robot: Region(place) for robot, place in places.items()}
        self._ledger = Ledger(self._first + 1, regions, self._geometry)

    # -- lives and places

    def lives(self, robot: int) -> bool:
        """Whether a robot's disk has a life, which may move it."""
        return self._ledger.disks[robot].life != NO

    def rejoin(self, robot: int) -> None:
        """Begin a life of a static disk."""
        disk = self._ledger.disks[robot]
        self._ledger.rejoin(disk)
        self._change(robot)

    def fence(self, robot: int, place: Circle) -> None:
        """End the life of a robot: its disk is static at a place."""
        disk = self._ledger.disks[robot]
        self._ledger.fence(disk, Region(place))
        self._change(robot, *self._ledger.pairs[robot])

    def excludes(self, robot: int, place: Circle, radius: float) -> bool:
        """Whether a static disk of `radius`, m, that is in `place` cannot be in the one that it holds."""
        (held,) = _shapes(self._ledger.disks[robot].held)
        shift = math.dist((place.x, place.y), (held.around.x, held.around.y))
        return shift > held.around.radius + place.radius - 2.0 * radius + ROUNDING

    def settle(self, robot: int, place: Circle) -> None:
        """Restrict a static disk to its known place."""
        disk, region = self._ledger.disks[robot], Region(place)
        (held,) = _shapes(disk.held)
        if place.radius < held.around.radius and self._geometry.within(region, disk.held):
            self._ledger.settle(disk, region)
            self._change(robot, *self._ledger.pairs[robot])

    def announce(self, name: int, shape: Shape) -> None:
        """Announce a disk at a place."""
        self._ledger.announce(name, Region(shape, name < 0))

    def appear(self, name: int) -> bool:
        """Let an announced disk appear if every other one keeps clear of its place; returns whether."""
        disk = self._ledger.disks[name]
        clear = self._is_ready(disk, disk.held.regions[0][1])
        if clear:
            self._ledger.appear(disk)
        return clear

    def remove(self, name: int) -> None:
        """Remove a static or announced disk."""
        peers = tuple(self._ledger.pairs[name])
        self._ledger.remove(self._ledger.disks[name])
        self._change(name, *peers)

    # -- Commands

    def refuses(self, command: Command) -> bool:
        """Whether a Command refers to grants that its robot's present life cannot have received."""
        disk = self._ledger.disks.get(command.robot)
        granted = 0 if disk is None else disk.held.granted
        return command.version > self.version or command.region > min(granted, command.version)

    def acknowledge(self, command: Command) -> None:
        """Record the region and bindings that the present life of a robot obeys; its Command must have passed
        `refuses`."""
        robot = command.robot
        disk = self._ledger.disks[robot]
        self._known[robot] = command.version
        if command.region > max(disk.held.acknowledged, disk.life):
            self._ledger.acknowledge(disk, command.region)
            self._moved.add(robot)
        for first in command.firsts:
            for peer, binding in self._asked(disk):
                if binding.number == first.binding:
                    self._ledger.answer(binding, Line(first.nx, first.ny, first.offset))
                    self._change(robot, peer)

    def _asked(self, disk: DiskRecord[Region]) -> list[tuple[int, Binding[Line]]]:
        """Bindings in force, with the peer, for which a disk owes a first line."""
        return [
            (peer, binding)
            for peer, pair in self._ledger.pairs[disk.name].items()
            for binding in (pair.living, pair.static)
            if binding is not None and binding.asked == disk.name and binding.since == NO
        ]

    # -- once a tick

    def advance(self, places: Mapping[int, Vector]) -> None:
        """Grant the needed regions, given last known positions (m, by id), and bind the required pairs."""
        self._part()
        for robot, disk in self._ledger.disks.items():
            if disk.phase == ANNOUNCED:
                self._is_ready(disk, disk.held.regions[0][1])
            if disk.life == NO:
                continue
            around = disk.held.regions[0][1].shape.around
            at = (around.x, around.y) if disk.still else places.get(robot, (around.x, around.y))
            if disk.still:
                self._try(disk, Region(Circle(*at, around.radius + self._slack)))
            elif not self._is_roomy(disk, at):
                self._try(disk, Region(Circle(*at, disk.held.regions[-1][1].shape.around.radius)))

    def _is_roomy(self, disk: DiskRecord[Region], at: Vector) -> bool:
        """Whether the newest region is large enough around a place, or not yet obeyed."""
        held = disk.held
        region = held.regions[-1][1].shape.around
        if held.acknowledged < held.granted:
            return True
        return math.dist((region.x, region.y), at) <= _RENEWED * self._slack

    def _try(self, disk: DiskRecord[Region], wanted: Region) -> None:
        """Grant a region once every other disk is tied to this one, or far."""
        if self._is_ready(disk, wanted):
            peers = tuple(self._ledger.pairs[disk.name]) if disk.still else ()
            self._ledger.grant(disk, wanted)
            self._change(disk.name, *peers)

    def _is_ready(self, disk: DiskRecord[Region], wanted: Region) -> bool:
        """Whether every other disk is tied to this one, or disjoint from its new region, which contains its
        place while it is static; otherwise bind it, or request a first line.
        """
        ledger, geometry, ready = self._ledger, self._geometry, True
        for name in geometry.around(disk, wanted):
            other = ledger.disks[name]
            one, two = (other, disk) if disk.life == NO else (disk, other)
            if other is disk or other.phase != PRESENT or ledger.tied(one, two):
                continue
            if geometry.clear(other.held, wanted):
                continue
            if one.life == NO or not self._bind(one, two):
                ready = False
        return ready

    def _bind(self, disk: DiskRecord[Region], other: DiskRecord[Region]) -> bool:
        """Introduce two disks, or request a first line; returns whether they are tied."""
        ledger = self._ledger
        pair = ledger.pairs[disk.name].get(other.name)
        lives = NO not in (disk.life, other.life)
        if pair is not None and (pair.living if lives else pair.static) is not None:
            return False  # already requested
        low, high = (disk, other) if disk.name < other.name else (other, disk)
        line = parting(_shapes(low.held), _shapes(high.held))
        if line is not None:
            ledger.introduce(low, high, line)
            self._change(disk.name, other.name)
            return ledger.tied(disk, other)
        if disk.still and other.life != NO:
            self._ask(other, disk)
        elif other.still:
            self._ask(disk, other)
        return False

    def _ask(self, disk: DiskRecord[Region], other: DiskRecord[Region]) -> None:
        self._ledger.ask(disk, other)
        self._change(disk.name)

    def _part(self) -> None:
        """End bindings of disks that are far from each other."""
        ledger, moved = self._ledger, self._moved
        self._moved = set()
        for robot in sorted(moved):
            one = ledger.disks[robot]
            for peer in list(ledger.pairs[robot]):
                other = ledger.disks[peer]
                gap = min(
                    distance(ours, theirs) for ours in _shapes(one.held) for theirs in _shapes(other.held)
                )
                if gap > _PARTED * self._slack:
                    ledger.part(one, other)
                    self._change(robot, peer)

    def _change(self, *names: int) -> None:
        for name in names:
            self._changed[name] = self._ledger.version
            self._bound.pop(name, None)

    # -- grants

    def bound(self, robot: int) -> Iterable[int]:
        """Robots to which the present life of a robot is bound, by the grants in its Tick."""
        disk = self._ledger.disks[robot]
        if disk.life == NO:
            return ()
        if robot not in self._bound:
            bindings = self._ledger.grants_of(disk).bindings
            self._bound[robot] = {each.peer for each in bindings if each.peer > 0}
        return self._bound[robot]

    def news(self, robot: int) -> Grants | None:
        """Grants for the present life of a robot; None if it has the newest."""
        disk = self._ledger.disks[robot]
        if disk.life == NO or self._known.get(robot, 0) >= self._changed.get(robot, 0):
            return None
        return _message(self._ledger.grants_of(disk))


def _shapes(held: Held[Region]) -> list[Shape]:
    return [region.shape for _, region in held.regions]


def _message(grants: LifeGrants[Region, Line]) -> Grants:
    listings = []
    for each in grants.bindings:
        points, radius = ((), 0.0) if each.place is None else points_of(each.place.shape)
        first = None if each.first is None else (each.first.nx, each.first.ny, each.first.offset)
        listings.append(Listing(each.number, each.peer, first, points, radius, each.static))
    region = grants.region.shape.around
    disk = None if grants.region.is_everywhere else (region.x, region.y, region.radius)
    return Grants(grants.life, grants.version, grants.number, disk, tuple(listings))
