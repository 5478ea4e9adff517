"""Tilt where the file leaves it open: slices of meshes whose bodies may tilt, two bearings, what check says."""

from __future__ import annotations

import copy
import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

import epicyclic
from epicyclic.document.document import ready_drives
from epicyclic.train.resolution import load, resolved_document
from epicyclic.train.stage_bodies import SLICES
from epicyclic.train.train import Train

Document = dict[str, Any]
PAIRS = ("sun-planet", "planet-ring")
PLACE, RADIAL = 0.07, 2.5e9

BASE: Document = {
    "format": 2,
    "title": "a helical set with four planets",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 4,
            "module": 0.01,
            "helix_angle": math.radians(7.5),
            "face_width": 0.22,
            "sun": {"teeth": 21, "support": {"radial": 1e7}},
            "planet": {"teeth": 39, "bore": 0.2, "bearing": {"radial": 5e9, "z": 1e9}},
            "ring": {"teeth": 99, "rim": 0.06},
            "carrier": {"mass": 1200.0, "inertia": 180.0, "tilt_inertia": 100.0},
        }
    },
    "operation": {"held": ["ring"], "speed": {"carrier": 2.4}, "torque": {"carrier": 3.2e5}},
    "deviations": {"planet": {"position": {"y": [30e-6, 0.0, 0.0, 0.0]}}},
}


def document(**changes: Any) -> Document:
    """BASE with `changes` by path of the stage, points as double underscores."""
    data = copy.deepcopy(BASE)
    for path, value in changes.items():
        *tables, last = path.split("__")
        here = data["stages"]["main"]
        for name in tables:
            here = here.setdefault(name, {})
        here[last] = value
    return data


def sliced(count: int, **changes: Any) -> Document:
    return document(meshes={pair: {"slices": count} for pair in PAIRS}, **changes)


def pair_of_bearings(**more: Any) -> Document:
    """Planets on two bearings at a distance, of which nothing is said but radial stiffness and place."""
    row = {"radial": RADIAL}
    return document(planet__bearing={"front": {**row, "at": -PLACE}, "rear": {**row, "at": PLACE}, **more})


def counts(train: Train) -> set[int]:
    return {len(mesh.slices) for mesh in train.meshes}


# slices ---------------------------------------------------------------------------------------------------------------

TILTING = {"planet__bearing__tilt": 5e7, "sun__support__tilt": 1e5}


@cache
def sharing_and_tilt_mode(count: int | None, bearing: float = 5e7) -> tuple[float, float]:
    """K_gamma - 1 by statics, and the lowest natural frequency with most of its kinetic energy in tilt [Hz].

    count : slices; None as the file leaves them.  bearing : of the planets, against tilt [N m/rad].
    """
    changes = TILTING | {"planet__bearing__tilt": bearing}
    system = epicyclic.assemble(load(document(**changes) if count is None else sliced(count, **changes)))
    squares, shapes = eigh(system.mean_stiffness, system.M)
    tilts = [direction in ("rx", "ry") for direction in system.dofs.direction]
    share = np.einsum("im,ij,jm->m", shapes[tilts], system.M[np.ix_(tilts, tilts)], shapes[tilts])
    lowest = math.sqrt(squares[share > 0.5].min()) / math.tau
    return float(epicyclic.sharing(system, method="static").system_load_sharing.max()) - 1, lowest


def test_default_slices_agree_with_twice_as_many_and_one_row_does_not() -> None:
    default, twice, one = (sharing_and_tilt_mode(count) for count in (None, 2 * SLICES, 1))
    np.testing.assert_allclose(default, twice, rtol=0.01)
    assert one[0] < 0.96 * twice[0]  # the load of the stiffest planet comes out too small
    assert one[1] < 0.5 * twice[1]  # a mode of tilt that the teeth do not hold


def test_planets_in_soft_bearings_lean_on_their_teeth() -> None:
    """One row lets a planet tilt away from its load: K_gamma 1.042 in place of 1.090."""
    default, twice, one = (sharing_and_tilt_mode(count, 1.65e6) for count in (None, 2 * SLICES, 1))
    np.testing.assert_allclose(default, twice, rtol=0.005)
    assert one[0] < 0.5 * default[0]


