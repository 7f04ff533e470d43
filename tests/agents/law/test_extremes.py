"""Whatever finite numbers peers say, a law gives a finite velocity within the limit, and no error."""

import math
from dataclasses import replace

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from agents.law import GuardedLaw, View
from agents.law.choice import MOST
from agents.peers.far import FarField
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library.encounters import swap
from deploy.library.load import load
from protocol.messages import LARGEST
from protocol.scenario.model import Scenario

ROBOTS, TICKS = 9, 40
EXTREMES = [0.0, 5e-324, 1e-100, 1e-9, 1.0, 1e9, 1e99, LARGEST]
sizes = st.sampled_from(EXTREMES) | st.floats(0.0, LARGEST)
numbers = sizes | sizes.map(lambda size: -size)
contacts = st.sampled_from([0.0, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.0 + 1e-15, 1.01, 3.0])
fields = st.fixed_dictionaries(
    {},
    optional={
        **dict.fromkeys(("x", "y", "vx", "vy"), numbers),
        **dict.fromkeys(("bound", "gamma", "slice", "radius"), sizes),
        "tick": st.integers(0, TICKS),
        "placed": st.booleans(),
    },
)


def drive(
    scenario: Scenario, law_name: str, lies: dict[str, float], far: dict[str, float], contact: float = 3.0
) -> None:
    """Robot 1 for some ticks among peers; 2 says `lies`, 3 is at `contact` distances of contact, at first."""
    law = GuardedLaw(replace(scenario, control=replace(scenario.control, law=law_name, k=60.0)), 1)
    speed, period = scenario.control.speed, scenario.time.step
    own = scenario.spec(1)
    (x, y), (vx, vy) = own.start, (0.0, 0.0)
    beside = x - contact * 2.0 * own.radius, y
    known = Neighbours({spec.id: spec.radius for spec in scenario.robots if spec.id != 1})
    for tick in range(TICKS):
        for spec in scenario.robots:
            if spec.id != 1:
                gamma = math.dist(spec.start, spec.goal) ** 2
                state = PeerState(
                    spec.id, 1, tick, True, *spec.start, 0.0, gamma, 0.1, 0.05, 0.05, radius=spec.radius
                )
                if spec.id == 3:
                    state.x, state.y = beside
                if spec.id == 2:
                    for name, value in lies.items():
                        setattr(state, name, min(value, tick) if name == "tick" else value)
                known.on_state(state, state.tick)
        if far:
            known.far = FarField(max(0, tick - 3), *own.start)
            for name, value in far.items():
                setattr(known.far, name, value)
            known.far.count = 3
        shapes = tuple(scenario.shapes.values())
        view = View(tick, (x, y), own.goal, (period * vx, period * vy), known, shapes)
        vx, vy = law.velocity(view)
        assert math.hypot(vx, vy) <= speed * (1.0 + 1e-9), (tick, vx, vy)
        norm = law.slice_norm((x, y), own.goal)
        assert 0.0 <= norm <= MOST * scenario.workspace.shape.around.radius, (tick, norm)
        x, y = x + period * vx, y + period * vy


@pytest.mark.slow
@pytest.mark.parametrize("law", ["gradient", "reciprocal"])
@settings(max_examples=10, deadline=None)
@given(
    contact=contacts,
    lies=fields,
    far=st.just({}) | st.fixed_dictionaries(dict.fromkeys(("gamma", "largest", "slice"), sizes)),
)
@example(contact=1.0, lies={"gamma": 1e99}, far={})
@example(contact=1.0 + 1e-15, lies={"x": LARGEST, "y": -LARGEST, "vx": -LARGEST}, far={})
def test_no_finite_number_of_a_peer_makes_a_law_fail(
    law: str, contact: float, lies: dict[str, float], far: dict[str, float]
) -> None:
    for scenario in swap(ROBOTS), load("boxes-4"):
        drive(scenario, law, lies, far, contact)
