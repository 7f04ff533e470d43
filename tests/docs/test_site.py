"""The site: builds without a warning, fetches nothing, and its reference is the code's."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import disknav
from deploy.cli.application import GROUPS
from deploy.run.options import RunOptions
from deploy.run.result import complete
from docs.concepts.diagrams import render
from docs.reference import commands, python, result, scenario
from protocol.scenario.file import json_schema

if TYPE_CHECKING:
    from playwright.sync_api import Browser

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as `make site` does; mkdocs.yml is strict, so a dead link is a failure."""
    target = tmp_path_factory.mktemp("site")
    call = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(target)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(
        call, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=110, check=False
    )
    assert done.returncode == 0, done.stderr
    return target


@pytest.mark.slow
def test_every_page_is_there(site: Path) -> None:
    named = re.findall(r"[\w/-]+\.md", (ROOT / "mkdocs.yml").read_text())
    assert [page for page in named if not (site / _address(page)).exists()] == []
    index = (site / "index.html").read_text()
    for path in (ROOT / "docs").rglob("*.md"):
        page = _address(path.relative_to(ROOT / "docs").as_posix())
        assert f'href="{page}"' in index, f"{page} is in no menu"


def _address(page: str) -> str:
    """Where the site has a page: README is the index of its folder."""
    return re.sub(r"(README)?\.md$", lambda found: "index.html" if found[1] else ".html", page)


@pytest.mark.slow
def test_the_front_page_is_that_of_readme(site: Path) -> None:
    front, readme = (site / "index.html").read_text(), (ROOT / "README.md").read_text()
    pictures = re.findall(r"docs/(pictures/moving/[\w-]+\.webp)", readme)
    assert len(pictures) == 5
    assert all(f'src="{each}"' in front for each in pictures)
    assert sum((ROOT / "docs" / each).stat().st_size for each in pictures) < 2_000_000
    assert "make demo" in front
    assert len(readme.split()) <= 700


@pytest.mark.browser
@pytest.mark.slow
def test_no_page_is_wider_than_a_phone(site: Path, browser: Browser) -> None:
    page = browser.new_page(viewport={"width": 390, "height": 844})
    for path in sorted(site.rglob("*.html")):
        page.goto(path.as_uri())
        width = page.evaluate("document.scrollingElement.scrollWidth")
        assert width <= 390, f"{path.relative_to(site)} is {width} pixels wide"


@pytest.mark.slow
def test_nothing_is_fetched_from_elsewhere(site: Path) -> None:
    fetched = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*?(?:src|href)=\"(?:https?:)?//[^\"]*\"")
    found = {
        address
        for page in site.rglob("*.html")
        for address in fetched.findall(page.read_text())
        if 'rel="canonical"' not in address
    }
    assert found == set()
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\(\s*[\"']?(?:https?:)?//", sheet.read_text())


@pytest.mark.slow
def test_every_diagram_is_drawn_as_its_source_says_and_shown(site: Path) -> None:
    sources = sorted(render.FOLDER.glob("*.mmd"))
    assert sources
    assert [each.name for each in sources if not render.is_drawn(each)] == [], "make diagrams"
    pages = "".join(page.read_text() for page in site.rglob("*.html"))
    assert [each.stem for each in sources if f"diagrams/{each.stem}.svg" not in pages] == []
    assert "```mermaid" not in "".join(page.read_text() for page in (ROOT / "docs").rglob("*.md"))


def test_every_command_is_in_the_reference() -> None:
    page = commands.page()
    names = [
        command.info.name if hasattr(command, "info") else command.__name__
        for grouped in GROUPS.values()
        for command in grouped
    ]
    assert all(f"### `disknav {name}" in page for name in names)
    assert "| `--json FILE` |" in page
    assert "| `--set PATH=VALUE` |" in page


def test_every_scenario_key_is_in_the_reference() -> None:
    page, schema = scenario.page(), json_schema()
    tables = [schema, *schema["$defs"].values()]
    keys = {key for table in tables for key, value in table.get("properties", {}).items()}
    missing = {key for key in keys if f"| `{key}` |" not in page and f"{key}]" not in page}
    assert missing == set()


def test_every_result_field_is_in_the_reference() -> None:
    report = disknav.run("head-on", {"time.limit": 0.5}).result
    assert set(complete(report, RunOptions(), [])) == set(result.FIELDS)


def test_every_name_of_the_python_interface_is_in_the_reference() -> None:
    page = python.page()
    assert all(f"## `{name}" in page for name in disknav.__all__)
