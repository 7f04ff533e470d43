"""mkdocs' hooks: add the pages that are made from the code, and guides that mkdocs.yml does not list."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]


def on_config(config: Any) -> Any:
    """See mkdocs. An author of a page need not think of its place."""
    guides = next(section["Guides"] for section in config.nav if "Guides" in section)
    listed = str(config.nav)
    pages = [path.relative_to(ROOT / "docs").as_posix() for path in sorted((ROOT / "docs").rglob("*.md"))]
    guides += [page for page in pages if page not in listed]
    return config


def on_files(files: Any, config: Any) -> Any:
    """See mkdocs."""
    for name, text in generated().items():
        files.append(_file(config, f"reference/{name}.md", text))
    return files


def generated() -> dict[str, str]:
    """Text of each page by name."""
    sys.path[:0] = [str(ROOT)]
    try:
        from docs.reference import commands, python, result, scenario
    finally:
        sys.path.remove(str(ROOT))
    return {each.__name__.rpartition(".")[2]: each.page() for each in (commands, scenario, result, python)}


def _file(config: Any, path: str, text: str) -> Any:
    from mkdocs.structure.files import File

    return File.generated(config, path, content=text)
