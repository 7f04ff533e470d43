"""Desired velocity: the gradient flow integrated over one period, with the peers as last received.

A constant -D over a whole period oscillates and collides in the repulsive layer, which is stiff and only
about gamma/k thin; following y' = -s D(y) inside the period does not. The integrator is the modified
Rosenbrock pair of Shampine and Reichelt ("The MATLAB ODE suite", 1997, ode23s): L-stable, second order,
third-order error estimate, with the slice's exact Jacobian. Away from contact a period is one step of three
evaluations.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, final

from mypy_extensions import mypyc_attr

from protocol.messages import Vector

if TYPE_CHECKING:
    from agents.law.gradient import Gradient, Slice

TOLERANCE: Final = 2e-3  # error of one step, as a fraction of the longest motion in a period
MAX_STEPS: Final = 60  # attempted steps per period
_D: Final = 1.0 / (2.0 + math.sqrt(2.0))
_E32: Final = 6.0 + math.sqrt(2.0)


@final
@mypyc_attr(acyclic=True)
class Flow:
    """The autonomous field y' = -scale D(y) + drift, m/s."""

    def __init__(self, field: Slice, scale: float, drift: Vector = (0.0, 0.0)) -> None:
        self.slice, self.scale, self.drift = field, scale, drift


def desired_velocity(
    flow: Flow, position: Vector, *, period: float, speed: float, begin: Gradient | None = None
) -> Vector:
    """Mean velocity (m/s) over one period of the flow from `position` (m).

    Above the speed limit the curve is followed at the limit: it ends after `period` (s), or earlier after an
    arc of `speed * period`. The result never exceeds `speed` (m/s). `begin` is the slice's gradient at
    `position`, if known.
    """
    if begin is None:
        begin = flow.slice.gradient(*position)
    x, y = _end(flow, position, begin, period, speed * period)
    vx, vy = (x - position[0]) / period, (y - position[1]) / period
    excess = math.hypot(vx, vy) / speed
    return (vx, vy) if excess <= 1.0 else (vx / excess, vy / excess)


def _end(flow: Flow, position: Vector, now: Gradient, period: float, max_step: float) -> Vector:
    """End of the flow after `period`, or earlier after an arc of `max_step`."""
    x, y = position
    left, arc, step = period, max_step, period
    tolerance = TOLERANCE * max_step
    for _ in range(MAX_STEPS):
        rate = math.hypot(flow.drift[0] - flow.scale * now.dx, flow.drift[1] - flow.scale * now.dy)
        if rate * left > 2.0 * arc:
            step = min(step, 2.0 * arc / rate)
        step = min(step, left)
        mx, my, error, end = _rosenbrock(flow, x, y, now, step)
        if error <= tolerance:
            moved = math.hypot(mx, my)
            if moved >= arc:
                return x + mx * arc / moved, y + my * arc / moved
            x, y, now = x + mx, y + my, end
            left -= step
            arc -= moved
            if left <= 1e-9 * period:
                break
        step *= min(4.0, max(0.1, 0.8 * (tolerance / max(error, 1e-3 * tolerance)) ** (1.0 / 3.0)))
    return x, y


def _rosenbrock(
    flow: Flow, x: float, y: float, now: Gradient, step: float
) -> tuple[float, float, float, Gradient]:
    """One step from (x, y): displacement (m), error estimate (m), gradient at the end.

    The matrix of the three linear systems is W = I + step d scale J, as the flow's Jacobian is -scale J.
    """
    field, scale, (wx, wy) = flow.slice, flow.scale, flow.drift
    fx, fy = wx - scale * now.dx, wy - scale * now.dy
    h = step * _D * scale
    a, b, c, d = 1.0 + h * now.xx, h * now.xy, h * now.yx, 1.0 + h * now.yy
    inverse = 1.0 / (a * d - b * c)
    a, b, c, d = a * inverse, b * inverse, c * inverse, d * inverse
    k1x, k1y = d * fx - b * fy, a * fy - c * fx
    gx, gy = field(x + 0.5 * step * k1x, y + 0.5 * step * k1y)
    gx, gy = wx - scale * gx, wy - scale * gy
    rx, ry = gx - k1x, gy - k1y
    k2x, k2y = k1x + d * rx - b * ry, k1y + a * ry - c * rx
    mx, my = step * k2x, step * k2y
    end = field.gradient(x + mx, y + my)
    rx = wx - scale * end.dx - _E32 * (k2x - gx) - 2.0 * (k1x - fx)
    ry = wy - scale * end.dy - _E32 * (k2y - gy) - 2.0 * (k1y - fy)
    k3x, k3y = d * rx - b * ry, a * ry - c * rx
    error = math.hypot(k1x - 2.0 * k2x + k3x, k1y - 2.0 * k2y + k3y) * step / 6.0
    return mx, my, error, end
