"""What the tolerances say on the page: bands and ties, one limit that can be set, advice where it pays alone."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from tests.app.cockpit_driver import PATIENCE, Cockpit, Tab, still

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def tab(browser: Any, cockpit: Cockpit) -> Iterator[Tab]:
    """One tab of all tests of the file, in their order."""
    context = still(browser)
    opened = Tab(context, cockpit.address)
    opened.page.locator("[data-answer]").nth(4).wait_for()
    yield opened
    assert opened.errors() == []
    context.close()


def line(tab: Tab, key: str) -> Any:
    return tab.page.locator(f"[data-answer={key}]")


def computed(tab: Tab) -> None:
    """Run the job of the tolerances and wait until its answers stand there."""
    line(tab, "error").get_by_role("button", name="Compute tolerance").click()
    line(tab, "planet").get_by_text("at 99 %").first.wait_for(timeout=5 * PATIENCE)


def seen(tab: Tab, key: str, text: str) -> None:
    line(tab, key).get_by_text(text).first.wait_for()


def test_an_answer_that_rests_on_assumed_values_says_which(tab: Tab) -> None:
    mark = line(tab, "planet").get_by_text(re.compile(r"^\d+ assumed$"))
    mark.wait_for()
    assert "operation.torque.main.sun: printed without the member" in mark.get_attribute("title")


def test_below_the_limit_there_is_no_button_but_an_answer_in_words(tab: Tab) -> None:
    seen(tab, "error", "Nothing to do as drawn: K_gamma 1.034 is below its limit 1.1")
    assert not line(tab, "error").get_by_role("button", name="Halve this deviation").is_visible()


def test_a_ranking_has_its_bands_and_its_ties(tab: Tab) -> None:
    computed(tab)
    said = line(tab, "error").inner_text()
    assert "carrier run-out (-0.00264 [-0.00284, -0.00243]) or planet position (-0.00239 [-0.00270, -0.00207])" in said
    assert "they are not told apart at 8192 samples" in said
    assert "overlap: with interactions they add up to 168 %" in said
    drawn = tab.page.locator("[data-kind=evidence]")
    tab.page.wait_for_function("() => document.querySelector('[data-kind=evidence]').ariaLabel.includes('1-2')")
    assert "Tolerances, 4 more take nothing off" in drawn.get_attribute("aria-label")
    assert "1-2  carrier run out" in drawn.get_attribute("aria-label")


def test_the_mark_follows_nearly_all_trains_and_nothing_is_to_be_done(tab: Tab) -> None:
    figures = [text.replace("\u00a0", " ") for text in line(tab, "planet").locator(".ck-figure").all_inner_texts()]
    assert figures == ["1.034", "1.056 at 99 %", "1.1"]
    assert line(tab, "planet").get_by_role("button", name="Limit of K_gamma 1.1: 3 planets, IEC 61400-4").is_visible()
    assert line(tab, "error").locator(".ck-figure").first.inner_text() == "nothing to do"
    for key, name in (("error", "Halve this tolerance"), ("float", "Let the sun float")):
        assert not line(tab, key).get_by_role("button", name=name).is_visible()


def test_one_limit_is_set_and_all_are_held_against_it(tab: Tab) -> None:
    tab.set_limit("1.05")
    seen(tab, "planet", "Limit 1.05: of the model")
    seen(tab, "error", "below its limit 1.05")
    assert line(tab, "planet").get_by_role("img", name="passes").is_visible()  # 1.034 as drawn
    computed(tab)
    line(tab, "planet").get_by_role("img", name="fails").wait_for()
    seen(tab, "planet", "limit 1.05 (limits.k_gamma): FAILS")
    halve = line(tab, "error").get_by_role("button", name="Halve this tolerance")
    halve.wait_for()
    seen(tab, "error", "Half of the first: K_gamma falls by 0.010")
    tab.set_limit("0.9")
    tab.page.get_by_text("allowed: a load factor of 1 or more").first.wait_for()
    tab.page.get_by_role("button", name="As the table has it").click()
    line(tab, "planet").locator(".ck-limit").get_by_text("1.1", exact=True).wait_for()
    halve.wait_for(state="hidden")
