"""The chosen mode, the mark of the resonance and what a floating sun changes, on the page as a person sees them."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.app.cockpit_driver import PATIENCE, Cockpit, Tab, still

import epicyclic
from epicyclic.document.document import drive_text

pytestmark = pytest.mark.browser

PRESSED = """[
    [...document.querySelectorAll('.ck-mode[aria-pressed=true]')].filter(e => !e.hidden).map(e => e.innerText),
    cockpit.mode,
]"""


@pytest.fixture(scope="module")
def tab(browser: Any, cockpit: Cockpit) -> Iterator[Tab]:
    """ren2021."""
    context = still(browser)
    shown = Tab(context, cockpit.address)
    shown.page.locator(".ck-mode").nth(8).wait_for()
    yield shown
    assert shown.errors() == []
    context.close()


@pytest.fixture(autouse=True)
def as_it_was(tab: Tab) -> Iterator[None]:
    """Every test begins with the model of the file and without a mode."""
    yield
    while tab.page.get_by_label(re.compile("^Undo")).is_enabled():
        undo(tab)
    tab.page.locator("[data-kind=train]").press("Escape")


def choose(tab: Tab, number: int) -> None:
    tab.page.locator(f".ck-mode[data-mode='{number}']").click()


def pressed(tab: Tab, *words: str) -> str:
    """Wait until one row alone is pressed which has these words; its text, and that the drawing swings it too."""
    end = time.monotonic() + PATIENCE / 2000
    while True:
        rows, swung = tab.page.evaluate(PRESSED)
        if len(rows) == 1 and all(word in rows[0] for word in words) and swung == int(rows[0].split()[0]):
            return str(rows[0])
        assert time.monotonic() < end, (rows, swung, words)
        time.sleep(0.05)


def undo(tab: Tab) -> None:
    rev = tab.rev
    tab.page.get_by_label(re.compile("^Undo")).click()
    tab.painted(rev)


def test_the_chosen_mode_is_followed_when_the_sun_begins_to_float_and_back(tab: Tab) -> None:
    choose(tab, 5)
    rigid = pressed(tab, "159.5", "carrier rotates with the planets")
    tab.set_limit("1.02")
    tab.button("Let the sun float").wait_for()
    rev = tab.rev
    tab.button("Let the sun float").click()
    tab.painted(rev)
    floating = pressed(tab, "159.5", "carrier rotates with the planets")
    assert [text.split()[0] for text in (rigid, floating)] == ["5", "7"]
    undo(tab)
    assert pressed(tab, "159.5").split()[0] == "5"


def test_a_mode_that_is_gone_is_dropped_and_said(tab: Tab) -> None:
    tab.set_limit("1.02")
    tab.button("Let the sun float").wait_for()
    rev = tab.rev
    tab.button("Let the sun float").click()
    tab.painted(rev)
    choose(tab, 2)
    pressed(tab, "47.44")
    rev = tab.rev
    radial = tab.page.locator("[data-lever='stages.main.sun.support.radial'] input.ck-box-number")
    radial.fill("inf")
    radial.press("Enter")
    tab.painted(rev)
    said = tab.page.locator(".ck-modes [role=status]")
    tab.page.get_by_text("mode 2, 47.44 Hz, is gone: best MAC 0.48, limit 0.5").wait_for(timeout=8000)
    assert tab.page.evaluate(PRESSED) == [[], None]
    assert tab.page.evaluate("cockpit.mode") is None
    assert said.evaluate("e => e.scrollWidth <= e.clientWidth")  # nothing of it is cut
    undo(tab)
    choose(tab, 4)
    pressed(tab, "100.8")
    assert "is gone" not in said.inner_text()


def test_another_train_leaves_the_mode(tab: Tab, tmp_path: Path) -> None:
    choose(tab, 6)
    pressed(tab, "180.5")
    open_beside(tab, "wind-stage", tmp_path)
    assert tab.page.evaluate(PRESSED) == [[], None]
    assert tab.page.evaluate("cockpit.mode") is None


def open_beside(tab: Tab, drive: str, folder: Path) -> None:
    """Open another model on the same page."""
    path = folder / f"{drive}.toml"
    path.write_text(drive_text(drive), encoding="utf-8")
    rev = tab.rev
    tab.page.locator("input[type=file]").first.set_input_files(str(path))
    tab.painted(rev)
    tab.page.locator(".ck-mode:visible").get_by_text("2, 3 move tangentially").first.wait_for()


def test_the_mark_of_the_resonance_says_order_speed_and_distance(tab: Tab) -> None:
    said = tab.page.locator("[data-kind=sweep]").get_attribute("aria-label")
    assert "resonance of the answers: 6th order, 97.31 rpm, −2.7 %" in said
    assert tab.page.locator(".ck-peak").count() == 0  # none rises by 5 %: the largest by 0.4 %


def test_a_floating_sun_is_told_in_the_mean_and_while_turning(tab: Tab, tmp_path: Path) -> None:
    open_beside(tab, "wind-stage", tmp_path)
    tab.page.wait_for_function("cockpit.parts.sharing.kind === 'sharing'")  # all of the state is computed
    tab.page.locator("[data-answer=float]").get_by_text("With a floating sun: ").wait_for(timeout=PATIENCE / 2)
    text = tab.page.locator("[data-answer=float]").inner_text()
    told = []
    for overrides in ({}, {"stages.main.sun.support.radial": 0}):
        shares = epicyclic.sharing("wind-stage", method="static", overrides=overrides)["load_sharing"]
        told.append([float(shares.sel(definition=name).max()) for name in ("mean-load", "mean-load-turning")])
    (mean, turning), (mean_floating, turning_floating) = told
    assert f"mean-load K_gamma falls from {mean:.4f} to {mean_floating:.4f}" in text
    assert f"turning K_gamma rises from {turning:.4f} to {turning_floating:.4f}" in text
    assert "Resonance, 7th order: 13.51 rpm, −9.9 % → 13.47 rpm, −10 %." in text
