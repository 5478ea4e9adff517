"""The report in a real browser: drawn, quiet, self-contained, nothing over anything else, and the animation plays."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import plotly.graph_objects as go
import pytest

from epicyclic.show.report import write_report
from epicyclic.verbs.record import run_report

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("few_turning_trains")]

# Boxes of what stands in a figure, and which of them lie over each other.
LAYOUT = """
() => {
  const slack = 1;  // [px] glyph boxes are rounded outwards
  const box = (element, kind) => {
    const r = element.getBoundingClientRect();
    const words = (element.textContent || '').trim().slice(0, 40);
    return {kind, words, x0: r.left, x1: r.right, y0: r.top, y1: r.bottom};
  };
  const meet = (a, b) => Math.min(a.x1, b.x1) - Math.max(a.x0, b.x0) > slack
                      && Math.min(a.y1, b.y1) - Math.max(a.y0, b.y0) > slack;
  const within = (a, b) => a.x0 >= b.x0 - slack && a.x1 <= b.x1 + slack && a.y0 >= b.y0 - slack && a.y1 <= b.y1 + slack;
  const say = b => `${b.kind} "${b.words}" [${[b.x0, b.y0, b.x1, b.y1].map(Math.round)}]`;
  const problems = [];
  const clash = (where, one, other) => problems.push(`${where}: ${say(one)} over ${say(other)}`);
  const cross = (where, a, boxes) => boxes.forEach(b => meet(a, b) && clash(where, a, b));
  const pairs = (where, boxes) => boxes.forEach((a, i) => cross(where, a, boxes.slice(i + 1)));
  const visible = b => b.x1 - b.x0 > 0.5 && b.y1 - b.y0 > 0.5;

  for (const figure of document.querySelectorAll('.js-plotly-plot')) {
    const all = (selector, kind) => [...figure.querySelectorAll(selector)].map(e => box(e, kind)).filter(visible);
    const frame = box(figure, 'figure'), full = figure._fullLayout, areas = [];
    for (const {xaxis, yaxis} of Object.values(full._plots || {})) {
      const x0 = frame.x0 + xaxis._offset, y0 = frame.y0 + yaxis._offset;
      areas.push({kind: 'plot', words: '', x0, x1: x0 + xaxis._length, y0, y1: y0 + yaxis._length});
    }
    areas.push(...all('.polarlayer .plotbg path', 'dial'));
    const outside = [
      ...all('.legend', 'legend'), ...all('.gtitle', 'title'), ...all('.colorbar', 'colour bar'),
      ...all('.xtitle, .ytitle', 'axis title'), ...all('.xtick text, .ytick text, .angularaxistick text', 'tick'),
      ...all('.slider-group', 'slider'), ...all('.updatemenu-button', 'button'),
    ];
    const notes = all('.annotation-text-g', 'note');
    const words = [...all('.textpoint text', 'text'), ...all('.bartext', 'text')];
    pairs(figure.id, [...outside, ...notes]);
    pairs(figure.id, [...notes, ...words]);
    pairs(figure.id, areas);
    outside.forEach(a => cross(figure.id, a, [...areas, ...words]));
    [...outside, ...notes, ...words].filter(a => !within(a, frame))
      .forEach(a => problems.push(`${figure.id}: ${say(a)} sticks out`));
  }
  const shown = e => !e.parentElement.closest('details:not([open])');
  const apart = ['nav, main', 'header, .findings, .warnings, .keys, section', '.key', '.findings li',
                 '.fold > figure, h2, .fold > .table, .fold > details'];
  for (const selector of apart) {
    const boxes = [...document.querySelectorAll(selector)].filter(shown);
    pairs('page', boxes.map(e => box(e, `${e.tagName}.${e.className}`)).filter(visible));
  }
  const whole = document.documentElement;
  if (whole.scrollWidth > whole.clientWidth) problems.push('the page is too wide');
  return problems;
}
"""
DRAWN = """
() => [...document.querySelectorAll('.js-plotly-plot')].map(figure => {
  const svg = figure.querySelector('svg.main-svg'), r = svg ? svg.getBoundingClientRect() : {width: 0, height: 0};
  const marks = figure.querySelectorAll('.trace, .barlayer .point, .hm image, .polarlayer .trace').length;
  return {id: figure.id, width: r.width, height: r.height, marks, traces: figure._fullData.length};
})
"""


def made_up() -> ModuleType:
    """The made-up Datasets of the unit tests; a folder as a package, because relative imports need one."""
    name = "epicyclic_synthetic"
    if name not in sys.modules:
        package = ModuleType(name)
        package.__path__ = [str(Path(__file__).parents[1] / "unit" / "show" / "synthetic")]
        sys.modules[name] = package
    return import_module(f"{name}.results")


def crowded() -> dict[str, Any]:
    synthetic = made_up()
    found: dict[str, Any] = synthetic.everything(synthetic.lin_gears(8, turning=True))
    return found


class Opened:
    """A page with all that it said and asked for."""

    def __init__(
        self, browser: Any, path: Path, *, width: int = 1280, scheme: str = "light", whole: bool = True
    ) -> None:
        self.page = browser.new_page(viewport={"width": width, "height": 800}, color_scheme=scheme)
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(f"{message.type}: {message.text}"))
        self.page.on("pageerror", lambda error: self.said.append(f"error: {error}"))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(path.as_uri())
        self.page.wait_for_function("() => document.documentElement.dataset.ready")
        if whole:
            self.page.locator("[data-folds=open]").click()
        self.wait()

    def wait(self) -> None:
        """Until every figure that can be seen is drawn."""
        self.page.wait_for_function(
            "() => [...document.querySelectorAll('.plotly-graph-div')]"
            ".filter(figure => !figure.parentElement.closest('details:not([open])'))"
            ".every(figure => figure._fullLayout && figure.querySelector('svg'))"
        )

    def problems(self) -> list[str]:
        found: list[str] = self.page.evaluate(LAYOUT)
        return found


@pytest.fixture(scope="module")
def crowded_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(tmp_path_factory.mktemp("crowded") / "page.html", crowded())


@pytest.fixture(scope="module", params=["ren2021", "lin1999-n4", "eight planets"])
def opened(
    request: pytest.FixtureRequest, browser: Any, crowded_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Opened]:
    """Two ready drives as analysed, and a crowded train that has everything."""
    path = crowded_path
    if request.param != "eight planets":
        path = write_report(tmp_path_factory.mktemp("report") / "page.html", run_report(request.param))
    page = Opened(browser, path)
    yield page
    page.page.close()


def test_the_browser_has_nothing_to_complain_about(opened: Opened) -> None:
    assert [text for text in opened.said if text.startswith(("error", "warning"))] == []


def test_nothing_is_asked_for_outside(opened: Opened) -> None:
    assert [url for url in opened.asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert opened.asked


def test_every_figure_is_drawn(opened: Opened) -> None:
    figures = opened.page.evaluate(DRAWN)
    assert len(figures) >= 7
    for figure in figures:
        assert min(figure["width"], figure["height"]) > 100, figure
        assert figure["marks"] > 0, figure
        assert figure["traces"] > 0, figure


def test_nothing_overlaps(opened: Opened) -> None:
    assert opened.problems() == []
    opened.page.evaluate("() => document.querySelectorAll('details').forEach(each => { each.open = true; })")
    opened.wait()
    assert opened.problems() == []


@pytest.mark.parametrize(("width", "scheme"), [(900, "dark"), (1400, "light")])
def test_nothing_overlaps_at_other_widths(browser: Any, crowded_path: Path, width: int, scheme: str) -> None:
    opened = Opened(browser, crowded_path, width=width, scheme=scheme)
    problems, grounds = opened.problems(), opened.page.evaluate(GROUNDS)
    opened.page.close()
    assert problems == []
    # text stands out from what it stands on, on either ground (WCAG AA asks for 4.5)
    assert min(contrast(ink, ground) for ink, ground in grounds) > 4.5
    assert all((sum(ground) < 3 * 80) == (scheme == "dark") for _, ground in grounds)


# Colour of the page's words, of the titles of figures and of the names of their axes, and what is under them.
GROUNDS = """
() => {
  const rgb = words => (words.match(/[0-9.]+/g) || []).slice(0, 3).map(Number);
  const page = rgb(getComputedStyle(document.body).backgroundColor);
  const found = [[rgb(getComputedStyle(document.body).color), page]];
  for (const figure of document.querySelectorAll('.js-plotly-plot')) {
    const ground = rgb(getComputedStyle(figure.querySelector('.main-svg')).backgroundColor);
    const words = figure.querySelectorAll('.gtitle, .xtitle, .ytitle, .xtick text, .legendtext');
    for (const each of words) found.push([rgb(getComputedStyle(each).fill), ground]);
  }
  return found;
}
"""


def contrast(one: list[float], other: list[float]) -> float:
    """Ratio of the luminances of two colours [0..255], as WCAG 2 defines it."""

    def light(colour: list[float]) -> float:
        parts = [value / 255 for value in colour]
        red, green, blue = (x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts)
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    low, high = sorted((light(one), light(other)))
    return (high + 0.05) / (low + 0.05)


def test_the_first_page_is_read_without_a_click(browser: Any, crowded_path: Path) -> None:
    """Folded at first; a link opens its section and draws it."""
    opened = Opened(browser, crowded_path, whole=False)
    page = opened.page
    drawn = "() => [...document.querySelectorAll('.js-plotly-plot')].map(figure => figure.id)"
    assert page.evaluate(drawn) == ["figure-operating-range"]
    assert page.locator(".findings li").count() >= 3
    assert page.locator("#modes figure").first.is_hidden()
    page.locator("nav a[href='#modes']").click()
    page.locator("#modes figure").first.wait_for()  # the link opens it once the address has changed
    opened.wait()
    assert page.locator("#modes figure").first.is_visible()
    assert "figure-campbell" in page.evaluate(drawn)
    assert page.locator("#sharing figure").first.is_hidden()
    page.close()


def test_on_paper_everything_is_open_and_whole(browser: Any, crowded_path: Path) -> None:
    """A4, light, numbered; no heading is the last of its page, nothing wider than the paper."""
    from pypdf import PdfReader

    opened = Opened(browser, crowded_path, scheme="dark", whole=False)
    titles = opened.page.locator("h2").all_text_contents()
    reader = PdfReader(io.BytesIO(opened.page.pdf(prefer_css_page_size=True)))
    opened.page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
    wide = opened.page.evaluate(
        "() => [...document.querySelectorAll('main table, main figure, main pre, .plotly-graph-div .main-svg')]"
        ".filter(one => one.getBoundingClientRect().right > 682).map(one => one.outerHTML.slice(0, 80))"
    )
    tall = opened.page.evaluate(
        "() => [...document.querySelectorAll('figure')].map(one => one.getBoundingClientRect().height)"
    )
    opened.page.close()
    assert wide == []
    assert max(tall) < 990  # [px] of A4 between its margins: a figure is not cut
    assert [round(float(side)) for side in reader.pages[0].mediabox[2:]] == [595, 842]
    pages = [page.extract_text() for page in reader.pages]
    assert all(f"{place} / {len(pages)}" in text for place, text in enumerate(pages, start=1))
    for title in titles:
        (where,) = [text for text in pages if any(line.strip("▸▾ ") == title for line in text.splitlines())]
        lines = [line.strip("▸▾ ") for line in where.splitlines() if line.strip()]
        assert lines.index(title) < len(lines) - 2, title  # behind it something else than the number of the page
    assert "Every resolved value" in "".join(pages)  # folded twice on the screen


PATHS = (
    "[...document.querySelectorAll('#figure-shapes .scatterlayer path.js-line')].map(e => e.getAttribute('d')).join()"
)


def shapes_path(page: Any) -> str:
    found: str = page.evaluate(f"() => {PATHS}")
    return found


def test_the_animation_plays_and_stops(opened: Opened) -> None:
    page = opened.page
    page.locator("#figure-shapes").scroll_into_view_if_needed()
    still = shapes_path(page)
    page.locator("#figure-shapes .updatemenu-button", has_text="Play").click()
    page.wait_for_function(f"before => {PATHS} !== before", arg=still, timeout=10_000)
    page.locator("#figure-shapes .updatemenu-button", has_text="Stop").click()
    page.wait_for_timeout(300)
    stopped = shapes_path(page)
    page.wait_for_timeout(300)
    assert shapes_path(page) == stopped


def test_the_slider_chooses_a_mode(opened: Opened) -> None:
    page = opened.page
    rail = page.locator("#figure-shapes .slider-rail-touch-rect")
    rail.scroll_into_view_if_needed()
    size = rail.bounding_box()
    page.mouse.click(size["x"] + 0.5 * size["width"], size["y"] + 0.5 * size["height"])
    page.wait_for_timeout(400)
    active = page.evaluate("() => document.getElementById('figure-shapes')._fullLayout.sliders[0].active")
    steps = page.evaluate("() => document.getElementById('figure-shapes')._fullLayout.sliders[0].steps.length")
    assert abs(active - (steps - 1) / 2) <= 1
    shown = page.locator("#figure-shapes .slider-group").text_content()
    assert f"mode {active + 1}:" in shown
    frame = page.evaluate("() => document.getElementById('figure-shapes')._fullLayout._currentFrame")
    assert frame.split(".")[0] == str(active)
    page.locator("#figure-shapes .updatemenu-button", has_text="Stop").click()


def test_an_overlap_is_seen(browser: Any, tmp_path: Path) -> None:
    """The check of the layout itself: a legend in the plot, a note on the title, a page that is too wide."""
    bad = go.Figure([go.Scatter(y=[1, 2], name="one"), go.Scatter(y=[2, 1], name="two")])
    bad.update_layout(title="A title", legend={"x": 0.5, "y": 0.5}, width=1600)
    bad.add_annotation(text="on the title", xref="paper", yref="paper", x=0, y=1.3, showarrow=False)
    page = Opened(browser, write_report(tmp_path / "page.html", {}, figures={"bad": bad}))
    problems = page.problems()
    page.page.close()
    for kinds in (("legend", "plot"), ("title", "note")):
        assert any(all(f"{kind} " in text for kind in kinds) for text in problems), problems
