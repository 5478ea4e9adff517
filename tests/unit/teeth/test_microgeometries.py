"""Many micro-geometries at once are each of them alone; one segment across an even face is as good as many."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.system.tooth_pairs import pair_of
from epicyclic.teeth.form import PLAIN, Flank, Relief
from epicyclic.teeth.gear_pair import ContactPair, uniform_along_face
from epicyclic.teeth.loaded_contact import loaded_contact, microgeometry_contact
from epicyclic.teeth.segments import contact_segments

PHASES = np.arange(12) / 12
TIP = Flank(tip_relief=Relief(amount=12e-6, length=2e-3))
FLANKS = (PLAIN, TIP, Flank(crown=4e-6, tip_relief=Relief(amount=5e-6, length=1e-3, shape="parabolic")))
LOADS = [2000.0, 500.0, 4000.0]  # in no order


def pair(helix: str = "0 deg", **options: Any) -> ContactPair:
    document = {
        "format": 2,
        "title": "One pair",
        "stages": {
            "main": {
                "module": "4 mm",
                "pressure_angle": "20 deg",
                "helix_angle": helix,
                "face_width": "20 mm",
                "pinion": {"kind": "gear", "teeth": 23},
                "wheel": {"kind": "gear", "teeth": 41},
                "meshes": {"pinion-wheel": {"stiffness": "400 N/um"}},
            }
        },
    }
    train = epicyclic.load(document)
    return replace(pair_of(train, train.meshes[0], slices=6), **options)


@pytest.mark.parametrize("helix", ["0 deg", "15 deg"])
@pytest.mark.parametrize("linear_at", [None, 1e5])
@pytest.mark.parametrize("at_once", [1, 2, 3])
def test_many_are_each_alone(
    helix: str, linear_at: float | None, at_once: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = pair(helix, linear_at=linear_at)
    shapes = [replace(one, flank_a=a, flank_b=b) for a, b in zip(FLANKS, FLANKS[::-1], strict=True)]
    segments = contact_segments(one, PHASES)
    # one by one, each from the solution before, or in parts
    monkeypatch.setattr("epicyclic.teeth.loaded_contact._AT_ONCE", segments.compliance.size * at_once)
    if at_once == 1:
        monkeypatch.setattr("epicyclic.teeth.contact_solver._ENTRIES", 1)
    many = microgeometry_contact(segments, shapes, LOADS, tangents=True)
    assert many.solved.all()
    assert many.residual.max() < 1e-11
    for i, shape in enumerate(shapes):
        alone = loaded_contact(shape, LOADS, PHASES)
        # both end at 1e-12 of the forces; the tangent follows from them
        np.testing.assert_allclose(many.approach[i], alone.approach, rtol=1e-10)
        np.testing.assert_allclose(many.tangent[i], alone.tangent, rtol=1e-8)
        np.testing.assert_allclose(many.largest_load[i], alone.largest_load, rtol=1e-9)
    assert np.ptp(many.approach[:, 0], axis=0).min() > 1e-7  # they are not all the same


def test_one_piece_across_an_even_face() -> None:
    one = pair(flank_a=TIP)
    assert uniform_along_face(one)
    many, single = (loaded_contact(replace(one, slices=count), LOADS, PHASES) for count in (6, 1))
    np.testing.assert_allclose(single.approach, many.approach, rtol=1e-9)
    np.testing.assert_allclose(single.tangent, many.tangent, rtol=1e-9)
    np.testing.assert_allclose(single.largest_load, many.largest_load, rtol=1e-9)


@pytest.mark.parametrize(
    "change",
    [
        {"flank_a": Flank(crown=1e-6)},
        {"flank_b": Flank(slope=1e-6)},
        {"flank_b": Flank(end_relief=Relief(amount=5e-6, length=4e-3))},
        {"misalignment": 1e-4},
        {"gap": ((-0.01, 0.0), (0.01, 1e-6))},
        {"plane": replace(pair().plane, face_a=(-0.009, 0.01))},
    ],
)
def test_what_differs_along_the_face_is_not_even(change: dict[str, Any]) -> None:
    uneven = pair(**change)
    assert not uniform_along_face(uneven)
    many, single = (loaded_contact(replace(uneven, slices=count), [2000.0], PHASES) for count in (6, 1))
    assert np.abs(single.approach / many.approach - 1).max() > 1e-4


def test_a_helix_is_not_even() -> None:
    assert not uniform_along_face(pair("15 deg"))


@pytest.mark.parametrize("helix", ["0 deg", "15 deg"])
def test_a_start_from_another_micro_geometry_loses_none(helix: str) -> None:
    """Far apart and lightly loaded, Newton's method from the nearest solved one often misses: all are solved anew."""
    one = pair(helix)
    random = np.random.default_rng(3)
    shapes = []
    for tip, length, root, crown, slope in random.random((30, 5)):
        flank = Flank(
            tip_relief=Relief(amount=60e-6 * tip, length=1e-4 + 2e-3 * length),
            root_relief=Relief(amount=50e-6 * root, length=1e-3),
            crown=40e-6 * crown,
            slope=160e-6 * (slope - 0.5),
        )
        shapes.append(replace(one, flank_a=flank, flank_b=flank))
    segments = contact_segments(one, PHASES)
    loads = [40.0, 2000.0]
    many = microgeometry_contact(segments, shapes, loads)
    assert many.solved.all()
    assert many.residual.max() < 1e-10
    for i in range(0, 30, 7):
        alone = loaded_contact(shapes[i], loads, PHASES)
        np.testing.assert_allclose(many.approach[i], alone.approach, rtol=1e-9)


def test_the_largest_load_is_computed_where_it_is_wanted() -> None:
    one = pair()
    segments = contact_segments(one, PHASES)
    found = [microgeometry_contact(segments, [one], LOADS, largest=wanted) for wanted in (True, False)]
    assert np.isfinite(found[0].largest_load).all()
    assert np.isnan(found[1].largest_load).all()
    assert np.array_equal(found[0].approach, found[1].approach)
