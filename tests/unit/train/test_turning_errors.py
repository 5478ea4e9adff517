"""Errors of a mesh that turn with a member: closed form, and the same System as the run-out they restate."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.document.document import read
from epicyclic.errors import ModelError
from epicyclic.questions.check.check import mesh_deviations
from epicyclic.questions.studies.sensitivity import all_parameters
from epicyclic.statics import StaticOptions
from epicyclic.statics.static import static
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load, resolved_document
from epicyclic.train.train import Train

Table = dict[str, Any]
PATH = "deviations.main.meshes.sun-planet.errors.mine"
CARRIER = Fraction(115, 4) / 60  # turns per second of ren2021's carrier, 28.75 rpm
# as a run-out shows in a mesh: its component along the transverse tooth normal, in the normal direction
ECCENTRIC: Table = {"from": "normal", "direction": "transverse", "flanks": "both"}


def with_error(more: Table, overrides: Table | None = None, *, pair: str = "sun-planet") -> Train:
    """ren2021 with one error of one pair and no other deviation; more : its keys, None one that it has not."""
    key = f"deviations.meshes.{pair}.errors.mine"
    error = {"turns_with": "sun", "amplitude": "20 um", **more}
    error = {name: value for name, value in error.items() if value is not None}
    return load("ren2021", {"deviations": None, key: error, **(overrides or {})})


def error_at(train: Train, mesh: str, time: float) -> float:
    """Error of the loaded flank of a mesh at a time [m]."""
    found = [e for e in train.mesh_errors if e.mesh == mesh and not e.far]
    return float(sum((e.amplitude * np.exp(2j * math.pi * float(e.frequency) * time)).real for e in found))


# closed form ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("time", [0.0, 0.137, 2.6])
@pytest.mark.parametrize("planet", [1, 2, 3])
def test_one_mesh_of_the_sun(planet: int, time: float) -> None:
    """A cos(order theta + phase), theta the angle of the sun's x axis from the line to the planet."""
    train = with_error({"order": 2, "phase": "[10, 50, 200] deg", "amplitude": "[20, 10, -5] um"})
    theta = 2 * math.pi * (float(Fraction(100, 60) - CARRIER) * time - (planet - 1) / 3)
    amplitude, phase = (20e-6, 10e-6, -5e-6)[planet - 1], math.radians((10, 50, 200)[planet - 1])
    expected = amplitude * math.cos(2 * theta + phase)
    assert error_at(train, f"main/sun-planet/{planet}/left", time) == pytest.approx(expected, abs=1e-17)


@pytest.mark.parametrize("time", [0.0, 0.137, 2.6])
def test_a_planet_meets_the_sun_behind_and_the_ring_ahead(time: float) -> None:
    speed = float(Fraction(-1150, 17) / 60 - CARRIER)
    for pair, behind in (("sun-planet", math.pi), ("planet-ring", 0.0)):
        train = with_error({"turns_with": "planet", "phase": "30 deg"}, pair=pair)
        expected = 20e-6 * math.cos(2 * math.pi * speed * time - behind + math.radians(30))
        assert error_at(train, f"main/{pair}/2/left", time) == pytest.approx(expected, abs=1e-17)


@pytest.mark.parametrize("time", [0.0, 0.137, 2.6])
def test_from_the_tooth_normal_it_is_the_projection_of_an_eccentricity(time: float) -> None:
    """e = -n . E: -E cos(beta_b) sin(alpha + theta) of the driving sun [ren2021, eq. 11, with its cos(beta_b)]."""
    train = with_error({**ECCENTRIC, "flanks": "loaded", "phase": "30 deg"})
    mesh = next(m for m in train.meshes if m.name == "main/sun-planet/2/left")
    assert mesh.flank == 1
    theta = 2 * math.pi * (float(Fraction(100, 60) - CARRIER) * time - 1 / 3) + math.radians(30)
    expected = -20e-6 * math.cos(mesh.base_helix) * math.sin(mesh.pressure_angle + theta)
    assert error_at(train, mesh.name, time) == pytest.approx(expected, abs=1e-17)


def test_direction_and_sense_scale_it() -> None:
    base = error_at(with_error({}), "main/sun-planet/1/left", 0.1)
    helix = load("ren2021").meshes[0].base_helix
    across = error_at(with_error({"direction": "transverse"}), "main/sun-planet/1/left", 0.1)
    assert across == pytest.approx(base * math.cos(helix), rel=1e-14)
    assert error_at(with_error({"sense": "closes"}), "main/sun-planet/1/left", 0.1) == -base


