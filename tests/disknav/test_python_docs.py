"""The Python of the documentation and the notebook runs, from top to bottom."""

import re
from pathlib import Path

import matplotlib as mpl
import pytest

from tests.scripts import ROOT, ended

PAGES = [
    "../README.md",
    "index.md",
    "guides/law.md",
    "guides/python.md",
    "guides/learning.md",
    "guides/networks.md",
]
NOTEBOOK = ROOT / "docs/guides/figure_1.py"


def blocks(page: str) -> list[str]:
    """The Python that a page shows."""
    return re.findall(r"```python\n(.*?)```", (ROOT / "docs" / page).read_text(), re.DOTALL)


@pytest.mark.process
@pytest.mark.parametrize("page", PAGES)
def test_a_page(page: str, tmp_path: Path) -> None:
    """As one script: a class of its own is then a law of `__main__`."""
    script = tmp_path / "page.py"
    script.write_text("\n".join(blocks(page)))
    assert script.stat().st_size > 0
    done = ended(script, timeout=110.0, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_the_notebook_draws_figure_1_in_ten_lines() -> None:
    import jupytext

    mpl.use("Agg")
    cells = [cell.source for cell in jupytext.read(NOTEBOOK).cells if cell.cell_type == "code"]
    assert len([line for line in cells[0].splitlines() if line]) <= 10
    names: dict[str, object] = {}
    for cell in cells:
        exec(cell, names)
    axes = names["axes"]
    assert len(axes.lines) == 6  # type: ignore[attr-defined]
    assert axes.get_title().startswith("arrived")  # type: ignore[attr-defined]
