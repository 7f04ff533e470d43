"""Loading a scenario by file or library name, with settings applied and its law checked."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import NamedTuple

from agents.law import GuardedLaw, View
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library import encounters, instances
from deploy.theory.tuning import gain_for
from protocol.draws import checked_seed
from protocol.errors import LawError, ScenarioError, UsageError
from protocol.process.log import LOG
from protocol.scenario.checks import doubts
from protocol.scenario.file import apply_settings, document_of, parse_document, read_document, validated
from protocol.scenario.model import Scenario
from protocol.scenario.tables import Document
from world.plants.plant import require as require_plant

DEFAULT_SEED = 0
MAPS = {  # deploy/library/maps
    "office": "seven rooms on both sides of a corridor",
    "warehouse": "racks between aisles",
    "cloister": "a round court with four gates in an octagonal walk",
}


class CatalogueEntry(NamedTuple):
    """One name of the library; `N` in it is a number of robots, or of parts."""

    name: str
    robots: str
    text: str


class Series(NamedTuple):
    """The scenarios of one name, by a number of robots, or of parts, from `least` to `most`, and `seed`."""

    build: Callable[..., Scenario]
    least: int
    most: int
    text: str


def _from_file(name: str, seed: int) -> Scenario:
    document = read_document(Path(__file__).parent / "scenarios" / f"{name}.toml")
    return parse_document(document | {"seed": seed})


def _on_map(name: str, count: int, seed: int) -> Scenario:
    from deploy.maps.scenario import expanded, on_map  # needs an extra's libraries

    folder = Path(__file__).parent / "maps"
    document = on_map(folder / f"{name}.yaml", count, 0.2, seed)
    return parse_document(expanded(document, folder, document["name"]))


_FIXED: dict[str, Callable[[int], Scenario]] = {
    "figure-1": partial(_from_file, "figure-1"),
    "figure-2": partial(_from_file, "figure-2"),
    **{f"figure-3{letter}": partial(instances.figure_3, letter) for letter in instances.TIGHTNESS},
    "head-on": partial(_from_file, "head-on"),
    "admissible": partial(_from_file, "admissible"),
    "delay-6": instances.delay_6,
    "sphere-world": partial(_from_file, "sphere-world"),
    "crash": instances.crash,
}
_COUNTED: dict[str, Series] = {
    "swap": Series(encounters.swap, 2, 1000, "robots on a circle change places, exactly on the saddle"),
    "circle": Series(
        encounters.circle, 2, 250, "robots of 1.5 m change places on a circle of 200 m, as in RVO2"
    ),
    "turtlebots": Series(
        encounters.turtlebots, 2, 100, "robots on two wheels each change places on a circle"
    ),
    "forest": Series(encounters.forest, 1, 20, "among 40 boxes, as in LSC-DR's forest10"),
    "blocks": Series(encounters.blocks, 4, 100, "four groups cross between four blocks, as in RVO2"),
    "boxes": Series(encounters.boxes, 1, 100, "random goals among 8 boxes, as in GCBF+"),
    "beads": Series(encounters.beads, 1, 100, "in a corridor, where all keep their order"),
    "in-turn": Series(instances.in_turn, 1, 100, "only one robot moves at a time"),
    "parts": Series(instances.parts, 1, 40, "N parts, which 3 robots bring to their goals"),
    **{
        name: Series(partial(_on_map, name), 1, 100, f"random goals on a floor plan: {text}")
        for name, text in MAPS.items()
    },
    "random": Series(instances.random_instance, 1, 1000, "random starts and goals at the paper's density"),
}
_NUMBERED = re.compile(rf"({'|'.join(_COUNTED)})-([1-9][0-9]{{0,5}})")


def catalogue() -> list[CatalogueEntry]:
    """All names, in the order of display."""
    made = {name: make(DEFAULT_SEED) for name, make in _FIXED.items()}
    fixed = [CatalogueEntry(name, str(len(each.robots)), each.description) for name, each in made.items()]
    counted = (
        CatalogueEntry(f"{name}-N", f"{each.least} to {each.most}", each.text)
        for name, each in _COUNTED.items()
    )
    return [*fixed, *counted]


def build(name: str, seed: int | None = None) -> Scenario:
    """The library's scenario of this name; `seed` (default 0) determines all random values.
    Raises UsageError if the name is unknown, its number out of range, or the seed is invalid.
    """
    seed = DEFAULT_SEED if seed is None else checked_seed(seed)
    if name in _FIXED:
        return validated(_FIXED[name](seed))
    if found := _NUMBERED.fullmatch(name):
        return validated(_COUNTED[found[1]].build(_in_range(found[1], int(found[2])), seed=seed))
    known = [*_FIXED, *(f"{each}-N" for each in _COUNTED)]
    near = " or ".join(get_close_matches(name, known, 3, 0.5)).replace("-N", "-4")
    help_ = f"did you mean {near}?" if near else f"the library has {', '.join(known)}"
    raise UsageError(f"no scenario {name!r}; {help_}")


def _in_range(name: str, count: int) -> int:
    series = _COUNTED[name]
    if not series.least <= count <= series.most:
        raise UsageError(f"{name}-{count}: choose from {series.least} to {series.most}")
    return count


_COUNT = 6  # default number of robots
_OPTIONS = {"random": ("robots", "density", "unequal"), "swap": ("robots", "jitter")}


def generate(kind: str, seed: int, options: Mapping[str, float]) -> Scenario:
    """A scenario of `kind`: "random", "swap", or a name of the library.

    Args:
        options: "robots", "density" and "unequal" for "random", "robots" and "jitter" for "swap".

    Raises:
        UsageError: unknown kind, or an option that is out of range or not of this kind.
    """
    known = _OPTIONS.get(kind, ())
    unknown = [f"--{key}" for key in options if key not in known]
    if unknown:
        allowed = f"it has {', '.join(f'--{key}' for key in known)}" if known else "it has none"
        raise UsageError(f"{kind} has no option {', '.join(unknown)}; {allowed}")
    if not known:
        return build(kind, seed)
    others = {key: value for key, value in options.items() if key != "robots"}
    count = _in_range(kind, int(options.get("robots", _COUNT)))
    return validated(_COUNTED[kind].build(count, seed=seed, **others))


TRIES = 5  # steps, of which the quickest is judged


def try_out(scenario: Scenario) -> None:
    """Let an external law make some steps for the first robot at its start.

    Raises:
        UsageError: there is no such law, or a step takes longer than a period.
        LawError: it fails, or does not return a velocity.
    """
    if ":" not in scenario.control.law:
        return
    robot = scenario.ids[0]
    law, own = GuardedLaw(scenario, robot), scenario.spec(robot)
    neighbours = _neighbours(scenario, robot)
    quickest = float("inf")
    for tick in range(TRIES):
        view = View(
            tick=tick,
            position=own.start,
            goal=own.goal,
            displacement=(0.0, 0.0),
            neighbours=neighbours,
            obstacles=tuple(scenario.shapes.values()),
        )
        begin = time.perf_counter()
        law.velocity(view)
        quickest = min(quickest, time.perf_counter() - begin)
        law.slice_norm(own.start, own.goal)
        if law.failure:
            raise LawError(law.failure)
    if quickest > scenario.time.step:
        raise UsageError(
            f"a step of the law {scenario.control.law} takes {1e3 * quickest:.3g} ms, longer than a "
            f"period of {1e3 * scenario.time.step:g} ms: make it quicker, or time.step longer"
        )


def _neighbours(scenario: Scenario, robot: int) -> Neighbours:
    others = [spec for spec in scenario.robots if spec.id != robot]
    heard = Neighbours({spec.id: spec.radius for spec in others})
    for spec in others:
        x, y = spec.start
        gamma = (x - spec.goal[0]) ** 2 + (y - spec.goal[1]) ** 2
        pull = 2.0 * gamma**0.5
        heard.on_state(
            PeerState(spec.id, 1, 0, True, x, y, 0.0, gamma, pull, 0.0, 0.0, radius=spec.radius), 0
        )
    return heard


def load(name: str, settings: Sequence[str] = (), seed: int | None = None) -> Scenario:
    """The scenario `name`, ready to run: as `read`, with k as a number and its law tried out."""
    return prepared(_certified(name, read(name, settings, seed)))


def prepared(scenario: Scenario) -> Scenario:
    """The scenario with k as a number, its plant's library present and its law tried out; warns of doubts."""
    for doubt in doubts(scenario):
        LOG.warning(f"{scenario.name}: {doubt}")
    scenario = resolved(scenario)
    require_plant(scenario.world.plant)
    try_out(scenario)
    return scenario


