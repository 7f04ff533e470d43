"""The kept trajectories: `trajectories.json`, in whole micrometres, and `hashes.json`."""

import json
from collections.abc import Mapping
from pathlib import Path

from tests.golden.cases import SADDLES
from tests.golden.trajectory import EVERY, Trajectory, rounding

_FOLDER = Path(__file__).parent
_TRAJECTORIES, _HASHES = _FOLDER / "trajectories.json", _FOLDER / "hashes.json"
_UNIT = 1e-6  # m


def read() -> dict[str, Trajectory]:
    """What is kept, by case; without positions where they are not compared."""
    if not _HASHES.exists():
        return {}
    hashes = json.loads(_HASHES.read_text())["sha256"]
    paths = json.loads(_TRAJECTORIES.read_text())["cases"]
    return {case: _trajectory(sha256, **paths[case]) for case, sha256 in hashes.items()}


def rounding_of_hashes() -> str:
    """How the machine rounds on which the hashes were made."""
    return str(json.loads(_HASHES.read_text())["rounding"])


def write(trajectories: Mapping[str, Trajectory]) -> None:
    """Keep these in place of what is kept."""
    hashes = {case: each.sha256 for case, each in trajectories.items()}
    _HASHES.write_text(json.dumps({"rounding": rounding(), "sha256": hashes}, indent=1) + "\n")
    cases = ",\n".join(f"{json.dumps(case)}: {_text(case, each)}" for case, each in trajectories.items())
    head = f'"every": {EVERY}, "unit": {_UNIT}'
    _TRAJECTORIES.write_text(f'{{{head}, "cases": {{\n{cases}\n}}}}\n')


def _trajectory(sha256: str, ticks: int, positions: list[list[list[int]]]) -> Trajectory:
    rows = tuple(tuple((x * _UNIT, y * _UNIT) for x, y in row) for row in positions)
    return Trajectory(sha256, ticks, rows)


def _text(case: str, trajectory: Trajectory) -> str:
    """A line for each configuration, so that a difference shows where it begins."""
    rows = () if case in SADDLES else trajectory.positions
    lines = [json.dumps([[round(x / _UNIT), round(y / _UNIT)] for x, y in row]) for row in rows]
    positions = ",".join(f"\n {line.replace(' ', '')}" for line in lines)
    return f'{{"ticks": {trajectory.ticks}, "positions": [{positions}]}}'
