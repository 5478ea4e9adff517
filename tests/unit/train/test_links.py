"""Links: what is not named is rigid, shafts, shares, torques on halves."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from epicyclic.errors import ModelError
from epicyclic.train.links import shaft_stiffness, shear_coefficient
from epicyclic.train.resolution import load
from epicyclic.train.train import Link, Train

MODELS = Path(__file__).parent / "models"
INF = math.inf


def link(train: Train, name: str) -> Link:
    return next(entry for entry in train.links if entry.name == name)


def test_what_is_not_named_is_rigid_and_rz_is_free() -> None:
    train = load("ren2021")
    assert link(train, "main/sun/support").stiffness == (1e9, 1e9, 1e9, INF, INF, 0.0)
    bearing = link(train, "main/planet/2/bearing")
    assert bearing.stiffness == (1e9, 1e9, 1e9, INF, INF, 0.0)
    assert (bearing.first, bearing.second) == ("main/carrier", "main/planet/2")
    assert bearing.angle == pytest.approx(2 * math.pi / 3)
    assert link(train, "main/ring/left/support").station == -0.095


def test_a_held_member_is_rigid_in_rz_unless_it_says_otherwise() -> None:
    held = load("ren2021", {"stages.main.ring.support.rz": None})
    assert link(held, "main/ring/left/support").stiffness[5] == INF
    assert link(load("ren2021"), "main/ring/left/support").stiffness[5] == pytest.approx(
        1e10 * 0.933793115162928**2, rel=1e-12
    )  # z m_t cos(alpha_t)/2 of 57 teeth


def test_overrides_of_one_direction_and_per_planet() -> None:
    train = load("ren2021", {"stages.main.planet.bearing.x": [1e8, 2e8, 3e8]})
    assert [link(train, f"main/planet/{i}/bearing").stiffness[:2] for i in (1, 2, 3)] == [
        (1e8, 1e9),
        (2e8, 1e9),
        (3e8, 1e9),
    ]


def test_planets_without_carrier_stand_in_the_housing() -> None:
    train = load(MODELS / "encased.toml")
    bearing = link(train, "encased/planet/3/bearing")
    assert (bearing.first, bearing.second) == ("encased/planet/3", None)


def test_a_planet_in_one_piece_hangs_on_both_halves_of_a_split_carrier() -> None:
    train = load("ren2021", {"stages.main.carrier.split": True, "stages.main.carrier.neck": {}})
    ends = [(entry.first, entry.stiffness[0]) for entry in train.links if entry.name.startswith("main/planet/1")]
    assert ends == [("main/carrier/left", 5e8), ("main/carrier/right", 5e8)]


def test_supported_by_another_member() -> None:
    train = load("ren2021", {"stages.main.sun.support.to": "carrier"})
    assert link(train, "main/sun/support").second == "main/carrier"


def test_damping_and_play_are_handed_on() -> None:
    train = load(MODELS / "dong.toml", {"stages.main.sun.support.damping": "100 N s/m"})
    support = link(train, "main/sun/support")
    assert support.damping == (100.0, 100.0, 100.0, 0.0, 0.0, 0.0)
    assert support.clearance == 20e-6
    assert dict(support.friction) == {"coefficient": 0.1, "radius": 0.02, "law": "holonomic"}


def test_couplings_pass_torque_only_unless_their_ends_are_fixed() -> None:
    splined = link(load(MODELS / "xu.toml"), "output-shaft")
    shape = shaft_stiffness(0.28, 0.0, 0.4325, 206e9, 0.3)
    assert splined.stiffness == (0, 0, 0, 0, 0, shape["rz"])
    fixed = link(load(MODELS / "xu.toml", {"couplings.output-shaft.ends": "fixed"}), "output-shaft")
    assert fixed.stiffness == tuple(shape[d] for d in ("x", "y", "z", "rx", "ry", "rz"))


def test_shaft_stiffness_is_that_of_a_beam_with_shear() -> None:
    """Cantilever: an end force F gives F l^3/(3 E I) + F l/(kappa G A), an end moment M l/(E I)."""
    modulus, poisson, diameter, length = 206e9, 0.3, 0.1, 0.4
    k = shaft_stiffness(diameter, 0.0, length, modulus, poisson)
    second, area = math.pi * diameter**4 / 64, math.pi * diameter**2 / 4
    shear = modulus / (2 * (1 + poisson)) * 6 * (1 + poisson) / (7 + 6 * poisson) * area
    # springs at mid-length: the end force bends the rotation spring over half the length
    tip = 1 / k["x"] + (length / 2) ** 2 / k["ry"]
    assert tip == pytest.approx(length**3 / (3 * modulus * second) + length / shear, rel=1e-12)
    assert 1 / k["ry"] == pytest.approx(length / (modulus * second), rel=1e-12)
    assert k["rz"] == pytest.approx(modulus / 2.6 * 2 * second / length, rel=1e-12)


def annular_shear_coefficient(inner: float, outer: float, nu: float) -> float:
    """Cowper's integral over an annulus of the flexure function chi, harmonic with the flux of an end load."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    r, dr = (outer + inner) / 2 + (outer - inner) / 2 * nodes, (outer - inner) / 2 * weights
    turn = 2 * np.pi * np.arange(16) / 16
    r, turn = r[:, None], turn[None]
    x, y, dA = r * np.cos(turn), r * np.sin(turn), r * dr[:, None] * (2 * np.pi / 16)
    squares = inner**2 + outer**2
    chi = -(3 + 2 * nu) / 4 * (squares * r + inner**2 * outer**2 / r) * np.cos(turn) + r**3 * np.cos(3 * turn) / 4
    area, second = np.sum(dA + 0 * turn), np.sum(x**2 * dA)
    return float(-2 * (1 + nu) * second**2 / (area * np.sum(x * (chi + x * y**2) * dA)))


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
def test_shear_coefficient_of_hollow_sections(poisson: float) -> None:
    """Solid and thin-walled sections in closed form, between them the integral over the section."""
    assert shear_coefficient(0.0, poisson) == pytest.approx(6 * (1 + poisson) / (7 + 6 * poisson), rel=1e-14)
    assert shear_coefficient(1 - 1e-9, poisson) == pytest.approx(2 * (1 + poisson) / (4 + 3 * poisson), rel=1e-8)
    for ratio in (0.2, 0.6, 0.95):
        assert shear_coefficient(ratio, poisson) == pytest.approx(annular_shear_coefficient(ratio, 1.0, poisson))


