"""Hosts before a run: whether each is fit."""

import re
import socket
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import typer

from deploy.cli.setup import hosts as command
from deploy.processes.hosts import prepare
from deploy.processes.hosts.prepare import check
from deploy.processes.hosts.remote import GREETING
from deploy.processes.hosts.table import Host
from deploy.software import SOFTWARE, Finding, code_digest
from tests.deploy.processes.ports import free_ports
from tests.forks import Forks
from tests.system.hosts.testbed.ssh_server import needs_sshd, ssh_server

HERE = code_digest(SOFTWARE)


@pytest.fixture(scope="module")
def far(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Host]:
    with ssh_server(tmp_path_factory.mktemp("sshd")) as server:
        yield Host(
            "far", "127.0.0.1", ssh=f"{server.user}@127.0.0.1", options=server.options, command=server.command
        )


@pytest.mark.process
@needs_sshd
def test_a_host_that_is_fit(far: Host) -> None:
    (port,) = free_ports(1)
    found = {each.what: each for each in check(replace(far, port=port))}
    assert {each.level for each in found.values()} <= {"good", "note"}, found
    assert set(found) == {"reach", "version", "compiled", "clock rate", "router port", "space"}
    rate = re.fullmatch(r"([+-]\d+) ± (\d+) ppm", found["clock rate"].text)
    assert abs(int(rate[1])) <= int(rate[2]) + 1000  # it is the clock of this machine


@pytest.mark.process
@needs_sshd
@pytest.mark.parametrize(
    ("changes", "what", "text"),
    [
        ({"command": "/nowhere/it"}, "reach", "host far: its shell finds no command '/nowhere/it'"),
        ({"ssh": "nobody-at-all@127.0.0.1"}, "reach", "host far is gone: ssh ended with status 255"),
        ({"command": f"echo {GREETING} {HERE} /tmp; yes #"}, "reach", "does not follow the protocol"),
        ({"command": f"echo {GREETING} 0 /tmp; cat #"}, "version", "not the same version"),
    ],
)
def test_a_host_that_is_not(changes: dict[str, str], what: str, text: str, far: Host) -> None:
    (found,) = check(replace(far, **changes))
    assert (found.what, found.level) == (what, "bad")
    assert text in found.text


@pytest.mark.process
@needs_sshd
def test_a_port_that_is_taken(far: Host) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        found = {each.what: each.level for each in check(replace(far, port=taken.getsockname()[1]))}
    assert found["router port"] == "bad"


@pytest.mark.process
@needs_sshd
def test_a_host_that_goes_on_for_ever_is_given_up(monkeypatch: pytest.MonkeyPatch, far: Host) -> None:
    monkeypatch.setattr(prepare, "_PATIENCE", 2.0)
    (found,) = check(replace(far, command="while :; do echo; sleep 0.1; done #"))
    assert (found.what, found.level, found.text) == ("reach", "bad", "host far did not answer in time")


def test_what_a_host_says_cannot_steer_the_terminal(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lie = Finding("router port", "bad", "[/red] \x1b[2J")
    monkeypatch.setattr(prepare, "check", lambda _: [lie])
    table = tmp_path / "hosts.toml"
    table.write_text('[[hosts]]\nname = "here"\naddress = "127.0.0.1"\nrobots = [1]\n')
    with pytest.raises(typer.Exit):
        command(table)
    shown = capsys.readouterr().out
    assert "[/red]" in shown
    assert "\x1b[2J" not in shown


@pytest.mark.slow
def test_the_command_tells_by_its_status(disknav: Forks, tmp_path: Path) -> None:
    table = tmp_path / "hosts.toml"
    (port,) = free_ports(1)
    text = f'[[hosts]]\nname = "here"\naddress = "127.0.0.1"\nport = {port}\nrobots = [3, 7]\n'
    for address, status in (("127.0.0.1", 0), ("203.0.113.1", 1)):
        table.write_text(text.replace("127.0.0.1", address))
        done = disknav("setup", "hosts", table)
        assert done.returncode == status, done.stdout + done.stderr
        assert "router port" in done.stdout
