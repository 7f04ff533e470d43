"""The hosts table: whatever is wrong is said at once, with its path."""

import tomllib
from pathlib import Path

import pytest

from deploy.processes.hosts.table import parse_hosts, read_hosts, roster_of
from deploy.run.assembly import MultiHost, places
from deploy.security.membership import KeyRing
from protocol.errors import HostsError, UsageError

BASE = {"name": "base", "address": "10.0.0.1", "robots": [1, 3]}
LEFT = {"name": "left", "address": "10.0.0.2", "port": 7448, "listen": "0.0.0.0", "robots": [2]}
SSH = {"ssh": "robot@10.0.0.2", "options": ["-p", "2222"], "command": "/opt/disknav/bin/disknav"}
GOOD = {"world": "left", "hosts": [BASE, LEFT | SSH]}


def problems(text: str) -> list[str]:
    with pytest.raises(HostsError) as caught:
        parse_hosts(tomllib.loads(text), (1, 2, 3))
    return [str(problem) for problem in caught.value.problems]


def test_what_runs_where() -> None:
    table = parse_hosts(GOOD, (1, 2, 3))
    assert table.world_host.name == "left"
    on_base, on_left = ("router-base", "robot-1", "robot-3"), ("router-left", "world", "robot-2")
    assert places(table) == {**dict.fromkeys(on_base, "base"), **dict.fromkeys(on_left, "left")}


def test_a_robot_that_was_added_is_on_no_host() -> None:
    hosts = parse_hosts(GOOD, (1, 2, 3))
    with pytest.raises(UsageError, match=r"\(base, left\) runs robot 7: `disknav node robot 7 --run"):
        MultiHost(hosts, KeyRing(None), {}).connection("robot-7")


def test_robots_that_orders_add_may_be_on_a_host() -> None:
    hosts = parse_hosts(GOOD, (1, 2), newcomers=(3, 4))
    assert places(hosts)["robot-3"] == "base"
    assert roster_of("yard", hosts).robots == (1, 2, 3)


def test_every_problem_at_once() -> None:
    found = problems("""
world = "nowhere"
hosts = [
  {name = "base", address = "10.0.0.1", robots = [1, 9], prot = 3},
  {name = "base", address = "10.0.0.1", robots = [1], ssh = "-oProxyCommand=x"},
  {name = "a b", address = "tcp/10.0.0.3", port = 70000, options = "-p 2222", command = ""},
]
""")
    assert found == [
        "hosts: robots 2, 3 of the scenario must be on a host",
        "hosts[0].prot: unknown key; did you mean `port`?",
        "hosts[0].robots[1]: the scenario has no robot 9",
        "hosts[1].name: is the name of hosts[0] already",
        "hosts[1].port: hosts[0] has its router at 10.0.0.1, port 7447 already",
        "hosts[1].robots[0]: robot 1 is on hosts[0] already",
        "hosts[1].ssh: must be a destination such as user@host; options go into `options`",
        "hosts[2].address: must be a name or an address, without protocol, port or path",
        "hosts[2].command: must not be empty",
        "hosts[2].name: must be of letters, digits and '-', and not begin with '-'",
        'hosts[2].options: must be an array, not the string "-p 2222"',
        "hosts[2].port: must be at most 65535, is 70000",
        "world: there is no host 'nowhere'; there are base",
    ]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "hosts: is missing"),
        ("hosts = []", "hosts: must not be empty"),
        ("hosts = 3", "hosts: must be an array, not 3"),
        ("[[hosts]]\nname = 'a'", "hosts[0].address: is missing"),
        ("[[hosts]]\nname = 'a'\naddress = ''", "hosts[0].address: must not be empty"),
    ],
)
def test_what_is_missing(text: str, problem: str) -> None:
    assert problem in problems(text)


def test_a_file_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(HostsError, match="cannot be read"):
        read_hosts(tmp_path / "hosts.toml")
    (tmp_path / "hosts.toml").write_text("[[hosts]")
    with pytest.raises(HostsError, match="not TOML"):
        read_hosts(tmp_path / "hosts.toml")
