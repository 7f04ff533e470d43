"""JSON that a command writes: to a file, or to standard output."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from deploy.output.target import check_target, writing

_STANDARD_OUTPUT = "-"
_WHAT = "write JSON"


def is_standard_output(target: Path | None) -> bool:
    """Whether `target` asks for standard output, which then takes nothing else."""
    return str(target) == _STANDARD_OUTPUT


def check(target: Path | None) -> None:
    """Find out before the work what would fail after it.

    Raises:
        UsageError: `target` cannot be written.
    """
    if target is not None and not is_standard_output(target):
        check_target(target, _WHAT)


def write_json(document: object, target: Path | None) -> None:
    """Write `document` into the file `target`, to standard output for '-', nowhere for None.

    Raises:
        UsageError: `target` cannot be written.
    """
    if target is None:
        return
    text = json.dumps(document, indent=2) + "\n"
    if is_standard_output(target):
        sys.stdout.write(text)
    else:
        with writing(target, _WHAT):
            target.write_text(text, encoding="utf-8")
