"""Every message that the page of troubleshooting quotes is one that the software prints."""

import ast
import re
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


def printed() -> list[str]:
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
    return texts


def longest_fragment(quoted: str) -> str:
    return max((each.strip(" :") for each in re.split(r"\.\.\.|\(|\)|\d+|\bmine\.toml", quoted)), key=len)


@pytest.mark.slow
def test_quoted_messages_are_printed() -> None:
    fragments = [longest_fragment(quoted) for quoted in _QUOTED]
    assert len(fragments) > 30
    assert min(map(len, fragments)) >= 5
    texts = "\n".join(printed())
    assert [each for each in fragments if each not in texts] == []
