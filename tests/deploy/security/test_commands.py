"""The commands that take keys, as a user meets them."""

import json
from pathlib import Path

import pytest

from deploy.security.membership import KeyRing
from deploy.security.roster import KeyRoster
from protocol.errors import UsageError
from tests.forks import Forks

ROSTER = KeyRoster("yard", (1, 2, 3))


@pytest.mark.process
def test_keys_then_a_run_with_them(disknav: Forks, tmp_path: Path) -> None:
    keys = tmp_path / "keys"
    made = disknav("setup", "keys", keys, "--scenario", "figure-2", "--run", "yard")
    assert made.returncode == 0
    assert "for the run yard, valid until" in made.stdout
    done = disknav("run", "figure-2", "--secure", keys, "--json", "-")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["run"] == "yard"


@pytest.mark.slow
def test_mistakes_are_named_before_anything_starts(disknav: Forks, keys: Path, tmp_path: Path) -> None:
    mistakes = {
        ("run", "figure-1", "--secure", keys): "no certificate for robot-4",
        ("run", "figure-2", "--secure", keys, "--run", "other"): "are for the run yard, not other",
        ("run", "figure-2", "--secure", keys, "--transport", "mesh"): "needs --transport routed",
        ("run", "figure-2", "--secure", tmp_path): "not a directory of keys",
        ("node", "robot", "9", "--secure", keys): "no certificate for robot-9",
        ("node", "robot", "1", "--secure", keys, "--router", "tcp/127.0.0.1:7447"): "use tls/",
        ("setup", "keys", keys, "-s", "figure-2"): "--force",
    }
    for command, text in mistakes.items():
        done = disknav(*command)
        assert done.returncode == 2, command
        assert text in done.stderr, command


@pytest.mark.slow
def test_print_config_is_the_whole_of_the_rules(disknav: Forks, keys: Path) -> None:
    printed = disknav("node", "router", "--secure", keys, "--print-config")
    config = json.loads(printed.stdout.partition("\n")[2])
    assert config["listen"]["endpoints"] == ["tls/127.0.0.1:7447"]
    assert config["access_control"]["default_permission"] == "deny"
    assert config["transport"]["link"]["tls"]["enable_mtls"] is True


def test_an_endpoint_need_not_say_the_protocol_of_its_network(tmp_path: Path) -> None:
    assert KeyRing().endpoint("localhost:7611") == "tcp/localhost:7611"
    assert KeyRing(tmp_path).endpoint("10.0.0.1") == "tls/10.0.0.1:7447"
    with pytest.raises(UsageError, match="give --secure DIR"):
        KeyRing().endpoint("tls/10.0.0.1:7447")
    with pytest.raises(UsageError, match="with --secure, use tls/"):
        KeyRing(tmp_path).endpoint("tcp/10.0.0.1:7447")


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        *("fleet goal yard 1 --router", "node router --listen", "node router --connect"),
        *("run figure-1 --keep -q --listen", "run figure-1 -q --router", "monitor yard --router"),
        *("node robot 1 --run yard --router", "node world figure-1 --run yard --router"),
        "fleet probe yard world --router",
    ],
)
def test_what_is_no_endpoint_ends_every_command_in_one_line(disknav: Forks, line: str) -> None:
    ended = disknav(*line.split(), "tcp//localhost")
    assert ended.returncode == 2
    assert "'tcp//localhost' is no endpoint" in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
