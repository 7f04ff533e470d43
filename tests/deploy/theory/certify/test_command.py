"""`disknav certify`: exit statuses, files, output; and where the proven K is used."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from deploy.cli.application import app
from deploy.library.load import load
from deploy.theory.certify.certificate import ProofError, fetch
from protocol.errors import UsageError
from tests.until import until

pytestmark = pytest.mark.slow


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments), catch_exceptions=True)


@pytest.mark.parametrize("name", ["swap-2", pytest.param("figure-2", marks=pytest.mark.campaign)])
def test_a_proof_its_verification_and_its_use(here: Path, name: str) -> None:
    found = call("certify", name, "--k", "1000", "--quiet", "--json")
    assert found.exit_code == 0
    data = json.loads(found.stdout)
    assert data["proven"] == data["asked"] == 1000.0
    assert data["boxes"] == sum(slab["boxes"] for slab in data["slabs"])
    assert data["file"] == f"{name}.certificate.json"
    assert (here / data["file"]).is_file()

    checked = call("certify", name, "--verify", data["file"], "--quiet", "--json")
    assert checked.exit_code == 0
    assert json.loads(checked.stdout)["verified"] == 1000.0
    assert call("certify", "--verify", data["file"], "--k", "500", "--quiet").exit_code == 1

    theory = json.loads(call("check", name, "--json").stdout)
    assert theory["certificate"] == {"file": data["file"], "k": 1000.0, "refused": None}
    assert load(name, ("control.k=certified",)).k == 1000.0


def test_a_certificate_of_other_goals_is_refused_by_name(here: Path) -> None:
    assert call("certify", "swap-2", "--k", "1000", "--quiet").exit_code == 0
    (here / "swap-2.certificate.json").rename(here / "figure-2.certificate.json")
    for arguments in (("figure-2", "--k", "1000"), ("figure-2", "--verify", "figure-2.certificate.json")):
        error = call("certify", *arguments, "--quiet").exception
        assert isinstance(error, ProofError)
        assert "figure-2.certificate.json" in str(error)
    refused = json.loads(call("check", "figure-2", "--json").stdout)["certificate"]
    assert refused["k"] is None
    assert "the scenario's goals" in refused["refused"]
    with pytest.raises(ProofError, match="the scenario's goals"):
        load("figure-2", ("control.k=certified",))


@pytest.mark.usefixtures("here")
def test_k_certified_needs_a_certificate() -> None:
    with pytest.raises(UsageError, match="disknav certify figure-2"):
        load("figure-2", ("control.k=certified",))


@pytest.mark.usefixtures("here")
def test_too_little_time_is_status_1() -> None:
    first = call("certify", "figure-2", "--k", "4", "--minutes", "0", "--quiet", "--json")
    assert first.exit_code == 1
    data = json.loads(first.stdout)
    assert data["proven"] is None or data["proven"] > 4.0


def test_nothing_to_certify_is_an_error(here: Path) -> None:
    assert isinstance(call("certify").exception, UsageError)
    assert isinstance(call("certify", "--verify", "nowhere.json").exception, ProofError)
    assert call("certify", "figure-2", "--k", "0.5").exit_code == 2
    assert isinstance(call("certify", "figure-2", "--k", "inf").exception, UsageError)
    assert not list(here.iterdir())


@pytest.mark.process
def test_ctrl_c_leaves_a_file_to_go_on_from(here: Path) -> None:
    command = [sys.executable, "-m", "disknav", "certify", "figure-2", "--minutes", "5", "--quiet"]
    root = Path(__file__).resolve().parents[4]
    with subprocess.Popen(command, env=os.environ | {"PYTHONPATH": str(root)}) as process:
        try:
            path = here / "figure-2.certificate.json"
            until(path.is_file, 90.0)
            process.send_signal(signal.SIGINT)
            assert process.wait(120) == 130
        finally:
            process.kill()
    before = fetch(path).proven
    assert call("certify", "figure-2", "--k", "100", "--quiet").exit_code == 0
    assert fetch(path).proven in (100.0, before)
