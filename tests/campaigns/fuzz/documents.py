"""Readers of scenarios and of orders."""

from functools import cache
from random import Random
from typing import Any

import msgspec

from deploy.library.load import read
from protocol.errors import MessageError, ScenarioError
from protocol.messages import GoalStatus, Member, Roster
from protocol.operations import Reply, decode_operation, decode_reply, encode_reply
from protocol.scenario.file import (
    apply_settings,
    document_of,
    parse_document,
    parse_toml,
    read_document,
    write_toml,
)
from protocol.scenario.model import Scenario
from tests.campaigns.campaign import Dice
from tests.campaigns.fuzz.kept import written
from tests.campaigns.fuzz.mutation import (
    WRITTEN,
    Target,
    damaged_bytes,
    damaged_message,
    damaged_text,
    damaged_tree,
    deep,
)
from tests.campaigns.scenarios.draw import drawn
from tests.protocol.test_operations import ASKED

_SETTINGS = (
    "control.k=80", "robots[1].goal=[0.0, 0.0]", "link.delay=[0.0, 0.3]", "robots[6].id=9",
    "sensing.delay=0.1", "name=x", "process=[]", "time.step=0.05", "sensing[0].bias=[0, 0]",
)  # fmt: skip


@cache
def _scenarios() -> list[Scenario]:
    named = ("figure-1", "figure-3d", "delay-6", "crash", "swap-4", "random-3")
    return [*map(read, named), *(found for seed in range(8) if (found := drawn(Dice(seed))))]


@cache
def _documents() -> list[Any]:
    return [document_of(scenario) for scenario in _scenarios()]


@cache
def _texts() -> list[str]:
    return [write_toml(scenario) for scenario in _scenarios()]


def _draw_document(rng: Random) -> dict[str, Any]:
    tree = damaged_tree(rng.choice(_documents()), rng, WRITTEN)
    return tree if isinstance(tree, dict) else {"robots": tree}


def _draw_text(rng: Random) -> str:
    if rng.randrange(200) == 0:
        opening = rng.choice(("x = " + "[" * 2, "[x.", "x.", "x = {a = ", "[[a]]\n"))
        return str(deep(rng, lambda depth: opening + opening[-3:] * min(depth, 2_000)))
    return damaged_text(rng.choice(_texts()), rng.choice(_texts()), rng)


def _draw_settings(rng: Random) -> list[str]:
    return [_draw_setting(rng) for _ in range(rng.randint(1, 3))]


def _draw_setting(rng: Random) -> str:
    valid = rng.choice(_SETTINGS)
    return damaged_text(valid, rng.choice(_SETTINGS), rng) if rng.randrange(4) else valid


def _draw_file(rng: Random) -> bytes:
    texts = [text.encode() for text in (rng.choice(_texts()), rng.choice(_texts()))]
    return (b"\xef\xbb\xbf" if rng.randrange(4) == 0 else b"") + damaged_bytes(texts[0], texts[1], rng)


def _same_again(scenario: Scenario) -> None:
    text = write_toml(scenario)
    assert write_toml(parse_toml(text)) == text


def _read_settings(settings: list[str]) -> None:
    _same_again(parse_document(apply_settings(_documents()[0], settings)))


def _read_file(content: bytes) -> None:
    _same_again(parse_document(read_document(written("scenario.toml", content))))


SCENARIOS = {
    "document": Target(_draw_document, lambda d: _same_again(parse_document(d)), ScenarioError, 4),
    "text": Target(_draw_text, lambda text: _same_again(parse_toml(text)), ScenarioError, 2),
    "settings": Target(_draw_settings, _read_settings, ScenarioError, 4),
    "file": Target(_draw_file, _read_file, ScenarioError, 2),
}


_STATUS = GoalStatus(3, 10, 1, "under way", (0.1, 0.2))
_REPLIES = [
    Reply(True, 1, "overlaps the goal of robot 2", tick=10, goals=(_STATUS,)),
    Reply(
        False, text="no", tick=3, halted=True, moving=(2,), roster=Roster(4, (Member(1, 1, "live", 0.04),))
    ),
]


def _draw_request(rng: Random) -> bytes:
    valid = rng.choice(ASKED)[0]
    if rng.randrange(2):  # as people write it
        text = msgspec.json.encode(damaged_tree(valid, rng)).decode()
        if rng.randrange(2):
            return damaged_text(text, text, rng).encode(errors="surrogatepass")
        return damaged_bytes(text.encode(), b"{}", rng)
    return damaged_message(msgspec.msgpack.encode(valid), msgspec.msgpack.encode(ASKED[0][0]), rng)


def _read_request(request: bytes) -> None:
    decoded = decode_operation(request)
    if decoded is not None:
        assert decode_operation(msgspec.msgpack.encode(decoded)) == decoded


def _draw_reply(rng: Random) -> bytes:
    valid, other = rng.choice(_REPLIES), rng.choice(_REPLIES)
    return damaged_message(encode_reply(valid, b""), encode_reply(other, b""), rng)


ORDERS = {
    "order": Target(_draw_request, _read_request, MessageError, 12),
    "outcome": Target(_draw_reply, lambda reply: decode_reply(reply, Reply), MessageError, 4),
}
