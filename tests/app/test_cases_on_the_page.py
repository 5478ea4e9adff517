"""The switch of the load cases: levers, facts and answers of the case that is computed; undo, and the file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.app.cockpit_driver import Cockpit, Tab, running, still

pytestmark = pytest.mark.browser

MODEL = Path(__file__).parents[2] / "examples" / "models" / "hybrid.toml"


@pytest.fixture(scope="module")
def cockpit(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cockpit]:
    folder = tmp_path_factory.mktemp("cases")
    with running(folder, str(MODEL)) as server:
        yield server


def test_a_case_is_one_step_and_a_lever_changes_what_it_states(browser: Any, cockpit: Cockpit) -> None:
    context = still(browser)
    tab = Tab(context, cockpit.address)
    switch, facts = tab.page.get_by_label("Load case"), tab.page.locator(".ck-facts")
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
    assert tab.errors() == []
    context.close()
