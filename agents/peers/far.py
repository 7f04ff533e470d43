"""Far peers: positions of all robots by the world's newest summary, and their share of a robot's slice."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import lru_cache
from typing import Final, final

import numpy as np
from mypy_extensions import mypyc_attr
from numpy.typing import NDArray

from protocol.arrays import Reals
from protocol.codec import decode, keeps_newest
from protocol.crowd import LEAD, period, stagger
from protocol.errors import MessageError
from protocol.messages import LARGEST, Summary, Vector
from protocol.scenario.model import Scenario


@final
@mypyc_attr(acyclic=True)
class SummaryPlaces:
    """One summary; raises MessageError if it is malformed. Immutable."""

    def __init__(self, summary: Summary) -> None:
        self.tick, self.epoch = summary.tick, summary.epoch
        self.runs = summary.robots  # ids, encoded as there
        count = len(summary.gammas) // 4
        sizes_fit = len(summary.gammas) == len(summary.slices) == 4 * count
        if not sizes_fit or len(summary.positions) != 8 * count:
            raise MessageError(
                "shape", "summary: as many positions as squared distances and slices are needed"
            )
        places = np.ascontiguousarray(_numbers(summary.positions).reshape(-1, 2).T)
        places.setflags(write=False)
        self.x, self.y = places  # m, shape (n,)
        self.gammas: Reals = _numbers(summary.gammas)  # m^2
        self.slices: Reals = _numbers(summary.slices)  # m
        sizes = np.concatenate((np.abs(places).ravel(), self.gammas, self.slices))
        if not ((sizes >= 0.0) & (sizes <= LARGEST**2)).all():
            raise MessageError("shape", "summary: holds a number that is infinite, absurd or none")
        robots, index = _ids(summary.robots, count)
        self.robots: NDArray[np.int64] = robots  # ids, ascending
        self.index: Mapping[int, int] = index  # position of each id in the arrays


# Robots of one process share what follows from the newest summaries: among 1000 a tick takes a fifth less.
@lru_cache(maxsize=1)
def read_summary(key: str, payload: bytes) -> SummaryPlaces:
    """The summary in a payload of its key; raises MessageError."""
    message = decode(key, payload)
    assert isinstance(message, Summary)
    return SummaryPlaces(message)


@lru_cache(maxsize=16)
def drift(before: SummaryPlaces, after: SummaryPlaces) -> tuple[Reals, Reals]:
    """Mean displacement of each robot per tick between two summaries, m; zero if their robots differ."""
    ticks = after.tick - before.tick
    if before.runs != after.runs or ticks <= 0:
        return np.zeros_like(after.x), np.zeros_like(after.y)
    return (after.x - before.x) / ticks, (after.y - before.y) / ticks


@keeps_newest
def _sizes(known: tuple[Mapping[int, int], Mapping[int, float]]) -> Reals:
    """Radii of the robots of a summary's index, m. Immutable: robots of one process share them."""
    index, radii = known
    sizes: Reals = np.array([radii.get(robot, 0.0) for robot in index], dtype=np.float64)
    sizes.setflags(write=False)
    return sizes


@final
@mypyc_attr(acyclic=True)
class FarField:
    """Terms of far disks in the slice, to first order around (x, y), m."""

    def __init__(self, tick: int = 0, x: float = 0.0, y: float = 0.0) -> None:
        self.tick = tick  # of their positions
        self.x, self.y = x, y
        self.log_x = self.log_y = 0.0  # half the gradient of log beta there, 1/m
        self.xx = self.xy = self.yy = 0.0  # its derivative, symmetric, 1/m^2
        self.gamma = self.largest = 0.0  # sum and maximum of their squared distances to their goals, m^2
        self.slice = 0.0  # the largest norm of their own slices, m
        self.count = 0  # number of disks


NOTHING = FarField()


