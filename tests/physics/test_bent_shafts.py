"""Shafts on several bearings that bend: closed beam formulas, and beams of many short elements assembled here."""

from __future__ import annotations

import cmath
import math
import tomllib
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.optimize import fsolve

from epicyclic import life, modes, static
from epicyclic.system.assembly import assemble
from epicyclic.train.resolution import load
from epicyclic.train.train import bodies_named

Array = NDArray[np.float64]
E, NU, RHO = 206e9, 0.3, 7850.0
G = E / (2 * (1 + NU))
P = 1000.0


class Cylinder:
    """A section with from, to, outer and inner diameter [m], as this file needs it."""

    def __init__(self, start: float, end: float, diameter: float, bore: float = 0.0) -> None:
        self.start, self.end, self.diameter, self.bore = start, end, diameter, bore
        self.area = math.pi / 4 * (diameter**2 - bore**2)
        self.second = math.pi / 64 * (diameter**4 - bore**4)
        m = bore / diameter  # [cowper1966]
        wide = (1 + m**2) ** 2
        kappa = 6 * (1 + NU) * wide / ((7 + 6 * NU) * wide + (20 + 12 * NU) * m**2)
        self.bending, self.shear = E * self.second, kappa * G * self.area

    @property
    def table(self) -> dict[str, str]:
        keys = {"from": self.start, "to": self.end, "diameter": self.diameter, "bore": self.bore}
        return {key: f"{value!r} m" for key, value in keys.items()}


def element(c: Cylinder, length: float) -> tuple[Array, Array]:
    """Stiffness of a Timoshenko element, deflection and slope of both ends, and its mass, which stays straight."""
    phi = 12 * c.bending / (c.shear * length**2)
    k = np.array([[12, 6, -12, 6], [6, 4 + phi, -6, 2 - phi], [-12, -6, 12, -6], [6, 2 - phi, -6, 4 + phi]])
    k *= np.outer([1, length, 1, length], [1, length, 1, length]) * c.bending / (length**3 * (1 + phi))
    m = np.kron([[2, 1], [1, 2]], np.diag([c.area, c.second])) * RHO * length / 6
    return k, m


