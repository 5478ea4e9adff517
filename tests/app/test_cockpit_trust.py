"""What a user must be able to rely on: what a lever writes, whose figures stand there, what a reload and a kill leave."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from tests.app.cockpit_driver import Cockpit, Tab, still

pytestmark = pytest.mark.browser
MODEL = "xu2020"
PIN = "[data-lever='deviations.planet.position.y']"


@pytest.fixture
def context(browser: Any) -> Iterator[Any]:
    made = still(browser)
    yield made
    made.close()


@pytest.fixture
def tab(context: Any, cockpit: Cockpit) -> Iterator[Tab]:
    opened = Tab(context, cockpit.address)
    yield opened
    assert opened.errors() == []


def typed(tab: Tab, text: str, lever: str = PIN) -> None:
    """Type into the box of a lever, and wait for its figure."""
    field = tab.page.locator(f"{lever} input.ck-box-number")
    rev = tab.rev
    field.fill(text)
    field.press("Enter")
    tab.painted(rev, "sharing")


def answer(tab: Tab, key: str) -> str:
    return " ".join(str(tab.page.locator(f"[data-answer={key}]").inner_text()).split())


def test_a_number_and_a_text_with_its_unit_are_the_same_train(tab: Tab) -> None:
    tab.painted(-1, "sharing")
    typed(tab, "40")
    number = answer(tab, "planet")
    assert re.search(r"1\.[1-9]", number)  # one pin that is off: one planet carries more
    for text in ("40 um", "0.04 mm", "4e-5 m"):
        typed(tab, "20")
        typed(tab, text)
        assert answer(tab, "planet") == number, text
        assert tab.page.locator(f"{PIN} input.ck-box-number").input_value() == "40"
