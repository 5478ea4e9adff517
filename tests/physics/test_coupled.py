"""Coupled trains: nothing is grounded that is not held, torques balance, gravity acts in every frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.system.system import System
from epicyclic.train.resolution import load
from epicyclic.train.train import DIRECTIONS, Body, Train

Array = NDArray[np.float64]
Document = dict[str, Any]
MODELS = Path(__file__).parents[1] / "unit" / "train" / "models"
LATERAL = {"radial": 3e8, "z": 1e8, "tilt": 1e6}


# trains to couple ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A stage: its members, which one power enters and leaves by, which one is held."""

    enters: str
    leaves: str
    held: str = ""
    members: Document = field(default_factory=dict)


SET: Document = {
    "sun": {"teeth": 24, "support": LATERAL},
    "planet": {"teeth": 21, "bearing": {"radial": 2e8, "z": 3e8, "tilt": 1e6}},
    "ring": {"teeth": 66, "rim": 0.03, "support": LATERAL},
}
CARRIER: Document = {"carrier": {"mass": 20.0, "inertia": 0.2, "tilt_inertia": 0.1, "support": LATERAL}}
PAIR: Document = {
    "wheel": {"teeth": 41, "support": LATERAL},
    "pinion": {"teeth": 23, "direction": 0.7, "support": LATERAL},
}
KINDS = {
    "reducer": Kind(enters="sun", leaves="carrier", held="ring", members=SET | CARRIER),
    "overdrive": Kind(enters="carrier", leaves="sun", held="ring", members=SET | CARRIER),
    "solar": Kind(enters="ring", leaves="carrier", held="sun", members=SET | CARRIER),
    "star": Kind(enters="sun", leaves="ring", members=SET),
    "held carrier": Kind(enters="sun", leaves="ring", held="carrier", members=SET | CARRIER),
    "parallel": Kind(enters="wheel", leaves="pinion", members=PAIR),
}
COUPLINGS = ("torsional", "axial", "gear", "shaft")


def chain(kinds: list[str], joints: list[str], helix: float = 0.2, torque: float = 1000.0) -> Document:
    """Stages one behind the other, joined as said, with an output body at the end."""
    data: Document = {"format": 2, "title": "coupled", "stages": {}, "bodies": {}, "couplings": {}}
    held = []
    for i, name in enumerate(kinds):
        kind = KINDS[name]
        members = {member: dict(table) for member, table in kind.members.items()}
        if kind.held:
            members[kind.held]["support"] = LATERAL | {"rz": 1e9}  # elastic, so that its reaction is a link force
            held.append(f"s{i}.{kind.held}")
        common = {"module": 0.004, "helix_angle": helix, "face_width": 0.05}
        data["stages"][f"s{i}"] = common | ({} if name == "parallel" else {"planets": 3}) | members
    ends = [f"s{i}.{KINDS[name].leaves}" for i, name in enumerate(kinds)]
    starts = [f"s{i}.{KINDS[name].enters}" for i, name in enumerate(kinds)]
    data["bodies"]["output"] = {"mass": 5.0, "inertia": 0.3, "tilt_inertia": 0.2, "support": LATERAL}
    for i, (end, start) in enumerate(zip(ends, [*starts[1:], "output"], strict=True)):
        _join(data, f"c{i}", (end, start), joints[i])
    data["operation"] = {
        "held": held,
        "speed": {starts[0]: 100.0},
        "torque": {starts[0]: torque, "output": "balance"},
    }
    return data


def _join(data: Document, name: str, between: tuple[str, str], how: str) -> None:
    """A coupling; of a gear coupling the two tooth rows with their own radii and a sleeve that floats between them."""
    couplings, ends = data["couplings"], list(between)
    if how == "torsional":
        couplings[name] = {"between": ends, "rz": 2e6}
    elif how == "axial":
        couplings[name] = {"between": ends, "rz": "3e8 N/m", "radius": 0.1, "z": 2e8}
    elif how == "shaft":
        couplings[name] = {"between": ends, "diameter": 0.08, "bore": 0.02, "length": 0.5}
    else:
        sleeve = f"{name}_sleeve"
        data["bodies"][sleeve] = {"mass": 3.0, "inertia": 0.02, "tilt_inertia": 0.02, "support": {"radial": 1e6}}
        couplings[f"{name}-a"] = {"between": [ends[0], sleeve], "rz": "2e9 N/m", "radius": 0.08}
        couplings[f"{name}-b"] = {"between": [sleeve, ends[1]], "rz": "3e9 N/m", "radius": 0.06}


