"""Bearings and splines as they are: closed forms of load sharing with play, friction and rolling elements."""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError

Array = NDArray[np.float64]
N, TORQUE, ERROR = 5, 308.9, 6e-6
K_SUN, K_RING, K_W, K_R = 8.6e9, 9.3e9, 1.78e7, 9.31e6
ANGLE = np.radians(20)


def stars(**support: Any) -> dict[str, Any]:
    """Five stepped stars between a sun in a spline and a sprung ring, spur, of one centre distance."""
    return {
        "format": 2,
        "title": "five stepped stars",
        "stages": {
            "main": {
                "planets": N,
                "sun": {"teeth": 24, "module": 2.75e-3, "support": {"radial": K_W, **support}},
                "star1": {"kind": "planet", "teeth": 22},
                "star2": {"kind": "planet", "teeth": 31, "on": "star1", "module": 126.5e-3 / 68, "station": 0.1},
                "ring": {"teeth": 99, "station": 0.1, "support": {"radial": K_R}},
                "meshes": {"sun-star1": {"stiffness": K_SUN}, "star2-ring": {"stiffness": K_RING}},
            }
        },
        "operation": {"speed": {"sun": 712.0}, "torque": {"sun": TORQUE}},
        "deviations": {"sun": {"run_out": ERROR}},
    }


def radii(model: dict[str, Any]) -> dict[str, float]:
    found = epicyclic.check(model).base_radius
    return {str(name): float(value) for name, value in zip(found.gear.values, found.values, strict=True)}


def shares(result: xr.Dataset, pair: str = "sun-star1") -> Array:
    force = result.mesh_force.values[[pair in str(name) for name in result.mesh.values]]
    return np.asarray(len(force) * force / force.sum(axis=0))


def wave(ratio: Array) -> Array:
    """Amplitude of the first harmonic over a record of one turn."""
    turn = np.exp(2j * np.pi * np.arange(ratio.shape[1]) / ratio.shape[1])
    return np.asarray(2 * np.abs(np.mean(ratio * turn, axis=1)))


def spline_force(R: float, friction: float, clearance: float) -> float:
    return min(K_W * R, friction) + K_W * max(R - friction / K_W - clearance, 0.0)


def spline_deflection(c0: float, friction: float, clearance: float) -> float:
    """R of c0 R + g(R) = c0 |E|, by halving."""
    low, high = 0.0, ERROR
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (
            (middle, high) if c0 * (middle - ERROR) + spline_force(middle, friction, clearance) < 0 else (low, middle)
        )
    return low


@pytest.mark.parametrize(
    ("friction", "clearance"), [(64.0, 0.0), (30.0, 1e-6), (30.0, 2e-6), (64.0, 2e-5), (1e4, 1e-5)]
)
def test_spline_closed_form(friction: float, clearance: float) -> None:
    """dong2019, section on the float: one first-harmonic error, equal spacing, closed meshes."""
    model = stars(clearance=clearance, friction={"force": friction})
    r = radii(model)
    rho = r["main/star1/1"] / r["main/star2/1"]
    c = 1 / K_SUN + rho**2 / K_RING
    c0 = (N / 2) / (c + (N / 2) * rho**2 / K_R)
    R = spline_deflection(c0, friction, clearance)
    result = epicyclic.static(model, turns=1, of="main/sun", samples=20)
    if clearance:
        # iterations stop at 1e-10 of the forces; R is 1e-3 of their terms
        np.testing.assert_allclose(result.group_stretch.values, R, rtol=1e-7)
        np.testing.assert_allclose(result.group_force.values, spline_force(R, friction, clearance), rtol=1e-7)
    amplitude = 2 * spline_force(R, friction, clearance) * r["main/sun"] / TORQUE
    # J - 1 is a pure wave of the sun's turn; its amplitude to the rounding of dense solves
    np.testing.assert_allclose(wave(shares(result)), amplitude, atol=1e-10)
    np.testing.assert_allclose(shares(result, "star2-ring"), shares(result), atol=1e-10)  # a star is in balance


def test_slip_start_is_derived_from_the_torque() -> None:
    model = stars(clearance=2e-5, friction={"coefficient": 0.1, "radius": 0.02})
    system = epicyclic.assemble(epicyclic.load(model))
    (group,) = system.groups
    assert group.law.friction == pytest.approx(0.1 * TORQUE / 0.02, rel=1e-12)
    assert group.law.slip_start == pytest.approx(0.1 * TORQUE / 0.02 / K_W, rel=1e-12)
    assert "main/sun/support" not in system.links.link
    said = json.loads(epicyclic.static(system, cycles=1, samples=1).attrs["laws"])["main/sun/support"]
    assert said["slip_start"] == group.law.slip_start
    assert said["kind"] == "holonomic spline"
    del model["operation"]["torque"]
    with pytest.raises(ModelError, match=r"stages\.main\.sun\.support\.friction\.coefficient = 0\.1.*friction\.force"):
        epicyclic.assemble(epicyclic.load(model))


