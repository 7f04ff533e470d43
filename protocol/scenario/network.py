"""The network between robots: delay, loss, radio effects, and the peers whose States a robot receives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from protocol.scenario.body import NonNegative, Positive, Probability, RobotId, Span


@dataclass(frozen=True, slots=True)
class Partition:
    """Between two times (s), States pass only inside each group; a robot in no group receives none."""

    from_: NonNegative  # s of simulated time
    until: Positive  # s
    groups: tuple[tuple[RobotId, ...], ...]


@dataclass(frozen=True, slots=True)
class Burst:
    """Each robot's radio has good and bad times at random, as Gilbert and Elliott have it; a State suffers
    from a bad time of its sender and from one of its receiver."""

    good: Positive = 10.0  # s, mean length of a good time
    bad: Positive = 0.5  # s, mean length of a bad one
    delay: Span = 0.0  # s, added by each radio in a bad time
    loss: Probability = 0.0  # that a radio in a bad time loses a State


@dataclass(frozen=True, slots=True)
class Roaming:
    """Each robot's radio changes its access point now and then; States wait for the end of the gap."""

    every: Positive = 60.0  # s, with one gap in each, at a random time
    gap: Span = 0.5  # s


@dataclass(frozen=True, slots=True)
class Distance:
    """Additional delay and loss of States per metre between two robots beyond `free`."""

    free: NonNegative = 0.0  # m
    delay: NonNegative = 0.0  # s/m
    loss: NonNegative = 0.0  # 1/m, probability


Wireless = Literal["good-wifi", "crowded-2.4ghz", "roaming"]


@dataclass(frozen=True, slots=True)
class Link:
    """How States travel between every two robots. A random delay reorders by itself."""

    delay: Span = 0.0  # s, one way
    jitter: NonNegative = 0.0  # s, added uniformly from [0, jitter]
    loss: Probability = 0.0  # that a State is lost
    duplicate: Probability = 0.0  # that a State arrives twice
    partition: Annotated[tuple[Partition, ...], Meta(max_length=50_000)] = ()
    capacity: Positive | None = None  # States per second of all robots together: a shared medium
    burst: Burst | None = None
    roaming: Roaming | None = None
    distance: Distance | None = None
    preset: Wireless | None = None  # for fields with their defaults

    def __post_init__(self) -> None:
        for key, value in WIRELESS.get(self.preset or "", {}).items():
            if getattr(self, key) in (0.0, None):
                object.__setattr__(self, key, value)


# Half of a measured round trip is one way; a State crosses the radios of its sender and of its receiver.
WIRELESS: dict[str, dict[str, tuple[float, float] | Burst | Roaming]] = {  # sources: docs/guides/networks.md
    "good-wifi": {"delay": (0.0, 0.02), "burst": Burst(9.0, 1.0, (0.0, 0.125))},
    "crowded-2.4ghz": {"delay": (0.0, 0.04), "burst": Burst(9.0, 1.0, (0.05, 0.125))},
    "roaming": {"roaming": Roaming(14.0, (1.2, 4.7))},
}


@dataclass(frozen=True, slots=True)
class Network:
    """The States that a robot receives: all, or those of near robots; positions of others twice a second."""

    interest: Literal["near", "all"] | None = None  # unless given, near above 32 robots or 200 obstacles
    reach: Positive | None = None  # m, gap of two disks below which they are near; by speed unless given
