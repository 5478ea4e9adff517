"""What is read first is of operation, names its stage, and hides no curve under another."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.show.charts.over_speed import speed_sweep
from epicyclic.show.console import warnings_of
from epicyclic.show.report import report
from epicyclic.show.series import merged
from epicyclic.show.views import key_figures_of, tables_of
from epicyclic.verbs.record import TO_MODES, run_report


@pytest.fixture(scope="module")
def reported(one_stage: dict[str, Any]) -> dict[str, xr.Dataset]:
    return run_report(one_stage)


def headline(result: xr.Dataset) -> str:
    return "; ".join(f"{value} {words}" for value, words in key_figures_of({"it": result})).replace("\u2011", "-")


def test_a_report_sweeps_about_operation_and_to_the_modes(reported: dict[str, xr.Dataset]) -> None:
    assert float(reported["sweep"].speed.max()) == pytest.approx(1.3)
    assert float(reported[TO_MODES].speed.max()) > 5
    page = report(reported)
    for title in ("Resonances near operation", "Speed sweep about operation", "Speed sweep to the natural frequencies"):
        assert page.count(f"<h2>{title}</h2>") == 1


def test_key_figures_of_a_report_are_those_of_operation(reported: dict[str, xr.Dataset]) -> None:
    words = "; ".join(words for _, words in key_figures_of(reported))
    assert words.count("largest RMS mesh force") == 1
    inside = reported["sweep"].mesh_force_rms
    at = int(np.nanargmax(inside.max("mesh").values))
    hertz = f"{float(inside.mesh_frequency.values[at]):.4g} Hz"
    assert f"{hertz}, " in words
    assert "strongest resonance near it" in words
    assert key_figures_of({"sweep": reported[TO_MODES]}) == []
    far = [one for one in warnings_of(reported[TO_MODES]) if one.startswith("up to ")]
    assert far == [one for one in warnings_of(reported[TO_MODES]) if "tensile" in one]


def test_a_figure_from_elsewhere_says_so(one_stage: dict[str, Any]) -> None:
    swept = epicyclic.sweep(one_stage, start="300 %", stop="400 %", points=3)
    assert "outside the operating range" in headline(swept)
    assert "outside" not in headline(epicyclic.sweep(one_stage, start="50 %", stop="400 %", points=8))
    assert "largest K_v at the operating speed" in headline(epicyclic.sweep(one_stage, points=5))


def test_key_figures_begin_with_a_frequency_and_its_unit(reported: dict[str, xr.Dataset]) -> None:
    value, words = key_figures_of({"modes": reported["modes"]})[0]
    assert value.endswith(" Hz")
    assert words.startswith("lowest natural frequency, ")
    count = int((reported["modes"].frequency.values > 1e-3).sum())
    assert f"; {count} in all, up to " in words


def test_stages_are_named_where_there_are_several(two_stages: dict[str, Any]) -> None:
    system = epicyclic.assemble(epicyclic.load(two_stages))
    swept = epicyclic.sweep(system, relative_speed=[0.9, 1.0])
    sharing = epicyclic.sharing(system)
    for result in (swept, sharing):
        found = headline(result).replace("\u00a0", " ")
        assert "sun-planet" in found or "planet-ring" in found
        assert found.count("-planet ") + found.count("planet-ring ") == found.count("low ") + found.count("high ")
    names = [trace.name for trace in speed_sweep(swept).data if trace.showlegend and trace.name]
    assert {name.split()[0] for name in names} == {"low", "high"}
    assert "mesh frequency of low [Hz]" in speed_sweep(swept).to_json()
    rows = tables_of(epicyclic.modes(system))[1].columns
    assert {order.split()[1] for order in rows["mesh order"]} == {"low", "high"}


def test_equal_branches_share_one_curve_named_for_all() -> None:
    curve = np.linspace(0.0, 1.0, 5)
    names = [f"main/sun-planet/{branch}/{side}" for branch in (1, 2, 3) for side in ("left", "right")]
    values = np.array([curve, curve, curve, curve, 2 * curve, 2 * curve])
    found = merged(names, values, branches=True)
    assert [one.label for one in found] == ["branches 1, 2 L, R alike", "branch 3 L, R"]
    assert [one.equal for one in found] == [(1, 2), (3,)]
    assert len(merged(names, values)) == 3


def test_the_figure_of_a_sweep_hides_no_curve(reported: dict[str, xr.Dataset]) -> None:
    drawn = speed_sweep(reported["sweep"])
    curves = [trace for trace in drawn.data if trace.yaxis == "y" and trace.name and len(trace.x) > 1]
    assert [trace.name for trace in curves] == ["sun-planet 1–3 alike", "planet-ring 1–3 alike"]
    for trace in curves:
        assert trace.y[-1] > 0


def test_resonances_are_marked_in_a_sweep_about_operation(reported: dict[str, xr.Dataset]) -> None:
    drawn = speed_sweep(reported["sweep"], reported["modes"])
    at = reported["modes"].resonance_speed.values * float(reported["check"].mesh_frequency[0])
    lines = {round(float(shape.x0), 6) for shape in drawn.layout.shapes if shape.line.dash == "dot"}
    assert 0 < len(lines) <= 8
    assert lines <= {round(float(one), 6) for one in at}
    names = [note.text for note in drawn.layout.annotations if note.text and ", mode " in note.text]
    assert names
    far = speed_sweep(reported[TO_MODES], reported["modes"])
    assert not [note.text for note in far.layout.annotations if note.text and ", mode " in note.text]


def test_options_name_the_range(reported: dict[str, xr.Dataset]) -> None:
    assert json.loads(reported["sweep"].attrs["options"])["speed_range"] == "operation"
    assert json.loads(reported[TO_MODES].attrs["options"])["speed_range"] == "modes"
