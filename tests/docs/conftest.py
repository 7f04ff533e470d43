"""The browser of the tests of pages."""

from tests.deploy.telemetry.monitor.web.conftest import browser  # noqa: F401
