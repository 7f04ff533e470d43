"""Far peers, and who begins anew among them."""

from __future__ import annotations

from tests.agents.lines.models.mutants.mutant import Mutant
from tests.agents.lines.models.product import LARGE_ROOM
from tests.interpreted import Edit

_FAR = "agents.lines.negotiation.far"
_INITIAL = "agents.lines.initial_lines"
_LEDGER = "agents.lines.separating_lines"
_LINE = "agents.lines.line"
_PLACEMENT = "agents.lines.placement"
_ROBOT = "agents.robot"

FAR = (
    Mutant(
        "offer-before-moving",
        "a letter is written before the velocity is chosen, which keeps to what it offers",
        (
            Edit(_ROBOT, "            letter = self._letter(filter_)  #", "            #"),
            Edit(
                _ROBOT,
                "            letter,\n            handles",
                "            None if filter_ is None else self._letter(filter_),\n            handles",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "look-at-initial-lines",
        "an initial line counts although nobody has spoken of it",
        (Edit(_INITIAL, "return self.within(x, y, self._looked)", "return []"),),
        model="skirmish",
    ),
    Mutant(
        "look-again",
        "who has moved looks again at those that were out of reach",
        (
            Edit(_LEDGER, "AHEAD: Final = 20.0", "AHEAD: Final = 0.0"),
            Edit(_INITIAL, "+ reach <= self._looked:", "* 0.0 <= self._looked:"),
        ),
        model="skirmish",
        first=54,
    ),
    Mutant(
        "rest-out-of-reach",
        "a line rests only where the own disk is farther off than it has looked",
        (
            Edit(
                _INITIAL,
                "if side.slack(self._looked_x, self._looked_y) < self._looked + _ROUNDING:",
                "if False:",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "wake",
        "a line that rested is looked at by itself again as soon as somebody may be near, or speaks of it",
        (*LARGE_ROOM, Edit(_LEDGER, "if pair is not None and not pair.rests:", "if pair is not None:")),
        model="skirmish",
    ),
)


AFTERWARDS = (
    Mutant(
        "answer-who-lives-again",
        "a far peer that stood and has spoken since is answered, though its disk is kept clear of until then",
        (Edit(_FAR, " and pair.heard < end.peer_incarnation:", ":"),),
        model="aftermath",
    ),
    Mutant(
        "halfway",
        "two that begin anew as near as they may come to stand can agree on a line",
        (Edit(_PLACEMENT, "return _halfway(span, owner.radius, follower.radius)", "return None"),),
        model="aftermath",
    ),
    Mutant(
        "sure",
        "for they need less room for that than they leave when they move",
        (Edit(_LINE, "0.25 * ROUNDING", "ROUNDING"),),
        model="aftermath",
    ),
)