def test_ten_slices_hold_tilt_to_one_per_cent() -> None:
    """k b^2/12 (1 - 1/n^2) about mid-face, of a spur mesh whose rows differ by their place only."""
    tilt = {}
    for count in (SLICES, 100):
        train = load(sliced(count, helix_angle=0.0, **TILTING))
        mesh = train.meshes[0]
        places = np.array([one.station - mesh.station for one in mesh.slices])
        tilt[count] = float(np.mean(places**2) * mesh.stiffness)
        assert tilt[count] == pytest.approx(mesh.stiffness * 0.22**2 / 12 * (1 - count**-2), rel=1e-12)
    assert 1 - tilt[SLICES] / tilt[100] == pytest.approx(0.01, rel=0.02)
    assert 1 / (SLICES - 1) ** 2 > 0.01  # and no fewer do


@pytest.mark.parametrize(
    ("changes", "count"),
    [
        ({}, 0),  # nothing tilts: one row
        (TILTING, SLICES),
        (TILTING | {"helix_angle": 0.0}, SLICES),  # a wide spur face too
        (TILTING | {"herringbone": True, "gap": 0.02}, SLICES),
        ({"carrier__support": {"tilt": 1e8}}, SLICES),  # planets that follow a carrier that tilts
        ({"sun__support": {"radial": 1e7, "rx": 1e7}}, None),  # about one axis only; the ring meshes stay whole
        ({"planet__bearing": {"radial": 5e9, "tilt": math.inf}}, 0),
    ],
)
def test_meshes_are_sliced_where_their_bodies_may_tilt(changes: Document, count: int | None) -> None:
    train = load(document(**changes))
    if count is None:
        assert {mesh.pair.split(".")[-1]: len(mesh.slices) for mesh in train.meshes} == dict(
            zip(PAIRS, (SLICES, 0), strict=True)
        )
    else:
        assert counts(train) == {count}
    noted = {value.path: (value.value, value.origin) for value in train.values if value.path.endswith(".slices")}
    assert set(noted.values()) == ({(SLICES, "default")} if count != 0 else set())
    assert not [text for text in train.warnings if "tilt" in text]


def test_a_seat_that_is_tilted_shows_along_the_face() -> None:
    """A member slaved in tilt stands askew by its deviation: its meshes need slices to see it."""
    data = document()
    data["deviations"] = {"planet": {"tilt": {"y": [2e-4, 0.0, 0.0, 0.0]}}}
    assert counts(load(data)) == {SLICES}
    assert float(epicyclic.static(data).face_load_factor.max()) > 1.05


def test_one_row_is_said_aloud() -> None:
    text = "slices: 1, but sun and planet may tilt against each other"
    assert any(text in warning for warning in load(sliced(1, **TILTING)).warnings)
    assert not any("slices" in warning for warning in load(sliced(1)).warnings)
    assert not any("slices" in warning for warning in load(sliced(4, **TILTING)).warnings)


def test_without_a_face_width_a_mesh_stays_one_row_and_says_so() -> None:
    data = document(**TILTING, meshes={pair: {"stiffness": 1e9} for pair in PAIRS})
    del data["stages"]["main"]["face_width"]
    for member in ("planet", "ring"):
        data["stages"]["main"][member] |= {"mass": 100.0, "inertia": 1.0, "tilt_inertia": 1.0}
    data["stages"]["main"]["sun"] |= {"mass": 100.0, "inertia": 1.0, "tilt_inertia": 1.0}
    train = load(data)
    assert counts(train) == {0}
    assert any("stages.main.face_width" in text and "no stiffness against tilt" in text for text in train.warnings)


@pytest.mark.parametrize("name", ready_drives())
def test_ready_drives_have_no_tilt_and_whole_meshes(name: str) -> None:
    assert counts(load(name)) == {0}


