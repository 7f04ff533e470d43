"""Figure 3 of Karagöz, Bozma, Koditschek, demonstrations with its goals, and random scenarios."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import repeat
from pathlib import Path

import numpy as np

from protocol.arrays import Reals
from protocol.draws import Purpose, generator
from protocol.errors import UsageError
from protocol.scenario.file import read_document
from protocol.scenario.model import (
    Control,
    Part,
    Position,
    ProcessFault,
    RobotSpec,
    Scenario,
    Time,
    Workspace,
)
from protocol.scenario.network import Link

RADIUS = 0.04  # m
WORKSPACE = 0.30  # m
GAIN = 60.0  # the paper's k


def numbered(
    radii: Iterable[float], starts: Iterable[Position], goals: Iterable[Position]
) -> tuple[RobotSpec, ...]:
    """Robots 1, 2, ... with these radii, starts and goals, m."""
    ends = zip(radii, zip(starts, goals, strict=True), strict=False)
    return tuple(RobotSpec(n, radius, *each) for n, (radius, each) in enumerate(ends, 1))


_SETS = read_document(Path(__file__).with_name("goal-sets.toml"))
GOAL_SETS: dict[str, tuple[Position, ...]] = {
    letter: tuple((x, y) for x, y in each["goals"]) for letter, each in _SETS.items()
}
TIGHTNESS: dict[str, float] = {letter: each["tight"] for letter, each in _SETS.items()}  # by the paper


def figure_3(letter: str, seed: int = 0) -> Scenario:
    """Goal set `letter` ("a" to "e", else UsageError) with random starts by seed."""
    if letter not in GOAL_SETS:
        raise UsageError(f"no goal set {letter!r}; there are {', '.join(GOAL_SETS)}")
    starts = random_starts([RADIUS] * 6, WORKSPACE, seed)
    text = f"six robots, goal set {letter} of tightness {TIGHTNESS[letter]:.2f}, random starts"
    robots = numbered(repeat(RADIUS), starts, GOAL_SETS[letter])
    control = Control(k=GAIN)
    return Scenario(robots, f"figure-3{letter}", text, seed, Workspace(WORKSPACE), control=control)


def delay_6(seed: int = 0) -> Scenario:
    """Figure 3d with States up to 0.3 s late, out of order, and 10 % lost."""
    return replace(
        figure_3("d", seed),
        name="delay-6",
        description="figure-3d with states delayed by 0 to 0.3 s, 10 % of them lost",
        link=Link(delay=(0.0, 0.3), loss=0.1),
    )


def crash(seed: int = 0) -> Scenario:
    """Figure 3c with a crash of robot 3, whose process is restarted."""
    return replace(
        figure_3("c", seed),
        name="crash",
        description="figure-3c; robot 3 is killed at 1 s and started again at 3 s",
        process=(ProcessFault(3, 1.0, "kill"), ProcessFault(3, 3.0, "restart")),
    )


PAPER_DENSITY = 6 * RADIUS**2 / WORKSPACE**2  # area of all disks over that of the workspace
LARGEST_DENSITY = 0.35
LARGEST_UNEQUAL = 0.5
_DARTS = 200  # attempts per disk, before disks are pushed apart
_GAP = 0.1  # free space around each disk, in its radii; at least half of it remains after relaxation
_SWEEPS = 2000
_ATTEMPTS = 50


def random_starts(radii: Sequence[float], workspace: float, seed: int, stream: int = 0) -> list[Position]:
    """Random centres of disks of `radii` (m) in a round workspace (radius, m), without overlap.

    Args:
        seed, stream: key of the draw; each stream of a seed is an independent configuration.

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
    """Random starts and goals of `count` robots. The size of the workspace follows from `density`; the time
    limit is three times the time of the way across, or the default if that is longer.

    Args:
        density: area of all disks over that of the workspace, at most `LARGEST_DENSITY`.
        unequal: radii are drawn from [1 - unequal, 1 + unequal] times 0.04 m, at most `LARGEST_UNEQUAL`.

    Raises:
        UsageError: no such instance can be drawn.
    """
    if not 0.0 < density <= LARGEST_DENSITY:
        raise UsageError(f"density {density:g}: choose above 0, at most {LARGEST_DENSITY}")
    if not 0.0 <= unequal <= LARGEST_UNEQUAL:
        raise UsageError(f"unequal {unequal:g}: choose between 0 and {LARGEST_UNEQUAL}")
    spread = generator(seed, Purpose.SCENARIO, 2).uniform(-unequal, unequal, count)
    radii = [round(RADIUS * (1.0 + float(part)), 4) for part in spread]
    workspace = workspace_for(radii, density)
    robots = random_robots(radii, workspace, seed)
    text = f"{count} robots, random starts and goals, density {density:.3g}"
    across = 2.0 * workspace / Control().speed
    time = Time(limit=max(Time().limit, math.ceil(3.0 * across)))
    return Scenario(robots, name or f"random-{count}", text, seed, Workspace(workspace), time)


