"""The router as a configuration file of zenoh's own router, `zenohd`."""

from __future__ import annotations

import json
from dataclasses import replace

from protocol.bus.connection import Connection, configuration

_HEAD = "// For zenohd 1.10 or newer: zenohd -c THIS_FILE. Whatever is not named here is zenoh's default.\n"


def router_config(connection: Connection, default: str) -> str:
    """JSON5 by which `zenohd` relays, and enforces, exactly as `disknav router` does.

    `default` is listened on where `connection` names no endpoint.
    """
    listening = connection if connection.listen else replace(connection, listen=(default,))
    return _HEAD + json.dumps(configuration(listening), indent=2) + "\n"
