"""What a resolution refuses or warns of, each with the path it names."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from epicyclic.errors import ModelError
from epicyclic.train.resolution import load
from epicyclic.warning_codes import code_of

BASE: dict[str, Any] = {
    "format": 2,
    "title": "planar set",
    "stages": {
        "main": {
            "planets": 3,
            "module": "2 mm",
            "face_width": "30 mm",
            "sun": {"teeth": 24},
            "planet": {"teeth": 18},
            "ring": {"teeth": 60, "rim": "10 mm"},
            "carrier": {"mass": 1.0, "inertia": 1.0},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1000 rpm"}, "torque": {"sun": "10 N m"}},
}


def test_the_base_is_sound() -> None:
    assert load(BASE).warnings == ()


REFUSED = [
    ({"stages.main.planets": 8}, "stages.main.planets", "collide"),
    ({"stages.main.ring.teeth": 41}, "stages.main.ring.teeth", "smaller than planet"),
    ({"stages.main.ring.teeth": 18}, "stages.main.ring.teeth", "smaller than planet"),
    (
        {"stages.main.centre_distance": "30 mm"},
        "stages.main.centre_distance",
        "below the base circles",
    ),
    ({"stages.main.carrier.pin_radius": "30 mm"}, "stages.main.carrier.pin_radius", "below the base circles"),
    (
        {"stages.main.meshes.sun-planet.centre_distance": "30 mm"},
        "stages.main.meshes.sun-planet.centre_distance",
        "below the base circles",
    ),
    (
        {
            "stages.main.centre_distance": "120 mm",
            **{f"stages.main.{g}.profile_shift": 0 for g in ("sun", "planet", "ring")},
        },
        "stages.main.centre_distance",
        "too large",
    ),
    ({"stages.main.centre_distance": "50 mm"}, "stages.main.planet.profile_shift", "no tooth is left"),
    (
        {"stages.main.centre_distance": "40 mm", "stages.main.sun.profile_shift": 4.5},
        "stages.main.planet.profile_shift",
        "profile shift of -5.28",
    ),
    ({"stages.main.sun.module": "2 mm", "stages.main.ring.module": "3 mm"}, "stages.main.ring.module", "contradicts"),
    (
        {"stages.main.sun.helix_angle": "9 deg", "stages.main.planet.helix_angle": 0.2},
        "planet.helix_angle",
        "contradicts",
    ),
    (
        {"stages.main.helix_angle": "9 deg", "stages.main.sun.hand": "left", "stages.main.planet.hand": "left"},
        "stages.main.planet.hand",
        "contradicts its chain",
    ),
    ({"stages.main.wheel": {"teeth": 30}}, "stages.main.wheel", "meshes with nothing"),
    ({"stages.main.module": None}, "stages.main.sun.module", "is missing"),
    ({"stages.main.face_width": None}, "stages.main.face_width", "needs it"),
    ({"stages.main.d": {"kind": "planet", "teeth": 18}}, "stages.main.meshes", "which of them mesh"),
    ({"stages.main.sun.split": True}, "stages.main.planet.herringbone", "left and a right half"),
    ({"stages.main.split": True}, "stages.main.sun", "neither neck nor hold"),
    (
        {"stages.main.meshes.sun-planet.stiffness": "contact", "stages.main.face_width": None},
        "stages.main.face_width",
        "needs it",
    ),
    ({"stages.main.sun.bore": "48 mm"}, "stages.main.sun.bore", "no solid"),
    ({"stages.main.ring.rim": None, "stages.main.ring.outer_diameter": "110 mm"}, "ring.outer_diameter", "no solid"),
    ({"stages.main.planet_angles": "[0, 120, 120] deg"}, "stages.main.planet_angles", "one place"),
    ({"operation.speed.carrier": "10 rpm"}, "operation.speed.main.carrier", "follows"),
    (
        {"couplings": {"c": {"between": ["main.planet", "main.sun"]}}},
        "couplings.c.between",
        "names no single body",
    ),
    ({"stages.main.sun.support.to": "main.sun"}, "stages.main.sun.support.to", "holds a body on itself"),
    ({"stages.main.sun.root_diameter": "60 mm"}, "stages.main.sun.root_diameter", "no tooth is left"),
    ({"stages.main.ring.tip_diameter": "130 mm"}, "stages.main.ring.tip_diameter", "no tooth is left"),
]


@pytest.mark.parametrize(("changes", "path", "problem"), REFUSED, ids=[f"{p}: {t}" for _, p, t in REFUSED])
def test_refused_with_its_path(changes: dict[str, Any], path: str, problem: str) -> None:
    changes = dict(changes)
    source = copy.deepcopy(BASE)
    source.update({key: changes.pop(key) for key in ("couplings",) if key in changes})
    with pytest.raises(ModelError) as caught:
        load(source, changes)
    assert path in caught.value.path
    assert problem in str(caught.value)


def test_angles_and_modules_that_contradict_are_told_with_their_units() -> None:
    """Sun and ring mesh with the planet, not with each other."""
    angles = {"stages.main.sun.helix_angle": "9 deg", "stages.main.ring.helix_angle": "11 deg"}
    with pytest.raises(ModelError) as caught:
        load(BASE, angles)
    assert str(caught.value).startswith(
        "stages.main.ring.helix_angle = 11 deg: contradicts its chain: sun has 9 deg; allowed: one value along a chain"
    )
    modules = {"stages.main.sun.module": "2 mm", "stages.main.ring.transverse_module": "3 mm"}
    with pytest.raises(ModelError) as caught:
        load(BASE, modules)
    assert str(caught.value).startswith(
        "stages.main.ring.transverse_module = 3 mm: contradicts its chain: sun has a normal module of 2 mm"
    )


def test_a_helix_angle_that_is_none_is_told_where_it_stands() -> None:
    with pytest.raises(ModelError, match="is no helix") as caught:
        load(BASE, {"stages.main.planet.helix_angle": "1e-6 deg"})
    assert caught.value.path == "stages.main.planet.helix_angle"


def test_a_backlash_and_phases_are_refused_where_they_stand() -> None:
    double = {"stages.main.herringbone": True, "stages.main.helix_angle": "20 deg", "stages.main.gap": "10 mm"}
    with pytest.raises(ModelError, match="no backlash of teeth") as caught:
        load(BASE, {**double, "stages.main.meshes.sun-planet.left.backlash": "3 mm"})
    assert caught.value.path == "stages.main.meshes.sun-planet.left.backlash"
    with pytest.raises(ModelError, match="one per planet") as caught:
        load(BASE, {**double, "stages.main.meshes.sun-planet.phase": [0.0, 0.5]})
    assert caught.value.path == "stages.main.meshes.sun-planet.phase"


def test_the_flank_of_a_stage_is_told_there() -> None:
    relief = {"amount": "20 um", "length": "30 mm"}
    with pytest.raises(ModelError, match="does not fit the flank") as caught:
        load(BASE, {"stages.main.flank.tip_relief": relief})
    assert caught.value.path == "stages.main.flank.tip_relief.length"
    large = {"stages.main.flank.crown": "1 mm", "stages.main.sun.flank.slope": "5 um"}
    told = [text for text in load(BASE, large).warnings if code_of(text) == "modification-large"]
    assert [text.partition(" = ")[0] for text in told] == ["stages.main.flank.crown"]


def test_only_radii_that_are_far_are_told_so() -> None:
    """24 mm of 22.55 mm is far; 17.0 mm of 16.91 mm is within the rounding of three digits."""
    radii = {"stages.main.sun.base_radius": "24 mm", "stages.main.planet.base_radius": "16.95 mm"}
    told = [text for text in load(BASE, radii).warnings if code_of(text) == "base-radius-far"]
    assert [text.partition(" = ")[0] for text in told] == ["stages.main.sun.base_radius"]


WARNED = [
    ({"stages.main.planets": 5}, "cannot be assembled"),
    ({"stages.main.sun.base_radius": "24 mm"}, "far from teeth and module"),
    (
        {"stages.main.sun.base_radius": "22.7 mm", "stages.main.meshes.sun-planet.pressure_angle": "20 deg"},
        "fit no single one",
    ),
    ({"stages.main.addendum": 0.5}, "contact ratio"),
    ({"stages.main.meshes.sun-planet.stiffness": "1e7 N/m"}, "steel teeth have 10 .. 30"),
    ({"stages.main.centre_distance": "42 mm", "stages.main.carrier.pin_radius": "42.1 mm"}, "centre distances differ"),
    ({"stages.main.ring.teeth": 63}, "centre distances differ"),
]


@pytest.mark.parametrize(("changes", "text"), WARNED, ids=[t for _, t in WARNED])
def test_warned(changes: dict[str, Any], text: str) -> None:
    assert any(text in warning for warning in load(BASE, changes).warnings)


def test_collisions_are_warnings_where_radii_are_given() -> None:
    train = load(BASE, {"stages.main.planets": 8, "stages.main.planet.pin_radius": "42 mm"})
    assert any("planets collide" in text for text in train.warnings)


def test_without_speeds_what_turns_is_left_out_by_name() -> None:
    deviations = {
        "deviations.sun.run_out": "5 um",
        "deviations.planet.position": "5 um",
        "deviations.meshes.sun-planet.profile": "1 um",
    }
    train = load(BASE, {"operation.speed": None, "operation.torque": None, **deviations})
    assert [item.cause for item in train.displacements] == ["position"] * 3
    assert train.mesh_errors == ()
    warning = next(text for text in train.warnings if "left out" in text)
    assert "deviations.main.sun.run_out" in warning
    assert "deviations.main.meshes.sun-planet.profile" in warning
    assert "position" not in warning


@pytest.mark.parametrize(
    ("modulus", "stiffness", "said"),
    [("3 GPa", 0.287, ""), ("3 GPa", 3.0, "0.287 .. 0.861"), ("206 GPa", 3.0, "10 .. 30")],
)
def test_a_declared_plastic_is_no_unusual_steel(modulus: str, stiffness: float, said: str) -> None:
    """Steel on plastic of 3 GPa is softer by 2 x 3/(3 + 206), so that 10 .. 30 N/(mm um) is 0.287 .. 0.861."""
    changes = {
        "stages.main.planet.material": {"youngs_modulus": modulus},
        "stages.main.sun.material": {"youngs_modulus": "206 GPa"},
        "stages.main.face_width": "20 mm",
        "stages.main.meshes.sun-planet.stiffness": f"{1.001 * stiffness * 20e6} N/m",
    }
    texts = [
        text for text in load(BASE, changes).warnings if code_of(text) == "stiffness-unusual" and "sun-planet" in text
    ]
    assert (said in texts[0]) if said else not texts


# Sun 30, p 18 on it, d 20 beside p, ring 68: whether d reaches into the sun is its place on the circle of its pins.
DOUBLE: dict[str, Any] = {
    "format": 2,
    "title": "double",
    "stages": {
        "main": {
            "planets": 3,
            "module": "2 mm",
            "face_width": "20 mm",
            "meshes": {"small-short": {}, "short-long": {}, "large-long": {}},
            "small": {"kind": "sun", "teeth": 30},
            "large": {"kind": "sun", "teeth": 36},
            "short": {"kind": "planet", "teeth": 20},
            "long": {"kind": "planet", "teeth": 18},
            "carrier": {},
        }
    },
    "operation": {"held": ["carrier"]},
}


def overlaps(changes: dict[str, Any]) -> list[str]:
    return [text for text in load(DOUBLE, changes).warnings if "overlap" in text]


def test_gears_that_overlap_without_meshing() -> None:
    """By hand: pins of short at 2 (30 + 20)/2 = 50 mm, tips of large and short at 38 and 22 mm: 10 mm too many."""
    assert overlaps({}) == []  # two suns cannot lie in one plane: the file shows several
    with pytest.raises(ModelError, match="large and short 1 overlap by 10 mm") as caught:
        load(DOUBLE, {"stages.main.short.station": "19 mm"})  # faces 20 mm wide
    assert caught.value.path == "stages.main.short.station"
    with pytest.raises(ModelError, match="small and large overlap by 70 mm"):
        load(DOUBLE, {"stages.main.large.station": "19 mm", "stages.main.short.station": "-2 mm"})
    apart = {"stages.main.large.station": "20 mm", "stages.main.long.face_width": "60 mm"}
    assert overlaps(apart) == []
    assert overlaps({"stages.main.short.pin_radius": "50 mm", "stages.main.short.station": "1 mm"}) != []


def test_a_sun_that_reaches_into_planets_it_does_not_mesh_with_is_a_doubt() -> None:
    """Without a place along the axis the file does not say whether large and short lie in one plane."""
    one = {"stages.main.small": None, "stages.main.meshes.small-short": None, "stages.main.short.pin_radius": "50 mm"}
    told = overlaps(one)
    assert len(told) == 1
    assert "large and short 1 overlap by 10 mm without meshing" in told[0]
    assert told[0].endswith("[gears-overlap]")


def test_planets_in_two_planes_pass_each_other() -> None:
    crowded = {"stages.main.planets": 4}
    with pytest.raises(ModelError, match=r"short 1 and long 4 overlap by .*: planets collide"):
        load(DOUBLE, crowded)
    behind = {f"stages.main.{name}.station": "20 mm" for name in ("small", "short", "back")}
    shaft = {
        "stages.main.back": {"kind": "planet", "teeth": 10, "on": "long"},
        "stages.main.meshes.short-back": {},
        "stages.main.meshes.short-long": None,
    }
    assert overlaps({**crowded, **shaft, **behind}) == []
    with pytest.raises(ModelError, match="planets collide"):
        load(DOUBLE, {**crowded, **shaft})


@pytest.mark.parametrize("name", ["yue2014-i", "dong2019", "xu2020", "encased-differential", "lin1999-n3"])
def test_ready_drives_have_no_gears_that_overlap(name: str) -> None:
    assert not any("overlap" in text for text in load(name).warnings)
