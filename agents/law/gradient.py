"""The paper's law, whole: down one robot's slice of the navigation function's gradient.

Karagöz, Bozma and Koditschek, with gamma = sum_j |b_j - g_j|^2, and beta the product of all
    beta_ij = |b_i - b_j|^2 - rho_ij^2,    rho_ij = rho_i + rho_j,
    beta_0i = rho_0i^2 - |b_i|^2,          rho_0i = rho_0 - rho_i:

    (5)  phi_hat = gamma^k / beta
    (9)  phi = (gamma^k / (gamma^k + beta))^(1/k)

         grad phi = c D,    c = beta (gamma^k + beta)^-(1 + 1/k) > 0
         D = grad gamma - (gamma/k) grad log beta
         D_i = 2 (b_i - g_i) - (gamma/k) [ sum_j 2 (b_i - b_j)/beta_ij - 2 b_i/beta_0i ]
         u_i = -s D_i,      s > 0

c is common to all robots; it is omitted because it only changes the timing, and spans hundreds of orders of
magnitude. No power of gamma and no product of betas is computed, so any k and number of robots stay finite.
`GradientLaw` is `control.law = "gradient"` with `control.additions = []`; the rest is in `additions.py`.

Plain floats: below about 40 peers a loop is several times faster than numpy, and fast enough for 200.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from mypy_extensions import mypyc_attr

from agents.law.api import View
from agents.law.flow import Flow, desired_velocity
from agents.law.pace import max_rate
from agents.peers.far import NOTHING, FarField
from agents.peers.state import Peer
from protocol.geometry import Disk, Shape
from protocol.messages import Vector
from protocol.scenario.model import Scenario

CONTACT: Final = 1e-9  # squared contact distances of beta below which 1/beta continues along its tangent
_LIMIT: Final = 1.0 + CONTACT
_REMOTE: Final = 1e6  # radius of a boundary without effect, sizes of the room


@final
class GradientLaw:
    """u_i = -s D_i with the largest s, integrated over the period: a `Law`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec, control, time = scenario.spec(robot), scenario.control, scenario.time
        self._radius, self._workspace = spec.radius, boundary_radius(scenario.workspace.shape)
        self._k = scenario.k
        self._speed, self._period = control.speed, time.step
        self._scale = max_rate(control.speed, time.step, time.tolerance)
        self._slice = Slice(spec.goal, spec.radius, self._workspace, scenario.k, [])

    def velocity(self, view: View) -> Vector:
        """Mean of u_i over the period, m/s."""
        peers = view.neighbours.disks()
        self._slice = Slice(view.goal, self._radius, self._workspace, self._k, peers, view.neighbours.far)
        flow = Flow(self._slice, self._scale)
        return desired_velocity(flow, view.position, period=self._period, speed=self._speed)

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """|D_i|, m."""
        self._slice.goal = goal
        return self._slice.norm(*position)


@final
@mypyc_attr(acyclic=True)
class Gradient:
    """D_i (m) at a point and its Jacobian dD_i/dx, row by row (dimensionless)."""

    def __init__(self, dx: float, dy: float, xx: float, xy: float, yx: float, yy: float) -> None:
        self.dx, self.dy = dx, dy
        self.xx, self.xy, self.yx, self.yy = xx, xy, yx, yy


class Slice:
    """D_i and its Jacobian as functions of the own position, built once per tick.

    At or beyond contact (beta <= 0, possible since States are late) phi has no gradient. There the slice
    continues 1/beta along its tangent at beta = 1e-9 rho^2: `-D_i` then points out of the overlap, exceeds
    all attraction, and grows with the depth. It is continuously differentiable everywhere. Coincident centres
    exert no force.

    Args:
        goal: own goal, m; an attribute that may be changed.
        radius: own radius, m.
        workspace: radius of the workspace, m; larger than `radius`.
        k: the navigation function's exponent.
        peers: all that are known closely.
        far: what all others add.
    """

    def __init__(
        self,
        goal: Vector,
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
        self._peers_gamma = far.gamma  # m^2, gamma without the own share
        for peer in peers:
            self._peers_gamma += peer.gamma

    def __call__(self, x: float, y: float) -> Vector:
        """D_i at (x, y), m."""
        found = self.gradient(x, y)
        return found.dx, found.dy

    def gradient(self, x: float, y: float) -> Gradient:
        """D_i and its Jacobian at (x, y), in one pass."""
        far = self._far
        px, py = x - far.x, y - far.y
        log_x = far.log_x + far.xx * px + far.xy * py
        log_y = far.log_y + far.xy * px + far.yy * py
        trace, xx, xy, yy = 0.0, far.xx, far.xy, far.yy  # second derivatives of half log beta
        for peer in self._peers:
            dx = x - peer.x
            dy = y - peer.y
            rho = self._radius + peer.radius
            contact = rho * rho
            square = dx * dx + dy * dy
            if square > contact * _LIMIT:
                inverse = 1.0 / (square - contact)
                slope = -2.0 * inverse * inverse
            else:
                inverse, slope = _beyond(square - contact, contact * _LIMIT - contact)
                slope *= 2.0
            log_x += dx * inverse
            log_y += dy * inverse
            trace += inverse
            xx += slope * dx * dx
            xy += slope * dx * dy
            yy += slope * dy * dy
        inverse, slope = self._edge_inverse(x, y)
        slope *= 2.0
        log_x -= x * inverse
        log_y -= y * inverse
        xx += slope * x * x + trace - inverse
        xy += slope * x * y
        yy += slope * y * y + trace - inverse
        ex = x - self.goal[0]
        ey = y - self.goal[1]
        share = (self._peers_gamma + ex * ex + ey * ey) * self._inverse_k
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
        """|D_i| at (x, y), m, for the common pace."""
        return math.hypot(*self(x, y))

    def _edge_inverse(self, x: float, y: float) -> Vector:
        """1/beta_0i and its derivative with respect to beta_0i."""
        beta = self._edge - x * x - y * y
        if beta > CONTACT * self._edge:
            inverse = 1.0 / beta
            return inverse, -inverse * inverse
        return _beyond(beta, CONTACT * self._edge)


def _beyond(beta: float, contact: float) -> Vector:
    """The tangent of 1/beta at beta = contact, evaluated at `beta`, and its slope."""
    return (2.0 - beta / contact) / contact, -1.0 / (contact * contact)


def boundary_radius(room: Shape) -> float:
    """Radius of the boundary in beta_0i, m."""
    if isinstance(room, Disk):
        return room.radius
    (left, low), (right, high) = room.box
    return _REMOTE * max(-left, -low, right, high, right - left, high - low)
