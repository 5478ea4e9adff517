"""Bodies of a finite-element program in a train: frequencies, the rigid limit, turning, what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reduced_ring
from tests.unit.bodies.bricks import brick_ring
from tests.unit.bodies.test_text_files import calculix

from epicyclic import ModelError, assemble, load, static
from epicyclic.bodies.elastic_body import ElasticBody
from epicyclic.bodies.files import native_bytes, read_body
from epicyclic.bodies.joined_body import axisymmetric
from epicyclic.bodies.reduced_body import ReducedBody
from epicyclic.questions.modes.eigen import whirl
from epicyclic.questions.modes.modal import modal
from epicyclic.system.structure import structure_of
from epicyclic.train.train import Train

PAIRS = ([17, 18], [152, 151], [296, 295], [440, 439])  # inside and outside at each planet
INTERFACES = {f"planet-{i}": {"nodes": pair, "spider": "nodes"} for i, pair in enumerate(PAIRS, start=1)}
UNSTATED = {
    "stages.main.ring.base_radius": "137.52 mm",
    "stages.main.ring.mass": None,
    "stages.main.ring.inertia": None,
}


def with_ring(file: Path, more: dict[str, Any] | None = None, **keys: object) -> Train:
    """Lin and Parker's set of four planets with a ring by its matrices."""
    table = {"file": str(file), "interfaces": INTERFACES} | keys
    return load("lin1999-n4", UNSTATED | {"stages.main.ring.reduced": table} | (more or {}))


def written(folder: Path, body: ReducedBody, name: str = "body.npz") -> Path:
    (folder / name).write_bytes(native_bytes(body))
    return folder / name


def test_frequencies_of_the_set_with_a_ring_of_bricks() -> None:
    """Computed independently with the same matrices: the in-plane modes of the set."""
    train = with_ring(reduced_ring.KEPT)
    system = assemble(train)
    modes = modal(system)
    found = modes.frequency.values
    single = [316.724, 788.568, 1210.120, 1704.481, 1824.540, 1889.477, 2019.699, 2653.879]
    double = [675.989, 936.784, 1095.101, 1893.255, 2329.115, 2661.232]
    for value in single:
        assert np.sum(np.abs(found - value) < 6e-4) == 1
    for value in double:
        assert np.sum(np.abs(found - value) < 6e-4) == 2
        assert set(modes.mode_kind.values[np.abs(found - value) < 6e-4]) == {"translational"}
    # its interfaces are a quarter of a turn apart, and so are its modes
    assert system.symmetries[0].holds
    kinds = dict(zip(np.round(found, 3), modes.mode_kind.values, strict=True))
    assert [kinds[value] for value in (788.568, 1210.12, 1824.54, 1889.477)] == [*("planet", "rotational") * 2]
    assert any(text.endswith("[mean-motion-held]") for text in train.warnings)


def test_stiff_matrices_approach_the_rigid_body(tmp_path: Path) -> None:
    body, _ = read_body(reduced_ring.KEPT)
    worst = []
    for factor in (1e4, 1e6):
        stiff = with_ring(written(tmp_path, _stiffer(body, factor), f"{factor:g}.npz"))
        rigid = replace(stiff, bodies=tuple(replace(one, reduced=None) for one in stiff.bodies))
        expected = modal(assemble(rigid)).frequency.values
        found = modal(assemble(stiff)).frequency.values[: len(expected)]
        worst.append(float(np.abs(found[1:] / expected[1:] - 1).max()))
    assert worst[1] < 1e-4
    assert worst[1] == pytest.approx(worst[0] / 100, rel=0.05)


def _stiffer(body: ReducedBody, factor: float) -> ReducedBody:
    """A body of so many times the stiffness; its modes keep mass 1."""
    return replace(body, K=factor * body.K)


