"""The first part of a recording, for a picture of a moment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deploy.recording.reader import Recording, Truths


def until(recording: Recording, seconds: float) -> Recording:
    """What was recorded up to `seconds` of simulated time, tick 0 at least; no result unless that is all."""
    truths, step = recording.truths, recording.scenario.time.step
    kept = truths.ticks * step <= max(seconds, 0.0) + 0.5 * step
    if kept.all():
        return recording
    there = ~np.isnan(truths.positions[kept, :, 0]).all(axis=0)
    positions = truths.positions[kept][:, there]
    part = Truths(
        truths.robots[there], truths.ticks[kept], positions, truths.clearance[kept], truths.phi[kept]
    )
    last = float(part.ticks[-1]) * step
    entries = recording.entries.where(lambda entry: entry.time <= last + 0.5 * step)
    return replace(recording, truths=part, entries=entries, result=None)
