"""What `disknav check` says of a scenario: what the theory says about it, and what is seen in practice."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from deploy.theory.check.practice import Practice
from deploy.theory.gain.assumptions import Status
from deploy.theory.gain.bounds import Bounds


@dataclass(frozen=True)
class Free:
    """Whether a configuration is free, and its smallest clearance, m (negative is overlap)."""

    free: bool
    clearance: float


@dataclass(frozen=True)
class Shortfall:
    """A cluster for which an assumption is not shown. Ids, None when it stands for all clusters of its size.

    margin: left-hand side minus right-hand side, m, not positive.
    """

    robots: tuple[int, ...] | None
    size: int
    margin: float
    status: Status


@dataclass(frozen=True)
class Assumption:
    """One assumption over all clusters, in the limit of small eps; worst: the smallest margin, m."""

    status: Status
    worst: float
    clusters: int
    failing: int
    shortfalls: tuple[Shortfall, ...]  # smallest clusters first, then the widest gap; at most LISTED


@dataclass(frozen=True)
class Certified:
    """What a stored certificate proves, None when nothing yet, or why it was refused."""

    file: str
    k: float | None
    refused: str | None = None


@dataclass(frozen=True)
class CheckReport:
    """Everything `disknav check` says. Lengths in m, eps in m^2.

    exact: every cluster was looked at and Lambda', Lambda'' are attained; else they are proven upper bounds.
    bounds: at the best eps, None where the assumptions are not shown.
    """

    scenario: str
    robots: int
    density: float
    tight: float | None
    k: float
    automatic: bool
    automatic_k: float
    start: Free
    goal: Free
    unreachable: tuple[tuple[int, int, int], ...]
    every_cluster: bool
    exact: bool
    assumption_1: Assumption
    assumption_2: Assumption
    bounds: Bounds | None
    practice: Practice | None
    certificate: Certified | None

    @property
    def guaranteed(self) -> bool:
        """Whether the theory covers the k in use."""
        return self.bounds is not None and self.k > self.bounds.polar


def to_json(found: CheckReport) -> dict[str, Any]:
    """Plain data; an infinite number becomes None, since JSON has none."""
    plain = finite(asdict(found)) | {"guaranteed": found.guaranteed}
    if found.bounds is not None:
        plain["bounds"] |= {"k2": found.bounds.k2, "polar": found.bounds.polar}
    return dict(plain)


def finite(value: Any) -> Any:
    """Plain data with None for every number that is not finite."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