def test_a_hollow_shaft_shears_more() -> None:
    """A short tube of thin wall: half of its section carries the shear, of a solid one nine tenths."""
    modulus, poisson, diameter, length = 206e9, 0.3, 0.1, 0.02
    bore = 0.999 * diameter
    second, area = math.pi * (diameter**4 - bore**4) / 64, math.pi * (diameter**2 - bore**2) / 4
    shear = 1 / shaft_stiffness(diameter, bore, length, modulus, poisson)["x"] - length**3 / (12 * modulus * second)
    kappa = 2 * (1 + poisson) / (4 + 3 * poisson)
    assert shear == pytest.approx(length * 2 * (1 + poisson) / (modulus * kappa * area), rel=1e-5)


def test_torque_of_a_named_side_and_of_both() -> None:
    whole = load(MODELS / "xu.toml")
    assert whole.torques["main/carrier/left"] == whole.torques["main/carrier/right"] == -414e3
    sided = load(MODELS / "xu.toml", {"operation.torque.carrier": {"right": "-828 kN m"}})
    assert "main/carrier/left" not in sided.torques
    assert sided.torques["main/carrier/right"] == -828e3


def test_origins_say_where_a_value_comes_from() -> None:
    train = load("ren2021", {"stages.main.sun.mass": "700 kg"})
    origin = {value.path: value.origin for value in train.values}
    assert origin["stages.main.sun.mass"] == "set"
    assert origin["stages.main.planet.mass"] == "given"
    assert origin["stages.main.module"] == "assumed"
    assert origin["stages.main.sun.module"] == "stage"
    assert origin["stages.main.planet.hand"] == "as sun"
    assert origin["stages.main.sun.base_radius"] == "geometry"
    assert origin["stages.main.sun.pressure_angle"] == "default"
    assert origin["stages.main.carrier.tilt_inertia"] == "missing"


