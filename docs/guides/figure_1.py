# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Figure 1 in ten lines
#
# Robot 1 passes between robots 2 to 5, which start 10 mm from their goals, give way, and return.
# `jupytext --to ipynb figure_1.py` makes a notebook of this file; Jupyter with jupytext opens it as one.

# %%
import matplotlib.pyplot as plt

import disknav

run = disknav.run("figure-1")
figure, axes = plt.subplots(figsize=(5, 5), subplot_kw={"aspect": "equal"})
axes.add_patch(plt.Circle((0, 0), run.scenario.workspace.radius, fill=False))
for spec in run.scenario.robots:
    (path,) = axes.plot(*run.trajectory.of_robot(spec.id).T)
    axes.add_patch(plt.Circle(spec.goal, spec.radius, alpha=0.3, color=path.get_color()))
axes.set(xlabel="x, m", ylabel="y, m", title=f"{run.verdict} after {run.result['sim_time']:.2f} s")

# %% [markdown]
# How far each robot was moved aside, and how close any two disks came:

# %%
{robot: f"{1000 * aside:.0f} mm" for robot, aside in run.result["lateral_deviation"].items()}

# %%
f"{1000 * run.trajectory.clearance.min():.1f} mm"
