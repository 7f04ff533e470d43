"""`disknav.parallel_env`: PettingZoo's own tests, Gymnasium's of spaces, and what numbers mean."""

import warnings

import numpy as np
import pytest
from gymnasium.utils.passive_env_checker import check_space
from hypothesis import given
from hypothesis import strategies as st
from pettingzoo.test import parallel_api_test, parallel_seed_test

import disknav
from disknav.environment import FleetEnv, Observer
from tests.scripts import ended

DISTURBED = {
    "sensing.noise": 0.002,
    "link.delay": [0.0, 0.2],
    "link.loss": 0.2,
    "actuation.noise": 0.05,
    "time.limit": 4.0,
}


def crossing(seed: int = 0, **control: object) -> disknav.Scenario:
    """Two robots that have to pass each other, from starts that depend on the seed."""
    start = -0.1 - 0.001 * (seed % 50)
    robots = [
        {"id": 4, "radius": 0.03, "start": [0.1, 0.005], "goal": [-0.1, 0.0]},
        {"id": 2, "radius": 0.02, "start": [start, 0.0], "goal": [0.1, 0.0]},
    ]
    return disknav.build({"robots": robots, "time": {"limit": 20.0}, "control": control})


def straight(env: FleetEnv, seen: dict[str, np.ndarray]) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    """Actions that drive every robot straight to its goal."""
    step = env.simulation.scenario.time.step
    return {agent: each[2:4] / max(step, np.hypot(*each[2:4]) / 0.1) for agent, each in seen.items()}


@pytest.mark.slow
@pytest.mark.parametrize("is_filtered", [True, False])
def test_it_passes_the_tests_of_the_library(is_filtered: bool) -> None:
    def make() -> FleetEnv:
        return disknav.parallel_env(disknav.load("swap-4", DISTURBED), filter=is_filtered)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(make(), num_cycles=100)
        parallel_seed_test(make, num_cycles=100)
        for agent in (env := make()).possible_agents:
            check_space(env.observation_space(agent), "observation", lambda _: None)
            check_space(env.action_space(agent), "action", lambda _: None)
        seen, _ = env.reset(seed=1)
        while env.agents:
            assert all(env.observation_space(agent).contains(each) for agent, each in seen.items())
            seen, *_ = env.step({agent: env.action_space(agent).sample() for agent in env.agents})


def test_a_seed_is_that_of_the_scenario_and_later_episodes_differ() -> None:
    env = disknav.parallel_env(disknav.load("swap-4", DISTURBED, seed=7))

    def ends(seed: int | None) -> bytes:
        seen, _ = env.reset(seed=seed)
        while env.agents:
            seen, *_ = env.step(straight(env, seen))
        return env.state().tobytes()

    first, second = ends(None), ends(None)
    assert first != second
    assert (ends(7), ends(None)) == (first, second)


def test_actions_move_their_robots_in_the_very_step_also_a_robot_that_is_alone() -> None:
    robot = {"id": 1, "radius": 0.02, "start": [0.0, 0.0], "goal": [0.2, 0.0]}
    env = disknav.parallel_env(disknav.build({"robots": [robot]}))
    env.reset()
    step = env.simulation.scenario.time.step
    for n in range(1, 4):
        seen, *_ = env.step({"robot_1": (0.04, 0.0)})
        assert seen["robot_1"] == pytest.approx([n * 0.04 * step, 0.0, 0.2 - n * 0.04 * step, 0.0], abs=1e-6)
    env.step({"robot_1": (3.0, 4.0)})
    assert env.state()[0] == pytest.approx([(0.12 + 0.06) * step, 0.08 * step])
    before = env.state()
    env.step({})
    assert (env.state() == before).all()


