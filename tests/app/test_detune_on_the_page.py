"""What moves a resonance away, as the page offers it: buttons that show what they give before they are pressed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from tests.app.cockpit_driver import Cockpit, Tab, still

from epicyclic.cockpit.state.state import PageState
from epicyclic.document.document import drive_text

pytestmark = pytest.mark.browser

CHANGE = "[data-answer=resonance] .ck-change:visible"
# ren2021 at a speed where the first mesh order meets a mode and the teeth part
MODEL = PageState(name="fast.toml", base=drive_text("ren2021").replace('"100 rpm"', '"580 rpm"'))
SWEEP = "document.querySelector('[data-kind=sweep]')"


@pytest.fixture
def tab(browser: Any, cockpit: Cockpit) -> Iterator[Tab]:
    context = still(browser)
    opened = Tab(context, cockpit.address)
    yield opened
    assert opened.errors() == []
    context.close()


def test_a_change_previews_and_a_click_is_one_step(tab: Tab) -> None:
    first = tab.page.locator(CHANGE).first
    first.wait_for()
    # the words of the terminal, and where the resonance is then
    assert first.inner_text() == "radial planet bearing x 1.5: 696.5 rpm, +20 %, 5.9 % left"
    assert "5.9 % of the mean force" in first.get_attribute("title")
    undo, rev = tab.page.get_by_role("button", name=re.compile("^Undo")), tab.rev
    assert undo.first.is_disabled()

    curve = tab.page.locator("[data-kind=sweep]").first
    before = curve.screenshot()
    first.hover()
    tab.page.wait_for_function(f"{SWEEP}.dataset.preview.startsWith('radial planet bearing')")
    tab.page.wait_for_function("window.cockpit.previewed?.sweep")  # its curves, computed for it
    tab.page.wait_for_timeout(100)
    assert curve.screenshot() != before
    assert tab.rev == rev  # nothing of the state moves
    assert undo.first.is_disabled()

    tab.page.mouse.move(5, 5)
    tab.page.wait_for_function(f"{SWEEP}.dataset.preview === ''")
    first.focus()  # the keyboard shows it as well
    tab.page.wait_for_function(f"{SWEEP}.dataset.preview !== ''")

    first.click()
    tab.painted(rev)
    answer = tab.page.locator("[data-answer=resonance]")
    answer.filter(has_text="5.9 % of the mean force").wait_for()
    assert "mode 5 " not in answer.locator(".ck-answer-text").inner_text()
    tab.page.wait_for_function(f"{SWEEP}.dataset.preview === ''")
    undo.first.click()
    answer.filter(has_text=re.compile("mode 5 .*118 %")).wait_for()
    assert undo.first.is_disabled()
    tab.page.locator(CHANGE).first.wait_for()  # the way back is offered again


def test_where_a_resonance_is_no_matter_nothing_is_offered(tab: Tab) -> None:
    tab.page.locator(CHANGE).first.wait_for()
    box = tab.page.locator("[data-lever='operation.speed.sun'] input.ck-box-number")
    box.fill("100")
    box.press("Enter")
    tab.page.locator("[data-answer=resonance]").filter(has_text="no matter").wait_for()
    tab.page.wait_for_function("!document.querySelector('.ck-page').dataset.busy")
    assert tab.page.locator(CHANGE).count() == 0