def fine_beam(cylinders: Sequence[Cylinder], places: Sequence[float], each: int) -> tuple[Array, Array, list[int]]:
    """Stiffness, mass, and number of the deflection at each of the places, of a beam of many elements."""
    ends = sorted({*places, *(c.start for c in cylinders), *(c.end for c in cylinders)})
    nodes = np.unique(np.concatenate([np.linspace(a, b, each + 1) for a, b in pairwise(ends)]))
    K, M = np.zeros((2, 2 * nodes.size, 2 * nodes.size))
    for i, (a, b) in enumerate(pairwise(nodes)):
        own = next(c for c in cylinders if c.start <= (a + b) / 2 <= c.end)
        k, m = element(own, b - a)
        K[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += k
        M[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += m
    return K, M, [2 * int(np.abs(nodes - place).argmin()) for place in places]


def shaft(
    cylinders: Sequence[Cylinder], bearings: Mapping[str, tuple[float, float]], loads: Any = None, **body: str
) -> dict[str, Any]:
    """A shaft about z = 0 on bearings (place [m], stiffness [N/m]), beside a pair of gears that a model needs."""
    named = {name: {"at": f"{at!r} m", "radial": f"{k!r} N/m"} for name, (at, k) in bearings.items()}
    first = next(iter(named.values()))
    first |= {"z": "1e9 N/m", "rz": "1e6 N m/rad"}
    force = {"pull": {"on": "shaft", "force": {"y": f"{P} N"}}} if loads is None else loads
    gear = {"mass": "1 kg", "inertia": "1 kg m^2"}
    return {
        "format": 2,
        "title": "a shaft",
        "material": {"youngs_modulus": f"{E} Pa", "poisson_ratio": NU, "density": f"{RHO} kg/m^3"},
        "stages": {
            "s": {
                **{"module": "3 mm", "face_width": "20 mm", "meshes": {"pinion-wheel": {"stiffness": "1e8 N/m"}}},
                **{"pinion": {"teeth": 20, **gear}, "wheel": {"teeth": 40, **gear}},
            }
        },
        "bodies": {"shaft": {"support": named, "shaft_sections": [c.table for c in cylinders], **body}},
        "loads": force,
        "operation": {"torque": {"pinion": "1 N m"}},
    }


def forces(result: xr.Dataset, axis: str = "y") -> dict[str, float]:
    """Mean force through every support of the result, by the name behind its member."""
    rows = zip(map(str, result.link_row.values), result.link_force.values.mean(axis=1), strict=True)
    return {
        name.split("/support/")[1].removesuffix(f"/{axis}"): float(value)
        for name, value in rows
        if "/support/" in name and name.endswith(f"/{axis}")
    }


def two_bearings(near: float, far: float, force: complex, lever: complex) -> NDArray[np.complex128]:
    """Forces on two bearings at their places [m] under a force and the sum of forces times their places [N m]."""
    return np.linalg.solve(np.array([[1, 1], [near, far]]), np.array([force, lever]))


def moved(result: xr.Dataset, name: str) -> float:
    return float(result.displacement.sel(dof=name)[0])


@pytest.mark.parametrize("slenderness", [2.0, 8.0, 200.0])
def test_two_equal_spans_on_three_bearings(slenderness: float) -> None:
    """Statically indeterminate: reactions by the force method with shear; slender 13, 22, -3 / 32."""
    span = 0.8
    c = Cylinder(-span / 2, 1.5 * span, span / slenderness)
    rigid = min(1e9 * c.bending / span**3, 1e16)
    result = static(shaft([c], {"a": (-span / 2, rigid), "b": (span / 2, rigid), "c": (1.5 * span, rigid)}))
    phi = c.bending / (c.shear * span**2)
    b = P * (11 / 96 + phi / 4) / (1 / 6 + phi / 2)
    expected = {"a": 3 / 4 * P - b / 2, "b": b, "c": P / 4 - b / 2}
    assert forces(result) == pytest.approx(expected, abs=1e-6 * P)
    if slenderness > 100:
        assert [32 * force / P for force in expected.values()] == pytest.approx([13, 22, -3], abs=2e-3)
    # at the load: the beam on a and c alone, less what b lifts; a moment M shears a simple beam by M/(kappa G A)
    simple = P * (span / 2 * 3 * span / 2) ** 2 / (3 * c.bending * 2 * span) + 3 / 8 * P * span / c.shear
    lifted = b * (11 / 96 * span**3 / c.bending + span / 4 / c.shear)
    assert moved(result, "shaft/y") == pytest.approx(simple - lifted, rel=1e-6)


def test_an_overhung_gear_on_two_elastic_bearings() -> None:
    a, b = 0.12, 0.3
    c = Cylinder(-a - b, 0.0, 0.06, 0.02)
    near, far = 3e8, 2e8
    result = static(shaft([c], {"far": (-a - b, far), "near": (-a, near)}))
    reaction = {"near": P * (1 + a / b), "far": -P * a / b}
    assert forces(result) == pytest.approx(reaction, rel=1e-9)
    sunk = {"near": reaction["near"] / near, "far": reaction["far"] / far}
    rigid = sunk["near"] + (sunk["near"] - sunk["far"]) * a / b
    beam = P * a**2 * (a + b) / (3 * c.bending) + P * a * (1 + a / b) / c.shear
    assert moved(result, "shaft/y") == pytest.approx(rigid + beam, rel=1e-9)
    slope = (sunk["near"] - sunk["far"]) / b + P * a * (2 * b + 3 * a) / (6 * c.bending) + P * a / (b * c.shear)
    assert -moved(result, "shaft/rx") == pytest.approx(slope, rel=1e-9)


STEPPED = [
    Cylinder(-0.35, -0.2, 0.05),
    Cylinder(-0.2, -0.02, 0.07, 0.02),
    Cylinder(-0.02, 0.1, 0.11),
    Cylinder(0.1, 0.24, 0.06, 0.03),
    Cylinder(0.24, 0.5, 0.045),
]
SEATS = {"front": (-0.3, 2e8), "middle": (0.18, 4e8), "rear": (0.44, 1e8)}


def test_a_stepped_shaft_is_that_of_many_elements() -> None:
    """Forces in both planes, at the body and at a place of its own: every deflection and slope, every bearing."""
    loads = {
        "gear": {"on": "shaft", "force": {"x": "-700 N", "y": "1000 N"}, "moment": {"x": "40 N m"}},
        "belt": {"on": "shaft", "force": {"y": "-300 N"}, "at": "-0.1 m"},
    }
    result = static(shaft(STEPPED, SEATS, loads))
    names = {
        "shaft": 0.0,
        "shaft/shaft/load/belt": -0.1,
        **{f"shaft/shaft/{key}": at for key, (at, _) in SEATS.items()},
    }
    K, _, at = fine_beam(STEPPED, list(names.values()), 6)
    for (_, stiffness), row in zip(SEATS.values(), at[2:], strict=True):
        K[row, row] += stiffness
    f = np.zeros((len(K), 2))
    f[at[0]], f[at[1], 0] = (1000, -700), -300
    f[at[0] + 1, 0] = -40  # a slope is a turn about -x
    u = np.linalg.solve(K, f)
    scale = np.abs(u[at]).max()
    for name, row in zip(names, at, strict=True):
        found = [moved(result, f"{name}/{axis}") for axis in ("y", "x")]
        assert found == pytest.approx(u[row].tolist(), abs=1e-8 * scale)
        turned = [-moved(result, f"{name}/rx"), moved(result, f"{name}/ry")]
        assert turned == pytest.approx(u[row + 1].tolist(), abs=1e-8 * np.abs(u[1::2]).max())
    for (name, (_, stiffness)), row in zip(SEATS.items(), at[2:], strict=True):
        assert forces(result)[name] == pytest.approx(stiffness * u[row, 0], rel=1e-7)


def test_torsion_and_axial_stiffness_in_series() -> None:
    loads = {"end": {"on": "shaft", "force": {"z": "5 kN"}, "moment": {"z": "200 N m"}, "at": "0.4 m"}}
    result = static(shaft(STEPPED, SEATS, loads))
    cut = [(c, max(c.start, -0.3), min(c.end, 0.4)) for c in STEPPED]
    twist = sum(200 * (b - a) / (G * 2 * c.second) for c, a, b in cut)
    pull = sum(5e3 * (b - a) / (E * c.area) for c, a, b in cut)
    for axis, expected in (("rz", twist), ("z", pull)):
        found = moved(result, f"shaft/shaft/load/end/{axis}") - moved(result, f"shaft/shaft/front/{axis}")
        assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("wheel", "error"), [(60.0, 0.02), (8.0, 0.07)])
def test_the_first_bending_mode(wheel: float, error: float) -> None:
    """Mass lumped at four places: 1.5 and 6 % off beside wheels of 60 and 8 kg on a shaft of 22 kg; a place more in
    every span leaves a quarter of it."""
    tilt = wheel * 0.01
    stated = {"mass": f"{wheel} kg", "inertia": f"{2 * tilt} kg m^2", "tilt_inertia": f"{tilt} kg m^2"}
    K, M, at = fine_beam(STEPPED, [0.0, *(place for place, _ in SEATS.values())], 6)
    for (_, stiffness), row in zip(SEATS.values(), at[1:], strict=True):
        K[row, row] += stiffness
    M[at[0], at[0]] += wheel
    M[at[0] + 1, at[0] + 1] += tilt
    first = math.sqrt(eigh(K, M, eigvals_only=True, subset_by_index=[0, 0])[0]) / (2 * math.pi)
    more = {f"m{i}": (at, 0.0) for i, at in enumerate((-0.15, 0.09, 0.31))}
    for seats, allowed in ((SEATS, error), (SEATS | more, error / 4)):
        result = modes(shaft(STEPPED, seats, {}, **stated))
        lateral = np.abs(result.full_shape.sel(body="shaft", direction="y").values)
        assert result.frequency.values[lateral > 0.3 * lateral.max()].min() == pytest.approx(first, rel=allowed)


def test_the_mode_of_a_span_with_clamped_ends() -> None:
    """Slender 22.37 sqrt(E I / (rho A l^4)); of stepped and stubby ones that of many elements."""
    slender = Cylinder(-1.0, 0.0, 0.02)
    (span,) = load(shaft([slender], {"end": (-1.0, 1e9)})).spans
    assert span.frequency == pytest.approx(
        22.3733 / (2 * math.pi) * math.sqrt(slender.bending / (RHO * slender.area)), rel=0.01
    )
    assert span.mass == pytest.approx(RHO * slender.area)
    for span, (start, end) in zip(
        load(shaft(STEPPED, SEATS)).spans, [(-0.3, 0.0), (0.0, 0.18), (0.18, 0.44)], strict=True
    ):
        cut = [Cylinder(max(c.start, start), min(c.end, end), c.diameter, c.bore) for c in STEPPED]
        K, M, _ = fine_beam([c for c in cut if c.end > c.start], [start, end], 8)
        lowest = eigh(K[2:-2, 2:-2], M[2:-2, 2:-2], eigvals_only=True, subset_by_index=[0, 0])[0]
        assert span.frequency == pytest.approx(math.sqrt(lowest) / (2 * math.pi), rel=0.01)


# --- a wind gearbox: a planetary stage, then a parallel one --------------------------------------------------------

TEETH, MODULE, HELIX, FACE = (90, 22), 0.01, math.radians(12), 0.2
HIGH = [Cylinder(-0.35, -0.1, 0.12), Cylinder(-0.1, 0.1, 0.16), Cylinder(0.1, 0.4, 0.11)]
WIND = f"""
format = 2
title = "Two-stage wind gearbox"

[stages.low]
planets = 3
module = "14 mm"
face_width = "240 mm"
sun = {{ teeth = 21, support.radial = 0 }}
planet = {{ teeth = 39, bore = "320 mm", bearing.radial = "4e9 N/m" }}
ring = {{ teeth = 99, rim = "60 mm" }}
carrier = {{ mass = "2500 kg", inertia = "700 kg m^2", support.radial = "4e9 N/m" }}

[stages.high]
module = "{MODULE} m"
helix_angle = "12 deg"
face_width = "{FACE} m"
meshes.wheel-pinion.slices = 1

[stages.high.wheel]
teeth = {TEETH[0]}
bore = "220 mm"
shaft_sections = [{{ from = "-240 mm", to = "260 mm", diameter = "220 mm" }}]
support.locating = {{ at = "-180 mm", radial = "1.5e9 N/m", z = "9e8 N/m" }}
support.floating = {{ at = "210 mm", radial = "1.2e9 N/m" }}

[stages.high.pinion]
teeth = {TEETH[1]}
bore = "160 mm"
direction = "50 deg"
shaft_sections = [{", ".join(str(c.table).replace(":", " =").replace("'from'", "from") for c in HIGH)}]

[stages.high.pinion.support]
rotor = {{ at = "-290 mm", radial = "8e8 N/m" }}
middle = {{ at = "170 mm", radial = "6e8 N/m" }}
generator = {{ at = "350 mm", radial = "5e8 N/m", z = "4e8 N/m" }}

[couplings.sun]
between = ["low.sun", "high.wheel"]
rz = "5e7 N m/rad"

[operation]
held = ["low.ring"]
speed.low.carrier = "20 rpm"
power.low.carrier = "1 MW"
torque.high.pinion = "balance"
"""
HIGH_SEATS = {"rotor": (-0.29, 8e8), "middle": (0.17, 6e8), "generator": (0.35, 5e8)}


def tooth_force(result: xr.Dataset) -> tuple[complex, float, complex]:
    """By hand, on the pinion: force across [N], along z, and moment about its centre [N m], x + i y, z.

    Tangential T/r, radial that times tan alpha_t away from the wheel, axial that times tan beta along the trace of the
    tooth.  The contact lies at -r e with e from wheel to pinion, t = z cross e.
    """
    radius = TEETH[1] * MODULE / math.cos(HELIX) / 2
    e = np.exp(1j * math.radians(50))
    train = load(MODEL)
    hand = next(body.gear.hand for body in train.bodies if body.name == "high/pinion" and body.gear)
    along = train.torques["high/pinion"] / radius
    transverse = math.tan(math.radians(20)) / math.cos(HELIX)
    axial = hand * along * math.tan(HELIX)
    return along * 1j * e + abs(along) * transverse * e, axial, radius * axial * 1j * e


MODEL = tomllib.loads(WIND)


@pytest.fixture(scope="module")
def wind() -> xr.Dataset:
    return static(MODEL)


def seats(result: xr.Dataset, member: str) -> dict[str, complex]:
    """Mean force across every bearing of a member of the second stage, x + i y."""
    of_member = result.sel(link_row=[name for name in result.link_row.values if f"high/{member}/support" in str(name)])
    x, y = (forces(of_member, axis) for axis in "xy")
    return {name: complex(x[name], y[name]) for name in x}


def test_two_bearings_of_the_wheel_by_hand(wind: xr.Dataset) -> None:
    """Statically determinate: f_1 + f_2 = F, z_1 f_1 + z_2 f_2 = -i M; the locating bearing takes the thrust."""
    force, axial, moment = tooth_force(wind)
    ratio = TEETH[0] / TEETH[1]
    force, axial, moment = -force, -axial, moment * ratio  # at + r e of the wheel, the force turned round
    expected = two_bearings(-0.18, 0.21, force, -1j * moment)
    found = seats(wind, "wheel")
    assert [found["locating"], found["floating"]] == pytest.approx(expected.tolist(), rel=1e-6)
    assert forces(wind, "z")["locating"] == pytest.approx(axial, rel=1e-6)


def test_three_bearings_of_the_high_speed_shaft(wind: xr.Dataset) -> None:
    """By many elements under the force by hand; rigid, the same shaft would share it in another way."""
    force, axial, moment = tooth_force(wind)
    K, _, at = fine_beam(HIGH, [0.0, *(place for place, _ in HIGH_SEATS.values())], 6)
    for (_, stiffness), row in zip(HIGH_SEATS.values(), at[1:], strict=True):
        K[row, row] += stiffness
    f = np.zeros(len(K), complex)
    f[at[0]], f[at[0] + 1] = force, -1j * moment
    u = np.linalg.solve(K, f)
    expected = {name: k * u[row] for (name, (_, k)), row in zip(HIGH_SEATS.items(), at[1:], strict=True)}
    found = seats(wind, "pinion")
    for name, one in expected.items():
        assert found[name] == pytest.approx(one, abs=1e-6 * abs(force))
    assert forces(wind, "z")["generator"] == pytest.approx(axial, rel=1e-6)
    rigid = static(MODEL, overrides={"stages.high.pinion.shaft_sections": None})
    assert abs(seats(rigid, "pinion")["middle"] - found["middle"]) > 0.2 * abs(force)


# --- an intermediate shaft with gears of two stages, and bearings by their parts -----------------------------------

INTERMEDIATE = Cylinder(-0.2, 0.45, 0.14)
ROLLER = {
    **{"type": "cylindrical roller", "elements": 20, "element_diameter": "24 mm", "element_length": "24 mm"},
    **{"pitch_diameter": "200 mm", "internal_clearance": "40 um"},
}


def two_pairs(supports: dict[str, Any]) -> dict[str, Any]:
    """Two spur pairs in series; the pinion of the first and the wheel of the second sit on one shaft."""
    gear = {"mass": "30 kg", "inertia": "1 kg m^2"}
    mesh = {"meshes": {"wheel-pinion": {"stiffness": "2e9 N/m", "slices": 1}}}
    free = {"support": {"radial": "1e9 N/m"}}
    joint = {"between": ["first.pinion", "second.wheel"], "radial": "inf", "tilt": "inf", "z": "inf", "rz": "inf"}
    shaft_of = {"shaft_sections": [INTERMEDIATE.table], "support": supports, "direction": "30 deg"}
    stage = {"module": "8 mm", "face_width": "120 mm", **mesh}
    return {
        "format": 2,
        "title": "two pairs",
        "stages": {
            "first": {**stage, "wheel": {"teeth": 80, **gear, **free}, "pinion": {"teeth": 20, **gear, **shaft_of}},
            "second": {
                **stage,
                "wheel": {"teeth": 60, "station": "0.25 m", "support": {"radial": 0, "tilt": 0, "z": 0}, **gear},
                "pinion": {"teeth": 20, "station": "0.25 m", **gear, **free, "direction": "-70 deg"},
            },
        },
        "couplings": {"one_shaft": joint},
        "operation": {
            "speed": {"first.wheel": "60 rpm"},
            "torque": {"first.wheel": "8 kN m", "second.pinion": "balance"},
        },
    }


def spur_force(torque: float, radius: float, towards: float) -> complex:
    """On a gear whose external torque this is, from the mate that lies at this polar angle [rad]."""
    e = cmath.rect(1, towards)
    return -torque / radius * 1j * e - abs(torque) / radius * math.tan(math.radians(20)) * e


def on_the_intermediate() -> tuple[complex, complex]:
    """Forces of the two meshes on it: 2 kN m come in at 80 mm radius, and go out at 240 mm."""
    return spur_force(2000.0, 0.08, math.radians(30) + math.pi), spur_force(-2000.0, 0.24, math.radians(-70))


@pytest.fixture(scope="module")
def by_parts() -> dict[str, Any]:
    return two_pairs({"left": {"at": "-0.15 m", **ROLLER}, "right": {"at": "0.4 m", **ROLLER}})


def test_two_bearings_under_two_gears_by_hand() -> None:
    """A gear of another stage sits on the shaft by a rigid coupling: levers of both forces share them out."""
    springs = {"radial": "8e8 N/m"}
    result = static(
        two_pairs({"left": {"at": "-0.15 m", **springs, "z": "1e9 N/m"}, "right": {"at": "0.4 m", **springs}})
    )
    first, second = on_the_intermediate()
    expected = two_bearings(-0.15, 0.4, first + second, 0.25 * second)
    x, y = forces(result), forces(result, "x")
    assert [complex(y[name], x[name]) for name in ("left", "right")] == pytest.approx(expected.tolist(), rel=1e-6)
    bodies = {body.name: body for body in load(two_pairs({"left": {"at": "-0.15 m", **springs}})).bodies}
    assert bodies["first/pinion/shaft/second/wheel"].station == 0.25


def test_the_life_of_bearings_by_parts_by_hand(by_parts: dict[str, Any]) -> None:
    """Radial rollers on two places: their loads are those by hand, L10 = (C/P)^(10/3) revolutions."""
    first, second = on_the_intermediate()
    load_of = np.abs(two_bearings(-0.15, 0.4, first + second, 0.25 * second))
    result = life(by_parts)
    assert result.bearing_load.values.ravel() == pytest.approx(load_of.tolist(), rel=1e-6)
    revolutions = 1e6 * (result.bearing_rating.values / load_of) ** (10 / 3)
    expected = revolutions / (4 * 60 / 60)  # the pinion turns four times as fast as 60 rpm
    assert result.bearing_life_basic.values.ravel() == pytest.approx(expected.tolist(), rel=1e-6)


def test_three_bearings_by_parts(by_parts: dict[str, Any]) -> None:
    """Indeterminate, with clearance and the law of the rollers: the beam of many elements on the same law."""
    supports = {"left": -0.15, "middle": 0.13, "right": 0.4}
    model = two_pairs({name: {"at": f"{at} m", **ROLLER} for name, at in supports.items()})
    curve = next(link for link in load(model).links if link.rolling is not None).curves[0][1]
    K, _, at = fine_beam([INTERMEDIATE], [0.0, 0.25, *supports.values()], 4)
    rest = [row for row in range(len(K)) if row not in at]
    of_places = K[np.ix_(at, at)] - K[np.ix_(at, rest)] @ np.linalg.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, at)])
    across = np.array([*on_the_intermediate(), 0, 0, 0])

    def left_over(flat: Array) -> Array:
        w = flat.view(complex)
        size = np.abs(w[2:])
        pressed = np.array([0, 0, *np.interp(size, curve.deflection, curve.force) / size]) * w
        return np.asarray((of_places @ w + pressed - across).view(float))

    start = 5e-5 * np.exp(1j * np.angle(across.sum())) * np.ones(5)
    w = fsolve(left_over, start.view(float)).view(complex)
    assert np.abs(left_over(w.view(float))).max() < 1e-3
    expected = np.interp(np.abs(w[2:]), curve.deflection, curve.force)
    assert life(model).bearing_load.values.ravel() == pytest.approx(expected.tolist(), rel=2e-3)


