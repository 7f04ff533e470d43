"""The router's rules, without a router: everything declared is possible to its owner and to no other role."""

from itertools import product
from typing import Any

import pytest
import zenoh

from deploy.security.roster import Home, KeyRoster, access_control
from protocol.errors import CertificateError
from protocol.keys import (
    ROBOT_STREAMS,
    STREAMS,
    WORLD_STREAMS,
    parse,
    robot_key,
    robot_token,
    world_key,
    world_token,
)

ROSTER = KeyRoster("demo", (1, 2, 3))
RULES = access_control(ROSTER)
MESSAGES = sorted({message for rule in RULES["rules"] for message in rule["messages"]})


def allowed(role: str, message: str, key: str, rules: dict[str, Any] = RULES) -> bool:
    """What zenoh decides on the way in: a rule of this subject includes the key."""
    granted = {
        rule for policy in rules["policies"] if policy["subjects"] == [role] for rule in policy["rules"]
    }
    return any(
        zenoh.KeyExpr(expression).includes(zenoh.KeyExpr(key))
        for rule in rules["rules"]
        if rule["id"] in granted and "ingress" in rule["flows"] and message in rule["messages"]
        for expression in rule["key_exprs"]
    )


def keys() -> list[str]:
    robots = [robot_key("demo", robot, stream) for robot in ROSTER.robots for stream in ROBOT_STREAMS]
    tokens = [world_token("demo", "1"), *(robot_token("demo", robot, "1") for robot in ROSTER.robots)]
    return robots + [world_key("demo", stream) for stream in WORLD_STREAMS] + tokens


@pytest.mark.parametrize("role", ROSTER.roles)
def test_everybody_writes_what_is_declared_theirs_and_nothing_else(role: str) -> None:
    writable = {key for key in keys() if allowed(role, "put", key)}
    names = {name for name, stream in STREAMS.items() if stream.publisher == role.partition("-")[0]}
    if role in ("router", "monitor"):  # another router has no business at the only one
        assert writable == set()
    elif role in ("world", "operator"):
        assert {parse(key).stream for key in writable} == names
        assert writable == {key for key in keys() if parse(key).stream in names}
    else:
        assert names == {"state", "command", "health"}
        assert writable == {robot_key("demo", int(role.removeprefix("robot-")), name) for name in names}


@pytest.mark.parametrize("role", ROSTER.roles[1:])
def test_no_role_deletes_and_only_the_world_answers(role: str) -> None:
    for key in keys():
        assert not allowed(role, "delete", key)
        answers = role == "world" and key.endswith(("/scenario", "/steering", "/join", "/operation"))
        assert allowed(role, "declare_queryable", key) == allowed(role, "reply", key) == answers


@pytest.mark.parametrize("role", ROSTER.roles[1:])
def test_a_token_stands_for_oneself(role: str) -> None:
    tokens = {key for key in keys() if allowed(role, "liveliness_token", key)}
    own = {"world": {world_token("demo", "1")}, "monitor": set(), "operator": set()}
    for robot in ROSTER.robots:
        own[f"robot-{robot}"] = {robot_token("demo", robot, "1")}
    assert tokens == own[role]


def test_only_an_operator_sends_robots_elsewhere() -> None:
    operation = world_key("demo", "operation")
    assert [role for role in ROSTER.roles[1:] if allowed(role, "query", operation)] == ["operator"]
    assert all(allowed("operator", "query", world_key("demo", name)) for name in ("scenario", "steering"))


def test_robots_neither_steer_nor_read_each_others_commands() -> None:
    assert not allowed("robot-1", "query", world_key("demo", "steering"))
    assert [r for r in ROSTER.robots if allowed("robot-1", "query", robot_key("demo", r, "join"))] == [1]
    assert not allowed("robot-1", "query", "disknav/demo/robot/*/join")
    assert not allowed("robot-1", "declare_subscriber", "disknav/demo/robot/*/command")
    assert not allowed("robot-1", "declare_subscriber", robot_key("demo", 2, "tick"))
    assert not allowed("robot-1", "declare_subscriber", world_key("demo", "truth"))
    assert not allowed("robot-1", "declare_subscriber", "disknav/demo/**")


@pytest.mark.parametrize("role", ROSTER.roles)
def test_another_run_is_another_world(role: str) -> None:
    for message in MESSAGES:
        assert not allowed(role, message, robot_key("other", 1, "state"))
        assert not allowed(role, message, "**")


HOSTS = KeyRoster(
    "demo", (1, 2, 3), {"a": Home(("a",), (1,)), "b": Home(("b",), (2, 3)), "c": Home(("c",))}, "a"
)


def granted(role: str, rules: dict[str, Any]) -> set[tuple[str, str]]:
    """Messages that a role may send under keys of the run, and under expressions."""
    expressions = [*keys(), "disknav/demo/robot/*/state", "disknav/demo/**"]
    return {each for each in product(MESSAGES, expressions) if allowed(role, *each, rules)}


@pytest.mark.parametrize("host", HOSTS.homes)
def test_a_router_speaks_for_those_behind_it_and_no_others(host: str) -> None:
    rules = access_control(HOSTS, host)
    for other in HOSTS.homes:
        behind = set().union(*(granted(role, RULES) for role in HOSTS.behind(other)))
        assert granted(f"router-{other}", rules) == (set() if other == host else behind)


def test_a_host_that_is_not_in_the_roster() -> None:
    with pytest.raises(CertificateError, match="not for a host 'd', but for a, b, c"):
        access_control(HOSTS, "d")
