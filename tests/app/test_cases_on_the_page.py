"""The switch of the load cases: levers, facts and answers of the case that is computed; undo, and the file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.app.cockpit_driver import PATIENCE, Cockpit, Tab, still

from epicyclic.document.document import drive_text

pytestmark = pytest.mark.browser

MODEL = Path(__file__).parents[2] / "examples" / "models" / "hybrid.toml"


@pytest.fixture(scope="module")
def tab(browser: Any, cockpit: Cockpit) -> Iterator[Tab]:
    """One tab of both tests, in their order."""
    context = still(browser)
    opened = Tab(context, cockpit.address)
    yield opened
    assert opened.errors() == []
    context.close()


def test_a_case_is_one_step_and_a_lever_changes_what_it_states(tab: Tab) -> None:
    switch, facts = tab.page.get_by_label("Load case", exact=True), tab.page.locator(".ck-facts")
    switch.wait_for()
    assert switch.inner_text().split() == ["nominal", "operation", "input_split", "compound_split", "fixed", "electric"]
    facts.filter(has_text="engine 140 N m").wait_for()
    switch.select_option("electric")
    facts.filter(has_text="engine 70 N m").wait_for()
    facts.filter(has_text="range sun 80 N m").wait_for()
    torque = tab.page.locator("[data-lever='cases.electric.torque.range.sun'] input.ck-box-number")
    torque.wait_for()
    assert torque.input_value() == "80"
    torque.fill("90")
    torque.press("Enter")
    facts.filter(has_text="range sun 90 N m").wait_for()
    for _ in range(2):
        tab.page.get_by_label(re.compile("^Undo")).click()
    facts.filter(has_text="engine 140 N m").wait_for()
    assert switch.input_value() == ""
    tab.page.get_by_label(re.compile("^Redo")).click()
    facts.filter(has_text="engine 70 N m").wait_for()
    assert switch.input_value() == "electric"


def test_the_cases_stand_in_one_table_beside_what_replays_it(tab: Tab, tmp_path: Path) -> None:
    tab.page.get_by_role("tab", name="Load cases").click()
    job = tab.page.locator("[data-job=cases]")
    job.get_by_role("button", name="Run", exact=True).click()
    tables = tab.page.locator(".ck-tables table")
    tables.first.wait_for(timeout=5 * PATIENCE)  # 6 s of a niced process, beside all that a run of the tests computes
    rows = tables.first.locator("tbody tr")
    names = ["input_split", "compound_split", "fixed", "electric"]
    assert [row.split("\t")[0] for row in rows.all_inner_texts()] == names
    heads = tables.first.locator("th").all_inner_texts()
    assert {"share [%]", "K_gamma", "ratio", "power [kW]"} <= set(heads)
    assert "slip" in tables.nth(1).inner_text()  # of the open clutches
    assert tab.page.locator("[data-kind=evidence]").is_hidden()
    tab.page.get_by_role("tab", name="Sharing").click()
    tables.first.wait_for(state="hidden")
    tab.page.locator("[data-kind=evidence]").wait_for()
    tab.page.get_by_role("tab", name="Load cases").click()
    job.get_by_role("button", name="Command line", exact=True).click()
    tab.page.locator("pre.ck-code").filter(has_text="--case all").wait_for()
    tab.page.keyboard.press("Escape")
    # a model without cases has no such tab, and its panel goes with it
    other = tmp_path / "ren2021.toml"
    other.write_text(drive_text("ren2021"), encoding="utf-8")
    tab.page.locator("input[type=file]").first.set_input_files(str(other))
    job.wait_for(state="hidden")
    assert tab.page.get_by_role("tab", name="Load cases").is_hidden()
    tab.page.get_by_role("tab", name="Sharing", selected=True).wait_for()
