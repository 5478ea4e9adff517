"""What is read first is of operation, names its stage, and hides no curve under another."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.show.console import warnings_of
from epicyclic.show.figures.series import merged
from epicyclic.show.figures.speed_sweep import speed_sweep
from epicyclic.show.report import report
from epicyclic.show.views import key_figures_of, sections_of, tables_of
from epicyclic.verbs.report import TO_MODES, run_report

STAGE: dict[str, Any] = {
    "planets": 3,
    "module": "4 mm",
    "helix_angle": "12 deg",
    "face_width": "50 mm",
    "sun": {"teeth": 24, "support": {"radial": "5e7 N/m"}},
    "planet": {"teeth": 30, "bore": "60 mm", "bearing": {"radial": "4e8 N/m"}},
    "ring": {"teeth": 84, "rim": "25 mm"},
    "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
}
ONE: dict[str, Any] = {
    "format": 1,
    "title": "One stage",
    "damping": {"modal": 0.03},
    "stages": {"main": STAGE},
    "operation": {"held": ["ring"], "speed": {"carrier": "100 rpm"}, "torque": {"carrier": "800 N m"}},
}
TWO: dict[str, Any] = {
    **ONE,
    "title": "Two stages",
    "stages": {"low": STAGE, "high": STAGE},
    "couplings": {"shaft": {"between": ["low.sun", "high.carrier"], "rz": "1e6 N m/rad"}},
    "operation": {
        "held": ["low.ring", "high.ring"],
        "speed": {"low.carrier": "100 rpm"},
        "torque": {"low.carrier": "800 N m"},
    },
}


@cache
def reported() -> dict[str, xr.Dataset]:
    return run_report(ONE)


def headline(result: xr.Dataset) -> str:
    return "; ".join(f"{value} {words}" for value, words in key_figures_of({"it": result})).replace("\u2011", "-")


def test_a_report_sweeps_about_operation_and_to_the_modes() -> None:
    results = reported()
    assert float(results["sweep"].speed.max()) == pytest.approx(1.3)
    assert float(results[TO_MODES].speed.max()) > 5
    titles = [one.title for one in sections_of(results)]
    for title in ("Resonances near operation", "Speed sweep about operation", "Speed sweep to the natural frequencies"):
        assert titles.count(title) == 1
    assert "Resonances near operation" in report(results)


def test_key_figures_of_a_report_are_those_of_operation() -> None:
    results = reported()
    words = "; ".join(words for _, words in key_figures_of(results))
    assert words.count("largest RMS mesh force") == 1
    inside = results["sweep"].mesh_force_rms
    at = int(np.nanargmax(inside.max("mesh").values))
    hertz = f"{float(inside.mesh_frequency.values[at]):.4g} Hz"
    assert f"{hertz}, " in words
    assert "strongest resonance near it" in words
    assert key_figures_of({"sweep": results[TO_MODES]}) == []
    far = [one for one in warnings_of(results[TO_MODES]) if one.startswith("up to ")]
    assert far == [one for one in warnings_of(results[TO_MODES]) if "tensile" in one]


def test_a_figure_from_elsewhere_says_so() -> None:
    swept = epicyclic.sweep(ONE, start="300 %", stop="400 %", points=3)
    assert "outside the operating range" in headline(swept)
    assert "outside" not in headline(epicyclic.sweep(ONE, start="50 %", stop="400 %", points=8))
    assert "largest K_v at the operating speed" in headline(epicyclic.sweep(ONE, points=5))


def test_key_figures_begin_with_a_frequency_and_its_unit() -> None:
    value, words = key_figures_of({"modes": reported()["modes"]})[0]
    assert value.endswith(" Hz")
    assert words.startswith("lowest natural frequency, ")
    count = int((reported()["modes"].frequency.values > 1e-3).sum())
    assert f"; {count} in all, up to " in words


def test_stages_are_named_where_there_are_several() -> None:
    system = epicyclic.assemble(epicyclic.load(TWO))
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
    assert [one.label for one in found] == ["branches 1, 2 L, R (equal)", "branch 3 L, R"]
    assert [one.equal for one in found] == [(1, 2), (3,)]
    assert len(merged(names, values)) == 3


def test_the_figure_of_a_sweep_hides_no_curve() -> None:
    drawn = speed_sweep(reported()["sweep"])
    curves = [trace for trace in drawn.data if trace.yaxis == "y" and trace.name and len(trace.x) > 1]
    assert [trace.name for trace in curves] == ["sun-planet 1, 2, 3 (equal)", "planet-ring 1, 2, 3 (equal)"]
    for trace in curves:
        assert trace.y[-1] > 0


def test_resonances_are_marked_in_a_sweep_about_operation() -> None:
    results = reported()
    drawn = speed_sweep(results["sweep"], results["modes"])
    at = results["modes"].resonance_speed.values * float(results["check"].mesh_frequency[0])
    lines = {round(float(shape.x0), 6) for shape in drawn.layout.shapes if shape.line.dash == "dot"}
    assert 0 < len(lines) <= 8
    assert lines <= {round(float(one), 6) for one in at}
    names = [note.text for note in drawn.layout.annotations if note.text and ", mode " in note.text]
    assert names
    far = speed_sweep(results[TO_MODES], results["modes"])
    assert not [note.text for note in far.layout.annotations if note.text and ", mode " in note.text]


def test_options_name_the_range() -> None:
    assert json.loads(reported()["sweep"].attrs["options"])["speed_range"] == "operation"
    assert json.loads(reported()[TO_MODES].attrs["options"])["speed_range"] == "modes"
