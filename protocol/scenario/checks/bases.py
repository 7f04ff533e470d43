"""What must hold of bases outside: bodies that brake, keys that can be told apart, no scripted faults."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from protocol.errors import UsageError
from protocol.scenario.base import FRAMES, TOPICS, Base, ros_name
from protocol.scenario.checks.bodies import fields_of, robots_of
from protocol.scenario.checks.sound import Sound
from protocol.scenario.model import Time, World
from protocol.scenario.shape import Finding, Steps, written

_TICKS = 3  # from a Command to the Tick that says that it was heard, and one that is late


def base_findings(sound: Sound) -> Iterator[Finding]:
    """Everything that is wrong with bases."""
    external = sound.get("world", "plant") == "external"
    default = sound.get("base")
    yield from _names(("base",), default)
    keys: dict[str, Steps] = {}
    for robot in robots_of(sound):
        steps: Steps = (*robot, "base")
        own = sound.get(*steps)
        yield from _names(steps, own)
        table = default if own is None else own
        if not (external or isinstance(table, dict)):
            continue
        body = sound.get(*robot, "body")
        kind = fields_of(sound.get("body") if body is None else body).get("kind", "point")
        if kind == "point":
            yield (
                (*robot, "body"),
                'a base outside cannot stop at once: say which body it is, such as "turtlebot3-burger"',
            )
        yield from _shared(steps, table, sound.get(*robot, "id"), keys)
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
    """Names that no key can have, and frames that no header should have."""
    for key, name in base.items() if isinstance(base, dict) else ():
        if key in (*TOPICS, "namespace") and isinstance(name, str):
            try:
                ros_name(name)
            except UsageError as error:
                yield (*steps, key), str(error)
            if key != "namespace" and not name.strip("/"):
                yield (*steps, key), "must not be empty"
        if key in FRAMES and isinstance(name, str) and not name.isprintable():
            yield (*steps, key), "must have no control characters"


def _shared(steps: Steps, base: Any, robot: int | None, seen: dict[str, Steps]) -> Iterator[Finding]:
    """Keys that two topics have, of one robot or of two; `seen` are those of robots before this one."""
    named = {key: value for key, value in (base or {}).items() if key in (*TOPICS, "namespace")}
    if robot is None or not all(isinstance(value, str) for value in named.values()):
        return
    own = Base(**named).of(robot)
    keys: dict[str, str] = {}
    for topic in TOPICS:
        key = own.key(getattr(own, topic))
        if keys.setdefault(key, topic) != topic:
            yield steps, f"`{keys[key]}` and `{topic}` are both {key}: give each topic a name of its own"
        elif key in seen:
            yield steps, f"has the same key {key} as {written(seen[key])}: give it a namespace of its own"
            return
    seen.update(dict.fromkeys(keys, steps[:-1]))
