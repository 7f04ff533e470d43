"""What comes from another host over ssh: news of its processes, and lines of its logs."""

import io
import os
import struct
from functools import cache
from math import inf
from random import Random

import msgspec

from deploy.processes.hosts.ssh import FramedMessages, Relay, SshSpawner
from deploy.processes.hosts.table import read_hosts
from deploy.processes.spawn import MAX_NEWS, Exited, HostFacts, ProcessReport, Started, encode_news
from deploy.security.roster import Home, KeyRoster, encoded, read
from protocol.errors import CertificateError, HostsError, KeyGrammarError, ProcessError
from protocol.scenario.file import toml_value
from tests.campaigns.fuzz.kept import written
from tests.campaigns.fuzz.mutation import Target, damaged_bytes, damaged_message, damaged_text, damaged_tree
from tests.deploy.processes.hosts.test_table import GOOD

_NEWS = [
    encode_news(Started(1, 4711)),
    encode_news(ProcessReport(1, "tcp/127.0.0.1:7447")),
    encode_news(Exited(2, -9, 1.5, 42.0)),
    encode_news(HostFacts(0, "3.11.2", True, 1 << 30, "", 4711.5)),
]
_LINE = {
    "run": "yard", "host": "", "role": "robot", "robot": 3, "time": "2026-01-02T03:04:05.678Z",
    "level": "warning", "text": "the world is gone; the robot stands still",
}  # fmt: skip
_ROSTER = encoded(KeyRoster("yard", (1, 2, 3), homes={"base": Home(("10.0.0.1",), (1, 2))}, world="base"))


# -- news


def _draw_news(rng: Random) -> list[bytes]:
    """What arrives at once, a few times."""
    said = b""
    for _ in range(rng.randint(1, 4)):
        message = damaged_message(rng.choice(_NEWS), rng.choice(_NEWS), rng)[:60_000]
        length = len(message) if rng.randrange(8) else rng.choice((0, -1, 5, 1 << 20, MAX_NEWS + 1, 1 << 30))
        said += struct.pack("!i", length) + message
    if rng.randrange(4) == 0:
        said = damaged_bytes(said, b"\xff" * len(said), rng)
    cut = rng.randint(0, len(said))
    return [said[:cut], said[cut:]]


class HostOnPipe(SshSpawner):
    def __init__(self, descriptor: int) -> None:
        self.name, self._beat = "host left", inf
        self._frames = FramedMessages(descriptor, MAX_NEWS, 5.0)


def _read_news(drawn: list[bytes]) -> None:
    reading, writing = os.pipe()
    try:
        host = HostOnPipe(reading)
        for said in drawn:
            os.write(writing, said[:65_000])
            for news in host.news(0.0):
                assert encode_news(news)
    finally:
        os.close(reading)
        os.close(writing)


# -- logs


def _draw_line(rng: Random) -> bytes:
    text = msgspec.json.encode(damaged_tree(_LINE, rng))
    return damaged_bytes(text, text[::-1], rng) if rng.randrange(2) else text


@cache
def _relay() -> Relay:
    relay = Relay("left", "yard", None)
    (handler,) = relay._logger.handlers
    handler.setStream(io.TextIOWrapper(io.BytesIO(), errors="backslashreplace"))  # type: ignore[attr-defined]
    handler.handleError = _raise  # type: ignore[method-assign, assignment]
    return relay


def _raise(_: object) -> None:
    raise  # noqa: PLE0704  what a handler would print


def _read_line(drawn: bytes) -> None:
    _relay().take(drawn)
    (handler,) = _relay()._logger.handlers
    stream = handler.stream  # type: ignore[attr-defined]
    stream.flush()
    shown = stream.buffer.getvalue().decode()
    stream.seek(0)
    stream.truncate()
    assert all(each.isprintable() or each == "\n" for each in shown), shown


# -- files about hosts

_TABLE = "\n".join(f"{key} = {toml_value(value)}" for key, value in GOOD.items())


def _read_table(drawn: str) -> None:
    read_hosts(written("hosts.toml", drawn.encode(errors="surrogatepass")))


def _read_roster(drawn: bytes) -> None:
    try:
        assert read(written("roster.json", drawn).parent).roles
    except KeyGrammarError as error:  # of a run that cannot have this name
        raise CertificateError(str(error)) from error


def _draw_roster(rng: Random) -> bytes:
    if rng.randrange(2):
        return msgspec.json.encode(damaged_tree(msgspec.json.decode(_ROSTER), rng))
    return damaged_bytes(_ROSTER, _ROSTER[::-1], rng)


HOSTS = {
    "news": Target(_draw_news, _read_news, ProcessError, 16),
    "log": Target(_draw_line, _read_line, ProcessError, 8),
    "hosts": Target(lambda rng: damaged_text(_TABLE, _TABLE, rng), _read_table, HostsError, 2),
    "roster": Target(_draw_roster, _read_roster, CertificateError, 2),
}
