"""A search for livelock: scenarios in which the paper's law arrives and the reciprocal one does not.

Random starts and goals, equal and unequal disks, crowded and not, swaps with and without jitter, prompt and
late States. Every instance on which the reciprocal law does not arrive is run with the paper's law.
"""

from dataclasses import replace

from deploy.library.encounters import swap
from deploy.library.instances import random_instance
from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.draws import Purpose, generator
from protocol.scenario.file import write_toml
from protocol.scenario.model import Control, Scenario
from protocol.scenario.network import Link
from tests.campaigns.campaign import Campaign, Dice, Outcome

LIMIT = 120.0  # s of simulated time
DELAYS = (0.0, 0.0, 0.05, 0.1, 0.2, 0.3)  # s; fresh states twice as often


def drawn(seed: int) -> Scenario:
    random = generator(seed, Purpose.SCENARIO, 7)
    count, kind = int(random.integers(2, 13)), int(random.integers(3))
    if kind == 0:
        scenario = swap(count, 0.015 * random.random() * float(random.integers(2)), seed)
    else:
        unequal = 0.5 * random.random() * (kind - 1)
        scenario = random_instance(count, seed, density=random.uniform(0.03, 0.3), unequal=unequal)
    delay = DELAYS[int(random.integers(len(DELAYS)))]
    time = replace(scenario.time, limit=LIMIT, deadlock=LIMIT)
    return replace(scenario, link=Link(delay=delay), time=time)


def arrives(scenario: Scenario, law: str) -> bool:
    """Whether all robots do.

    Raises:
        AssertionError: something touched.
    """
    control = Control(law=law)
    report = LocalFleet(resolved(replace(scenario, control=control))).execute()
    assert report["collisions"] == 0, f"{law} touches in {scenario.name} of seed {scenario.seed}"
    return bool(report["verdict"] == "arrived")


def run(dice: Dice) -> Outcome:
    """One instance: the violation is that only the paper's law arrives."""
    scenario = drawn(dice.seed)
    if arrives(scenario, "reciprocal"):
        return Outcome("arrived")
    if not arrives(scenario, "gradient"):
        return Outcome("with neither")
    late = f"{scenario.description}, {scenario.link.delay} s late"
    return Outcome("only with gradient", f"livelock: {late}", write_toml(resolved(scenario)))


LAWS = Campaign(run, 2000)
