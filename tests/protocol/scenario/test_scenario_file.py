"""Scenario files: what cannot be read, forms that mean the same, and the schema for editors."""

from __future__ import annotations

from typing import Any

import pytest

from protocol.errors import ScenarioError
from protocol.scenario.file import json_schema, parse_toml, read_scenario
from protocol.scenario.model import Sensing
from tests.protocol.scenario.scenario_texts import ROBOTS, problems


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = \n", "line 1"),
        ("x = 1\nx = 2\ny = 3", "line 2"),
        ("[a]\nb = [1, 2\n", "not TOML"),
        ("a = " + "[" * 100_000, "not TOML"),
        ("a = " + "9" * 5000, "not TOML"),
    ],
)
def test_what_is_not_toml(text: str, words: str) -> None:
    assert words in problems(text)[""]


def test_files_that_cannot_be_read(tmp_path: Any) -> None:
    with pytest.raises(ScenarioError, match="No such file"):
        read_scenario(tmp_path / "none.toml")
    with pytest.raises(ScenarioError, match="cannot be read"):
        read_scenario(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ScenarioError, match="not UTF-8"):
        read_scenario(binary)
    good = tmp_path / "good.toml"
    good.write_bytes(b"\xef\xbb\xbf" + ROBOTS.replace("\n", "\r\n").encode())
    assert read_scenario(good).ids == (1, 2)


def test_sensing_as_one_table_and_as_an_array() -> None:
    one = parse_toml("[sensing]\nnoise = 0.1" + ROBOTS)
    assert one.sensing == parse_toml("[[sensing]]\nnoise = 0.1" + ROBOTS).sensing == (Sensing(noise=0.1),)
    assert parse_toml(ROBOTS).sensing == (Sensing(),)


def test_schema_knows_every_table_and_both_forms_of_sensing() -> None:
    schema = json_schema()
    assert schema["required"] == ["robots"]
    assert {"from", "until", "groups"} == schema["$defs"]["Partition"]["properties"].keys()
    assert len(schema["properties"]["sensing"]["anyOf"]) == 2
