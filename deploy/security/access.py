"""The router's rules: who may say and hear what, from the roster and the declared streams.

Everything is denied that no rule allows. What a process sends is checked when it enters a router,
and only what it subscribed to with leave can come back, so the way out needs one rule for all.
A declared subscription, query or token must lie within an allowed key expression.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from deploy.security.roster import MONITOR, ROUTER, WORLD, Roster, robot_role
from protocol.keys import ROBOT_STREAMS, WORLD_STREAMS, every_robot, everything, robot_key, world_key
from protocol.streams import STREAMS

Rule = dict[str, Any]

_PUBLISH = ("put",)
_SUBSCRIBE = ("declare_subscriber",)
_ASK = ("query",)
_SERVE = ("declare_queryable", "reply")
_ANNOUNCE = ("liveliness_token",)
_WATCH = ("declare_liveliness_subscriber", "liveliness_query")
_ALL = (*_PUBLISH, "delete", *_SUBSCRIBE, *_ASK, *_SERVE, *_ANNOUNCE, *_WATCH)
_QUERYABLES = ("scenario", "steering")

_ALIVE = "alive"


def access_control(roster: Roster) -> dict[str, Any]:
    """zenoh's `access_control` for a router of this run. Subjects are common names of certificates."""
    run = roster.run
    roles = {
        ROUTER: [_rule(ROUTER, "relay", _ALL, [everything(run)])],
        WORLD: list(_world(run)),
        MONITOR: list(_monitor(run)),
        **{robot_role(robot): list(_robot(run, robot)) for robot in roster.robots},
    }
    out = _rule("anybody", "hear", _ALL, [everything(run)], flow="egress")
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [out, *(rule for rules in roles.values() for rule in rules)],
        "subjects": [{"id": role, "cert_common_names": [role]} for role in roles],
        "policies": [
            {"rules": [out["id"], *(rule["id"] for rule in rules)], "subjects": [role]}
            for role, rules in roles.items()
        ],
    }


def _robot(run: str, robot: int) -> Iterator[Rule]:
    """A robot writes under its own id, hears its Ticks and everybody's state, asks for the scenario.

    Its own health is for the probe beside it, which has no other certificate; so is the world's clock.
    """
    role = robot_role(robot)
    own = [robot_key(run, robot, stream) for stream in ROBOT_STREAMS if _published_by(stream, "robot")]
    yield _rule(role, "publish", _PUBLISH, own)
    yield _rule(
        role,
        "subscribe",
        _SUBSCRIBE,
        [*(robot_key(run, robot, stream) for stream in ("tick", "health")), every_robot(run, "state")],
    )
    yield _rule(role, "ask", _ASK, [world_key(run, "scenario")])
    yield _rule(role, "announce", _ANNOUNCE, [robot_key(run, robot, _ALIVE)])
    yield _rule(role, "watch", _WATCH, [world_key(run, _ALIVE)])


def _world(run: str) -> Iterator[Rule]:
    """The world writes Ticks and what is its own, hears commands, answers questions."""
    to_robots = [every_robot(run, stream) for stream in ROBOT_STREAMS if _published_by(stream, "world")]
    own = [world_key(run, stream) for stream in WORLD_STREAMS if _published_by(stream, "world")]
    yield _rule(WORLD, "publish", _PUBLISH, [*to_robots, *own])
    yield _rule(WORLD, "subscribe", _SUBSCRIBE, [every_robot(run, "command"), world_key(run, "clock")])
    yield _rule(WORLD, "serve", _SERVE, [world_key(run, stream) for stream in _QUERYABLES])
    yield _rule(WORLD, "announce", _ANNOUNCE, [world_key(run, _ALIVE)])
    yield _rule(WORLD, "watch", _WATCH, [every_robot(run, _ALIVE)])


def _monitor(run: str) -> Iterator[Rule]:
    """A monitor hears everything and writes nothing; it may ask for the scenario and use the controls."""
    yield _rule(MONITOR, "subscribe", _SUBSCRIBE, [everything(run)])
    yield _rule(MONITOR, "ask", _ASK, [world_key(run, stream) for stream in _QUERYABLES])
    yield _rule(MONITOR, "watch", _WATCH, [everything(run)])


def _published_by(stream: str, who: str) -> bool:
    return stream in STREAMS and STREAMS[stream].publisher == who


def _rule(
    role: str, name: str, messages: Sequence[str], keys: Sequence[str], *, flow: str = "ingress"
) -> Rule:
    return {
        "id": f"{role} {name}",
        "permission": "allow",
        "flows": [flow],
        "messages": list(messages),
        "key_exprs": list(keys),
    }
