"""Jobs in a real browser: what they find stays where it is drawn; how long they take; what replays them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from tests.app.cockpit_driver import PATIENCE, Cockpit, Tab, still

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def tab(browser: Any, cockpit: Cockpit) -> Iterator[Tab]:
    context = still(browser)
    opened = Tab(context, cockpit.address)
    yield opened
    assert opened.errors() == []
    context.close()


def chosen(tab: Tab, words: str, name: str, **options: str) -> Any:
    """The bar of a job with options typed."""
    tab.page.get_by_role("tab", name=words).click()
    job = tab.page.locator(f"[data-job={name}]")
    job.get_by_text("Options").click()
    for label, text in options.items():
        field = job.get_by_label(label.replace("_", " "), exact=True)
        field.fill(text)
        field.press("Tab")
    return job


def test_the_numbers_of_a_relief_stay_when_it_is_drawn_and_the_curve_can_follow(tab: Tab) -> None:
    chosen(tab, "Relief", "relief", Population="4", Generations="2")
    line = tab.page.locator("[data-answer=relief]")
    assert re.search(r"for [\d.]+ kN a helix", line.inner_text())
    line.get_by_role("button", name="Compute").click()
    draw = line.get_by_role("button", name="Draw this relief")
    draw.click(timeout=5 * PATIENCE)
    line.get_by_text(re.compile(r"is drawn: .* [\d.]+ µm before, [\d.]+ µm after at [\d.]+ to [\d.]+ kN")).wait_for()
    curve = tab.page.locator("[data-kind=sweep]")
    curve.get_by_text("relief not counted").wait_for()
    # the curve is painted ahead of the rest, which may say for a moment that it is of another state
    tab.page.get_by_text("of another state: run it again").wait_for(state="hidden")
    tab.page.locator("[data-kind=evidence][data-stale=false]").wait_for()
    draw.wait_for(state="hidden")
    tab.page.get_by_label(re.compile("^Undo")).click()
    draw.click()  # what was found of this model stands again
    line.get_by_role("button", name="Let the curve follow").click()
    curve.get_by_text("relief not counted").wait_for(state="hidden")
    line.get_by_role("button", name="Let the curve follow").wait_for(state="hidden")
    assert "µm before" in line.inner_text()
    tab.page.locator("[data-kind=evidence][data-stale=false]").wait_for()


def test_a_job_says_what_it_takes_of_this_train_and_its_tab_how_it_stands(tab: Tab) -> None:
    job = chosen(tab, "Contact loss", "contact_loss", Points="4")
    job.get_by_text(re.compile(r"About \d+ (to \d+ )?s on this train")).wait_for()
    assert job.locator(".ck-answer-text").inner_text().startswith("About")  # what is cut is what follows
    mark = tab.page.get_by_role("tab", name="Contact loss")
    assert mark.get_attribute("data-mark") is None
    job.get_by_role("button", name="Run", exact=True).click()
    tab.page.locator("[role=tab][data-mark='✓']", has_text="Contact loss").wait_for(timeout=5 * PATIENCE)
    assert mark.get_attribute("title").endswith(": done, of this state")
    key = tab.page.locator("[data-kind=evidence] .ck-keys")
    key.get_by_text("linear, largest").wait_for()
    tab.page.locator("[data-lever] [role=slider]").first.focus()
    tab.page.keyboard.press("ArrowRight")
    tab.page.locator("[role=tab][data-mark='↻']", has_text="Contact loss").wait_for()
    firsts = tab.page.locator("[role=tab].ck-first").all_inner_texts()
    assert [text.split("\n")[0] for text in firsts] == ["Contact", "Relief", "Jobs"]


def test_every_job_has_its_command_line_and_script(tab: Tab) -> None:
    job = chosen(tab, "Transient", "transient", Cycles="3")
    for name, words in (("Command line", "epicyclic transient ren2021 --cycles 3"), ("Script", "epicyclic.transient(")):
        job.get_by_role("button", name=name).click()
        window = tab.page.get_by_role("dialog")
        window.get_by_text(words).wait_for()
        window.get_by_role("button", name="Copy").wait_for()
        window.get_by_role("button", name="Close").click()
        window.wait_for(state="hidden")
    for bar in tab.page.locator("[data-job]").all():
        assert bar.get_by_role("button", name="Script", include_hidden=True).count() == 1
