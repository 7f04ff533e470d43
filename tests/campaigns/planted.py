"""Fleets with a planted fault: some modules as their sources say, with one fault in them."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from protocol.scenario.model import Sensing
from tests.campaigns import observe
from tests.interpreted import interpreted

Modules = dict[str, ModuleType]
Fault = Callable[[Modules, pytest.MonkeyPatch], None]

# in the order of their imports, up to those that a fleet is made of
_CHAIN = (
    *("agents.lines.boundary", "agents.lines.safe_velocity", "agents.bodies", "protocol.kernel.pair"),
    *("protocol.kernel.robot", "agents.peers.link", "agents.peers.neighbours"),
    *("agents.lines.negotiation", "agents.lines.separating_lines", "agents.safety_filter"),
    *("agents.robot", "agents.shell.node", "deploy.run.local"),
)


@contextmanager
def plant(fault: Fault) -> Iterator[None]:
    """Inside, `observe` runs fleets with this fault."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        modules = dict(zip(_CHAIN, interpreted(*_CHAIN), strict=True))
        fault(modules, monkeypatch)
        monkeypatch.setattr(observe, "LocalFleet", modules["deploy.run.local"].LocalFleet)
        yield


# -- faults


def half_the_error(_: Modules, monkeypatch: pytest.MonkeyPatch) -> None:
    """Robots take measurements for twice as good as they are."""
    whole = Sensing.bound.fget
    monkeypatch.setattr(Sensing, "bound", property(lambda self: 0.5 * whole(self)))  # type: ignore[misc]


def trusting_the_estimate(modules: Modules, _: pytest.MonkeyPatch) -> None:
    """The wall is kept for the estimate, as if that were exact."""
    boundary = modules["agents.lines.boundary"].RoundBoundary

    def cut(self: Any, place: Any, _: Any, step: Any, noise: float = 0.0, tolerance: float = 0.0) -> Any:
        extra = noise * float(np.hypot(*step))
        return self._cut_of_point(*place, *step, extra, tolerance)

    boundary.cut = cut


def not_waiting(modules: Modules, _: pytest.MonkeyPatch) -> None:
    """A robot moves before it obeys a region."""
    modules["agents.lines.separating_lines"].SeparatingLines.ready = True


def drawing_as_it_comes(modules: Modules, _: pytest.MonkeyPatch) -> None:
    """What the link does depends on the order in which messages come."""
    draws = np.random.default_rng(0)
    link = modules["agents.peers.link"].StateLink
    before = link._delayed

    def delayed(self: Any, state: Any, late: float, _: float, jitter: float) -> int:
        return int(before(self, state, late, float(draws.random()), jitter))

    link._delayed = delayed


def sizing_as_it_comes(modules: Modules, _: pytest.MonkeyPatch) -> None:
    """A peer is the disk of the roster that is known as its State arrives."""
    hearing = modules["agents.peers.neighbours"].PeerInbox
    before = hearing.on_state

    def on_state(self: Any, state: Any) -> None:
        state.size(self.neighbours.radii[state.robot])
        before(self, state)

    def learn(self: Any, state: Any) -> None:
        if state.tick >= self._since.get(state.robot, 2**62) and self.neighbours.on_state(state, self._tick):
            self._accepted(state)

    hearing.on_state, hearing._learn = on_state, learn


def hearing_what_nobody_waited_for(modules: Modules, _: pytest.MonkeyPatch) -> None:
    """A robot hears what was said before its life, or while it was paused, if it still arrives."""
    hearing = modules["agents.peers.neighbours"].PeerInbox
    before = hearing._attend

    def attend(self: Any, tick: Any) -> None:
        before(self, tick)
        self._since = dict.fromkeys(self._since, 0)

    hearing._attend = attend


def failing(modules: Modules, _: pytest.MonkeyPatch) -> None:
    """A robot's step fails where a peer is exactly at its own place's distance: an undeclared error."""
    robot = modules["agents.robot"].Robot
    before = robot.command

    def command(self: Any) -> Any:
        if self.incarnation > 2 and self.tick > 3:
            raise ZeroDivisionError("planted")
        return before(self)

    robot.command = command


FAULTS: dict[Fault, int] = {  # those that random scenarios show, and a seed from which on they do soon
    half_the_error: 4,
    trusting_the_estimate: 55,
    not_waiting: 0,
    drawing_as_it_comes: 0,
    failing: 0,
}
