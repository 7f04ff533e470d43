"""The report lists the operators' requests: goals, robots added and removed, every emergency stop."""

import json
import time

import msgspec

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Query
from protocol.bus.local import LocalNetwork
from protocol.codec import decode
from tests.listening import overhear
from world.shell.node import WorldNode

ASKED = (
    {"goal": {"robot": 2, "points": [[0.05, 0.02]]}},
    {"goal": {"robot": 2, "points": [[9.0, 0.0]]}},
    {"remove": 1},
    {"place": {"center": [0.0, 0.25], "radius": 0.01}},
    {"halt": True},
    {"halt": True},
    {"halt": False},
    {"release": 1},
    {"release": 2},
    {},
)
MALFORMED = (b'{"tak": 99}', b"\xc1")  # each is answered in its form


def test_a_log_holds_every_order_and_a_person_hears_of_every_stop() -> None:
    said: list[str] = []
    noted: list[str] = []
    bus = LocalNetwork().connect()
    world = WorldNode(bus, "r", load("swap-2"), warn=said.append, info=noted.append)
    replies: list[bytes] = []
    for payload in (*(json.dumps(request).encode() if request else b"" for request in ASKED), *MALFORMED):
        world.handle(Query("disknav/r/world/operation", payload, replies.append))
    *replies, said_of_json, said_of_msgpack = replies
    for refusal in json.loads(said_of_json), msgspec.msgpack.decode(said_of_msgpack):
        assert (refusal["accepted"], refusal["text"][:10]) == (False, "operation:")
    assert len(replies) == len(ASKED)
    assert said == ["tick 0: emergency stop", "tick 0: released"]
    outcomes = [json.loads(reply)["accepted"] for reply in replies[4:9]]
    assert outcomes == [True, True, False, False, True], "a release names both stops"
    assert noted[0] == "tick 0: robot 2 is sent to [(0.05, 0.02)]"
    assert noted[1].startswith("tick 0: robot 2 is sent to [(9.0, 0.0)]: refused, ")
    assert noted[2].startswith("tick 0: robot 1 goes")
    assert noted[3].startswith("tick 0: an obstacle comes")
    assert len(noted) == 4


def test_who_listens_before_the_first_tick_hears_where_the_robots_start() -> None:
    fleet, heard = LocalFleet(load("swap-2")), list[int]()
    fleet.world.on_timer(time.monotonic())  # it tells monitors that it waits

    def hear(key: str, payload: bytes) -> None:
        heard.append(decode(key, payload).tick)

    overhear(fleet.network, hear, "disknav/local/world/truth")
    fleet.execute()
    assert heard == list(range(fleet.world.world.tick + 1))