# two bearings at a distance -------------------------------------------------------------------------------------------


def test_two_bearings_hold_tilt_by_their_distance() -> None:
    """The same as one bearing in the middle with tilt = sum k z^2, in all forces; not rigid tilt."""
    pair = epicyclic.static(pair_of_bearings())
    middle = {"radial": 2 * RADIAL, "tilt": 2 * RADIAL * PLACE**2}
    single = epicyclic.static(document(planet__bearing=middle))
    np.testing.assert_allclose(pair.slice_force, single.slice_force, rtol=1e-9)
    np.testing.assert_allclose(pair.face_load_factor, single.face_load_factor, rtol=1e-9)
    assert 1.15 < float(pair.face_load_factor.max()) < 1.6
    rigid = epicyclic.static(sliced(SLICES, planet__bearing={"radial": 2 * RADIAL}))
    assert float(rigid.face_load_factor.max()) < 1.01


def test_loaded_teeth_see_the_tilt_that_two_bearings_leave() -> None:
    """Face load factor of the real teeth at the operating load, without deviations."""

    def factors(data: Document) -> Any:
        data["deviations"] = {}
        return epicyclic.contact(data, samples=4, slices=20, loads=[1.0]).face_load_factor.values

    pair = factors(pair_of_bearings())
    assert ((pair > 1.3) & (pair < 1.4)).all()  # over a tenth of the face; the last slice has 1.4 to 1.5
    middle = {"radial": 2 * RADIAL, "tilt": 2 * RADIAL * PLACE**2}
    np.testing.assert_allclose(pair, factors(document(planet__bearing=middle)), rtol=1e-6)  # the solver's tolerance
    assert (factors(document(planet__bearing={"radial": 2 * RADIAL})) < 1.1).all()


def test_unequal_bearings_give_the_whole_block() -> None:
    """sum k z^2 about the centre in tilt, sum k z between tilt and displacement."""
    rows = {"front": {"radial": 3e9, "at": -0.05}, "rear": {"radial": 1e9, "at": 0.09}}
    system = epicyclic.assemble(load(document(planet__bearing=rows)))
    at = {name: i for i, name in enumerate(system.dofs.names)}
    rx, ry, x, y = (at[f"main/planet/1/{d}"] for d in ("rx", "ry", "x", "y"))
    K = (system.links.B * system.links.stiffness) @ system.links.B.T
    tilt, mixed = 3e9 * 0.05**2 + 1e9 * 0.09**2, -3e9 * 0.05 + 1e9 * 0.09
    assert K[rx, rx] == pytest.approx(tilt, rel=1e-12)
    assert K[ry, ry] == pytest.approx(tilt, rel=1e-12)
    assert K[x, ry] == pytest.approx(mixed, rel=1e-12)  # the point at z moves by x + z ry, y - z rx
    assert K[y, rx] == pytest.approx(-mixed, rel=1e-12)


@pytest.mark.parametrize(
    ("front", "rear", "tilts"),
    [
        ({"radial": RADIAL}, {"radial": RADIAL}, True),
        ({"radial": RADIAL}, {"radial": "[2.5e9, 2.5e9, 2.5e9, 2.5e9] N/m"}, True),
        ({"radial": RADIAL}, {"radial": 0}, False),  # one alone holds nothing at a distance
        ({"radial": RADIAL}, {"radial": RADIAL, "at": -PLACE}, False),  # at one place
        ({"radial": RADIAL}, {"z": 1e9}, False),
        ({"radial": RADIAL, "tilt": math.inf}, {"radial": RADIAL}, False),  # said otherwise
        ({"radial": math.inf}, {"radial": math.inf}, False),  # rigid at two places is rigid in tilt
        ({"radial": math.inf}, {"radial": RADIAL}, True),
    ],
)
def test_what_two_bearings_leave_to_tilt(front: Document, rear: Document, tilts: bool) -> None:
    rows = {"front": {"at": -PLACE, **front}, "rear": {"at": PLACE, **rear}}
    train = load(document(planet__bearing=rows))
    system = epicyclic.assemble(train)
    assert ("main/planet/1/rx" in system.dofs.names) == tilts
    assert counts(train) == {SLICES if tilts else 0}


