"""The roles of a run, and the access rules of its routers.

All is denied that no rule allows. Messages are checked where they enter a router. Only permitted
subscriptions receive any, so one rule suffices for the way out. A declared subscription, query or token must
lie within an allowed key expression.

The router of another host may pass on messages of its own robots only, so an attacker on a host speaks for
its robots only. Therefore no messages are relayed over a third host.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from protocol.codec import DAMAGED
from protocol.errors import CertificateError
from protocol.keys import (
    QUESTIONS,
    ROBOT_STREAMS,
    STREAMS,
    checked_run,
    every_robot,
    everything,
    robot_key,
    robot_tokens,
    world_key,
    world_tokens,
)

ROSTER = "roster.json"
WORLD, ROUTER, MONITOR, OPERATOR = "world", "router", "monitor", "operator"


@dataclass(frozen=True, slots=True)
class Home:
    """A host with a router of its own."""

    addresses: tuple[str, ...]  # names or addresses of its router, without a port
    robots: tuple[int, ...] = ()  # clients of its router


@dataclass(frozen=True, slots=True)
class KeyRoster:
    """The roles of `run`, and their hosts. Each role is the common name of one certificate.

    Without `homes` there is one router for all.
    """

    run: str
    robots: tuple[int, ...]
    homes: Mapping[str, Home] = field(default_factory=dict)  # by name of the host
    world: str = ""  # host whose router serves the world and the monitors

    @property
    def routers(self) -> tuple[str, ...]:
        """Roles of the routers: `router`, or `router-left` and so on."""
        return tuple(map(router_role, self.homes)) or (ROUTER,)

    @property
    def roles(self) -> tuple[str, ...]:
        """Every role: routers, world, monitor, operator, then `robot-1` and so on."""
        return (*self.routers, WORLD, MONITOR, OPERATOR, *map(robot_role, self.robots))

    def behind(self, host: str) -> tuple[str, ...]:
        """Roles of the clients of the router of `host`; raises CertificateError if there is none."""
        if host not in self.homes:
            raise CertificateError(
                f"the keys of the run {self.run} are not for a host {host!r}, "
                f"but for {', '.join(self.homes) or 'one router'}"
            )
        others = (WORLD, MONITOR, OPERATOR) if host == self.world else ()
        return (*others, *map(robot_role, self.homes[host].robots))


def robot_role(robot: int) -> str:
    """Role of one robot, `robot-3`."""
    return f"robot-{robot}"


def router_role(host: str = "") -> str:
    """Role of the router of a host, `router-left`; `router` if there is one for all."""
    return f"{ROUTER}-{host}" if host else ROUTER


def encoded(roster: KeyRoster) -> bytes:
    """Content of the roster's file."""
    return msgspec.json.format(msgspec.json.encode(asdict(roster))) + b"\n"


def read(directory: Path) -> KeyRoster:
    """The roster of a directory of keys; raises CertificateError if it is missing or invalid."""
    path = directory / ROSTER
    try:
        roster = msgspec.json.decode(path.read_bytes(), type=KeyRoster)
    except FileNotFoundError:
        raise CertificateError(
            f"{path} does not exist: {directory} is not a directory of keys; "
            f"make one: `disknav setup keys {directory} --scenario S`"
        ) from None
    except (OSError, *DAMAGED) as error:
        raise CertificateError(f"{path} cannot be read as a roster: {error}") from error
    checked_run(roster.run)
    return roster


Rule = dict[str, Any]

_PUBLISH = ("put",)
_SUBSCRIBE = ("declare_subscriber",)
_ASK = ("query",)
_SERVE = ("declare_queryable", "reply")
_ANNOUNCE = ("liveliness_token",)
_WATCH = ("declare_liveliness_subscriber", "liveliness_query")
_ALL = (*_PUBLISH, "delete", *_SUBSCRIBE, *_ASK, *_SERVE, *_ANNOUNCE, *_WATCH)

_ADMIN = "@/*/router/**"  # zenoh's admin space of a router, if enabled


