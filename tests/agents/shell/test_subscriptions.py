"""Subscriptions change while no peer waits for the robot: new ones at once, withdrawals some ticks later."""

from dataclasses import replace

from agents.shell.subscriptions import Subscriptions
from deploy.library.load import load
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.joining import Admission
from protocol.keys import robot_key
from protocol.scenario.network import Network

NEAR = replace(load("swap-6"), network=Network("near"))
PERIOD = 5  # ticks


def near_only(robot: int) -> tuple[LocalBus, Subscriptions]:
    bus = LocalNetwork().connect()
    peers = Subscriptions(bus, "run", robot)
    peers.begin(Admission(1, True, NEAR))
    return bus, peers


def test_nothing_changes_before_there_is_time() -> None:
    bus, peers = near_only(1)
    peers.attend((1, 2))
    assert not bus.keys
    peers.apply(0)
    assert bus.keys == peers.readers.keys() == {robot_key("run", 2, "state")}
    peers.begin(Admission(2, True, NEAR))
    assert not peers.readers, "those of another life read States for that"


def test_subscriptions_follow_near_robots() -> None:
    bus, peers = near_only(1)
    heard = []
    for turn, near in enumerate(((2, 3), (3, 4), (4, 5), (4, 5), (2, 4))):
        peers.attend(near)
        for tick in range(PERIOD):
            peers.apply(turn * PERIOD + tick)
            if tick in (0, PERIOD - 1):
                heard.append({peer for peer in range(2, 7) if robot_key("run", peer, "state") in bus.keys})
    first, second, third = [{2, 3}, {2, 3}], [{2, 3, 4}, {2, 3, 4}], [{2, 3, 4, 5}, {3, 4, 5}]
    assert heard == [*first, *second, *third, {3, 4, 5}, {4, 5}, {2, 4, 5}, {2, 4, 5}]
    assert peers.readers.keys() == bus.keys