def test_one_gear_speaks_for_its_chain() -> None:
    train = load(MODELS / "dong.toml")
    origin = {value.path: value.origin for value in train.values}
    assert origin["stages.main.star1.module"] == "as sun"
    assert origin["stages.main.ring.helix_angle"] == "as star2"


def test_the_bearing_of_a_planet_stands_in_the_housing_only_where_its_carrier_does() -> None:
    to_housing = {"stages.main.planet.bearing.to": "housing"}
    with pytest.raises(ModelError, match="the carrier turns") as caught:
        load("ren2021", to_housing)
    assert caught.value.path == "stages.main.planet.bearing.to"
    still = {"operation.held": ["carrier"], "operation.speed": {"sun": "100 rpm"}, "operation.torque": None}
    bearing = link(load("ren2021", {**to_housing, **still}), "main/planet/1/bearing")
    assert (bearing.first, bearing.second) == ("main/planet/1", None)
    assert link(
        load(MODELS / "encased.toml", {"stages.encased.planet.bearing.to": "housing"}), "encased/planet/1/bearing"
    )


def two_steps(gears: Sequence[str], on: dict[str, str], **shaft: object) -> dict[str, object]:
    """g1 - g2 and g3 - g4, g2 and g3 on one shaft; gears in the order of the file."""
    teeth = {"g1": 20, "g2": 40, "g3": 25, "g4": 50}
    sitting = {name: {"on": below, "shaft": shaft} for name, below in on.items()}
    members = {name: {"kind": "gear", "teeth": teeth[name], **sitting.get(name, {})} for name in gears}
    main = {"module": 0.002, "face_width": 0.02, **members, "meshes": {"g1-g2": {}, "g3-g4": {}}}
    return {"format": 2, "title": "two steps", "stages": {"s": main}}


@pytest.mark.parametrize("shape", [{"torsional_rigidity": 5e5}, {"diameter": 0.03}])
def test_a_shaft_without_length_has_no_stiffness_by_its_shape(shape: dict[str, object]) -> None:
    with pytest.raises(ModelError, match="is missing") as caught:
        load(two_steps(("g1", "g2", "g3", "g4"), {"g3": "g2"}, **shape))
    assert caught.value.path == "stages.s.g3.shaft.length"
    train = load(two_steps(("g1", "g2", "g3", "g4"), {"g3": "g2"}, **shape, length=0.06))
    assert math.isfinite(link(train, "s/g3/shaft").stiffness[5])


def halves_of_a_carrier(support: dict[str, object]) -> Train:
    """A split carrier without a neck, both halves on a hub, planets in one piece."""
    main = {
        "planets": 3, "module": 0.004, "face_width": 0.04, "gap": 0.02, "herringbone": True, "helix_angle": 0.3,
        "sun": {"teeth": 24}, "planet": {"teeth": 24, "bearing": {"radial": 1e8}}, "ring": {"teeth": 72, "rim": 0.03},
        "carrier": {"mass": 20.0, "inertia": 0.2, "split": True, "support": support},
    }  # fmt: skip
    hub = {"hub": {"frame": "main", "mass": 1.0, "inertia": 1.0}}
    return load({"format": 2, "title": "halves", "stages": {"main": main}, "bodies": hub})


