"""Load sharing from mesh cycles spread over the hunting period: even phases, the numbers of the whole, no search."""

from __future__ import annotations

from fractions import Fraction
from math import lcm
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.questions.rating.test_life import train

import epicyclic
from epicyclic import assemble, load
from epicyclic.errors import ModelError
from epicyclic.questions.sharing import SharingOptions
from epicyclic.questions.sharing.definitions import _LOOKED, _recurrences
from epicyclic.questions.sharing.sharing import sharing, spread_sharing
from epicyclic.statics.record import spread_cycles

RUN_OUTS = {
    "deviations.sun.run_out": "20 um",
    "deviations.planet.run_out": "20 um",
    "deviations.ring.run_out": "20 um",
    "deviations.planet.position.y": "[20, 0, 0, 0] um",
}


def _farthest(cycles: np.ndarray, teeth: int) -> float:
    """Largest gap between neighbouring phases of a line with so many cycles a turn [turns]."""
    phases = np.unique(cycles % teeth)
    return float(np.diff(np.append(phases, phases[0] + teeth)).max()) / teeth


@given(st.lists(st.integers(2, 160), min_size=1, max_size=4))
def test_every_line_takes_all_its_phases(teeth: list[int]) -> None:
    cycles = spread_cycles(lcm(*teeth), 1024)
    assert np.all(np.diff(cycles) > 0)
    assert len(cycles) == min(1024, lcm(*teeth))
    for number in teeth:
        assert _farthest(cycles, number) == 1 / number


@pytest.mark.parametrize("period", [25_420, 73_815, 22_287, 139_825, 8_712, 1_048_576, 10**12 + 39])
def test_no_part_of_the_period_is_left_out(period: int) -> None:
    cycles = spread_cycles(period, 1024)
    assert np.diff(np.append(cycles, period)).max() <= 1.6 * period / 1024


