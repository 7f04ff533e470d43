"""Fleets with a planted fault: some modules as their sources say, but for a few words."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.agents.lines.models.product import ROBOT
from tests.agents.lines.models.test_models import MUTANTS
from tests.campaigns import observe
from tests.interpreted import Edit, Mutant, interpreted, without

_CHAIN = (*ROBOT, "agents.peers.link", "agents.shell.node", "deploy.run.local")


@contextmanager
def plant(fault: Mutant) -> Iterator[None]:
    """Inside, `observe` runs fleets with this fault."""
    *_, local = interpreted(*_CHAIN, edits=fault.edits)
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(observe, "LocalFleet", local.LocalFleet)
        yield


_RULES = ("own-error-at-lines", "own-error-at-the-wall", "no-region-no-motion", "measured-then")
FAULTS = (  # those that random scenarios show
    *(mutant for mutant in MUTANTS if mutant.rule in _RULES),
    without(
        "drawing-as-it-comes",
        "what the link does to a State does not depend on the order in which States come",
        Edit(
            "agents.peers.link",
            "        loss, duplicate, *spread = self._drawn_for(state.robot, state.tick)\n",
            "        self.heard = getattr(self, 'heard', 0) + 1\n"
            "        loss, duplicate, *spread = self._drawn_for(state.robot, self.heard)\n",
        ),
    ),
    without(
        "failing",
        "no step of a robot fails",
        Edit(
            "agents.robot",
            "        self.inbox.close()\n",
            "        self.inbox.close()\n"
            "        if self.incarnation > 2 and self.tick > 3:\n            raise ZeroDivisionError\n",
        ),
    ),
)
SIZING = without(
    "sizing-as-it-comes",
    "a peer is the disk of the roster that is known when its State counts, not when it arrives",
    Edit(
        "agents.peers.neighbours",
        "        tick = state.tick\n        if tick >= self._tick:",
        "        tick = state.tick\n        state.size(self.neighbours.radii[state.robot])\n"
        "        if tick >= self._tick:",
    ),
    Edit("agents.peers.neighbours", "        state.size(self.neighbours.radii.get(state.robot, 0.0))\n", ""),
)
HEARING = without(
    "hearing-what-nobody-waited-for",
    "a robot does not hear what was said before its life, or while it was paused",
    Edit("agents.peers.neighbours", "{peer: before.get(peer, now) for", "{peer: 0 for"),
)