trains = st.integers(1, 3).flatmap(
    lambda n: st.tuples(
        st.lists(st.sampled_from(sorted(KINDS)), min_size=n, max_size=n),
        st.lists(st.sampled_from(COUPLINGS), min_size=n, max_size=n),
        st.sampled_from([0.0, 0.1, 0.35]),
        st.sampled_from([1000.0, -300.0]),
    )
)
FEW = settings(max_examples=25, deadline=None, derandomize=True)


# what a motion and a matrix say --------------------------------------------------------------------------------------


def reduced(train: Train, system: System, motion: dict[str, Array]) -> Array:
    """Coordinates of a motion given as x y z rx ry rz of every body's centre in frame axes; all directions must fit."""
    full = np.concatenate([_own(body, motion[body.name]) for body in train.bodies])
    number = {body.name: i for i, body in enumerate(train.bodies)}
    keys = zip(system.dofs.body, system.dofs.direction, strict=True)
    p = full[[6 * number[body] + DIRECTIONS.index(direction) for body, direction in keys]]
    np.testing.assert_allclose(system.dofs.expand @ p, full, atol=1e-14 * max(1.0, float(np.abs(full).max())))
    return np.asarray(p)


def _own(body: Body, six: Array) -> Array:
    c, s = math.cos(body.angle), math.sin(body.angle)
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return np.concatenate([turn @ six[:3], turn @ six[3:]])


def turning(train: Train) -> dict[str, Array]:
    """Every body turned by what the exact ratios say per turn of the free member, carried centres moving along."""
    (freedom,) = train.kinematics.freedoms
    ratio = {body.name: float(train.kinematics.ratio[body.member][freedom]) for body in train.bodies}
    motion = {}
    for body in train.bodies:
        about = ratio[body.carried_by] if body.carried_by else 0.0
        x, y = body.centre
        motion[body.name] = np.array([-about * y, about * x, 0, 0, 0, ratio[body.name]])
    return motion


def round_the_axis(train: Train) -> dict[str, Array]:
    """The whole train turned about the origin as one piece."""
    return {b.name: np.array([-b.centre[1], b.centre[0], 0, 0, 0, 1.0]) for b in train.bodies}


def free_motions(system: System) -> int:
    """Motions that strain nothing; eigenvalues of the matrix scaled to a unit diagonal."""
    K = system.mean_stiffness
    scale = 1 / np.sqrt(np.diag(K))
    values = np.linalg.eigvalsh(scale[:, None] * K * scale)
    # rounding leaves 1e-15; the softest real one here, a soft sleeve, some 1e-7
    assert not np.any((np.abs(values) > 1e-13) & (np.abs(values) < 1e-9))
    return int(np.sum(np.abs(values) <= 1e-13))


@FEW
@given(trains)
def test_one_free_motion_and_it_is_the_turning_of_the_train(drawn: tuple[list[str], list[str], float, float]) -> None:
    train = load(chain(*drawn))
    system = epicyclic.assemble(train)
    assert free_motions(system) == 1
    v, K = reduced(train, system, turning(train)), system.mean_stiffness
    assert np.abs(K @ v).max() <= 1e-14 * (np.abs(K) @ np.abs(v)).max()
    assert np.abs(system.meshes.B.T @ v).max() <= 1e-14 * np.abs(v).max()
    assert abs(v @ system.force) <= 1e-13 * np.abs(v) @ np.abs(system.force)


