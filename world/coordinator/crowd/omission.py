"""What robots of a large fleet are not told of themselves, for they know it (`protocol.crowd.reckoning`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from protocol.crowd.reckoning import as_commanded, exact_place
from protocol.messages import Sense, Vector


class _Known(NamedTuple):
    """What a life knows that has commanded in `tick`."""

    incarnation: int
    tick: int
    place: Vector  # m, at its start


class Omission:
    """Leaves out what is sensed of robots that went as they commanded.

    Whoever commanded in the tick before was told of it, so that it knows where it was; whoever did not is
    told everything.

    Args:
        step: of time, s.
    """

    def __init__(self, step: float) -> None:
        self._step = step
        self._known: dict[int, _Known] = {}

    def sift(
        self,
        tick: int,
        sensed: Mapping[int, Sense],
        commanded: Mapping[int, Vector],
        incarnations: Mapping[int, int],
    ) -> tuple[dict[int, Sense], frozenset[int]]:
        """What is still to be told at the start of `tick`, and of whom only that it went as it commanded.

        Args:
            tick: that begins; each once, in order.
            sensed: of every robot.
            commanded: velocities taken in the tick before, m/s.
            incarnations: newest of each robot.
        """
        known, self._known = self._known, {}
        told = {}
        for robot, sense in sensed.items():
            before, velocity, life = known.get(robot), commanded.get(robot), incarnations.get(robot, 0)
            place = exact_place(tick, sense)
            if place is not None:
                self._known[robot] = _Known(life, tick, place)
            if (
                before is None
                or velocity is None
                or (before.incarnation, before.tick) != (life, tick - 1)
                or sense != as_commanded(tick, before.place, velocity, self._step)
            ):
                told[robot] = sense
        return told, frozenset(sensed.keys() - told.keys())
