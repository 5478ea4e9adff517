"""Bodies of a finite-element program in a train: frequencies, the rigid limit, turning, what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import reduced_ring
from tests.unit.bodies.bricks import brick_ring

from epicyclic import ModelError, assemble, load
from epicyclic.bodies.reading import read_body
from epicyclic.bodies.reduced_body import ReducedBody, native_bytes
from epicyclic.questions.modes.eigen import whirl
from epicyclic.questions.modes.modal import modal
from epicyclic.train.train import Train

PAIRS = ([17, 18], [152, 151], [296, 295], [440, 439])  # inside and outside at each planet
INTERFACES = {f"planet-{i}": {"nodes": pair, "spider": "nodes"} for i, pair in enumerate(PAIRS, start=1)}
UNSTATED = {
    "stages.main.ring.base_radius": "137.52 mm",
    "stages.main.ring.mass": None,
    "stages.main.ring.inertia": None,
}


def with_ring(file: Path, more: dict | None = None, **keys: object) -> Train:
    """Lin and Parker's set of four planets with a ring by its matrices."""
    table = {"file": str(file), "interfaces": INTERFACES} | keys
    return load("lin1999-n4", UNSTATED | {"stages.main.ring.reduced": table} | (more or {}))


def written(folder: Path, body: ReducedBody, name: str = "body.npz") -> Path:
    (folder / name).write_bytes(native_bytes(body))
    return folder / name


def test_frequencies_of_the_set_with_a_ring_of_bricks():
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


def test_stiff_matrices_approach_the_rigid_body(tmp_path):
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


def test_axisymmetric_ring_is_seen_from_the_frame_shifted_by_its_waves(tmp_path):
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
        free = np.sqrt(joined.stiffness / np.diag(joined.mass)[6:]) / math.tau
        waves = np.abs(np.linalg.eigvals(joined.turn[6:, 6:]).imag)
        found = whirl(assemble(train), relative_speed=1.0).mu.imag / math.tau
        for f, n in {(round(f, 6), n) for f in free for n in np.round(waves) if _has(joined, f, n)}:
            for shifted in (f - 40 * n, f + 40 * n):
                assert np.abs(np.abs(found) - abs(shifted)).min() < 1e-3


def _has(joined, frequency: float, waves: float) -> bool:
    """Whether modes of a frequency [Hz] have so many waves."""
    own = np.sqrt(joined.stiffness / np.diag(joined.mass)[6:]) / math.tau
    at = np.abs(own - frequency) < 1e-3
    block = joined.turn[6:, 6:][np.ix_(at, at)]
    return bool(np.any(np.abs(np.abs(np.linalg.eigvals(block).imag) - waves) < 1e-3))


def test_contact_of_an_axisymmetric_ring_moves_with_its_angle(tmp_path):
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


def test_reduced_carrier_turns_with_its_frame(tmp_path):
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
    pair = sorted(range(len(joined.names)), key=lambda i: joined.stiffness[i] / joined.mass[6 + i, 6 + i])
    free = np.sqrt(joined.stiffness / np.diag(joined.mass)[6:]) / math.tau
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


ONE = {"planet-1": {"nodes": PAIRS[0], "spider": "nodes"}}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"stages.main.ring.reduced": {"file": "none.npz"}}, "none.npz"),
        ({"stages.main.ring.reduced": {"stiffness": "k.mtx"}}, "missing; allowed: a file"),
        ({"stages.main.ring.reduced": {}}, "one way to name the files"),
        ({"stages.main.ring.reduced.interfaces": {"a": {"nodes": [9999]}}}, "interfaces.a.nodes = 9999"),
        ({"stages.main.ring.reduced": {"file": str(reduced_ring.KEPT), "interfaces": ONE}}, "no interface of the body"),
        ({"stages.main.ring.mass": "3 kg"}, "stages.main.ring.mass = 3"),
        ({"operation": {"held": ["ring"], "speed": {"carrier": "100 rpm"}}}, "turns against the axes of its stage"),
        ({"stages.main.ring.elastic": {"radius": "155 mm", "bending": "770 N m^2"}}, "elastic beside reduced"),
    ],
)
def test_bad_input_is_named(change, message):
    with pytest.raises(ModelError) as caught:
        with_ring(reduced_ring.KEPT, change)
    assert message in str(caught.value)
    assert "stages.main.ring" in str(caught.value)


def test_body_off_its_axis_is_refused(tmp_path):
    ring = brick_ring(8)
    ring = replace(ring, node_xyz=np.add(ring.node_xyz, (0.01, 0.0, 0.0)))
    with pytest.raises(ModelError, match="centre of mass off the axis"):
        with_ring(
            written(tmp_path, ring),
            modes=6,
            interfaces={"a": {"nodes": [1, 2, 3, 4]}, "b": {"nodes": [17, 18, 19, 20]}},
        )