@FEW
@given(trains)
def test_static_forces_are_those_of_torque_and_power(drawn: tuple[list[str], list[str], float, float]) -> None:
    """Independent of stiffness: a coupling passes the power over its speed, the sun or wheel the torque that enters its
    stage or that its speed ratio leaves, and the housing takes what the external torques leave."""
    train = load(chain(*drawn))
    system = epicyclic.assemble(train)
    result = epicyclic.static(train, cycles=1, samples=4)
    speed, kinds = train.kinematics.speed, drawn[0]
    assert speed is not None
    power = drawn[3] * 100.0
    force = dict(zip(system.links.name, result.link_force.values.mean(axis=1), strict=True))
    rad = {member: float(rpm) * math.pi / 30 for member, rpm in speed.items()}
    for name, value in force.items():
        if name.startswith("c") and name.endswith("/rz"):
            first = next(link.first for link in train.links if link.name == name[:-3])
            member = next(b.member for b in train.bodies if b.name == first)
            # the spring is wound up by what its first end, driving, passes on
            assert value == pytest.approx(power / rad[member], rel=1e-8)
    for i, name in enumerate(kinds):
        gear = f"s{i}.{'wheel' if name == 'parallel' else 'sun'}"
        torque = _torque(name, i, power, rad)
        meshes = [m for m in train.meshes if m.a == gear.replace(".", "/")]
        pressed = [result.mesh_force.sel(mesh=m.name).values.mean() for m in meshes]
        arms = [m.radius_a * math.cos(m.pressure_angle) * math.cos(m.base_helix) for m in meshes]
        assert float(np.dot(pressed, arms)) == pytest.approx(abs(torque), rel=1e-8)
        assert min(pressed) > 0
    about = system.links.B.T @ reduced(train, system, round_the_axis(train))
    reaction = about * np.array([force[name] for name in system.links.name])
    external = float(system.force @ reduced(train, system, round_the_axis(train)))
    assert reaction.sum() == pytest.approx(external, abs=1e-8 * np.abs(reaction).sum())


def _torque(kind: str, i: int, power: float, rad: dict[str, float]) -> float:
    """External torque on the sun or wheel of a stage that power flows through."""
    if KINDS[kind].held == "sun":
        return -(power / rad[f"s{i}.ring"] - power / rad[f"s{i}.carrier"])
    gear = "wheel" if kind == "parallel" else "sun"
    return power / rad[f"s{i}.{gear}"]


@FEW
@given(trains)
def test_modes_have_one_at_zero_frequency(drawn: tuple[list[str], list[str], float, float]) -> None:
    frequency = epicyclic.modes(load(chain(*drawn))).frequency.values
    # rounding 1e-16 of the largest square, so 1e-8 of the largest frequency
    assert frequency[0] <= 1e-7 * frequency[-1]
    assert frequency[1] > 1e-5 * frequency[-1]


# named trains --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["wind", "encased"])
def test_named_trains_turn_freely(name: str) -> None:
    train = load(MODELS / f"{name}.toml")
    system = epicyclic.assemble(train)
    assert free_motions(system) == 1
    v, K = reduced(train, system, turning(train)), system.mean_stiffness
    assert np.abs(K @ v).max() <= 1e-14 * (np.abs(K) @ np.abs(v)).max()
    assert abs(v @ system.force) <= 1e-13 * np.abs(v) @ np.abs(system.force)


def test_power_split_shows_in_the_couplings() -> None:
    """A loop: carrier and encased ring join at the output; the paths pass 37.298 and 62.702 % of the power."""
    train = load(MODELS / "encased.toml", {"operation.gravity": None, "deviations": None})
    result = epicyclic.static(train, cycles=1, samples=8)
    force = result.link_force.mean("time")
    output = abs(train.kinematics.torque["output"]) if train.kinematics.torque else math.nan
    shares = [abs(force.sel(link_row=f"{name}/rz").item()) / output for name in ("f2-output", "carrier-output")]
    assert sum(shares) == pytest.approx(1.0, rel=1e-9)
    assert sorted(shares) == pytest.approx([0.37298, 0.62702], abs=5e-6)  # printed to five digits


def test_parallel_stage_behind_a_planetary_one() -> None:
    """Torque of the generator by hand: 4 MN m over (1 + 96/21) 95/24; the pinion's bearings carry the tooth force."""
    train = load(MODELS / "wind.toml")
    result = epicyclic.static(train, cycles=1, samples=8)
    generator = 4e6 / ((1 + 96 / 21) * 95 / 24)
    assert abs(result.link_force.sel(link_row="pinion-generator/rz").mean().item()) == pytest.approx(
        generator, rel=1e-8
    )
    mesh = next(m for m in train.meshes if m.name.startswith("high"))
    force = result.mesh_force.sel(mesh=mesh.name).mean().item()
    lever = mesh.radius_b * math.cos(mesh.pressure_angle) * math.cos(mesh.base_helix)
    assert force * lever == pytest.approx(generator, rel=1e-8)
    rows = {d: [f"high/pinion/support/{place}/{d}" for place in ("front", "rear")] for d in ("x", "y")}
    pushed = [result.link_force.sel(link_row=rows[d]).sum("link_row").mean().item() for d in ("x", "y")]
    assert math.hypot(*pushed) == pytest.approx(force * math.cos(mesh.base_helix), rel=1e-8)


