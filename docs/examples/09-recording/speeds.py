"""Speeds of a recorded run as data frames and a picture: python speeds.py RECORDING."""

import sys

import matplotlib.pyplot as plt
import pandas as pd

import disknav

if not sys.argv[1:]:
    sys.exit(__doc__)
recording = disknav.read(sys.argv[1])
frame = pd.DataFrame(recording.trajectory.columns())  # one row per tick and robot
step = recording.scenario.time.step
moves = frame.groupby("robot")[["x", "y"]].diff()
frame["speed"] = (moves["x"] ** 2 + moves["y"] ** 2) ** 0.5 / step
print(frame.groupby("robot")["speed"].describe()[["mean", "max"]])

states = pd.DataFrame(recording.columns("state"))  # any recorded stream
print(states.groupby("robot")["gamma"].last())

table = frame.pivot_table(index="time", columns="robot", values="speed")
axes = table.plot(figsize=(5, 3), ylabel="speed, m/s", xlabel="t, s")
axes.figure.savefig("speeds.png", dpi=90, bbox_inches="tight")
plt.close(axes.figure)
