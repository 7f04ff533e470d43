"""Walls, and things that come and go."""

from __future__ import annotations

from tests.agents.lines.models.mutants.mutant import Mutant
from tests.interpreted import Edit

_BOUNDARY = "agents.lines.boundary"
_DISK = "agents.lines.tangent"
_FILTER = "agents.safety_filter"
_LIVES = "world.coordinator.lives"
_THINGS = "agents.lines.things"

SURROUNDINGS = (
    Mutant(
        "things-before-moving",
        "a robot moves only while it is behind a tangent to everything that stands",
        (
            Edit(
                _FILTER,
                "return self.lines.ready and self.things.ready",
                "return self.lines.ready",
            ),
        ),
        model="skirmish",
        first=435,
    ),
    Mutant(
        "start-of-founders",
        "only a founding life knows that its disk is where the scenario lets it begin",
        (Edit(_FILTER, "starts[robot] if founding else None", "starts[robot]"),),
        model="skirmish",
        first=207,
    ),
    Mutant(
        "own-error-at-things",
        "every place where the own centre can be keeps clear of things",
        (Edit(_THINGS, "found.append(own.kept_in(side.nx, side.ny, side.limit))", "found.append(side)"),),
        model="skirmish",
    ),
    Mutant(
        "own-error-at-straight-walls",
        "and of straight walls",
        (Edit(_BOUNDARY, "wall.slack(x, y) - extent - 2.0 * ROUNDING", "wall.slack(x, y)"),),
        model="skirmish",
    ),
    Mutant(
        "acknowledge-things-when-clear",
        "a version that announces a thing is acknowledged only by who is clear of its place",
        (
            Edit(
                _FILTER,
                "(self.lines.keeps_clear and self.things.keeps_clear)",
                "self.lines.keeps_clear",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "things-appear-when-acknowledged",
        "a thing is put up only when everybody live has acknowledged its place",
        (
            Edit(
                _LIVES,
                "if not self.things.appearing or not self._roster.all_keep_clear():",
                "if not self.things.appearing:",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "things-appear-beside-standing-disks",
        "and not where the disk of a life that is over stands",
        (Edit(_LIVES, "settled = self.things.settle(disks)", "settled = self.things.settle([])"),),
        model="skirmish",
    ),
    Mutant(
        "nearest-point",
        "a tangent touches the thing itself: one through its middle leaves half of it on the own side",
        (
            Edit(
                _DISK,
                "HalfPlane(nx, ny, target.limit(nx, ny, self.radius))",
                "HalfPlane(nx, ny, nx * around.x + ny * around.y - self.radius)",
            ),
        ),
        model="skirmish",
    ),
)