# gear couplings with a floating sleeve -------------------------------------------------------------------------------


def sleeved(frame: str | None, held: str = "ring") -> Document:
    """A sun driven by a shaft through a sleeve on two tooth rows, 60 mm apart."""
    data = chain(["reducer"], ["torsional"])
    main = data["stages"]["s0"]
    if held != "ring":
        main["ring"]["support"] = LATERAL
        main["carrier"]["support"] = LATERAL | {"rz": 1e9}
        data["operation"]["held"] = ["s0.carrier"]
        data["couplings"]["c0"]["between"] = ["s0.ring", "output"]
    main["sun"]["support"] = {"radial": 0, "z": 1e8, "tilt": 1e6}
    place = {} if frame is None else {"frame": frame}
    free = {"radial": 0, "z": 0, "tilt": 0}
    shaft = {"mass": 8.0, "inertia": 0.05, "tilt_inertia": 0.05, "station": 0.2, "support": LATERAL}
    data["bodies"]["shaft"] = place | shaft
    sleeve = {"mass": 3.0, "inertia": 0.02, "tilt_inertia": 0.02, "station": 0.1, "support": free}
    data["bodies"]["sleeve"] = place | sleeve
    row = {"rz": "2e9 N/m", "radius": 0.08, "radial": 1e9, "z": 1e6}
    # the middle between the bodies is at 50 and 150 mm: the rows stand at 70 and 130 mm
    data["couplings"]["row-a"] = {"between": ["s0.sun", "sleeve"], "at": 0.02} | row
    data["couplings"]["row-b"] = {"between": ["sleeve", "shaft"], "at": -0.02} | row | {"radius": 0.06}
    data["operation"] |= {"speed": {"shaft": 100.0}, "torque": {"shaft": 500.0, "output": "balance"}}
    return data


def condensed(system: System, kept: list[str]) -> Array:
    """Stiffness of the links alone seen from some coordinates, the rest left to themselves."""
    keep = [system.dofs.names.index(name) for name in kept]
    rest = [i for i, body in enumerate(system.dofs.body) if body == "sleeve"]
    K = system.K
    inner = np.linalg.pinv(K[np.ix_(rest, rest)], rcond=1e-12, hermitian=True)
    return np.asarray(K[np.ix_(keep, keep)] - K[np.ix_(keep, rest)] @ inner @ K[np.ix_(rest, keep)])


def test_a_sleeve_passes_torque_and_no_lateral_force() -> None:
    """Two tooth rows with a floating sleeve between them: springs in series about z, each at its own radius, and free
    to be misaligned, because the sleeve tilts."""
    train = load(sleeved("s0"))
    system = epicyclic.assemble(train)
    assert next(row for row in train.links if row.name == "row-a").station == pytest.approx(0.07, abs=1e-15)
    assert free_motions(system) == 1
    series = 1 / (1 / (2e9 * 0.08**2) + 1 / (2e9 * 0.06**2))
    K = condensed(system, ["s0/sun/x", "shaft/x", "s0/sun/rz", "shaft/rz"])
    assert K[2:, 2:] == pytest.approx(series * np.array([[1, -1], [-1, 1]]), rel=1e-12)
    assert np.abs(K[0, 1]) < 1e-5 * 1e9  # rounding of 1e9
    assert np.abs(K[0, 0]) < 1e-5 * 1e9  # the sun has no support of its own
    result = epicyclic.static(train, cycles=1, samples=4)
    passed = [abs(result.link_force.sel(link_row=f"row-{row}/rz").mean().item()) for row in "ab"]
    assert passed == pytest.approx([500.0, 500.0], rel=1e-9)


