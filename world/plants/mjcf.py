"""A fleet on two wheels each as a model of MuJoCo: https://mujoco.readthedocs.io/en/stable/XMLreference.html.

Each robot is a hull, two driven wheels and two casters. Around its control point lies its disk, a cylinder
that exerts no force, but whose contacts with the others' the engine reports: with `margin` -1 and `gap` 1 a
contact is found as soon as two overlap, and is never given to the solver.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element, SubElement, tostring

from protocol.scenario.body import Body
from protocol.scenario.model import RobotSpec, Scenario

TIMESTEP = 0.002  # s
_WHEEL = 0.2  # of the track: radius of a wheel
_DENSITY = 32.0  # kg/m^2 of a hull: a disk of radius 0.1 m weighs a kilogram
_LAG = 0.015  # s, time constant of a wheel's servo; its gain must stay small for the wheel's inertia
_PUSH = 3.0  # m/s^2: what both servos together can do
_COLOURS = (
    "0.12 0.47 0.71",
    "1.00 0.50 0.05",
    "0.17 0.63 0.17",
    "0.84 0.15 0.16",
    "0.58 0.40 0.74",
    "0.55 0.34 0.29",
)


def wheel_radius(body: Body) -> float:
    """Radius of the wheels that a body is given, m."""
    return _WHEEL * body.track


def model(scenario: Scenario) -> str:
    """The XML of a scenario, all of whose robots have two wheels."""
    root = Element("mujoco", model=scenario.name)
    SubElement(
        root, "option", timestep=f"{TIMESTEP}", integrator="implicitfast", cone="elliptic", impratio="10"
    )
    visual = SubElement(root, "visual")
    SubElement(visual, "global", offwidth="1200", offheight="900")
    SubElement(visual, "headlight", ambient="0.5 0.5 0.5", diffuse="0.5 0.5 0.5")
    world = SubElement(root, "worldbody")
    SubElement(world, "light", pos="0 0 5", dir="0 0 -1", diffuse="0.4 0.4 0.4")
    size = 2.0 * scenario.workspace.shape.around.radius
    SubElement(world, "geom", name="floor", type="plane", size=f"{size} {size} 0.1", rgba="0.9 0.9 0.88 1")
    actuator = SubElement(root, "actuator")
    for spec in sorted(scenario.robots, key=lambda each: each.id):
        _robot(world, actuator, spec, scenario.body_of(spec.id))
    return tostring(root, encoding="unicode")


def _robot(world: Element, actuator: Element, spec: RobotSpec, body: Body) -> None:
    hull = spec.radius - body.offset if body.radius is None else body.radius
    wheel, mass = wheel_radius(body), _DENSITY * math.pi * hull * hull
    x = spec.start[0] - body.offset * math.cos(spec.heading)
    y = spec.start[1] - body.offset * math.sin(spec.heading)
    half = 0.5 * spec.heading
    name, colour = f"{spec.id}", _COLOURS[spec.id % len(_COLOURS)]
    base = SubElement(
        world, "body", name=name, pos=f"{x} {y} {wheel}", quat=f"{math.cos(half)} 0 0 {math.sin(half)}"
    )
    SubElement(base, "freejoint", name=name)
    # The weight lies low, between a caster in front and one behind: the body must not pitch when it brakes.
    SubElement(
        base, "geom", type="cylinder", size=f"{0.5 * hull} {0.3 * wheel}", pos=f"0 0 {-0.2 * wheel}",
        mass=f"{mass}", contype="0", conaffinity="0", rgba="0.2 0.2 0.2 1",
    )  # fmt: skip
    SubElement(
        base, "geom", name=f"hull {name}", type="cylinder", size=f"{hull} {wheel}", pos=f"0 0 {2.2 * wheel}",
        mass="0.001", rgba=f"{colour} 1",
    )  # fmt: skip
    for place in (0.75 * hull, -0.75 * hull):
        SubElement(
            base, "geom", type="sphere", size=f"{0.4 * wheel}", pos=f"{place} 0 {-0.59 * wheel}", mass="0.01",
            condim="1", friction="0 0 0", priority="1",
        )  # fmt: skip
    SubElement(
        base, "geom", name=f"disk {name}", type="cylinder", size=f"{spec.radius} {0.1 * wheel}",
        pos=f"{body.offset} 0 {-0.5 * wheel}", mass="0", contype="2", conaffinity="2", margin="-1", gap="1",
        rgba=f"{colour} 0.3",
    )  # fmt: skip
    SubElement(base, "site", name=name, pos=f"{body.offset} 0 0", size="0.001")
    gain, torque = 0.5 * mass * wheel * wheel / _LAG, 0.5 * _PUSH * mass * wheel
    for side, place in (("left", 0.5), ("right", -0.5)):
        _wheel(base, f"{side} {name}", place * body.track, wheel, 0.1 * mass * wheel * wheel)
        SubElement(
            actuator,
            "velocity",
            name=f"{side} {name}",
            joint=f"{side} {name}",
            kv=f"{gain}",
            forcerange=f"{-torque} {torque}",
        )


def _wheel(base: Element, name: str, place: float, radius: float, inertia: float) -> None:
    body = SubElement(base, "body", pos=f"0 {place} 0")
    SubElement(body, "joint", name=name, type="hinge", axis="0 1 0", armature=f"{inertia}")
    SubElement(
        body, "geom", type="cylinder", size=f"{radius} {0.25 * radius}", zaxis="0 1 0", mass="0.03",
        friction="1.0 0.005 0.0001", rgba="0.1 0.1 0.1 1",
    )  # fmt: skip
