"""Shared by all tests: profiles of hypothesis, a check that sources are tested, a browser, their order."""

import gc
import os
import shutil
import signal
from collections.abc import Iterator
from contextlib import closing
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

from deploy.processes.router import listening
from deploy.software import check_compiled
from protocol.bus.connection import Connection
from protocol.errors import UsageError
from protocol.process.signals import STOP
from tests.forks import Forks

if TYPE_CHECKING:
    from playwright.sync_api import Browser

# A busy machine is no counterexample; in continuous integration the same examples are tried every time.
settings.register_profile(
    "disknav", deadline=None, max_examples=30, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("ci", settings.get_profile("disknav"), derandomize=True)
settings.register_profile("campaign", settings.get_profile("disknav"), max_examples=1000)
settings.load_profile("ci" if os.environ.get("CI") else "disknav")

os.environ["MUJOCO_GL"] = "disable"  # nothing is drawn, and looking for libraries that draw takes a while


gc.disable()  # until all tests are imported, which leaves little garbage


def pytest_configure() -> None:
    try:
        check_compiled()
    except UsageError as error:
        pytest.exit(str(error), returncode=2)
    # A shell that puts the tests in the background has them, and all that they start, ignore Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish() -> None:
    gc.enable()


@pytest.fixture(scope="session")
def disknav() -> Iterator[Forks]:
    """The command, for tests that run it to its end."""
    with closing(Forks()) as forks:
        yield forks


@pytest.fixture
def endpoint() -> Iterator[str]:
    """Where a router in this process listens."""
    bus, where = listening(Connection("router"))
    with closing(bus):
        yield where


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C ends a router that runs in this process."""
    with STOP.listening():
        yield


@pytest.fixture(scope="module")  # while it is there, asyncio's loop runs in this thread
def browser() -> Iterator["Browser"]:
    """Chromium, headless, driven by Playwright; what needs it is skipped where either is missing."""
    names = ("chromium", "chromium-browser", "google-chrome")
    chromium = next((path for path in map(shutil.which, names) if path), None)
    if chromium is None:
        pytest.skip("Chromium is missing: apt-get install chromium (Debian), or put `chromium` on the PATH")
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright is missing: pip install playwright"
    )
    flags = ["no-sandbox", "disable-gpu", "disable-quic", "no-first-run", "disable-background-networking"]
    flags += ["disable-component-update", "disable-sync"]
    with playwright.sync_playwright() as driver:
        found = driver.chromium.launch(
            executable_path=chromium, headless=True, args=[f"--{flag}" for flag in flags], timeout=90_000
        )
        yield found
        found.close()


@pytest.hookimpl(trylast=True)  # after those that were not asked for have gone
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Every process of pytest-xdist begins with its share of the tests marked `long`: none of them is left
    to the end, when the others have nothing more to do."""
    processes = getattr(config, "workerinput", {}).get("workercount", 1)
    long = sorted(filter(_seconds, items), key=_seconds, reverse=True)
    others = [item for item in items if not _seconds(item)]
    total = len(items)
    items.clear()
    for process in range(processes):
        share = long[process::processes]
        size = (total - len(items)) // (processes - process)  # as `--dist worksteal` deals them out
        fill = others[: max(0, size - len(share))]
        del others[: len(fill)]
        items += share + fill


def _seconds(item: pytest.Item) -> float:
    """About how long a test takes that is marked `long`; 0 for the others."""
    mark = item.get_closest_marker("long")
    return 0.0 if mark is None else float(mark.args[0])
