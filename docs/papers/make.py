"""Draw the figures of the pages on the ready drives: python docs/papers/make.py [NAME ... | NAME/FIGURE ...]

Each NAME.py beside this file defines FIGURES, name -> function that returns a plotly figure; schematics.py adds the
drawings of the train.  They are written to figures/NAME-FIGURE.svg through a headless Chromium (package playwright, a
Chromium on PATH or playwright's own), as SVG that plain renderers read alike.
"""

from __future__ import annotations

import importlib.util
import json
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from epicyclic.show.charts.renderers import FONT

HERE = Path(__file__).parent
FIGURES = HERE / "figures"
WIDTH, HEIGHT = 900, 500
MOST_BYTES = 200_000
# Two typefaces of one width, one of which stands on nearly every machine: a legend is cut where it was measured in a
# narrower one than it is shown in.
PAGE_FONT = "Verdana, 'DejaVu Sans', sans-serif"
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
_NOT_PAGES = ("make", "common", "schematics")
_RAISED = re.compile(  # an exponent, and the return to the line
    '\u200b?<tspan style="font-size:70%" dy="-0.6em">([-−0-9]+)</tspan><tspan dy="0.42em">\u200b</tspan>'
)
_SUPERSCRIPTS = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_DRAW = """async ([spec, width, height]) => {
  const options = { format: "svg", width: width, height: height };
  return await Plotly.toImage({ data: spec.data, layout: spec.layout }, options);
}"""

Renderer = Callable[[go.Figure, str], str]


def names() -> list[str]:
    """Pages that have figures."""
    return sorted(path.stem for path in HERE.glob("*.py") if path.stem not in _NOT_PAGES)


def figures_of(name: str) -> dict[str, Callable[[], go.Figure]]:
    """Drawings of the train and FIGURES of one page."""
    if str(HERE) not in sys.path:  # pages import what is beside them
        sys.path.insert(0, str(HERE))
    spec = importlib.util.spec_from_file_location(f"drives_{name}", HERE / f"{name}.py")
    if spec is None or spec.loader is None:
        raise SystemExit(f"no {name}.py in {HERE}; there are {', '.join(names())}")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    from schematics import schematics_of

    return {**schematics_of(name), **module.FIGURES}


@contextmanager
def renderer() -> Iterator[Renderer]:
    """A function from a figure and its name to SVG; stops with a message where there is no browser."""
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError:
        raise SystemExit("figures need the package playwright: pip install playwright") from None
    executable = next(filter(None, map(shutil.which, _BROWSERS)), None)
    with sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=executable)
        except Error as error:
            found = f"{executable} does not start" if executable else f"none of {', '.join(_BROWSERS)} is on PATH"
            raise SystemExit(f"figures need a headless Chromium: {found} ({error.message.splitlines()[0]})") from None
        yield lambda figure, name: _svg(browser, figure, name)
        browser.close()


def _svg(browser: Any, figure: go.Figure, name: str) -> str:
    """SVG of a figure, 900 x 500 or as much higher as its layout says; the same text for the same figure.

    A drawing to scale keeps its own height.
    """
    spec = json.loads(figure.to_json().replace(json.dumps(FONT)[1:-1], PAGE_FONT))
    for place, trace in enumerate(spec["data"]):  # plotly draws what is not named at random, here and below
        trace["uid"] = f"-{place}"
    page = browser.new_page()  # a new one each: plotly remembers widths of texts, and they depend on what came before
    page.add_script_tag(content=get_plotlyjs())
    least = 0 if figure.layout.yaxis.scaleanchor and figure.layout.height else HEIGHT
    address = page.evaluate(_DRAW, [spec, WIDTH, max(least, int(figure.layout.height or 0))])
    page.close()
    text = plain_superscripts(unquote(address.partition(",")[2]))
    found = re.search(r'id="(?:top)?defs-([0-9a-f]{6})"', text)
    return text.replace(found[1], name) if found else text


def plain_superscripts(text: str) -> str:
    """SVG with exponents as characters of their own: plotly's raised text has a size in percent, which SVG 1.1 does
    not know and some renderers take for a multiple.
    """
    return _RAISED.sub(lambda found: found[1].translate(_SUPERSCRIPTS), text)


def draw(wanted: Sequence[str]) -> int:
    """Draw the figures of some pages, or some figures ``page/figure``; returns how many are too large."""
    FIGURES.mkdir(exist_ok=True)
    large = 0
    with renderer() as to_svg:
        for page, _, only in (one.partition("/") for one in wanted):
            found = figures_of(page)
            if only and only not in found:
                raise SystemExit(f"no figure {only} in {page}; there are {', '.join(found)}")
            for name, build in found.items():
                if only and name != only:
                    continue
                target = FIGURES / f"{page}-{name}.svg"
                text = to_svg(build(), f"{page}-{name}")
                target.write_text(text, encoding="utf-8")
                size = len(text.encode())
                large += size > MOST_BYTES
                remark = f"  more than {MOST_BYTES // 1000} kB: draw fewer points" if size > MOST_BYTES else ""
                print(f"{target.relative_to(HERE.parent.parent)}  {size / 1000:.0f} kB{remark}", flush=True)
    return large


if __name__ == "__main__":
    unknown = [name for name in sys.argv[1:] if name.partition("/")[0] not in names()]
    if unknown:
        raise SystemExit(f"no page {', '.join(unknown)}; there are {', '.join(names())}")
    raise SystemExit(1 if draw(sys.argv[1:] or names()) else 0)
