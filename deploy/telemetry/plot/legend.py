"""What the marks mean."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.legend_handler import HandlerPatch
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch

from deploy.telemetry.plot.style import FAINT, colour, dash


def _disk(*, xdescent: float, ydescent: float, width: float, height: float, **_: object) -> Circle:
    """A disk as a disk, where legends would show a box."""
    return Circle((width / 2 - xdescent, height / 2 - ydescent), 0.75 * height)


HANDLERS = {Patch: HandlerPatch(patch_func=_disk)}


def disks() -> list[Patch]:
    """Handles for the disks of a workspace."""
    return [
        Patch(fill=False, edgecolor=FAINT, linestyle=":", linewidth=1.0, label="start"),
        Patch(facecolor=FAINT, alpha=0.25, linewidth=0, label="between"),
        Patch(facecolor=FAINT, alpha=0.7, linewidth=0, label="end"),
        Patch(fill=False, edgecolor=FAINT, linewidth=1.2, label="goal"),
    ]


def curves(names: Sequence[str]) -> list[Line2D]:
    """Handles for curves in their order."""
    return [
        Line2D([], [], color=colour(index), linestyle=dash(index), label=name)
        for index, name in enumerate(names)
    ]
