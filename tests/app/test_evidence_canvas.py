"""Lines of a job in a real browser: no peak is lost, a drag goes closer, a double click and Escape show all again."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.app.canvas_page import painted, show
from tests.unit.cockpit import canvas_frames as frames

from epicyclic.cockpit.computing.job_kinds import Drawn, job_frame, lines
from epicyclic.cockpit.state.frames import pack

pytestmark = pytest.mark.browser

SPIKE = 33_333  # of 50 000 samples, one of those that a thinned record leaves out
# [px] of the ink of the first strong curve in the upper half of the plot
HIGH = """() => {
  const { plot, styles } = panes.evidence, { left, top, width, height } = plot.bbox;
  const probe = document.createElement("canvas").getContext("2d");
  probe.fillStyle = styles[0].colour;
  probe.fillRect(0, 0, 1, 1);
  const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
  const { data } = plot.ctx.getImageData(left, top, width, height / 2);
  const columns = new Set();
  for (let i = 0; i < data.length; i += 4) {
    const off = [r, g, b].reduce((sum, value, k) => sum + Math.abs(data[i + k] - value), 0);
    if (off < 60) columns.add((i / 4) % width);
  }
  return [...columns].map((at) => plot.posToVal(at / devicePixelRatio, "x"));
}"""


def shown(page: Any, name: str, drawn: Drawn) -> None:
    frame = replace(job_frame(name, "Motion over time", "A spike.", drawn), rev=1)
    show(page, pack(frame))
    page.evaluate("name => panes.evidence.setEvidence(name)", name)
    painted(page, "evidence", 1)


def test_a_record_is_drawn_with_every_peak_and_zoomed_by_drag_and_keys(page: Any) -> None:
    time = np.linspace(0.0, 500.0, 50_001)
    force = np.sin(time)
    force[SPIKE] = 40.0
    shown(page, "transient", lines("time [ms]", "mesh force [kN]", time, {"sun-planet 1": force}))
    columns = page.evaluate(HIGH)
    assert columns, "the spike is not drawn"
    assert columns == pytest.approx([time[SPIKE]] * len(columns), abs=3.0)

    ends = "panes.evidence.xRange"
    assert page.evaluate(ends) == [0, 500]
    over = page.locator("#evidence .u-over").bounding_box()
    middle = over["y"] + over["height"] / 2
    page.mouse.move(over["x"] + 0.6 * over["width"], middle)
    page.mouse.down()
    page.mouse.move(over["x"] + 0.7 * over["width"], middle, steps=4)
    page.mouse.up()
    assert page.evaluate(ends) == pytest.approx([300, 350], abs=2)
    page.wait_for_function("() => Math.abs(panes.evidence.plot.scales.x.min - 300) < 2")
    assert page.get_by_text("double click: all").is_visible()
    assert page.evaluate(HIGH) == pytest.approx([time[SPIKE]] * len(page.evaluate(HIGH)), abs=1.0)
    page.mouse.dblclick(over["x"] + 10, middle)
    assert page.evaluate(ends) == [0, 500]

    page.mouse.move(0, 0)
    page.focus("#evidence")
    page.keyboard.press("+")
    assert page.evaluate(ends) == pytest.approx([125, 375])
    page.keyboard.press("ArrowRight")
    assert page.evaluate(ends) == pytest.approx([187.5, 437.5])
    page.keyboard.press("-")
    assert page.evaluate("panes.evidence.root.dataset.zoomed") == "true"
    page.keyboard.press("Escape")
    assert page.evaluate(ends) == [0, 500]


def test_a_job_of_an_earlier_state_is_said_to_be_old(page: Any) -> None:
    shown(page, "transient", lines("time [ms]", "mesh force [kN]", np.arange(3.0), {"sun": np.arange(3.0)}))
    assert page.evaluate("panes.evidence.old.hidden")
    show(page, frames.live(2))
    painted(page, "sweep", 2)
    page.wait_for_function("!panes.evidence.old.hidden")


def test_what_is_compared_with_is_pale_and_zero_is_drawn(page: Any) -> None:
    x = np.linspace(100, 2000, 80)
    curves = {name: 50 + k * np.sin(x / 200) for k, name in enumerate(("linear, largest", "run-up, largest", "least"))}
    shown(page, "contact_loss", lines("speed [rpm]", "mesh force [kN]", x, curves, pale="linear, largest", zero=True))
    colours, low, pale = page.evaluate(
        "[panes.evidence.styles.map((style) => style.colour), panes.evidence.yRange[0], look.look().pale]"
    )
    assert colours.count(pale) == 1
    assert len(set(colours)) == 2  # what is no mesh is in ink, told apart by its dashes
    dashes = page.evaluate("panes.evidence.plot.series.slice(1).map((one) => String(one.dash))")
    assert len({dash for dash, colour in zip(dashes, colours, strict=True) if colour != pale}) == 2
    assert low <= 0
    assert page.locator("#evidence .ck-keys").inner_text().count("linear, largest") == 1
