"""Scenarios as people write them: files, texts, documents, and settings on a command line."""

from __future__ import annotations

from functools import cache
from random import Random
from typing import Any

from deploy.library.load import read
from protocol.errors import ScenarioError
from protocol.scenario.file import (
    apply_settings,
    document_of,
    parse_document,
    parse_toml,
    read_scenario,
    write_toml,
)
from protocol.scenario.model import Scenario
from tests.campaigns.faults import fault_scenario
from tests.fuzz.mutation import WRITTEN, damaged_bytes, damaged_text, damaged_tree, deep
from tests.fuzz.target import Target
from tests.fuzz.targets.kept import folder

_SETTINGS = (
    "control.k=80", "robots[1].goal=[0.0, 0.0]", "link.delay=[0.0, 0.3]", "robots[6].id=9",
    "sensing.delay=0.1", "name=x", "process=[]", "time.step=0.05", "sensing[0].bias=[0, 0]",
)  # fmt: skip


@cache
def _scenarios() -> list[Scenario]:
    named = ("figure-1", "figure-3d", "delay-6", "crash", "swap-4", "random-3")
    return [*map(read, named), *map(fault_scenario, range(8))]


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


def _same_again(scenario: Scenario) -> bool:
    text = write_toml(scenario)
    assert write_toml(parse_toml(text)) == text
    return True


def _read_settings(settings: list[str]) -> bool:
    return _same_again(parse_document(apply_settings(_documents()[0], settings)))


def _read_file(content: bytes) -> bool:
    path = folder() / "scenario.toml"
    try:
        path.write_bytes(content)
        return _same_again(read_scenario(path))
    finally:
        path.unlink()


SCENARIOS = {
    "document": Target(_draw_document, lambda d: _same_again(parse_document(d)), ScenarioError, 4),
    "text": Target(_draw_text, lambda text: _same_again(parse_toml(text)), ScenarioError, 2),
    "settings": Target(_draw_settings, _read_settings, ScenarioError, 4),
    "file": Target(_draw_file, _read_file, ScenarioError, 2),
}