def test_axisymmetric_ring_is_seen_from_the_frame_shifted_by_its_waves(tmp_path: Path) -> None:
    """A held ring of bricks by its sectors, meshes too soft to matter: f_n - 40 n and f_n + 40 n Hz."""
    ring = brick_ring(32)
    file = written(tmp_path, ring)
    inside = {"nodes": [1, 2, 3, 4], "spider": "nodes"}
    soft = {"stiffness": "1 N/m"}
    more = {
        "stages.main.ring.reduced": {"file": str(file), "sectors": 32, "modes": 14, "interfaces": {"rim": inside}},
        "stages.main.meshes": {"sun-planet": soft, "planet-ring": soft},
        "operation": {"held": ["ring"], "speed": {"carrier": "2400 rpm"}},
    }
    for count in (3, 4):  # one circle of contacts serves any number of planets
        overrides = UNSTATED | {"stages.main.ring.base_radius": "136.4 mm"} | more
        train = load(f"lin1999-n{count}", overrides)
        joined = next(body.reduced for body in train.bodies if body.reduced is not None)
        free = np.sqrt(joined.springs.stiffness / np.diag(joined.mass)[6:]) / math.tau
        waves = np.abs(np.linalg.eigvals(joined.turn[6:, 6:]).imag)
        found = whirl(assemble(train), relative_speed=1.0).mu.imag / math.tau
        for f, n in {(round(f, 6), n) for f in free for n in np.round(waves) if _has(joined, f, n)}:
            for shifted in (f - 40 * n, f + 40 * n):
                assert np.abs(np.abs(found) - abs(shifted)).min() < 1e-3


def _has(joined: ElasticBody, frequency: float, waves: float) -> bool:
    """Whether modes of a frequency [Hz] have so many waves."""
    own = np.sqrt(joined.springs.stiffness / np.diag(joined.mass)[6:]) / math.tau
    at = np.abs(own - frequency) < 1e-3
    block = joined.turn[6:, 6:][np.ix_(at, at)]
    return bool(np.any(np.abs(np.abs(np.linalg.eigvals(block).imag) - waves) < 1e-3))


def test_contact_of_an_axisymmetric_ring_moves_with_its_angle(tmp_path: Path) -> None:
    """Rows at planets between the nodes of one sector: those of a ring turned as much."""
    file = written(tmp_path, brick_ring(32))
    table = {"file": str(file), "sectors": 32, "modes": 14, "interfaces": {"rim": {"nodes": [1, 2, 3, 4]}}}
    train = load(
        "lin1999-n4", UNSTATED | {"stages.main.ring.base_radius": "136.4 mm", "stages.main.ring.reduced": table}
    )
    joined = next(body.reduced for body in train.bodies if body.reduced is not None)
    points = np.array([[0.15 * math.cos(a), 0.15 * math.sin(a), 0.0] for a in (0.0, 2 * math.pi / 32, 1.0)])
    at = joined.shape(points)
    assert np.abs(at[1] - at[0]).max() > 1e-2 * np.abs(at).max()
    # of one mode and its partner the sum of squares of the radial motion is the same at any angle
    out = np.stack([points[:, 0], points[:, 1], 0 * points[:, 0]], axis=1) / 0.15
    radial = np.einsum("ra,rae->re", out, at[:, :3])
    size = np.sum(radial**2 / np.diag(joined.mass)[6:], axis=1)
    np.testing.assert_allclose(size, size[0], rtol=1e-6)


CARRIER = {
    "stages.main.carrier.mass": None,
    "stages.main.carrier.inertia": None,
    "stages.main.carrier.pin_radius": "155.379 mm",
    "operation": {"held": ["ring"], "speed": {"carrier": "1500 rpm"}},
}


