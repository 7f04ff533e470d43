"""A live page in a browser, and the fleet that it shows."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from deploy.run.local import LocalFleet
from deploy.telemetry.monitor.watcher import Watcher
from deploy.telemetry.monitor.web import Server
from protocol.operations import Steer
from protocol.scenario.model import Scenario
from tests.deploy.telemetry.monitor.watched import running, served, watch_local

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

PATIENCE = 30.0  # s
MARGIN = 10  # px around the workspace
DESKTOP, PHONE = {"width": 1280, "height": 860}, {"width": 390, "height": 844}


@dataclass
class Shown:
    """A page that shows a fleet, and what it complained about or asked for elsewhere."""

    page: Page
    fleet: LocalFleet
    watcher: Watcher
    server: Server
    complaints: list[str] = field(default_factory=list)
    frames: int = 0

    def tick(self) -> int:
        return int(self.page.inner_text("#tick"))

    def wait_for_tick(self, tick: int) -> None:
        self.wait_until(lambda: self.tick() >= tick)

    def wait_until(self, condition: Callable[[], object], patience: float = PATIENCE) -> None:
        deadline = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < deadline, "waited in vain"
            self.page.wait_for_timeout(40)

    def wait_for_frames(self, count: int) -> None:
        """Until the page has had so many frames; they come at a fixed rate, held or not."""
        enough = self.frames + count
        self.wait_until(lambda: self.frames >= enough)

    def distances(self) -> list[float]:
        return [float(text) for text in self.page.locator("td.distance").all_inner_texts()]

    def spot(self, x: float, y: float) -> tuple[float, float]:
        """Where on the screen a place of the workspace is drawn."""
        box = self.page.locator("#workspace").bounding_box()
        scale = (min(box["width"], box["height"]) / 2 - MARGIN) / self.radius
        return box["x"] + box["width"] / 2 + scale * x, box["y"] + box["height"] / 2 - scale * y

    @property
    def radius(self) -> float:
        return float(self.watcher.overview()["room"]["radius"])

    def hold(self) -> None:
        self.watcher.steer(Steer(pause=True))
        self.page.wait_for_selector("#verdict:has-text('Paused')")
        self.wait_until(lambda: self.tick() == self.watcher.snapshot()["tick"])

    def place(self, robot: int) -> tuple[float, float]:
        """Where on the screen a robot is, in a run that is held."""
        return self.spot(*self.watcher.snapshot()["samples"][-1][4][robot - 1])

    def goal(self, robot: int) -> list[float]:
        return [round(part, 3) for part in self.watcher.snapshot()["robots"][robot - 1]["goal"]]

    def count(self) -> None:
        self.frames += 1

    def phase(self) -> str:
        return str(self.watcher.snapshot()["phase"])

    def picture(self) -> str:
        return str(self.page.evaluate("document.querySelector('#workspace').toDataURL()"))

    def overflow(self) -> int:
        return int(self.page.evaluate("document.documentElement.scrollWidth - window.innerWidth"))

    def on_message(self) -> None:
        page = self.page
        page.on("websocket", lambda it: it.on("framereceived", lambda _: self.count()))
        page.on("console", lambda it: it.type == "error" and self.complaints.append(it.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", lambda it: "//127.0.0.1:" in it.url or self.complaints.append(f"asks {it.url}"))
        page.on("requestfailed", lambda it: self.complaints.append(f"failed {it.url}"))


@contextmanager
def shown(browser: Browser, scenario: Scenario, speed: float = 1.0, **options: object) -> Iterator[Shown]:
    """The page of a fleet that begins to run; it must not complain about anything."""
    fleet = LocalFleet(scenario, "page")
    watcher = watch_local(fleet.network, "page", speed=speed)
    context = browser.new_context(**{"viewport": DESKTOP, **options})
    context.set_default_timeout(1000 * PATIENCE)
    with served(watcher) as server:
        it = Shown(context.new_page(), fleet, watcher, server)
        it.on_message()
        it.page.goto(server.link)
        it.page.wait_for_selector("#verdict:has-text('Looking')")  # nothing can be missed from here on
        with running(fleet):
            it.page.wait_for_selector("#robots tr", state="attached")
            yield it
        assert it.complaints == []
        context.close()