def test_supports_of_a_shaft_hold_tilt_in_the_same_way() -> None:
    support = {"front": {"radial": 1e8, "at": -0.3}, "rear": {"radial": 1e8, "at": 0.3}}
    train = load(document(sun__support=support))
    names = epicyclic.assemble(train).dofs.names
    assert "main/sun/rx" in names
    assert "main/planet/1/rx" not in names


def test_a_tilted_seat_of_two_bearings_has_its_effect() -> None:
    data = pair_of_bearings()
    data["deviations"] = {"planet": {"tilt": {"y": [2e-4, 0.0, 0.0, 0.0]}}}
    train = load(data)
    assert not any("has no effect" in text for text in train.warnings)
    plain = float(epicyclic.static(pair_of_bearings()).face_load_factor.max())
    assert float(epicyclic.static(data).face_load_factor.max()) != pytest.approx(plain, rel=1e-3)
    # tilt that is free has no seat: `tilt = 0` in a bearing in the middle
    data["stages"]["main"]["planet"]["bearing"] = {"radial": RADIAL, "tilt": 0}
    assert any("has no effect" in text and "rx and ry" in text for text in load(data).warnings)


def test_a_resolved_file_states_what_was_left_open() -> None:
    data = resolved_document(load(pair_of_bearings()))
    assert data["stages"]["main"]["meshes"]["sun-planet"]["slices"] == SLICES
    assert data["stages"]["main"]["planet"]["bearing"]["front"]["rx"] == 0.0
    plain, again = (epicyclic.assemble(load(model)) for model in (pair_of_bearings(), data))
    np.testing.assert_allclose(again.mean_stiffness, plain.mean_stiffness, rtol=1e-12)


# what check says ------------------------------------------------------------------------------------------------------


def test_check_names_what_holds_tilt_and_how_many_slices() -> None:
    result = epicyclic.check(load(pair_of_bearings()))
    said = {
        str(path): (str(value), str(origin), str(effect))
        for path, value, origin, effect in zip(
            result.choice.values,
            result.choice_value.values,
            result.choice_origin.values,
            result.choice_effect.values,
            strict=True,
        )
    }
    value, origin, effect = said["stages.main.planet.bearing.front.tilt"]
    assert value == f"rx {2 * RADIAL * PLACE**2:.4g} N m/rad, ry {2 * RADIAL * PLACE**2:.4g} N m/rad"
    assert origin == "default"
    assert "front and rear hold it by their distance" in effect
    assert said["stages.main.sun.support.tilt"][:2] == ("rigid", "default")
    value, origin, effect = said["stages.main.meshes.sun-planet.slices"]
    assert (value, origin) == (str(SLICES), "default")
    assert "1 % low" in effect
    assert set(result.mesh_slices.values) == {SLICES}


def test_check_tells_given_from_default() -> None:
    result = epicyclic.check(load(sliced(1, **TILTING)))
    said = dict(
        zip(
            result.choice.values, zip(result.choice_value.values, result.choice_origin.values, strict=True), strict=True
        )
    )
    assert said["stages.main.meshes.sun-planet.slices"] == ("1", "given")
    assert said["stages.main.planet.bearing.tilt"] == ("rx 5e+07 N m/rad, ry 5e+07 N m/rad", "given")
    assert said["stages.main.ring.support.tilt"] == ("rigid", "default")


def test_bolts_hold_tilt_by_their_circle() -> None:
    bolts = {"count": 6, "radius": 0.6, "radial": 1e9, "tangential": 1e9, "z": 1e9}
    result = epicyclic.check(load(document(ring__support={"bolts": bolts})))
    value = dict(zip(result.choice.values, result.choice_value.values, strict=True))["stages.main.ring.support.tilt"]
    assert value == "rx 1.08e+09 N m/rad, ry 1.08e+09 N m/rad"  # n k r^2/2
