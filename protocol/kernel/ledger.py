"""The coordinator's half of the kernel: the disks, the regions each may be in, the pairs that are bound.

Of any two disks that are present, all that they hold is apart, or a binding of the two counts, or both stand.
"""

from __future__ import annotations

from collections.abc import Iterable
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
    Listed,
    R,
    Told,
    require,
)


@mypyc_attr(allow_interpreted_subclasses=True)
class Pair(Generic[L]):
    """What binds two disks.

    Attributes:
        living: a binding of the present lives of both.
        static: one of the present life of one to the place where the other stands.
    """

    def __init__(self) -> None:
        self.living: Binding[L] | None = None
        self.static: Binding[L] | None = None


@mypyc_attr(allow_interpreted_subclasses=True)
class Ledger(Generic[R, L]):
    """All disks, and what binds them.

    Args:
        version: of an epoch that no earlier ledger of these robots has reached.
        places: where disks are as it begins, by id; no life is there yet.
        geometry: of regions and lines.
    """

    def __init__(self, version: int, places: dict[int, R], geometry: LedgerGeometry[R, L]) -> None:
        self.version = version
        self.disks = {name: DiskRecord(name, Held(version, place), PRESENT) for name, place in places.items()}
        self.pairs: dict[int, dict[int, Pair[L]]] = {name: {} for name in places}
        self._geometry = geometry
        for disk in self.disks.values():
            geometry.note(disk)

    # -- lives

    def rejoin(self, disk: DiskRecord[R]) -> None:
        """A life begins in a disk that stands, only after the one before it is over."""
        require(disk.phase == PRESENT, "rejoin: the disk is present")
        require(disk.life == NO, "rejoin: the life before it is over")
        self.version += 1
        disk.life = self.version

    def fence(self, disk: DiskRecord[R], place: R) -> None:
        """A life is over. To be called only once the body stands: from now on it holds that place alone."""
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
            self._end(pair, disk, moved)

    def _end(self, pair: Pair[L], disk: DiskRecord[R], moved: bool) -> None:
        """A life of the disk is over: its line with a peer is one towards the place where it stands."""
        living, static = pair.living, pair.static
        pair.living = None
        if static is not None:
            if static.end(disk.name).dead == NO:
                pair.static = None  # both ends are dead
            elif not moved and static.told != NO:
                return  # the peer has kept off that place since an earlier life
        if living is not None and (living.told != NO or living.asked != disk.name):
            living.end(disk.name).dead = self.version
            pair.static = living

    def settle(self, disk: DiskRecord[R], place: R) -> None:
        """It is known better where a disk without a life stands: it holds that place alone."""
        require(disk.life == NO, "settle: the disk has no life")
        require(self._geometry.within(place, disk.held), "settle: the place is in the one that it holds")
        self.version += 1
        disk.held.stand(self.version, place)
        self._geometry.note(disk)

    def obeys(self, disk: DiskRecord[R], life: int) -> bool:
        """Whether the base of a disk does what this life commands."""
        return disk.phase == PRESENT and disk.life == life

    # -- regions

    def tied(self, disk: DiskRecord[R], other: DiskRecord[R]) -> bool:
        """Whether a binding counts that the present life of a disk obeys or takes before its next region,
        and the other disk obeys it too, or stands."""
        pair = self.pairs[disk.name].get(other.name)
        if pair is None:
            return False
        living, static = pair.living, pair.static
        if living is not None and living.told != NO:
            return True
        return static is not None and static.told != NO and static.end(disk.name).dead == NO

    def grant(self, disk: DiskRecord[R], region: R) -> None:
        """A live disk may be in a region as well. With its first one a life stands no longer."""
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
        """The disk stands no longer: what a peer kept only towards its place is over."""
        living, static = pair.living, pair.static
        if static is not None and static.end(disk.name).dead != NO:
            pair.static = None
        if living is not None and living.told == NO and living.asked != disk.name:
            pair.living = None

    def acknowledge(self, disk: DiskRecord[R], number: int) -> None:
        """A Command says that a life obeys the region of this number; those of earlier lives are no news."""
        require(number > disk.held.acknowledged, "acknowledge: it is news")
        require(number <= disk.held.granted, "acknowledge: it was granted")
        disk.held.acknowledge(number)
        self._geometry.note(disk)

    # -- bindings

    def introduce(self, one: DiskRecord[R], other: DiskRecord[R], line: L) -> None:
        """Bind two disks by a line with all that the one holds on one side, and all the other holds on the
        other."""
        require(one.name < other.name, "introduce: the low end comes first")
        require(one.phase != GONE, "introduce: the one is there")
        require(other.phase != GONE, "introduce: the other is there")
        require(self._geometry.beside(one.held, line, True), "introduce: beside the one")
        require(self._geometry.beside(other.held, line, False), "introduce: beside the other")
        self._bind(one, other, NO, line)

    def ask(self, disk: DiskRecord[R], other: DiskRecord[R]) -> None:
        """Ask a live disk for the first line towards one that stands, waits as a new life or is announced."""
        require(disk.life != NO, "ask: the disk has a life")
        require(other.phase != GONE, "ask: the other is there")
        require(other.still, "ask: the other stands")
        if disk.name < other.name:
            self._bind(disk, other, disk.name, None)
        else:
            self._bind(other, disk, disk.name, None)

    def _bind(self, low: DiskRecord[R], high: DiskRecord[R], asked: int, first: L | None) -> None:
        pair = self.pairs[low.name].get(high.name)
        if pair is None:
            pair = self.pairs[low.name][high.name] = self.pairs[high.name][low.name] = Pair()
        lives = low.life != NO and high.life != NO  # noqa: PLR1714  # the solver reads comparisons
        require(low.life != NO or high.life != NO, "bind: one of the two has a life")
        require((pair.living if lives else pair.static) is None, "bind: the two are not bound")
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
        """A Command says that a life obeys this first line of a binding in force, for which it was asked. No
        other life has heard of it."""
        require(binding.told == NO, "answer: it is news")
        self.version += 1
        binding.first, binding.told = line, self.version

    def part(self, one: DiskRecord[R], other: DiskRecord[R]) -> None:
        """End what binds two disks, while all that they hold is apart."""
        require(self._geometry.apart(one.held, other.held), "part: what they hold is apart")
        self.version += 1
        self._release(one, other)

    def _release(self, one: DiskRecord[R], other: DiskRecord[R]) -> None:
        self.pairs[one.name].pop(other.name, None)
        self.pairs[other.name].pop(one.name, None)

    # -- disks

    def announce(self, name: int, place: R) -> DiskRecord[R]:
        """A disk is to appear at a place; nothing is there yet."""
        disk = self.disks.get(name)
        require(disk is None or disk.phase == GONE, "announce: the disk is not there")
        self.version += 1
        found = self.disks[name] = DiskRecord(name, Held(self.version, place), ANNOUNCED)
        self.pairs[name] = {}
        self._geometry.note(found)
        return found

    def appear(self, news: Iterable[DiskRecord[R]], instead: Iterable[DiskRecord[R]] = ()) -> None:
        """Disks that were announced are there, in place of others that stand and have no life."""
        gone, come = list(instead), list(news)
        for disk in gone:
            require(disk.life == NO, "appear: what goes has no life")
        for disk in come:
            require(disk.phase == ANNOUNCED, "appear: what comes was announced")
        staying = [each for each in self.disks.values() if each.phase == PRESENT and each not in gone]
        for index, disk in enumerate(come):
            for other in [*staying, *come[:index]]:
                if not self.tied(other, disk):
                    require(self._geometry.apart(other.held, disk.held), "appear: apart from others, or tied")
        self.version += 1
        for disk in gone:
            self._vanish(disk)
        for disk in come:
            disk.phase = PRESENT

    def remove(self, disk: DiskRecord[R]) -> None:
        """A disk that has no life is taken away, does not appear after all, or is a part within the body that
        a life has commanded to be."""
        require(disk.phase != GONE, "remove: the disk is there")
        require(disk.life == NO, "remove: the disk has no life")
        self.version += 1
        self._vanish(disk)

    def _vanish(self, disk: DiskRecord[R]) -> None:
        disk.phase = GONE
        self._geometry.note(disk)
        for peer in list(self.pairs[disk.name]):
            self._release(disk, self.disks[peer])

    # -- grants

    def told(self, disk: DiskRecord[R]) -> Told[R, L]:
        """Everything that concerns the present life of a disk, as a whole."""
        listed: list[Listed[R, L]] = []
        for peer, pair in self.pairs[disk.name].items():
            for binding in (pair.living, pair.static):
                if binding is None or binding.end(disk.name).life != disk.life:
                    continue
                if binding.told == NO and binding.asked != disk.name:
                    continue
                other = self.disks[peer]
                place = other.held.regions[0][1] if other.still else None
                static = binding.other(disk.name).dead != NO
                listed.append(Listed(binding.number, peer, binding.first, place, static))
        held = disk.held
        return Told(disk.life, self.version, held.granted, held.regions[-1][1], listed)
