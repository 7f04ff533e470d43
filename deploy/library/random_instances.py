"""Random configurations: where disks and parts may be in a workspace, drawn from a seed. Always succeeds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from protocol.draws import Purpose, generator
from protocol.errors import UsageError
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Part, Point, RobotSpec, Scenario, Time, Workspace

Array = NDArray[np.float64]

RADIUS = 0.04  # m
PAPER_DENSITY = 6 * 0.04**2 / 0.30**2  # area of all disks over that of the workspace
LARGEST_DENSITY = 0.35
LARGEST_UNEQUAL = 0.5
_DARTS = 200  # attempts per disk before the disks are pushed apart instead
_GAP = 0.1  # free space around each disk, in its radii; at least half of it remains after relaxation
_SWEEPS = 2000
_ATTEMPTS = 50


def random_starts(radii: Sequence[float], workspace: float, seed: int, stream: int = 0) -> list[Point]:
    """Centres of disks of `radii` (m) in a workspace of this radius (m), apart from each other, uniform.

    Args:
        seed, stream: what the draw is keyed by; each stream of a seed is a configuration of its own.

    Raises:
        UsageError: the disks fill more than `LARGEST_DENSITY` of the workspace.
    """
    sizes = np.array(radii, dtype=np.float64)
    density = float((sizes**2).sum()) / workspace**2
    if density > LARGEST_DENSITY + 1e-9 or (1.0 + _GAP) * sizes.max() > workspace:
        raise UsageError(
            f"{len(sizes)} disks fill {density:.2f} of the workspace; at most {LARGEST_DENSITY} can be drawn"
        )
    random = generator(seed, Purpose.SCENARIO, stream)
    for _ in range(_ATTEMPTS):
        points = _relaxed(_thrown(random, sizes, workspace), sizes, workspace)
        if points is not None:
            return [(round(float(x), 6), round(float(y), 6)) for x, y in points]
    raise UsageError(f"{len(sizes)} disks do not fit into a workspace of {workspace:g} m with room to move")


def random_instance(
    count: int, seed: int, *, density: float = PAPER_DENSITY, unequal: float = 0.0, name: str | None = None
) -> Scenario:
    """Random starts and goals for `count` robots; the workspace is as large as `density` asks for, the time
    limit three times as long as the way across it takes, or that of all scenarios.

    Args:
        density: area of all disks over that of the workspace, at most `LARGEST_DENSITY`.
        unequal: radii are drawn from [1 - unequal, 1 + unequal] times 0.04 m, at most `LARGEST_UNEQUAL`.

    Raises:
        UsageError: no such instance can be drawn.
    """
    if not 1 <= count <= 1000:
        raise UsageError(f"{count} robots: choose between 1 and 1000")
    if not 0.0 < density <= LARGEST_DENSITY:
        raise UsageError(f"density {density:g}: choose above 0, at most {LARGEST_DENSITY}")
    if not 0.0 <= unequal <= LARGEST_UNEQUAL:
        raise UsageError(f"unequal {unequal:g}: choose between 0 and {LARGEST_UNEQUAL}")
    spread = generator(seed, Purpose.SCENARIO, 2).uniform(-unequal, unequal, count)
    radii = [round(RADIUS * (1.0 + float(part)), 4) for part in spread]
    workspace = float(np.sqrt((np.array(radii) ** 2).sum() / density))
    # A disk and the gap around it must fit, however few disks there are.
    workspace = round(max(workspace, _room(radii)) + 5e-7, 6)
    starts, goals = (random_starts(radii, workspace, seed, stream) for stream in (0, 1))
    robots = tuple(
        RobotSpec(n + 1, radius, start, goal)
        for n, (radius, start, goal) in enumerate(zip(radii, starts, goals, strict=True))
    )
    text = f"{count} robots, random starts and goals, density {density:.3g}"
    across = 2.0 * workspace / Control().speed
    time = Time(limit=max(Time().limit, math.ceil(3.0 * across)))
    return validated(Scenario(robots, name or f"random-{count}", text, seed, Workspace(workspace), time))


def in_turn(count: int, seed: int = 0) -> Scenario:
    """Robots of which only one moves at a time, each for a second, while the others stand."""
    drawn = random_instance(count, seed, density=0.1, name=f"in-turn-{count}")
    turns = replace(drawn.control, turn=1.0).without("escape")
    text = f"{count} robots of which one moves at a time, for a second each"
    limit = replace(drawn.time, limit=60.0 * count, deadlock=20.0 * count)
    return replace(drawn, description=text, control=turns, time=limit)


def _room(radii: Sequence[float]) -> float:
    """Radius of a workspace that surely holds the largest disk, or the two largest side by side, m."""
    return (1.0 + 2.0 * _GAP) * sum(sorted(radii)[-2:])


def _thrown(random: np.random.Generator, radii: Array, workspace: float) -> Array:
    """Darts: uniform centres, large disks first; one that hits another is thrown again, so many times."""
    points = np.zeros((len(radii), 2))
    placed: list[int] = []
    for i in np.argsort(-radii, kind="stable"):
        apart = (radii[placed] + radii[i]) * (1.0 + _GAP)
        for _ in range(_DARTS):
            points[i] = _uniform(random, workspace - radii[i] * (1.0 + _GAP))
            if (((points[placed] - points[i]) ** 2).sum(axis=1) > apart**2).all():
                break
        placed.append(int(i))
    return points


def _uniform(random: np.random.Generator, radius: float) -> Array:
    """A point uniform in a disk around the origin."""
    angle, reach = random.uniform(0.0, 2.0 * np.pi), radius * np.sqrt(random.uniform())
    return np.array([reach * np.cos(angle), reach * np.sin(angle)])


def _relaxed(points: Array, radii: Array, workspace: float) -> Array | None:
    """Push apart what is too close until nothing is; None if that does not come to an end."""
    apart = (radii[:, None] + radii[None, :]) * (1.0 + _GAP)
    np.fill_diagonal(apart, 0.0)
    enough = apart * (1.0 + 0.5 * _GAP) / (1.0 + _GAP)
    limit = workspace - radii * (1.0 + _GAP)
    for _ in range(_SWEEPS):
        between = points[:, None, :] - points[None, :, :]
        distance = np.sqrt((between**2).sum(axis=2))
        np.fill_diagonal(distance, np.inf)
        if (distance >= enough).all():
            return points
        push = np.maximum(apart - distance, 0.0) / (2.0 * np.maximum(distance, 1e-9))
        points = points + (push[:, :, None] * between).sum(axis=1)
        length = np.sqrt((points**2).sum(axis=1))
        points *= np.minimum(1.0, limit / np.maximum(length, 1e-9))[:, None]
    return None


DENSITY = 0.2  # area of all disks over that of the workspace
_ROBOT, _PART = 0.03, 0.035  # m, radii: a robot grows when it takes up a part
_MOST = 40


def parts(count: int, seed: int = 0, robots: int = 3, density: float = DENSITY) -> Scenario:
    """Random parts with random goals, and robots that carry them, at this density.

    Robots end where they begin. No part's goal overlaps a robot's.

    Raises:
        UsageError: `count` is none of 1 to 40.
    """
    if not 1 <= count <= _MOST:
        raise UsageError(f"{count} parts: choose between 1 and {_MOST}")
    radii = [_ROBOT] * robots + [_PART] * count
    workspace = round(math.sqrt(sum(radius**2 for radius in radii) / density) + 5e-7, 6)
    starts = random_starts(radii, workspace, seed, 0)
    goals = _goals(radii, workspace, seed, starts[:robots])
    return validated(
        Scenario(
            tuple(RobotSpec(n + 1, _ROBOT, starts[n], starts[n]) for n in range(robots)),
            f"parts-{count}",
            f"{robots} robots bring {count} parts to their goals, density {density:.3g}",
            seed,
            Workspace(workspace),
            Time(limit=600.0, deadlock=60.0),
            parts=tuple(Part(_PART, starts[robots + n], goals[n]) for n in range(count)),
        )
    )


def _goals(
    radii: list[float], workspace: float, seed: int, homes: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Goals of parts, apart from each other and from where robots are at home, m."""
    robots = len(homes)
    for stream in range(1, 10_000):
        drawn = random_starts(radii, workspace, seed, stream)[robots:]
        if all(math.dist(goal, home) >= 1.1 * (radii[0] + radii[robots]) for goal in drawn for home in homes):
            return drawn
    raise UsageError("no room for the goals of parts")
