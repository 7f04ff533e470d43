"""Where the owner puts the next line of a pair, and when it is worth a proposal.

Nothing here can be unsafe: the ledger offers only lines that the own disk satisfies, and the
follower adopts only those that its own disk satisfies.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from agents.lines.line import ROUNDING, Line

_EVEN = 0.5  # share of the gap for the owner when neither robot wants any of it


class Disk(NamedTuple):
    """One robot as the owner of a line sees it: centre, radius and error bound (m), desired velocity."""

    x: float
    y: float
    radius: float
    vx: float
    vy: float


def is_idle(line: Line, owner: Disk, follower: Disk, reach: float) -> bool:
    """Whether neither robot can get within `reach` (m) of the line by moving that far: it may stay."""
    nx, ny, offset = line
    return (
        offset - nx * owner.x - ny * owner.y - owner.radius > 2.0 * reach
        and nx * follower.x + ny * follower.y - follower.radius - offset > 2.0 * reach
    )


def place(owner: Disk, follower: Disk) -> Line | None:
    """The line across the gap between two disks, shared in proportion to what each wants of it.

    None when the disks are not known to be apart.
    """
    dx, dy = follower.x - owner.x, follower.y - owner.y
    distance = math.hypot(dx, dy)
    gap = distance - owner.radius - follower.radius - 4.0 * ROUNDING
    if gap <= 0.0:
        return None
    nx, ny = dx / distance, dy / distance
    wanted = max(0.0, nx * owner.vx + ny * owner.vy)
    granted = max(0.0, -nx * follower.vx - ny * follower.vy)
    share = wanted / (wanted + granted) if wanted + granted > 0.0 else _EVEN
    edge = nx * owner.x + ny * owner.y + owner.radius + 2.0 * ROUNDING
    return Line(nx, ny, edge + share * gap)