def test_reduced_carrier_turns_with_its_frame(tmp_path: Path) -> None:
    """Its terms of the speed are those of its matrices; turned as one it stays neutral."""
    ring = brick_ring(32)
    nodes = {f"pin-{i}": {"nodes": [32 * i + k for k in (1, 2, 3, 4)]} for i in range(4)}
    table = {"file": str(written(tmp_path, ring)), "modes": 20, "interfaces": nodes}
    train = load(
        "lin1999-n4", CARRIER | {"stages.main.carrier.pin_radius": "150 mm", "stages.main.carrier.reduced": table}
    )
    system = assemble(train)
    joined = next(body.reduced for body in train.bodies if body.reduced is not None)
    # of a ring that turns with its frame, order 2 in its plane: coupling 2 n/(n^2 + 1) per speed, twice in G
    pair = sorted(range(len(joined.names)), key=lambda i: joined.springs.stiffness[i] / joined.mass[6 + i, 6 + i])
    free = np.sqrt(joined.springs.stiffness / np.diag(joined.mass)[6:]) / math.tau
    coupling = np.abs(joined.spin[6:, 6:]) / np.sqrt(np.outer(np.diag(joined.mass)[6:], np.diag(joined.mass)[6:]))
    assert any(
        abs(coupling[i, j] / 2 - 0.8) < 0.02 and abs(free[i] / free[j] - 1) < 1e-2 for i in pair[:8] for j in pair[:8]
    )
    turn = np.zeros(len(system.dofs.names))
    bodies = {body.name: body for body in train.bodies}
    for i, (name, d) in enumerate(zip(system.dofs.body, system.dofs.direction, strict=True)):
        turn[i] = {"rz": 1.0, "y": math.hypot(*bodies[name].centre)}.get(d, 0.0)
    force = system.Kg @ turn
    assert np.abs(force).max() < 1e-9 * np.abs(system.Kg).max()


WIDE = {"stages.main.face_width": "200 mm", "stages.main.meshes.planet-ring.slices": 5}
ONE = {"planet-1": {"nodes": PAIRS[0], "spider": "nodes"}}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"stages.main.ring.reduced": {"file": "none.npz"}}, "none.npz"),
        ({"stages.main.ring.reduced": {"stiffness": "k.mtx"}}, "missing; allowed: a file"),
        ({"stages.main.ring.reduced": {}}, "one way to name the files"),
        ({"stages.main.ring.reduced.interfaces": {"a": {"nodes": [9999]}}}, "interfaces.a.nodes = 9999"),
        ({"stages.main.ring.reduced": {"file": str(reduced_ring.KEPT), "interfaces": ONE}}, "no interface of the body"),
        (WIDE, "(151.2, 0, -80) mm from its centre of mass: no interface of the body where main/planet-ring/1"),
        ({"stages.main.ring.mass": "3 kg"}, "stages.main.ring.mass = 3"),
        ({"operation": {"held": ["ring"], "speed": {"carrier": "100 rpm"}}}, "turns against the axes of its stage"),
        ({"stages.main.ring.elastic": {"radius": "155 mm", "bending": "770 N m^2"}}, "elastic beside reduced"),
    ],
)
def test_bad_input_is_named(change: Any, message: Any) -> None:
    with pytest.raises(ModelError) as caught:
        with_ring(reduced_ring.KEPT, change)
    assert message in str(caught.value)
    assert "stages.main.ring" in str(caught.value)


def test_body_off_its_axis_is_refused(tmp_path: Path) -> None:
    ring = brick_ring(8)
    ring = replace(ring, node_xyz=np.add(ring.node_xyz, (0.01, 0.0, 0.0)))
    with pytest.raises(ModelError, match="centre of mass off the axis"):
        with_ring(
            written(tmp_path, ring),
            modes=6,
            interfaces={"a": {"nodes": [1, 2, 3, 4]}, "b": {"nodes": [17, 18, 19, 20]}},
        )


def test_an_accelerometer_has_no_place_on_matrices() -> None:
    """Their motion is known at interfaces alone; the mean rotation is known."""
    at = {"kind": "acceleration", "on": "ring", "radius": "150 mm"}
    with pytest.raises(ModelError, match=r"sensors.a.on = main.ring: main/ring is a body of matrices.*a rigid body"):
        with_ring(reduced_ring.KEPT, {"sensors.a": at})
    assert with_ring(reduced_ring.KEPT, {"sensors.a": {"kind": "angle", "on": "ring"}}).sensors[0].bodies == (
        "main/ring",
    )


def test_turned_interface_is_that_of_the_nodes_there(tmp_path: Path) -> None:
    """The motion seven sectors on: by D from the first sector, and by the nodes there."""
    file = written(tmp_path, brick_ring(32))
    there = {"rim": {"nodes": [1, 2, 3, 4]}, "on": {"nodes": [29, 30, 31, 32]}}
    table = {"file": str(file), "sectors": 32, "modes": 14, "interfaces": there}
    train = load(
        "lin1999-n4", UNSTATED | {"stages.main.ring.base_radius": "136.4 mm", "stages.main.ring.reduced": table}
    )
    shape: Any = next(body.reduced for body in train.bodies if body.reduced is not None).shape
    first = {name: getattr(shape, name)[:1] for name in ("names", "points", "shapes", "strains")}
    found = replace(shape, **first)(shape.points[1:])[0]
    assert np.abs(shape.shapes[1] - shape.shapes[0]).max() > 0.1
    np.testing.assert_allclose(found, shape.shapes[1], atol=1e-7 * np.abs(found).max())