def test_with_the_carrier_it_stands_still_and_differs_by_planet() -> None:
    """The printed error of ren2021, eq. (15): E cos(alpha) sin(beta - phi_i)."""
    train = with_error({"turns_with": "carrier", "phase": "-90 deg"}, {"operation.speed": None})
    for planet in (1, 2, 3):
        name = f"main/sun-planet/{planet}/right"
        (error,) = [e for e in train.mesh_errors if e.mesh == name]
        assert error.frequency == 0
        assert error_at(train, name, 0.3) == pytest.approx(20e-6 * math.sin(-math.tau / 3 * (planet - 1)), abs=1e-17)


# the same System by two routes ---------------------------------------------------------------------------------------


def pairs_of(train: Train, member: str) -> set[str]:
    """Pairs of the file in which a member has teeth."""
    names = {body.name for body in train.bodies if body.member == member}
    return {mesh.pair.removeprefix("stages.") for mesh in train.meshes if {mesh.a, mesh.b} & names}


def restated(drive: str, member: str, table: Table, changes: Table) -> tuple[System, System]:
    """System with a run-out of a member, and with the errors of its meshes that it means."""
    bare = {**({"deviations": None} if "deviations" in read(drive).data else {}), **changes}
    pairs = pairs_of(load(drive, bare), member)
    assert pairs
    error = {"turns_with": member, **table, **ECCENTRIC}
    errors = {f"deviations.{pair}.errors.of_{member.replace('.', '_')}": error for pair in pairs}
    routes = ({f"deviations.{member}.run_out": table}, errors)
    first, second = (assemble(load(drive, {**bare, **route})) for route in routes)
    return first, second


def difference(first: System, second: System) -> float:
    """Largest difference of the excitation lines over the largest entry of each kind."""
    worst = 0.0
    ours, theirs = ({line.frequency: line for line in system.lines} for system in (first, second))
    assert set(ours) == set(theirs)
    for kind in ("gap", "far_gap", "link_gap", "group_gap", "force", "ramp_force"):
        rows: list[tuple[NDArray[Any], NDArray[Any]]] = [
            (getattr(ours[f], kind), getattr(theirs[f], kind)) for f in ours
        ]
        size = max(float(np.abs(a).max(initial=0.0)) for a, _ in rows)
        worst = max(worst, *(float(np.abs(a - b).max(initial=0.0)) / (size or 1.0) for a, b in rows))
    return worst


TURNING: Table = {"operation.held": ["ring"], "operation.speed.sun": "1000 rpm", "operation.torque.sun": "1 kN m"}
HELICAL: Table = {
    **TURNING,
    "stages.main.helix_angle": "15 deg",
    "stages.main.sun.hand": "left",
    "stages.main.face_width": "30 mm",
}
CASES: list[tuple[str, str, Table, Table]] = [
    ("ren2021", "main.sun", {"amplitude": "20 um", "phase": "30 deg"}, {}),
    ("ren2021", "main.planet", {"amplitude": "[20, 5, 3] um", "phase": "[30, 0, 7] deg"}, {}),
    ("ren2021", "main.ring", {"amplitude": "20 um", "phase": "-70 deg"}, {}),
    ("ren2021", "main.planet", {"amplitude": "20 um"}, {"operation.torque.sun": "-100 kN m"}),
    ("ren2021", "main.planet", {"amplitude": "20 um"}, {"stages.main.meshes.sun-planet.backlash": "0.3 mm"}),
    ("ren2021", "main.sun", {"amplitude": "20 um"}, {"stages.main.meshes.sun-planet.slices": 4}),
    ("lin1999-n4", "main.planet", {"amplitude": "20 um", "phase": "30 deg"}, TURNING),
    (
        "lin1999-n4",
        "main.ring",
        {"amplitude": "20 um"},
        {**HELICAL, "stages.main.meshes.planet-ring.backlash": "0.1 mm"},
    ),
    ("lin1999-n4", "main.sun", {"amplitude": "20 um"}, {**HELICAL, "stages.main.meshes.sun-planet.slices": 5}),
    ("dong2019", "main.star1", {"amplitude": "6 um", "phase": "30 deg"}, {}),
    ("dong2019", "main.star2", {"amplitude": "6 um", "phase": "30 deg"}, {}),
    ("encased-differential", "differential.planet", {"amplitude": "6 um", "phase": "5 deg"}, {}),
    ("encased-differential", "encased.ring", {"amplitude": "6 um", "phase": "5 deg"}, {}),
    ("xu2020", "main.sun", {"amplitude": "6 um", "phase": "5 deg"}, {}),
]


