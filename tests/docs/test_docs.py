"""What documents say of the code: every file and folder that they name is there."""

from __future__ import annotations

import re
from collections import defaultdict
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


def test_the_map_names_every_folder_and_files_beside_what_it_names() -> None:
    named: set[str] = set()
    for row in re.findall(r"^\|.*\|$", (ROOT / "CONTRIBUTING.md").read_text(), re.MULTILINE):
        beside = ROOT
        for path in re.findall(r"`([\w/-]+(?:/|\.py))`", row):
            if "/" in path:
                beside = (ROOT / path).parent
                named.add(path)
            else:
                assert (beside / path).exists(), f"{path} is not in {beside}"
    packages = ("protocol", "agents", "world", "deploy")
    folders = {path.parent for package in packages for path in (ROOT / package).glob("*/*.py")}
    names = {folder.relative_to(ROOT).as_posix() + "/" for folder in folders}
    assert [name for name in sorted(names) if not any(each.startswith(name) for each in named)] == []


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


def test_no_folder_is_a_heap() -> None:
    entries: dict[Path, set[str]] = defaultdict(set)
    for path in (path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.is_file()):
        if "__pycache__" not in path.parts and path.suffix != ".so":  # which the machine made
            for folder in path.relative_to(ROOT).parents:
                entries[folder].add(path.relative_to(ROOT / folder).parts[0])
    del entries[Path()]
    assert {str(folder): found for folder, found in entries.items() if len(found) > 14} == {}
