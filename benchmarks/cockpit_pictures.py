"""Pictures of the cockpit: every state of the page, five sizes, light and dark, one PNG each, to be looked at.

What a small drive shows for an instant only is held: its process that computes is stopped for the picture.
"""

from __future__ import annotations

import re
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from cockpit_page import SIZES, Running, server
from playwright.sync_api import Browser, Page
from playwright.sync_api import TimeoutError as NotThere

from epicyclic.document.document import drive_text

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
    box = page.locator("[data-lever] input:not([role=slider])").nth(2)
    box.fill("-5")
    box.press("Enter")
    page.locator("[role=alert]:visible").first.wait_for(timeout=WAITS)


def loading(page: Page) -> None:
    """The old curve at 40 % while the next one takes long."""
    page.locator("[data-lever] [role=slider]").first.focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_selector("[data-loading]", timeout=WAITS)


def refused_text(page: Page) -> None:
    """A model text that is wrong: a banner, the last good curves."""
    unfolded("Model text (TOML)")(page)
    page.locator(".cm-content").first.click()
    page.keyboard.press("Control+Home")
    page.keyboard.type("unknown_key = 1\n")
    page.keyboard.press("Control+Enter")
    page.locator("[role=alert]:visible").first.wait_for(timeout=WAITS)


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


def filled(page: Page) -> None:
    """The wizard with a gearbox."""
    opened_by("New")(page)
    for label, value in {"Teeth": "21/39/99", "Speed of": "1000 rpm", "Power of": "750 kW"}.items():
        page.get_by_label(re.compile(f"^{label}")).first.fill(value)
    time.sleep(3 * DRAWN)


def tab_of(words: str) -> Callable[[Page], None]:
    def state(page: Page) -> None:
        computed(page)
        page.get_by_role("tab", name=words, exact=True).click()

    return state


def job_of(name: str, *, wait: bool = True) -> Callable[[Page], None]:
    """A job when it is done, or half a second after its start."""

    def state(page: Page) -> None:
        computed(page)
        job = page.locator(f"[data-job={name}]")
        page.get_by_role("tab").filter(has_text=re.compile(name.replace("_", " "), re.IGNORECASE)).first.click()
        job.get_by_role("button", name="Run").click()
        time.sleep(0.5)
        if wait:
            job.get_by_role("button", name="Run").wait_for(timeout=4 * WAITS)

    return state


def older_job(page: Page) -> None:
    """A job of an earlier state."""
    job_of("stiffness")(page)
    page.locator("[data-lever] [role=slider]").first.focus()
    page.keyboard.press("ArrowRight")
    time.sleep(SETTLED)


def limit(page: Page) -> None:
    """The window in which the limit of K_gamma is set."""
    computed(page)
    page.locator("[data-answer=planet] .ck-limit").click()


def detuned(page: Page) -> None:
    """Changes that move the named resonance, one of them previewed."""
    computed(page)
    page.locator("[data-answer=resonance] .ck-change:visible").first.hover(timeout=WAITS)
    time.sleep(SETTLED)


STATES: dict[str, Callable[[Page], None]] = {
    "computed": computed,
    "mode": mode,
    "refused": refused,
    "refused-text": refused_text,
    "pinned": pinned,
    "compared": compared,
    "errors": tab_of("Errors"),
    "jobs": tab_of("Jobs"),
    "open": opened_by("Open"),
    "new": opened_by("New"),
    "wizard": filled,
    "save-as": opened_by("Save as"),
    "take-away": opened_by("Take away"),
    "fields": unfolded("All fields"),
    "text": unfolded("Model text (TOML)"),
    "running": job_of("contact_loss", wait=False),
    "older-job": older_job,
    **{name: job_of(name) for name in ("contact", "relief", "stiffness", "tolerance", "transient", "sensitivity")},
    "contact-loss": job_of("contact_loss"),
    "limit": limit,
    "detune": job_of("detune"),
}


@contextmanager
def page_of(browser: Browser, running: Running) -> Iterator[Page]:
    width, height = SIZES["1280x800"]
    context = browser.new_context(viewport={"width": width, "height": height})
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
            _pictures(browser, running, folder, {"loading": loading}, held=True)
            _gone(browser, running, folder)
        fast = Path(kept) / "fast.toml"  # the first mesh order meets a mode, and the teeth part
        fast.write_text(drive_text("ren2021").replace('"100 rpm"', '"580 rpm"'), encoding="utf-8")
        with server(str(fast), Path(kept)) as running:
            _pictures(browser, running, folder, {"detuned": detuned})


def _pictures(
    browser: Browser, running: Running, folder: Path, states: dict[str, Callable[[Page], None]], *, held: bool = False
) -> None:
    """held : the server's processes are stopped once the page is computed."""
    for name, state in states.items():
        with page_of(browser, running) as page:
            try:
                if held:
                    computed(page)
                    _signal(running, signal.SIGSTOP)
                state(page)
            except NotThere as error:
                print(f"not reached: {name}: {str(error).splitlines()[0]}", flush=True)
            _in_all_sizes(page, folder, name)
            if held:
                _signal(running, signal.SIGCONT)


def _in_all_sizes(page: Page, folder: Path, name: str) -> None:
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        for theme in ("light", "dark"):
            page.emulate_media(color_scheme=theme)
            time.sleep(DRAWN)
            page.screenshot(path=folder / f"{name}-{size}-{theme}.png")


def _signal(running: Running, number: int) -> None:
    for process in running.process.children(recursive=True):
        process.send_signal(number)


def _gone(browser: Browser, running: Running, folder: Path) -> None:
    """The page when its server is gone."""
    with page_of(browser, running) as page:
        computed(page)
        running.process.send_signal(signal.SIGINT)
        time.sleep(SETTLED)
        _in_all_sizes(page, folder, "disconnected")
