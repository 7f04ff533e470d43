"""The half-plane of velocities that one robot leaves itself for the sake of another.

Van den Berg, Guy, Lin, Manocha, "Reciprocal n-Body Collision Avoidance" (2011), section 4: if both keep to
theirs, they do not touch within the horizon.
"""

from __future__ import annotations

import math

from agents.lines.line import HalfPlane


def reciprocal(
    rx: float,
    ry: float,
    contact: float,
    vx: float,
    vy: float,
    ux: float,
    uy: float,
    horizon: float,
    share: float,
) -> HalfPlane:
    """Own velocities n.v <= limit.

    Args:
        rx, ry: from the own centre to the other's, m, farther than `contact` apart.
        contact: distance at which they touch, m.
        vx, vy: own velocity that both reckon with, m/s.
        ux, uy: the other's, m/s.
        horizon: s.
        share: of the change of relative velocity that this robot takes upon itself.
    """
    dx, dy = vx - ux, vy - uy
    square = rx * rx + ry * ry
    wx, wy = dx - rx / horizon, dy - ry / horizon  # from the centre of the obstacle's round end
    size = math.hypot(wx, wy)
    ahead = wx * rx + wy * ry
    if ahead < 0.0 and -ahead > contact * size:
        nx, ny = -wx / size, -wy / size
        depth = contact / horizon - size
    else:
        leg = math.sqrt(max(0.0, square - contact * contact))
        turn = leg if rx * wy - ry * wx > 0.0 else -leg
        nx, ny = (rx * contact + ry * turn) / square, (ry * contact - rx * turn) / square
        depth = nx * dx + ny * dy
    return HalfPlane(nx, ny, nx * vx + ny * vy - share * depth)