def read(name: str, settings: Sequence[str] = (), seed: int | None = None) -> Scenario:
    """The scenario of a file or of the library, with settings applied.

    Args:
        name: a file or a library name.
        settings: `path.to.key=VALUE`, as in `protocol.scenario.file`.
        seed: replaces the scenario's; it determines the random values of a library scenario.

    Raises:
        ScenarioError: the scenario or a setting is invalid; lists every problem.
        MapError: its map cannot be read.
        UsageError: there is no such file or library name.
    """
    document = apply_settings(_document(name, seed), settings)
    if "map" not in document:
        return parse_document(document, name)
    from deploy.maps.scenario import blamed_on_map, expanded

    try:
        return parse_document(expanded(document, Path(name).parent, name), name)
    except ScenarioError as error:
        own = document.get("obstacles", [])
        raise blamed_on_map(error, len(own) if isinstance(own, list) else 0) from None


def resolved(scenario: Scenario) -> Scenario:
    """The scenario with a number in place of k = "auto"; raises UsageError for "certified"."""
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
    if path.suffix or "/" in name:
        raise UsageError(
            f"no scenario file {name!r}; the library has names such as figure-1 (see scenario list)"
        )
    return document_of(build(name, seed))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError as error:
        raise UsageError(f"scenario file {str(path)!r}: {error.strerror}") from None
