"""Who is in the fleet, while it runs: a request under `world/fleet`, which the world answers.

`{"add": {"id": 7, "radius": 0.04, "start": [x, y], "goal": [x, y]}}` has a disk appear once every robot keeps
clear of its place; then it stands, and its process may join. `{"remove": 7}` ends a robot and takes its disk
away. `add` takes the keys of `[[robots]]` in a scenario. An empty request asks who is there. The reply has
`accepted`, `roster` and `text`, why not. Maps in msgpack, or JSON text; the reply comes in the form of the
request.
"""

from __future__ import annotations

import msgspec

from protocol.errors import MessageError
from protocol.messages import Id, Roster
from protocol.requests.form import read_request
from protocol.scenario.model import RobotSpec

LIMIT = 16 * 1024  # bytes of a request


class Change(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is asked: one of both."""

    add: RobotSpec | None = None
    remove: Id | None = None

    def __str__(self) -> str:
        return f"robot {self.remove} goes" if self.add is None else f"robot {self.add.id} comes"


class FleetReply(msgspec.Struct, frozen=True):
    """Whether a change was accepted, and who is there.

    Attributes:
        text: why it was refused.
    """

    accepted: bool
    roster: Roster
    text: str = ""


def decode_change(payload: bytes) -> Change | None:
    """Read a request; None if it only asks.

    Raises:
        MessageError: it is none, or asks for both or neither.
    """
    if not payload:
        return None
    change = read_request(payload, Change, "fleet", LIMIT)
    if (change.add is None) == (change.remove is None):
        raise MessageError("shape", "fleet request: give either `add` or `remove`")
    return change
