"""The Python of the documentation and the notebook runs, from top to bottom."""

from __future__ import annotations

import re
from pathlib import Path

import jupytext
import matplotlib as mpl
import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOK = ROOT / "docs/notebooks/figure_1.py"


def blocks(page: str) -> list[str]:
    """The Python that a page shows."""
    return re.findall(r"```python\n(.*?)```", (ROOT / "docs" / page).read_text(), re.DOTALL)


@pytest.mark.process
@pytest.mark.parametrize("page", ["index.md", "law.md", "python.md"])
def test_a_page(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    assert blocks(page)
    for n, block in enumerate(blocks(page)):
        exec(compile(block, f"docs/{page}, block {n}", "exec"), names)


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
