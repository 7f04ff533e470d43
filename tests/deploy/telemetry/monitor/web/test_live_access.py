"""The live page by keyboard, by finger, on any screen, in light and dark, and to those who do not see it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.deploy.telemetry.monitor.watched import ring
from tests.deploy.telemetry.monitor.web.live_page import DESKTOP, PHONE, shown

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.browser


def test_everything_can_be_done_with_the_keyboard(browser: Browser) -> None:
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


def test_a_tap_selects_and_a_tap_sends(browser: Browser) -> None:
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


def test_nothing_is_wider_than_the_screen(browser: Browser) -> None:
    with shown(browser, ring(6, kill=3, at=0.2)) as it:
        it.page.wait_for_selector("tr[data-alarm]")
        for viewport in (PHONE, {"width": 320, "height": 640}, DESKTOP):
            it.page.set_viewport_size(viewport)
            it.wait_until(lambda: it.overflow() <= 0)
            assert it.page.locator("#workspace").bounding_box()["width"] >= 0.4 * viewport["width"]


@pytest.mark.campaign
def test_light_and_dark_follow_the_system_until_chosen(browser: Browser) -> None:
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


def test_everything_has_an_accessible_name(browser: Browser) -> None:
    with shown(browser, ring(6), speed=0.1) as it:
        it.page.wait_for_selector("#verdict:has-text('Running')")
        for role, names in {
            "button": ("Pause", "Step", "Stop all", "Theme", "Robot 6"),
            "alert": ("",),
            "checkbox": ("Trails", "Goals", "Velocity", "Separating lines"),
            "combobox": ("Speed",),
            "img": ("Workspace", "Clearance", "Potential"),
            "columnheader": ("Robot", "Status", "To goal", "Age", "Rate", "Error", "Rejected", "Restarts"),
            "rowheader": ("1", "6"),
        }.items():
            for name in names:
                assert it.page.get_by_role(role, name=name).count() == 1, (role, name)
        assert it.page.get_by_role("status").inner_text() == "Running"
