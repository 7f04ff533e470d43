"""What two ends of a pair agree on, life against life."""

from __future__ import annotations

from tests.agents.lines.models.mutants.mutant import Mutant
from tests.interpreted import Edit

_LEDGER = "agents.lines.separating_lines"
_NEAR = "agents.lines.negotiation.near"
_PAIR = "agents.lines.ends"

PAIR = (
    Mutant(
        "propose-satisfied",
        "an owner proposes only a line that its own disk satisfies now",
        (Edit(_NEAR, "if line is None or not fits(line):", "if line is None:"),),
    ),
    Mutant(
        "obey-at-once",
        "an owner obeys a proposal from the moment when it makes it",
        (
            Edit(
                _PAIR,
                "return (*self._inherited, *held, *self.proposed.values())",
                "return (*self._inherited, *held)",
            ),
        ),
    ),
    Mutant(
        "obey-both",
        "until there is an answer it obeys what it held, too",
        (Edit(_PAIR, "        self.number += 1\n", "        self.number += 1\n        self.held = None\n"),),
    ),
    Mutant(
        "drop-on-answer",
        "it drops a proposal only when an answer says that this number has been answered",
        (
            Edit(
                _PAIR,
                "for number, line in self.proposed.items() if number > seen}",
                "for number, line in ()}",
            ),
        ),
    ),
    Mutant(
        "hold-what-is-held",
        "of the lines that were answered it goes on obeying the one that the follower holds",
        (Edit(_PAIR, "if held in self.proposed:", "if seen in self.proposed:\n            held = seen"),),
    ),
    Mutant(
        "adopt-satisfied",
        "a follower adopts only a line that its own disk satisfies now",
        (Edit(_PAIR, "if not fits(line):", "if False:"),),
    ),
    Mutant(
        "answer-once",
        "a number that was answered, or passed over, is never adopted later",
        (Edit(_PAIR, "or number <= self.seen:\n", "or number == self.held_number:\n"),),
    ),
    Mutant(
        "reject-for-ever",
        "a number that was rejected is never adopted later, though the own disk may satisfy it then",
        (Edit(_PAIR, "or number <= self.seen:\n", "or number <= self.held_number:\n"),),
    ),
    Mutant(
        "no-line-no-motion",
        "a robot moves only while every peer that is there is behind a line or a tangent",
        (Edit(_LEDGER, "if not (pair.settled or pair.ready):", "if False:"),),
    ),
    Mutant(
        "save-before-telling",
        "the coordinator writes down what it decided before it tells anybody",
        saved=False,
    ),
)
