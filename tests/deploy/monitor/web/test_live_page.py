"""The live page in a real browser: Debian's Chromium, headless, driven by Playwright."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest

from deploy.monitor.watcher import Watcher, watch_local
from deploy.run.local import LocalFleet
from protocol.scenario.model import Scenario
from tests.deploy.monitor.watched import ring, running, served

playwright = pytest.importorskip(
    "playwright.sync_api", reason="playwright is missing: pip install playwright"
)

NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for path in map(shutil.which, NAMES) if path), None)
INSTALL = "Chromium is missing: apt-get install chromium (Debian), or put `chromium` on the PATH"
pytestmark = [pytest.mark.browser, pytest.mark.skipif(CHROMIUM is None, reason=INSTALL)]

FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
PATIENCE = 10.0  # s
DESKTOP, PHONE = {"width": 1280, "height": 860}, {"width": 390, "height": 844}


@dataclass
class Shown:
    """A page that shows a fleet, and what it complained about or asked for elsewhere."""

    page: playwright.Page
    fleet: LocalFleet
    watcher: Watcher
    complaints: list[str] = field(default_factory=list)

    def tick(self) -> int:
        return int(self.page.inner_text("#tick"))

    def wait_for_tick(self, tick: int) -> None:
        self.wait_until(lambda: self.tick() >= tick)

    def wait_until(self, condition: Callable[[], object], patience: float = PATIENCE) -> None:
        deadline = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < deadline, "waited in vain"
            self.page.wait_for_timeout(10)

    def distances(self) -> list[float]:
        return [float(text) for text in self.page.locator("td.distance").all_inner_texts()]

    def picture(self) -> str:
        return str(self.page.evaluate("document.querySelector('#workspace').toDataURL()"))

    def overflow(self) -> int:
        return int(self.page.evaluate("document.documentElement.scrollWidth - window.innerWidth"))

    def on_message(self) -> None:
        page = self.page
        page.on("console", lambda it: it.type == "error" and self.complaints.append(it.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", lambda it: "//127.0.0.1:" in it.url or self.complaints.append(f"asks {it.url}"))
        page.on("requestfailed", lambda it: self.complaints.append(f"failed {it.url}"))


@pytest.fixture(scope="module")
def browser() -> Iterator[playwright.Browser]:
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, headless=True, args=FLAGS, timeout=90_000)
        yield browser
        browser.close()


@contextmanager
def shown(
    browser: playwright.Browser, scenario: Scenario, speed: float = 1.0, **options: object
) -> Iterator[Shown]:
    """The page of a fleet that begins to run; it must not complain about anything."""
    fleet = LocalFleet([scenario], "page")
    watcher = watch_local(fleet.network, "page", speed=speed)
    context = browser.new_context(**{"viewport": DESKTOP, **options})
    context.set_default_timeout(1000 * PATIENCE)
    with served(watcher) as server:
        it = Shown(context.new_page(), fleet, watcher)
        it.on_message()
        it.page.goto(server.link)
        it.page.wait_for_selector("#verdict:has-text('Looking')")  # nothing can be missed from here on
        with running(fleet):
            it.page.wait_for_selector("#robots tr")
            yield it
        assert it.complaints == []
        context.close()


def test_six_robots_move_and_arrive(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), speed=0.6) as it:
        assert it.page.get_by_role("row").count() == 7
        it.wait_for_tick(5)
        distances, picture = it.distances(), it.picture()
        it.wait_for_tick(it.watcher.snapshot()["tick"] + 15)
        assert all(later < earlier for earlier, later in zip(distances, it.distances(), strict=True))
        assert it.picture() != picture
        assert it.page.title() == "ring · disknav"
        it.page.get_by_label("Speed").select_option("unlimited")
        it.page.wait_for_selector("#verdict:has-text('Arrived')")
        assert it.page.locator("td.status").all_inner_texts() == ["at goal"] * 6
        assert it.page.get_by_role("button", name="Pause").is_disabled()


def test_a_killed_robot_turns_red_within_two_seconds(browser: playwright.Browser) -> None:
    with shown(browser, ring(6, kill=3, at=2.5)) as it:
        robot = it.page.locator("tr[data-robot='3']")
        red = reds(it)
        assert robot.get_attribute("data-alarm") is None
        it.wait_until(lambda: it.fleet.robots[3].node is None)
        killed = time.monotonic()
        it.page.wait_for_selector("tr[data-robot='3'][data-alarm]", timeout=2000)
        it.wait_until(lambda: reds(it) > red + 100, 2.0)
        assert time.monotonic() < killed + 2.0
        assert robot.locator(".status").inner_text() in ("dead", "fenced")
        assert robot.locator(".status").evaluate("it => getComputedStyle(it).color") == "rgb(197, 22, 29)"
        assert "✕" in robot.locator(".status").evaluate("it => getComputedStyle(it, '::before').content")
        assert it.page.locator("tr[data-alarm]").count() == 1


REDS = """(() => {
  const canvas = document.querySelector('#workspace');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i] > 180 && data[i + 1] < 60 && data[i + 2] < 60;
  return count;
})()"""


def reds(it: Shown) -> int:
    """Pixels of the picture in the colour of alarms."""
    return int(it.page.evaluate(REDS))


def test_pause_stops_the_ticks_and_step_makes_one(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), speed=0.5) as it:
        it.wait_for_tick(3)
        it.page.get_by_role("button", name="Pause").click()
        it.page.wait_for_selector("#verdict:has-text('Paused')")
        it.page.wait_for_timeout(400)  # the tick under way is finished, and shown
        held = it.watcher.snapshot()["tick"]
        it.page.wait_for_timeout(400)
        assert it.watcher.snapshot()["tick"] == held
        it.page.get_by_role("button", name="Step").click()
        it.wait_for_tick(held + 1)
        it.page.wait_for_timeout(300)
        assert it.watcher.snapshot()["tick"] == held + 1
        it.page.locator("h1").click()
        it.page.keyboard.press("Space")
        it.wait_for_tick(held + 4)


def test_the_layers_of_the_picture_can_be_chosen(browser: playwright.Browser) -> None:
    with shown(browser, ring(12), speed=0.4) as it:  # close enough to each other for lines
        it.wait_for_tick(12)
        it.page.get_by_role("button", name="Pause").click()
        it.page.wait_for_selector("#verdict:has-text('Paused')")
        it.wait_until(lambda: it.picture() == (it.page.wait_for_timeout(200), it.picture())[1])
        for layer in ("Trails", "Goals", "Velocity", "Separating lines"):
            before = it.picture()
            it.page.get_by_role("checkbox", name=layer).click()
            it.wait_until(lambda before=before: it.picture() != before)


@pytest.mark.parametrize("viewport", [PHONE, {"width": 320, "height": 640}, DESKTOP])
def test_nothing_is_wider_than_the_screen(browser: playwright.Browser, viewport: dict[str, int]) -> None:
    with shown(browser, ring(6, kill=3, at=0.2), viewport=viewport) as it:
        it.page.wait_for_selector("tr[data-alarm]")
        assert it.overflow() <= 0
        assert it.page.locator("#workspace").bounding_box()["width"] >= 0.4 * viewport["width"]


def test_light_and_dark_follow_the_system_until_chosen(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), color_scheme="dark") as it:
        background = "getComputedStyle(document.body).backgroundColor"
        dark = it.page.evaluate(background)
        it.page.emulate_media(color_scheme="light")
        it.wait_until(lambda: it.page.evaluate(background) != dark)
        button = it.page.get_by_role("button", name="Theme")
        while "dark" not in button.inner_text():
            button.click()
        assert it.page.evaluate(background) == dark
        it.page.reload()
        it.page.wait_for_selector("#robots tr")
        assert it.page.evaluate(background) == dark


def test_everything_has_an_accessible_name(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), speed=0.1) as it:
        it.page.wait_for_selector("#verdict:has-text('Running')")
        for role, names in {
            "button": ("Pause", "Step", "Theme"),
            "checkbox": ("Trails", "Goals", "Velocity", "Separating lines"),
            "combobox": ("Speed",),
            "img": ("Workspace", "Clearance", "Navigation function"),
            "columnheader": ("Robot", "Status", "To goal", "Age", "Rate", "Error", "Rejected", "Restarts"),
            "rowheader": ("1", "6"),
        }.items():
            for name in names:
                assert it.page.get_by_role(role, name=name).count() == 1, (role, name)
        assert it.page.get_by_role("status").inner_text() == "Running"
