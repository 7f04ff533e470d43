"""What documents say of the code: every file and folder that they name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
_NAMED = re.compile(r"`((?:protocol|agents|world|deploy|tests|docs)/(?:[\w./-]*/|[\w./-]+\.(?:py|md|json)))`")


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