def test_on_the_plateau_sharing_does_not_depend_on_the_torque() -> None:
    def excess(torque: float, **support: Any) -> float:
        model = stars(**support)
        model["operation"]["torque"]["sun"] = torque
        return float(wave(shares(epicyclic.static(model, turns=1, of="main/sun", samples=20)))[0])

    slipping = {"clearance": 5e-5, "friction": {"coefficient": 0.001, "radius": 0.02}}
    assert excess(200.0, **slipping) == pytest.approx(excess(370.0, **slipping), rel=1e-7)
    assert excess(200.0) * 200 == pytest.approx(excess(370.0) * 370, rel=1e-7)  # elastic: as 1/torque


@pytest.mark.parametrize("law", ["holonomic", "coulomb"])
def test_limits_of_clearance_and_friction(law: str) -> None:
    """No clearance or endless friction: linear; no friction: play."""
    linear = epicyclic.static(stars(), turns=1, of="main/sun", samples=16).mesh_force.values
    for limit in (
        {"clearance": 1e-20, "friction": {"force": 30.0, "law": law}},
        {"clearance": 2e-5, "friction": {"force": 1e9, "law": law}},
    ):
        found = epicyclic.static(stars(**limit), turns=1, of="main/sun", samples=16).mesh_force.values
        # iterations stop at 1e-10 of the largest force
        np.testing.assert_allclose(found, linear, rtol=2e-10)
    play = epicyclic.static(stars(clearance=2e-6), turns=1, of="main/sun", samples=16).mesh_force.values
    loose = stars(clearance=2e-6, friction={"force": 1e-7, "law": law})
    found = epicyclic.static(loose, turns=1, of="main/sun", samples=16).mesh_force.values
    np.testing.assert_allclose(found, play, atol=1e-6)  # the friction force itself


def test_friction_without_clearance_is_said_to_have_no_effect() -> None:
    result = epicyclic.static(stars(friction={"force": 30.0}), turns=1, of="main/sun", samples=4)
    assert any("friction has no effect" in text for text in json.loads(result.attrs["warnings"]))


def test_coulomb_has_the_same_peak_and_another_history() -> None:
    """Loads that turn with several bodies: the float changes direction, which real friction resists."""
    histories = {}
    for law in ("holonomic", "coulomb"):
        model = stars(clearance=5e-6, friction={"force": 30.0, "law": law})
        model["deviations"]["star1"] = {"run_out": 6e-6}
        model["deviations"]["ring"] = {"run_out": 6e-6}
        result = epicyclic.static(model, turns=11, of="main/sun", samples=8)
        assert result.attrs["laws"].count(f"{law} spline") == 1
        assert ("warm-up over 11 turns of main/sun" in result.attrs["history"]) == (law == "coulomb")
        histories[law] = shares(result)
    difference = np.abs(histories["coulomb"] - histories["holonomic"])
    assert difference.max() > 2e-3
    assert abs(histories["coulomb"].max() - histories["holonomic"].max()) < 0.05 * (histories["holonomic"].max() - 1)


def two_pins(clearance: list[float], torque: float) -> dict[str, Any]:
    """Two planets between a sun, a ring and a held carrier that stand firm, pins with play."""
    return {
        "format": 2,
        "title": "two pins",
        "stages": {
            "main": {
                "planets": 2,
                "module": 4e-3,
                "sun": {"teeth": 24},
                "planet": {"teeth": 24, "bearing": {"radial": 2e8, "clearance": clearance}},
                "ring": {"teeth": 72},
                "carrier": {},
                "meshes": {"sun-planet": {"stiffness": 5e8}, "planet-ring": {"stiffness": 4e8}},
            }
        },
        "operation": {"held": ["carrier"], "torque": {"sun": torque}},
    }


@pytest.mark.parametrize(("play", "torque"), [([5e-6, 5e-6], 400.0), ([1e-6, 7e-6], 400.0), ([4e-6, 30e-6], 60.0)])
def test_play_on_two_pins(play: list[float], torque: float) -> None:
    """A pin carries 2 F cos(alpha), tangentially: r theta = F (1/k_s + 1/k_r + 4 cos^2/k_p) + 2 cos(alpha) play."""
    model = two_pins(play, torque)
    r = radii(model)["main/sun"]
    C = 1 / 5e8 + 1 / 4e8 + 4 * np.cos(ANGLE) ** 2 / 2e8
    difference = 2 * np.cos(ANGLE) * (play[1] - play[0]) / C
    first = min(torque / r, (torque / r + difference) / 2)
    result = epicyclic.static(model, cycles=1, samples=1)
    # Newton stops at 1e-10 of the forces
    np.testing.assert_allclose(result.mesh_force.values[:, 0], [first, torque / r - first] * 2, atol=1e-8 * torque / r)
    pins = 2 * np.cos(ANGLE) * np.array([first, torque / r - first])
    np.testing.assert_allclose(result.group_force.values[:, 0], pins, atol=1e-8 * torque / r)
    carries = torque / r - first > 0
    assert result.group_state.values[:, 0].tolist() == ["stop", "stop" if carries else "play"]
    assert result.mesh_contact.values[:, 0].tolist() == [True, carries] * 2  # both meshes of a lost branch open


