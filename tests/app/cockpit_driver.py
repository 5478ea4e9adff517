"""A server of the cockpit in a process of its own, and pages of a real browser on it."""

from __future__ import annotations

import os
import re
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

# Two lists under the address bar are pages of the browser's own, which each window would load beside ours at twice its
# cost; the others are those that Playwright switches off on Linux: of two such arguments the last one counts.
FEATURES_OFF = (
    "WebUIOmniboxPopup",
    "WebUIOmniboxAimPopup",
    "AimEnabled",
    "AvoidCorsURLLoaderRestartOnRedirect",
    "AvoidUnnecessaryBeforeUnloadCheckSync",
    "DestroyProfileOnBrowserClose",
    "HttpsFirstBalancedModeAutoEnable",
    "HttpsUpgrades",
    "LensOverlay",
    "MediaRouter",
    "NetworkTimeServiceQuerying",
    "OptimizationHints",
    "PaintHolding",
    "PreconnectToSearch",
    "ThirdPartyStoragePartitioning",
)
ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--enable-precise-memory-info",
    f"--disable-features={','.join(FEATURES_OFF)}",
]
# [ms] a step may take on a machine that runs other tests besides
PATIENCE = 40_000
# [ms] between two looks of who waits for something on a page
LOOK = 30


def absent(reason: str) -> None:
    """Skip, but not where continuous integration has to provide what is missing."""
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


def chromium() -> str:
    """Path of the system's browser."""
    found = next(
        filter(None, map(shutil.which, ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"))),
        "",
    )
    if not found:
        absent("no Chromium here")
    return found


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        return int(found.getsockname()[1])


@dataclass(kw_only=True)
class Cockpit:
    """A server that runs.  address : with its token.  folder : of its key and of the user's files."""

    process: subprocess.Popen[str]
    address: str
    folder: Path
    told: list[str] = field(default_factory=list)

    @property
    def port(self) -> int:
        return int(urlsplit(self.address).port or 0)

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def processes(self) -> list[Any]:
        """The server and all that it has started."""
        import psutil

        main = psutil.Process(self.process.pid)
        return [main, *main.children(recursive=True)]

    def seconds(self) -> dict[int, float]:
        """Processor time of each process [s]."""
        import psutil

        found = {}
        for one in self.processes():
            try:
                found[one.pid] = sum(one.cpu_times()[:2])
            except psutil.NoSuchProcess:
                continue
        return found

    def stop(self) -> None:
        """Ctrl-C; what it said on stderr stands in `told`."""
        if self.process.poll() is None:
            self.process.send_signal(2)
            try:
                self.process.wait(20)
            except subprocess.TimeoutExpired:
                self.process.kill()
                raise
        if self.process.stderr is not None and not self.process.stderr.closed:
            self.told += self.process.stderr.read().splitlines()
            self.process.stderr.close()


def start(folder: Path, model: str | None = "ren2021", *, port: int | None = None) -> Cockpit:
    """`epicyclic app MODEL`, as a user starts it, in a folder of its own."""
    pytest.importorskip("nicegui")
    named = [] if model is None else [model]
    command = [sys.executable, "-m", "epicyclic", "app", *named, "--no-browser", "--port", str(port or free_port())]
    environment = {**os.environ, "XDG_STATE_HOME": str(folder / "state")}
    environment["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=folder, env=environment)
    assert process.stderr is not None
    line = process.stderr.readline()
    found = re.search(r"http://\S+", line)
    assert found, line + process.stderr.read()
    return Cockpit(process=process, address=found[0], folder=folder)


@contextmanager
def running(folder: Path, model: str | None = "ren2021", *, port: int | None = None) -> Iterator[Cockpit]:
    """A server until the end of the block; a traceback that it wrote fails the test."""
    server = start(folder, model, port=port)
    try:
        yield server
    finally:
        server.stop()
    assert "Traceback" not in "\n".join(server.told), "\n".join(server.told)


@contextmanager
def launched() -> Iterator[Any]:
    """The browser."""
    path = chromium()
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        absent("playwright is not installed")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield browser
        browser.close()


def still(browser: Any, **options: Any) -> Any:
    """A context of a user who wants no motion: shapes that move are tested by the canvas, and cost a core a page."""
    return browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce", **options)


class Tab:
    """A tab on the cockpit, with all that its console said."""

    def __init__(self, context: Any, address: str, *, wait: bool = True) -> None:
        self.page = context.new_page()
        self.page.set_default_timeout(PATIENCE)
        # Playwright looks at every picture, which makes the browser paint as long as somebody waits
        self.page.wait_for_function = partial(self.page.wait_for_function, polling=LOOK)
        self.said: list[str] = []
        self.page.on("console", lambda message: self.said.append(f"{message.type}: {message.text}"))
        self.page.on("pageerror", lambda error: self.said.append(f"error: {error}"))
        self.page.goto(address)
        if wait:
            self.painted()

    def painted(self, rev: int = -1, frame: str = "") -> int:
        """Wait until a figure of a newer revision is painted; its revision."""
        script = (
            "([rev, frame]) => window.cockpit?.painted && window.cockpit.painted.rev > rev"
            " && (!frame || window.cockpit.painted.frame === frame) ? {rev: window.cockpit.painted.rev} : null"
        )
        return int(self.page.wait_for_function(script, arg=[rev, frame]).json_value()["rev"])

    @property
    def rev(self) -> int:
        return int(self.page.evaluate("window.cockpit?.painted?.rev ?? -1"))

    def button(self, name: str) -> Any:
        return self.page.get_by_role("button", name=name, exact=True)

    def set_limit(self, value: str) -> None:
        """Set the limit of K_gamma in its window, beside the answer."""
        self.page.locator("[data-answer=planet] .ck-limit").click()
        field = self.page.get_by_label("Limit of K_gamma").locator("input")
        field.fill(value)
        field.press("Enter")

    def errors(self) -> list[str]:
        """What the console said that a user should never see there."""
        return [text for text in self.said if text.startswith("error")]