@final
class FarPicture:
    """One summary, with the radii that one robot knows.

    Args:
        radii: of all robots, m, by id; 0 for ids that it lacks.
        before: the picture before, from which robots moved.
    """

    def __init__(
        self, places: SummaryPlaces, radii: Mapping[int, float], before: FarPicture | None = None
    ) -> None:
        self.places = places
        self._before = places if before is None else before.places
        self._sizes = _sizes((places.index, radii))

    def courses(self) -> tuple[Reals, Reals, Reals, Reals, Reals]:
        """Of all robots: x and y, mean displacement in x and y per tick since the summary before (0 if that
        has other robots), and radii, m."""
        return self.places.x, self.places.y, *drift(self._before, self.places), self._sizes

    def field(self, position: Vector, radius: float, known: Collection[int]) -> FarField:
        """The terms that all robots but the `known` (own id included, each once) add to the slice of a robot
        of `radius`, m, near its position, m; those nearer than sqrt(2) contact distances are left out of log
        beta."""
        far = self.places
        near = [far.index[robot] for robot in known if robot in far.index]
        field = FarField(far.tick, *position)
        field.count = len(far.gammas) - len(near)
        if field.count <= 0:
            return field
        contacts = radius + self._sizes
        squares = contacts * contacts
        ax, ay = position[0] - far.x, position[1] - far.y
        beta = ax * ax
        beta += ay * ay
        beta -= squares
        np.copyto(beta, np.inf, where=beta <= squares)
        inverse = np.reciprocal(beta)
        gammas, slices = far.gammas, far.slices
        if near:
            gammas, slices = gammas.copy(), slices.copy()
            inverse[near] = gammas[near] = slices[near] = 0.0
        slope = inverse * inverse
        slope *= -2.0
        trace = float(np.add.reduce(inverse))
        field.log_x, field.log_y = float(ax.dot(inverse)), float(ay.dot(inverse))
        along = slope * ax
        field.xx, field.xy = trace + float(along.dot(ax)), float(along.dot(ay))
        slope *= ay
        field.yy = trace + float(slope.dot(ay))
        field.gamma, field.largest = float(np.add.reduce(gammas)), float(np.maximum.reduce(gammas))
        field.slice = float(np.maximum.reduce(slices))
        return field


_EARLY: Final = 8  # most summaries kept until they are due; more wait only after a long pause


@final
class Arrivals:
    """Summaries received by one robot; the tick alone decides when one takes effect."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self._period, self._wait = period(scenario), LEAD + stagger(scenario, robot)
        self._newest = self._due = -1  # ticks of the newest summary, and of the one due
        self._arrived: dict[int, SummaryPlaces] = {}
        self._picture: FarPicture | None = None  # applied last

    def open(self, tick: int) -> None:
        """Begin a tick."""
        if self._due != self._newest and tick >= self._newest + self._wait:
            self._due = self._newest
            self._arrived = {each: self._arrived[each] for each in self._arrived if each >= self._due}
        if tick % self._period == 0:
            self._newest = tick

    def on_summary(self, places: SummaryPlaces) -> None:
        """Receive a summary."""
        if places.tick <= self._taken or places.tick < self._due:
            return
        self._arrived[places.tick] = places
        if len(self._arrived) > _EARLY:
            del self._arrived[sorted(self._arrived)[-2]]  # the oldest may be due, the newest will be soon

    @property
    def has_summary(self) -> bool:
        """Whether the summary that is due in this tick, if any, or a later one has arrived."""
        return self._due < 0 or self._taken >= self._due or max(self._arrived, default=-1) >= self._due

    @property
    def _taken(self) -> int:
        return -1 if self._picture is None else self._picture.places.tick

    def new_picture(self, radii: Mapping[int, float]) -> FarPicture | None:
        """The summary that is due, returned once, with the radii of all robots, m; None if there is none."""
        if self._due <= self._taken:
            return None
        coming = sorted([tick for tick in self._arrived if tick >= self._due])
        if not coming:
            return None
        self._picture = FarPicture(self._arrived[coming[0]], radii, self._picture)
        self._arrived = {tick: self._arrived[tick] for tick in coming[1:]}
        return self._picture


def _numbers(payload: bytes) -> Reals:
    with np.errstate(invalid="ignore"):  # NaN is refused below, without a warning
        numbers: Reals = np.frombuffer(payload, dtype="<f4").astype(np.float64)
    numbers.setflags(write=False)
    return numbers


@lru_cache(maxsize=1)  # ids seldom change
def _ids(runs: bytes, count: int) -> tuple[NDArray[np.int64], Mapping[int, int]]:
    """The ids that `runs` encode (`protocol.messages.Summary`), `count` in all, and the index of each."""
    if len(runs) % 8:
        raise MessageError("shape", "summary: a run of ids is two numbers")
    pairs = np.frombuffer(runs, dtype="<u4").astype(np.int64).reshape(-1, 2)
    first, many = pairs[:, 0], pairs[:, 1]
    if int(many.sum()) != count:
        raise MessageError("shape", "summary: as many ids as positions are needed")
    ids: NDArray[np.int64] = np.repeat(first - np.cumsum(many) + many, many) + np.arange(count)
    if (np.diff(ids) <= 0).any():
        raise MessageError("shape", "summary: ids have to ascend")
    ids.setflags(write=False)
    known: list[int] = ids.tolist()
    return ids, {robot: place for place, robot in enumerate(known)}
