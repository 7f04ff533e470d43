"""The live page in a real browser: Debian's Chromium, headless, driven by Playwright."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import pytest

from deploy.run.local import LocalFleet
from deploy.telemetry.monitor.watcher import Watcher
from deploy.telemetry.monitor.web.server import Server
from protocol.requests.steering import Steer
from protocol.scenario.model import Order, RobotSpec, Scenario
from tests.deploy.telemetry.monitor.watched import ring, running, served, watch_local

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
PATIENCE = 30.0  # s
MARGIN = 10  # px around the workspace
DESKTOP, PHONE = {"width": 1280, "height": 860}, {"width": 390, "height": 844}


@dataclass
class Shown:
    """A page that shows a fleet, and what it complained about or asked for elsewhere."""

    page: playwright.Page
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
        """Until the page has been told so often how things stand; they come at a fixed rate, held or not."""
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
        it = Shown(context.new_page(), fleet, watcher, server)
        it.on_message()
        it.page.goto(server.link)
        it.page.wait_for_selector("#verdict:has-text('Looking')")  # nothing can be missed from here on
        with running(fleet):
            it.page.wait_for_selector("#robots tr", state="attached")
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


def test_who_comes_and_who_leaves_changes_the_table_and_no_colour(browser: playwright.Browser) -> None:
    guest = RobotSpec(2, 0.02, (0.17, 0.17), (0.18, 0.16))
    specs = tuple(replace(spec, id=10 * spec.id) for spec in ring().robots)
    orders = (Order(0.4, add=guest), Order(1.0, remove=20))
    with shown(browser, replace(ring(), robots=specs, orders=orders), speed=0.5) as it:
        rows = it.page.locator("tr[data-robot]")

        def hues() -> dict[str, str]:
            return dict(rows.evaluate_all("all => all.map(it => [it.dataset.robot, it.style.cssText])"))

        it.page.wait_for_selector("tr[data-robot='2']")
        it.page.locator("tr[data-robot='30']").click()
        before = hues()
        it.page.wait_for_selector("tr[data-robot='20']", state="detached")
        after = hues()
        assert [*after] == ["2", "10", "30", "40"]
        assert after.items() <= before.items()
        it.page.wait_for_selector("tr[data-robot='30'][data-selected]")


@pytest.mark.alone
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
        it.wait_for_frames(4)  # the tick under way is finished, and shown
        held = it.watcher.snapshot()["tick"]
        it.wait_for_frames(8)
        assert it.watcher.snapshot()["tick"] == held
        it.page.get_by_role("button", name="Step").click()
        it.wait_for_tick(held + 1)
        it.wait_for_frames(6)
        assert it.watcher.snapshot()["tick"] == held + 1
        it.page.locator("h1").click()
        it.page.keyboard.press("Space")
        it.wait_for_tick(held + 4)


def test_the_layers_of_the_picture_can_be_chosen(browser: playwright.Browser) -> None:
    with shown(browser, ring(12), speed=0.4) as it:  # close enough to each other for lines
        it.wait_for_tick(12)
        it.page.get_by_role("button", name="Pause").click()
        it.page.wait_for_selector("#verdict:has-text('Paused')")
        it.wait_until(lambda: it.picture() == (it.wait_for_frames(4), it.picture())[1])
        for layer in ("Trails", "Goals", "Velocity", "Separating lines"):
            before = it.picture()
            it.page.get_by_role("checkbox", name=layer).click()
            it.wait_until(lambda before=before: it.picture() != before)


def test_a_click_sends_the_selected_robot_and_who_comes_late_sees_where(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), speed=0.6) as it:
        it.wait_for_tick(2)
        it.hold()
        it.page.mouse.move(*it.place(3))
        tip = it.page.locator("#tip")
        assert tip.inner_text().startswith("Robot 3: under way\nto goal ")
        assert it.page.locator("tr[data-robot='3'][data-pointed]").count() == 1
        it.page.mouse.click(*it.place(3))
        assert it.page.get_by_role("button", name="Robot 3").get_attribute("aria-pressed") == "true"
        before = it.picture()
        it.page.mouse.click(*it.spot(0.05, 0.1))
        it.page.wait_for_selector("#answer[data-tone]:has-text('Robot 3 goes to (0.0')")
        assert it.goal(3) == pytest.approx([0.05, 0.1], abs=0.002)
        it.wait_until(lambda: it.picture() != before)  # its goal is drawn elsewhere
        late = it.page.context.new_page()
        late.goto(it.server.link)
        late.locator("tr[data-robot='3']").click()
        late.wait_for_selector("#value-goal:has-text('(0.0')")
        assert late.input_value("#goal-x") == it.page.input_value("#goal-x")
        it.page.mouse.click(*it.spot(-0.05, 0.1), button="left")
        it.page.keyboard.down("Shift")
        it.page.mouse.click(*it.spot(0.0, -0.1))
        it.page.keyboard.up("Shift")
        it.page.wait_for_selector("#value-goal:has-text('then 1 more')")
        radius = it.radius
        it.page.mouse.click(*it.spot(0.0, 0.98 * radius))
        it.page.wait_for_selector("#answer[data-tone='bad']:has-text('out of the workspace')")
        it.page.mouse.click(*it.spot(0.95 * radius, 0.95 * radius))  # a corner, where nobody can go
        it.page.wait_for_selector("text=No robot selected")
        it.page.mouse.click(*it.spot(0.1, 0.0))  # nobody is selected
        assert it.goal(3) == pytest.approx([-0.05, 0.1], abs=0.002)


def test_who_has_no_token_can_select_but_not_send(browser: playwright.Browser) -> None:
    with shown(browser, ring(4), speed=0.2) as it:
        looking = it.page.context.new_page()
        looking.goto(it.server.address)
        looking.locator("tr[data-robot='2']").click()
        looking.wait_for_selector("#how:has-text('only looks')")
        assert looking.locator("#order").is_hidden()
        goal = it.goal(2)
        looking.mouse.click(*it.spot(0.0, 0.0))
        looking.locator("tr[data-robot='2']").click()
        looking.wait_for_selector("text=No robot selected")
        assert it.goal(2) == goal


def test_all_are_stopped_by_a_key_and_released_by_the_button(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), speed=0.6) as it:
        it.wait_for_tick(3)
        looking = it.page.context.new_page()
        looking.goto(it.server.address)
        looking.wait_for_selector("#verdict:has-text('Running')")
        assert looking.locator("#halt").is_hidden()
        looking.keyboard.press("s")  # who only looks stops nobody
        it.page.locator("#speed").focus()
        assert it.phase() == "running"
        it.page.keyboard.press("s")
        it.page.wait_for_selector("#verdict:has-text('Emergency stop')")
        looking.wait_for_selector("#verdict:has-text('Emergency stop')")
        stood = it.fleet.world.world.truth.positions
        it.wait_for_tick(it.watcher.snapshot()["tick"] + 5)
        assert it.fleet.world.world.truth.positions == stood
        it.page.keyboard.press("s")  # it only stops
        it.wait_for_tick(it.watcher.snapshot()["tick"] + 2)
        assert it.phase() == "halted"
        it.page.get_by_role("button", name="Release all").click()
        it.page.wait_for_selector("#verdict:has-text('Running')")
        it.page.get_by_label("Speed").select_option("unlimited")
        it.page.wait_for_selector("#verdict:has-text('Arrived')")
        assert it.page.locator("#halt").is_disabled()


def test_of_many_robots_alarms_and_the_selected_one_are_shown(browser: playwright.Browser) -> None:
    with shown(browser, ring(26, kill=7, at=0.1), speed=0.5) as it:
        shown_rows = it.page.locator("#robots tr:visible")
        it.page.wait_for_selector("#alarms:has-text('robot 7')", state="attached")
        assert shown_rows.count() == 1
        assert "26 robots:" in it.page.inner_text("#count")
        it.page.get_by_label("Find robot").fill("19")
        it.wait_until(lambda: shown_rows.count() == 2)
        assert it.page.inner_text("#selected-heading") == "Robot 19"
        fold = it.page.get_by_role("button", name="Show all 26")
        assert fold.get_attribute("aria-expanded") == "false"
        fold.click()
        it.wait_until(lambda: shown_rows.count() == 26)
        it.page.get_by_role("button", name="Show alarms and selection only").click()
        it.wait_until(lambda: shown_rows.count() == 2)
        assert it.overflow() <= 0


def test_everything_can_be_done_with_the_keyboard(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), speed=0.2) as it:
        page, focused = (
            it.page,
            "document.activeElement.getAttribute('aria-label') ?? document.activeElement.id",
        )
        it.wait_for_tick(1)
        it.page.wait_for_selector("#pause:enabled")
        order = []
        page.locator("#theme").focus()
        while not order or order[-1] != "Robot 1":
            page.keyboard.press("Tab")
            order.append(page.evaluate(focused))
            assert len(order) < 12
        toggles = ["show-trails", "show-goals", "show-velocity", "show-lines"]
        assert order == [*toggles, "pause", "step", "speed", "Robot 1"]
        page.keyboard.press("ArrowDown")
        page.keyboard.press("ArrowDown")
        page.keyboard.press("Enter")
        page.wait_for_selector("#selected-heading:has-text('Robot 3')")
        page.locator("#deselect").focus()
        page.keyboard.press("Tab")
        page.keyboard.type("0.1")
        page.keyboard.press("Tab")
        page.keyboard.type("-0.02")
        page.keyboard.press("Enter")
        page.wait_for_selector("#answer:has-text('Robot 3 goes to (0.100, -0.020) m')")
        page.keyboard.press("Escape")
        page.wait_for_selector("text=No robot selected")


def test_a_tap_selects_and_a_tap_sends(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), speed=0.3, viewport=PHONE, has_touch=True, is_mobile=True) as it:
        it.wait_for_tick(2)
        it.hold()
        it.page.touchscreen.tap(*it.place(4))
        it.page.wait_for_selector("#selected-heading:has-text('Robot 4')")
        it.page.touchscreen.tap(*it.spot(0.0, 0.12))
        it.page.wait_for_selector("#answer:has-text('Robot 4 goes to')")
        assert it.goal(4) == pytest.approx([0.0, 0.12], abs=0.003)
        assert it.overflow() <= 0
        small = "[...document.querySelectorAll('button:not([hidden])')].filter(it => it.offsetParent)"
        heights = it.page.evaluate(small + ".map(it => it.closest('tr, .head') ? 44 : it.offsetHeight)")
        assert min(heights) >= 44  # px, a finger


def test_a_plot_tells_the_value_under_the_pointer(browser: playwright.Browser) -> None:
    with shown(browser, ring(6), speed=1.0) as it:
        it.wait_for_tick(10)
        it.page.locator("#clearance").hover(position={"x": 60, "y": 40})
        it.page.wait_for_selector("#clearance-now:has-text(' at ')")
        it.page.mouse.move(5, 5)
        it.page.wait_for_selector("#clearance-now:not(:has-text(' at '))")


PLACES = """async () => {
  const { Model } = await import('/model.js');
  const model = new Model();
  const robot = { id: 1, radius: 0.1, start: [0, 0], goal: [1, 1], trail: [] };
  model.begin({ scenario: 's', run: 'r', room: {}, things: {}, robots: [robot], history: [], tick: -1 });
  const frame = (tick, place) => ({ robots: [{ goal: [1, 1] }], samples: [[tick, tick, 1, 1, [place]]] });
  model.take(frame(1, [0.2, 0.4]), 1000);
  model.take(frame(2, [0.4, 0.2]), 1100);
  return [-1e9, 0, 1099, 1100, 1150, 1200, 1e9].map((now) => model.place(model.robots[0], now));
}"""


def test_nothing_is_drawn_outside_what_was_received(browser: playwright.Browser) -> None:
    with shown(browser, ring(2), speed=0.2) as it:
        places = it.page.evaluate(PLACES)
        assert all(0.2 <= x <= 0.4 and x + y == pytest.approx(0.6) for x, y in places)
        assert (places[0], places[-1]) == ([0.2, 0.4], [0.4, 0.2])
        assert places[4] == pytest.approx([0.3, 0.3])


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
            "button": ("Pause", "Step", "Stop all", "Theme", "Robot 6"),
            "alert": ("",),
            "checkbox": ("Trails", "Goals", "Velocity", "Separating lines"),
            "combobox": ("Speed",),
            "img": ("Workspace", "Clearance", "Navigation function"),
            "columnheader": ("Robot", "Status", "To goal", "Age", "Rate", "Error", "Rejected", "Restarts"),
            "rowheader": ("1", "6"),
        }.items():
            for name in names:
                assert it.page.get_by_role(role, name=name).count() == 1, (role, name)
        assert it.page.get_by_role("status").inner_text() == "Running"