def carrier_of(folder: Path, ring: ReducedBody, more: dict[str, Any] | None = None, **keys: object) -> Train:
    """Set of four planets whose carrier is a ring of bricks with its pins at sections of it."""
    nodes = {f"pin-{i}": {"nodes": [32 * i + k for k in (1, 2, 3, 4)]} for i in range(4)}
    file = written(folder, ring, f"{len(list(folder.iterdir()))}.npz")
    table = {"file": str(file), "modes": 20, "interfaces": nodes} | keys
    changes = {"stages.main.carrier.pin_radius": "150 mm", "stages.main.carrier.reduced": table}
    return load("lin1999-n4", CARRIER | changes | (more or {}))


def test_a_change_of_a_file_beside_the_named_one_is_seen(tmp_path: Path) -> None:
    """Twice the masses in the .mas, the .sti as it was."""
    calculix(brick_ring(8), tmp_path)
    nodes = {f"pin-{i}": {"nodes": [8 * i + k for k in (1, 2, 3, 4)]} for i in range(4)}
    table = {"file": str(tmp_path / "ring.sti"), "units": "kg m s", "modes": 6, "interfaces": nodes}
    changes = CARRIER | {"stages.main.carrier.pin_radius": "150 mm", "stages.main.carrier.reduced": table}
    masses = []
    for factor in (1.0, 2.0):
        terms = np.loadtxt(tmp_path / "ring.mas") * [1.0, 1.0, factor]
        np.savetxt(tmp_path / "ring.mas", terms, fmt=["%d", "%d", "%.17g"])
        masses += [body.mass for body in load("lin1999-n4", changes).bodies if body.kind == "carrier"]
    assert masses[1] == pytest.approx(2 * masses[0])


def test_origin_of_the_file_is_the_centre_of_the_member(tmp_path: Path) -> None:
    """A mesh whose centre of mass stands 20 mm along z, of a member 20 mm back, is the same body."""
    ring = brick_ring(32)
    moved = replace(ring, node_xyz=np.add(ring.node_xyz, (0.0, 0.0, 0.02)))
    tilting = {
        "stages.main.planet.tilt_inertia": "1e-3 kg m^2",
        "stages.main.carrier.support": {"radial": "1e8 N/m", "tilt": "1e6 N m/rad"},
    }
    here = assemble(carrier_of(tmp_path, ring, tilting))
    back = {"stages.main.carrier.station": "-20 mm", "stages.main.carrier.support.at": "20 mm"}
    there_train = carrier_of(tmp_path, moved, tilting | back)
    there = assemble(there_train)
    carrier = next(body for body in there_train.bodies if body.kind == "carrier")
    assert carrier.station == pytest.approx(0.0, abs=1e-9)
    # shapes of equal frequency are any of their plane
    for name in ("G", "K", "Kg"):
        one, other = (np.linalg.norm(getattr(system, name)) for system in (here, there))
        assert other == pytest.approx(one, rel=1e-6)
    np.testing.assert_allclose(
        modal(there, relative_speed=1.0).frequency, modal(here, relative_speed=1.0).frequency, rtol=1e-6, atol=1e-2
    )


def test_rows_of_a_tilting_pin_have_the_rotation_of_the_interface(tmp_path: Path) -> None:
    tilting = {"stages.main.planet.bearing": {"radial": "1e8 N/m", "tilt": "1e5 N m/rad"}}
    train = carrier_of(tmp_path, brick_ring(32), tilting | {"stages.main.planet.tilt_inertia": "1e-3 kg m^2"})
    rows = structure_of(train)
    (part,) = rows.elastic
    pin = np.array([[0.0, 0.15, 0.0]])  # of planet 2, whose axes are a quarter of a turn on
    moved = part.elastic.shape(pin)[0]
    at = {row.name: i for i, row in enumerate(rows.links)}
    for direction, expected in (("x", moved[1]), ("y", -moved[0]), ("rx", moved[4]), ("ry", -moved[3])):
        own = rows.link[at[f"main/planet/2/bearing/{direction}"], part.columns]
        np.testing.assert_allclose(own, expected, atol=1e-12 * np.abs(moved).max())
        assert np.abs(expected).max() > 1e-3


