"""The live page in a browser: what it shows of a fleet, its orders, and its permissions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import pytest

from deploy.run.local import LocalFleet
from deploy.telemetry.monitor.watcher import Watcher
from deploy.telemetry.monitor.web import Server
from protocol.operations import Steer
from protocol.scenario.model import Order, RobotSpec, Scenario
from tests.deploy.telemetry.monitor.watched import ring, running, watch_local
from tests.until import PATIENCE, until

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.browser

MARGIN = 10  # px around the workspace
DESKTOP, PHONE = {"width": 1280, "height": 860}, {"width": 390, "height": 844}


SLOW_DISPLAY = "window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 100);"
"""Ten pictures in a second: software that draws sixty takes a processor of its own."""


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

    def wait_until(self, condition: Callable[[], object]) -> None:
        until(lambda: condition() or self.page.wait_for_timeout(100))

    def wait_for_frames(self, count: int) -> None:
        """Until the page has had so many frames; they come at a fixed rate, held or not."""
        enough = self.frames + count
        self.wait_until(lambda: self.frames >= enough)

    def sees(self, selector: str, text: str = "") -> None:
        self.page.wait_for_selector(f"{selector}:has-text('{text}')" if text else selector)

    def other_page(self, address: str) -> Page:
        """A second page of the same browser, which may not steer unless the address has the token."""
        page = self.page.context.new_page()
        page.goto(address)
        return page

    def spot(self, x: float, y: float) -> tuple[float, float]:
        box = self.page.locator("#workspace").bounding_box()
        scale = (min(box["width"], box["height"]) / 2 - MARGIN) / self.radius
        return box["x"] + box["width"] / 2 + scale * x, box["y"] + box["height"] / 2 - scale * y

    @property
    def radius(self) -> float:
        return float(self.watcher.overview()["room"]["radius"])

    def hold(self) -> None:
        self.watcher.steer(Steer(pause=True))
        self.sees("#verdict", "Paused")
        self.wait_until(lambda: self.tick() == self.watcher.snapshot()["tick"])

    def go(self) -> None:
        self.watcher.steer(Steer(pause=False))

    def place(self, robot: int) -> tuple[float, float]:
        return self.spot(*self.watcher.snapshot()["samples"][-1][4][robot - 1])

    def goal(self, robot: int) -> list[float]:
        return [round(part, 3) for part in self.watcher.snapshot()["robots"][robot - 1]["goal"]]

    def picture(self) -> str:
        return str(self.page.evaluate("document.querySelector('#workspace').toDataURL()"))

    def overflow(self) -> int:
        return int(self.page.evaluate("document.documentElement.scrollWidth - window.innerWidth"))

    def background(self) -> str:
        return str(self.page.evaluate("getComputedStyle(document.body).backgroundColor"))

    def listen(self) -> None:
        def count(_: object) -> None:
            self.frames += 1

        page = self.page
        page.on("websocket", lambda it: it.on("framereceived", count))
        page.on("console", lambda it: it.type == "error" and self.complaints.append(it.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", lambda it: "//127.0.0.1:" in it.url or self.complaints.append(f"asks {it.url}"))
        page.on("requestfailed", lambda it: self.complaints.append(f"failed {it.url}"))


@contextmanager
def shown(
    browser: Browser, scenario: Scenario, speed: float = 1.0, *, held: bool = False, **options: object
) -> Iterator[Shown]:
    """The page of a fleet that begins to run, or is held; it must not complain about anything."""
    fleet = LocalFleet(scenario, "page")
    watcher = watch_local(fleet.network, "page")
    watcher.steer(Steer(speed=speed, pause=held))
    context = browser.new_context(**{"viewport": DESKTOP, **options})
    context.set_default_timeout(1000 * PATIENCE)
    context.add_init_script(SLOW_DISPLAY)
    with closing(Server(watcher)) as server:
        it = Shown(context.new_page(), fleet, watcher, server)
        it.listen()
        it.page.goto(server.link)
        it.sees("#verdict", "Looking")  # nothing can be missed from here on
        with running(fleet):
            it.page.wait_for_selector("#robots tr", state="attached")
            yield it
        assert it.complaints == []
        context.close()


ROLES = {
    "button": ("Resume", "Step", "Stop all", "Theme", "Robot 6"),
    "alert": ("",),
    "checkbox": ("Trails", "Goals", "Velocity", "Separating lines"),
    "combobox": ("Speed",),
    "img": ("Workspace", "Clearance", "Potential"),
    "columnheader": ("Robot", "Status", "To goal", "Age", "Rate", "Error", "Rejected", "Restarts"),
    "rowheader": ("1", "6"),
}


def test_six_robots_move_and_arrive(browser: Browser) -> None:
    with shown(browser, ring(6), speed=0.4, held=True) as it:
        assert it.page.get_by_role("row").count() == 7
        it.page.get_by_role("status").get_by_text("Paused").wait_for()
        for role, names in ROLES.items():
            for name in names:
                assert it.page.get_by_role(role, name=name).count() == 1, (role, name)
        it.go()
        it.wait_for_tick(5)

        def distances() -> list[float]:
            return [float(text) for text in it.page.locator("td.distance").all_inner_texts()]

        before, picture = distances(), it.picture()
        it.wait_for_tick(it.watcher.snapshot()["tick"] + 15)
        assert all(later < earlier for earlier, later in zip(before, distances(), strict=True))
        assert it.picture() != picture
        it.page.locator("#clearance").hover(position={"x": 60, "y": 40})
        it.sees("#clearance-now", " at ")  # the value under the pointer
        it.page.mouse.move(5, 5)
        it.page.wait_for_selector("#clearance-now:not(:has-text(' at '))")
        assert it.page.title() == "ring · disknav"
        it.page.get_by_label("Speed").select_option("unlimited")
        it.sees("#verdict", "Arrived")
        it.sees("#smallest", f"{1000.0 * it.fleet.world.world.referee.record.totals.clearance:.2f}")
        assert it.page.locator("td.status").all_inner_texts() == ["at goal"] * 6
        assert it.page.get_by_role("button", name="Pause").is_disabled()


def test_robots_that_come_and_leave_change_the_table_and_no_colour(browser: Browser) -> None:
    guest = RobotSpec(2, 0.02, (0.17, 0.17), (0.18, 0.16))
    specs = tuple(replace(spec, id=10 * spec.id) for spec in ring().robots)
    orders = (Order(0.4, add=guest), Order(1.0, remove=20))
    with shown(browser, replace(ring(), robots=specs, orders=orders), speed=0.5) as it:
        rows = it.page.locator("tr[data-robot]")

        def hues() -> dict[str, str]:
            return dict(rows.evaluate_all("all => all.map(it => [it.dataset.robot, it.style.cssText])"))

        it.sees("tr[data-robot='2']")
        it.page.locator("tr[data-robot='30']").click()
        before = hues()
        it.page.wait_for_selector("tr[data-robot='20']", state="detached")
        after = hues()
        assert [*after] == ["2", "10", "30", "40"]
        assert after.items() <= before.items()
        it.sees("tr[data-robot='30'][data-selected]")


REDS = """(() => {
  const canvas = document.querySelector('#workspace');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i] > 180 && data[i + 1] < 60 && data[i + 2] < 60;
  return count;
})()"""  # pixels of the picture in the colour of alarms


TURNED_RED = f"""(before) => {{
  const row = document.querySelector("tr[data-robot='3'][data-alarm]");
  return row && {REDS} > before + 100 && document.querySelector('#tick').innerText;
}}"""  # the tick that is shown as soon as it has


def test_a_killed_robot_turns_red_within_two_seconds(browser: Browser) -> None:
    """Of the run, which goes on in real time; and nothing is wider than any screen."""
    with shown(browser, ring(6, kill=3, at=1.0), held=True) as it:
        robot = it.page.locator("tr[data-robot='3']")
        red = it.page.evaluate(REDS)
        assert robot.get_attribute("data-alarm") is None
        it.go()
        tick = it.page.wait_for_function(TURNED_RED, arg=red).json_value()
        assert int(tick) <= it.fleet.world.world.scenario.ticks(1.0 + 2.0)
        assert robot.locator(".status").inner_text() in ("dead", "fenced")
        assert robot.locator(".status").evaluate("it => getComputedStyle(it).color") == "rgb(197, 22, 29)"
        assert "✕" in robot.locator(".status").evaluate("it => getComputedStyle(it, '::before').content")
        assert it.page.locator("tr[data-alarm]").count() == 1
        for viewport in (PHONE, {"width": 320, "height": 640}, DESKTOP):
            it.page.set_viewport_size(viewport)
            it.wait_until(lambda: it.overflow() <= 0)
            assert it.page.locator("#workspace").bounding_box()["width"] >= 0.4 * viewport["width"]


def test_of_many_robots_alarms_and_the_selected_one_are_shown(browser: Browser) -> None:
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


PLACES = """async () => {
  const { Model } = await import('/model.js');
  const model = new Model();
  const robot = { id: 1, radius: 0.1, start: [0, 0], goal: [1, 1], trail: [] };
  model.begin({ scenario: 's', run: 'r', room: {}, obstacles: {}, robots: [robot], history: [], tick: -1 });
  const frame = (tick, place) => ({ robots: [{ goal: [1, 1] }], samples: [[tick, tick, 1, 1, [place]]] });
  model.take(frame(1, [0.2, 0.4]), 1000);
  model.take(frame(2, [0.4, 0.2]), 1100);
  return [-1e9, 0, 1099, 1100, 1150, 1200, 1e9].map((now) => model.place(model.robots[0], now));
}"""


def test_pause_stops_the_ticks_and_step_makes_one(browser: Browser) -> None:
    with shown(browser, ring(12), speed=0.15, color_scheme="dark") as it:  # close enough for lines
        it.wait_for_tick(8)
        it.page.get_by_role("button", name="Pause").click()
        it.sees("#verdict", "Paused")
        it.wait_for_frames(4)  # the tick under way is finished, and shown
        held = it.watcher.snapshot()["tick"]
        it.wait_until(lambda: it.picture() == (it.wait_for_frames(4), it.picture())[1])
        assert it.watcher.snapshot()["tick"] == held
        for layer in ROLES["checkbox"]:
            before = it.picture()
            it.page.get_by_role("checkbox", name=layer).click()
            it.wait_until(lambda before=before: it.picture() != before)
        places = it.page.evaluate(PLACES)  # nothing is drawn outside what was received
        assert all(0.2 <= x <= 0.4 and x + y == pytest.approx(0.6) for x, y in places)
        assert (places[0], places[4], places[-1]) == ([0.2, 0.4], pytest.approx([0.3, 0.3]), [0.4, 0.2])
        it.page.get_by_role("button", name="Step").click()
        it.wait_for_tick(held + 1)
        it.wait_for_frames(6)
        assert it.watcher.snapshot()["tick"] == held + 1
        it.page.locator("h1").click()
        it.page.keyboard.press("Space")
        it.page.get_by_label("Speed").select_option("unlimited")
        it.wait_for_tick(held + 4)
        dark = it.background()  # as the system says, until chosen
        it.page.emulate_media(color_scheme="light")
        it.wait_until(lambda: it.background() != dark)
        button = it.page.get_by_role("button", name="Theme")
        while "dark" not in button.inner_text():
            button.click()
        assert it.background() == dark
        it.page.reload()
        it.sees("#robots tr")
        assert it.background() == dark


def test_everything_can_be_done_with_the_keyboard(browser: Browser) -> None:
    with shown(browser, ring(6), speed=0.2) as it:
        page = it.page
        focused = "document.activeElement.getAttribute('aria-label') ?? document.activeElement.id"
        it.wait_for_tick(1)
        it.sees("#pause:enabled")
        order = []
        page.locator("#theme").focus()
        while not order or order[-1] != "Robot 1":
            page.keyboard.press("Tab")
            order.append(page.evaluate(focused))
            assert len(order) < 12
        toggles = ["show-trails", "show-goals", "show-velocity", "show-lines"]
        assert order == [*toggles, "pause", "step", "speed", "Robot 1"]
        for key in ("ArrowDown", "ArrowDown", "Enter"):
            page.keyboard.press(key)
        it.sees("#selected-heading", "Robot 3")
        page.locator("#deselect").focus()
        for text in ("0.1", "-0.02"):
            page.keyboard.press("Tab")
            page.keyboard.type(text)
        page.keyboard.press("Enter")
        it.sees("#answer", "Robot 3 goes to (0.100, -0.020) m")
        page.keyboard.press("Escape")
        it.sees("text=No robot selected")


def test_a_tap_selects_and_a_tap_sends(browser: Browser) -> None:
    with shown(browser, ring(6), speed=0.3, viewport=PHONE, has_touch=True, is_mobile=True) as it:
        it.wait_for_tick(2)
        it.hold()
        it.page.touchscreen.tap(*it.place(4))
        it.sees("#selected-heading", "Robot 4")
        it.page.touchscreen.tap(*it.spot(0.0, 0.12))
        it.sees("#answer", "Robot 4 goes to")
        assert it.goal(4) == pytest.approx([0.0, 0.12], abs=0.003)
        assert it.overflow() <= 0
        small = "[...document.querySelectorAll('button:not([hidden])')].filter(it => it.offsetParent)"
        heights = it.page.evaluate(small + ".map(it => it.closest('tr, .head') ? 44 : it.offsetHeight)")
        assert min(heights) >= 44  # px, a finger


def test_a_click_sends_the_selected_robot_and_a_late_viewer_sees_where(browser: Browser) -> None:
    with shown(browser, ring(6), speed=0.4) as it:
        it.wait_for_tick(2)
        it.hold()
        it.page.mouse.move(*it.place(3))
        assert it.page.locator("#tip").inner_text().startswith("Robot 3: under way\nto goal ")
        assert it.page.locator("tr[data-robot='3'][data-pointed]").count() == 1
        it.page.mouse.click(*it.place(3))
        assert it.page.get_by_role("button", name="Robot 3").get_attribute("aria-pressed") == "true"
        before = it.picture()
        it.page.mouse.click(*it.spot(0.05, 0.1))
        it.sees("#answer[data-tone]", "Robot 3 goes to (0.0")
        assert it.goal(3) == pytest.approx([0.05, 0.1], abs=0.002)
        it.wait_until(lambda: it.picture() != before)  # its goal is drawn elsewhere
        late = it.other_page(it.server.link)
        late.locator("tr[data-robot='3']").click()
        late.wait_for_selector("#value-goal:has-text('(0.0')")
        assert late.input_value("#goal-x") == it.page.input_value("#goal-x")
        it.page.mouse.click(*it.spot(-0.05, 0.1), button="left")
        it.page.keyboard.down("Shift")
        it.page.mouse.click(*it.spot(0.0, -0.1))
        it.page.keyboard.up("Shift")
        it.sees("#value-goal", "then 1 more")
        radius = it.radius
        it.page.mouse.click(*it.spot(0.0, 0.98 * radius))
        it.sees("#answer[data-tone='bad']", "out of the workspace")
        it.page.mouse.click(*it.spot(0.95 * radius, 0.95 * radius))  # a corner, outside of the workspace
        it.sees("text=No robot selected")
        it.page.mouse.click(*it.spot(0.1, 0.0))  # no robot is selected
        assert it.goal(3) == pytest.approx([-0.05, 0.1], abs=0.002)


def test_a_viewer_without_token_may_only_look_and_all_are_stopped_by_a_key(browser: Browser) -> None:
    with shown(browser, ring(6), speed=0.4, held=True) as it:
        looking, goal = it.other_page(it.server.address), it.goal(2)
        looking.locator("tr[data-robot='2']").click()
        looking.wait_for_selector("#how:has-text('may not steer')")
        assert looking.locator("#order").is_hidden()
        looking.mouse.click(*it.spot(0.0, 0.0))
        looking.locator("tr[data-robot='2']").click()
        looking.wait_for_selector("text=No robot selected")
        assert it.goal(2) == goal
        assert looking.locator("#halt").is_hidden()
        looking.keyboard.press("s")
        it.page.locator("#speed").focus()
        it.go()
        it.wait_for_tick(1)
        assert it.watcher.snapshot()["phase"] == "running"
        it.page.keyboard.press("s")
        it.sees("#verdict", "Emergency stop")
        looking.wait_for_selector("#verdict:has-text('Emergency stop')")
        stood = it.fleet.world.world.truth.positions
        it.wait_for_tick(it.watcher.snapshot()["tick"] + 5)
        assert it.fleet.world.world.truth.positions == stood
        it.page.keyboard.press("s")  # it only stops
        it.wait_for_tick(it.watcher.snapshot()["tick"] + 2)
        assert it.watcher.snapshot()["phase"] == "halted"
        it.page.get_by_role("button", name="Release all").click()
        it.sees("#verdict", "Running")
        it.page.get_by_label("Speed").select_option("unlimited")
        it.sees("#verdict", "Arrived")
        assert it.page.locator("#halt").is_disabled()
