"""The scenarios whose trajectories are kept: the library, and some of it under faults."""

from collections.abc import Callable, Mapping
from functools import partial

from deploy.library.encounters import swap
from deploy.library.load import catalogue, load, resolved
from protocol.scenario.model import Scenario

_COUNTED = ("swap-2", "swap-3", "swap-6", "random-1", "random-6", "random-12", "boxes-4", "beads-5")
_NOISE = ("sensing.delay=[0.0,0.1]", "sensing.noise=0.001", "sensing.dropout=0.1", "actuation.noise=0.02")
_LINK = ("link.delay=[0.1,0.3]", "link.jitter=0.1", "link.loss=0.3", "link.duplicate=0.2")


def _moved_swap() -> Scenario:
    """Off the saddle by up to 10 mm, so that no last bit decides which robot passes on which side."""
    return resolved(swap(6, 0.01, 3))


CASES: Mapping[str, Callable[[], Scenario]] = {
    **{entry.name: partial(load, entry.name) for entry in catalogue() if not entry.name.endswith("-N")},
    **{name: partial(load, name) for name in _COUNTED},
    "figure-3e, own pace": partial(load, "figure-3e", ['control.additions=["jams", "escape"]']),
    "figure-3d, bare law": partial(load, "figure-3d", ["control.filter=none", 'control.additions=["pace"]']),
    "figure-3c, noise": partial(load, "figure-3c", _NOISE),
    "random-12, bad link": partial(load, "random-12", _LINK),
    "crash, bad link": partial(load, "crash", _LINK),
    "swap of 6, off the saddle": _moved_swap,
}
"""By name; a function each, as some take a moment to draw."""

SADDLES = frozenset({"swap-6"})
"""Exactly symmetric: the last bit of the first step decides where all go, so no tolerance has a meaning."""

LONG = frozenset({"boxes-4", "random-12, bad link"})
"""Seconds of work each."""
