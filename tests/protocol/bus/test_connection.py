"""Endpoints as people write them, and as zenoh takes them."""

import json
import pickle

import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from protocol.bus.connection import Connection, Endpoint, configuration
from protocol.errors import UsageError


@pytest.mark.parametrize(
    ("text", "meant", "address"),
    [
        ("tcp/127.0.0.1:7447", "tcp/127.0.0.1:7447", ("127.0.0.1", 7447)),
        ("localhost:7611", "tcp/localhost:7611", ("localhost", 7611)),
        ("10.0.0.1", "tcp/10.0.0.1:7447", ("10.0.0.1", 7447)),
        ("tls/yard-router", "tls/yard-router:7447", ("yard-router", 7447)),
        ("[::1]:5", "tcp/[::1]:5", ("::1", 5)),
        ("tcp/0.0.0.0:07#iface=eth0", "tcp/0.0.0.0:7#iface=eth0", ("0.0.0.0", 7)),
        ("unixsock-stream//tmp/a b".replace(" ", "-"), "unixsock-stream//tmp/a-b", None),
    ],
)
def test_what_is_left_out_is_filled_in(text: str, meant: str, address: tuple[str, int] | None) -> None:
    assert Endpoint(text) == meant
    assert Endpoint(text).address == address
    assert Endpoint(Endpoint(text)) == meant
    assert Endpoint(text, "tls").protocol == (text if "/" in text else "tls/").partition("/")[0]
    assert type(pickle.loads(pickle.dumps(Endpoint(text)))) is Endpoint


def test_only_addresses_of_this_host_are_on_the_loopback() -> None:
    for text in ("localhost", "127.3.2.1", "[::1]", "unixsock-stream//tmp/a"):
        assert Endpoint(text).is_loopback
    for text in ("127.example.org", "localhost.example.org", "0.0.0.0", "[::]", "10.0.0.1"):
        assert not Endpoint(text).is_loopback


@pytest.mark.parametrize(
    "text",
    ["", "tcp/", ":7447", "tcp/a:0", "tcp/a:65536", "a:x", "::1", "tcp/::1:7447", "[::g]:1", "[1]", "udp/a:1",
     "a b:1", "a:1\n", "tcp/a:1#", "tcp/a:1?x", "tcp//a:1", "*:7447", "é:1", "unixsock-stream/", "-a:1"],
)  # fmt: skip
def test_what_is_no_endpoint_is_named(text: str) -> None:
    with pytest.raises(UsageError) as caught:
        Connection(connect=(text,))  # type: ignore[arg-type]  # as typed
    assert repr(text) in str(caught.value)


@given(
    st.text(max_size=30)
    | st.from_regex(r"(tcp/|tls/|unixsock-stream/)?[a-z0-9.\[\]:*-]{0,20}(:\d{0,6})?([?#][a-z]*=?\d*)?\Z"),
    st.sampled_from(["client", "router", "peer"]),
)  # fmt: skip
def test_zenoh_takes_every_endpoint(text: str, mode: str) -> None:
    try:
        endpoint = Endpoint(text)
    except UsageError as error:
        assert repr(text) in str(error)
        return
    connection = Connection(mode, connect=(endpoint,), listen=(endpoint,))  # type: ignore[arg-type]
    zenoh.Config.from_json5(json.dumps(configuration(connection)))


def test_zenoh_refuses_what_is_none() -> None:
    """So that the test before this one sees something."""
    with pytest.raises(zenoh.ZError):
        zenoh.Config.from_json5('{"connect": {"endpoints": ["localhost:7447"]}}')
