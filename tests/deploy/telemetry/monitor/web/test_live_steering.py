"""What can be done to a fleet from the live page, and by whom."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.deploy.telemetry.monitor.watched import ring
from tests.deploy.telemetry.monitor.web.live_page import shown

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.browser


def test_pause_stops_the_ticks_and_step_makes_one(browser: Browser) -> None:
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


def test_a_click_sends_the_selected_robot_and_who_comes_late_sees_where(browser: Browser) -> None:
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


def test_who_has_no_token_can_select_but_not_send(browser: Browser) -> None:
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


def test_all_are_stopped_by_a_key_and_released_by_the_button(browser: Browser) -> None:
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
