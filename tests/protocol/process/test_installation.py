"""How to add what is missing, for the installation in use: a checkout, or a wheel from wherever it came."""

import sys
from pathlib import Path
from shlex import quote
from types import SimpleNamespace

import pytest

from protocol.process import installation


def test_a_checkout_is_set_up_again(tmp_path: Path) -> None:
    for name in ("pyproject.toml", "Makefile"):
        (tmp_path / name).touch()
    assert installation.is_checkout(tmp_path)
    said = installation.how_to_install("plot", tmp_path)
    assert f"`make setup` in {tmp_path}" in said
    assert f"{quote(sys.executable)} -m pip install --editable '{tmp_path}[plot]'" in said


@pytest.mark.parametrize(
    ("recorded", "origin"),
    [(None, ""), ('{"url": "file:///tmp/x.whl", "archive_info": {}}', " @ file:///tmp/x.whl")],
)
def test_a_wheel_is_named_by_where_it_came_from(
    recorded: str | None, origin: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    metadata = SimpleNamespace(read_text=lambda _: recorded)
    monkeypatch.setattr(installation, "distribution", lambda _: metadata)
    assert not installation.is_checkout(tmp_path)
    assert installation.how_to_install("plot", tmp_path).endswith(f"-m pip install 'disknav[plot]{origin}'")


def test_only_libraries_of_extras_are_explained() -> None:
    error = installation.explained(ModuleNotFoundError("no", name="scipy.optimize"))
    assert "scipy" in str(error)
    assert "[theory]" in str(error)
    assert installation.explained(ModuleNotFoundError("no", name="agents.typo")) is None