def test_damping_of_the_file_turns_with_the_material(tmp_path: Path) -> None:
    """C of a native file with D, held in a frame at -nu: C on the rates and nu C D on the places."""
    where, lag = "ring", 3e-6
    ring = axisymmetric(brick_ring(32), 32, 14, (1, 2, 3, 4), where)
    file = written(tmp_path, replace(ring, C=lag * np.asarray(ring.K)))
    table = {"file": str(file), "interfaces": {"rim": {"nodes": [1, 2, 3, 4]}}}
    more: dict[str, Any] = {"operation": {"held": ["ring"], "speed": {"carrier": "2400 rpm"}}}
    train = load(
        "lin1999-n4",
        UNSTATED | {"stages.main.ring.base_radius": "136.4 mm", "stages.main.ring.reduced": table} | more,
    )
    system, joined = assemble(train), next(body.reduced for body in train.bodies if body.reduced is not None)
    own = [i for i, d in enumerate(system.dofs.direction) if d.startswith("e")]
    expected = lag * np.diag(joined.springs.stiffness)
    np.testing.assert_allclose(system.C[np.ix_(own, own)], expected, atol=1e-9 * expected.max())
    skew = -math.tau * 40 * expected @ joined.turn[6:, 6:]
    np.testing.assert_allclose(system.Cskew[np.ix_(own, own)], skew, atol=1e-9 * np.abs(skew).max())
    assert np.abs(skew).max() > 0


def test_bolts_that_pass_a_carrier_are_refused(tmp_path: Path) -> None:
    bolts = {"count": 4, "radius": "150 mm", "radial": "1e8 N/m", "tangential": "1e8 N/m", "z": "1e8 N/m"}
    with pytest.raises(ModelError, match="bolts that pass a body that is not axisymmetric"):
        carrier_of(tmp_path, brick_ring(32), {"stages.main.carrier.support": {"bolts": bolts}})


@pytest.mark.parametrize(("member", "place"), [("sun", "(42.57, 0, "), ("planet", "(-55.18, ")])
def test_place_of_a_mesh_without_interface_is_said(tmp_path: Path, member: Any, place: Any) -> None:
    """The pitch point: outwards from the sun, inwards from the planet."""
    table = {
        "file": str(written(tmp_path, brick_ring(32))),
        "sectors": 32,
        "interfaces": {"a": {"nodes": [1, 2, 3, 4]}},
    }
    gone = {f"stages.main.{member}.mass": None, f"stages.main.{member}.inertia": None}
    with pytest.raises(ModelError) as caught:
        load("lin1999-n4", gone | {f"stages.main.{member}.reduced": table})
    assert place in str(caught.value)


LOADED: dict[str, object] = {"operation": {"held": ["ring"], "torque": {"sun": "500 N m", "carrier": "balance"}}}
LOADED |= {"stages.main.carrier.support": {"radial": "1e8 N/m", "rz": "inf"}}


def test_rest_under_a_load_is_found_whatever_hardly_moves_the_flanks() -> None:
    """Modes out of the plane move flanks by the rounding of the matrices: what is left on these is no force."""
    result = static(with_ring(reduced_ring.KEPT, LOADED))
    force = result.mesh_force.mean("time").values
    np.testing.assert_allclose(force, 500 / (4 * 38.71e-3), rtol=1e-6)


