"""Rosters: who is there, and who may appear."""

from __future__ import annotations

from tests.agents.lines.models.mutants.mutant import Mutant
from tests.agents.lines.models.small_model import Bounds
from tests.interpreted import Edit

_BOND = "agents.lines.robot_pair"
_DISK = "agents.lines.tangent"
_LEDGER = "agents.lines.separating_lines"
_ROLL = "world.coordinator.roster"
_ROSTER = "agents.peers.roster"

WHO_IS_THERE = (
    Mutant(
        "founding-only",
        "only a life that began the run knows the initial lines",
        (Edit(_ROSTER, "own.founding == self._incarnation > 0", "own.founding > 0"),),
    ),
    Mutant(
        "late-lives-are-newcomers",
        "whoever was not there when the run began is no founding life when it comes",
        (
            Edit(
                _ROLL,
                'self._put(replace(member, incarnation=incarnation, status="live", position=None, '
                "bound=0.0))",
                'self._put(replace(member, incarnation=incarnation, status="live", position=None, '
                "bound=0.0, founding=member.founding or incarnation))",
            ),
        ),
    ),
    Mutant(
        "newer-lives-only",
        "only a life with a new number is admitted",
        (Edit(_ROLL, "if incarnation <= member.incarnation:", "if False:"),),
    ),
    Mutant(
        "acknowledge-before-appearing",
        "a disk appears only after every live robot has acknowledged the version that announces it",
        (Edit(_ROLL, "                and self.all_keep_clear()\n", ""),),
    ),
    Mutant(
        "admission-is-no-acknowledgement",
        "to be admitted with that version is no acknowledgement: the life may begin on the place",
        (
            Edit(
                _ROLL,
                "position=None, bound=0.0))\n\n    def fence",
                "position=None, bound=0.0))\n"
                "        self._kept[robot] = (incarnation, self.version)\n"
                "\n"
                "    def fence",
            ),
        ),
    ),
    Mutant(
        "acknowledge-the-newest",
        "an acknowledgement of an earlier version is none of this one",
        (
            Edit(
                _ROLL,
                "            self._kept.get(each.robot) == (each.incarnation, self.version)\n            for",
                "            self._kept.get(each.robot, (0, 0))[0] == each.incarnation\n            for",
            ),
        ),
    ),
    Mutant(
        "acknowledge-when-clear",
        "a robot acknowledges only what it keeps clear of, by a tangent",
        (Edit(_LEDGER, "return not self._disturbed or all(", "return True or all("),),
    ),
    Mutant(
        "appear-where-nothing-stands",
        "a disk appears only where no disk stands",
        (Edit(_ROLL, " and self._is_free(member)", ""),),
    ),
    Mutant(
        "appear-as-standing",
        "what has appeared stands, for whoever is admitted later",
        (
            Edit(
                _ROLL,
                'self._put(replace(member, status="standing"))',
                'self._put(replace(member, status="appearing", position=(9.0, 9.0)))',
            ),
        ),
    ),
    Mutant(
        "gone-after-fenced",
        "only what stands can be struck off",
        (
            Edit(
                _ROLL,
                '        if member.status != "standing":\n'
                '            raise RosterError(f"robot {robot} cannot be removed',
                '        if False:\n            raise RosterError(f"robot {robot} cannot be removed',
            ),
        ),
    ),
    Mutant(
        "older-versions-ignored",
        "a robot never follows a version older than one that it knows",
        (Edit(_ROSTER, "if roster.version <= self.version:", "if roster.version == self.version:"),),
    ),
    Mutant(
        "heard-life-is-not-excused",
        "a version that is older than a life already heard excuses nobody",
        (Edit(_BOND, "if member.incarnation < self.heard:", "if False:"),),
        model="pair",
        bounds=Bounds(lives=(1, 2), proposals=1, fences=1),
    ),
    Mutant(
        "standing-is-there",
        "a standing disk is behind a tangent, or the robot stands still",
        (Edit(_BOND, 'self.excused = member.status == "appearing"', "self.excused = True"),),
    ),
    Mutant(
        "tangent-when-clear",
        "a tangent is taken only if the own disk satisfies it",
        (Edit(_DISK, "if own.satisfies(tangent):", "if True:"),),
    ),
    Mutant(
        "standing-behind-the-line",
        "a line stays in the place of the tangent only if the disk stands behind it",
        (Edit(_DISK, "if shape.limit(side.nx, side.ny, own_radius) >= side.limit:", "if True:"),),
    ),
    Mutant(
        "line-replaces-standing-when-agreed",
        "a standing place counts until a line with the new life is agreed",
        (
            Edit(
                _BOND,
                "        if self.end.agreed:\n            self.disk = None\n",
                "        if self.end.obeyed:\n            self.disk = None\n",
            ),
            Edit(
                _BOND,
                "return self.excused or self.end.agreed or self.keeps_clear",
                "return self.excused or bool(self.end.obeyed) or self.keeps_clear",
            ),
        ),
    ),
    Mutant(
        "standing-life-is-over",
        "of a life that stands nothing counts any more, whatever it says",
        (Edit(_BOND, "        self.end.fence(incarnation)\n", "        self.end.fence(incarnation - 1)\n"),),
    ),
    Mutant(
        "save-before-telling",
        "the coordinator writes down what it decided before it tells anybody",
        saved=False,
    ),
)
