"""From what a user names to a scenario that can run, its law tried out."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from agents.law import View, choose
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library.names import build
from deploy.theory.tuning import gain_for
from protocol.draws import checked_seed
from protocol.errors import ScenarioError, UsageError
from protocol.scenario.file import apply_settings, document_of, parse_document, read_document
from protocol.scenario.model import Scenario
from protocol.scenario.tables import Document
from world.plants.plant import require as require_plant

TRIES = 5  # the quickest counts: others may have waited for the processor


def try_out(scenario: Scenario) -> None:
    """Let a law from outside make some steps as the first robot at the start.

    Raises:
        UsageError: there is no such law, or a step takes longer than a period.
        LawError: it fails, or does not return a velocity.
    """
    if ":" not in scenario.control.law:
        return
    robot = scenario.ids[0]
    law, own = choose(scenario, robot), scenario.spec(robot)
    neighbours = _neighbours(scenario, robot)
    quickest = float("inf")
    for tick in range(TRIES):
        view = View(
            tick=tick,
            position=own.start,
            goal=own.goal,
            displacement=(0.0, 0.0),
            neighbours=neighbours,
            things=tuple(scenario.shapes.values()),
        )
        begin = time.perf_counter()
        law.velocity(view)
        quickest = min(quickest, time.perf_counter() - begin)
        law.slice_norm(own.start, own.goal)
    if quickest > scenario.time.step:
        raise UsageError(
            f"control.law: a step of {scenario.control.law} takes {1e3 * quickest:.3g} ms, longer than a "
            f"period of {1e3 * scenario.time.step:g} ms: make it quicker, or time.step longer"
        )


def _neighbours(scenario: Scenario, robot: int) -> Neighbours:
    """Everybody else as heard in the first tick."""
    others = [spec for spec in scenario.robots if spec.id != robot]
    heard = Neighbours({spec.id: spec.radius for spec in others})
    for spec in others:
        x, y = spec.start
        gamma = (x - spec.goal[0]) ** 2 + (y - spec.goal[1]) ** 2
        pull = 2.0 * gamma**0.5
        heard.on_state(PeerState(spec.id, 1, 0, True, x, y, 0.0, gamma, pull, 0.0, 0.0, radius=spec.radius))
    return heard


def load(name: str, settings: Sequence[str] = (), seed: int | None = None) -> Scenario:
    """The scenario `name`, ready to run: as `read`, with k resolved, and its law tried out."""
    scenario = resolved(_certified(name, read(name, settings, seed)))
    require_plant(scenario.world.plant)
    try_out(scenario)
    return scenario


def read(name: str, settings: Sequence[str] = (), seed: int | None = None) -> Scenario:
    """The scenario of a file or of the library, with settings laid over it.

    Args:
        name: a file, else a library name.
        settings: `path.to.key=VALUE`, see `protocol.scenario.file`.
        seed: over the scenario's; a library scenario draws its random starts from it.

    Raises:
        ScenarioError: the scenario or a setting is invalid; names every problem.
        MapError: its map cannot be read.
        UsageError: there is no such file or library name.
    """
    document = apply_settings(_document(name, seed), settings)
    if "map" not in document:
        return parse_document(document, name)
    from deploy.maps.expand import blamed_on_map, expanded

    try:
        return parse_document(expanded(document, Path(name).parent, name), name)
    except ScenarioError as error:
        own = document.get("obstacles", [])
        raise blamed_on_map(error, len(own) if isinstance(own, list) else 0) from None


def resolved(scenario: Scenario) -> Scenario:
    """The same with a number for k where it is "auto".

    Raises:
        UsageError: it is "certified": who proved it is known of files and library names only.
    """
    if scenario.control.k == "certified":
        raise UsageError(
            'control.k = "certified" is for scenario files and names of the library, which '
            "`disknav certify` knows: give the number that it proves"
        )
    if scenario.control.k != "auto":
        return scenario
    return replace(scenario, control=replace(scenario.control, k=gain_for(scenario)))


def _certified(name: str, scenario: Scenario) -> Scenario:
    """The same with the smallest proven K for k where it is "certified"."""
    if scenario.control.k != "certified":
        return scenario
    from deploy.theory.certify.certificate import path_for, stored

    certificate = stored(name, scenario)
    if certificate is None or certificate.proven is None:
        raise UsageError(
            f'control.k is "certified", but {path_for(name)} proves nothing yet: disknav certify {name}'
        )
    return replace(scenario, control=replace(scenario.control, k=certificate.proven))


def _document(name: str, seed: int | None) -> Document:
    path, seed = Path(name), None if seed is None else checked_seed(seed)
    if _is_file(path):
        document = read_document(path)
        return document if seed is None else document | {"seed": seed}
    if path.suffix == ".toml" or "/" in name:
        raise UsageError(
            f"no scenario file {name!r}; the library has names such as figure-1 (see scenario list)"
        )
    return document_of(build(name, seed))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError as error:
        raise UsageError(f"scenario file {str(path)!r}: {error.strerror}") from None
