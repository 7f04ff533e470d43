"""`disknav plot`: pictures and animations of recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deploy.bar import bar
from deploy.plot.draw import check, draw
from deploy.recording.reader import Recording, read


def plot(
    recordings: Annotated[
        list[Path], typer.Argument(metavar="RECORDING...", help="Files that `run --record` wrote.")
    ],
    out: Annotated[
        Path, typer.Option("--out", "-o", help="File to write: .png, .svg, .pdf, or a film: .gif, .mp4.")
    ],
) -> None:
    """Draw recordings: paths with disks, clearance and phi over time, and how late information was.

    Example: disknav plot figure-1.mcap -o figure-1.pdf
    """
    check(out, len(recordings))
    found = [_read(path) for path in recordings]
    with bar(f"drawing {out.name}") as progress:
        draw(found, out, progress)


def _read(path: Path) -> Recording:
    with bar(f"reading {path.name}") as progress:
        return read(path, progress)