@pytest.mark.parametrize(
    ("support", "holds"),
    [
        ({"bolts": {"count": 4, "radius": 0.1}}, True),
        ({"bolts": {"count": 4, "radius": 0.1, "tangential": 1e8}}, True),
        ({"bolts": {"count": 4, "radius": 0.1, "tangential": 0}}, False),
        ({"front": {"radial": 1e8, "bolts": {"count": 4, "radius": 0.1}}}, True),
        ({"rz": 1e6}, True),
        ({"rz": {"deflection": [0, 1e-3], "force": [0, 1e3]}}, True),
        ({"radial": 1e8}, False),
    ],
)
def test_what_holds_the_halves_of_a_carrier(support: dict[str, object], holds: bool) -> None:
    if not holds:
        with pytest.raises(ModelError, match="nothing holds the left half"):
            halves_of_a_carrier({"to": "hub", **support})
        return
    links = halves_of_a_carrier({"to": "hub", **support}).links
    assert {entry.second for entry in links if entry.name.startswith("main/carrier/right/support")} == {"hub"}


@pytest.mark.parametrize("member", ["carrier", "sun"])
def test_places_on_halves_count_from_the_centre_of_the_member(member: str) -> None:
    """Bearings at -150 and 150 mm of a member at 10 mm; halves 40 mm wide beside a gap of 20 mm stand 30 mm off it."""
    main: dict[str, Any] = {
        "planets": 3, "module": 0.004, "face_width": 0.04, "gap": 0.02, "split": True, "helix_angle": 0.3,
        "sun": {"teeth": 24}, "planet": {"teeth": 24}, "ring": {"teeth": 72, "rim": 0.03},
        "carrier": {"mass": 20.0, "inertia": 0.2},
    }  # fmt: skip
    main |= {name: main[name] | {"neck": {}, "station": 0.01} for name in ("sun", "planet", "ring", "carrier")}
    front, rear = {"at": -0.15, "radial": 1e8}, {"at": 0.15, "radial": 1e8}
    main[member]["support"] = {"front": front, "rear": rear}
    push = {"on": member, "force": {"x": 1.0}, "at": 0.2}
    train = load({"format": 2, "title": "places", "stages": {"main": main}, "loads": {"push": push}})
    stations = {body.name: body.station for body in train.bodies}
    assert stations[f"main/{member}/left"] == pytest.approx(-0.02)
    ends = {entry.name: entry.station for entry in train.links if entry.path == f"stages.main.{member}.support.rear"}
    assert ends == {f"main/{member}/{side}/support/rear": pytest.approx(0.16) for side in ("left", "right")}
    assert [load.station for load in train.loads] == pytest.approx([0.21, 0.21])


@pytest.mark.parametrize("order", list(itertools.permutations(["g1", "g2", "g3", "g4"])))
@pytest.mark.parametrize("on", [{"g2": "g3"}, {"g3": "g2"}])
def test_places_of_gears_on_one_shaft_know_no_order(order: tuple[str, ...], on: dict[str, str]) -> None:
    """Axes 2 (20 + 40)/2 = 60 and 2 (25 + 50)/2 = 75 mm apart, whichever gear carries the other."""
    places = {body.member: body.centre for body in load(two_steps(order, on)).bodies}
    assert places["s.g2"] == places["s.g3"]
    assert math.dist(places["s.g1"], places["s.g2"]) == pytest.approx(0.060)
    assert math.dist(places["s.g3"], places["s.g4"]) == pytest.approx(0.075)


def test_a_carrier_without_planets_has_no_radius_for_a_stiffness_in_newtons() -> None:
    gear = {"support": {"radial": "1e9 N/m"}}
    stage: dict[str, Any] = {
        **{"module": "5 mm", "pinion": {"teeth": 20, **gear}, "wheel": {"teeth": 40, **gear}},
        "carrier": {"mass": "1 kg", "inertia": "1 kg m^2", "support": {"rz": "1e6 N/m"}},
    }
    operation = {"speed": {"pinion": "100 rpm", "carrier": "0 rpm"}}
    with pytest.raises(ModelError, match="no radius is known") as raised:
        load({"format": 2, "title": "x", "stages": {"main": stage}, "operation": operation})
    assert raised.value.path == "stages.main.carrier.support.rz"