# --- beside the rigid member -----------------------------------------------------------------------------------------

PLANETS = """
format = 2
title = "planets with shafts"
material.youngs_modulus = "1e6 GPa"

[stages.main]
planets = 3
module = "4 mm"
helix_angle = "12 deg"
face_width = "50 mm"
meshes.sun-planet.stiffness = "1e9 N/m"
meshes.planet-ring.stiffness = "1e9 N/m"
ring = { teeth = 84, mass = "20 kg", inertia = "1 kg m^2", tilt_inertia = "0.5 kg m^2" }

[stages.main.carrier]
mass = "40 kg"
inertia = "0.5 kg m^2"
tilt_inertia = "0.4 kg m^2"
support.front = { at = "-150 mm", radial = "6e8 N/m", z = "5e8 N/m" }
support.rear = { at = "180 mm", radial = "5e8 N/m" }

[stages.main.sun]
teeth = 24
mass = "3 kg"
inertia = "0.01 kg m^2"
tilt_inertia = "0.02 kg m^2"
support.near = { at = "90 mm", radial = "2e7 N/m", z = "1e8 N/m" }
support.far = { at = "200 mm", radial = "3e7 N/m" }

[stages.main.planet]
teeth = 30
mass = "3 kg"
inertia = "0.01 kg m^2"
tilt_inertia = "0.02 kg m^2"
bearing.front = { at = "-40 mm", radial = "3e8 N/m", z = "4e8 N/m" }
bearing.rear = { at = "50 mm", radial = "4e8 N/m" }

[operation]
held = ["ring"]
speed.sun = "1500 rpm"
torque.sun = "800 N m"

[deviations]
planet.run_out = "12 um"
planet.bearing_run_out = "9 um"
planet.position.y = "[20, 0, 5] um"
planet.tilt = { x = "[0.3, 0, 0] mrad", y = "[0, 0.2, 0] mrad" }
sun.tilt.x = "0.4 mrad"

[loads.belt]
on = "sun"
force = { x = "2 kN" }
at = "200 mm"
"""
BENT = {
    "planet": ("-45 mm", "60 mm"),
    "sun": ("-10 mm", "220 mm"),
    "carrier": ("-150 mm", "180 mm"),
}


