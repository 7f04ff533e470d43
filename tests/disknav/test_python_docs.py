"""docs/python.md and the notebook run, from top to bottom."""

from __future__ import annotations

import re
from pathlib import Path

import jupytext
import matplotlib as mpl
import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOK = ROOT / "docs/notebooks/figure_1.py"


@pytest.mark.process
def test_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.DOTALL)
    for n, block in enumerate(blocks):
        exec(compile(block, f"docs/python.md, block {n}", "exec"), names)
    assert len(blocks) >= 7
    assert names["simulation"].verdict == "arrived"  # type: ignore[attr-defined]


def test_the_notebook_draws_figure_1_in_ten_lines() -> None:
    mpl.use("Agg")
    cells = [cell.source for cell in jupytext.read(NOTEBOOK).cells if cell.cell_type == "code"]
    assert len([line for line in cells[0].splitlines() if line]) <= 10
    names: dict[str, object] = {}
    for cell in cells:
        exec(cell, names)
    axes = names["axes"]
    assert len(axes.lines) == 6  # type: ignore[attr-defined]
    assert axes.get_title().startswith("arrived")  # type: ignore[attr-defined]
