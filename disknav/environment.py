"""An environment for learning, after PettingZoo's parallel API: actions are velocities of robots."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, Literal, SupportsFloat

import numpy as np
from numpy.typing import NDArray

from deploy.run.local import seldom_collecting
from disknav.running import Simulation
from disknav.scenarios import Source, ready
from protocol.arrays import Reals
from protocol.draws import LARGEST_SEED, checked_seed
from protocol.errors import UsageError
from protocol.process.installation import missing_library
from protocol.scenario.model import Scenario

try:
    from gymnasium.spaces import Box
    from pettingzoo import ParallelEnv
except ModuleNotFoundError as error:
    raise missing_library("an environment for learning", "pettingzoo", "env") from error

Observation = NDArray[np.float32]


class FleetEnv(ParallelEnv):  # type: ignore[misc]  # PettingZoo has no types
    """A fleet in this process as a `pettingzoo.ParallelEnv`, in which each step is one tick. Agents are
    `robot_<id>`, and stay to the end of an episode.

    *Action*: the wanted velocity, m/s, shape (2,); a longer one is slowed down to the speed limit. The filter
    executes the part of it that is safe.

    *Observation*: float32, of the truth at the start of the tick: own position (m), way to the goal (m), and
    for each of the nearest disks, nearest first, the way to its centre (m), its velocity (m/s) and the gap to
    it (m). Noise, delay and loss of the scenario act on robots and their filter.

    *Reward*: 1 for all in the step with which all have arrived without a contact, else 0.

    *End*: terminated once all are at their goals; truncated when the run ends otherwise, by its time limit
    or a deadlock. A contact does not end an episode.

    *Info*: `arrived`, whether the robot is within the tolerance of its goal; `clearance` of the fleet, m, as
    of `Simulation`; `verdict`, empty while the episode continues.

    Args:
        scenario: a result of `load` or `build`, a source for `load`, or a function that returns one of these
            from the seed of an episode, with the same robots each time.
        filter: whether the safety filter stands between actions and robots.
        neighbours: how many others each robot observes.

    Attributes:
        simulation: of the current episode.

    Raises:
        ScenarioError, UsageError: as `load`; a library of the extra `env` is missing; the scenario has
            orders, parts or external bases.
    """

    metadata: dict[str, Any] = {"name": "disknav_v0", "render_modes": []}  # noqa: RUF012  # as in PettingZoo
    render_mode = None

    def __init__(
        self, scenario: Source | Callable[[int], Source], filter: bool = True, *, neighbours: int = 4
    ) -> None:
        if neighbours < 0:
            raise UsageError(f"neighbours: {neighbours} must not be negative")
        self._filter = filter
        self._episode = scenario if callable(scenario) else None
        self._scenario = self._prepared(scenario(0) if callable(scenario) else scenario)
        self._view = Observer(self._scenario, min(neighbours, len(self._scenario.ids) - 1))
        self.possible_agents = [f"robot_{robot}" for robot in self._scenario.ids]
        self.agents: list[str] = []
        self._ids = dict(zip(self.possible_agents, self._scenario.ids, strict=True))
        speed, limits = self._scenario.control.speed, self._view.limits
        self.action_spaces = {agent: Box(-speed, speed, (2,), np.float32) for agent in self.possible_agents}
        self.observation_spaces = {
            agent: Box(-limits, limits, dtype=np.float32) for agent in self.possible_agents
        }
        self.simulation = Simulation(self._scenario)
        self._random: np.random.Generator | None = None

    def action_space(self, agent: str) -> Box:
        """Velocities up to the speed limit along each axis, m/s."""
        return self.action_spaces[agent]

    def observation_space(self, agent: str) -> Box:
        """Numbers of one observation, in the order of the class's documentation."""
        return self.observation_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin an episode; returns observations and infos of all agents.

        Args:
            seed: of all random values, as `Scenario.seed`; by default the scenario's in the first episode,
                and drawn in later ones.
            options: ignored.
        """
        del options
        if seed is not None or self._random is None:
            seed = self._scenario.seed if seed is None else checked_seed(seed)
            self._random = np.random.default_rng(seed)
        else:
            seed = int(self._random.integers(LARGEST_SEED))
        scenario = self._scenario if self._episode is None else self._prepared(self._episode(seed))
        if scenario.ids != self._scenario.ids:
            raise UsageError(
                f"seed {seed} has robots {scenario.ids}; the environment has {self._scenario.ids}"
            )
        with seldom_collecting():  # the episode before is garbage with cycles
            self.simulation = Simulation(replace(scenario, seed=seed))
            self.simulation.join()
        self._view.begin(scenario, self.simulation.positions)
        self.agents = self.possible_agents.copy()
        return self._observations(), self._infos(self._view.arrived)

    def step(
        self, actions: Mapping[str, Iterable[SupportsFloat]]
    ) -> tuple[
        dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        """Advance one tick; an agent without an action wants to stand. Returns observations, rewards,
        terminations, truncations and infos of all agents.

        Raises:
            UsageError: an agent is unknown, an action is no velocity, or no episode is in progress.
        """
        if not self.agents:
            raise UsageError("no episode is under way: call reset")
        wishes: dict[int, Iterable[SupportsFloat]] = dict.fromkeys(self._ids.values(), (0.0, 0.0))
        wishes.update((self._known(agent), action) for agent, action in actions.items())
        self.simulation.tell(wishes)
        self.simulation.step()
        self._view.move(self.simulation.positions)
        verdict, agents, arrived = self.simulation.verdict, self.agents, self._view.arrived
        is_there = bool(verdict) and all(arrived)
        results = (
            self._observations(),
            dict.fromkeys(agents, float(verdict == "arrived")),
            dict.fromkeys(agents, is_there),
            dict.fromkeys(agents, bool(verdict) and not is_there),
            self._infos(arrived),
        )
        if verdict:
            self.agents = []
        return results

    def state(self) -> Reals:
        """Positions of all robots in the order of their ids, m, shape (p, 2)."""
        return self.simulation.positions

    def close(self) -> None:
        """Do nothing, as the interface requires."""

    def _prepared(self, source: Source) -> Scenario:
        """The scenario, with actions in place of its law."""
        scenario = ready(source, None, None)
        if scenario.is_external or scenario.parts or scenario.orders:
            raise UsageError("an environment has no orders, no parts and no external bases")
        filter_: Literal["separating-lines", "none"] = "separating-lines" if self._filter else "none"
        return replace(scenario, control=replace(scenario.control, law="external", filter=filter_))

    def _known(self, agent: str) -> int:
        if agent not in self._ids:
            raise UsageError(f"there is no agent {agent!r}; there are {', '.join(self.possible_agents)}")
        return self._ids[agent]

    def _observations(self) -> dict[str, Observation]:
        return dict(zip(self.agents, self._view.observations(), strict=True))

    def _infos(self, arrived: list[bool]) -> dict[str, dict[str, Any]]:
        common = {"clearance": self.simulation.clearance, "verdict": self.simulation.verdict}
        return {agent: {"arrived": at, **common} for agent, at in zip(self.agents, arrived, strict=True)}


parallel_env = FleetEnv  # as PettingZoo's environments name it


class Observer:
    """Computes the observations of all robots from their positions, each with so many neighbours."""

    def __init__(self, scenario: Scenario, neighbours: int) -> None:
        self._neighbours = neighbours
        (left, low), (right, high) = scenario.workspace.shape.box
        reach, speed = 2.0 * max(-left, -low, right, high), scenario.control.speed
        each = [2.0 * reach, 2.0 * reach, speed, speed, 2.0 * reach]
        # Largest size of each number of an observation, shape (4 + 5 neighbours,).
        self.limits = np.array([reach, reach, 2.0 * reach, 2.0 * reach, *each * neighbours], np.float32)
        self.begin(scenario, np.array([scenario.spec(robot).start for robot in scenario.ids]))

    def begin(self, scenario: Scenario, positions: Reals) -> None:
        """Begin an episode with all disks at `positions`, m, shape (p, 2)."""
        specs = [scenario.spec(robot) for robot in scenario.ids]
        radii = np.array([spec.radius for spec in specs])
        self._goals = np.array([spec.goal for spec in specs])
        self._step, self._tolerance = scenario.time.step, scenario.time.tolerance
        self._radii = radii[:, None] + radii
        np.fill_diagonal(self._radii, -np.inf)  # no disk is near itself
        self._rows = np.arange(len(specs))[:, None]
        self._positions, self._velocities = positions, np.zeros_like(positions)

    def move(self, positions: Reals) -> None:
        """Set the positions after another tick, m."""
        self._velocities = (positions - self._positions) / self._step
        self._positions = positions

    @property
    def arrived(self) -> list[bool]:
        """Which robots are within the tolerance of their goals."""
        ways = self._goals - self._positions
        there: list[bool] = (np.hypot(ways[:, 0], ways[:, 1]) <= self._tolerance).tolist()
        return there

    def observations(self) -> Observation:
        """Observations of all robots, shape (p, 4 + 5 neighbours), clipped to `limits`."""
        at = self._positions
        ways = at - at[:, None]
        gaps = np.hypot(ways[..., 0], ways[..., 1]) - self._radii
        nearest = gaps.argsort(axis=1, kind="stable")[:, : self._neighbours]
        rows = self._rows
        peers = (ways[rows, nearest], self._velocities[nearest], gaps[rows, nearest][..., None])
        seen = np.hstack((at, self._goals - at, np.concatenate(peers, axis=2).reshape(len(at), -1)))
        limited: Observation = np.maximum(np.minimum(seen, self.limits), -self.limits).astype(np.float32)
        return limited
