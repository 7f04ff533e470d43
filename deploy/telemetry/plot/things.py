"""What stood in the workspace, and when: what the scenario lists, what came, and what went."""

from __future__ import annotations

import math
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.patches import Circle, Patch, Polygon

from deploy.telemetry.plot.style import FAINT, INK
from deploy.telemetry.recording.reading.reader import Recording
from protocol.geometry import Disk, Shape
from protocol.messages import Clock


class Stay(NamedTuple):
    """A thing, and from when until when it stood, s of simulated time; infinite if it went never."""

    shape: Shape
    since: float
    until: float

    @property
    def words(self) -> str:
        """When it came and went; "" if it was there all the time."""
        came = f"from {self.since:.1f} s" if self.since > 0.0 else ""
        went = f"until {self.until:.1f} s" if math.isfinite(self.until) else ""
        return " ".join(filter(None, (came, went)))


def stays(recording: Recording) -> list[Stay]:
    """Everything that ever stood, in the order of numbers, as the world's clock told it."""
    shapes = dict(recording.scenario.shapes)
    since, until = dict.fromkeys(shapes, 0.0), dict.fromkeys(shapes, math.inf)
    came: set[int] = set()
    for clock in recording.said(Clock):
        told = {thing.number: thing for thing in clock.things}
        for number, thing in told.items():
            if thing.status == "standing" and number not in shapes:
                shapes[number], since[number], until[number] = thing.shape, clock.time, math.inf
                came.add(number)
        for number in shapes:
            gone = told[number].status == "gone" if number in told else number in came
            if gone:
                until[number] = min(until[number], clock.time)
    return [Stay(shapes[number], since[number], until[number]) for number in sorted(shapes)]


def draw_things(axes: Axes, recording: Recording) -> list[tuple[Patch, Stay]]:
    """Draw everything that ever stood: filled what stands at the end, dashed what went."""
    drawn = []
    for stay in stays(recording):
        went = math.isfinite(stay.until)
        patch = patch_of(stay.shape, facecolor=FAINT, edgecolor=INK, alpha=0.35, linewidth=0.8, zorder=3)
        if went:
            patch.set(fill=False, linestyle="--")
        axes.add_patch(patch)
        drawn.append((patch, stay))
        if stay.words:
            centre = stay.shape.around
            axes.text(
                centre.x, centre.y, stay.words, ha="center", va="center", fontsize=5, color=INK, zorder=6
            )
    return drawn


def patch_of(shape: Shape, **look: object) -> Patch:
    """A shape as matplotlib draws it."""
    if isinstance(shape, Disk):
        return Circle((shape.x, shape.y), shape.radius, **look)
    return Polygon(shape.points, closed=True, **look)
