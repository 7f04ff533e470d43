"""What it means that a session did not open, and what to do about it."""

from __future__ import annotations

import re

from protocol.bus.connection import Connection
from protocol.errors import BusError, CertificateError, EndpointTakenError

_PLACE = re.compile(r" at \S+\.rs:\d+\.?")  # in zenoh's sources: means nothing to a user


def explained(connection: Connection, error: str) -> BusError:
    """The error for a user; zenoh's own words, `error`, come last.

    zenoh reports a certificate that is not accepted as time that is up, so this looks for itself.
    """
    error = _PLACE.sub("", error)
    listen, connect = ", ".join(connection.listen), ", ".join(connection.connect)
    if "in use" in error:
        return EndpointTakenError(f"cannot listen on {listen}: another process does already ({error})")
    if (certificates := _certificates(connection)) is not None:
        return CertificateError(certificates)
    if not connection.connect:
        return BusError(f"cannot listen on {listen}: {error}")
    return BusError(
        f"nobody reachable at {connect} within {connection.timeout:g} s: is the router running there "
        f"(`disknav router`), is the endpoint right, does a firewall stand between? ({error})"
    )


def _certificates(connection: Connection) -> str | None:
    from protocol.bus.tls_refusal import demands_certificates, refusal  # robots without TLS stay lean

    for endpoint in connection.connect:
        if connection.credentials is not None:
            if (why := refusal(endpoint, connection.credentials)) is not None:
                return why
        elif demands_certificates(endpoint):
            return f"the router at {endpoint} demands certificates: use tls/ and --secure DIR"
    return None
