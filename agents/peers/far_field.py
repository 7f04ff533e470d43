"""What far disks add to a robot's slice: little, and changing slowly, so that it is followed to first order.

With a_j = x - b_j and contact distance rho_ij, half the gradient of log beta is the sum over peers of
a_j / (|a_j|^2 - rho_ij^2) (`agents.law.gradient`). Of far peers that sum and its derivative are taken at
one place, and serve all around it until more is known of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from mypy_extensions import mypyc_attr
from numpy.typing import NDArray

from protocol.messages import Vector

Array = NDArray[np.float64]


@final
@mypyc_attr(acyclic=True)
class FarField:
    """To first order around (x, y), m.

    Attributes:
        log_x, log_y: half the gradient of log beta there, 1/m.
        xx, xy, yy: its derivative, symmetric, 1/m^2.
        gamma, largest: sum of the disks' squared distances to their goals and the largest of them, m^2.
        slice: the largest norm of the disks' own slices, m.
        count: of disks.
        tick: in which they were there.
    """

    __slots__ = ("count", "gamma", "largest", "log_x", "log_y", "slice", "tick", "x", "xx", "xy", "y", "yy")

    def __init__(self, tick: int = 0, x: float = 0.0, y: float = 0.0) -> None:
        self.tick = tick
        self.x, self.y = x, y
        self.log_x = self.log_y = self.xx = self.xy = self.yy = 0.0
        self.gamma = self.largest = self.slice = 0.0
        self.count = 0


NOTHING = FarField()


def far_field(
    tick: int,
    position: Vector,
    x: Array,
    y: Array,
    contacts: Array,
    gammas: Array,
    slices: Array,
    known: Sequence[int] = (),
) -> FarField:
    """The field of disks that are surely apart; the others are left out.

    Args:
        tick: of the places.
        position: around which, m.
        x, y: places of the disks, m.
        contacts: distance at which each touches, m.
        gammas: squared distances to their goals, m^2.
        slices: norms of their own slices, m.
        known: indices of disks that do not count, each once.
    """
    field = FarField(tick, *position)
    field.count = len(gammas) - len(known)
    if field.count <= 0:
        return field
    squares = contacts * contacts
    ax, ay = position[0] - x, position[1] - y
    beta = ax * ax
    beta += ay * ay
    beta -= squares
    np.copyto(beta, np.inf, where=beta <= squares)
    inverse = np.reciprocal(beta)
    others, norms = gammas, slices
    if known:
        others, norms = gammas.copy(), slices.copy()
        inverse[known] = others[known] = norms[known] = 0.0
    slope = inverse * inverse
    slope *= -2.0
    trace = float(np.add.reduce(inverse))
    field.log_x, field.log_y = float(ax.dot(inverse)), float(ay.dot(inverse))
    along = slope * ax
    field.xx, field.xy = trace + float(along.dot(ax)), float(along.dot(ay))
    slope *= ay
    field.yy = trace + float(slope.dot(ay))
    field.gamma, field.largest = float(np.add.reduce(others)), float(np.maximum.reduce(others))
    field.slice = float(np.maximum.reduce(norms))
    return field
