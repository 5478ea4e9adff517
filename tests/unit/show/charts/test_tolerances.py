"""Figures and tables of tolerances, read back from their data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import xarray as xr

from epicyclic.questions.tolerance.views import allocate_tables, tolerance_findings, tolerance_tables
from epicyclic.show.charts.sharing import (
    grade_prices,
    k_gamma_by_design,
    k_gamma_by_tolerance,
    k_gamma_histogram,
    tolerance_shares,
    worst_branches,
)
from epicyclic.show.elements import Table
from epicyclic.show.series import even_bins, pair_labels, percent, short_entries
from epicyclic.show.views import key_figures_of, tables_of

Datasets = dict[str, xr.Dataset]
POSITION = "deviations.main.planet.position.y"


@pytest.fixture
def result(ren: Datasets) -> xr.Dataset:
    return ren["tolerance"]


@pytest.fixture
def grades(ren: Datasets) -> xr.Dataset:
    return ren["allocate"]


def words(drawn: object) -> list[str]:
    return [str(one.text) for one in drawn.layout.annotations]  # type: ignore[attr-defined]


def table(found: Sequence[Table], title: str) -> Table:
    return next(one for one in found if one.title.startswith(title))


def test_the_histogram_holds_every_sample_and_marks_the_quantiles(result: xr.Dataset) -> None:
    drawn = k_gamma_histogram(result)
    bars, turning = drawn.data
    inside = result.system_histogram.values[0].sum() / 4096
    assert sum(bars.y) == pytest.approx(100 * inside, abs=0.2)  # but for a thousandth at the ends
    assert turning.name == "largest while turning"
    assert sum(turning.y) == pytest.approx(100 * result.system_histogram.values[1].sum() / 4096, abs=0.2)
    quantiles = result.system_k_gamma_quantile.sel(definition="mean-load", probability=[0.5, 0.95, 0.99]).values
    solid = sorted(shape.x0 for shape in drawn.layout.shapes if shape.line.dash == "solid")
    assert solid == pytest.approx(sorted(quantiles))
    low, high = drawn.layout.xaxis.range
    inside = [limit for limit in result.limit.values if low < limit < high]
    assert [shape.x0 for shape in drawn.layout.shapes if shape.line.dash == "dot"] == pytest.approx(inside)
    assert [text for text in words(drawn) if text.startswith("99")] == [f"{percent(0.99)}: {quantiles[2]:.3f}"]
    assert f"{quantiles[1]:.3f} in {percent(0.95)}" in drawn.layout.title.text


@pytest.mark.parametrize(
    ("limit", "words"), [(0.5, "; limit 0.5 lies below"), (9.5, "; limit 9.5 lies above"), (None, "")]
)
def test_a_limit_out_of_the_picture_is_told(result: xr.Dataset, limit: float | None, words: str) -> None:
    limit = limit or float(result.system_k_gamma_quantile.sel(definition="mean-load", probability=0.95))
    moved = result.isel(limit=[0]).assign_coords(limit=[limit])
    drawn = k_gamma_histogram(moved)
    low, high = drawn.layout.xaxis.range
    assert (low < limit < high) == (not words)
    assert str(drawn.layout.title.text).partition("of the trains")[2] == words


def test_lines_of_tables_are_those_the_user_gave(result: xr.Dataset) -> None:
    assert not any(shape.line.dash == "dash" for shape in k_gamma_histogram(result).layout.shapes)
    given = result.assign(reference_k_gamma=("reference", [1.9])).assign_coords(reference=["our standard, 5 planets"])
    drawn = k_gamma_histogram(given)
    (line,) = (shape for shape in drawn.layout.shapes if shape.line.dash == "dash")
    assert line.x0 == 1.9
    assert "our standard, 5 planets: 1.9" in words(drawn)
    assert drawn.layout.xaxis.range[1] > 1.9  # in the picture


def test_even_bins_share_out_the_counts_by_width() -> None:
    edges, counts = np.array([0.0, 1.0, 3.0]), np.array([6.0, 2.0])
    centres, share = even_bins(edges, counts, 0.0, 3.0, 6)
    assert centres == pytest.approx([0.25, 0.75, 1.25, 1.75, 2.25, 2.75])
    assert share == pytest.approx(np.array([3, 3, 0.5, 0.5, 0.5, 0.5]) / 8)


def test_curves_stand_in_the_order_of_their_rise(result: xr.Dataset) -> None:
    drawn = k_gamma_by_tolerance(result)
    assert words(drawn)[:3] == ["planet position y", "planet run-out", "planet tooth-gap"]
    values = result.k_gamma_by_scale.sel(probability=0.99).values
    shown = [trace.y for trace in drawn.data if trace.name == percent(0.99)]
    assert np.array(shown) == pytest.approx(values, abs=1e-5)
    # a tolerance without effect has no panel, and is named
    flat = result.copy()
    flat["k_gamma_by_scale"] = flat.k_gamma_by_scale.copy()
    flat.k_gamma_by_scale[1] = flat.k_gamma_by_scale[1, 3]
    assert "hardly any effect: planet run-out" in words(k_gamma_by_tolerance(flat))


def test_design_panels_leave_out_what_the_result_has_not(result: xr.Dataset) -> None:
    drawn = k_gamma_by_design(result)
    assert words(drawn) == ["torque", "support of sun", "number of planets"]
    assert [axis.type for axis in drawn.select_xaxes()] == [None, "log", None]
    assert [axis.title.text for axis in drawn.select_xaxes()][1] == "stiffness [N/m]"
    assert words(k_gamma_by_design(result.drop_vars("k_gamma_by_support"))) == ["torque", "number of planets"]
    # numbers of planets that do not fit are nan, and no points
    some = result.copy(deep=True)
    some.k_gamma_by_planets[3:] = np.nan
    planets = k_gamma_by_design(some).data[-1]
    assert list(planets.x) == [3, 4, 5]


def test_the_headline_says_what_a_tenth_less_takes_off(result: xr.Dataset) -> None:
    value = result.system_tenth_less.sel(definition="mean-load", probability=0.99).values
    (said,) = [one.change for one in tolerance_findings(result, {}) if one.change]
    band = f"{value[0]:.5f} [{value[0] - 1e-4:.5f}, {value[0] + 1e-4:.5f}]"
    assert said == f"A tenth less spread of planet position y ({band}) takes most off K_gamma at {percent(0.99)}."
    tied = result.assign(tenth_less_place=("tolerance", [1, 1, 3]), tenth_less_last_place=("tolerance", [2, 2, 3]))
    (said,) = [one.change for one in tolerance_findings(tied, {}) if one.change]
    assert " or planet run-out (" in said
    assert said.endswith("; they are not told apart at 4096 samples.")
    assert table(tolerance_tables(tied), "What buys what").columns["place"] == ["1-2", "1-2", "3"]


def test_below_its_limit_nothing_is_to_be_tightened(result: xr.Dataset) -> None:
    for limit, words in ((9.0, "Nothing to tighten: K_gamma at 99"), (1.01, "A tenth less spread of planet")):
        held = result.assign(k_gamma_limit=("pair", [limit] * 2), k_gamma_limit_source=("pair", ["limits.k_gamma"] * 2))
        (said,) = [one.change for one in tolerance_findings(held, {}) if one.change]
        assert said.startswith(words)


def test_a_fall_that_no_sample_tells_is_no_advice(result: xr.Dataset) -> None:
    unsure = result.copy(deep=True)
    unsure["system_tenth_less_high"][:] = 1e-3
    (said,) = [one.change for one in tolerance_findings(unsure, {}) if one.change]
    assert "takes nothing off" in said


def test_shares_are_said_with_their_bands_and_that_they_overlap(result: xr.Dataset) -> None:
    over = result.copy(deep=True)
    over["sobol_total"][:, :, 0], over["sobol_first"][:, :, 2] = 1.09, -0.004
    buys = table(tolerance_tables(over), "What buys what")
    assert buys.columns["with interactions [%]"][0].startswith("about all [")
    assert buys.columns["alone [%]"][2].startswith("about none [")
    assert buys.columns["alone [%]"][0] == "52.0 [49.0, 55.0]"
    assert "109" not in str(buys.columns)
    assert "overlap: with interactions they add up to 154 %" in buys.lead
    noise = over.assign(sobol_total_low=0.5 * over.sobol_total)  # what they add up to beyond 100 % may be noise
    assert "do not overlap beyond their bands" in table(tolerance_tables(noise), "What buys what").lead


def test_shares_and_slopes_have_their_units_and_bands(result: xr.Dataset) -> None:
    drawn = tolerance_shares(result)
    taken, total, first, slope = drawn.data
    assert list(total.y)[-1] == "planet position y"  # the largest at the top
    exact = result.system_tenth_less.sel(definition="mean-load", probability=0.99).values[::-1]
    assert list(taken.x) == pytest.approx(-exact, rel=1e-3)
    assert list(taken.error_x.array) == pytest.approx([1e-4] * 3)
    assert list(total.x) == pytest.approx([12, 33, 76])
    assert list(first.x) == pytest.approx([4, 16, 52])
    for bars, half in ((total, 2), (first, 3)):
        assert list(bars.error_x.array) == list(bars.error_x.arrayminus) == pytest.approx([half] * 3)
    exact = result.quantile_slope.sel(definition="mean-load", probability=0.99).isel(pair=0).values[::-1]
    assert list(slope.x) == pytest.approx(1e-6 * exact, rel=1e-3)
    # a stiffness has no slope per micrometre
    stiff = result.assign(tolerance_unit=("tolerance", ["m", "N/m", "m"]))
    assert [x is None for x in tolerance_shares(stiff).data[3].x] == [False, True, False]


def test_the_worst_sample_shows_every_branch(result: xr.Dataset) -> None:
    drawn = worst_branches(result)
    sun, ring = drawn.data
    assert list(sun.x) == list(ring.x) == ["1", "2", "3", "4", "5"]
    assert max(sun.y) == pytest.approx(float(result.worst_k_gamma[0]), abs=1e-4)
    assert sum(sun.y) == pytest.approx(5, abs=1e-3)


def test_grades_stand_at_their_prices(grades: xr.Dataset) -> None:
    drawn = grade_prices(grades)
    points = {trace.name: trace for trace in drawn.data}
    assert (points["the grades found"].x, points["the grades found"].y) == ((82.0,), (1.147,))
    finer, coarser = points["one grade finer"], points["one grade coarser"]
    assert (list(finer.x), list(finer.text)) == ([142.0, 100.0], ["planet position y", "planet run-out"])
    assert (list(coarser.x), list(coarser.y)) == ([60.0, 68.0], [1.221, 1.163])
    assert "as drawn" not in points  # a grade of the drawing has no price
    assert "as drawn" in {trace.name for trace in grade_prices(grades.assign(drawn_price=90.0)).data}


def test_names_of_entries_and_pairs() -> None:
    paths = [POSITION, "operation.torque.main.sun", "stages.main.planet.bearing.radial"]
    assert short_entries(paths) == ["planet position y", "torque sun", "planet bearing radial"]
    assert short_entries([POSITION, "deviations.second.sun.run_out"]) == [
        "main planet position y",
        "second sun run-out",
    ]
    assert pair_labels(["main.meshes.sun-planet.left", "main.meshes.planet-ring"]) == ["sun-planet L", "planet-ring"]
    assert pair_labels(["a.meshes.x-y", "b.meshes.x-y"]) == ["a x-y", "b x-y"]


def test_the_terminal_says_quantiles_with_bands_and_what_buys_what(result: xr.Dataset) -> None:
    found = tolerance_tables(result)
    quantiles = table(found, "Mesh-load factor")
    value = float(result.system_k_gamma_quantile.sel(definition="mean-load", probability=0.99))
    cell = quantiles.columns[percent(0.99)][0]
    assert cell == f"{value:.4f} [{1 + 0.98 * (value - 1):.4f}, {1 + 1.02 * (value - 1):.4f}]"
    often = table(found, "How often")
    share = float(result.system_exceedance.sel(definition="mean-load", limit=1.15))
    assert often.columns["event"][0] == "K_gamma above 1.15"
    assert often.columns["share of the trains [%]"][0] == pytest.approx(100 * share)
    buys = table(found, "What buys what")
    assert buys.columns["tolerance"][0] == POSITION
    tenth = float(result.system_tenth_less.sel(definition="mean-load", probability=0.99)[0])
    assert buys.columns[f"a tenth less spread, K_gamma at {percent(0.99)}"][0].startswith(f"{tenth:.5f} [")
    figures = {words: value for value, words in key_figures_of({"tolerance": result})}
    assert figures[f"K_gamma not exceeded in {percent(0.99)} of the trains"] == f"{value:.3f}"


def test_the_terminal_says_what_the_next_grade_costs_and_saves(grades: xr.Dataset) -> None:
    found = tables_of(grades)
    steps = table(found, "One grade")
    assert steps.columns["next finer"] == ["normal(0, 3 um)", "rayleigh(5 um)", ""]
    assert steps.columns["costs"][:2] == [60.0, 18.0]
    assert steps.columns["loses"] == ["1.2210", "", "1.1630"]
    totals = table(found, "Totals")
    assert "82: no grades that meet the target cost less (proven" in totals.columns["value"][1]
    unproven = table(allocate_tables(grades.assign_attrs(proof="open")), "Totals")
    assert "cheaper grades may be left" in unproven.columns["value"][1]


def test_pairs_that_scatter_alike_are_told_apart_by_rule_not_by_rounding(result: xr.Dataset) -> None:
    two = result.isel(pair=[0, 0]).assign_coords(pair=["main.meshes.sun-planet", "main.meshes.planet-ring"])
    for rounding in (-1e-12, 1e-12):
        two["k_gamma_std"] = result.k_gamma_std.isel(pair=[0, 0]).drop_vars("pair") * [1, 1 + rounding]
        assert "of K_gamma, sun-planet," in table(tolerance_tables(two), "What buys what").lead
        assert "share of the variance, sun-planet" in words(tolerance_shares(two))
