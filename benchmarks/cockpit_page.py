"""The cockpit in a real browser: from the event of a slider to the painted figure, drags, memory, pictures.

python benchmarks/cockpit_page.py [DRIVE ...] [--moves 50] [--long 500] [--pictures FOLDER] [--numpy]

Prints a row for each drive: median and 95 % of 50 moves [ms], of them spent computing, updates a second in a drag,
growth of the heap of the page and of the server's memory over 500 moves.  `run-outs` behind the name of a drive, say
``xu2020+run-outs``, adds run-outs of 10 um to all gears.  With --pictures it writes one PNG for each state of the page,
three sizes, light and dark, into a folder.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import Browser, Page, sync_playwright

ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--enable-precise-memory-info"]
SIZES = {"laptop": (1280, 800), "screen": (1920, 1080), "narrow": (800, 1000)}
WARM = 5  # moves before it counts: the first run through every path of the browser's own compiler
PAUSE = 0.35  # [s] between two moves: what a release asks for has begun, as of a person who tries values
DRAG = 5.0  # [s]
# the time of a key, and of the first frame of a newer revision that is painted in the sweep
WATCH = """
() => {
  window.benchmark = {pressed: 0, times: []};
  addEventListener('keydown', () => { window.benchmark.pressed = performance.now(); }, true);
}
"""
NEXT = """
([rev]) => window.cockpit?.painted && window.cockpit.painted.rev > rev && window.cockpit.painted.frame === 'live'
  ? {rev: window.cockpit.painted.rev, late: window.cockpit.painted.time - window.benchmark.pressed,
     ms: window.cockpit.painted.computed ?? null} : null
"""


@dataclass(frozen=True, kw_only=True)
class Running:
    """A server of the benchmark: its address with the token, its process."""

    address: str
    process: psutil.Process

    def memory(self) -> float:
        """Resident memory of the server and its processes [MB]."""
        family = [self.process, *self.process.children(recursive=True)]
        return sum(one.memory_info().rss for one in family) / 1e6


@contextmanager
def server(model: str | None, folder: Path, *, compiled: bool = True) -> Iterator[Running]:
    """`epicyclic app MODEL` on a port of its own."""
    environment = {**os.environ, "XDG_STATE_HOME": str(folder)}
    if not compiled:
        (folder / "numba.py").write_text("raise ImportError('left out of this run')\n", encoding="utf-8")
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [str(folder), environment.get("PYTHONPATH")]))
    named = [] if model is None else [model]
    command = [sys.executable, "-m", "epicyclic", "app", *named, "--no-browser"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as run:
        assert run.stderr is not None
        line = run.stderr.readline()
        found = re.search(r"http://\S+", line)
        if found is None:
            raise SystemExit(line + run.stderr.read())
        try:
            yield Running(address=found[0], process=psutil.Process(run.pid))
        finally:
            if run.poll() is None:
                run.send_signal(2)
            run.wait(20)


def model_of(name: str, folder: Path) -> str:
    """A drive, or a model file beside it with run-outs and one pin error."""
    drive, _, more = name.partition("+")
    if not more:
        return drive
    from epicyclic.cockpit.state.state import opened, with_values
    from epicyclic.cockpit.state.written_text import text_of

    errors = {f"deviations.{gear}.runout": "10 um" for gear in ("sun", "ring", "planet")}
    path = folder / f"{drive}-run-outs.toml"
    path.write_text(text_of(with_values(opened(drive), errors)), encoding="utf-8")
    return str(path)


def opened_page(browser: Browser, running: Running, size: tuple[int, int] = SIZES["laptop"]) -> Page:
    """The page, with its first figure painted."""
    page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    page.goto(running.address)
    page.wait_for_function("window.cockpit?.painted?.kind", timeout=60_000)
    page.evaluate(WATCH)
    return page


def slider(page: Page) -> Any:
    """The first lever."""
    return page.locator("[data-lever] [role=slider]").first


def moves(page: Page, count: int) -> list[tuple[float, float | None]]:
    """Times from a key on the slider to the painted figure [ms], with the time of computing in it."""
    found = []
    place = slider(page)
    place.focus()
    for index in range(count + WARM):
        rev = page.evaluate("window.cockpit.painted.rev")
        # back and forth, so that no end of the slider is met
        page.keyboard.press("ArrowRight" if index // 10 % 2 == 0 else "ArrowLeft")
        seen = page.wait_for_function(NEXT, arg=[rev], polling="raf", timeout=20_000).json_value()
        if index >= WARM:
            found.append((float(seen["late"]), seen["ms"]))
        time.sleep(PAUSE)
    return found


def drag(page: Page) -> float:
    """Updates a second while the slider is dragged."""
    box = slider(page).bounding_box()
    y, x0, width = box["y"] + box["height"] / 2, box["x"] + 8, box["width"] - 16
    page.mouse.move(x0 + width / 2, y)
    page.mouse.down()
    page.evaluate(
        "() => { window.benchmark.revs = new Set(); const look = () => { const now = window.cockpit.painted;"
        " if (now.frame === 'live') window.benchmark.revs.add(now.rev);"
        " window.benchmark.on = requestAnimationFrame(look); }; look(); }"
    )
    end, step = time.monotonic() + DRAG, 0
    while time.monotonic() < end:
        step += 1
        page.mouse.move(x0 + width * (0.5 + 0.3 * ((step % 80) - 40) / 40), y)
        time.sleep(0.03)
    count = page.evaluate("() => { cancelAnimationFrame(window.benchmark.on); return window.benchmark.revs.size; }")
    page.mouse.up()
    return (int(count) - 1) / DRAG


def heap(page: Page) -> float:
    """Memory of the page's scripts after a collection [MB]."""
    page.context.new_cdp_session(page).send("HeapProfiler.collectGarbage")
    return float(page.evaluate("performance.memory.usedJSHeapSize")) / 1e6


