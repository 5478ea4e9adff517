"""The figure of `modulation`, read back from its data."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest
import xarray as xr

import epicyclic
from epicyclic.show.charts.over_time import modulation


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    faults = {"deviations.sun.run_out": "30 um", "deviations.planet.position.y": "[60, 0, 0, 0] um"}
    return epicyclic.modulation("xu2020", overrides=faults, sensor="90 deg", floor=1e-3)


@pytest.fixture(scope="module")
def drawn(result: xr.Dataset) -> go.Figure:
    return modulation(result)


def test_axes_have_units_and_no_nan(drawn: go.Figure) -> None:
    titles = [axis.title.text for axis in [*drawn.select_xaxes(), *drawn.select_yaxes()]]
    assert len(titles) == 6
    assert all(re.search(r"\[.+\]$", str(title)) for title in titles)
    assert "NaN" not in drawn.to_json()
    assert json.loads(drawn.to_json())["layout"]["title"]["text"]


def test_families_are_named_once_and_coloured_apart(drawn: go.Figure, result: xr.Dataset) -> None:
    legend = [trace for trace in drawn.data if trace.showlegend]
    names = [trace.name for trace in legend]
    assert sorted(names) == sorted([*set(result.family.values), "without deviations"])
    colours = [trace.marker.color for trace in legend if trace.name != "without deviations"]
    assert len(set(colours)) == len(colours)


def test_lines_stand_at_their_orders(drawn: go.Figure, result: xr.Dataset) -> None:
    mine = next(trace for trace in drawn.data if trace.name == "unlike planets" and trace.showlegend)
    order = result.carrier_order.values[result.family.values == "unlike planets"]
    assert sorted(mine.x) == pytest.approx(sorted(order), abs=1e-6)
    assert all("planet.position" in text for text in mine.text)
    rings = next(trace for trace in drawn.data if trace.name == "without deviations" and trace.showlegend)
    assert np.all(np.array(rings.x).round().astype(int) % 4 == 0)  # even planets, 95 teeth: multiples of 4 only


def test_passages_are_marked(drawn: go.Figure, result: xr.Dataset) -> None:
    words = {note.text: note.x for note in drawn.layout.annotations if str(note.text).startswith("planet ")}
    for planet, passage in zip(result.planet.values, result.passage.values, strict=True):
        assert words[f"planet {planet}"] == pytest.approx(passage * result.attrs["carrier_frequency"])


def test_a_star_drive_is_drawn_over_hertz(tmp_path: Path) -> None:
    star = epicyclic.modulation("dong2019", body="housing", floor=1e-2)
    drawn = modulation(star)
    assert {axis.title.text for axis in drawn.select_xaxes()} == {"time [s]", "frequency [Hz]"}
    epicyclic.write_report(tmp_path / "report.html", {"modulation": star})
    assert "Vibration at the ring" in (tmp_path / "report.html").read_text(encoding="utf-8")
