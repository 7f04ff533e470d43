"""`disknav plot`: pictures and animations of recordings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.commands import options
from deploy.output.bar import bar

if TYPE_CHECKING:  # the rest of the command line does without what reading takes, numpy first of all
    from deploy.telemetry.recording.reading.reader import Recording


def plot(
    recordings: Annotated[
        list[Path], typer.Argument(metavar="RECORDING...", help="Files that `disknav run --record` wrote.")
    ],
    out: Annotated[Path, options.out("Picture to write: .png, .svg, .pdf, or a film: .gif, .mp4.")],
    until: Annotated[
        float | None,
        typer.Option(min=0.0, help="Draw only so many simulated seconds: disks as they stand then."),
    ] = None,
) -> None:
    """Draw recordings: paths with disks, clearance and phi over time, and how late information was.

    Examples: disknav plot figure-1.mcap -o figure-1.pdf;
    disknav plot figure-2.mcap --until 2.5 -o blocked.png
    """
    from deploy.telemetry.plot import draw

    draw.check(out, len(recordings))
    found = [_read(path) for path in recordings]
    if until is not None:
        found = [draw.until(each, until) for each in found]
    with bar(f"drawing {out.name}") as progress:
        draw.draw(found, out, progress)


def _read(path: Path) -> Recording:
    from deploy.telemetry.recording.reading.reader import read

    with bar(f"reading {path.name}") as progress:
        return read(path, progress)
