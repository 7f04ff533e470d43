"""What documents say: every file and folder that they name is there, and README's scenario arrives."""

import re
from pathlib import Path

import pytest

from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.scenario.file import parse_toml

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


def test_the_scenario_of_readme_arrives() -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert LocalFleet(resolved(parse_toml(text, "README"))).execute()["verdict"] == "arrived"
