"""Scenarios made to measure: a kind, a seed and a few options."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from deploy.library.names import build
from deploy.library.random_instances import PAPER_DENSITY, random_instance
from deploy.library.swaps import swap
from protocol.errors import UsageError
from protocol.scenario.model import Scenario

Options = Mapping[str, float]

_COUNT = 6  # robots, unless given


def generate(kind: str, seed: int, options: Options) -> Scenario:
    """A scenario of `kind`: "random", "swap", or a name of the library.

    Args:
        options: "robots", "density" and "unequal" for "random", "robots" and "jitter" for "swap".

    Raises:
        UsageError: no such kind, an option that this kind does not have, or one out of range.
    """
    make, known = _KINDS.get(kind, (None, ()))
    foreign = [f"--{key}" for key in options if key not in known]
    if foreign:
        allowed = f"it has {', '.join(f'--{key}' for key in known)}" if known else "it has none"
        raise UsageError(f"{kind} has no option {', '.join(foreign)}; {allowed}")
    return build(kind, seed) if make is None else make(seed, options)


def _random(seed: int, options: Options) -> Scenario:
    return random_instance(
        int(options.get("robots", _COUNT)),
        seed,
        density=options.get("density", PAPER_DENSITY),
        unequal=options.get("unequal", 0.0),
    )


def _swap(seed: int, options: Options) -> Scenario:
    return swap(int(options.get("robots", _COUNT)), options.get("jitter", 0.0), seed)


_KINDS: dict[str, tuple[Callable[[int, Options], Scenario], tuple[str, ...]]] = {
    "random": (_random, ("robots", "density", "unequal")),
    "swap": (_swap, ("robots", "jitter")),
}