def measured(browser: Browser, name: str, options: argparse.Namespace) -> None:
    """Print the row of a drive."""
    with tempfile.TemporaryDirectory() as folder:
        model = model_of(name, Path(folder))
        with server(model, Path(folder), compiled=not options.numpy) as running:
            page = opened_page(browser, running)
            time.sleep(5)  # the first full set
            pairs = moves(page, options.moves)
            late = sorted(time for time, _ in pairs)
            computing = [ms for _, ms in pairs if ms is not None]
            rate = drag(page)
            time.sleep(5)
            before = heap(page), running.memory()
            if options.long:
                moves(page, options.long)
                time.sleep(5)
            after = heap(page), running.memory()
    p95 = late[int(0.95 * (len(late) - 1))]
    inside = f"{statistics.median(computing):.0f}" if computing else "?"
    print(
        f"| {name} | {statistics.median(late):.0f} | {p95:.0f} | {inside} | {rate:.1f} "
        f"| {before[0]:.0f} -> {after[0]:.0f} | {before[1]:.0f} -> {after[1]:.0f} |",
        flush=True,
    )


def main() -> None:
    """Measure, and take pictures where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", nargs="*", help="default: ren2021 xu2020+run-outs; none with --pictures alone")
    parser.add_argument("--moves", type=int, default=50)
    parser.add_argument("--long", type=int, default=500, help="moves between two looks at the memory")
    parser.add_argument("--numpy", action="store_true", help="without numba")
    parser.add_argument("--pictures", type=Path, help="folder of the pictures")
    options = parser.parse_args()
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
        drives = options.drives or ([] if options.pictures else ["ren2021", "xu2020+run-outs"])
        print("| drive | median ms | p95 ms | computing ms | updates a second | heap MB | server MB |")
        print("|---|---|---|---|---|---|---|")
        for name in drives:
            measured(browser, name, options)
        if options.pictures:
            from cockpit_pictures import take_pictures

            take_pictures(browser, options.pictures)
        browser.close()


if __name__ == "__main__":
    main()
