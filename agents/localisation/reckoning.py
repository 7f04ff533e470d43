"""What a robot knows of itself once it is told that all went as it commanded (`protocol.crowd.reckoning`)."""

from __future__ import annotations

from typing import final

from protocol.crowd.reckoning import as_commanded, exact_place
from protocol.messages import Sense, Vector


@final
class Reckoning:
    """Of one life.

    Args:
        step: of time, s.
    """

    def __init__(self, step: float) -> None:
        self._step = step
        self._tick = -1  # in which it commanded last
        self._velocity: Vector = (0.0, 0.0)
        self._place: Vector | None = None  # m, at the start of the newest tick, if it is known exactly

    def sense(self, tick: int, told: Sense | None, *, went_as_commanded: bool) -> Sense | None:
        """What is sensed as `tick` begins: what is `told`, or what was commanded, if that is what happened;
        None if neither is known. That nothing is told says nothing: the command may have been void."""
        if went_as_commanded and self._place is not None and self._tick == tick - 1:
            told = as_commanded(tick, self._place, self._velocity, self._step)
        self._place = exact_place(tick, told)
        return told

    def commanded(self, tick: int, velocity: Vector) -> None:
        """The robot gives its Command of `tick`."""
        self._tick, self._velocity = tick, velocity