def test_the_mass_of_the_sleeve_moves() -> None:
    """The sleeve rocks between its two rows: modes of a bar on two springs, where sun and shaft are heavy and held."""
    data = sleeved("s0", held="carrier")
    sun = data["stages"]["s0"]["sun"] = data["stages"]["s0"]["sun"] | {"mass": 1e5, "inertia": 1e3, "tilt_inertia": 1e3}
    sun["support"] = {"radial": 1e12, "z": 1e12, "tilt": 1e12}
    data["bodies"]["shaft"] |= {"mass": 1e5, "tilt_inertia": 1e3, "support": {"radial": 1e12, "z": 1e12, "tilt": 1e12}}
    frequency = epicyclic.modes(load(data)).frequency.values
    for expected in (math.sqrt(2e9 / 3.0), math.sqrt(2 * 1e9 * 0.03**2 / 0.02)):
        nearest = np.abs(frequency * math.tau - expected).min() / expected
        assert nearest < 2e-3  # 1e9 against 1e12 in the bearings


# frames --------------------------------------------------------------------------------------------------------------

LATERAL_KEYS: tuple[Document, ...] = ({"radial": 1e8}, {"x": 1e6}, {"tilt": 1e6}, {"ends": "fixed", "diameter": 0.1})


@pytest.mark.parametrize("keys", LATERAL_KEYS, ids=str)
def test_no_lateral_coupling_between_frames_of_different_speed(keys: Document) -> None:
    data = chain(["reducer", "star"], ["torsional", "torsional"])
    if "ends" in keys:
        keys = keys | {"length": 0.3}
    data["couplings"]["c0"] = {"between": ["s0.carrier", "s1.sun"], **keys}
    message = r"couplings\.c0.*frames turn at different speeds.*allowed: z and rz between such bodies"
    with pytest.raises(ModelError, match=message):
        epicyclic.assemble(load(data))
    data["couplings"]["c0"] = {"between": ["s0.carrier", "s1.sun"], "rz": 1e7, "z": 1e7}
    assert free_motions(epicyclic.assemble(load(data))) == 1


def test_a_sleeve_couples_laterally_in_the_frame_it_is_said_to_move_in() -> None:
    epicyclic.assemble(load(sleeved("s0")))
    with pytest.raises(ModelError, match=r"couplings\.row-a.*different speeds"):
        epicyclic.assemble(load(sleeved(None)))
    # where the carrier is held, the frame of the stage and the housing are alike
    epicyclic.assemble(load(sleeved(None, held="carrier")))


def test_a_body_in_the_frame_of_a_stage_stands_where_it_is_coupled() -> None:
    data = chain(["parallel"], ["gear"])
    data["bodies"]["c0_sleeve"]["frame"] = "s0"
    place = {body.name: body.centre for body in load(data).bodies}
    assert math.hypot(*place["s0/pinion"]) > 0.1
    assert place["c0_sleeve"] == pytest.approx(place["s0/pinion"], rel=1e-15)
    assert place["output"] == pytest.approx(place["s0/pinion"], rel=1e-15)


def test_stages_whose_frames_turn_together_couple_laterally() -> None:
    """Carriers tied to each other: two frames of exactly one speed."""
    data = tied()
    data["couplings"]["carriers"] |= {"radial": 1e8, "tilt": 1e6}
    train = load(data)
    frames = train.kinematics.frame_speed
    assert frames is not None
    assert frames["one"] == frames["two"] == Fraction(240)  # 900/(1 + 66/24)
    system = epicyclic.assemble(train)
    assert free_motions(system) == 1


def test_a_fixed_shaft_joins_all_six_directions_of_two_standing_frames() -> None:
    """Its springs at mid-length do not feel the two stages move as one piece, and feel everything else."""
    data = chain(["star", "parallel"], ["shaft", "torsional"])
    data["couplings"]["c0"]["ends"] = "fixed"
    for gear in ("wheel", "pinion"):
        data["stages"]["s1"][gear]["station"] = 0.5
    train = load(data)
    system = epicyclic.assemble(train)
    assert free_motions(system) == 1
    rows = np.array([name.startswith("c0/") for name in system.links.name])
    assert rows.sum() == 6
    pieces = []
    for axis in np.eye(3):
        places = {b.name: np.array([*b.centre, b.station]) for b in train.bodies}
        pieces.append({name: np.concatenate([axis, np.zeros(3)]) for name in places})
        pieces.append({name: np.concatenate([np.cross(axis, place), axis]) for name, place in places.items()})
    motions = np.array([reduced(train, system, piece) for piece in pieces])
    assert np.abs(motions @ system.links.B[:, rows]).max() < 1e-15  # rounding of lengths below 1 m
    assert np.linalg.matrix_rank(system.links.B[:, rows]) == 6


