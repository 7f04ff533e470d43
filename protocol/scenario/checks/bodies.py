"""What must hold of bodies: wheels somewhere, a hull inside its disk, and a plant that can move them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from protocol.scenario.body import BRISKEST, LONGEST, PRESETS, SHORTEST, Body, Preset
from protocol.scenario.checks.sound import Sound
from protocol.scenario.model import RobotSpec
from protocol.scenario.shape import Document, Finding, Steps, written


def with_radii(document: Document) -> Document:
    """The document, where a robot that has no radius is given that of its body's disk, if this has one."""
    robots, orders, body = document.get("robots"), document.get("orders"), document.get("body")
    if isinstance(robots, list):
        document = document | {"robots": [_with_radius(robot, body) for robot in robots]}
    if isinstance(orders, list):
        document = document | {"orders": [_with_newcomer(order, body) for order in orders]}
    return document


def _with_newcomer(order: Any, default: Any) -> Any:
    if isinstance(order, dict) and "add" in order:
        return order | {"add": _with_radius(order["add"], default)}
    return order


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
    step = sound.get("time", "step")
    if physics and step is not None and not SHORTEST <= step <= LONGEST:
        yield (
            ("time", "step"),
            f"must be from {SHORTEST:g} to {LONGEST:g} s in MuJoCo: "
            "with other periods the errors of bodies were not measured",
        )
    for robot in robots_of(sound):
        steps: Steps = (*robot, "body")
        own = sound.get(*steps)
        yield from _wheels(steps, fields_of(own))
        body = fields_of(sound.get("body") if own is None else own)
        yield from _hull((*robot, "radius"), body, sound.get(*robot, "radius"))
        if physics and body:
            yield from _physical(steps, body)


def misfits(spec: RobotSpec, default: Preset | Body) -> Iterator[str]:
    """What is wrong with a robot's body, the default unless it has one of its own."""
    own = default if spec.body is None else spec.body
    body = asdict(PRESETS[own] if isinstance(own, str) else own)
    for steps, text in (*_wheels(("body",), body), *_hull(("radius",), body, spec.radius)):
        yield f"{written(steps)}: {text}"


def robots_of(sound: Sound) -> list[Steps]:
    """Where robots are described: those of the start, and those that orders add."""
    added: list[Steps] = [("orders", index, "add") for index in range(sound.size("orders"))]
    return [
        *(("robots", index) for index in range(sound.size("robots"))),
        *(steps for steps in added if sound.get(*steps)),
    ]


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


def _physical(steps: Steps, body: dict[str, Any]) -> Iterator[Finding]:
    """Why a body cannot be had in MuJoCo."""
    if body.get("kind") != "differential-drive":
        yield steps, 'world.plant = "mujoco" moves robots on two wheels only, such as "turtlebot3-burger"'
    elif body.get("acceleration", BRISKEST + 1.0) > BRISKEST:
        yield (*steps, "acceleration"), f"must be at most {BRISKEST:g} in MuJoCo, or wheels slip"


def _hull(steps: Steps, body: dict[str, Any], radius: float | None) -> Iterator[Finding]:
    hull, offset = body.get("radius"), body.get("offset") or 0.0
    if radius is not None and hull is not None and radius < (least := hull + offset) * (1.0 - 1e-9):
        yield steps, f"must be at least {least:g}, for the body lies inside the disk"
