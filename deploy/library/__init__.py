"""The scenario library: the paper's figures, swaps and random instances, each a function of a seed."""

from deploy.library.demonstrations import crash, delay_6
from deploy.library.figures import figure_1, figure_2
from deploy.library.goal_sets import GOAL_SETS, figure_3, tightness
from deploy.library.names import build, catalogue, suggestions
from deploy.library.random_instances import random_instance, random_starts
from deploy.library.swaps import head_on, swap

__all__ = [
    "GOAL_SETS",
    "build",
    "catalogue",
    "crash",
    "delay_6",
    "figure_1",
    "figure_2",
    "figure_3",
    "head_on",
    "random_instance",
    "random_starts",
    "suggestions",
    "swap",
    "tightness",
]
