"""Drawing a recording into a file: a picture or an animation, by its suffix."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from deploy.output import check_target, writing
from deploy.telemetry.recording.reader import Progress, Recording
from protocol.errors import UsageError
from protocol.process.installation import missing_library

PICTURES = (".png", ".svg", ".pdf")
ANIMATIONS = (".gif", ".webp", ".mp4")
_WHAT = "draw"


def check(target: Path | None, *others: Path | str | None) -> None:
    """Check before a run that `target`, if any, can be drawn, and is none of `others`.
    Raises UsageError for an unknown suffix, a file that cannot be written, or without matplotlib.
    """
    if target is None:
        return
    kinds = PICTURES + ANIMATIONS
    if target.suffix not in kinds:
        raise UsageError(f"{target}: cannot draw this kind of file; name one that ends in {', '.join(kinds)}")
    check_target(target, _WHAT, *others)
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise missing_library("a picture", "matplotlib", "plot") from error


def draw(
    recording: Recording,
    target: Path,
    progress: Progress = lambda _: None,
    width: int | None = None,
    seconds: float | None = None,
) -> None:
    """Draw a recording into `target`.

    Args:
        target: its suffix selects the format.
        progress: receives the share that is done, 0 to 1.
        width: of an animation, pixels.
        seconds: longest duration of an animation.

    Raises:
        UsageError: as `check`, or the disk is full.
    """
    check(target)
    import matplotlib

    from deploy.telemetry.plot.figure import animate, figure
    from deploy.telemetry.plot.workspace import RC

    with matplotlib.rc_context(RC), writing(target, _WHAT):
        if target.suffix in ANIMATIONS:
            animate(recording, target, progress, width, seconds)
        else:
            metadata = {"Date": None} if target.suffix == ".svg" else {}
            figure(recording).savefig(target, metadata=metadata)


def until(recording: Recording, seconds: float) -> Recording:
    """The recording up to `seconds` of simulated time, at least tick 0; without result if cut."""
    whole, step = recording.trajectory, recording.scenario.time.step
    kept = whole.times <= max(seconds, 0.0) + 0.5 * step
    if kept.all():
        return recording
    part = whole.at(kept)
    last = float(part.times[-1])
    entries = recording.entries.where(lambda entry: entry.time <= last + 0.5 * step)
    return replace(recording, trajectory=part, entries=entries, result=None)
