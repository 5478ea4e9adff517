"""Pictures of the cockpit: every state of the page, three sizes, light and dark, one PNG each, to be looked at."""

from __future__ import annotations

import re
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cockpit_page import SIZES, Running, server
from playwright.sync_api import Browser, Page
from playwright.sync_api import TimeoutError as NotThere

__all__ = ["take_pictures"]

SETTLED = 4.0  # [s] the full set has come
DRAWN = 0.7  # [s] a dialog has faded in
WAITS = 20_000  # [ms]


def empty(page: Page) -> None:
    """As a page without a model stands."""


def computed(page: Page) -> None:
    page.wait_for_function("window.cockpit?.painted?.rev >= 0", timeout=WAITS)
    time.sleep(SETTLED)


def mode(page: Page) -> None:
    computed(page)
    page.locator("[data-mode]").first.click()


def refused(page: Page) -> None:
    computed(page)
    box = page.locator("[data-lever] input:not([role=slider])").first
    box.fill("-5")
    box.press("Enter")
    page.locator("[role=alert]:visible").first.wait_for(timeout=WAITS)


def dragged(page: Page) -> None:
    """The old curve at 40 % while the next one is computed."""
    computed(page)
    page.locator("[data-lever] [role=slider]").first.focus()
    for _ in range(6):
        page.keyboard.press("ArrowRight")


def pinned(page: Page) -> None:
    computed(page)
    page.get_by_role("button", name="Pin A", exact=True).click()
    page.locator("[data-lever] [role=slider]").first.focus()
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    time.sleep(SETTLED)


def compared(page: Page) -> None:
    pinned(page)
    page.get_by_role("button", name="Compare", exact=True).click()
    page.get_by_label("Differences of model and results").wait_for(timeout=3 * WAITS)


def opened_by(name: str) -> Callable[[Page], None]:
    """A state that a button of the header opens."""

    def state(page: Page) -> None:
        computed(page)
        page.get_by_role("button", name=re.compile(f"^{name}")).first.click()
        time.sleep(DRAWN)

    return state


def unfolded(name: str) -> Callable[[Page], None]:
    def state(page: Page) -> None:
        computed(page)
        page.get_by_text(name, exact=True).first.click()
        time.sleep(3 * DRAWN)

    return state


def job_of(name: str) -> Callable[[Page], None]:
    """A job as soon as it is done, or as it stands after a while."""

    def state(page: Page) -> None:
        computed(page)
        job = page.locator(f"[data-job={name}]")
        page.get_by_role("tab").filter(has_text=re.compile(name.split("_")[0], re.IGNORECASE)).first.click()
        job.get_by_role("button", name="Run").click()
        time.sleep(1.0)
        job.get_by_role("button", name="Run").wait_for(timeout=4 * WAITS)
        time.sleep(DRAWN)

    return state


STATES: dict[str, Callable[[Page], None]] = {
    "computed": computed,
    "mode": mode,
    "dragged": dragged,
    "refused": refused,
    "pinned": pinned,
    "compared": compared,
    "open": opened_by("Open"),
    "new": opened_by("New"),
    "save-as": opened_by("Save as"),
    "take-away": opened_by("Take away"),
    "fields": unfolded("All fields"),
    "text": unfolded("Model text (TOML)"),
    **{name: job_of(name) for name in ("contact", "relief", "stiffness", "tolerance", "transient")},
}
# what is looked at in all sizes; dialogs and jobs in one
EVERYWHERE = {"computed", "refused", "pinned"}


@contextmanager
def page_of(browser: Browser, running: Running, size: tuple[int, int], theme: Any) -> Iterator[Page]:
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=theme)
    try:
        page = context.new_page()
        page.goto(running.address)
        page.wait_for_selector(".ck-page, main", timeout=WAITS)
        yield page
    finally:
        context.close()


def take_pictures(browser: Browser, folder: Path, drive: str = "ren2021") -> None:
    """Write a picture for each state; one that cannot be reached is told."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as kept:
        with server(None, Path(kept)) as running:
            _pictures(browser, running, folder, {"empty": empty})
        with server(drive, Path(kept)) as running:
            _pictures(browser, running, folder, STATES)
            _gone(browser, running, folder)


def _pictures(browser: Browser, running: Running, folder: Path, states: dict[str, Callable[[Page], None]]) -> None:
    for name, state in states.items():
        for size, pixels in SIZES.items():
            if size != "laptop" and name not in EVERYWHERE | {"empty"}:
                continue
            for theme in ("light", "dark"):
                with page_of(browser, running, pixels, theme) as page:
                    try:
                        state(page)
                    except NotThere as error:
                        print(f"not reached: {name}, {size}, {theme}: {str(error).splitlines()[0]}", flush=True)
                    time.sleep(DRAWN)
                    page.screenshot(path=folder / f"{name}-{size}-{theme}.png")


def _gone(browser: Browser, running: Running, folder: Path) -> None:
    """The page when its server is gone."""
    with page_of(browser, running, SIZES["laptop"], "light") as page:
        computed(page)
        running.process.send_signal(2)
        time.sleep(SETTLED)
        page.screenshot(path=folder / "disconnected-laptop-light.png")