def access_control(roster: KeyRoster, host: str = "") -> dict[str, Any]:
    """zenoh's `access_control` for the router of `host` (CertificateError if unknown), or for the only one.

    Subjects are common names of certificates.
    """
    run = roster.run
    rules = {rule["id"]: rule for role in roster.roles for rule in _rules(run, role)}
    out = _rule("all", "receive", _ALL, [everything(run), _ADMIN], flow="egress")
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [out, *rules.values()],
        "subjects": [{"id": role, "cert_common_names": [role]} for role in _speakers(roster, host)],
        "policies": [
            {
                "rules": [out["id"], *(rule["id"] for each in roles for rule in _rules(run, each))],
                "subjects": [role],
            }
            for role, roles in _speakers(roster, host).items()
        ],
    }


def _speakers(roster: KeyRoster, host: str) -> dict[str, tuple[str, ...]]:
    """Peers of this router -> the roles whose messages each may send."""
    clients = (
        roster.behind(host) if roster.homes else (WORLD, MONITOR, OPERATOR, *map(robot_role, roster.robots))
    )
    routers = {router_role(other): roster.behind(other) for other in roster.homes if other != host}
    return {**routers, **{role: (role,) for role in clients}}


def _rules(run: str, role: str) -> Iterator[Rule]:
    if role == WORLD:
        yield from _world(run)
    elif role == MONITOR:
        yield from _watcher(run, MONITOR, _questions("monitor"))
    elif role == OPERATOR:
        yield from _watcher(run, OPERATOR, [*_questions("monitor"), *_questions("operator")])
        yield _rule(role, "publish", _PUBLISH, [_key(run, name) for name in _published_by("operator")])
    elif role.startswith("robot-"):
        yield from _robot(run, int(role.removeprefix("robot-")))


def _robot(run: str, robot: int) -> Iterator[Rule]:
    """A robot writes, asks and announces itself under its own id only."""
    role = robot_role(robot)
    own = [_key(run, name, robot) for name in _heard_by("itself")]
    everybodys = [_key(run, name) for name in _heard_by("robots")]
    yield _rule(role, "publish", _PUBLISH, [_key(run, name, robot) for name in _published_by("robot")])
    yield _rule(role, "subscribe", _SUBSCRIBE, [*own, *everybodys])
    yield _rule(role, "ask", _ASK, [_key(run, name, robot) for name in _questions("itself")])
    yield _rule(role, "announce", _ANNOUNCE, [robot_tokens(run, robot)])
    yield _rule(role, "watch", _WATCH, [world_tokens(run)])


def _world(run: str) -> Iterator[Rule]:
    """The world writes its own streams and those to robots, receives commands, and answers queries."""
    yield _rule(WORLD, "publish", _PUBLISH, [_key(run, name) for name in _published_by("world")])
    yield _rule(WORLD, "subscribe", _SUBSCRIBE, [_key(run, name) for name in _heard_by("world")])
    yield _rule(WORLD, "serve", _SERVE, [_key(run, question.name) for question in QUESTIONS])
    yield _rule(WORLD, "ask", _ASK, [world_key(run, "scenario")])  # detects another world
    yield _rule(WORLD, "announce", _ANNOUNCE, [world_tokens(run)])
    yield _rule(WORLD, "watch", _WATCH, [robot_tokens(run), world_tokens(run)])


def _watcher(run: str, role: str, questions: Sequence[str]) -> Iterator[Rule]:
    """A monitor receives all and writes nothing; it may query the scenario and use the controls. An operator
    may also set goals, and add and remove robots and obstacles.
    """
    yield _rule(role, "subscribe", _SUBSCRIBE, [everything(run)])
    yield _rule(role, "ask", _ASK, [*(_key(run, name) for name in questions), _ADMIN])
    yield _rule(role, "watch", _WATCH, [everything(run)])


def _published_by(publisher: str) -> list[str]:
    return [stream.name for stream in STREAMS.values() if stream.publisher == publisher]


def _heard_by(hearer: str) -> list[str]:
    return [stream.name for stream in STREAMS.values() if hearer in stream.heard_by]


def _questions(asker: str) -> list[str]:
    return [question.name for question in QUESTIONS if question.asked_by == asker]


def _key(run: str, name: str, robot: int | None = None) -> str:
    if name not in ROBOT_STREAMS:
        return world_key(run, name)
    return every_robot(run, name) if robot is None else robot_key(run, robot, name)


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
