"""One robot's slice of the navigation function's gradient, with everybody else where last heard.

    D_i(x) = 2 (x - g_i) - (gamma/k) [ sum_j 2 (x - b_j)/beta_ij - 2 x/beta_0i ]

(Karagoz, Bozma, Koditschek, eq. 5 and 9: grad phi = c D with a scalar c > 0 common to all robots, which is
dropped because it only re-times the flow and spans hundreds of orders of magnitude.) Here
gamma(x) = sum of the peers' gamma_j, held fixed, + |x - g_i|^2. No power of gamma and no product of betas
is formed, so any k and any number of robots stay finite.

Plain floats: below about 40 peers a loop beats numpy several times, and at 200 it still keeps its budget.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from mypy_extensions import mypyc_attr

from agents.navigation.far_field import NOTHING, FarField

# 1/beta is followed down to this fraction of the squared contact distance, a gap of less than a nanometre
# per metre of radius, and along its tangent from there on (see `Slice`).
CONTACT: Final = 1e-9
_LIMIT: Final = 1.0 + CONTACT


@mypyc_attr(acyclic=True)
class Peer:
    """A disk as a robot knows it: centre and radius in m, gamma_j = |b_j - g_j|^2 in m^2 (0 if fixed)."""

    __slots__ = ("gamma", "radius", "x", "y")

    def __init__(self, x: float, y: float, radius: float, gamma: float) -> None:
        self.x, self.y, self.radius, self.gamma = x, y, radius, gamma


@final
@mypyc_attr(acyclic=True)
class Gradient:
    """D_i (m) at a point and its Jacobian dD_i/dx, row by row (dimensionless)."""

    __slots__ = ("dx", "dy", "xx", "xy", "yx", "yy")

    def __init__(self, dx: float, dy: float, xx: float, xy: float, yx: float, yy: float) -> None:
        self.dx, self.dy = dx, dy
        self.xx, self.xy, self.yx, self.yy = xx, xy, yx, yy


class Slice:
    """D_i and its Jacobian as functions of the own position, built once per tick.

    At or behind a contact (beta <= 0, possible because peers are known late) phi has no gradient. There the
    slice continues 1/beta along its tangent at beta = 1e-9 rho^2: `-D_i` then points straight out of the
    overlap, outweighs all attraction, and grows with the depth, so that integrating it pushes the disks
    apart. It is continuously differentiable everywhere. Two coincident centres exert no push.

    Args:
        goal: own goal, m.
        radius: own radius, m.
        workspace: radius of the workspace, m; larger than `radius`.
        k: the navigation function's exponent.
        peers: everybody else who is known closely.
        far: what all others add.

    Attributes:
        goal: as given.
    """

    __slots__ = ("_edge", "_far", "_inverse_k", "_others", "_peers", "_radius", "goal")

    def __init__(
        self,
        goal: tuple[float, float],
        radius: float,
        workspace: float,
        k: float,
        peers: Sequence[Peer],
        far: FarField = NOTHING,
    ) -> None:
        self.goal = goal
        self._radius = radius
        self._inverse_k = 1.0 / k
        self._edge = (workspace - radius) ** 2
        self._peers, self._far = peers, far
        others = far.gamma
        for peer in peers:
            others += peer.gamma
        self._others = others

    def gamma(self, x: float, y: float) -> float:
        """gamma = sum of all squared distances to the goals, m^2, with this robot at (x, y)."""
        return self._others + (x - self.goal[0]) ** 2 + (y - self.goal[1]) ** 2

    def __call__(self, x: float, y: float) -> tuple[float, float]:
        """D_i at (x, y), m. The law is u_i = -D_i up to a positive scale."""
        far = self._far
        px, py = x - far.x, y - far.y
        log_x = far.log_x + far.xx * px + far.xy * py  # half the gradient of log beta
        log_y = far.log_y + far.xy * px + far.yy * py
        for peer in self._peers:
            ax = x - peer.x
            ay = y - peer.y
            contact_distance = self._radius + peer.radius
            contact = contact_distance * contact_distance
            square = ax * ax + ay * ay
            if square > contact * _LIMIT:
                inverse = 1.0 / (square - contact)
            else:
                inverse, _ = _beyond(square - contact, contact * _LIMIT - contact)
            log_x += ax * inverse
            log_y += ay * inverse
        inverse = self._edge_inverse(x, y)[0]
        log_x -= x * inverse
        log_y -= y * inverse
        ex = x - self.goal[0]
        ey = y - self.goal[1]
        share = (self._others + ex * ex + ey * ey) * self._inverse_k
        return 2.0 * (ex - share * log_x), 2.0 * (ey - share * log_y)

    def gradient(self, x: float, y: float) -> Gradient:
        """D_i and its Jacobian at (x, y), in one pass."""
        far = self._far
        px, py = x - far.x, y - far.y
        log_x = far.log_x + far.xx * px + far.xy * py
        log_y = far.log_y + far.xy * px + far.yy * py
        trace, xx, xy, yy = 0.0, far.xx, far.xy, far.yy  # second derivatives of half log beta
        for peer in self._peers:
            ax = x - peer.x
            ay = y - peer.y
            contact_distance = self._radius + peer.radius
            contact = contact_distance * contact_distance
            square = ax * ax + ay * ay
            if square > contact * _LIMIT:
                inverse = 1.0 / (square - contact)
                slope = -2.0 * inverse * inverse
            else:
                inverse, slope = _beyond(square - contact, contact * _LIMIT - contact)
                slope *= 2.0
            log_x += ax * inverse
            log_y += ay * inverse
            trace += inverse
            xx += slope * ax * ax
            xy += slope * ax * ay
            yy += slope * ay * ay
        inverse, slope = self._edge_inverse(x, y)
        slope *= 2.0
        log_x -= x * inverse
        log_y -= y * inverse
        xx += slope * x * x + trace - inverse
        xy += slope * x * y
        yy += slope * y * y + trace - inverse
        ex = x - self.goal[0]
        ey = y - self.goal[1]
        share = (self._others + ex * ex + ey * ey) * self._inverse_k
        fx = 2.0 * self._inverse_k * log_x
        fy = 2.0 * self._inverse_k * log_y
        return Gradient(
            2.0 * (ex - share * log_x),
            2.0 * (ey - share * log_y),
            2.0 * (1.0 - fx * ex - share * xx),
            -2.0 * (fx * ey + share * xy),
            -2.0 * (fy * ex + share * xy),
            2.0 * (1.0 - fy * ey - share * yy),
        )

    def norm(self, x: float, y: float) -> float:
        """|D_i| at (x, y), m: what a robot tells its peers for the common pace."""
        return math.hypot(*self(x, y))

    def _edge_inverse(self, x: float, y: float) -> tuple[float, float]:
        """1/beta_0i and its derivative with respect to beta_0i."""
        beta = self._edge - x * x - y * y
        if beta > CONTACT * self._edge:
            inverse = 1.0 / beta
            return inverse, -inverse * inverse
        return _beyond(beta, CONTACT * self._edge)


def _beyond(beta: float, contact: float) -> tuple[float, float]:
    """The tangent of 1/beta at beta = contact, followed to `beta`, and its slope."""
    return (2.0 - beta / contact) / contact, -1.0 / (contact * contact)
