"""The product without one rule of the pair protocol each; the reading of its source has to tell them apart."""
# ruff: noqa: E501

from __future__ import annotations

from tests.interpreted import Edit
from tests.proof.pair.source import ENDS, KNOWN, LEDGER, NEAR, PAIR_OF_ONE, ROSTER, TANGENT

MUTANTS: tuple[tuple[str, *tuple[Edit, ...]], ...] = (
    (
        "an owner proposes only a line that its own disk satisfies now",
        Edit(NEAR, "if line is None or not fits(line):", "if line is None:"),
    ),
    (
        "an owner obeys a proposal from the moment when it makes it",
        Edit(
            ENDS,
            "return (*self._inherited, *held, *self.proposed.values())",
            "return (*self._inherited, *held)",
        ),
    ),
    (
        "until there is an answer it obeys what it held, too",
        Edit(ENDS, "        self.number += 1\n", "        self.number += 1\n        self.held = None\n"),
    ),
    (
        "it drops a proposal only when an answer says that this number has been answered",
        Edit(ENDS, "for number, line in self.proposed.items() if number > seen}", "for number, line in ()}"),
    ),
    (
        "of the lines that were answered it goes on obeying the one that the follower holds",
        Edit(ENDS, "if held in self.proposed:", "if seen in self.proposed:\n            held = seen"),
    ),
    (
        "a follower adopts only a line that its own disk satisfies now",
        Edit(ENDS, "if not fits(line):", "if False:"),
    ),
    (
        "a number that was answered, or passed over, is never adopted later",
        Edit(ENDS, "or number <= self.seen:\n", "or number == self.held_number:\n"),
    ),
    (
        "a number that was rejected is never adopted later, though the own disk may satisfy it then",
        Edit(ENDS, "or number <= self.seen:\n", "or number <= self.held_number:\n"),
    ),
    (
        "a robot moves only while every peer that is there is behind a line or a tangent",
        Edit(LEDGER, "if not (pair.settled or pair.ready):", "if False:"),
    ),
    (
        "an answer counts only for the life of the owner that it names",
        Edit(
            ENDS,
            "            or incarnation != self.incarnation\n            or not self.seen",
            "            or not self.seen",
        ),
    ),
    (
        "a proposal counts only for the life of the follower that it names",
        Edit(ENDS, "or incarnation != self.incarnation or number <= self.seen:", "or number <= self.seen:"),
    ),
    (
        "an owner ignores lives of the follower that are older than the newest known",
        Edit(
            ENDS,
            "            not self.accept(peer_incarnation)\n            or incarnation",
            "            incarnation",
        ),
        Edit(
            PAIR_OF_ONE,
            "            if not self.end.accept(state.incarnation):\n                return False\n",
            "            self.end.accept(state.incarnation)\n",
        ),
    ),
    (
        "a follower ignores lives of the owner that are older than the newest known",
        Edit(
            ENDS,
            "if not self.accept(peer_incarnation) or incarnation != self.incarnation or number",
            "if incarnation != self.incarnation or number",
        ),
        Edit(
            PAIR_OF_ONE,
            "            if not self.end.accept(state.incarnation):\n                return False\n",
            "            self.end.accept(state.incarnation)\n",
        ),
    ),
    (
        "either end ignores lives of the other that are older than the one that a roster names",
        Edit(PAIR_OF_ONE, "if incarnation > self.end.peer_incarnation:", "if False:"),
    ),
    (
        "so it is with the first roster that a life hears",
        Edit(LEDGER, 'if member.status != "live" or not founding:', 'if member.status != "live":'),
    ),
    (
        "which of two lives is the newer one follows from their numbers, not from who was heard last",
        Edit(
            ENDS,
            "        if peer_incarnation > self.peer_incarnation:\n            self.linked",
            "        if peer_incarnation != self.peer_incarnation:\n            self.linked",
        ),
    ),
    (
        "a follower counts the numbers of each life of the owner by themselves",
        Edit(ENDS, "            self.held_number = self.seen = 0\n", ""),
    ),
    (
        "an owner whose follower lives anew goes on obeying the line that was held",
        Edit(ENDS, "self._inherited = self.obeyed\n", "self._inherited = tuple(self.proposed.values())\n"),
    ),
    (
        "and every unanswered proposal: it may have been adopted in the moment of death",
        Edit(ENDS, "self._inherited = self.obeyed\n", "self._inherited = self.obeyed[:1]\n"),
    ),
    (
        "a proposal that no life is known to have adopted is no line: the peer may have moved past it",
        Edit(
            ENDS,
            "        self.proposed[self.number] = line\n",
            "        self.proposed[self.number] = line\n        self.agreed = True\n",
        ),
    ),
    (
        "nothing is offered to a life that has not been heard",
        Edit(NEAR, "if not end.met or len(end.proposed)", "if len(end.proposed)"),
        Edit(
            NEAR,
            "        if state is None or not state.placed:\n            return 0\n",
            "        if state is None:\n            state = PeerState(pair.peer, 0, 0, True, 0.0, float(pair.peer), 0.0, 0.0, 0.0, 0.0, 0.0, radius=0.0)\n",
        ),
    ),
    (
        "a follower whose owner lives anew goes on obeying the line that it holds",
        Edit(
            ENDS,
            "            self.held_number = self.seen = 0\n",
            "            self.held_number = self.seen = 0\n            self._held = None\n",
        ),
        Edit(
            ENDS,
            "        return self._held is not None\n\n    @property\n    def settled",
            "        return True\n\n    @property\n    def settled",
        ),
    ),
    (
        "only a life that began the run knows the initial lines",
        Edit(KNOWN, "own.founding == self._incarnation > 0", "own.founding > 0"),
    ),
    (
        "whoever was not there when the run began is no founding life when it comes",
        Edit(
            ROSTER,
            'self._put(replace(member, incarnation=incarnation, status="live", position=None, bound=0.0))',
            'self._put(replace(member, incarnation=incarnation, status="live", position=None, bound=0.0, founding=member.founding or incarnation))',
        ),
    ),
    (
        "only a life with a new number is admitted",
        Edit(ROSTER, "if incarnation <= member.incarnation:", "if False:"),
    ),
    (
        "a disk appears only after every live robot has acknowledged the version that announces it",
        Edit(ROSTER, "                and self.all_keep_clear()\n", ""),
    ),
    (
        "to be admitted with that version is no acknowledgement: the life may begin on the place",
        Edit(
            ROSTER,
            "position=None, bound=0.0))\n\n    def fence",
            "position=None, bound=0.0))\n        self._kept[robot] = (incarnation, self.version)\n\n    def fence",
        ),
    ),
    (
        "an acknowledgement of an earlier version is none of this one",
        Edit(
            ROSTER,
            "            self._kept.get(each.robot) == (each.incarnation, self.version)\n            for",
            "            self._kept.get(each.robot, (0, 0))[0] == each.incarnation\n            for",
        ),
    ),
    (
        "a robot acknowledges only what it keeps clear of, by a tangent",
        Edit(LEDGER, "return not self._disturbed or all(", "return True or all("),
    ),
    (
        "a disk appears only where no disk stands",
        Edit(ROSTER, " and self._is_free(member)", ""),
    ),
    (
        "what has appeared stands, for whoever is admitted later",
        Edit(
            ROSTER,
            'self._put(replace(member, status="standing"))',
            'self._put(replace(member, status="appearing", position=(9.0, 9.0)))',
        ),
    ),
    (
        "only what stands can be struck off",
        Edit(
            ROSTER,
            '        if member.status != "standing":\n            raise RosterError(f"robot {robot} cannot be removed',
            '        if False:\n            raise RosterError(f"robot {robot} cannot be removed',
        ),
    ),
    (
        "a robot never follows a version older than one that it knows",
        Edit(KNOWN, "if roster.version <= self.version:", "if roster.version == self.version:"),
    ),
    (
        "a version that is older than a life already heard excuses nobody",
        Edit(PAIR_OF_ONE, "if member.incarnation < self.heard:", "if False:"),
    ),
    (
        "a standing disk is behind a tangent, or the robot stands still",
        Edit(PAIR_OF_ONE, 'self.excused = member.status == "appearing"', "self.excused = True"),
    ),
    (
        "a tangent is taken only if the own disk satisfies it",
        Edit(TANGENT, "if own.satisfies(tangent):", "if True:"),
    ),
    (
        "a line stays in the place of the tangent only if the disk stands behind it",
        Edit(TANGENT, "if shape.limit(side.nx, side.ny, own_radius) >= side.limit:", "if True:"),
    ),
    (
        "a standing place counts until a line with the new life is agreed",
        Edit(
            PAIR_OF_ONE,
            "        if self.end.agreed:\n            self.disk = None\n",
            "        if self.end.obeyed:\n            self.disk = None\n",
        ),
        Edit(
            PAIR_OF_ONE,
            "return self.excused or self.end.agreed or self.keeps_clear",
            "return self.excused or bool(self.end.obeyed) or self.keeps_clear",
        ),
    ),
    (
        "of a life that stands nothing counts any more, whatever it says",
        Edit(
            PAIR_OF_ONE, "        self.end.fence(incarnation)\n", "        self.end.fence(incarnation - 1)\n"
        ),
    ),
)
