"""The coordinator's part of the kernel: disks, the regions that they hold, and bindings.

Invariant: for any two present disks, all that they hold is disjoint, or a binding of the two is in force, or
both are static.
"""

from __future__ import annotations

from typing import Generic

from mypy_extensions import mypyc_attr

from protocol.kernel.records import (
    ANNOUNCED,
    GONE,
    NO,
    PRESENT,
    Binding,
    DiskRecord,
    End,
    Held,
    L,
    LedgerGeometry,
    LifeGrants,
    Listed,
    R,
    require,
)


@mypyc_attr(allow_interpreted_subclasses=True)
class Pair(Generic[L]):
    """Bindings of two disks.

    Attributes:
        living: between the present lives of both.
        static: between the present life of one and the place of the other, which is static.
    """

    def __init__(self) -> None:
        self.living: Binding[L] | None = None
        self.static: Binding[L] | None = None


@mypyc_attr(allow_interpreted_subclasses=True)
class Ledger(Generic[R, L]):
    """All disks, and their bindings.

    Args:
        version: above all versions of earlier ledgers of these robots.
        places: initial places of the disks, all static, by id.
        geometry: of regions and lines.
    """

    def __init__(self, version: int, places: dict[int, R], geometry: LedgerGeometry[R, L]) -> None:
        self.version = version
        self.disks = {name: DiskRecord(name, Held(version, place), PRESENT) for name, place in places.items()}
        self.pairs: dict[int, dict[int, Pair[L]]] = {name: {} for name in places}
        self._geometry = geometry
        for disk in self.disks.values():
            self._geometry.note(disk)

    # -- lives

    def rejoin(self, disk: DiskRecord[R]) -> None:
        """Begin a life of a static disk, after the end of the previous one."""
        require(disk.phase == PRESENT, "rejoin: the disk is present")
        require(disk.life == NO, "rejoin: the life before it is over")
        self.version += 1
        disk.life = self.version

    def fence(self, disk: DiskRecord[R], place: R) -> None:
        """End a life, once its body stands: the disk then holds that place alone."""
        moved = not disk.still
        if moved:
            require(self._geometry.within(place, disk.held), "fence: the place is in a region that it holds")
        self.version += 1
        disk.life = NO
        if moved:
            disk.still = True
            disk.held.stand(self.version, place)
            self._geometry.note(disk)
        for pair in self.pairs[disk.name].values():
            self._end(pair, disk)

    def _end(self, pair: Pair[L], disk: DiskRecord[R]) -> None:
        """Make a binding of the ended life one towards its static place."""
        living, static = pair.living, pair.static
        pair.living = None
        if static is not None:
            if static.end(disk.name).dead == NO:
                pair.static = None  # both ends are dead
            elif static.since != NO or living is None or living.since == NO:
                return  # the peer obeys a binding towards that place already, or is asked for its line
        if living is not None and (living.since != NO or living.asked != disk.name):
            living.end(disk.name).dead = self.version
            pair.static = living

    def settle(self, disk: DiskRecord[R], place: R) -> None:
        """Replace the place of a static disk by a smaller one inside it."""
        require(disk.life == NO, "settle: the disk has no life")
        require(self._geometry.within(place, disk.held), "settle: the place is in the one that it holds")
        self.version += 1
        disk.held.stand(self.version, place)
        self._geometry.note(disk)

    # -- regions

    def tied(self, disk: DiskRecord[R], other: DiskRecord[R]) -> bool:
        """Whether a binding is in force that the disk's present life obeys, or adopts before its next region,
        and that the other disk obeys, too, unless it is static.
        """
        pair = self.pairs[disk.name].get(other.name)
        if pair is None:
            return False
        living, static = pair.living, pair.static
        if living is not None and living.since != NO:
            return True
        return static is not None and static.since != NO and static.end(disk.name).dead == NO

    def grant(self, disk: DiskRecord[R], region: R) -> None:
        """Grant a further region to a life. With the first one its disk is no longer static."""
        require(disk.life != NO, "grant: the disk has a life")
        begins = disk.still
        for name in self._geometry.around(disk, region):
            other = self.disks[name]
            if other is not disk and other.phase == PRESENT and not self.tied(disk, other):
                require(self._geometry.clear(other.held, region), "grant: apart from others, or tied")
                if begins:
                    require(
                        self._geometry.apart(other.held, disk.held), "grant: leaves others apart, or tied"
                    )
        self.version += 1
        disk.held.grant(self.version, region)
        self._geometry.note(disk)
        if begins:
            disk.still = False
            for pair in self.pairs[disk.name].values():
                self._begin(pair, disk)

    def _begin(self, pair: Pair[L], disk: DiskRecord[R]) -> None:
        """End bindings of peers towards the static place of the disk."""
        living, static = pair.living, pair.static
        if static is not None and static.end(disk.name).dead != NO:
            pair.static = None
        if living is not None and living.since == NO and living.asked != disk.name:
            pair.living = None

    def acknowledge(self, disk: DiskRecord[R], number: int) -> None:
        """Record by a Command that the life obeys the region of this number; older numbers are refused."""
        require(number > disk.held.acknowledged, "acknowledge: it is news")
        require(number <= disk.held.granted, "acknowledge: it was granted")
        disk.held.acknowledge(number)
        self._geometry.note(disk)

    # -- bindings

    def introduce(self, one: DiskRecord[R], other: DiskRecord[R], line: L) -> None:
        """Bind two disks by a line: regions of `one` on its low side, of `other` on its high side."""
        require(one.name < other.name, "introduce: the low end comes first")
        require(one.phase != GONE, "introduce: the one is there")
        require(other.phase != GONE, "introduce: the other is there")
        require(self._geometry.beside(one.held, line, True), "introduce: beside the one")
        require(self._geometry.beside(other.held, line, False), "introduce: beside the other")
        self._bind(one, other, NO, line)

    def ask(self, disk: DiskRecord[R], other: DiskRecord[R]) -> None:
        """Ask a life for the first line towards a disk that is static, announced, or waits as a new life."""
        require(disk.life != NO, "ask: the disk has a life")
        require(other.phase != GONE, "ask: the other is there")
        require(other.still, "ask: the other stands")
        if disk.name < other.name:
            self._bind(disk, other, disk.name, None)
        else:
            self._bind(other, disk, disk.name, None)

    def _bind(self, low: DiskRecord[R], high: DiskRecord[R], asked: int, first: L | None) -> None:
        pair = self.pairs[low.name].get(high.name)
        lives = low.life != NO and high.life != NO  # noqa: PLR1714  # the solver reads comparisons
        require(low.life != NO or high.life != NO, "bind: one of the two has a life")
        require(
            pair is None or (pair.living if lives else pair.static) is None, "bind: the two are not bound"
        )
        if pair is None:
            pair = self.pairs[low.name][high.name] = self.pairs[high.name][low.name] = Pair()
        self.version += 1
        binding = Binding(
            self.version,
            End(low.name, low.life, NO if low.life != NO else self.version),
            End(high.name, high.life, NO if high.life != NO else self.version),
            asked,
            first,
        )
        if lives:
            pair.living = binding
        else:
            pair.static = binding

    def answer(self, binding: Binding[L], line: L) -> None:
        """Record by a Command that a life obeys the first line of a binding for which it was asked. No other
        life knows that line yet.
        """
        require(binding.since == NO, "answer: it is news")
        self.version += 1
        binding.first, binding.since = line, self.version

    def part(self, one: DiskRecord[R], other: DiskRecord[R]) -> None:
        """End the bindings of two disks, when all that they hold is disjoint."""
        require(self._geometry.apart(one.held, other.held), "part: what they hold is apart")
        self.version += 1
        self._release(one, other)

    def _release(self, one: DiskRecord[R], other: DiskRecord[R]) -> None:
        self.pairs[one.name].pop(other.name, None)
        self.pairs[other.name].pop(one.name, None)

    # -- disks

    def announce(self, name: int, place: R) -> DiskRecord[R]:
        """Announce a disk that is to appear at a place."""
        disk = self.disks.get(name)
        require(disk is None or disk.phase == GONE, "announce: the disk is not there")
        self.version += 1
        found = self.disks[name] = DiskRecord(name, Held(self.version, place), ANNOUNCED)
        self.pairs[name] = {}
        self._geometry.note(found)
        return found

    def appear(self, disk: DiskRecord[R]) -> None:
        """Make an announced disk present."""
        require(disk.phase == ANNOUNCED, "appear: the disk was announced")
        for other in self.disks.values():
            if other.phase == PRESENT and not self.tied(other, disk):
                require(self._geometry.apart(other.held, disk.held), "appear: apart from others, or tied")
        self.version += 1
        disk.phase = PRESENT

    def remove(self, disk: DiskRecord[R]) -> None:
        """Remove a static disk, an announced disk, or a part that has become part of a robot's body."""
        require(disk.phase != GONE, "remove: the disk is there")
        require(disk.life == NO, "remove: the disk has no life")
        self.version += 1
        disk.phase = GONE
        self._geometry.note(disk)
        for peer in list(self.pairs[disk.name]):
            self._release(disk, self.disks[peer])

    # -- grants

    def grants_of(self, disk: DiskRecord[R]) -> LifeGrants[R, L]:
        """All that concerns the present life of a disk, complete."""
        listed: list[Listed[R, L]] = []
        for peer, pair in self.pairs[disk.name].items():
            for binding in (pair.living, pair.static):
                if binding is None or binding.end(disk.name).life != disk.life:
                    continue
                if binding.since == NO and binding.asked != disk.name:
                    continue
                other = self.disks[peer]
                place = other.held.regions[0][1] if other.still else None
                static = binding.other(disk.name).dead != NO
                listed.append(Listed(binding.number, peer, binding.first, place, static))
        held = disk.held
        return LifeGrants(disk.life, self.version, held.granted, held.regions[-1][1], listed)
