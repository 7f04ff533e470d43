"""What documents say of the code: every file and folder that they name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
FOLDERS = ("disknav", "protocol", "agents", "world", "deploy", "tests", "docs")
_NAMED = re.compile(rf"`((?:{'|'.join(FOLDERS)})/(?:[\w./-]*/|[\w./-]+\.(?:py|md|json)))`")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_path_is_there(page: Path) -> None:
    named = set(_NAMED.findall(page.read_text()))
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\]\((?!https?:)([^)#\s]+)", page.read_text())
    made = {path.with_suffix(".md") for path in (ROOT / "docs/reference").glob("*.py")}  # with the site
    targets = {link: (page.parent / link).resolve() for link in links}
    assert [link for link, target in targets.items() if target not in made and not target.exists()] == []


def test_every_module_to_run_is_there() -> None:
    sources = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")]
    said = "".join(path.read_text() for path in [*PAGES, ROOT / "Makefile", *sources])
    named = {
        ROOT / name.replace(".", "/")
        for name in re.findall(r"python -m ((?:tests|deploy|docs)[\w.]*\w)", said)
    }
    assert len(named) > 20
    assert [path for path in named if not path.with_suffix(".py").exists() and not path.is_dir()] == []
