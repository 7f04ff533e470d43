"""Keys of a module's run."""

from pathlib import Path

import pytest

from deploy.security.keystore import create


@pytest.fixture(scope="module")
def keys(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of all roles in the module's ROSTER."""
    directory = tmp_path_factory.mktemp("security") / "keys"
    create(directory, request.module.ROSTER)
    return directory
