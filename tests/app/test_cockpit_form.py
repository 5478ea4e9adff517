"""The looks of the page in a real browser: one colour and name a mesh, columns of answers, contrast, sizes, Escape."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from tests.app.cockpit_driver import Cockpit, Tab, still

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def tab(browser: Any, cockpit: Cockpit) -> Iterator[Tab]:
    """One tab for all tests of the file; each leaves it with the train as it was opened."""
    context = still(browser)
    opened = Tab(context, cockpit.address)
    opened.page.locator("[data-lever]").nth(4).wait_for()
    yield opened
    assert opened.errors() == []
    context.close()


def themes(tab: Tab) -> Iterator[str]:
    """Each theme, and the light one at the end."""
    for theme in ("dark", "light"):
        tab.page.evaluate(f"window.Quasar.Dark.set({str(theme == 'dark').lower()})")
        tab.page.wait_for_timeout(500)  # colours of the library fade
        yield theme


def sized(tab: Tab, width: int, height: int) -> None:
    tab.page.set_viewport_size({"width": width, "height": height})
    tab.page.wait_for_timeout(250)


def run(tab: Tab, words: str, name: str, option: str, text: str) -> None:
    """Run a job with an option typed, and wait until its result is drawn."""
    tab.page.get_by_role("tab", name=words, exact=True).click()
    job = tab.page.locator(f"[data-job={name}]")
    job.get_by_text("Options").click()
    field = job.get_by_label(option, exact=True)
    field.fill(text)
    field.press("Tab")
    job.get_by_role("button", name=re.compile("^Run")).click()
    tab.page.wait_for_function(f"() => window.cockpit.parts['job:{name}']", timeout=100_000)
    tab.page.wait_for_function(
        "() => [...cockpit.panes].find((pane) => pane.kind === 'evidence').plot?.series.length > 1"
    )


# Label -> colour of the meshes that a pane draws: strong curves by their styles, rows by their dots.
COLOURS = """kind => {
  const pane = [...cockpit.panes].find((one) => one.kind === kind);
  const {labels, colours} = pane.hit?.data ?? {};
  if (!pane.plot) return Object.fromEntries(labels.map((label, i) => [label, colours?.[i] ?? 'none']));
  const alone = (label) => label.replace(/ and \\d+ alike$/, '');
  const curves = pane.plot.series.slice(1).map((one, i) => [alone(one.label), pane.styles[i].colour, one.width]);
  return Object.fromEntries(curves.filter(([, , width]) => width > 1).map(([label, colour]) => [label, colour]));
}"""


def test_a_mesh_has_one_name_and_one_colour_in_every_chart(tab: Tab) -> None:
    tab.page.get_by_role("tab", name="Sharing").click()
    tab.painted(-1)
    tab.page.wait_for_function("() => [...cockpit.panes].find((pane) => pane.kind === 'evidence').hit?.data.labels")
    rows = tab.page.evaluate(COLOURS, "evidence")
    assert len(set(rows.values())) == len(rows) == 12
    found = {"sweep": tab.page.evaluate(COLOURS, "sweep")}
    for words, name, *short in (("Stiffness", "stiffness", "Samples", "32"), ("Transient", "transient", "Cycles", "3")):
        run(tab, words, name, *short)
        found[name] = tab.page.evaluate(COLOURS, "evidence")
    for name, drawn in found.items():
        assert 1 <= len(drawn) <= 4
        assert drawn == {label: rows.get(label) for label in drawn}, name
    names = tab.page.locator("[data-kind=evidence] .ck-keys span").all_text_contents()
    assert set(names) <= {label.replace(" left", " L").replace(" right", " R") for label in rows} | {"8 more"}
    tab.page.get_by_role("tab", name="Sharing").click()


# Share of the pixels of the canvases that are blue, in thousandths.
BLUE = """() => [...document.querySelectorAll('canvas')].flatMap((canvas) => {
  const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let blue = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b, a] = data.subarray(i, i + 4);
    if (a > 60 && b > r + 50 && b > g + 15) blue += 1;
  }
  return [4000 * blue / data.length];
})"""


def test_no_data_are_blue(tab: Tab) -> None:
    for theme in themes(tab):
        tab.page.get_by_role("tab", name="Sharing").click()
        tab.page.wait_for_timeout(200)
        for name in ("Sharing", "Errors"):
            tab.page.get_by_role("tab", name=name).click()
            tab.page.wait_for_timeout(200)
            assert max(tab.page.evaluate(BLUE)) < 0.1, (theme, name)


def test_numbers_of_the_answers_stand_in_columns_and_a_click_shows_the_whole_text(tab: Tab) -> None:
    sized(tab, 1280, 800)
    heads = tab.page.locator(".ck-answers .ck-columns .ck-figure")
    assert heads.all_text_contents() == ["now", "then", "limit"]
    right = [round(box["x"] + box["width"]) for i in range(3) if (box := heads.nth(i).bounding_box())]
    for key in ("resonance", "planet", "float", "error", "relief"):
        line = tab.page.locator(f"[data-answer={key}]")
        figures = line.locator(".ck-figure")
        for i, edge in enumerate(right):
            box = figures.nth(i).bounding_box()
            assert abs(box["x"] + box["width"] - edge) <= 2, (key, i)
        more, text = line.locator("[aria-expanded]"), line.locator(".ck-answer-text")
        assert more.get_attribute("aria-expanded") == "false"
        more.focus()
        tab.page.keyboard.press("Enter")
        line.locator("[aria-expanded=true]").wait_for()
        assert text.evaluate("e => e.scrollHeight <= e.clientHeight + 1"), key  # nothing is cut
        text.click()
        line.locator("[aria-expanded=false]").wait_for()
    found = tab.page.locator("[data-answer=float] .ck-figure").all_text_contents()
    assert found[:2] == ["1.034", "1.000"]
    assert tab.page.locator("[data-answer=planet] .ck-figure").all_text_contents()[2] == "1.1"


GROUND = "key => getComputedStyle(document.querySelector(`[data-answer=${key}]`)).backgroundColor"


def test_an_answer_that_fails_looks_worse_than_a_note(tab: Tab) -> None:
    field = tab.page.locator("[data-lever]").filter(has_text="run-out of the carrier").locator(".ck-box-number")
    field.fill("200")
    field.press("Enter")
    tab.page.locator("[data-answer=planet] .ck-mark.bad").wait_for()
    grounds = {key: tab.page.evaluate(GROUND, key) for key in ("planet", "resonance", "relief")}
    assert grounds["planet"] not in (grounds["resonance"], grounds["relief"])
    assert grounds["resonance"] == grounds["relief"]
    size = "key => document.querySelector(`[data-answer=${key}] .ck-mark`).getBoundingClientRect().width"
    assert tab.page.evaluate(size, "planet") > tab.page.evaluate(size, "resonance")
    tab.page.get_by_label(re.compile("^Undo")).click()
    tab.page.locator("[data-answer=planet] .ck-mark.good").wait_for()


# Texts and icons of the page whose contrast to what lies under them is below 4.5, and of the colours of the canvases.
PALE = """() => {
  const paper = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  const read = (colour) => {
    paper.clearRect(0, 0, 1, 1);
    paper.fillStyle = colour;
    paper.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = paper.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = ([r, g, b, a], [R, G, B]) => [a * r + (1 - a) * R, a * g + (1 - a) * G, a * b + (1 - a) * B];
  const light = (rgb) => rgb.map((c) => c / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const ratio = (a, b) => {
    const [low, high] = [light(a), light(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  };
  // what is under an element, and how it looks itself, with the opacities of all that hold it
  const seen = (element) => {
    const chain = [];
    for (let one = element; one; one = one.parentElement) chain.unshift(one);
    let ground = [255, 255, 255], alpha = 1;
    for (const one of chain) {
      const style = getComputedStyle(one);
      alpha *= Number(style.opacity);
      const [r, g, b, a] = read(style.backgroundColor);
      ground = over([r, g, b, a * alpha], ground);
    }
    const [r, g, b, a] = read(getComputedStyle(element).color);
    return [over([r, g, b, a * alpha], ground), ground];
  };
  const found = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const [element, text] = [walk.currentNode.parentElement, walk.currentNode.textContent.trim()];
    if (!text || !element.checkVisibility({visibilityProperty: true}) || !element.getClientRects().length) continue;
    if (element.closest('script, style, option, :disabled, .disabled, .ck-hidden')) continue;
    const contrast = ratio(...seen(element));
    if (contrast < 4.5) found.push(`${text.slice(0, 30)}: ${contrast.toFixed(2)}`);
  }
  const style = getComputedStyle(document.body);
  const of = (name) => read(style.getPropertyValue(`--ck-${name}`).trim()).slice(0, 3);
  for (const name of ['ink', 'pale', 'warn', 'bad', 'good'])
    for (const under of ['surface', 'raised']) {
      const contrast = ratio(of(name), of(under));
      if (contrast < 4.5) found.push(`${name} on ${under}: ${contrast.toFixed(2)}`);
    }
  return [...new Set(found)];
}"""


def test_every_text_can_be_read(tab: Tab) -> None:
    sized(tab, 1280, 800)
    field = tab.page.locator("[data-lever]").filter(has_text="run-out of the carrier").locator(".ck-box-number")

    def pale(state: str) -> dict[str, list[str]]:
        return {f"{state}, {theme}": found for theme in themes(tab) if (found := tab.page.evaluate(PALE))}

    tab.page.mouse.move(2, 2)  # no tooltip fades in or out
    tab.page.locator(".q-tooltip").wait_for(state="detached")
    faint = pale("as opened")
    field.fill("200")
    field.press("Enter")
    tab.page.locator("[data-answer=planet] .ck-mark.bad").wait_for()
    tab.page.locator(".ck-mode[data-mode='5']").click()
    faint |= pale("edited, an answer fails")
    tab.button("Take away").click()
    tab.page.get_by_role("heading", name="Take away").wait_for()
    tab.page.wait_for_timeout(400)
    faint |= pale("a window")
    tab.page.keyboard.press("Escape")
    tab.page.get_by_role("heading", name="Take away").wait_for(state="detached")
    field.fill("five um")
    field.press("Enter")
    tab.page.wait_for_function("() => document.querySelector('.ck-page[data-failed]')")
    faint |= pale("refused")
    field.press("Escape")
    tab.page.wait_for_function("() => !document.querySelector('.ck-page[data-failed]')")
    tab.page.get_by_label(re.compile("^Undo")).click()
    tab.page.locator("[data-answer=planet] .ck-mark.good").wait_for()
    assert faint == {}


SIZES = """() => {
  const size = (place) => parseFloat(getComputedStyle(document.querySelector(place)).fontSize);
  const sweep = [...cockpit.panes].find((pane) => pane.kind === 'sweep').plot;
  const sheet = document.querySelector('[data-kind=train] canvas');
  const axis = parseFloat(/([\\d.]+)px/.exec([sweep.axes[0].font].flat()[0])[1]) / devicePixelRatio;
  const drawn = sheet.getContext('2d').getTransform().a / devicePixelRatio;
  return [size('.ck-answer-text'), size('.ck-lever-name'), size('.ck-head .q-btn'), axis, 11 * drawn];
}"""


def test_text_grows_with_a_wide_page(tab: Tab) -> None:
    found = {}
    for width, height in ((1280, 800), (1920, 1080), (2560, 1440), (3840, 2160)):
        sized(tab, width, height)
        tab.page.wait_for_timeout(200)
        found[width] = tab.page.evaluate(SIZES)
        wide = tab.page.evaluate("document.documentElement.scrollWidth")
        assert wide <= width
    sized(tab, 1280, 800)
    assert found[1280] == pytest.approx(found[1920], rel=1e-3)
    for i, size in enumerate(found[1920]):
        assert found[2560][i] == pytest.approx(size * 4 / 3, rel=0.05), i
        assert found[3840][i] > 1.2 * found[2560][i], i


# Pixels with ink where the title of the axis of the rows stands, at the bottom of what is seen, and below it.
TITLE = """() => {
  const pane = [...cockpit.panes].find((one) => one.kind === 'evidence');
  const canvas = pane.scroll.querySelector('canvas'), ratio = canvas.width / canvas.clientWidth;
  const bottom = pane.scroll.scrollTop + pane.scroll.clientHeight;
  const ink = (from, to) => {
    const [top, tall] = [Math.round((bottom - from) * ratio), Math.round((from - to) * ratio)];
    const {data} = canvas.getContext('2d').getImageData(0, top, canvas.width, tall);
    return data.filter((alpha, i) => i % 4 === 3 && alpha > 200).length;
  };
  return [ink(17, 3), ink(3, 0)];
}"""


def test_the_title_of_an_axis_is_seen_on_a_low_page(tab: Tab) -> None:
    tab.page.get_by_role("tab", name="Sharing").click()
    for width, height in ((1440, 757), (1280, 620)):  # on the second one the rows are scrolled
        sized(tab, width, height)
        at = tab.page.locator("[data-kind=evidence]").bounding_box()
        assert at["y"] + at["height"] <= max(height, 700)
        ink, below = tab.page.evaluate(TITLE)
        assert ink > 150, (width, height)
        assert below == 0, (width, height)  # it is whole
    tab.page.evaluate("[...cockpit.panes].find((one) => one.kind === 'evidence').scroll.scrollTop = 10")
    tab.page.wait_for_timeout(200)
    assert tab.page.evaluate(TITLE)[0] > 150
    sized(tab, 1280, 800)


def test_escape_ends_what_swings_is_enlarged_or_unfolded(tab: Tab) -> None:
    tab.page.locator(".ck-mode[data-mode='5']").click()
    tab.page.wait_for_function("() => cockpit.mode === 5")
    tab.page.keyboard.press("Escape")  # the focus is on the row, not on the drawing
    tab.page.wait_for_function("() => cockpit.mode === null")
    tab.page.wait_for_function("() => !document.querySelector('[data-mode][aria-pressed=true]')")
    tab.page.get_by_text("Model text (TOML)").click()
    tab.page.get_by_label(re.compile(": enlarge$")).first.click()
    tab.page.locator(".cockpit-large").wait_for()
    tab.page.keyboard.press("Escape")
    tab.page.locator(".cockpit-large").wait_for(state="detached")
    tab.page.get_by_text("Model text (TOML)").click()
    tab.page.get_by_role("tab", name="Stiffness").click()
    tab.page.locator("[data-job=stiffness] summary").click()
    tab.page.locator("[data-job=stiffness] details[open]").wait_for()
    tab.page.keyboard.press("Escape")
    tab.page.locator("[data-job=stiffness] details[open]").wait_for(state="detached")
    tab.page.get_by_role("tab", name="Sharing").click()


def test_the_header_says_edited_and_shows_the_whole_name(tab: Tab) -> None:
    name = tab.page.get_by_test_id("name")
    edited = tab.page.get_by_text("edited", exact=True)
    assert not edited.is_visible()
    field = tab.page.locator("[data-lever] .ck-box-number").first
    before = field.input_value()
    field.fill("7")
    field.press("Enter")
    edited.wait_for()
    assert name.inner_text() == "ren2021"
    assert "edited" in name.get_attribute("title")
    name.evaluate("e => { e.textContent = 'a-gearbox-with-a-name-of-forty-letters.toml' }")
    assert name.evaluate("e => e.scrollWidth <= e.clientWidth")  # there is room: the facts give way
    name.evaluate("e => { e.textContent = 'ren2021' }")
    tab.page.get_by_label(re.compile("^Undo")).click()
    tab.page.wait_for_function("v => document.querySelector('[data-lever] .ck-box-number').value === v", arg=before)
    assert not edited.is_visible()
