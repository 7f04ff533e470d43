"""What need not be said of a robot that went exactly as it commanded, and whose place is measured exactly.

Coordinator and robot both know where it was and what it commanded. Where the sum of the two is what it would
be told in `Tick.sense`, the coordinator says just that: in a large fleet a sense is most of a Tick.
"""

from __future__ import annotations

from protocol.messages import Sense, Vector


def as_commanded(tick: int, place: Vector, velocity: Vector, step: float) -> Sense:
    """What is sensed at the start of `tick` if all went as commanded in the one before.

    Args:
        tick: that begins.
        place: measured at the start of the tick before, m.
        velocity: commanded in it, m/s.
        step: of time, s.
    """
    dx, dy = velocity[0] * step, velocity[1] * step
    return Sense((place[0] + dx, place[1] + dy), tick, 0, (dx, dy), 0)


def exact_place(tick: int, sense: Sense | None) -> Vector | None:
    """Where a robot was at the start of `tick`, m, if that was measured then, and without error."""
    return None if sense is None or sense.stamp != tick or sense.bound > 0.0 else sense.position
