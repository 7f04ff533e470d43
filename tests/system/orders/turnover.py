"""Fleets in which robots come and go: a guest among four, and 3 to 12 under all faults."""

import math
import random
from dataclasses import replace
from typing import Any

import msgspec
import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Query
from protocol.keys import world_key
from protocol.operations import Reply, decode_reply
from protocol.scenario.model import Order, RobotSpec, Scenario, Sensing
from protocol.scenario.network import Link, Partition

SWAP, ENDLESS = load("swap-4"), load("swap-4", ["time.endless=true"])
GUEST = RobotSpec(7, 0.03, (0.0, 0.0), (0.0, 0.22))  # where the four of them pass
GUESTED = replace(SWAP, orders=(Order(0.2, add=GUEST),))
_ROOM = 0.36  # m from the centre, in which robots are sent about
_FEWEST, _MOST, _IDS = 3, 12, 20
_EVERY = 15  # ticks between changes


def faulty(seed: int) -> Scenario:
    """The scenario: everything that can go wrong does, a partition of five seconds in each half minute."""
    sides = tuple(range(1, _IDS, 2)), tuple(range(2, _IDS, 2))
    parts = tuple(Partition(at, at + 5.0, sides) for at in (10.0, 40.0, 70.0, 100.0))
    return replace(
        ENDLESS,
        seed=seed,
        link=Link(delay=(0.0, 0.3), loss=0.2, duplicate=0.1, partition=parts),
        sensing=(Sensing(noise=0.001, delay=(0.0, 0.1), dropout=0.1),),
    )


def asked(fleet: LocalFleet, change: dict[str, Any] | None = None) -> Reply:
    replies: list[bytes] = []
    payload = b"" if change is None else msgspec.msgpack.encode(change)
    fleet.world.handle(Query(world_key(fleet.run, "operation"), payload, replies.append))
    return decode_reply(replies[0], Reply)


def status(fleet: LocalFleet, robot: int) -> str:
    """What the world's roster says of a robot; "" if it does not know it."""
    return next((each.status for each in asked(fleet).roster.members if each.robot == robot), "")


def step(fleet: LocalFleet, ticks: int) -> None:
    for _ in range(ticks):
        assert fleet.step()


def to_be(fleet: LocalFleet, robot: int, wanted: str) -> None:
    """Go on until a robot has this status, for 400 ticks at most."""
    for _ in range(400):
        if status(fleet, robot) == wanted:
            return
        assert fleet.step()
    pytest.fail(f"robot {robot} is {status(fleet, robot)}, not {wanted}")


class Turnover:
    """One such fleet.

    Attributes:
        changes: accepted so far, by kind.
    """

    def __init__(self, seed: int) -> None:
        self.draw = random.Random(seed)
        self.fleet = LocalFleet(faulty(seed))
        self.changes = 0

    def run(self, ticks: int) -> None:
        for tick in range(ticks):
            assert self.fleet.step()
            if tick % _EVERY == 0:
                self.changes += self._change()

    def settles(self, most: int) -> bool:
        """Whether every robot still reaches its goal, `most` ticks at most after all changes.

        Goals are places on a circle, far enough apart that all can be there.
        """
        world = self.fleet.world.world
        for _ in range(200):  # added robots appear, dead ones are fenced and restarted
            assert self.fleet.step()
        self._revive()
        for _ in range(40):
            assert self.fleet.step()
        robots = [each.robot for each in asked(self.fleet).roster.members if each.status == "live"]
        for number, robot in enumerate(robots):
            angle = math.tau * number / len(robots)
            assert self._send(robot, [(0.3 * math.cos(angle), 0.3 * math.sin(angle))])
        for _ in range(most):
            if all(each.status == "arrived" for each in world.goal_statuses() if each.robot in robots):
                return True
            assert self.fleet.step()
        return False

    def _change(self) -> bool:
        draw = self.draw
        members = {each.robot: each.status for each in asked(self.fleet).roster.members}
        live = [robot for robot, status in members.items() if status == "live"]
        there = sum(status != "gone" for status in members.values())
        kind = draw.choice(["add", "remove", "kill", "goal", "goal"])
        if kind == "add" and there < _MOST:
            free = [each for each in range(1, _IDS) if members.get(each, "gone") == "gone"]
            spec = RobotSpec(draw.choice(free), draw.uniform(0.015, 0.03), self._place(), self._place())
            return asked(self.fleet, {"add": spec}).accepted
        if kind == "remove" and len(live) > _FEWEST:
            return asked(self.fleet, {"remove": draw.choice(live)}).accepted
        if kind == "kill" and len(live) > _FEWEST:
            self._revive()
            self.fleet.kill(draw.choice(live))
            return True
        return bool(live) and self._send(draw.choice(live), [self._place()])

    def _revive(self) -> None:
        for member in asked(self.fleet).roster.members:
            if member.status == "standing" and member.incarnation:
                self.fleet.kill(member.robot)
                self.fleet.start(member.robot).on_timer(math.inf)

    def _send(self, robot: int, points: list[tuple[float, float]]) -> bool:
        return asked(self.fleet, {"goal": {"robot": robot, "points": points}}).accepted

    def _place(self) -> tuple[float, float]:
        size, angle = _ROOM * math.sqrt(self.draw.random()), math.tau * self.draw.random()
        return size * math.cos(angle), size * math.sin(angle)
