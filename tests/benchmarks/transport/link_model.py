"""What a fleet of any size sends over the links between its hosts, by a model fitted to small ones.

    bytes per tick = a n + b c + (hosts - 1) summary

with n robots beside another router than the world's, each of which is told a Tick and gives a Command; c
copies of States to hosts where somebody is near; and the summary, 16 bytes a robot and period. a and b are
fitted to fleets of `links`, and checked on one that was not fitted.

    python -m tests.benchmarks.transport.link_model
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from protocol.crowd.interest import period, slack_of
from protocol.scenario.model import Network, Scenario
from tests.benchmarks.links import homes, in_blocks, measure
from world.close_pairs import close_pairs

FITTED = ((16, 2), (32, 4), (64, 4), (64, 2))  # robots, hosts
CHECKED = (96, 6)
ASKED = (1000, 10)
_SECONDS = 8.0  # of simulated time
_ENTRY = 16  # bytes of a robot in a summary


class Load(NamedTuple):
    """What a fleet on several hosts has to send in a tick."""

    away: int  # robots beside another router than the world's
    copies: int  # of States, to hosts where somebody is near who speaks, counted where robots start
    summary: float  # bytes

    def bytes(self, away: float, copy: float) -> float:
        """By the model, with its two coefficients."""
        return away * self.away + copy * self.copies + self.summary


def load(scenario: Scenario, hosts: int) -> Load:
    """Of a scenario whose robots are in blocks, one on each host."""
    at = homes(scenario, hosts)
    ids = [spec.id for spec in scenario.robots]
    places = np.array([complex(*spec.start) for spec in scenario.robots])
    radii = np.array([spec.radius for spec in scenario.robots])
    pairs = np.stack(close_pairs(places, radii, 2.0 * slack_of(scenario))).T.tolist()
    crossed = {
        (one, at[ids[other]])
        for i, j in pairs
        for one, other in ((i, j), (j, i))
        if at[ids[one]] != at[ids[other]]
    }
    away = sum(host != 1 for host in at.values())
    return Load(away, len(crossed), (hosts - 1) * _ENTRY * len(ids) / period(scenario))


def fitted(loads: Sequence[Load], sent: Sequence[float]) -> tuple[float, float]:
    """The coefficients that come nearest, each fleet counting alike."""
    terms = np.array([(each.away, each.copies) for each in loads], dtype=np.float64)
    wanted = np.array(sent) - [each.summary for each in loads]
    weights = 1.0 / np.array(sent)
    found = np.linalg.lstsq(terms * weights[:, None], wanted * weights, rcond=None)[0]
    return float(found[0]), float(found[1])


def _near(robots: int, hosts: int) -> Scenario:
    return in_blocks(robots, hosts, _SECONDS, Network("near"))


def main() -> None:
    """Measure, fit, check, and say what is asked."""
    fleets = (*FITTED, CHECKED)
    loads = [load(_near(*fleet), fleet[1]) for fleet in fleets]
    sent = [measure(_near(*fleet), fleet[1]).each * fleet[0] for fleet in fleets]
    coefficients = fitted(loads[:-1], sent[:-1])
    print("a = {:.0f}, b = {:.0f} bytes".format(*coefficients))
    print("robots  hosts   away  copies  measured  by the model")
    for (robots, hosts), each, measured in zip(fleets, loads, sent, strict=True):
        print(
            f"{robots:6d}  {hosts:5d}  {each.away:5d}  {each.copies:6d}  {measured:8.0f}"
            f"  {each.bytes(*coefficients):8.0f}{'' if (robots, hosts) in FITTED else '  not fitted'}"
        )
    scenario = _near(*ASKED)
    asked = load(scenario, ASKED[1])
    print(
        f"{ASKED[0]:6d}  {ASKED[1]:5d}  {asked.away:5d}  {asked.copies:6d}  {'':8}"
        f"  {asked.bytes(*coefficients):8.0f}"
    )


if __name__ == "__main__":
    main()
