"""The safety filter as a function, for other simulators: positions, radii, wishes in, velocities out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from protocol.arrays import Reals
from protocol.errors import UsageError

_ROUNDS = 8  # projections onto all half-planes; scaling removes the rest
_ROOM = 1e-9  # m, allowance for rounding
_TINY = np.finfo(np.float64).tiny


def filtered(
    positions: ArrayLike,
    radii: ArrayLike,
    wishes: ArrayLike,
    *,
    period: float,
    speed: float = np.inf,
    workspace: float | None = None,
) -> Reals:
    """Velocities near the desired ones, with which no two disks touch within a period if all follow theirs,
    or any part of them.

    Each pair has the separating line in the middle of its gap, and each disk stays behind its lines: the
    filter of the fleet for robots with exact and immediate information.

    Args:
        positions: of centres, m, (..., n, 2); leading axes count worlds.
        radii: m, (n,) or (..., n).
        wishes: desired velocities, m/s, shaped as positions.
        period: time for which the velocities are kept, s.
        speed: limit, m/s.
        workspace: radius of a disk around the origin that no disk leaves, m; none by default.

    Returns:
        Velocities, m/s, shaped as positions. Overlapping disks come no closer, those outside move no farther
        out.

    Raises:
        UsageError: a shape does not match, or a number is not finite or not positive.
    """
    at, wish = np.asarray(positions, dtype=np.float64), np.asarray(wishes, dtype=np.float64)
    size = np.asarray(radii, dtype=np.float64)
    if at.shape[-1:] != (2,) or at.ndim < 2 or wish.shape != at.shape:
        raise UsageError(f"positions {at.shape} and wishes {wish.shape} must both be (..., n, 2)")
    if size.shape not in (at.shape[:-1], at.shape[-2:-1]):
        raise UsageError(f"radii {size.shape} must be (n,) or (..., n) of positions {at.shape}")
    if not (
        np.isfinite(at).all() and np.isfinite(wish).all() and (size > 0.0).all() and np.isfinite(size).all()
    ):
        raise UsageError("positions and wishes must be finite, radii finite and positive")
    if not (0.0 < period < np.inf and speed > 0.0 and (workspace is None or 0.0 < workspace < np.inf)):
        raise UsageError("period and workspace must be finite and positive, speed positive")
    normals, limits = _half_planes(at, np.broadcast_to(size, at.shape[:-1]), period, workspace)
    velocity = _slowed(wish, speed)
    for _ in range(_ROUNDS):
        for each in range(normals.shape[-2]):
            normal = normals[..., each, :]
            beyond = np.maximum((normal * velocity).sum(axis=-1) - limits[..., each], 0.0)
            velocity = velocity - beyond[..., None] * normal
    velocity = _slowed(velocity, speed)
    along = (normals * velocity[..., None, :]).sum(axis=-1)  # (..., n, m)
    exceeded = along > limits
    share = np.where(exceeded, limits, 1.0) / np.where(exceeded, along, 1.0)
    velocity = velocity * np.clip(share.min(axis=-1, initial=1.0), 0.0, 1.0)[..., None]
    return velocity if workspace is None else _inside(at, velocity, workspace - size - _ROOM, period)


def _inside(at: Reals, velocity: Reals, room: Reals, period: float) -> Reals:
    """The velocities, shortened so that each centre is within `room` (m) of the origin after a period, or no
    farther from it than before."""
    step = period * velocity
    along, square = (at * step).sum(axis=-1), (step * step).sum(axis=-1)
    left = np.maximum(room * room * np.sign(room) - (at * at).sum(axis=-1), 0.0)
    chord = np.sqrt(along * along + square * left) - along
    inside: Reals = velocity * np.clip(chord / np.maximum(square, _TINY), 0.0, 1.0)[..., None]
    return inside


def _half_planes(at: Reals, radii: Reals, period: float, workspace: float | None) -> tuple[Reals, Reals]:
    """Of every disk: normals (..., n, m, 2), and the greatest speed along each, m/s."""
    offsets = at[..., None, :, :] - at[..., :, None, :]
    distance = np.hypot(offsets[..., 0], offsets[..., 1])
    gap = distance - radii[..., None, :] - radii[..., :, None]
    own = np.eye(at.shape[-2], dtype=bool)
    normals = offsets / np.where(distance > 0.0, distance, 1.0)[..., None]
    limits = np.where(own, np.inf, np.maximum(0.5 * gap - _ROOM, 0.0) / period)
    if workspace is not None:
        out = np.hypot(at[..., 0], at[..., 1])
        room = np.maximum(workspace - radii - out - _ROOM, 0.0) / period
        normal = at / np.where(out > 0.0, out, 1.0)[..., None]
        normals = np.concatenate([normals, normal[..., None, :]], axis=-2)
        limits = np.concatenate([limits, room[..., None]], axis=-1)
    return normals, limits


def _slowed(velocity: Reals, speed: float) -> Reals:
    size = np.hypot(velocity[..., 0], velocity[..., 1])
    slowed: Reals = velocity * np.minimum(1.0, speed / np.maximum(size, _TINY))[..., None]
    return slowed
