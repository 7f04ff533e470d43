"""A recording that several tests look at."""

from pathlib import Path
from typing import Any

import pytest

from deploy.telemetry.recording.reader import Recording, read
from tests.deploy.telemetry.recording.recorded import record


@pytest.fixture(scope="package")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    path = tmp_path_factory.mktemp("recording") / "three.mcap"
    return path, record(path)


@pytest.fixture(scope="package")
def recording(recorded: tuple[Path, dict[str, Any]]) -> Recording:
    return read(recorded[0])
