import io
import json
from pathlib import Path

import pytest

from deploy.output.json_output import check, is_standard_output, write_json
from protocol.errors import UsageError


def test_what_cannot_be_written_is_refused_beforehand(tmp_path: Path) -> None:
    for target in (tmp_path / "missing" / "result.json", tmp_path):
        with pytest.raises(UsageError, match="cannot write JSON to"):
            check(target)


def test_looking_leaves_nothing_behind_and_spoils_nothing(tmp_path: Path) -> None:
    new, old = tmp_path / "new.json", tmp_path / "old.json"
    old.write_text("kept")
    for target in (new, old, Path("-"), Path("/dev/null"), None):
        check(target)
    assert not new.exists()
    assert old.read_text() == "kept"


def test_a_dash_is_standard_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert is_standard_output(Path("-"))
    assert not is_standard_output(tmp_path / "-")
    write_json({"a": 1}, Path("-"))
    write_json({"a": 1}, None)
    assert json.load(io.StringIO(capsys.readouterr().out)) == {"a": 1}
    write_json({"a": 2}, tmp_path / "x.json")
    assert json.loads((tmp_path / "x.json").read_text()) == {"a": 2}
