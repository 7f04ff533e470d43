"""What zenoh's admin space says of the router: who is connected to it, over which links.

Only `@/*/router` is asked for, one key per router: asking for everything (`@/**`) while many declare
can block a router. Routers of this project keep their admin space off; a stock `zenohd` has it on.
"""

from __future__ import annotations

from typing import Any

import msgspec

from protocol.wire.reader import DAMAGED

ROUTERS = "@/*/router"


class Link(msgspec.Struct, frozen=True):
    """One link of a session: the endpoint that is not the router's."""

    dst: str


class Session(msgspec.Struct, frozen=True):
    """Somebody who is connected: zenoh id, whether router, peer or client, and its links."""

    peer: str
    whatami: str
    links: tuple[Link, ...]


class Router(msgspec.Struct, frozen=True):
    """A router about itself."""

    zid: str
    version: str
    sessions: tuple[Session, ...]

    def told(self) -> dict[str, Any]:
        """As plain data for a viewer."""
        links = [f"{session.whatami} {link.dst}" for session in self.sessions for link in session.links]
        return {"version": self.version.split("-")[0].removeprefix("v"), "zid": self.zid, "links": links}


def router(payload: bytes) -> Router | None:
    """Read a reply; None if it is of another form than zenoh 1.x gives."""
    try:
        return msgspec.json.decode(payload, type=Router)
    except DAMAGED:
        return None