def test_a_step_that_divides_the_period_would_leave_a_line_at_one_phase() -> None:
    period = 64 * 81 * 1024
    assert _farthest(np.arange(1024) * (period // 1024), 64) == 1.0  # what an even step does
    assert _farthest(spread_cycles(period, 1024), 64) == 1 / 64


def test_periods_beyond_64_bits_of_products_stay_exact() -> None:
    period = 2**61 - 1
    cycles = spread_cycles(period, 1000)
    assert len(set(cycles.tolist())) == 1000
    assert 0 <= cycles.min() <= cycles.max() < period
    assert _farthest(cycles, period) < 3e-3


@pytest.mark.parametrize(
    ("drive", "overrides"),
    [("ren2021", {}), ("xu2020", RUN_OUTS), ("industrial-stage", {}), ("wind-stage", {}), ("wind-five", {})],
)
def test_the_numbers_are_those_of_sharing(drive: str, overrides: dict[str, Any]) -> None:
    system = assemble(load(drive, overrides))
    whole, spread = sharing(system, SharingOptions(method="static")), spread_sharing(system)
    by_name = {str(name): whole["load_sharing"].sel(definition=name).values for name in whole["definition"].values}
    np.testing.assert_array_equal(spread.mean_load[0], by_name["mean-load"])
    np.testing.assert_array_equal(spread.mean_load[1], by_name["mean-load-turning"])
    # what sampling leaves: at most 2 % of the deviation from equal shares, never more than the whole
    assert np.all(spread.cycle_peak <= by_name["cycle-peak"] + 1e-12)
    np.testing.assert_allclose(spread.cycle_peak - 1, by_name["cycle-peak"] - 1, rtol=0.02, atol=1e-6)
    np.testing.assert_allclose(spread.mean, whole["mesh_force_mean"].values, rtol=2e-4)
    assert spread.quick
    assert spread.period == whole.attrs["hunting_period"]


def test_the_strip_over_the_period_holds_the_largest_of_each_part() -> None:
    spread = spread_sharing(assemble(load("ren2021")))
    strip = spread.over_period(32)
    assert strip.shape == (12, 32)
    np.testing.assert_array_equal(strip.max(axis=1), spread.ratio.max(axis=1))
    first = spread.ratio[:, spread.place[0] < 1 / 32]
    np.testing.assert_array_equal(strip[:, 0], first.max(axis=1))


@pytest.mark.parametrize(
    ("overrides", "patience"),
    [
        ({"stages.main.planet.bearing.clearance": "50 um"}, 0.02),
        ({"stages.main.meshes.sun-planet.stiffness": "contact"}, 0.1),
    ],
)
def test_laws_are_asked_in_few_cycles(overrides: dict[str, Any], patience: float) -> None:
    system = assemble(load("ren2021", overrides))
    spread = spread_sharing(system, patience=patience)
    assert not spread.quick
    assert 4 <= spread.ratio.shape[1] <= 20
    whole = sharing(system, SharingOptions(method="static", cycles=100))["load_sharing"]
    np.testing.assert_array_equal(spread.mean_load[0], whole.sel(definition="mean-load"))
    # cycles from all over the period see more than as many in a row from its beginning
    row = sharing(system, SharingOptions(method="static", cycles=spread.ratio.shape[1]))["load_sharing"].sel(
        definition="cycle-peak"
    )
    peak = float(whole.sel(definition="cycle-peak").max())
    assert spread.cycle_peak.max() - 1 > 1.3 * (float(row.max()) - 1)
    assert spread.cycle_peak.max() == pytest.approx(peak, rel=0.02)
    assert np.all(np.diff(spread.place, axis=1) > 0)
    assert spread.place.min() >= 0
    assert spread.place.max() < 1


def test_a_memory_and_cycles_of_several_lengths_stand_in_a_row() -> None:
    both = spread_sharing(assemble(load("encased-differential")), patience=0.02)
    assert not both.quick
    assert np.isfinite(both.cycle_peak).all()
    play = {"stages.differential.sun.support.clearance": "5 um"}
    lawful = spread_sharing(assemble(load("encased-differential", play)), patience=0.01)
    assert np.isfinite(lawful.cycle_peak).all()
    np.testing.assert_allclose(lawful.place[:, 0], 0.0)


def test_without_a_speed_time_is_counted_in_mesh_cycles() -> None:
    still = assemble(load("ren2021", {"operation.speed": None}))
    spread, whole = spread_sharing(still), sharing(still, SharingOptions(method="static"))
    np.testing.assert_array_equal(spread.mean_load[0], whole["load_sharing"].sel(definition="mean-load").values)
    np.testing.assert_allclose(spread.cycle_peak, whole["load_sharing"].sel(definition="cycle-peak").values)


def test_what_cannot_be_shared_is_refused() -> None:
    with pytest.raises(ModelError, match="needs a load"):
        spread_sharing(assemble(load("lin1999-n3")))
    system = assemble(load("wind-five"))
    with pytest.raises(ModelError, match="cycles = 0"):
        epicyclic.sharing(system, cycles=0)


def test_a_common_period_shorter_than_what_is_asked_for_is_passed_once() -> None:
    """With laws every instant is solved by itself, of no more cycles than the common period has."""
    model = train()
    model["deviations"] = {"planet": {"run_out": ["5 um", 0, 0]}}
    system = assemble(load(model))
    spread = spread_sharing(system, patience=1.0)
    whole = sharing(system, SharingOptions(method="static"))["load_sharing"].sel(definition="cycle-peak")
    assert spread.ratio.shape[1] == spread.period
    np.testing.assert_allclose(spread.cycle_peak, whole.values, rtol=1e-3)  # of fewer instants a cycle


def test_phases_of_a_long_block_follow_each_other_by_the_finest() -> None:
    ratios = (Fraction(1, 7), Fraction(2, 29))
    ((step, moved),) = _recurrences(ratios, (0, 1), _LOOKED + 1)
    assert step == 1
    assert moved == pytest.approx(1 / 29)
