"""A picture of a study: python draw.py STUDY.json X Y [BY] draws Y over X, a curve for each value of BY."""

import json
import sys
from pathlib import Path

import matplotlib.pyplot as plt

if len(sys.argv) < 4:
    sys.exit(__doc__)
file, x, y, *by = sys.argv[1:]
if not Path(file).exists():
    sys.exit(f"{file} is missing: disknav study STUDY --json {file} makes it")
rows = json.loads(Path(file).read_text())["rows"]
figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
for curve in dict.fromkeys(tuple(row[name] for name in by) for row in rows):
    known = [row for row in rows if tuple(row[name] for name in by) == curve and row[y] is not None]
    deviations = [row.get(y.replace("_mean", "_std")) or 0.0 for row in known] if "_mean" in y else None
    label = ", ".join(map(str, curve)) or "measured"
    axes.errorbar([row[x] for row in known], [row[y] for row in known], deviations, marker="o", label=label)
for name, mark in (("paper", "s"), ("exact", "x")):  # what the paper prints; its continuous flow
    known = [row for row in rows if row.get(name) is not None]
    if known and y == "nrl_mean":
        axes.plot([row[x] for row in known], [row[name] for row in known], mark, label=name)
axes.set(xlabel=x, ylabel=y)
if rows[-1][x] > 20 * rows[0][x] > 0:
    axes.set_xscale("log")
axes.legend()
figure.savefig(Path(file).with_suffix(".png"), dpi=90)
