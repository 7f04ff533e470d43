"""Desired velocity: the gradient flow integrated over one period, with the peers as last heard.

Holding -D for a whole period chatters and collides in the repulsive layer, which is only about gamma/k thin
and stiff; following y' = -s D(y) inside the period does not. The integrator is the modified Rosenbrock pair
of Shampine and Reichelt ("The MATLAB ODE suite", 1997, ode23s): L-stable, second order, third-order error
estimate, with the slice's exact Jacobian. Away from contact a period is one step of three evaluations.
"""

from __future__ import annotations

import math

from agents.slice import Gradient, Slice

TOLERANCE = 2e-3  # error of one step, as a fraction of the distance that the speed limit allows in a period
MAX_STEPS = 60  # attempted steps per period; what was reached by then is returned
_D = 1.0 / (2.0 + math.sqrt(2.0))
_E32 = 6.0 + math.sqrt(2.0)

Vector = tuple[float, float]


def desired_velocity(
    field: Slice,
    position: Vector,
    scale: float,
    period: float,
    speed: float,
    drift: Vector = (0.0, 0.0),
) -> Vector:
    """Mean velocity (m/s) over a period of y' = -scale D(y) + drift, y(0) = position.

    Where the law asks for more than the speed limit the curve is followed at the limit: it ends after
    `period` or after `speed * period` of arc, whichever comes first. Both ends descend phi, and a large
    `scale` gives the flow of a robot that saturates by itself.

    Args:
        field: own slice of the gradient.
        position: own position, m.
        scale: pace s, 1/s, positive (`agents.pace`).
        period: control period, s.
        speed: speed limit, m/s; the result never exceeds it.
        drift: constant velocity added within the flow, m/s, so that obstacles still repel it (`agents.deadlock`).
    """
    reach = speed * period
    x, y = _integrate(field, position, scale, period, reach, drift)
    vx, vy = (x - position[0]) / period, (y - position[1]) / period
    norm = math.hypot(vx, vy)
    if norm > speed:
        return vx * speed / norm, vy * speed / norm
    return vx, vy


def _integrate(
    field: Slice, position: Vector, scale: float, period: float, reach: float, drift: Vector
) -> Vector:
    """Where the flow ends after `period`, or after `reach` of arc if that is sooner."""
    x, y = position
    tolerance = TOLERANCE * reach
    now = field.gradient(x, y)
    left, arc = period, reach
    step = period
    for _ in range(MAX_STEPS):
        rate = math.hypot(drift[0] - scale * now.dx, drift[1] - scale * now.dy)
        step = min(step, left, 2.0 * arc / rate if rate > 0.0 else left)
        mx, my, error, end = _step(field, x, y, now, scale, step, drift)
        if error <= tolerance:
            moved = math.hypot(mx, my)
            if moved >= arc:
                return x + mx * arc / moved, y + my * arc / moved
            x, y, now = x + mx, y + my, end
            left -= step
            arc -= moved
            if left <= 1e-12 * period:
                break
        step *= min(4.0, max(0.1, 0.8 * (tolerance / error) ** (1.0 / 3.0))) if error > 0.0 else 4.0
    return x, y


def _step(
    field: Slice, x: float, y: float, now: Gradient, scale: float, step: float, drift: Vector
) -> tuple[float, float, float, Gradient]:
    """One Rosenbrock step: displacement (m), error estimate (m), gradient at the end.

    W = I + step d scale J, since the flow's Jacobian is -scale J.
    """
    fx, fy = drift[0] - scale * now.dx, drift[1] - scale * now.dy
    h = step * _D * scale
    a, b, c, d = 1.0 + h * now.xx, h * now.xy, h * now.yx, 1.0 + h * now.yy
    inverse = 1.0 / (a * d - b * c)
    k1x, k1y = (d * fx - b * fy) * inverse, (a * fy - c * fx) * inverse
    mx, my = field(x + 0.5 * step * k1x, y + 0.5 * step * k1y)
    gx, gy = drift[0] - scale * mx, drift[1] - scale * my
    rx, ry = gx - k1x, gy - k1y
    k2x, k2y = (d * rx - b * ry) * inverse + k1x, (a * ry - c * rx) * inverse + k1y
    mx, my = step * k2x, step * k2y
    end = field.gradient(x + mx, y + my)
    rx = drift[0] - scale * end.dx - _E32 * (k2x - gx) - 2.0 * (k1x - fx)
    ry = drift[1] - scale * end.dy - _E32 * (k2y - gy) - 2.0 * (k1y - fy)
    k3x, k3y = (d * rx - b * ry) * inverse, (a * ry - c * rx) * inverse
    error = math.hypot(k1x - 2.0 * k2x + k3x, k1y - 2.0 * k2y + k3y) * step / 6.0
    return mx, my, error, end
