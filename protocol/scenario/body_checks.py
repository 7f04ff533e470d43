"""What must hold of bodies: wheels somewhere, a hull inside its disk, and a plant that can move them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from protocol.scenario.body import PRESETS
from protocol.scenario.shape import Document, Finding, Steps
from protocol.scenario.sound import Sound


def with_radii(document: Document) -> Document:
    """The document, where a robot that has no radius is given that of its body's disk, if this has one."""
    robots = document.get("robots")
    if not isinstance(robots, list):
        return document
    filled = [_with_radius(robot, document.get("body")) for robot in robots]
    return document | {"robots": filled}


def _with_radius(robot: Any, default: Any) -> Any:
    if not isinstance(robot, dict) or "radius" in robot:
        return robot
    body = fields_of(robot.get("body", default))
    radius, offset = body.get("radius"), body.get("offset", 0.0)
    if isinstance(radius, int | float) and isinstance(offset, int | float):
        return robot | {"radius": radius + offset}
    return robot


def body_findings(sound: Sound) -> Iterator[Finding]:
    """Everything that is wrong with bodies."""
    yield from _wheels(("body",), fields_of(sound.get("body")))
    physics = sound.get("world", "plant") == "mujoco"
    for index in range(sound.size("robots")):
        steps: Steps = ("robots", index, "body")
        own = sound.get(*steps)
        yield from _wheels(steps, fields_of(own))
        body = fields_of(sound.get("body") if own is None else own)
        yield from _hull(index, body, sound.get("robots", index, "radius"))
        if physics and body and body.get("kind") != "differential-drive":
            yield steps, 'world.plant = "mujoco" moves robots on two wheels only, such as "turtlebot3-burger"'


def fields_of(body: Any) -> dict[str, Any]:
    """What is known of a body, by name or as a table; without one, a point."""
    if isinstance(body, dict):
        return body
    preset = PRESETS.get("point" if body is None else body) if isinstance(body, str | None) else None
    return {} if preset is None else asdict(preset)


def _wheels(steps: Steps, body: dict[str, Any]) -> Iterator[Finding]:
    if body.get("kind") == "differential-drive":
        for key in ("offset", "track"):
            if not body.get(key):
                yield (*steps, key), "must be above 0 for a body on two wheels"


def _hull(index: int, body: dict[str, Any], radius: float | None) -> Iterator[Finding]:
    hull, offset = body.get("radius"), body.get("offset") or 0.0
    if radius is not None and hull is not None and radius < (least := hull + offset) * (1.0 - 1e-9):
        yield ("robots", index, "radius"), f"must be at least {least:g}, for the body lies inside the disk"