def tied() -> Document:
    """Two planetary stages on one carrier shaft: the first drives it, the second one is driven by it."""
    data: Document = {"format": 2, "title": "tied carriers", "stages": {}}
    for name, held in (("one", "ring"), ("two", "ring")):
        members = {member: dict(table) for member, table in (SET | CARRIER).items()}
        members[held]["support"] = LATERAL | {"rz": 1e9}
        data["stages"][name] = {"planets": 3, "module": 0.004, "face_width": 0.05, **members}
    data["stages"]["two"]["ring"]["teeth"] = 69
    data["stages"]["two"]["planet"]["teeth"] = 24
    data["stages"]["two"]["sun"]["teeth"] = 21
    data["couplings"] = {"carriers": {"between": ["one.carrier", "two.carrier"], "rz": 1e7}}
    data["operation"] = {
        "held": ["one.ring", "two.ring"],
        "speed": {"one.sun": "900 rpm"},
        "torque": {"one.sun": 1000.0, "two.sun": "balance"},
    }
    return data


# gravity -------------------------------------------------------------------------------------------------------------

G = np.array([1.5, -9.0, 0.0])


def frame_shift(train: Train, frame: str, axis: int) -> dict[str, Array]:
    """All bodies of one frame moved along one of its axes."""
    unit = np.eye(6)[axis]
    return {body.name: unit * (body.frame == frame) for body in train.bodies}


def weight(train: Train, system: System, frame: str, phase: float) -> Array:
    """Force of gravity on all bodies of a frame, in frame axes, when the lines stand at exp(i phase * f)."""
    total = sum(
        ((line.force[0] * np.exp(1j * phase * float(line.frequency))).real for line in system.lines), np.zeros(1)
    )
    return np.array([total @ reduced(train, system, frame_shift(train, frame, axis)) for axis in (0, 1)])


def test_gravity_acts_in_a_turning_and_in_a_standing_frame() -> None:
    """Turned back into the housing it is the weight of the stage, at any instant."""
    data = chain(["reducer", "star"], ["torsional", "gear"])
    data["operation"]["gravity"] = G.tolist()
    train = load(data)
    system = epicyclic.assemble(train)
    frames = train.kinematics.frame_speed
    assert frames is not None
    assert [line.frequency for line in system.lines] == [0, frames["s0"] / 60]
    assert frames["s1"] == 0
    for frame in ("s0", "s1", "housing"):
        mass = sum(body.mass for body in train.bodies if body.frame == frame)
        for time in (0.0, 0.0123, 0.4):
            turned = math.tau * float(frames.get(frame, Fraction(0))) / 60 * time
            c, s = math.cos(turned), math.sin(turned)
            in_housing = np.array([[c, -s], [s, c]]) @ weight(train, system, frame, math.tau * time)
            np.testing.assert_allclose(in_housing, mass * G[:2], rtol=1e-12)


def test_gravity_of_frames_that_turn_together_is_one_line() -> None:
    data = tied()
    data["operation"]["gravity"] = G.tolist()
    data["deviations"] = {"one": {"ring": {"run_out": 1e-5}}, "two": {"ring": {"run_out": 1e-5}}}
    train = load(data)
    system = epicyclic.assemble(train)
    frames = train.kinematics.frame_speed
    assert frames is not None
    # rings at rest, gravity, both stages: one frequency, exactly, beside the centrifugal load of the planets
    constant, turning = system.lines
    assert [constant.frequency, turning.frequency] == [0, frames["one"] / 60]
    assert set(constant.causes) == {"stages.one.planet.mass", "stages.two.planet.mass"}
    assert set(turning.causes) == {
        "operation.gravity",
        "deviations.one.ring.run_out",
        "deviations.two.ring.run_out",
    }
    mass = sum(body.mass for body in train.bodies)
    both = weight(train, system, "one", 0.0) + weight(train, system, "two", 0.0)
    np.testing.assert_allclose(both, mass * G[:2], rtol=1e-12)


def test_gravity_of_frames_of_different_speed_is_two_lines() -> None:
    data = chain(["reducer", "reducer"], ["torsional", "torsional"])
    data["operation"]["gravity"] = True
    train = load(data)
    frames = train.kinematics.frame_speed
    assert frames is not None
    found = [line.frequency for line in epicyclic.assemble(train).lines]
    assert found == [0, frames["s1"] / 60, frames["s0"] / 60]  # 0: the output stands in the housing
