"""The same scenario at another place."""

from __future__ import annotations

from dataclasses import replace

from protocol.scenario.model import Journey, Order, Part, Point, RobotSpec, Scenario, Thing, Workspace


def shifted(scenario: Scenario, dx: float, dy: float) -> Scenario:
    """A scenario in a polygonal room, all of which is moved by (dx, dy), m."""

    def moved(point: Point) -> Point:
        return point[0] + dx, point[1] + dy

    def robot(spec: RobotSpec) -> RobotSpec:
        return replace(spec, start=moved(spec.start), goal=moved(spec.goal))

    def thing(each: Thing) -> Thing:
        if each.points is not None:
            return Thing(points=tuple(map(moved, each.points)))
        assert each.center is not None
        return Thing(center=moved(each.center), radius=each.radius)

    def journey(goal: Journey) -> Journey:
        return replace(goal, points=tuple(map(moved, goal.points)))

    def order(each: Order) -> Order:
        return replace(
            each,
            goal=None if each.goal is None else journey(each.goal),
            add=None if each.add is None else robot(each.add),
            place=None if each.place is None else thing(each.place),
        )

    assert scenario.workspace.points is not None
    return replace(
        scenario,
        workspace=Workspace(points=tuple(map(moved, scenario.workspace.points))),
        robots=tuple(map(robot, scenario.robots)),
        things=tuple(map(thing, scenario.things)),
        parts=tuple(Part(part.radius, moved(part.start), moved(part.goal)) for part in scenario.parts),
        orders=tuple(map(order, scenario.orders)),
    )
