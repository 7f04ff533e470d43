"""Diagnosis of a session that did not open.

zenoh reports any failed TLS link as a timeout; a separate handshake finds out which end refuses the other's
certificate.
"""

from __future__ import annotations

import re
import socket
import ssl

from protocol.bus.connection import Connection, Credentials, Endpoint
from protocol.errors import BusError, CertificateError, EndpointTakenError, ListenError

_PLACE = re.compile(r" at \S+\.rs:\d+\.?")  # a position in zenoh's sources, of no use to a user
_PATIENCE = 1.0  # s for a connection, and for the other end's verdict after the handshake
_ALERTS = {
    "TLSV1_ALERT_UNKNOWN_CA": "it was not signed by the authority that the router trusts",
    "TLSV1_ALERT_DECRYPT_ERROR": "it was not signed by the authority that the router trusts",
    "TLSV13_ALERT_CERTIFICATE_REQUIRED": "the router demands one, and none was shown",
    "SSLV3_ALERT_CERTIFICATE_EXPIRED": "it has expired",
    "SSLV3_ALERT_BAD_CERTIFICATE": "the router cannot make sense of it",
    "SSLV3_ALERT_CERTIFICATE_UNKNOWN": "the router does not accept it",
    "SSLV3_ALERT_UNSUPPORTED_CERTIFICATE": "it is for another purpose",
}


def explained(connection: Connection, error: str) -> BusError:
    """The error for a user; zenoh's own words, `error`, come last."""
    error = _PLACE.sub("", error)
    listen, connect = ", ".join(connection.listen), ", ".join(connection.connect)
    if "in use" in error:
        return EndpointTakenError(f"cannot listen on {listen}: another process listens there ({error})")
    if (certificates := _certificates(connection)) is not None:
        return CertificateError(certificates)
    if not connection.connect or "listener" in error:
        return ListenError(
            f"cannot listen on {listen}: {error}; name an address of this host and a port that is free"
        )
    return BusError(
        f"no process reachable at {connect} within {connection.timeout:g} s: is the router running there "
        f"(`disknav node router`), is the endpoint right, is a firewall in the way? ({error})"
    )


def _certificates(connection: Connection) -> str | None:
    for endpoint in connection.connect:
        if connection.credentials is not None:
            if (why := refusal(endpoint, connection.credentials)) is not None:
                return why
        elif demands_certificates(endpoint):
            return f"the router at {endpoint} demands certificates: use tls/ and --secure DIR"
    return None


def refusal(endpoint: Endpoint, credentials: Credentials) -> str | None:
    """Why certificates between here and `endpoint` are refused; None if that is not the reason."""
    address = endpoint.address
    if address is None or endpoint.protocol != "tls":
        return None
    try:
        context = ssl.create_default_context(cafile=credentials.authority)
        context.load_cert_chain(credentials.certificate, credentials.key)
    except (OSError, ssl.SSLError) as error:
        return f"{credentials.certificate} and {credentials.key} cannot be used: {error}"
    try:
        _shake_hands(address, context)
    except ssl.SSLCertVerificationError as error:
        return (
            f"the certificate of the router at {endpoint} is not accepted here: {error.verify_message}; "
            f"{credentials.authority} must be the authority that signed it"
        )
    except ssl.SSLError as error:
        return _alert(endpoint, credentials, error)
    except OSError:
        return None  # nothing listens there, or it is too slow to decide
    return None


def demands_certificates(endpoint: Endpoint) -> bool:
    """Whether an endpoint that was tried without certificates uses TLS."""
    address = endpoint.address
    if address is None:
        return False
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE  # nothing confidential is sent
    try:
        _shake_hands(address, context)
    except ssl.SSLError as error:
        return "CERTIFICATE" in (error.reason or "")
    except OSError:
        return False
    return True


def _shake_hands(address: tuple[str, int], context: ssl.SSLContext) -> None:
    """Complete a handshake and read: in TLS 1.3 a client learns of its refusal only then."""
    with (
        socket.create_connection(address, _PATIENCE) as plain,
        context.wrap_socket(plain, server_hostname=address[0]) as link,
    ):
        try:
            link.recv(1)
        except TimeoutError:
            return  # without an answer the certificate is accepted


def _alert(endpoint: str, credentials: Credentials, error: ssl.SSLError) -> str:
    reason = error.reason or str(error)
    if reason in _ALERTS or "CERTIFICATE" in reason:
        text = _ALERTS.get(reason, f"TLS alert {reason}")
        return f"the router at {endpoint} refuses the certificate {credentials.certificate}: {text}"
    return f"no TLS with certificates at {endpoint} ({reason}): does the router there run with --secure?"