@pytest.mark.parametrize(("drive", "member", "table", "changes"), CASES, ids=lambda v: v if isinstance(v, str) else "")
def test_a_run_out_and_the_errors_it_means_are_one_system(
    drive: str, member: str, table: Table, changes: Table
) -> None:
    first, second = restated(drive, member, table, changes)
    assert any(np.abs(line.gap).max(initial=0.0) > 1e-6 for line in first.lines)
    assert difference(first, second) < 1e-12  # rounding of a cosine
    backlash = any("backlash" in key for key in changes)
    assert any(np.abs(line.far_gap).max(initial=0.0) > 1e-6 for line in second.lines) == backlash


def test_a_far_flank_without_errors_of_its_own_differs() -> None:
    """What `flanks` is for: the loaded flank alone is no eccentricity where the far one may touch."""
    changes = {"stages.main.meshes.sun-planet.backlash": "0.3 mm"}
    *_, line = assemble(with_error({**ECCENTRIC, "flanks": "loaded"}, changes)).lines
    assert line.gap.any()
    assert not line.far_gap.any()


def test_an_eccentric_carrier_by_its_pins_and_by_the_meshes() -> None:
    """The pins move the planets: at rest the mesh forces are those of the errors of both meshes of each planet."""
    even: Table = {
        "stages.main.meshes.sun-planet.variation": "none",
        "stages.main.meshes.planet-ring.variation": "none",
    }
    error = {"turns_with": "carrier", "amplitude": "20 um", "phase": "40 deg", **ECCENTRIC}
    by_meshes = {f"deviations.meshes.{pair}.errors.c": error for pair in ("sun-planet", "planet-ring")}
    by_pins = {"deviations.carrier.run_out": {"amplitude": "20 um", "phase": "40 deg"}}
    first, second = (
        static(assemble(load("ren2021", {"deviations": None, **even, **route})), StaticOptions(cycles=1))[
            "mesh_force"
        ].values
        for route in (by_meshes, by_pins)
    )
    assert np.ptp(second[:, 0]) > 1e3
    np.testing.assert_allclose(first, second, rtol=1e-9)


# the file ------------------------------------------------------------------------------------------------------------


def test_a_side_replaces_the_error_of_its_name_alone() -> None:
    errors = {"a": {"turns_with": "sun", "amplitude": "1 um"}, "b": {"turns_with": "sun", "amplitude": "2 um"}}
    side = {"b": {"turns_with": "sun", "amplitude": "5 um"}, "c": {"turns_with": "planet", "amplitude": "7 um"}}
    key = "deviations.meshes.sun-planet"
    train = load("ren2021", {"deviations": None, f"{key}.errors": errors, f"{key}.left.errors": side})
    left, right = (
        {e.path.rpartition(".errors.")[2]: abs(e.amplitude) for e in train.mesh_errors if e.mesh.endswith(f"1/{side}")}
        for side in ("left", "right")
    )
    assert left == pytest.approx({"a": 1e-6, "b": 5e-6, "c": 7e-6})
    assert right == pytest.approx({"a": 1e-6, "b": 2e-6})


def test_without_a_speed_it_is_left_out() -> None:
    train = with_error({}, {"operation.speed": None})
    assert not train.mesh_errors
    assert any("left out, because they turn" in text and PATH in text for text in train.warnings)


def test_the_resolved_file_keeps_it() -> None:
    train = with_error({**ECCENTRIC, "sense": "closes", "phase": "[1, 2, 3] deg"})
    again = load(resolved_document(train))
    assert [(e.path, e.mesh, e.amplitude, e.frequency, e.far) for e in again.mesh_errors] == [
        (e.path, e.mesh, e.amplitude, e.frequency, e.far) for e in train.mesh_errors
    ]


def test_its_numbers_are_parameters() -> None:
    """Amplitude and phases may be varied and differentiated; the order is a count."""
    names = {one.path for one in all_parameters(with_error({"order": 2, "phase": "[1, 2, 3] deg"}))}
    assert {f"{PATH}.amplitude", *(f"{PATH}.phase[{i}]" for i in (1, 2, 3))} <= names
    assert f"{PATH}.order" not in names


