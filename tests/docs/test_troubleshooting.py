"""Every message that the page of troubleshooting quotes is one that the software prints."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PRODUCT = ("disknav", "protocol", "agents", "world", "deploy")
_GAP = "\0"  # in the place of a value
_QUOTED = [
    quoted
    for row in re.findall(r"^\| (`.*?) \|", (ROOT / "docs/troubleshooting.md").read_text(), re.MULTILINE)
    for quoted in re.findall(r"`([^`]+)`", row)
]


@cache
def printed() -> tuple[str, ...]:
    """All texts of the product, each f-string as one with gaps."""
    texts = [(ROOT / "Makefile").read_text()]
    for folder in PRODUCT:
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.JoinedStr):
                    parts = (part.value if isinstance(part, ast.Constant) else _GAP for part in node.values)
                    texts.append("".join(map(str, parts)))
                elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                    texts.append(node.value)
                elif isinstance(node, ast.ClassDef):
                    texts.append(node.name)
    return tuple(texts)


@pytest.mark.parametrize("quoted", _QUOTED)
def test_a_quoted_message_is_printed(quoted: str) -> None:
    fragments = [each.strip(" :") for each in re.split(r"\.\.\.|\(|\)|\d+|\bmine\.toml", quoted)]
    longest = max(fragments, key=len)
    assert len(longest) >= 5
    assert any(longest in text for text in printed()), longest


def test_there_are_quoted_messages() -> None:
    assert len(_QUOTED) > 30
