"""What documents say of the code: every file and folder that they name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
FOLDERS = ("disknav", "protocol", "agents", "world", "deploy", "tests", "docs")
_NAMED = re.compile(rf"`((?:{'|'.join(FOLDERS)})/(?:[\w./-]*/|[\w./-]+\.(?:py|md|json)))`")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_path_is_there(page: Path) -> None:
    named = set(_NAMED.findall(page.read_text()))
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    links = set(re.findall(r"\]\((?!https?:)([^)\s]+)", page.read_text()))
    assert [link for link in sorted(links) if not leads_somewhere(page, link)] == []


def leads_somewhere(page: Path, link: str) -> bool:
    """Whether the file is there, and in it the heading, if the link names one."""
    path, _, anchor = link.partition("#")
    target = (page.parent / path).resolve() if path else page
    made = {file.with_suffix(".md") for file in (ROOT / "docs/reference").glob("*.py")}  # with the site
    if target in made:
        return True
    return target.exists() and (not anchor or anchor in anchors(target))


def anchors(page: Path) -> set[str]:
    """Of all headings of a page, as GitHub and the site make them."""
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    plain = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower() for heading in headings]
    return {re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", heading).strip()) for heading in plain}


def test_every_module_to_run_is_there() -> None:
    sources = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")]
    said = "".join(path.read_text() for path in [*PAGES, ROOT / "Makefile", *sources])
    named = {
        ROOT / name.replace(".", "/")
        for name in re.findall(r"python -m ((?:tests|deploy|docs)[\w.]*\w)", said)
    }
    assert len(named) > 20
    assert [path for path in named if not path.with_suffix(".py").exists() and not path.is_dir()] == []
