"""One pair of gears in contact: balance, limits, symmetry, linearity, refinement, pressures, stiffness."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.errors import ModelError
from epicyclic.teeth import gear_pair
from epicyclic.teeth.contact_solver import solve_hertzian
from epicyclic.teeth.form import PLAIN, Flank, Relief
from epicyclic.teeth.gear_pair import ContactPair, Torsion
from epicyclic.teeth.loaded_contact import harmonics, loaded_contact, loaded_segments
from epicyclic.teeth.segments import contact_segments, microgeometry_gaps

Build = Callable[..., ContactPair]
Array = NDArray[np.float64]
PHASES = np.arange(24) / 24 + 1e-3
KINDS: list[dict[str, Any]] = [{}, {"helix": 15.0}, {"teeth_b": 89, "internal": True, "helix": 10.0}]
WORN = Flank(crown=8e-6, slope=-6e-6, tip_relief=Relief(amount=12e-6, length=1.2e-3, shape="parabolic"))


@pytest.mark.parametrize("kind", KINDS)
def test_forces_balance_and_push(pair_of: Build, kind: dict[str, Any]) -> None:
    found = loaded_contact(pair_of(**kind, flank_a=WORN, misalignment=4e-4), [0.0, 1.0, 3e3, 3e4], PHASES)
    asked = np.array([0.0, 1.0, 3e3, 3e4])[:, None]
    assert np.abs(found.force.sum(axis=(2, 3)) - asked).max() <= 1e-9 * 3e4
    assert found.force.min() >= 0
    assert found.residual.max() < 1e-12  # conditions of contact, relative
    assert set(found.status.ravel()) == {""}
    assert found.share[1:].sum(axis=2) == pytest.approx(1.0, rel=1e-9)
    assert np.isfinite(found.tangent).all()
    assert np.isfinite(found.secant).all()
    assert np.isfinite(found.mean_pressure).all()


@pytest.mark.parametrize("kind", KINDS[:2])
def test_swapping_the_gears_changes_nothing(pair_of: Build, kind: dict[str, Any]) -> None:
    pair = pair_of(**kind, flank_a=WORN, misalignment=4e-4, face_a=(-16e-3, 14e-3))
    plane = pair.plane
    other = replace(
        pair,
        plane=replace(
            plane,
            base_a=plane.base_b,
            base_b=plane.base_a,
            limits=(-plane.limits[1], -plane.limits[0]),
            lean=-plane.lean,
            face_a=plane.face_b,
            face_b=plane.face_a,
        ),
        tooth_a=pair.tooth_b,
        tooth_b=pair.tooth_a,
        flank_a=pair.flank_b,
        flank_b=pair.flank_a,
    )
    ours, theirs = loaded_contact(pair, [8e3], PHASES), loaded_contact(other, [8e3], -PHASES)
    assert theirs.approach == pytest.approx(ours.approach, rel=1e-9)
    assert theirs.tangent == pytest.approx(ours.tangent, rel=1e-7)
    assert theirs.corner == pytest.approx(ours.corner[:, ::-1], rel=1e-6, abs=1e-12)


def test_spur_is_the_limit_of_a_small_helix(pair_of: Build) -> None:
    spur, nearly = loaded_contact(pair_of(), [8e3], PHASES), loaded_contact(pair_of(helix=1e-4), [8e3], PHASES)
    # 1e-4 deg moves the ends of the face by 1e-6 base pitches; no phase is nearer to an end of the path
    assert nearly.approach == pytest.approx(spur.approach, rel=1e-5)
    assert nearly.tangent == pytest.approx(spur.tangent, rel=1e-5)


def test_error_is_linear_in_the_load_where_contact_is(pair_of: Build) -> None:
    pair = pair_of(helix=15.0, linear_at=3e5)
    found = loaded_contact(pair, [2e3, 4e3, 8e3], PHASES)
    assert found.approach[1] == pytest.approx(2 * found.approach[0], rel=1e-12)
    assert found.approach[2] == pytest.approx(4 * found.approach[0], rel=1e-12)
    assert found.secant[2] == pytest.approx(found.tangent[0], rel=1e-10)
    solve_hertzian = loaded_contact(replace(pair, linear_at=None), [2e3, 8e3], PHASES)
    assert (solve_hertzian.approach[1] < 4 * solve_hertzian.approach[0]).all()  # flanks stiffen


def test_limits_of_no_load_and_no_relief(pair_of: Build) -> None:
    pair = pair_of(helix=15.0, flank_a=WORN, misalignment=4e-4)
    found = loaded_contact(pair, [0.0, 1e-3], PHASES)
    gap = found.segments.gap
    touched = np.where(found.segments.valid, gap, np.inf).min(axis=1)
    assert (found.approach[0] == touched).all()
    assert (found.no_load == touched).all()
    # a thousandth of a newton moves teeth of 1e8 N/m by far less than a nanometre
    assert found.approach[1] == pytest.approx(touched, abs=1e-10)
    plain = loaded_contact(replace(pair, flank_a=PLAIN, misalignment=0.0), [8e3], PHASES)
    none = Flank(tip_relief=Relief(amount=0.0, length=1e-3), root_relief=Relief(amount=0.0, length=1e-3))
    still = loaded_contact(replace(pair, flank_a=none, flank_b=none, misalignment=0.0), [8e3], PHASES)
    assert (still.approach == plain.approach).all()


def test_relief_as_deep_as_the_deflection_takes_the_step_away(pair_of: Build) -> None:
    pair = pair_of(slices=3)
    before, behind = pair.plane.limits[0] - 1e-7, pair.plane.limits[0] + 1e-7  # a pair comes into mesh between them
    plain = loaded_contact(pair, [9e3], [before, behind])
    step = float(plain.approach[0, 0] - plain.approach[0, 1])
    amount = float(plain.approach[0, 0])
    assert step > 0.3 * amount
    relieved = replace(pair, flank_b=Flank(tip_relief=Relief(amount=amount, length=1e-3)))
    found = loaded_contact(relieved, [9e3], [before, behind])
    assert found.approach[0, 0] == pytest.approx(amount, rel=1e-12)  # the pair that bears is not relieved there
    assert abs(found.approach[0, 0] - found.approach[0, 1]) < 1e-3 * step  # the relief has faded by 1e-7 base pitches
    assert found.corner[0, 0] < 1e-3 * amount
    deeper = loaded_contact(
        replace(pair, flank_b=Flank(tip_relief=Relief(amount=0.5 * amount, length=1e-3))), [9e3], [before]
    )
    assert deeper.corner[0, 0] == pytest.approx(0.5 * amount, rel=1e-3)


def test_tips_that_bear_smooth_the_step(pair_of: Build) -> None:
    pair = pair_of(slices=1)
    phases = np.arange(200) / 200
    plain, corner = (loaded_contact(replace(pair, corner=bear), [9e3], phases) for bear in (False, True))
    jump = [np.abs(np.diff(found.approach[0])).max() for found in (plain, corner)]
    assert jump[1] < 0.3 * jump[0]
    assert (corner.approach <= plain.approach * (1 + 1e-12)).all()  # more contact, less deflection
    assert (corner.corner == 0).all()
    assert plain.corner.max() > 0


def test_refining_slices(pair_of: Build) -> None:
    pair = pair_of(helix=15.0, width=40e-3, flank_a=Flank(crown=10e-6))
    counts = np.array([5, 10, 20, 40])
    found = [loaded_contact(replace(pair, slices=n), [8e3], PHASES).approach[0] for n in (*counts, 240)]
    errors = np.array([np.abs(one - found[-1]).max() / found[-1].mean() for one in found[:-1]])
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.2)  # midpoints of segments: second order
    assert errors[2] < 2e-3  # what the default of 20 segments costs


@pytest.mark.parametrize("kind", KINDS)
def test_shared_compliance_is_reciprocal_and_positive(pair_of: Build, kind: dict[str, Any]) -> None:
    twisted = {"torsion_a": Torsion(rigidity=1e4, end="left")}
    for more in ({}, twisted):
        segments = contact_segments(pair_of(**kind, **more), PHASES[:6])
        C = segments.compliance
        assert np.abs(C - np.swapaxes(C, 1, 2)).max() < 1e-12 * C.max()
        for t in range(6):
            own = C[t][np.ix_(segments.valid[t], segments.valid[t])]
            assert np.linalg.eigvalsh(own).min() > -1e-12 * C.max()


def test_evenly_loaded_teeth_bend_as_plane_ones(pair_of: Build) -> None:
    pair = pair_of(slices=8)
    segments = contact_segments(pair, [0.02])
    on = np.flatnonzero(segments.valid[0])
    assert len(on) == 8  # one pair of spur teeth bears
    per_length = 2e5
    moved = segments.compliance[0][np.ix_(on, on)] @ np.full(8, per_length * 30e-3 / 8)
    place = 0.02
    plane = sum(
        float(tooth.bending(radius(place))) * per_length
        for tooth, radius in ((pair.tooth_a, pair.plane.radius_a), (pair.tooth_b, pair.plane.radius_b))
    )
    assert moved == pytest.approx(plane, rel=1e-9)


def test_a_loaded_tooth_takes_its_neighbours_along(pair_of: Build) -> None:
    pair = pair_of(slices=8)
    place = -0.3
    segments = contact_segments(pair, [place])  # one pair at -0.3, the one ahead at 0.7
    first = np.flatnonzero(segments.valid[0] & (np.abs(segments.lines.sigma.ravel()[segments.index[0]] - place) < 1e-9))
    other = np.flatnonzero(
        segments.valid[0] & (np.abs(segments.lines.sigma.ravel()[segments.index[0]] - place - 1) < 1e-9)
    )
    assert len(first) == len(other) == 8
    moved = segments.compliance[0][np.ix_(other, first)] @ np.full(8, 2e5 * 30e-3 / 8)
    places, plane = np.array([place, place + 1]), 0.0
    for tooth, radius, numbers in (
        (pair.tooth_a, pair.plane.radius_a(places), [0, 1]),
        (pair.tooth_b, pair.plane.radius_b(places), [1, 0]),
    ):
        loads, roots = tooth.body_factors(radius, numbers)
        plane += 2e5 * float(loads[1] @ roots @ loads[0])
    assert moved == pytest.approx(plane, rel=1e-9)


def test_twist_of_a_shaft_under_an_even_load(pair_of: Build) -> None:
    rigid = pair_of(slices=200)
    pair = replace(rigid, torsion_a=Torsion(rigidity=2e4, end="right"))
    more = contact_segments(pair, [0.02]).compliance[0] - contact_segments(rigid, [0.02]).compliance[0]
    force, width = 9e3, 30e-3
    moved = more @ np.full(200, force / 200)
    x = (np.arange(200) + 0.5)[::-1] * width / 200  # from the right end, where the torque leaves
    torque = force * pair.plane.base_a
    twist = torque / 2e4 * (x - x**2 / (2 * width))
    assert moved == pytest.approx(pair.plane.base_a * twist, rel=1e-2)  # segments of a half per cent of the face
    assert moved[0] > moved[-1]


def test_misalignment_loads_the_end_it_closes(pair_of: Build) -> None:
    found = loaded_contact(pair_of(slices=10, misalignment=1e-3), [3e3], [0.02])
    over = found.force[0, 0].sum(axis=0)
    assert (np.diff(over) <= 0).all()  # positive opens the right end
    assert over[0] > over[-1] == 0
    given = loaded_contact(pair_of(slices=10, gap=((-15e-3, -15e-6), (15e-3, 15e-6))), [3e3], [0.02])
    assert given.force == pytest.approx(found.force, rel=1e-12, abs=1e-9)


def test_pitch_deviation_unloads_its_tooth(pair_of: Build) -> None:
    pitch = np.zeros(21)
    pitch[1] = 30e-6
    pair = pair_of(slices=2, flank_a=Flank(pitch=tuple(pitch)))
    phases = np.arange(0, 3, 1 / 16) + 1e-3
    found, plain = loaded_contact(pair, [6e3], phases), loaded_contact(pair_of(slices=2), [6e3], phases)
    share = np.zeros((3, len(phases)))
    for t in range(len(phases)):
        for number in range(3):
            share[number, t] = found.share[0, t][found.segments.lines.pair[t] == number].sum()
    same = np.isin(found.segments.lines.pair, [1]) & (plain.share[0] > 0) & (plain.share[0] < 0.99)
    assert (found.share[0][same] < plain.share[0][same]).all()
    assert found.approach.max() == pytest.approx(plain.approach.max() + 30e-6, rel=1e-2)  # alone in mesh, as far back
    # three teeth on it is forgotten
    far = np.abs(found.approach[0] - plain.approach[0])[phases < 0.1]
    assert far.max() < 1e-12


def test_pressure_is_that_of_pressed_cylinders(pair_of: Build) -> None:
    pair = pair_of(slices=1)
    found = loaded_contact(pair, [9e3], [0.02])
    p = 9e3 / 30e-3
    radius = float(pair.plane.curvature_radius(0.02))
    modulus = 206e9 / (2 * (1 - 0.3**2))
    assert found.mean_pressure.max() == pytest.approx(math.sqrt(p * modulus / (math.pi * radius)), rel=1e-12)
    assert found.largest_load[0] == pytest.approx(p, rel=1e-12)


@pytest.mark.parametrize("linear_at", [None, 3e5])
def test_tangent_is_the_slope_and_secant_the_chord(pair_of: Build, linear_at: float | None) -> None:
    pair = pair_of(helix=15.0, flank_a=WORN, linear_at=linear_at)
    load, step = 8e3, 2.0
    found = loaded_contact(pair, [load - step, load, load + step], PHASES)
    slope = 2 * step / (found.approach[2] - found.approach[0])
    # a segment that begins to bear between the loads makes a kink: there is no one slope
    pressed = found.force > 0
    smooth = (pressed[0] == pressed[2]).all(axis=(1, 2))
    assert smooth.sum() >= len(PHASES) - 1
    # the difference of approaches is known to 1e-12 of them, its curvature is (step/load)^2
    assert found.tangent[1, smooth] == pytest.approx(slope[smooth], rel=1e-5)
    assert found.secant[1] == pytest.approx(load / (found.approach[1] - found.no_load), rel=1e-12)


def test_approach_and_load_invert_each_other(pair_of: Build) -> None:
    pair = pair_of(helix=15.0, flank_a=WORN)
    segments = contact_segments(pair, PHASES)

    def load_at(approach: float) -> Array:
        given = segments.compliance, segments.gap, segments.valid, None, segments.law
        force: Array = solve_hertzian(*given, approach=np.full(len(PHASES), approach)).force.sum(axis=1)
        return force

    found = loaded_contact(pair, load_at(25e-6)[None, :], PHASES)  # a load for every phase
    assert found.approach == pytest.approx(25e-6, rel=1e-9)
    assert load_at(-1e-3) == pytest.approx(0.0, abs=0)


def test_reshaped_pieces_are_those_of_the_new_flank(pair_of: Build) -> None:
    pair = pair_of(helix=15.0)
    worn = replace(pair, flank_b=WORN, misalignment=2e-4)
    drawn = contact_segments(pair, PHASES)
    again = loaded_segments(replace(drawn, pair=worn, gap=microgeometry_gaps(drawn, [worn])[0]), [8e3])
    assert again.force == pytest.approx(loaded_contact(worn, [8e3], PHASES).force, rel=1e-12)


def test_transmission_error_is_transverse(pair_of: Build) -> None:
    found = loaded_contact(pair_of(helix=15.0), [8e3], PHASES)
    slant = math.asin(math.sin(math.radians(15)) * math.cos(math.radians(20)))
    assert found.transmission_error == pytest.approx(found.approach / math.cos(slant), rel=1e-12)


def test_harmonics_rebuild_the_samples() -> None:
    phase = np.arange(32) / 32
    values = 3 + 2 * np.cos(2 * np.pi * phase + 0.4) - np.sin(6 * np.pi * phase)
    found = harmonics(values, 5)
    assert found[0] == pytest.approx(3)
    assert found[1] == pytest.approx(2 * np.exp(0.4j))
    assert found[3] == pytest.approx(1j)
    assert abs(found[[2, 4, 5]]).max() < 1e-14


def test_bodies_that_are_softer_give_more(pair_of: Build) -> None:
    hard = loaded_contact(pair_of(), [8e3], PHASES)
    soft = loaded_contact(pair_of(youngs_modulus=(206e9, 103e9)), [8e3], PHASES)
    assert (soft.approach > hard.approach).all()
    assert (
        gear_pair.approach(hard.segments.contact, np.full(hard.segments.valid.shape, 1e5)).max() < hard.approach.max()
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"face_a": (20e-3, 40e-3)}, "faces do not overlap"),
        ({"face_a": (0.0, 0.0)}, "faces do not overlap"),
        ({"limits": (-0.4, 0.5)}, "do not keep contact"),
        ({"limits": (-3.0, 0.5)}, "interference"),
        ({"limits": (-0.5, 9.0)}, "interference"),
        ({"slices": 0}, "pieces of the face"),
        ({"flank_a": Flank(tip_relief=Relief(amount=1e-5, length=1.0))}, "does not fit the flank"),
    ],
)
def test_what_cannot_mesh_is_refused(pair_of: Build, change: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        loaded_contact(pair_of(**change), [1e3], [0.0])


@pytest.mark.parametrize("load", [-1.0, math.nan, math.inf])
def test_loads_are_refused(pair_of: Build, load: float) -> None:
    with pytest.raises(ModelError, match="a load on the teeth"):
        loaded_contact(pair_of(), [load], [0.0])
