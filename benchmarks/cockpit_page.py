"""The cockpit in a real browser: from the event of a slider to the painted figure, drags, memory, pictures.

python benchmarks/cockpit_page.py [DRIVE ...] [--moves 50] [--long 500] [--pictures FOLDER] [--numpy]

Prints a row for each drive: from a key to the painted curve, and to all else of the live set, median and 95 % of 50
moves [ms], of that spent computing, the rest (median of the differences), updates a second in a drag, from the release
of a drag to the painted curve with shaft orders (median and 95 % of 20) [ms], growth of the heap of the page and of the
server's memory over 500 moves.  ``xu2020+run-outs`` adds the run-outs of `cockpit.py` to a drive.  With --pictures it
writes one PNG for each state of the page, five sizes, light and dark, into a folder.
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
SIZES = {
    "1280x800": (1280, 800),
    "1440x757": (1440, 757),
    "1920x1080": (1920, 1080),
    "2560x1440": (2560, 1440),
    "800x600": (800, 600),
}
WARM = 5  # moves before it counts: the first run through every path of the browser's own compiler
# [s] between two moves, in turn: within a row of keys, while all of the state at rest is computed, and after it.  None
# is near the 0.4 s after which a row of keys ends: the frame of that would be taken for one of the next key.
PAUSES = (0.2, 0.8, 1.6)
QUICK = (0.1,)
DRAG = 5.0  # [s]
RELEASES = 20
# the time of a key, and of the first frame of a newer revision that is painted in the sweep
WATCH = """
() => {
  window.benchmark = {pressed: 0, released: 0};
  addEventListener('keydown', () => { window.benchmark.pressed = performance.now(); }, true);
  addEventListener('pointerup', () => { window.benchmark.released = performance.now(); }, true);
  // what each pane painted last
  let painted = window.cockpit.painted;
  window.benchmark.painted = {};
  Object.defineProperty(window.cockpit, 'painted', {
    get: () => painted, set: (value) => { window.benchmark.painted[value.kind] = painted = value; },
  });
}
"""
NEXT = """
([rev]) => window.cockpit?.painted && window.cockpit.painted.rev > rev && window.cockpit.painted.frame === 'live'
  ? {rev: window.cockpit.painted.rev, late: window.cockpit.painted.time - window.benchmark.pressed,
     curve: (window.cockpit.ahead?.rev > rev ? window.cockpit.ahead : window.cockpit.painted).time
       - window.benchmark.pressed,
     ms: window.cockpit.painted.computed ?? null} : null
