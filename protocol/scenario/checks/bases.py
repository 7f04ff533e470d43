"""What must hold of bases outside: bodies that brake, keys that can be told apart, no scripted faults."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from protocol.scenario.base import Base
from protocol.scenario.checks.bodies import fields_of
from protocol.scenario.checks.sound import Sound
from protocol.scenario.model import Time, World
from protocol.scenario.shape import Finding, Steps

_WILD = "*?#$ "
_TICKS = 3  # from a Command to the Tick that says that it was heard, and one that is late


def base_findings(sound: Sound) -> Iterator[Finding]:
    """Everything that is wrong with bases."""
    external = sound.get("world", "plant") == "external"
    default = sound.get("base")
    yield from _names(("base",), default)
    keys: dict[str, int] = {}
    for index in range(sound.size("robots")):
        steps: Steps = ("robots", index, "base")
        own = sound.get(*steps)
        yield from _names(steps, own)
        table = default if own is None else own
        if not (external or isinstance(table, dict)):
            continue
        body = sound.get("robots", index, "body")
        kind = fields_of(sound.get("body") if body is None else body).get("kind", "point")
        if kind == "point":
            yield (
                ("robots", index, "body"),
                'a base outside cannot stop at once: say which body it is, such as "turtlebot3-burger"',
            )
        key = _key(table, sound.get("robots", index, "id"))
        if key is not None and keys.setdefault(key, index) != index:
            yield steps, f"has the same key {key} as robots[{keys[key]}]: give it a namespace of its own"
    if external:
        yield from _external(sound)


def _external(sound: Sound) -> Iterator[Finding]:
    if sound.size("process"):
        yield ("process",), "nobody can script what happens to a fleet that is not simulated"
    if sound.get("network", "interest") == "near":
        yield (
            ("network", "interest"),
            "the world has no summary of a fleet that is not simulated: leave it out",
        )
    step = sound.get("time", "step", default=Time().step)
    lease = sound.get("world", "lease", default=World().lease)
    if step is not None and lease is not None and lease < _TICKS * step:
        yield ("world", "lease"), f"must be at least {_TICKS} ticks, {_TICKS * step:g} s, is {lease:g} s"


def _names(steps: Steps, base: Any) -> Iterator[Finding]:
    """Topics that would be patterns."""
    for key, name in base.items() if isinstance(base, dict) else ():
        if key in ("namespace", "velocity", "odometry", "pose") and set(_WILD) & set(str(name)):
            yield (*steps, key), f"must have none of {' '.join(_WILD.strip())} and no space"


def _key(base: Any, robot: int | None) -> str | None:
    """Under which key a robot's base hears velocities; None where that is malformed."""
    namespace, velocity = ((base or {}).get(key, getattr(Base(), key)) for key in ("namespace", "velocity"))
    if robot is None or not isinstance(namespace, str) or not isinstance(velocity, str):
        return None
    return Base(namespace=namespace).key(robot, velocity)
