"""Full contact in the equilibrium of a train: springs as the limit, balance, pairs alone, tilt, branches and sides."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.statics.contact_equilibrium import ContactEquilibrium, ContactProblem, contact_equilibrium
from epicyclic.statics.equilibrium import compliance_of, equilibrium
from epicyclic.statics.record import excitation
from epicyclic.system.flank_laws import FaceForce
from epicyclic.system.system import System, faces
from epicyclic.system.tooth_pairs import face_laws, pair_of, with_three_rows
from epicyclic.teeth.loaded_contact import loaded_contact
from epicyclic.teeth.segments import RowStations, contact_segments, row_response, row_weights
from epicyclic.train.resolution import load
from epicyclic.train.train import Train

Array = NDArray[np.float64]
Document = dict[str, Any]
WIDTH = 0.05

BASE: Document = {
    "format": 2,
    "title": "a set",
    "stages": {
        "main": {
            "planets": 3,
            "module": 0.004,
            "helix_angle": math.radians(15),
            "face_width": WIDTH,
            "sun": {"teeth": 22, "support": {"radial": 1e8, "z": 1e8}},
            "planet": {"teeth": 23, "bearing": {"radial": 2e8, "z": 3e8}},
            "ring": {"teeth": 68, "rim": 0.03, "support": {"radial": 1e9, "z": 1e9}},
            "carrier": {"mass": 20.0, "inertia": 0.2, "tilt_inertia": 0.1, "support": {"radial": 3e8, "z": 1e8}},
            "meshes": {pair: {"stiffness": 4e8, "variation": "none"} for pair in ("sun-planet", "planet-ring")},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": 100.0}, "torque": {"sun": 1000.0}},
}
TILT = (("sun", "support"), ("planet", "bearing"), ("ring", "support"), ("carrier", "support"))


def document(**changes: Any) -> Document:
    """BASE with changes by path of the stage, points as double underscores; `deviations` as it stands."""
    data = copy.deepcopy(BASE)
    data["deviations"] = changes.pop("deviations", {})
    for path, value in changes.items():
        *tables, last = path.split("__")
        here = data["stages"]["main"]
        for name in tables:
            here = here.setdefault(name, {})
        here[last] = value
    return data


def tilting(data: Document, stiffness: float = 2e6) -> Document:
    """The same with tilt in every support and bearing."""
    for member, key in TILT:
        data["stages"]["main"][member][key]["tilt"] = stiffness
    return data


@dataclass(frozen=True)
class Springs:
    """Meshes as springs at places along the face that do not know each other: the contact without compliance shared."""

    meshes: tuple[int, ...]
    places: Array  # (K,) from -1/2 to 1/2 of the face
    stiffness: float

    def at(self, cycles: Array) -> Springs:
        return self

    @property
    def weight(self) -> Array:
        """(K, 3): ends of the face at -1/2 and 1/2."""
        return np.stack([0.5 - self.places, 0.5 + self.places, np.zeros(len(self.places))], axis=1)

    def press(self, rows: Array, instants: NDArray[np.int64], start: Array | None) -> FaceForce:
        way = np.maximum(rows @ self.weight.T, 0.0)
        on = np.where(way > 0, self.stiffness, 0.0)
        return FaceForce(
            force=self.stiffness * way @ self.weight,
            tangent=np.einsum("tgk,ki,kj->tgij", on, self.weight, self.weight),
            energy=self.stiffness * (way**2).sum(axis=2) / 2,
            residual=np.zeros(rows.shape[:2]),
            state=way,
        )


def solved(train: Train, contacts: Any = None, samples: int = 8) -> tuple[System, ContactEquilibrium, Any]:
    """The train with three rows a mesh, its equilibrium over one mesh cycle, and the contacts."""
    system = epicyclic.assemble(with_three_rows(train))
    index = np.arange(samples)
    acting = excitation(system, system.tones[0], index, samples)
    models = face_laws(train, slices=8) if contacts is None else contacts
    cycles = np.repeat((index / samples)[:, None], len(train.meshes), axis=1)
    ready = [(one.at(cycles[:, list(one.meshes)]), np.array(one.meshes)) for one in models]
    flexible = compliance_of(system)
    springs = equilibrium(flexible, stiffness=acting.stiffness, gap=acting.gap, force=acting.force, laws=system.laws)
    given = ContactProblem(system=system, flexible=flexible, contacts=ready, gap=acting.gap, force=acting.force)
    return system, contact_equilibrium(given, springs.displacement), ready


def mesh_forces(state: ContactEquilibrium) -> Array:
    force: Array = state.row_force.reshape(len(state.row_force), -1, 3).sum(axis=2)
    return force


DEVIATIONS: Document = {
    "sun": {"run_out": 20e-6},
    "planet": {"position": {"y": [15e-6, 0.0, 0.0]}, "tilt": {"x": [0.0, 3e-3, 0.0]}},
    "meshes": {"sun-planet": {"profile": 3e-6}, "planet-ring": {"gap": [1e-6, 0.0, 2e-6]}},
}


@pytest.mark.parametrize("changes", [{}, {"helix_angle": 0.0}], ids=["helical", "spur"])
def test_springs_without_coupling_are_the_slices_of_static(changes: Document) -> None:
    """Two formulations: rows of slices as springs of the train, and three rows with a potential in between."""
    count, samples = 4, 8
    data = tilting(document(deviations=DEVIATIONS, **changes))
    cut = copy.deepcopy(data)
    for mesh in cut["stages"]["main"]["meshes"].values():
        mesh["slices"] = count
    expected = epicyclic.static(cut, cycles=1, samples=samples)
    train = load(data)
    places = (np.arange(count) + 0.5) / count - 0.5
    springs = Springs(tuple(range(len(train.meshes))), places, train.meshes[0].stiffness / count)
    system, state, _ = solved(train, [springs], samples)
    # both solve to 1e-10 of the largest force or better
    scale = float(expected.mesh_force.max())
    np.testing.assert_allclose(mesh_forces(state).T, expected.mesh_force, atol=1e-8 * scale)
    rows = state.approach.reshape(samples, -1, 3)
    slices = np.maximum(rows @ springs.weight.T, 0.0) * springs.stiffness
    assert (slices == 0).any()  # tilted so that some slices are open
    np.testing.assert_allclose(slices.reshape(samples, -1).T, expected.slice_force, atol=1e-8 * scale)
    moved = (state.displacement * system.dofs.radius).T
    np.testing.assert_allclose(moved, expected.displacement, atol=1e-8 * np.abs(expected.displacement).max())


def test_forces_balance_the_torque_and_contact_conditions_hold() -> None:
    train = load(tilting(document(deviations=DEVIATIONS)))
    _, state, _ = solved(train)
    force = mesh_forces(state)
    mesh = train.meshes[0]
    lever = mesh.radius_a * math.cos(mesh.pressure_angle) * math.cos(mesh.base_helix)
    # the sun turns freely: whatever its branches share adds up to its torque at every instant
    np.testing.assert_allclose(force[:, :3].sum(axis=1) * lever, 1000.0, rtol=1e-9)
    assert np.ptp(force[:, 0]) > 1.0
    assert state.force_residual.max() <= 1e-12
    assert state.contact_residual.max() < 1e-11  # of the Newton steps, relative


@pytest.mark.parametrize("helix", [0.0, math.radians(15)])
def test_where_nothing_tilts_a_mesh_is_the_pair_alone_under_its_force(helix: float) -> None:
    """Given displacements inside the train, given loads outside: two solvers of the same teeth."""
    train = load(document(helix_angle=helix, deviations={"sun": {"run_out": 20e-6}}))
    samples = 6
    _, state, ready = solved(train, samples=samples)
    force = mesh_forces(state)
    for (at, numbers), states in zip(ready, state.states, strict=True):
        rows = state.approach.reshape(samples, -1, 3)[:, numbers]
        loads = at.faces(rows, states)
        for i, number in enumerate(numbers.tolist()):
            mesh = train.meshes[number]
            sigma = mesh.sense * (np.arange(samples) / samples + float(mesh.lead))
            alone = loaded_contact(pair_of(train, mesh, slices=8), force[None, :, number], sigma)
            # rigid bodies without tilt: every place of the face approaches alike
            np.testing.assert_allclose(rows[:, i], alone.approach[0][:, None] * np.ones(3), rtol=1e-8)
            lines = loads[i].force
            np.testing.assert_allclose(lines.sum(axis=1), alone.force[0].sum(axis=1), atol=1e-7 * force.max())


def test_identical_branches_share_alike() -> None:
    result = epicyclic.contact(document(helix_angle=0.0), samples=6, slices=4, loads=[0.5])
    # planets a third of a cycle apart: what each carries over a cycle is the same to rounding
    np.testing.assert_allclose(result.branch_load_factor, 1.0, rtol=1e-9)
    moved = epicyclic.contact(
        document(helix_angle=0.0, deviations={"planet": {"position": {"y": [15e-6, 0.0, 0.0]}}}),
        samples=6,
        slices=4,
        loads=[0.25, 2.0],
    )
    factor = moved.branch_load_factor.sel(mesh_pair="stages.main.meshes.sun-planet").values
    assert (np.diff(factor) < 0).all()  # an error in place weighs less, the more the teeth give way
    assert factor[0] > 1.05


def test_a_tilted_pin_loads_one_end_as_springs_do() -> None:
    """K_Hbeta = 1 + theta b / (2 delta) of an even stiffness along a spur face, delta the mean approach."""
    angle, count = 4e-4, 200
    data = document(helix_angle=0.0, deviations={"planet": {"tilt": {"x": [angle, angle, angle]}}})
    train = load(data)
    places = (np.arange(count) + 0.5) / count - 0.5
    springs = Springs(tuple(range(len(train.meshes))), places, train.meshes[0].stiffness / count)
    _, state, _ = solved(train, [springs], 1)
    rows = state.approach.reshape(1, -1, 3)[0]
    load_along = rows[0] @ springs.weight.T * springs.stiffness
    mesh = train.meshes[0]
    mean = mesh_forces(state)[0, 0] / mesh.stiffness
    # gap per length of the planet's row under its tilt about x, along the tooth normal: d cos alpha
    expected = 1 + math.cos(mesh.pressure_angle) * angle * WIDTH / (2 * mean) * (count - 1) / count
    assert load_along.max() / load_along.mean() == pytest.approx(expected, rel=1e-9)
    assert expected > 1.2


def test_two_meshes_of_a_planet_press_opposite_flanks_and_tilt_it() -> None:
    """The axial forces of a helical planet form a couple; the pin that holds it tilts by couple over tilt stiffness."""
    stiff = 1e6
    train = load(document(planet__bearing={"radial": 2e8, "z": 3e8, "tilt": stiff}))
    system, state, ready = solved(train, samples=4)
    sun, ring = train.meshes[0], next(m for m in train.meshes if m.internal)
    assert sun.flank == -ring.flank
    assert sun.b == ring.a
    tilt = [i for i, name in enumerate(system.dofs.names) if name in (f"{sun.b}/rx", f"{sun.b}/ry")]
    moment = -(system.meshes.B[tilt] @ state.row_force.T)  # of the teeth on the planet
    np.testing.assert_allclose(
        stiff * state.displacement[:, tilt].T, moment, rtol=1e-7, atol=1e-7 * np.abs(moment).max()
    )
    couple = 2 * mesh_forces(state)[:, 0] * math.sin(sun.base_helix) * sun.radius_b
    # the pressure along the face, which the tilt moves off the middle, takes part of it back
    largest = np.hypot(*moment)
    assert (largest < couple).all()
    assert (largest > 0.3 * couple).all()
    loads = [
        at.faces(state.approach.reshape(4, -1, 3)[:, m], s) for (at, m), s in zip(ready, state.states, strict=True)
    ]
    along = np.linspace(-1, 1, 8)
    lean = [float((np.mean([one.force.sum(axis=1) for one in meshes], axis=(0, 1)) * along).sum()) for meshes in loads]
    # one tilt, opposite flanks: the sun's mesh is pressed at one end of the face, the ring's at the other
    assert lean[0] * lean[1] < 0
    assert min(map(abs, lean)) > 0.02 * mesh_forces(state).mean()


def test_rows_are_the_gradient_of_their_energy() -> None:
    """Force and tangent against differences of the energy, with and without Hertz."""
    train = load(document())
    for linear_at in (None, 200e3):
        pair = pair_of(train, train.meshes[0], slices=6, linear_at=linear_at)
        pieces = contact_segments(pair, np.array([0.1, 0.7]))
        weight = row_weights(pieces, RowStations(left=-WIDTH / 2, right=WIDTH / 2, along=pair.plane.base_pitch))
        np.testing.assert_allclose(weight.sum(axis=2), 1.0, rtol=1e-12)
        rows = np.array([[20e-6, 26e-6, 22e-6], [24e-6, -10e-6, 8e-6]])
        phases, step = np.arange(2), 2e-9
        at = row_response(pieces, weight, rows, phases)
        assert ((at.segment > 0) != pieces.valid).any()  # a part of the face is open
        for k in range(3):
            ahead, back = (row_response(pieces, weight, rows + s * step * np.eye(3)[k], phases) for s in (1, -1))
            # differences of second order over steps of 1e-4 of the approach
            np.testing.assert_allclose(at.force[:, k], (ahead.energy - back.energy) / (2 * step), rtol=2e-6)
            slope = (ahead.force - back.force) / (2 * step)
            np.testing.assert_allclose(at.tangent[:, k], slope, atol=2e-4 * np.abs(at.tangent).max())


def test_weights_give_back_any_straight_field() -> None:
    pair = pair_of(load(document()), load(document()).meshes[0], slices=5)
    pieces = contact_segments(pair, np.array([0.2, 0.9]))
    at = RowStations(left=-0.02, right=0.03, along=7e-3)
    place = np.take_along_axis(pieces.lines.sigma.reshape(2, -1), pieces.index, axis=1) * pair.plane.base_pitch
    expected = 1e-5 + 3e-4 * pieces.zeta - 2e-3 * place
    rows = np.array([1e-5 + 3e-4 * at.left, 1e-5 + 3e-4 * at.right, 1e-5 - 2e-3 * at.along])
    np.testing.assert_allclose((row_weights(pieces, at) @ rows)[pieces.valid], expected[pieces.valid], rtol=1e-12)


def test_rows_are_the_velocities_of_points_of_the_plane_of_action() -> None:
    """n . (u + theta x r) at the ends of the face and one base pitch along n_t, written out for the sun."""
    train = load(tilting(document()))
    system = epicyclic.assemble(with_three_rows(train))
    mesh, pair = train.meshes[1], pair_of(train, train.meshes[1])
    psi, alpha, beta = mesh.direction, mesh.pressure_angle, mesh.base_helix
    e = np.array([math.cos(psi), math.sin(psi), 0.0])
    t = np.array([-math.sin(psi), math.cos(psi), 0.0])
    across = math.sin(alpha) * e + mesh.flank * math.cos(alpha) * t
    normal = math.cos(beta) * across - mesh.hand * mesh.flank * math.sin(beta) * np.array([0.0, 0.0, 1.0])
    rows = system.meshes.B[:, 3:6]
    sun = [system.dofs.names.index(f"{mesh.a}/{d}") for d in ("x", "y", "z", "rx", "ry", "rz")]
    for column, (zeta, along) in enumerate([(-WIDTH / 2, 0.0), (WIDTH / 2, 0.0), (0.0, pair.plane.base_pitch)]):
        point = mesh.radius_a * e + along * across + np.array([0.0, 0.0, zeta])
        np.testing.assert_allclose(rows[sun, column], [*normal, *np.cross(point, normal)], atol=1e-14)


def test_a_row_along_the_line_of_action_turns_with_the_bodies() -> None:
    """Rigid turning at the ratio opens no place of the plane of action; tilt turns the normal's arm along the path."""
    train = load(tilting(document()))
    system = epicyclic.assemble(with_three_rows(train))
    free = compliance_of(system).free
    assert free.shape[1] == 1
    np.testing.assert_allclose(system.meshes.B.T @ free, 0.0, atol=1e-12)
    plain = epicyclic.assemble(replace(train, meshes=tuple(replace(mesh, slices=()) for mesh in train.meshes)))
    B, first = system.meshes.B, faces(system.meshes).first
    # the middle of both ends is the row of the whole mesh
    np.testing.assert_allclose((B[:, first] + B[:, first + 1]) / 2, plain.meshes.B, atol=1e-12)
    assert np.abs(B[:, first + 2] - plain.meshes.B).max() > 1e-4


@pytest.mark.parametrize(
    ("changes", "options", "words"),
    [
        ({"face_width": None}, {}, "face_width"),
        ({}, {"loads": [-1.0]}, "relative loads"),
        ({}, {"loads": [0.0]}, "above 0"),
        ({}, {"samples": 0}, "samples"),
        ({"no torque": True}, {}, "no torque"),
    ],
)
def test_refused(changes: Document, options: Document, words: str) -> None:
    data = document()
    if "face_width" in changes:
        del data["stages"]["main"]["face_width"]
    if "no torque" in changes:
        del data["operation"]["torque"]
    with pytest.raises(ModelError, match=words):
        epicyclic.contact(data, slices=2, **options)
