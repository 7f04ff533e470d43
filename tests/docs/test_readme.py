"""What README shows runs: its scenario, its Python, its targets; its commands in test_shown_commands.py."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.scenario.file import parse_toml

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def test_the_scenario() -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    report = LocalFleet(resolved(parse_toml(text, "README"))).execute()
    assert report["verdict"] == "arrived"


@pytest.mark.slow
def test_the_python() -> None:
    (text,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    names: dict[str, object] = {}
    exec(text, names)
    assert names["run"].verdict == "arrived"  # type: ignore[attr-defined]


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text()
    targets = re.findall(r"(?:^|`)make ([a-z]+)", README, re.MULTILINE)
    assert len(targets) >= 3
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