@pytest.mark.parametrize(
    ("more", "path", "given", "allowed"),
    [
        ({"turns_with": "ring"}, ".turns_with", "main.ring", "main.sun, main.planet, main.carrier"),
        ({"turns_with": "snu"}, ".turns_with", "snu", "a gear of the mesh"),
        ({"turns_with": "main/sun"}, ".turns_with", "main/sun", "a gear of the mesh"),
        ({"turns_with": 3}, ".turns_with", "3", "a text"),
        ({"turns_with": None}, ".turns_with", "", "a gear of the mesh, or the carrier"),
        ({"amplitude": None}, ".amplitude", "", "amplitude"),
        ({"amplitude": "3 kg"}, ".amplitude", "3 kg", "length"),
        ({"amplitude": "[1, 2] um"}, ".amplitude", "[", "one per planet"),
        ({"amplitude": "90 mm"}, ".amplitude", "90 mm", "at most a module"),
        ({"order": 0}, ".order", "0", ">= 1"),
        ({"from": "centre"}, ".from", "centre", "pitch-point"),
        ({"sense": "up"}, ".sense", "up", "opens"),
        ({"sine": True}, ".sine", "True", "turns_with"),
    ],
)
def test_what_is_wrong_is_named(more: Table, path: str, given: str, allowed: str) -> None:
    with pytest.raises(ModelError) as error:
        with_error(more)
    assert error.value.path == PATH + path
    assert given in str(error.value.given)
    assert allowed in error.value.allowed


@pytest.mark.parametrize("named", ["sun-ring", "sun-planet.left"])
def test_a_pair_that_does_not_mesh_is_no_place_of_an_error(named: str) -> None:
    error = {f"deviations.meshes.{named}.errors.a": {"turns_with": "sun", "amplitude": "1 um"}}
    with pytest.raises(ModelError) as refused:
        load("lin1999-n4", {**TURNING, **error})
    assert refused.value.path == f"deviations.main.meshes.{named}"
    assert refused.value.allowed == "main.meshes.sun-planet, main.meshes.planet-ring"


@pytest.mark.parametrize(("side", "allowed"), [("left", True), ("middle", False)])
def test_a_side_of_a_herringbone_mesh(side: str, allowed: bool) -> None:
    gap = {f"deviations.meshes.sun-planet.{side}.gap": "1 um"}
    if allowed:
        load("ren2021", gap)
        return
    with pytest.raises(ModelError):
        load("ren2021", gap)


def test_a_name_is_one_word() -> None:
    with pytest.raises(ModelError) as error:
        load("ren2021", {"deviations.meshes.sun-planet.errors": {"my error": {"turns_with": "sun", "amplitude": 0}}})
    assert error.value.path == "deviations.main.meshes.sun-planet.errors.my error"


def test_both_gears_on_the_carrier_have_no_common_normal() -> None:
    """Two planets that mesh are pushed apart: which force counts must not be guessed."""
    stage: Table = {
        "planets": 3,
        "module": "4 mm",
        "sun": {"teeth": 24},
        "inner": {"kind": "planet", "teeth": 18},
        "outer": {"kind": "planet", "teeth": 18},
        "carrier": {},
        "meshes": {"sun-inner": {}, "inner-outer": {}},
    }
    error = {"turns_with": "carrier", "amplitude": "1 um", "from": "normal"}
    source = {"format": 2, "title": "x", "stages": {"main": stage}}
    with pytest.raises(ModelError) as found:
        load(source, {"deviations.meshes.inner-outer.errors.c": error})
    assert found.value.path == "deviations.main.meshes.inner-outer.errors.c.from"


# what verbs make of it -----------------------------------------------------------------------------------------------


def test_check_lists_the_same_errors_by_both_routes() -> None:
    """Amplitude, phase and frequency in each mesh, of a run-out by projection and of the error as it is stated."""
    table = {"amplitude": "[20, 5, 3] um", "phase": "[30, 0, 7] deg"}
    error = {"turns_with": "planet", **table, **ECCENTRIC}
    errors = {f"deviations.meshes.{pair}.errors.mine": error for pair in ("sun-planet", "planet-ring")}
    routes: list[Table] = [{"deviations.planet.run_out": table}, errors]
    listed = [mesh_deviations(load("ren2021", {"deviations": None, **route})) for route in routes]
    first, second = ({one.mesh: one for one in found} for found in listed)
    assert set(first) == set(second) == {mesh.name for mesh in load("ren2021").meshes}
    for name, one in first.items():
        assert one.frequency == second[name].frequency == Fraction(437, 16) / 17
        assert one.amplitude == pytest.approx(second[name].amplitude, rel=1e-14)
        assert math.remainder(one.phase - second[name].phase, math.tau) == pytest.approx(0, abs=1e-13)
    assert second["main/sun-planet/2/left"].path == PATH