def test_behind_the_filter_robots_arrive_that_collide_without_it() -> None:
    def run(is_filtered: bool) -> tuple[str, float, float]:
        env = disknav.parallel_env(crossing(), filter=is_filtered)
        seen, infos = env.reset()
        closest, total = np.inf, 0.0
        while env.agents:
            seen, rewards, terminations, truncations, infos = env.step(straight(env, seen))
            closest = min(closest, infos["robot_2"]["clearance"])
            total += rewards["robot_2"]
        assert all(terminations.values())
        assert not any(truncations.values())
        assert all(info["arrived"] for info in infos.values())
        with pytest.raises(disknav.UsageError, match="call reset"):
            env.step({})
        return infos["robot_2"]["verdict"], total, closest

    verdict, total, closest = run(is_filtered=False)
    assert (verdict, total) == ("collision", 0.0)
    assert closest < 0.0
    verdict, total, closest = run(is_filtered=True)
    assert (verdict, total) == ("arrived", 1.0)
    assert closest > 0.0


def test_an_episode_that_takes_too_long_is_truncated() -> None:
    env = disknav.parallel_env(disknav.load("swap-3", {"time.limit": 0.5}))
    env.reset()
    for _ in range(10):
        _, _, terminations, truncations, infos = env.step({})
    assert infos["robot_1"]["verdict"] == "timeout"
    assert all(truncations.values())
    assert not any(terminations.values())


@given(st.integers(0, 2**32 - 1), st.integers(2, 7), st.integers(1, 6))
def test_nearest_disks_are_observed_by_their_gaps(seed: int, count: int, neighbours: int) -> None:
    random, neighbours = np.random.default_rng(seed), min(neighbours, count - 1)
    robots = [
        {"id": n + 1, "radius": random.uniform(0.01, 0.1), "start": [float(n), 0.0], "goal": [float(n), 1.0]}
        for n in range(count)
    ]
    scenario = disknav.build({"workspace": {"radius": 20.0}, "robots": robots})
    observer = Observer(scenario, neighbours)
    before, after = random.uniform(-2.0, 2.0, (2, count, 2))
    observer.begin(scenario, before)
    observer.move(after)
    for one, seen in enumerate(observer.observations()):
        gaps = {
            float(np.hypot(*(after[two] - after[one]))) - robots[one]["radius"] - robots[two]["radius"]: two
            for two in range(count)
            if two != one
        }
        expected = [*after[one], *(np.array(robots[one]["goal"]) - after[one])]
        for gap in sorted(gaps)[:neighbours]:
            two = gaps[gap]
            velocity = np.clip((after[two] - before[two]) / scenario.time.step, -0.1, 0.1)
            expected += [*(after[two] - after[one]), *velocity, gap]
        assert seen == pytest.approx(np.array(expected), abs=1e-5)


@pytest.mark.parametrize(
    ("action", "text"),
    [
        ({"robot_2": (np.nan, 0.0)}, "two finite numbers"),
        ({"robot_2": (1.0, 0.0, 0.0)}, "two finite numbers"),
        ({"robot_3": (0.0, 0.0)}, "no agent 'robot_3'; there are robot_2, robot_4"),
    ],
)
def test_bad_actions_are_named(action: dict[str, tuple[float, ...]], text: str) -> None:
    env = disknav.parallel_env(crossing())
    env.reset()
    with pytest.raises(disknav.UsageError, match=text):
        env.step(action)


def test_what_no_environment_can_be_made_of_is_refused() -> None:
    robot = {"id": 1, "radius": 0.02, "start": [0.0, 0.0], "goal": [0.2, 0.0]}
    with pytest.raises(disknav.UsageError, match="no orders"):
        disknav.parallel_env(disknav.build({"robots": [robot], "orders": [{"at": 1.0, "remove": 1}]}))
    with pytest.raises(disknav.UsageError, match="must not be negative"):
        disknav.parallel_env("swap-3", neighbours=-1)
    changing = disknav.parallel_env(lambda seed: disknav.load(f"swap-{3 + min(seed, 1)}"))
    with pytest.raises(disknav.UsageError, match="seed 5 has robots"):
        changing.reset(seed=5)


def test_without_its_libraries_the_extra_is_named() -> None:
    code = "import sys; sys.modules['pettingzoo'] = None; import disknav; disknav.parallel_env('swap-3')"
    said = ended(code, timeout=60.0).stderr
    assert "UsageError" in said
    assert "[env]" in said
