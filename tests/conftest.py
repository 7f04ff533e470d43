"""What all tests share: how hypothesis searches, and that what is tested is what the sources say."""

import os

import pytest
from hypothesis import HealthCheck, settings

from deploy.software import compiled
from protocol.errors import UsageError

# A busy machine is no counterexample; in continuous integration the same examples are tried every time.
settings.register_profile("disknav", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("disknav"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "disknav")


def pytest_configure() -> None:
    try:
        compiled.check()
    except UsageError as error:
        pytest.exit(str(error), returncode=2)
