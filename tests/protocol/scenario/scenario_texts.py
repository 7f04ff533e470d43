"""Scenario files in small, and what is wrong with a text."""

from typing import Any

import pytest

from protocol.errors import ScenarioError
from protocol.scenario.file import parse_toml

ROBOTS = """
[[robots]]
id = 1
radius = 0.04
start = [0.0, 0.0]
goal = [0.1, 0.1]
[[robots]]
id = 2
radius = 0.04
start = [-0.2, 0.0]
goal = [-0.1, -0.1]
"""
THIRD = "[[robots]]\nid = 3\nradius = 0.04\nstart = [0.067, 0.0]\ngoal = [0.0, 0.2]\n"


def problems(text: str) -> dict[str, str]:
    with pytest.raises(ScenarioError) as caught:
        parse_toml(text)
    found = {problem.path: problem.text for problem in caught.value.problems}
    assert len(found) == len(caught.value.problems)
    return found


def document() -> dict[str, Any]:
    robots = [{"id": n, "radius": 0.04, "start": [0.1 * n, 0.0], "goal": [-0.1 * n, 0.0]} for n in (1, 2)]
    return {"robots": robots}