def test_ring_on_bolts_without_axial_stiffness_stays_where_these_hold_it() -> None:
    """Its centre of mass is in the plane of the bolts but for rounding: tilt is free and takes no part of x and y."""
    moved = []
    for axial in ({}, {"z": 0}):
        bolts = {"radius": "155.379 mm", "count": 4, "radial": "5e7 N/m", "tangential": "5e7 N/m", **axial}
        more = LOADED | {"stages.main.ring.support": {"radial": 0, "rz": 0, "bolts": bolts}}
        more |= {"deviations.planet.position.y": "[20, 0, 0, 0] um"}
        result = static(with_ring(reduced_ring.KEPT, more)).displacement.isel(time=0)
        moved.append(result.sel(dof=["main/ring/x", "main/ring/y"]).values)
    np.testing.assert_allclose(moved[1], moved[0], rtol=1e-6)


def test_dampers_to_the_ground_are_refused(tmp_path: Path) -> None:
    """They join mean motion and bending; damping proportional to mass and stiffness does not."""
    body, _ = read_body(reduced_ring.KEPT)
    with pytest.raises(ModelError, match="C: dampers of the mean motion that bend the body"):
        with_ring(written(tmp_path, replace(body, C=1e3 * np.eye(84))))
    fine = with_ring(written(tmp_path, replace(body, C=2.0 * body.M + 1e-6 * body.K), "fine.npz"))
    found = np.linalg.eigvalsh(assemble(fine).C)
    assert found[0] > -1e-9 * found[-1]


@pytest.mark.parametrize("factor", [0.0, 0.5, -1.0])
def test_another_derivative_than_that_along_the_angle_is_refused(tmp_path: Path, factor: float) -> None:
    ring = axisymmetric(brick_ring(32), 32, 14, (1, 2, 3, 4), "ring")
    assert ring.D is not None
    with pytest.raises(ModelError, match="is not the derivative along the angle"):
        read_body(written(tmp_path, replace(ring, D=factor * ring.D)))


def bolted(folder: Path, count: int) -> Train:
    """A held ring of bricks by its sectors, waves up to 2, on bolts that pass it."""
    file = written(folder, brick_ring(32), f"{count}.npz")
    table = {"file": str(file), "sectors": 32, "modes": 4, "interfaces": {"rim": {"nodes": [1, 2, 3, 4]}}}
    of_one = {key: f"{6e7 / count!r} N/m" for key in ("radial", "tangential", "z")}
    more: dict[str, Any] = {
        "stages.main.ring.base_radius": "136.4 mm",
        "stages.main.ring.reduced": table,
        "stages.main.ring.support": {"radial": 0, "rz": 0, "bolts": {"count": count, "radius": "150 mm", **of_one}},
        "operation": {"held": ["ring"], "speed": {"carrier": "2400 rpm"}},
    }
    return load("lin1999-n4", UNSTATED | more)


def test_bolts_that_pass_an_axisymmetric_body_have_their_mean(tmp_path: Path) -> None:
    """More than twice the waves are a uniform seat; fewer have its stiffness, and the rest is named."""
    many, few = bolted(tmp_path, 12), bolted(tmp_path, 3)
    joined = next(body.reduced for body in many.bodies if body.reduced is not None)
    assert joined.waves == 2
    assert not any("bolts-averaged" in text for text in many.warnings)
    assert any("bolts-averaged" in text for text in few.warnings)
    uniform, mean = assemble(many), assemble(few)
    np.testing.assert_allclose(mean.K, uniform.K, atol=1e-9 * np.abs(uniform.K).max())


def test_planets_that_bend_keep_the_symmetry_of_the_stage(tmp_path: Path) -> None:
    """A planet of bricks by its sectors: patterns of one planet are those of the next."""
    ring = brick_ring(32)
    small = replace(ring, node_xyz=ring.node_xyz * 0.36)  # a section at 54 mm
    table = {
        "file": str(written(tmp_path, small)),
        "sectors": 32,
        "modes": 6,
        "interfaces": {"rim": {"nodes": [1, 2, 3, 4]}},
    }
    gone: dict[str, Any] = {"stages.main.planet.mass": None, "stages.main.planet.inertia": None}
    hub: dict[str, Any] = {"stages.main.planet.reduced": table, "stages.main.planet.base_radius": "49.1 mm"}
    system = assemble(load("lin1999-n4", gone | hub))
    assert sum(direction.startswith("e") for direction in system.dofs.direction) == 4 * 6
    assert system.symmetries[0].holds
    assert set(modal(system).mode_kind.values) <= {"rotational", "translational", "planet"}