def test_rolling_elements_on_pins() -> None:
    """The same pins with F ~ delta^(10/9): at the stated load the linear answer, stretch n = 10/9 times its own."""
    model = two_pins([0.0, 0.0], 400.0)
    load = 2 * np.cos(ANGLE) * 400.0 / radii(model)["main/sun"] / 2
    model["stages"]["main"]["planet"]["bearing"] = {"radial": 2e8, "exponent": 10 / 9, "load": float(load)}
    result = epicyclic.static(model, cycles=1, samples=1)
    np.testing.assert_allclose(result.group_force.values, load, rtol=1e-9)
    np.testing.assert_allclose(result.group_stretch.values, 10 / 9 * load / 2e8, rtol=1e-8)


def floating(**changes: Any) -> dict[str, Any]:
    """Three planets, a sun that floats, standing carrier, pins on bearings."""
    model = two_pins([0.0, 0.0], 400.0)
    stage = model["stages"]["main"]
    stage |= {"planets": 3, "face_width": 0.04}
    stage["sun"] = {"teeth": 24, "support": {"radial": 0}}
    stage["planet"] = {"teeth": 24, "bearing": {"radial": 2e8} | changes.get("bearing", {})}
    model["operation"] |= {"speed": {"sun": 100.0}, "gravity": changes.get("gravity", False)}
    model["deviations"] = {"planet": {"position": {"y": [2e-5, 0, 0]}}}
    return copy.deepcopy(model)


def test_three_planets_and_a_floating_sun_are_equal_only_without_gravity() -> None:
    """Errors and play leave three planets equal: two equations of lateral balance, one of torque.  Weight does not:

    F_i = F_0 - 2/3 W . a_i with a_i the direction in which mesh i pushes the sun.
    """

    def excess(**changes: Any) -> float:
        result = epicyclic.sharing(floating(**changes), method="static", cycles=1, samples=8)
        return float(result.system_load_sharing.sel(definition="simultaneous")) - 1

    loose = {"clearance": [2e-5, 5e-5, 1e-5]}
    assert excess() < 1e-9
    assert excess(bearing=loose) < 1e-9  # play alone is an error like any other
    check = epicyclic.check(floating(gravity=True))
    weight = 9.81 * check.mass.sel(body="main/sun").item()
    angle = 2 * np.pi * np.arange(3) / 3 - (np.pi / 2 - ANGLE)  # of -a_i for a sun turned counter-clockwise
    share = 400.0 / radii(floating())["main/sun"] / 3
    expected = 2 / 3 * weight * np.max(-np.sin(angle + np.pi)) / share
    assert expected > 1e-3
    for bearing in ({}, loose):
        assert excess(gravity=True, bearing=bearing) == pytest.approx(expected, rel=1e-6)


def test_carrier_of_two_plates_tilts_its_pins() -> None:
    """Half of the torque passes the neck between the plates and winds it by T l/(G I_p); each holds a bearing row."""
    rigidity, length, span, torque = 2e5, 0.05, 0.03, 1000.0
    model = two_pins([0.0, 0.0], torque)
    stage = model["stages"]["main"]
    stage |= {"planets": 3, "face_width": 0.04, "ring": {"teeth": 72}}
    stage["carrier"] = {"split": True, "neck": {"torsional_rigidity": rigidity, "length": length}}
    for mesh in stage["meshes"].values():
        mesh["slices"] = 1  # teeth that do not hold the tilt of the pins
    row = {"radial": 4e8}
    stage["planet"]["bearing"] = {"front": {"at": -span / 2, **row}, "rear": {"at": span / 2, **row}}
    model["operation"] = {"held": ["ring"], "torque": {"sun": torque, "carrier": {"right": "balance"}}}
    train = epicyclic.load(model)
    ends = {link.name: link.first for link in train.links if link.kind == "bearing"}
    assert ends["main/planet/2/bearing/front"] == "main/carrier/left"
    assert ends["main/planet/2/bearing/rear"] == "main/carrier/right"
    assert len(ends) == 6
    result = epicyclic.static(train, cycles=1, samples=1)
    wind_up = torque * (1 + 72 / 24) / 2 * length / rigidity
    tilt = [result.displacement.sel(dof=f"main/planet/{i}/rx").item() for i in (1, 2, 3)]
    np.testing.assert_allclose(tilt, wind_up * 0.096 / span, rtol=1e-9)  # a dense solve, condition 1e5
    # play in the rear row lets that end of the planet run on, which takes some of the tilt back
    stage["planet"]["bearing"]["rear"]["clearance"] = 3e-5
    loose = epicyclic.static(model, cycles=1, samples=1)
    moved = [loose.displacement.sel(dof=f"main/planet/{i}/rx").item() for i in (1, 2, 3)]
    assert set(loose.group_state.values.ravel()) == {"stop"}
    np.testing.assert_allclose(np.array(moved) - tilt, -3e-5 / span, rtol=1e-9)
