"""Steps of an environment against those of a Simulation whose law asks for the same, in turns; and resets.

python -m tests.benchmarks.stepping --robots 2 6 16
"""

import argparse
import time
from statistics import median

import numpy as np

import disknav
from agents.law.api import View
from protocol.messages import Vector
from protocol.scenario.model import Scenario

_STEPS = 40  # of each, in turns


class Straight:
    def __init__(self, scenario: Scenario, robot: int) -> None:
        del robot
        self._speed, self._step = scenario.control.speed, scenario.time.step

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s."""
        x, y = view.goal[0] - view.position[0], view.goal[1] - view.position[1]
        rate = 1.0 / max(self._step, float(np.hypot(x, y)) / self._speed)
        return rate * x, rate * y


def compare(robots: int, rounds: int) -> tuple[float, float, float]:
    """Time of a step of an environment and of a Simulation, and of a reset, s: the median of all rounds."""
    scenario = disknav.load(f"swap-{robots}", {"time.limit": 1000.0})
    env = disknav.parallel_env(scenario)
    plain = disknav.load(f"swap-{robots}", {"time.limit": 1000.0, "control.law": Straight})
    law = Straight(scenario, 1)
    of_env, of_simulation, of_reset = [], [], []
    for _ in range(rounds):
        begun = time.perf_counter()
        seen, _ = env.reset()
        of_reset.append(time.perf_counter() - begun)
        simulation = disknav.Simulation(plain)
        simulation.join()
        for _ in range(_STEPS):
            step = law._step
            actions = {
                agent: at[2:4] / max(step, np.hypot(*at[2:4]) / law._speed) for agent, at in seen.items()
            }
            begun = time.perf_counter()
            seen, *_ = env.step(actions)
            between = time.perf_counter()
            simulation.step()
            of_env.append(between - begun)
            of_simulation.append(time.perf_counter() - between)
        assert np.abs(env.state() - simulation.positions).max() < 1e-4  # they did the same
    return median(of_env), median(of_simulation), median(of_reset)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=(2, 6, 16), help="numbers of robots")
    parser.add_argument("--rounds", type=int, default=10, help="episodes of 40 steps")
    options = parser.parse_args()
    print(f"{'robots':>6} {'env ms':>8} {'simulation ms':>14} {'ratio':>6} {'reset ms':>9}")
    for robots in options.robots:
        env, simulation, reset = compare(robots, options.rounds)
        ratio = simulation / env
        print(f"{robots:6d} {1e3 * env:8.2f} {1e3 * simulation:14.2f} {ratio:6.2f} {1e3 * reset:9.2f}")


if __name__ == "__main__":
    main()
