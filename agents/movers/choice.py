"""Which part a robot fetches next."""

from __future__ import annotations

from collections.abc import Collection

from agents.movers.outlook import Outlook
from agents.movers.plan import Errand, Planner
from protocol.messages import Vector


def choose(
    planner: Planner, position: Vector, outlook: Outlook, avoided: Collection[int], goals: dict[int, Vector]
) -> Errand | None:
    """The nearest part after which all others can be brought, too, by whomever; where there is no order for
    all, one that makes room; None to wait.

    Args:
        position: own, m.
        avoided: parts that could not be reached.
        goals: of all parts, m.
    """
    nearest: Errand | None = None
    floor = outlook.floor
    for errand in planner.errands(position, floor):
        if errand.part in floor.promised or errand.part in avoided:
            continue
        nearest = nearest or errand
        if fits(planner, errand.part, position, outlook, goals):
            return errand
    if floor.promised or planner.has_order(floor, position):
        return None
    return planner.clearing(position, floor) or nearest


def fits(planner: Planner, part: int, position: Vector, outlook: Outlook, goals: dict[int, Vector]) -> bool:
    """Whether all get to their goals if a robot brings this part there next, beside all that is claimed."""
    return planner.leads_on(part, outlook.floor, position) and _agrees(
        planner, part, position, outlook, goals
    )


def _agrees(planner: Planner, own: int, position: Vector, outlook: Outlook, goals: dict[int, Vector]) -> bool:
    """Whether it does not matter who of all that are under way is done before whom: each finds its way after
    any one of the others, and after all of them."""
    at = {peer.robot: peer.position for peer in outlook.peers}
    jobs = {claim.part: at[robot] for robot, claim in outlook.claims} | {own: position}
    for part, begin in jobs.items():
        others = [each for each in jobs if each != part]
        for done in ([], *([each] for each in others), others):
            floor = outlook.floor
            for each in done:
                floor = floor.moved(each, goals[each])
            finds = planner.orders.can_fetch if part in floor.parts else planner.orders.can_deliver
            if begin is not None and not finds(part, floor, begin):
                return False
    return True
