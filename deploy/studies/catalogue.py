"""The studies by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from deploy.run.options import Transport
from deploy.studies.arrival import arrival
from deploy.studies.delay import delay
from deploy.studies.experiments import tightness, tuning
from deploy.studies.peers.study import peers
from deploy.studies.robustness import robustness
from deploy.studies.scale import scale
from deploy.studies.study import Study, StudyName

_BUILD: dict[StudyName, Callable[..., Study]] = {
    "tightness": tightness,
    "tuning": tuning,
    "robustness": robustness,
    "arrival": arrival,
    "delay": delay,
    "peers": peers,
    "scale": scale,
}
_DEFAULT: dict[StudyName, Transport] = {"tightness": "routed", "tuning": "routed"}
_ONE_AT_A_TIME: frozenset[StudyName] = frozenset({"scale"})  # its figures are speeds


@dataclass(frozen=True)
class Defaults:
    """What a study uses unless told otherwise."""

    transport: Transport
    one_job: bool


def defaults(name: StudyName) -> Defaults:
    """Real processes for the paper's experiments; elsewhere the in-process bus, with the same rows."""
    return Defaults(_DEFAULT.get(name, "local"), name in _ONE_AT_A_TIME)


def find(
    name: StudyName,
    runs: int | None,
    seed: int,
    transport: Transport | None,
    *,
    laws: Sequence[str] = (),
    only: Sequence[str] = (),
) -> Study:
    """The study, with `runs` runs a cell (its own number unless given) from `seed` on.

    Args:
        laws, only: see `peers`; other studies have none.
    """
    arguments: dict[str, Any] = {"seed": seed} if runs is None else {"seed": seed, "runs": runs}
    if name == "scale" and transport is not None:
        arguments["transports"] = (transport,)
    if name == "peers":
        arguments |= {"laws": laws, "only": only}
    return _BUILD[name](**arguments)