def in_turn(count: int, seed: int = 0) -> Scenario:
    """Robots of which only one moves at a time, each for a second."""
    drawn = random_instance(count, seed, density=0.1, name=f"in-turn-{count}")
    turns = replace(drawn.control, turn=1.0).without("escape")
    text = f"{count} robots of which one moves at a time, for a second each"
    limit = replace(drawn.time, limit=60.0 * count, deadlock=20.0 * count)
    return replace(drawn, description=text, control=turns, time=limit)


def random_robots(radii: Sequence[float], workspace: float, seed: int) -> tuple[RobotSpec, ...]:
    """Robots with random starts and goals; arguments and errors as of `random_starts`."""
    return numbered(radii, *(random_starts(radii, workspace, seed, stream) for stream in (0, 1)))


def workspace_for(radii: Sequence[float], density: float) -> float:
    """Radius of a workspace in which disks have this density, m; the two largest fit in side by side."""
    filled = float(np.sqrt((np.array(radii) ** 2).sum() / density))
    return round(max(filled, (1.0 + 2.0 * _GAP) * sum(sorted(radii)[-2:])) + 5e-7, 6)


def _thrown(random: np.random.Generator, radii: Reals, workspace: float) -> Reals:
    """Uniform random centres, large disks first, each with at most `_DARTS` draws until it is free."""
    points = np.zeros((len(radii), 2))
    placed: list[int] = []
    for i in np.argsort(-radii, kind="stable"):
        apart = (radii[placed] + radii[i]) * (1.0 + _GAP)
        for _ in range(_DARTS):
            angle = random.uniform(0.0, 2.0 * np.pi)
            reach = (workspace - radii[i] * (1.0 + _GAP)) * np.sqrt(random.uniform())
            points[i] = reach * np.cos(angle), reach * np.sin(angle)
            if (((points[placed] - points[i]) ** 2).sum(axis=1) > apart**2).all():
                break
        placed.append(int(i))
    return points


def _relaxed(points: Reals, radii: Reals, workspace: float) -> Reals | None:
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
_ROBOT, _PART = 0.03, 0.035  # m, radii; a robot's disk grows with a part


def parts(count: int, seed: int = 0, robots: int = 3, density: float = DENSITY) -> Scenario:
    """Random parts with random goals, and robots that carry them, at this density.

    Robots end at their starts. No part's goal overlaps a robot's.
    """
    radii = [_ROBOT] * robots + [_PART] * count
    workspace = workspace_for(radii, density)
    starts = random_starts(radii, workspace, seed, 0)
    goals = _goals(radii, workspace, seed, starts[:robots])
    return Scenario(
        tuple(RobotSpec(n + 1, _ROBOT, starts[n], starts[n]) for n in range(robots)),
        f"parts-{count}",
        f"{robots} robots bring {count} parts to their goals, density {density:.3g}",
        seed,
        Workspace(workspace),
        Time(limit=600.0, deadlock=60.0),
        parts=tuple(Part(_PART, starts[robots + n], goals[n]) for n in range(count)),
    )


def _goals(
    radii: list[float], workspace: float, seed: int, homes: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Random goals of parts, apart from each other and from the robots' starts, m."""
    robots = len(homes)
    for stream in range(1, 10_000):
        drawn = random_starts(radii, workspace, seed, stream)[robots:]
        if all(math.dist(goal, home) >= 1.1 * (radii[0] + radii[robots]) for goal in drawn for home in homes):
            return drawn
    raise UsageError("no room for the goals of parts")
