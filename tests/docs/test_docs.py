"""What documents say: every file and folder that they name is there, README's scenario arrives, and every
message that the page of troubleshooting quotes is one that the software prints."""

import ast
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


# -- troubleshooting


PRODUCT = ("disknav", "protocol", "agents", "world", "deploy")
_GAP = "\0"  # in the place of a value
_QUOTED = [
    quoted
    for row in re.findall(r"^\| (`.*?) \|", (ROOT / "docs/troubleshooting.md").read_text(), re.MULTILINE)
    for quoted in re.findall(r"`([^`]+)`", row)
]


def printed() -> list[str]:
    """All texts of the product, each f-string as one with gaps."""
    texts = [(ROOT / "Makefile").read_text()]
    for folder in PRODUCT:
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.JoinedStr):
                    parts = (part.value if isinstance(part, ast.Constant) else _GAP for part in node.values)
                    texts.append("".join(map(str, parts)))
                elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                    texts.append(node.value)
                elif isinstance(node, ast.ClassDef):
                    texts.append(node.name)
    return texts


def longest_fragment(quoted: str) -> str:
    return max((each.strip(" :") for each in re.split(r"\.\.\.|\(|\)|\d+|\bmine\.toml", quoted)), key=len)


@pytest.mark.slow
def test_quoted_messages_are_printed() -> None:
    fragments = [longest_fragment(quoted) for quoted in _QUOTED]
    assert len(fragments) > 30
    assert min(map(len, fragments)) >= 5
    texts = "\n".join(printed())
    assert [each for each in fragments if each not in texts] == []
