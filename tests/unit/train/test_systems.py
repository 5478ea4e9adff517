"""Whole trains of several kinds, resolved: the figures that their sources and hand calculation give."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from epicyclic.document.writer import model_text
from epicyclic.train.resolution import load, resolved_document
from epicyclic.train.train import Body, GearData, Link, Mesh, Train

MODELS = Path(__file__).parent / "models"
DRIVES = (
    "ren2021",
    "lin1999-n3",
    "lin1999-n5",
    "yue2014-i",
    "yue2014-iii",
    *(str(path) for path in sorted(MODELS.glob("*.toml"))),
)


def model(name: str, overrides: dict[str, object] | None = None) -> Train:
    return load(MODELS / f"{name}.toml", overrides)


def body(train: Train, name: str) -> Body:
    return next(b for b in train.bodies if b.name == name)


def gear(train: Train, name: str) -> GearData:
    found = body(train, name).gear
    assert found is not None
    return found


def mesh(train: Train, name: str) -> Mesh:
    return next(m for m in train.meshes if m.name == name)


def link(train: Train, name: str) -> Link:
    return next(entry for entry in train.links if entry.name == name)


# the figures of the trains -------------------------------------------------------------------------------------------


def test_ren2021_speeds_frequency_and_torques() -> None:
    train = load("ren2021")
    kinematics = train.kinematics
    assert kinematics.mesh_frequency == {"main": Fraction(437, 16)}  # 27.3125 Hz
    assert kinematics.speed is not None
    rad = {name: float(rpm) * math.pi / 30 for name, rpm in kinematics.speed.items()}
    assert rad["main.sun"] == pytest.approx(10.472, abs=5e-4)  # printed to three digits
    assert rad["main.carrier"] == pytest.approx(3.0107, abs=5e-5)
    assert rad["main.planet"] == pytest.approx(-7.0840, abs=5e-5)
    assert train.torques == {"main/sun": pytest.approx(1e5), "main/carrier": pytest.approx(-1e5 * (1 + 57 / 23))}


def test_ren2021_phases_and_nearest_angles() -> None:
    train = load("ren2021")
    third = Fraction(1, 3)
    assert [mesh(train, f"main/sun-planet/{i}/left").lead for i in (1, 2, 3)] == [0, third, 2 * third]
    assert [mesh(train, f"main/planet-ring/{i}/right").lead for i in (1, 2, 3)] == [0, 0, 0]
    assert any("nearest angles 0, 121.5, 238.5 deg" in text for text in train.warnings)


def test_ren2021_nearest_angles_assemble() -> None:
    train = load("ren2021", {"stages.main.planet_angles": "[0, 121.5, 238.5] deg"})
    assert train.warnings == ()
    assert [m.lead for m in train.meshes if m.pair.endswith("planet-ring")] == [
        0,
        0,
        *[Fraction(19, 80)] * 2,
        *[Fraction(61, 80)] * 2,
    ]


def test_ren2021_iso_stiffness_is_transverse_by_definition() -> None:
    train = load("ren2021")
    sun, ring = mesh(train, "main/sun-planet/1/left"), mesh(train, "main/planet-ring/1/left")
    transverse = [m.stiffness * math.cos(m.base_helix) ** 2 for m in (sun, ring)]
    assert transverse == pytest.approx([2.402e9, 3.238e9], rel=2e-4)  # printed to four digits
    assert (sun.hand, ring.hand) == (-1, 1)  # the sun's left helix is left-handed, the planet's right-handed
    assert (sun.flank, ring.flank) == (1, -1)
    assert mesh(train, "main/sun-planet/1/right").hand == 1


def test_encased_speeds_masses_and_output() -> None:
    train = model("encased")
    frequency, torque = train.kinematics.mesh_frequency, train.kinematics.torque
    assert frequency is not None
    assert torque is not None
    assert float(frequency["differential"]) == pytest.approx(1712.740, abs=5e-4)
    assert float(frequency["encased"]) == pytest.approx(552.748, abs=5e-4)
    assert frequency["differential"] / frequency["encased"] == Fraction(220, 71)
    assert torque["output"] == pytest.approx(-858043, abs=0.5)
    names = ("differential/sun", "differential/planet/1", "differential/ring", "encased/sun", "encased/planet/1")
    assert [round(body(train, name).mass, 1) for name in names] == [135.3, 310.4, 678.4, 478.9, 144.3]


def test_encased_flanks_follow_the_torque_of_each_stage() -> None:
    train = model("encased")
    assert mesh(train, "differential/sun-planet/1/left").flank == 1
    assert mesh(train, "encased/sun-planet/1/left").flank == -1
    assert all(m.sense == 1 for m in train.meshes)  # the suns drive in both stages
    assert [mesh(train, f"encased/sun-planet/{i}/left").lead for i in (1, 2)] == [0, Fraction(1, 5)]
    assert link(train, "ring-g1").stiffness == pytest.approx((0, 0, 0, 0, 0, 1e10 * 0.5236**2), rel=1e-15)


def test_yue_second_planet_stands_ahead() -> None:
    train = model("yue")
    assert math.degrees(body(train, "main/d/1").angle) == pytest.approx(41.8768, abs=5e-5)
    assert math.dist(body(train, "main/p/1").centre, body(train, "main/d/1").centre) == pytest.approx(0.078, abs=1e-15)
    assert mesh(train, "main/p-d/1").contact_ratio == pytest.approx(1.40581, abs=5e-6)
    assert [mesh(train, f"main/{pair}/1").flank for pair in ("sun-p", "p-d", "d-ring")] == [1, -1, 1]
    assert train.kinematics.ratio["main.ring"]["main.sun"] == Fraction(32, 77)
    behind = model("yue", {"stages.main.d.ahead": False})
    assert math.degrees(body(behind, "main/d/1").angle) == pytest.approx(-41.8768, abs=5e-5)


def test_yue_said_base_radii_work_at_the_angle_that_fits_the_axes() -> None:
    train = model("yue")
    base = {"sun-p": 58.0 + 34.5, "p-d": 34.5 + 36.3, "d-ring": 139.6 - 36.3}
    axes = {"sun-p": 102.0, "p-d": 78.0, "d-ring": 114.0}
    for pair in base:
        angle = math.acos(base[pair] / axes[pair])
        assert mesh(train, f"main/{pair}/1").pressure_angle == pytest.approx(angle, rel=1e-14)  # rounding
    assert not any("differ" in text for text in train.warnings)
    # where the teeth touch, and when, is theirs: as without said radii, exact as long as the angles are
    assert [mesh(train, f"main/sun-p/{i}").lead for i in (1, 2, 3)] == [0, Fraction(1, 3), Fraction(2, 3)]
    unsaid = model("yue", {f"stages.main.{name}.base_radius": None for name in ("sun", "p", "d", "ring")})
    for said, own in zip(train.meshes, unsaid.meshes, strict=True):
        assert (said.lead, said.contact_ratio) == (own.lead, own.contact_ratio)
        assert own.pressure_angle == math.radians(25)


def test_dong_stepped_shafts() -> None:
    train = model("dong")
    speed, torque = train.kinematics.speed, train.kinematics.torque
    assert speed is not None
    assert torque is not None
    assert abs(speed["main.ring"] / speed["main.sun"]) == Fraction(124, 363)
    assert torque["main.ring"] == pytest.approx(904.42, abs=5e-3)
    warning = next(text for text in train.warnings if "centre distances differ" in text)
    assert "64.2257 mm" in warning
    assert "69.5192 mm" in warning
    assert any("identical shafts of star2" in text for text in train.warnings)  # (24 31 + 99 22)/5 is no integer
    assert mesh(train, "main/star2-ring/2").stage == "main/star2-ring"  # a mesh frequency of its own
    assert math.isinf(min(link(train, "main/star2/1/shaft").stiffness))
    outer = mesh(train, "main/star2-ring/2")
    assert outer.stiffness * math.cos(outer.base_helix) ** 2 == pytest.approx(4e9, rel=1e-15)  # given as transverse
    assert mesh(train, "main/sun-star1/2").stiffness == 4e9


def test_dong_equal_shafts_fit_where_the_teeth_allow_it() -> None:
    # (24 31 + 98 22)/5 = 580: identical shafts fit
    train = model("dong", {"stages.main.ring.teeth": 98, "stages.main.ring.support.radial": "1e8 N/m"})
    assert not any("identical shafts" in text for text in train.warnings)


def test_xu_halves_are_bodies() -> None:
    train = model("xu")
    assert [round(body(train, f"main/sun/{side}").mass, 1) for side in ("left", "right")] == [127.9, 127.9]
    assert round(body(train, "main/planet/1/left").mass, 1) == 276.3
    assert body(train, "main/planet/1/left").carried_by == "main/carrier/left"
    assert body(train, "main/sun/left").station == -0.1125
    torque = train.kinematics.torque
    assert torque is not None
    assert torque["output"] == pytest.approx(149.9e3, abs=50)
    assert train.torques["main/carrier/left"] == -414e3
    leads = [mesh(train, f"main/sun-planet/{i}/left").lead for i in (1, 2, 3, 4)]
    assert leads == [Fraction(i, 4) for i in range(4)]  # Omega < 0, so the order is 0 1/4 1/2 3/4
    assert mesh(train, "main/sun-planet/1/left").sense == -1


def test_xu_neck_and_sides() -> None:
    train = model("xu")
    neck = link(train, "main/sun/neck")
    # the length is face width + gap
    assert neck.stiffness == pytest.approx((5e9, 5e9, 2e10, math.inf, math.inf, 5.2e7 / 0.225), rel=1e-15)
    assert (neck.first, neck.second) == ("main/sun/left", "main/sun/right")
    assert link(train, "main/sun/left/support").stiffness[2] == 1e6
    assert link(train, "main/sun/right/support").stiffness[2] == 0.0


def test_fva_carrier_torque_and_angles() -> None:
    train = model("fva")
    torque = train.kinematics.torque
    assert torque is not None
    assert torque["main.carrier"] == pytest.approx(-7302.4, abs=0.05)
    assert math.hypot(*body(train, "main/planet/1").centre) == pytest.approx(0.078, rel=1e-15)
    assert mesh(train, "main/sun-planet/2").stiffness == pytest.approx(1e9, rel=1e-15)  # 20 N/(mm um) x 50 mm
    assert mesh(train, "main/sun-planet/2").variation.size == 0
    assert mesh(train, "main/planet-ring/2").variation.size > 0
    assert math.degrees(body(train, "main/planet/2").angle) == pytest.approx(240.0, rel=1e-15)


def test_wind_shift_follows_from_the_centre_distance() -> None:
    train = model("wind")
    assert gear(train, "high/wheel").profile_shift == pytest.approx(0.6691, abs=5e-5)
    pinion, wheel = body(train, "high/pinion"), body(train, "high/wheel")
    assert math.dist(pinion.centre, wheel.centre) == pytest.approx(0.861, abs=1e-15)
    assert body(train, "generator").centre == pytest.approx(pinion.centre)  # what is coupled is coaxial
    front, rear = (link(train, f"high/pinion/support/{name}") for name in ("front", "rear"))
    assert front.stiffness == (2e9, 2e9, 1e9, 0.0, 0.0, 0.0)  # tilt is named nowhere: their distance holds it
    assert rear.stiffness == (2e9, 2e9, 0.0, 0.0, 0.0, 0.0)
    assert (front.station, rear.station) == (-0.3, 0.3)


def test_wind_shifts_leave_no_backlash() -> None:
    train = model("wind")
    sun, planet, ring = (gear(train, f"low/{name}").profile_shift for name in ("sun", "planet/1", "ring"))
    assert sun == 0.25
    normal, helix = math.radians(20), math.radians(5)
    alpha = math.atan(math.tan(normal) / math.cos(helix))
    m_t = 0.014 / math.cos(helix)

    def total(teeth: int) -> float:
        """Sum of shifts at 411 mm, sum or difference of teeth: teeth (inv alpha_w - inv alpha_t)/(2 tan alpha_n)."""
        working = math.acos(0.5 * teeth * m_t * math.cos(alpha) / 0.411)
        change = math.tan(working) - working - math.tan(alpha) + alpha
        return teeth * change / (2 * math.tan(normal))

    assert sun + planet == pytest.approx(total(21 + 37), abs=1e-12)  # rounding
    assert planet + ring == pytest.approx(-total(96 - 37), abs=1e-12)  # teeth count negative in a ring
    assert not any("differ" in text for text in train.warnings)


@pytest.mark.parametrize("planets", [3, 4, 5])
def test_lin1999_is_what_the_page_prints(planets: int) -> None:
    train = load(f"lin1999-n{planets}")
    assert len(train.meshes) == 2 * planets
    for name, radius, inertia in (("sun", 38.71e-3, 0.39), ("ring", 137.515e-3, 3.0), ("carrier", 88.4e-3, 6.29)):
        assert body(train, f"main/{name}").reference_radius == radius
        assert body(train, f"main/{name}").inertia == pytest.approx(inertia * radius**2, rel=1e-15)
    assert all(m.stiffness == 5e8 and m.pressure_angle == math.radians(24.6) for m in train.meshes)
    assert train.meshes[0].radius_a == 38.71e-3 / math.cos(math.radians(24.6))
    assert link(train, "main/ring/support").stiffness[5] == pytest.approx(1e9 * 137.515e-3**2, rel=1e-15)
    assert link(train, "main/sun/support").stiffness[5] == 0.0
    assert any("fit no single one" in text for text in train.warnings)
    assert any("collide" in text for text in train.warnings) == (planets == 5)
    assert not any("assembled" in text for text in train.warnings)


# written out and resolved again --------------------------------------------------------------------------------------


def same(a: object, b: object) -> bool:
    """Equal, numbers to 1e-12: module, radii and shifts are computed once more from their decimal text."""
    if isinstance(a, (float, complex, int, Fraction)) and isinstance(b, (float, complex, int, Fraction)):
        x, y = complex(a), complex(b)
        return (x != x and y != y) or x == y or abs(x - y) <= 1e-12 * max(abs(x), abs(y), 1e-3)
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.shape == b.shape and bool(np.allclose(a, b, rtol=1e-12, atol=1e-13))
    if isinstance(a, (tuple, list)) and isinstance(b, (tuple, list)):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if dataclasses.is_dataclass(a) and type(a) is type(b):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    return a == b


def differing(first: Train, second: Train) -> list[str]:
    fields = (f.name for f in dataclasses.fields(first) if f.name not in ("values", "document"))
    return [name for name in fields if not same(_sorted(first, name), _sorted(second, name))]


def _sorted(train: Train, name: str) -> object:
    """Links, ties and paths by name: the order of tables in a file means nothing.

    A stiffness written out comes from no method.
    """
    if name == "links":
        return sorted(train.links, key=lambda entry: entry.name)
    if name == "kinematics":
        ties = tuple(sorted(train.kinematics.ties, key=lambda tie: tie.name))
        return dataclasses.replace(train.kinematics, ties=ties)
    if name == "power_paths":
        return sorted(train.power_paths, key=lambda entry: entry.path)
    if name == "warnings":
        return [text for text in train.warnings if "ISO 6336" not in text]
    return getattr(train, name)


@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: Path(drive).stem)
def test_resolving_the_resolved_document_changes_nothing(drive: str) -> None:
    train = load(drive)
    again = load(tomllib.loads(model_text(resolved_document(train))))
    assert differing(train, again) == []


def test_exact_leads_stay_exact() -> None:
    train = load("ren2021")
    again = load(resolved_document(train))
    assert [(type(m.lead), m.lead) for m in again.meshes] == [(type(m.lead), m.lead) for m in train.meshes]


def test_a_changed_value_is_seen() -> None:
    document = resolved_document(load("ren2021"))
    document["stages"]["main"]["meshes"]["sun-planet"]["stiffness"] *= 1 + 1e-9
    assert differing(load("ren2021"), load(document)) == ["meshes"]


def test_the_resolved_document_says_derived_values() -> None:
    main = resolved_document(load("ren2021"))["stages"]["main"]
    assert main["planet"]["hand"] == "right"
    assert main["carrier"]["pin_radius"] == pytest.approx(0.016 * 40 / math.cos(math.radians(25)), rel=1e-15)
    assert main["meshes"]["sun-planet"]["left"]["phase"] == pytest.approx([0, 1 / 3, 2 / 3], abs=1e-15)  # rounding
    assert main["sun"]["support"]["rx"] == "inf"
    assert main["sun"]["inertia"] == pytest.approx(663 * main["sun"]["base_radius"] ** 2, rel=1e-15)
