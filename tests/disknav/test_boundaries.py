"""What strangers type: every boundary takes it, or names it in an error of this software; nothing else.

`test_python.py` notices a boundary that refuses everything.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import disknav
from deploy.library.load import read
from deploy.run.options import restarts
from deploy.security.membership import KeyRing
from deploy.telemetry.recording.writer import rotation
from disknav.orders import Orders
from protocol.bus.connection import Endpoint
from protocol.draws import checked_seed
from protocol.errors import DisknavError
from protocol.keys import checked_run, parse
from protocol.scenario.body import Base, ros_name
from protocol.scenario.file import apply_settings, parse_document, parse_toml

TEXTS = st.text(max_size=20) | st.sampled_from(
    ["", "/", "//", "..", "a b", "a\x00b", "a\nb", "\x1b[31m", "\udce9", "é", "figure-1", "figure-1\n",
     "swap-0", "localhost:7447", "tcp/localhost", "tcp/[::1]:7447#a=b", "tls/10.0.0.1:1", "on-failure:3",
     "never", "1h", "control.k=80", "robots[9].id=1", "a=[", "=", "name=\x1b", "seed=nan", "٣", "-1", "1e999",
     "x" * 300]
)  # fmt: skip
NUMBERS = (
    st.integers()
    | st.floats()
    | st.sampled_from([True, np.int64(3), np.uint8(0), np.float32(1.5), np.float64("nan"), np.bool_(True)])
    | st.sampled_from([10**30, -1, 0, None])
)
ARRAYS = st.lists(st.floats() | st.integers(), max_size=4).map(np.array)
VALUES = st.recursive(
    TEXTS
    | NUMBERS
    | ARRAYS
    | st.sampled_from([1j, object(), {1}, b"x", disknav.Simulation, np.datetime64("NaT")]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS | NUMBERS, inner, max_size=3),
    max_leaves=8,
)
ROBOT = {"id": 1, "radius": 0.04, "start": [0.0, 0.0], "goal": [0.1, 0.1]}
FIELDS = st.sampled_from(
    ["seed", "name", "description", "robots", "workspace", "control", "sensing", "link", "orders",
     "obstacles", "body", "base", "parts", "time", "world", "network", "process", "carrying",
     "actuation", "nmae"]
)  # fmt: skip


def refused(call: Callable[..., object], *arguments: Any) -> str:
    """Why `call` did not take its arguments, "" if it did; any other error than ours is raised."""
    try:
        call(*arguments)
    except DisknavError as error:
        assert str(error), "an error that says nothing"
        return str(error)
    return ""


@given(TEXTS)
@pytest.mark.parametrize(
    "boundary",
    [Endpoint, KeyRing().endpoint, checked_run, parse, ros_name, restarts, read, parse_toml, disknav.load],
    ids=lambda each: getattr(each, "__qualname__", "endpoint"),
)
def test_texts(boundary: Callable[[str], object], text: str) -> None:
    said = refused(boundary, text)
    assert said.isprintable() or boundary in (parse_toml, read, disknav.load), said


@given(st.lists(TEXTS, max_size=2))
def test_lists_of_texts(texts: list[str]) -> None:
    refused(rotation, texts)
    refused(apply_settings, {"robots": [dict(ROBOT)]}, texts)
    refused(read, "figure-1", texts)


@given(VALUES)
def test_seeds(seed: object) -> None:
    if not refused(checked_seed, seed):
        assert type(checked_seed(seed)) is int
        assert 0 <= checked_seed(seed) < 2**63


@given(TEXTS, TEXTS, st.integers(1, 10**9 - 1))
def test_a_name_that_is_taken_makes_a_key_of_zenoh(namespace: str, topic: str, robot: int) -> None:
    table = {"namespace": namespace, "velocity": topic}
    document = {
        "world": {"plant": "external"},
        "body": "turtlebot4",
        "base": table,
        "workspace": {"radius": 9},
    }
    robots = [{"id": robot, "start": [0, 0], "goal": [1, 1]}]
    if not refused(parse_document, {**document, "robots": robots}):
        base = Base(namespace=namespace, velocity=topic).of(robot)
        key = base.topic(base.velocity)
        assert all(key.split("/"))
        assert not set(key) & set("*?#$ {}")


@given(FIELDS, VALUES)
def test_documents(field: str, value: Any) -> None:
    refused(disknav.build, {"robots": [ROBOT], field: value})
    refused(disknav.load, "figure-1", {field: value})


@given(st.sampled_from(["id", "radius", "start", "goal", "heading", "body", "base"]), VALUES)
def test_robots(field: str, value: Any) -> None:
    refused(disknav.build, {"robots": [{**ROBOT, field: value}]})


@pytest.fixture(scope="module")
def orders() -> Orders:
    return disknav.Simulation("swap-6").orders


@given(VALUES, st.lists(VALUES, max_size=3), VALUES, VALUES)
def test_orders(orders: Orders, robot: Any, points: list[Any], within: Any, radius: Any) -> None:
    refused(lambda: orders.send(robot, *points, within=within))
    refused(orders.status, robot)
    refused(orders.wish, robot, points)
    refused(lambda: orders.place(*points, radius=radius))
    refused(orders.take, robot)


@given(VALUES)
def test_scenarios_and_names_of_runs(value: Any) -> None:
    assert (isinstance(value, str) and value == "figure-1") or refused(disknav.Simulation, value)
    assert refused(lambda: disknav.Simulation("figure-1", name=value)) or isinstance(value, str)
