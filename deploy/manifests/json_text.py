"""JSON for people: indented, with a comment on top, which YAML, a superset, allows for."""

from __future__ import annotations

import json
from typing import Any


def json_text(document: Any, head: str) -> str:
    """The text of a file, for a reader of YAML."""
    comment = "".join(f"# {line}\n" for line in head.splitlines())
    return f"{comment}{json.dumps(document, indent=2, ensure_ascii=False)}\n"
