"""Which sidebands are there: the five groups of [inalpolat2009], the asymmetry of [mcfadden1985], run-outs, errors."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
import xarray as xr

from epicyclic.questions.modulation import ModulationOptions
from epicyclic.questions.modulation.modulation import modulation
from epicyclic.questions.modulation.spectrum import (
    SensorContributions,
    SensorPosition,
    StageSpectrum,
    merged_lines,
    named_window,
    windowed_forces,
)
from epicyclic.questions.response import SteadyOptions
from epicyclic.questions.response.steady import steady
from epicyclic.system.system import System

from .conftest import GROUPS, every_line

Make = Callable[..., System]
NOTHING = SensorContributions(row=np.zeros(0, np.int64), order=np.zeros(0, np.int64), amplitude=np.zeros(0, complex))
# What should vanish cancels among planets solved alike: rounding, 1e-14 of the largest line, with a margin.
GONE = 1e-10


def angles(group: str) -> list[float]:
    (sun, _, ring), places = GROUPS[group]
    if isinstance(places, int):
        return [2 * math.pi * i / places for i in range(places)]
    return [2 * math.pi * place / (sun + ring) for place in places]


def spread(group: str, order: int) -> float:
    """|sum over planets of exp(i order psi)|: what identical planets leave of a line at an order of the carrier."""
    return abs(sum(cmath.exp(1j * order * psi) for psi in angles(group)))


def by_order(result: xr.Dataset) -> dict[int, float]:
    """Amplitudes by whole order of the carrier."""
    orders = result.carrier_order.values
    return {round(o): float(abs(a)) for o, a in zip(orders, result.signal_amplitude.values, strict=True)}


@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("turn", [Fraction(4), Fraction(-4)])
def test_closed_form_of_planets_that_are_alike(group: str, turn: Fraction) -> None:
    psi, ring = np.array(angles(group)), GROUPS[group][0][2]
    window, most = named_window("cos6", planets=len(psi)), 3
    sense = 1 if turn > 0 else -1
    orders = np.arange(1, most + 1)
    rows = StageSpectrum(
        unit=1,
        carrier=int(turn),
        step=np.array([order * ring * abs(int(turn)) for order in orders.tolist()], dtype=np.object_),
        shaft=np.full(most, -1),
        point=orders[:, None],
        force=np.exp(1j * sense * np.outer(psi, orders * ring)),
        motion=np.zeros((6, most), complex),
    )
    place = SensorPosition(
        stage="main", bodies=(), turn=turn, angle=1.1, meshes=np.arange(len(psi)), share=np.ones(len(psi)), contact=psi,
        branches=tuple(range(1, len(psi) + 1)), spacing=psi, teeth=-sense * ring,
    )  # fmt: skip
    lines = merged_lines(rows, windowed_forces(rows, place, window), NOTHING)
    found = dict(zip(lines.frequency, np.abs(lines.force), strict=True))
    for order in orders.tolist():
        for k in range(-3, 4):
            expected = abs(window.sides[3 + k]) * spread(group, order * ring + k)
            at = Fraction(order * ring + k) * abs(turn)
            assert found.get(at, 0.0) == pytest.approx(expected, abs=1e-12)  # sums of a few numbers of size 1


@pytest.mark.parametrize("group", GROUPS)
def test_lines_follow_from_the_mesh_forces(group: str, system_of: Make) -> None:
    """Whatever the forces are: the harmonics of `steady` through the window, summed by hand."""
    system = system_of(group)
    result = modulation(system, ModulationOptions(window="cos4", sensor=0.7, floor=0.0))
    forces = steady(system, SteadyOptions()).mesh_force_harmonic
    ring = forces.values[["planet-ring" in str(name) for name in forces.mesh.values]]
    teeth, sides = GROUPS[group][0][2], named_window("cos4", planets=1).sides
    away, found = np.array(angles(group)) - 0.7, by_order(result)
    largest = max(found.values())
    for order in (1, 2, 3):
        for k in range(-2, 3):
            expected = abs(sides[2 + k] * np.sum(ring[:, order] * np.exp(1j * k * away)))
            assert found.get(order * teeth + k, 0.0) == pytest.approx(expected, rel=1e-9, abs=1e-12 * largest)


@pytest.mark.parametrize("group", ["even, in phase", "even, in sequence"])
def test_even_planets_leave_multiples_of_their_number(group: str) -> None:
    found = by_order(every_line(group))
    planets = len(angles(group))
    largest = max(found.values())
    # the suppressed ones are there as numbers and are zero
    assert max(a for order, a in found.items() if order % planets) < GONE * largest
    assert min(found[order] for order in found if order % planets == 0 and abs(order - 96) < 9) > 1e-3 * largest


def test_in_phase_the_mesh_line_dominates_and_sidebands_are_symmetric() -> None:
    found = by_order(every_line("even, in phase"))
    near = {order: a for order, a in found.items() if abs(order - 96) <= 9}
    assert max(near, key=near.__getitem__) == 96
    assert found[96 + 3] == pytest.approx(found[96 - 3], rel=1e-4)  # but for the other mesh orders' far sidebands
    assert found[96] == pytest.approx(2 * found[96 + 3], rel=1e-4)  # a Hann window over 1/N has c_N = c_0 / 2
    # and no other multiple of N: windows shifted by 1/N add up to one
    assert max(found.get(96 + k, 0.0) for k in (-9, -6, 6, 9)) < 1e-3 * found[96]


def test_in_sequence_the_mesh_line_vanishes_and_sidebands_are_one_sided() -> None:
    """95 teeth, 4 planets: 95 + 1 and 95 - 3 are multiples of 4, the nearest is above."""
    found = by_order(every_line("even, in sequence"))
    largest = max(found.get(order, 0.0) for order in range(85, 106))
    assert found[95] < GONE * largest
    assert found[96] == largest
    sides = named_window("hann", planets=4).sides
    middle = len(sides) // 2
    # both come from the same mesh order: their ratio is that of the window
    assert found[92] / found[96] == pytest.approx(abs(sides[middle - 3] / sides[middle + 1]), rel=1e-4)
    # 380 is a multiple of 4: the fourth order is in phase
    assert found[4 * 95] > 1e-2 * largest > 1e4 * max(found[4 * 95 + 1], found[4 * 95 - 1])


def test_uneven_in_phase_keeps_the_mesh_line_and_has_every_sideband() -> None:
    found = by_order(every_line("uneven, in phase"))
    near = {order: found.get(order, 0.0) for order in range(90, 103)}
    assert max(near, key=near.__getitem__) == 96
    assert min(near[order] for order in range(93, 100)) > 1e-2 * near[96]


def test_opposite_pairs_leave_even_orders() -> None:
    found = by_order(every_line("uneven, in opposite phase"))
    largest = max(found.values())
    assert found[95] < GONE * largest  # the mesh line is suppressed although planets are uneven
    assert max(a for order, a in found.items() if order % 2) < GONE * largest
    assert min(found[94], found[96]) > 1e-2 * max(found.get(order, 0.0) for order in range(85, 106))
    assert found[94] != pytest.approx(found[96], rel=1e-3)


def test_any_phase_has_everything_and_no_symmetry() -> None:
    found = by_order(every_line("uneven, in any phase"))
    near = [found[order] for order in range(92, 99)]
    assert min(near) > 1e-3 * max(near)
    assert found[94] != pytest.approx(found[96], rel=0.1)


def test_families_of_trains_as_drawn(system_of: Make) -> None:
    for group in GROUPS:
        result = modulation(system_of(group), ModulationOptions(floor=1e-5))
        families = set(result.family.values)
        wanted = {"mesh", "planets passing"} | (set() if group.startswith("even") else {"uneven planets"})
        assert families == wanted, group
        causes = {family: set(result.causes.values[result.family.values == family]) for family in wanted}
        assert all(text.startswith("tooth meshing") for text in causes["mesh"])
        assert all(text.startswith("fault-free: planets passing") for text in causes["planets passing"])
        amplitude, healthy = np.abs(result.signal_amplitude.values), np.abs(result.fault_free_amplitude.values)
        assert healthy == pytest.approx(amplitude, rel=1e-9)  # nothing to leave out: solved twice alike


def test_a_pin_out_of_place_fills_the_gaps_and_is_named(system_of: Make) -> None:
    system = system_of("even, in sequence", {"deviations.planet.position.y": "[30, 0, 0, 0] um"})
    result = modulation(system, ModulationOptions(floor=1e-4))
    unlike = result.isel(line=result.family.values == "unlike planets")
    assert unlike.sizes["line"] > 10
    assert all("deviations.main.planet.position" in text for text in unlike.causes.values)
    assert all(order % 4 for order in unlike.carrier_order.values.round().astype(int))
    assert np.abs(unlike.fault_free_amplitude.values).max() < GONE * float(np.abs(result.signal_amplitude).max())
    passing = result.isel(line=result.family.values == "planets passing")
    assert all("position" not in text for text in passing.causes.values)


def test_sun_run_out_stands_at_the_predicted_orders(system_of: Make) -> None:
    """Even planets: f_sun + j N f_carrier beside any mesh order, exactly; the sun as seen from the housing."""
    system = system_of("even, in sequence", {"deviations.sun.run_out": "20 um"})
    result = modulation(system, ModulationOptions(floor=0.0))
    sun, carrier = (
        dict(zip(system.dofs.bodies, system.body_turns, strict=True))[f"main/{m}"] for m in ("sun", "carrier")
    )
    assert carrier == sun * Fraction(21, 116)
    mine = result.isel(line=result.family.values == "sun run-out")
    largest = float(np.abs(mine.signal_amplitude).max())
    allowed: list[float] = []
    others: list[float] = []
    for text, amplitude in zip(mine.exact_frequency.values, np.abs(mine.signal_amplitude.values), strict=True):
        orders = [(Fraction(text) - sign * sun) / carrier / 4 for sign in (1, -1)]
        (allowed if any(order.denominator == 1 for order in orders) else others).append(amplitude)
    assert len(allowed) > 50
    assert max(others) < GONE * largest
    assert largest > 1.0  # [N]
    assert set(mine.causes.values) == {"deviations.main.sun.run_out"}
    strongest = str(mine.line.values[np.abs(mine.signal_amplitude.values).argmax()])
    assert strongest in ("sun run-out + 1 x carrier", "1 x mesh + sun run-out", "3 x carrier - sun run-out")


def test_planet_run_out_is_named_by_its_path_and_label(system_of: Make) -> None:
    result = modulation(
        system_of("even, in phase", {"deviations.planet.run_out": "[20, 0, 0] um"}), ModulationOptions(floor=1e-5)
    )
    mine = result.isel(line=result.family.values == "planet run-out")
    assert set(mine.causes.values) == {"deviations.main.planet.run_out"}
    f_mesh, f_carrier = (
        Fraction(result.attrs[k]).limit_denominator(10**6) for k in ("stage_mesh_frequency", "carrier_frequency")
    )
    for label, text in zip(mine.line.values, mine.exact_frequency.values, strict=True):
        terms = re.findall(r"([+-]?) ?(?:(\d+) x )?(mesh|carrier|planet run-out)", str(label))
        size = {"mesh": f_mesh, "carrier": f_carrier, "planet run-out": f_mesh / 36}
        total = sum((-1 if sign == "-" else 1) * int(count or 1) * size[name] for sign, count, name in terms)
        assert total == Fraction(text), label


def test_measured_pitch_has_its_orders_in_the_labels(system_of: Make) -> None:
    turn = 2 * np.pi * np.arange(24) / 24
    samples = tuple((3e-6 * np.cos(2 * turn) + 2e-6 * np.cos(3 * turn)).tolist())
    system = system_of("even, in phase", {"deviations.sun.pitch": samples})
    families = {str(name) for name in modulation(system, ModulationOptions(floor=1e-6)).family.values}
    assert {"2 x sun pitch", "3 x sun pitch"} <= families


def test_ring_run_out_and_mesh_share_lines_and_causes(system_of: Make) -> None:
    """The ring stands still: its run-out turns backwards with the carrier's speed in the stage, on the same orders."""
    result = modulation(
        system_of("even, in phase", {"deviations.ring.run_out": "30 um"}), ModulationOptions(floor=1e-6)
    )
    assert all(order == round(order) for order in result.carrier_order.values.round(9))
    both = [text for text in result.causes.values if "ring.run_out" in text and "fault-free" in text]
    assert both


def test_uneven_planets_and_a_pin_are_distinguished(system_of: Make) -> None:
    """Opposite pairs leave even orders only: what stands at odd ones is the pin's, although the planets are uneven."""
    changes = {"deviations.planet.position.y": "[40, 0, 0, 0] um"}
    result = modulation(system_of("uneven, in opposite phase", changes), ModulationOptions(floor=1e-4))
    odd = result.carrier_order.values.round().astype(int) % 2 == 1
    assert odd.any()
    assert set(result.family.values[odd]) == {"unlike planets"}
    assert all("planet.position" in text for text in result.causes.values[odd])
    assert "uneven planets" in set(result.family.values[~odd])


def test_weight_is_no_fault(system_of: Make) -> None:
    result = modulation(system_of("even, in phase", {"operation.gravity": True}), ModulationOptions(floor=1e-8))
    mine = result.isel(line=result.family.values == "gravity")
    assert mine.sizes["line"]
    amplitude, healthy = np.abs(mine.signal_amplitude.values), np.abs(mine.fault_free_amplitude.values)
    assert healthy == pytest.approx(amplitude, rel=1e-9)
    assert set(mine.causes.values) == {"operation.gravity"}