def test_check_lists_errors_that_stand_still_and_leaves_out_pitch() -> None:
    more = {"deviations.sun.pitch": [1e-6, *[0.0] * 22], "deviations.meshes.sun-planet.gap": "-2 um"}
    listed = mesh_deviations(with_error({"turns_with": "carrier", "sense": "closes", "amplitude": "3 um"}, more))
    one = {item.path.rpartition("sun-planet.")[2]: item for item in listed if item.mesh == "main/sun-planet/1/left"}
    assert {name: item.amplitude for name, item in one.items()} == pytest.approx({"gap": 2e-6, "errors.mine": 3e-6})
    assert all(item.phase == math.pi and item.frequency == 0 for item in one.values())


def test_check_lists_a_displaced_pin_as_the_gaps_it_means() -> None:
    """Static forces of a pin out of place are those of the openings listed, stated as gaps of the meshes."""
    pin = {"deviations.planet.position.x": "[30, 0, 5] um", "deviations.planet.position.y": "[-3, 0, 10] um"}
    base: Table = {"deviations": None}
    listed = mesh_deviations(load("ren2021", base | pin))
    assert {one.path for one in listed} == {"deviations.main.planet.position"}
    assert {one.frequency for one in listed} == {Fraction(0)}
    gaps: dict[str, list[float]] = {}
    for one in listed:
        _, pair, branch, side = one.mesh.split("/")
        if side == "left":
            gaps.setdefault(pair, [0.0] * 3)[int(branch) - 1] += one.amplitude * math.cos(one.phase)
    stated = {
        f"deviations.meshes.{pair}.gap": f"[{', '.join(repr(1e6 * gap) for gap in found)}] um"
        for pair, found in gaps.items()
    }
    forces = [
        static(assemble(load("ren2021", base | route)), StaticOptions(cycles=1, samples=4)).mesh_force.values
        for route in (pin, stated, {})
    ]
    # the same state by displaced bearings and by open flanks, to the rounding of a displacement
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-10)
    assert np.abs(forces[0] - forces[2]).max() > 500


def test_check_lists_the_seats_of_other_members() -> None:
    """A carrier whose pins or seat are out of place carries all planets along; a sun turns about its own bearing."""
    for path, frequency, meshes in (
        ("deviations.carrier.run_out", Fraction(0), 12),
        ("deviations.carrier.position", Fraction(23, 48), 12),
        ("deviations.sun.bearing_run_out", Fraction(19, 16), 6),
    ):
        listed = mesh_deviations(load("ren2021", {"deviations": None, path: "20 um"}))
        assert len(listed) == meshes
        assert {one.frequency for one in listed} == {frequency}
        assert max(one.amplitude for one in listed) < 20e-6


def test_check_lists_no_rounding() -> None:
    """A standing error at 90 degrees opens nothing in branch 1, where its cosine is 6e-17."""
    listed = mesh_deviations(with_error({"turns_with": "carrier", "amplitude": "3 um", "phase": "90 deg"}, {}))
    mine = {one.mesh: one.amplitude for one in listed if "errors.mine" in one.path}
    assert {name.split("/")[2] for name in mine} == {"2", "3"}
    assert min(mine.values()) == pytest.approx(3e-6 * math.sqrt(0.75), rel=1e-12)


def test_sensitivity_of_the_mesh_forces_by_both_routes() -> None:
    """RMS of every mesh force by the amplitude of a run-out, and by that of the errors it means."""
    even = {"stages.main.meshes.sun-planet.variation": "none", "stages.main.meshes.planet-ring.variation": "none"}
    error = {"turns_with": "sun", "amplitude": "20 um", **ECCENTRIC}
    routes: dict[str, Table] = {
        "deviations.main.sun.run_out.amplitude": {"deviations.sun.run_out.amplitude": "20 um"},
        f"{PATH}.amplitude": {"deviations.meshes.sun-planet.errors.mine": error},
    }
    first, second = (
        epicyclic.sensitivity("ren2021", overrides={"deviations": None, **even, **route}, of="force", paths=[path])
        for path, route in routes.items()
    )
    assert np.abs(first.derivative).min() > 1.0  # [N per um]
    np.testing.assert_allclose(first.derivative.values, second.derivative.values, rtol=1e-9)
