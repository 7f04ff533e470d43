"""What is left of a world for its successor."""

from __future__ import annotations

import msgspec

from protocol.messages import Count, Id
from world.coordinator.membership import FleetChange
from world.coordinator.records import Mission, PastLives
from world.judge.record import PastReferee
from world.plants.plant import PastDisks


class Past(msgspec.Struct, frozen=True):
    """State of a world for a successor in the same run.

    It is not the state of a process: lives, lines, grants and messages on their way end with their world.
    """

    tick: Count = 0  # open, or next to open
    founded: bool = False
    stopped: bool = False
    stops: Count = 0
    scheduled: Count = 0  # number of the scenario's latest stop
    lives: PastLives | None = None
    missions: dict[Id, Mission] = {}
    numbered: Count = 0  # orders to robots
    fleet: FleetChange | None = None
    orders: list[str] = []  # executed orders of the scenario, as `Schedule.past`
    missed: Count = 0  # Commands
    refused: dict[str, Count] = {}  # Commands, by reason
    disks: PastDisks | None = None
    referee: PastReferee | None = None
