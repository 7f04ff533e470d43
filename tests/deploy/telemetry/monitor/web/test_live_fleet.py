"""What the live page shows of a fleet."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from protocol.scenario.model import Order, RobotSpec
from tests.deploy.telemetry.monitor.watched import ring
from tests.deploy.telemetry.monitor.web.live_page import Shown, shown

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.browser


def test_six_robots_move_and_arrive(browser: Browser) -> None:
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


def test_who_comes_and_who_leaves_changes_the_table_and_no_colour(browser: Browser) -> None:
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
def test_a_killed_robot_turns_red_within_two_seconds(browser: Browser) -> None:
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


@pytest.mark.campaign
def test_the_layers_of_the_picture_can_be_chosen(browser: Browser) -> None:
    with shown(browser, ring(12), speed=0.4) as it:  # close enough to each other for lines
        it.wait_for_tick(12)
        it.page.get_by_role("button", name="Pause").click()
        it.page.wait_for_selector("#verdict:has-text('Paused')")
        it.wait_until(lambda: it.picture() == (it.wait_for_frames(4), it.picture())[1])
        for layer in ("Trails", "Goals", "Velocity", "Separating lines"):
            before = it.picture()
            it.page.get_by_role("checkbox", name=layer).click()
            it.wait_until(lambda before=before: it.picture() != before)


def test_a_plot_tells_the_value_under_the_pointer(browser: Browser) -> None:
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
  model.begin({ scenario: 's', run: 'r', room: {}, obstacles: {}, robots: [robot], history: [], tick: -1 });
  const frame = (tick, place) => ({ robots: [{ goal: [1, 1] }], samples: [[tick, tick, 1, 1, [place]]] });
  model.take(frame(1, [0.2, 0.4]), 1000);
  model.take(frame(2, [0.4, 0.2]), 1100);
  return [-1e9, 0, 1099, 1100, 1150, 1200, 1e9].map((now) => model.place(model.robots[0], now));
}"""


def test_nothing_is_drawn_outside_what_was_received(browser: Browser) -> None:
    with shown(browser, ring(2), speed=0.2) as it:
        places = it.page.evaluate(PLACES)
        assert all(0.2 <= x <= 0.4 and x + y == pytest.approx(0.6) for x, y in places)
        assert (places[0], places[-1]) == ([0.2, 0.4], [0.4, 0.2])
        assert places[4] == pytest.approx([0.3, 0.3])