@pytest.fixture(scope="module")
def stiff_pair() -> tuple[dict[str, Any], dict[str, Any]]:
    """The rigid train, and the same on shafts 0.4 m thick, 5000 times as stiff as steel and almost without mass."""
    bent = tomllib.loads(PLANETS)
    bent["material"]["density"] = "1e-6 kg/m^3"
    for name, (start, end) in BENT.items():
        bent["stages"]["main"][name]["shaft_sections"] = [{"from": start, "to": end, "diameter": "400 mm"}]
    return tomllib.loads(PLANETS), bent


def test_a_stiff_shaft_is_the_rigid_member(stiff_pair: tuple[dict[str, Any], dict[str, Any]]) -> None:
    """Mesh and bearing forces with displaced and tilted seats, an external load off the centre, and all frequencies."""
    rigid, bent = (static(model, cycles=6, samples=8) for model in stiff_pair)
    scale = float(np.abs(rigid.mesh_force.values).max())
    assert np.abs(bent.mesh_force.values - rigid.mesh_force.values).max() < 1e-4 * scale
    own = bent.link_force.sel(link_row=rigid.link_row)
    assert np.abs(own.values - rigid.link_force.values).max() < 1e-4 * scale
    assert np.ptp(rigid.mesh_force.values.mean(axis=1)) > 0.05 * scale  # the deviations count
    straight = modes(stiff_pair[0]).frequency.values
    assert modes(stiff_pair[1]).frequency.values[: len(straight)] == pytest.approx(straight.tolist(), rel=1e-3, abs=1.0)


def test_planets_on_shafts_that_bend_are_alike(stiff_pair: tuple[dict[str, Any], dict[str, Any]]) -> None:
    """Places of planets turn into each other, so that the cyclic symmetry holds; their forces centre outwards."""
    system = assemble(load(stiff_pair[1]))
    assert [one.holds for one in system.symmetries] == [True]
    train = load(stiff_pair[1])
    assert {b.name for b in train.bodies if b.shaft_of == "main/planet/2"} == {
        "main/planet/2/shaft/front",
        "main/planet/2/shaft/rear",
    }
    assert [body.name for body in bodies_named("main.sun", train.bodies)] == ["main/sun"]
