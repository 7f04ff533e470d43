"""`make diagrams`: draws each diagram of this folder that has changed, so that no reader has to.

Needs npm, whose registry has Mermaid, and a Chromium. Each picture ends with the digest of its source.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

FOLDER = Path(__file__).parent
_MERMAID = "@mermaid-js/mermaid-cli@11.17.0"
_LOOKS = {"theme": "neutral", "htmlLabels": False}  # plain text, which all viewers show


def signature(source: Path) -> str:
    """What the picture of `source` ends with."""
    return f"<!-- {hashlib.sha256(source.read_bytes()).hexdigest()} -->\n"


def is_drawn(source: Path) -> bool:
    """Whether the picture beside `source` is of what it says."""
    picture = source.with_suffix(".svg")
    return picture.exists() and picture.read_text().endswith(signature(source))


def _draw(source: Path) -> None:
    picture = source.with_suffix(".svg")
    with TemporaryDirectory() as folder:
        browser, looks = Path(folder) / "browser.json", Path(folder) / "looks.json"
        browser.write_text(json.dumps({"executablePath": shutil.which("chromium"), "args": ["--no-sandbox"]}))
        looks.write_text(json.dumps(_LOOKS))
        files = ["-p", browser, "-c", looks, "-i", source, "-o", picture]
        command = ["npx", "--yes", _MERMAID, "--quiet", "-b", "white", *map(str, files)]
        environment = {**os.environ, "PUPPETEER_SKIP_DOWNLOAD": "1"}  # the machine's Chromium draws
        subprocess.run(command, env=environment, check=True)
    picture.write_text(picture.read_text().rstrip() + "\n" + signature(source))


if __name__ == "__main__":
    for each in sorted(FOLDER.glob("*.mmd")):
        if not is_drawn(each):
            _draw(each)
            print(each.with_suffix(".svg"), file=sys.stderr)