"""

# the same from the release of a slider to its curve with shaft orders
SHAFTS = """
([rev]) => {
  const sweep = window.cockpit.parts.sweep, painted = window.benchmark.painted.sweep;
  return sweep?.rev > rev && sweep.head.stage === 'with shaft orders' && painted?.time >= sweep.arrived
    ? painted.time - window.benchmark.released : null;
}
"""


@dataclass(frozen=True, kw_only=True)
class Running:
    """A server of the benchmark: its address with the token, its process."""

    address: str
    process: psutil.Process

    def memory(self) -> float:
        """Resident memory of the server and its processes [MB]."""
        family = [self.process, *self.process.children(recursive=True)]
        return float(sum(one.memory_info().rss for one in family)) / 1e6


@contextmanager
def server(model: str | None, folder: Path) -> Iterator[Running]:
    """`epicyclic app MODEL` on a port of its own."""
    environment = {**os.environ, "XDG_STATE_HOME": str(folder)}
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
    """A drive, or a model file of it with run-outs and one pin error."""
    drive, _, more = name.partition("+")
    if not more:
        return drive
    from cockpit import RUN_OUTS

    from epicyclic.cockpit.state.model_file import text_of
    from epicyclic.cockpit.state.state import opened, with_values

    path = folder / f"{drive}-run-outs.toml"
    path.write_text(text_of(with_values(opened(drive), RUN_OUTS)), encoding="utf-8")
    return str(path)


def opened_page(browser: Browser, running: Running, size: tuple[int, int] = SIZES["1280x800"]) -> Page:
    """The page, with its first figure painted."""
    page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    page.goto(running.address)
    page.wait_for_function("window.cockpit?.painted?.kind", timeout=60_000)
    page.evaluate(WATCH)
    return page


def slider(page: Page) -> Any:
    """The first lever."""
    return page.locator("[data-lever] [role=slider]").first


def moves(page: Page, count: int, pauses: tuple[float, ...] = PAUSES) -> list[tuple[float, float, float | None]]:
    """Times from a key on the slider to the painted curve and to the rest [ms], with the time of computing in it."""
    found = []
    place = slider(page)
    place.focus()
    for index in range(count + WARM):
        rev = page.evaluate("window.cockpit.painted.rev")
        # back and forth, so that no end of the slider is met
        page.keyboard.press("ArrowRight" if index // 10 % 2 == 0 else "ArrowLeft")
        seen = page.wait_for_function(NEXT, arg=[rev], polling="raf", timeout=20_000).json_value()
        if index >= WARM:
            found.append((float(seen["curve"]), float(seen["late"]), seen["ms"]))
        time.sleep(pauses[index % len(pauses)])
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


def releases(page: Page) -> list[float]:
    """Times from the release of a slider to the painted curve with shaft orders [ms]; none of a train without."""
    if page.evaluate("window.cockpit.parts.sweep.head.stage") != "with shaft orders":
        return []
    box, found = slider(page).bounding_box(), []
    assert box is not None
    y, x0, width = box["y"] + box["height"] / 2, box["x"] + 8, box["width"] - 16
    for index in range(RELEASES):
        rev = page.evaluate("window.cockpit.rev")
        page.mouse.move(x0 + width * 0.5, y)
        page.mouse.down()
        for step in range(4):
            page.mouse.move(x0 + width * (0.5 + 0.02 * (step + 1) * (-1) ** index), y)
            time.sleep(0.05)
        page.mouse.up()
        found.append(float(page.wait_for_function(SHAFTS, arg=[rev], polling="raf", timeout=20_000).json_value()))
        time.sleep(1)
    return found


def heap(page: Page) -> float:
    """Memory of the page's scripts after a collection [MB]."""
    page.context.new_cdp_session(page).send("HeapProfiler.collectGarbage")
    return float(page.evaluate("performance.memory.usedJSHeapSize")) / 1e6


def measured(browser: Browser, name: str, options: argparse.Namespace) -> None:
    """Print the row of a drive."""
    with tempfile.TemporaryDirectory() as folder:
        model = model_of(name, Path(folder))
        with server(model, Path(folder)) as running:
            page = opened_page(browser, running)
            time.sleep(5)  # the first full set
            found = moves(page, options.moves)
            curve, whole = [curve for curve, _, _ in found], [late for _, late, _ in found]
            computing = [ms for _, _, ms in found if ms is not None]
            rate = drag(page)
            time.sleep(5)
            shafts = releases(page)
            before = heap(page), running.memory()
            if options.long:
                moves(page, options.long, QUICK)
                time.sleep(5)
            after = heap(page), running.memory()
    rest = [late - ms for _, late, ms in found if ms is not None]
    print(
        f"| {name} | {middle(curve)} | {late_of(curve)} | {middle(whole)} | {late_of(whole)} "
        f"| {middle(computing)} | {middle(rest)} | {rate:.1f} | {middle(shafts)} | {late_of(shafts)} "
        f"| {before[0]:.0f} -> {after[0]:.0f} | {before[1]:.0f} -> {after[1]:.0f} |",
        flush=True,
    )


def middle(times: list[float]) -> str:
    """Median, a dash of none."""
    return f"{statistics.median(times):.0f}" if times else "-"


def late_of(times: list[float]) -> str:
    """95th percentile, a dash of none."""
    return f"{sorted(times)[int(0.95 * (len(times) - 1))]:.0f}" if times else "-"


def main() -> None:
    """Measure, and take pictures where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", nargs="*", help="default: ren2021 xu2020+run-outs; none with --pictures alone")
    parser.add_argument("--moves", type=int, default=50)
    parser.add_argument("--long", type=int, default=500, help="moves between two looks at the memory")
    parser.add_argument("--pictures", type=Path, help="folder of the pictures")
    options = parser.parse_args()
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
        drives = options.drives or ([] if options.pictures else ["ren2021", "xu2020+run-outs"])
        print(
            "| drive | curve ms | p95 ms | all ms | p95 ms | computing ms | rest ms | updates a second "
            "| shaft orders ms | p95 ms "
            "| heap MB | server MB |"
        )
        print("|---" * 12 + "|")
        for name in drives:
            measured(browser, name, options)
        if options.pictures:
            from cockpit_pictures import take_pictures

            take_pictures(browser, options.pictures)
        browser.close()


if __name__ == "__main__":
    main()
