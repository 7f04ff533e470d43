"""Additions to the paper's law: without any it is the paper's, and each can be left out."""

import json
import math
from dataclasses import replace

import pytest

from agents.law import View, choose
from agents.law.additions import AugmentedLaw
from agents.law.gradient import GradientLaw
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library.instances import random_instance
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.scenario.model import Control


@pytest.mark.parametrize("seed", range(6))
def test_without_additions_the_law_is_the_papers_to_the_last_bit(seed: int) -> None:
    """Peers may be late, and some near a contact."""
    scenario = replace(random_instance(6, seed), control=Control(k=60.0, additions=()))
    papers, augmented = choose(scenario, 1), AugmentedLaw(scenario, 1)
    assert isinstance(papers, GradientLaw)
    (x, y), period = scenario.robots[0].start, scenario.time.step
    vx = vy = 0.0
    known = Neighbours({spec.id: spec.radius for spec in scenario.robots[1:]})
    for tick in range(40):
        for spec in scenario.robots[1:]:
            if (tick + spec.id) % 3 == 0:
                gamma = math.dist(spec.start, spec.goal) ** 2
                state = (spec.id, 1, tick, True, *spec.start, 0.0, gamma, 0.1, 0.05, 0.05)
                known.on_state(PeerState(*state, radius=spec.radius), 0)
        view = View(tick, (x, y), scenario.robots[0].goal, (period * vx, period * vy), known)
        vx, vy = papers.velocity(view)
        assert augmented.velocity(view) == (vx, vy)
        assert augmented.slice_norm((x, y), view.goal) == papers.slice_norm((x, y), view.goal)
        x, y = x + period * vx, y + period * vy


@pytest.mark.slow
@pytest.mark.parametrize(("count", "without"), [(3, ""), (6, "pace")])
def test_symmetric_swaps_arrive_on_short_ways(count: int, without: str) -> None:
    """By the law alone: no filter keeps them apart."""
    additions = [each for each in ("pace", "escape") if each != without]
    scenario = load(f"swap-{count}", [f"control.additions={json.dumps(additions)}", "control.filter=none"])
    report = LocalFleet(scenario).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["nrl"] < 1.7


@pytest.mark.parametrize("filter_", ["separating-lines", "none"])
def test_on_a_saddle_only_the_escape_gets_away(filter_: str) -> None:
    def verdict(*additions: str) -> str:
        settings = [f"control.additions={json.dumps(additions)}", f"control.filter={filter_}"]
        scenario = load("head-on", [*settings, "time.limit=20.0", "time.deadlock=5.0"])
        return str(LocalFleet(scenario).execute()["verdict"])

    assert [verdict("pace", "escape"), verdict("pace"), verdict()] == ["arrived", "deadlock", "deadlock"]
