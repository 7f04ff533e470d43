"""Lives of robots that end and begin anew, as their pairs see it."""

from __future__ import annotations

from tests.agents.lines.models.mutants.mutant import Mutant
from tests.agents.lines.models.small_model import Bounds
from tests.interpreted import Edit

_BOND = "agents.lines.robot_pair"
_LEDGER = "agents.lines.separating_lines"
_NEAR = "agents.lines.negotiation.near"
_PAIR = "agents.lines.ends"

LIVES = (
    Mutant(
        "answer-to-this-life",
        "an answer counts only for the life of the owner that it names",
        (
            Edit(
                _PAIR,
                "            or incarnation != self.incarnation\n            or not self.seen",
                "            or not self.seen",
            ),
        ),
    ),
    Mutant(
        "offer-to-this-life",
        "a proposal counts only for the life of the follower that it names",
        (
            Edit(
                _PAIR, "or incarnation != self.incarnation or number <= self.seen:", "or number <= self.seen:"
            ),
        ),
        first=1422,
    ),
    Mutant(
        "older-follower-ignored",
        "an owner ignores lives of the follower that are older than the newest known",
        (
            Edit(
                _PAIR,
                "            not self.accept(peer_incarnation)\n            or incarnation",
                "            incarnation",
            ),
            Edit(
                _BOND,
                "            if not self.end.accept(state.incarnation):\n                return False\n",
                "            self.end.accept(state.incarnation)\n",
            ),
        ),
    ),
    Mutant(
        "older-owner-ignored",
        "a follower ignores lives of the owner that are older than the newest known",
        (
            Edit(
                _PAIR,
                "if not self.accept(peer_incarnation) or incarnation != self.incarnation or number",
                "if incarnation != self.incarnation or number",
            ),
            Edit(
                _BOND,
                "            if not self.end.accept(state.incarnation):\n                return False\n",
                "            self.end.accept(state.incarnation)\n",
            ),
        ),
    ),
    Mutant(
        "rosters-name-lives",
        "either end ignores lives of the other that are older than the one that a roster names",
        (Edit(_BOND, "if incarnation > self.end.peer_incarnation:", "if False:"),),
        model="pair",
        bounds=Bounds((2, 1), proposals=1, founding=(1,), versions=4, talks_on=True),
    ),
    Mutant(
        "first-roster-names-lives",
        "so it is with the first roster that a life hears",
        (Edit(_LEDGER, 'if member.status != "live" or not founding:', 'if member.status != "live":'),),
        model="pair",
        bounds=Bounds((1, 2), proposals=1, founding=(2,), versions=4, talks_on=True),
    ),
    Mutant(
        "lives-are-ordered",
        "which of two lives is the newer one follows from their numbers, not from who was heard last",
        (
            Edit(
                _PAIR,
                "        if peer_incarnation > self.peer_incarnation:\n            self.linked",
                "        if peer_incarnation != self.peer_incarnation:\n            self.linked",
            ),
        ),
    ),
    Mutant(
        "numbers-begin-anew",
        "a follower counts the numbers of each life of the owner by themselves",
        (Edit(_PAIR, "            self.held_number = self.seen = 0\n", ""),),
    ),
    Mutant(
        "inherit-held",
        "an owner whose follower lives anew goes on obeying the line that was held",
        (
            Edit(
                _PAIR, "self._inherited = self.obeyed\n", "self._inherited = tuple(self.proposed.values())\n"
            ),
        ),
    ),
    Mutant(
        "inherit-proposed",
        "and every unanswered proposal: it may have been adopted in the moment of death",
        (Edit(_PAIR, "self._inherited = self.obeyed\n", "self._inherited = self.obeyed[:1]\n"),),
    ),
    Mutant(
        "unadopted-count-for-nothing",
        "a proposal that no life is known to have adopted is no line: the peer may have moved past it",
        (
            Edit(
                _PAIR,
                "        self.proposed[self.number] = line\n",
                "        self.proposed[self.number] = line\n        self.agreed = True\n",
            ),
        ),
    ),
    Mutant(
        "offer-to-who-was-heard",
        "nothing is offered to a life that has not been heard",
        (
            Edit(_NEAR, "if not end.met or len(end.proposed)", "if len(end.proposed)"),
            Edit(
                _NEAR,
                "        if state is None or not state.placed:\n            return 0\n",
                "        if state is None:\n"
                "            state = PeerState(pair.peer, 0, 0, True, 0.0, float(pair.peer), 0.0, 0.0, "
                "0.0, 0.0, 0.0, radius=0.0)\n",
            ),
        ),
        model="pair",
        bounds=Bounds((1, 1), proposals=1, founding=(1,), removals=1, appearances=1),
    ),
    Mutant(
        "dead-lines-are-kept",
        "a follower whose owner lives anew goes on obeying the line that it holds",
        (
            Edit(
                _PAIR,
                "            self.held_number = self.seen = 0\n",
                "            self.held_number = self.seen = 0\n            self._held = None\n",
            ),
            Edit(
                _PAIR,
                "        return self._held is not None\n\n    @property\n    def settled",
                "        return True\n\n    @property\n    def settled",
            ),
        ),
    ),
)
