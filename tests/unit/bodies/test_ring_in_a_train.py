"""A ring that bends in Lin and Parker's set: frequencies, neutral motions, families, the rigid limit, bolts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from epicyclic import ModelError, assemble, load, static
from epicyclic.bodies.elastic_body import Array, order_compliances
from epicyclic.questions.check.check import choices
from epicyclic.questions.modes.eigen import eigen, frequencies_of_bodies, whirl
from epicyclic.questions.modes.modal import modal
from epicyclic.system.system import System
from epicyclic.train.train import Train

RADIUS = 0.13752 * math.sqrt(3 / 2.35)
BENDING = 770.9016903845232  # N m^2, of a steel section 25.4 mm wide with the mass of the ring
NAMES = {count: f"lin1999-n{count}" for count in (3, 4, 5)}


def train_of(
    count: int = 4, *, bending: float = BENDING, modes: int = 16, more: dict[str, Any] | None = None, **keys: object
) -> Train:
    """Set of `count` planets with an inextensible ring, base radius as in BODIES."""
    table = {"radius": f"{RADIUS!r} m", "bending": f"{bending!r} N m^2", "modes": modes, **keys}
    base = {"stages.main.ring.base_radius": "137.52 mm", "stages.main.ring.elastic": table}
    return load(NAMES[count], base | (more or {}))


def bent_share(system: System, vectors: Array) -> Array:
    """Part of the kinetic energy of each mode in the coordinates by which the ring bends (modes,)."""
    own = np.array([direction not in ("x", "y", "z", "rx", "ry", "rz") for direction in system.dofs.direction])
    return np.asarray(np.einsum("im,ij,jm->m", vectors[own], system.M[np.ix_(own, own)], vectors[own]))


def test_frequencies_of_the_set_with_four_planets() -> None:
    found = modal(assemble(train_of())).frequency.values
    rotational = [1220.550, 1894.338, 2025.442, 2661.330, 6340.847]
    translational = [676.969, 938.771, 1095.295, 1897.644, 2333.157, 2692.295]
    planet = [792.137, 1826.332, 3667.483, 6346.754]
    alone = [316.558, 1716.776, 4072.914, 7374.977]
    expected = np.sort([0.0, *rotational, *np.repeat(translational, 2), *planet, *alone])
    low = found[found < 5000]
    np.testing.assert_allclose(low, expected[: len(low)], atol=6e-4)
    for value in (*rotational, *planet, *alone):
        assert np.abs(found - value).min() < 6e-4


def test_frequency_converges_with_the_orders() -> None:
    found = [modal(assemble(train_of(modes=n))).frequency.values[4] for n in (8, 16, 32)]
    np.testing.assert_allclose(found, [793.198, 792.137, 791.903], atol=6e-4)
    stretched = modal(assemble(train_of(modes=32, axial="63474037.299656756 N"))).frequency.values[4]
    assert stretched == pytest.approx(789.840, abs=6e-4)


def test_stiff_ring_approaches_the_rigid_one_with_its_stiffness() -> None:
    rigid = modal(assemble(load("lin1999-n4", {"stages.main.ring.base_radius": "137.52 mm"}))).frequency.values
    worst = []
    for factor in (1e4, 1e5, 1e6, 1e7):
        found = modal(assemble(train_of(bending=factor * BENDING, modes=4))).frequency.values[: len(rigid)]
        worst.append(float(np.abs(found[1:] / rigid[1:] - 1).max()))
    np.testing.assert_allclose(worst, [3.59e-3, 3.53e-4, 3.521e-5, 3.520e-6], rtol=2e-3)


@pytest.mark.parametrize("count", [3, 4, 5])
def test_modes_belong_to_one_family_of_orders(count: Any) -> None:
    """Orders jN are rotational, jN +- 1 translational, others planet; some orders n move the ring alone."""
    system = assemble(train_of(count))
    shapes = modal(system)
    orders = np.array([int(d[1:]) if d[0] in "ab" else -1 for d in system.dofs.direction])
    scale = np.sqrt(np.diag(system.M))
    rotational, translational = orders % count == 0, np.isin(orders % count, (1, count - 1))
    vectors = shapes["shape"].values / system.dofs.radius[:, None] * scale[:, None]
    for kind, vector in zip(shapes.mode_kind.values, vectors.T, strict=True):
        bent = np.where(orders > 0, vector, 0.0)
        own = {"rotational": rotational, "translational": translational}.get(kind, ~rotational & ~translational)
        if kind != "ring":
            assert np.sum(bent[own] ** 2) >= np.sum(bent**2) - 1e-9 * np.sum(vector**2)
    modes = eigen(system)
    alone = bent_share(system, modes.vectors) > 1 - 1e-9
    gaps = np.abs(system.meshes.B.T @ modes.vectors).max(axis=0) / np.abs(system.meshes.B).max()
    alone &= gaps < 1e-9 * np.abs(modes.vectors).max()
    free = train_of(count).bodies
    ring = next(body.elastic for body in free if body.elastic is not None)
    found = [n for n in range(2, 13) if np.abs(modes.omega[alone] / math.tau - ring.frequency(n)).min() < 1e-6]
    assert found == {3: [3, 6, 9, 12], 4: [2, 4, 6, 8, 10, 12], 5: [5, 10]}[count]


def free_stage(axial: object) -> dict[str, Any]:
    """A stage of consistent geometry that nothing holds, its carrier at 25 Hz and its ring turning."""
    floats = {"radial": 0, "rz": "0 N m/rad"}
    return {
        "format": 2,
        "title": "A stage of consistent geometry",
        "stages": {
            "main": {
                "planets": 3,
                "module": "3 mm",
                "face_width": "25 mm",
                "sun": {"teeth": 24, "bore": "30 mm", "support": floats},
                "planet": {"teeth": 33, "bore": "50 mm", "bearing": {"radial": "2e8 N/m"}},
                "ring": {
                    "teeth": 90,
                    "rim": "14 mm",
                    "elastic": {"modes": 6} | ({} if axial is None else {"axial": axial}),
                    "support": floats,
                },
                "carrier": {"mass": "9 kg", "inertia": "0.05 kg m^2", "support": floats},
            }
        },
        "operation": {"speed": {"carrier": "1500 rpm", "ring": "700 rpm"}},
    }


@pytest.mark.parametrize("axial", [None, True])
def test_motions_of_the_whole_train_stay_neutral_at_speed(axial: Any) -> None:
    """Turned or moved as one, nothing is strained and no inertia acts, whatever the speeds."""
    train = load(free_stage(axial))
    system = assemble(train)
    bodies = {body.name: body for body in train.bodies}
    omega = math.tau * 25
    turn, shift = np.zeros((2, len(system.dofs.names)), complex)
    for i, (name, d) in enumerate(zip(system.dofs.body, system.dofs.direction, strict=True)):
        body = bodies[name]
        turn[i] = {"rz": 1.0, "y": math.hypot(*body.centre)}.get(d, 0.0)
        # a shift in the housing turns backwards in the frame: x = cos, y = -sin
        shift[i] = {"x": np.exp(1j * body.angle), "y": 1j * np.exp(1j * body.angle)}.get(d, 0.0)
    K = system.mean_stiffness + system.Kg
    moving = -(omega**2) * system.M + 1j * omega * system.G + K
    for matrix, motion in ((K, turn), (moving, shift)):
        size = np.abs(matrix) @ np.abs(motion)
        assert size.max() > 1e6
        np.testing.assert_allclose(np.abs(matrix @ motion), 0.0, atol=1e-12 * size.max())


def test_modes_turn_with_the_speed_as_those_of_a_body_at_rest_seen_from_the_frame() -> None:
    """A ring that meshes with nothing that reacts: a set of soft meshes, seen from the carrier at 40 Hz."""
    soft = {
        "stages.main.meshes.sun-planet.stiffness": "1 N/m",
        "stages.main.meshes.planet-ring.stiffness": "1 N/m",
        "stages.main.ring.support": {"radial": "1e8 N/m", "rz": "1e9 N/m"},
        "operation": {"held": ["ring"], "speed": {"carrier": "2400 rpm"}},
    }
    train = train_of(modes=4, more=soft)
    ring = next(body.elastic for body in train.bodies if body.elastic is not None)
    found = whirl(assemble(train), relative_speed=1.0).mu.imag / math.tau
    for n in (2, 3, 4):
        for shifted in (ring.frequency(n) - 40 * n, ring.frequency(n) + 40 * n):
            assert np.abs(found - shifted).min() < 1e-4


def test_static_ring_under_its_planets_has_the_closed_form() -> None:
    """Ring free on soft springs, under equal forces of the meshes: radial deflection at the contacts."""
    stage = free_stage(None)
    ring = stage["stages"]["main"]["ring"]
    ring |= {"elastic": {"modes": 24}, "support": {"radial": "1e8 N/m", "rz": "1e9 N m/rad"}}
    stage["stages"]["main"]["meshes"] = {"planet-ring": {"stiffness": "4e8 N/m", "variation": "none"}}
    stage["stages"]["main"]["meshes"]["sun-planet"] = {"stiffness": "3e8 N/m", "variation": "none"}
    train = load(stage | {"operation": {"held": ["ring"], "torque": {"sun": "200 N m", "carrier": "balance"}}})
    result = static(train)
    dofs = list(result.dof.values)
    part = {name: result.displacement.values[i].mean() for i, name in enumerate(dofs) if name.startswith("main/ring")}
    mesh = next(mesh for mesh in train.meshes if mesh.internal)
    force = float(result.mesh_force.sel(mesh=mesh.name).mean()) if "mesh_force" in result else 0.0
    assert force > 0
    # loads with radial part sin, tangential part cos at the lever of the tooth: orders 3, 6, ..
    ring = next(body.elastic for body in train.bodies if body.elastic is not None)
    lever = mesh.radius_b - ring.radius
    for n in (3, 6, 9):
        turn = ring.section_turn(n)
        stiffness = math.pi * ring.bending * (n**2 - 1) ** 2 / ring.radius**3 * turn
        radial, tangential = force * math.sin(mesh.pressure_angle), force * math.cos(mesh.pressure_angle)
        a = 3 * radial / stiffness
        b = 3 * tangential * (1 / n + turn * lever / ring.radius * (1 / n - n)) / stiffness
        amplitude = math.hypot(part[f"main/ring/a{n}"], part[f"main/ring/b{n}"])
        assert amplitude == pytest.approx(math.hypot(a, b), rel=1e-9)


BOLTED = {
    "operation": {"held": ["ring"], "speed": {"carrier": "1800 rpm"}},
}


def bolts(count: int, z: object = 0) -> dict[str, Any]:
    """Bolts with the sum of six of 2e7 N/m along the radius and 1e7 N/m along the circle."""
    of_one = {
        "radial": f"{6 / count * 2e7!r} N/m",
        "tangential": f"{6 / count * 1e7!r} N/m",
    }
    return {
        "stages.main.ring.support": {
            "radial": 0,
            "rz": "0 N m/rad",
            "bolts": {"count": count, "radius": f"{RADIUS!r} m", **of_one, "z": z},
        },
        "stages.main.ring.tilt_inertia": "0.02 kg m^2",
        **BOLTED,
    }


def common(system: System, other: System) -> Array:
    """K of a system on the coordinates of another."""
    at = [system.dofs.names.index(name) for name in other.dofs.names]
    return system.K[np.ix_(at, at)]


def test_many_bolts_are_a_uniform_foundation() -> None:
    """12 bolts of a ring of orders up to 5: constant matrices, equal to the foundation of the same stiffness."""
    whole = 6 / (math.tau * RADIUS)
    foundation = {"radial": f"{2e7 * whole!r} N/m^2", "tangential": f"{1e7 * whole!r} N/m^2"}
    held = {"stages.main.ring.support": {"radial": 0, "rz": "0 N m/rad"}, **BOLTED}
    uniform = assemble(train_of(modes=5, more=held, foundation=foundation))
    for count in (11, 12):
        bolted = assemble(train_of(modes=5, more=bolts(count)))
        assert not any("bolts" in text for text in bolted.warnings)
        np.testing.assert_allclose(common(bolted, uniform), uniform.K, atol=1e-12 * np.abs(uniform.K).max())


def test_few_bolts_are_taken_by_their_mean_and_the_rest_is_named() -> None:
    uniform = assemble(train_of(modes=5, more=bolts(12)))
    few = assemble(train_of(modes=5, more=bolts(6)))
    (text,) = [text for text in few.warnings if text.endswith("[bolts-averaged]")]
    assert "6 bolts pass" in text
    assert "up to 0.54 varies" in text  # .5436 by the norms of K_1 and K_0, computed apart
    assert "with 5 orders the force of a bolt is not whole, from 6 on it is" in text
    assert not any("not whole" in text for text in assemble(train_of(modes=6, more=bolts(6))).warnings)
    scale = np.abs(uniform.K).max()
    np.testing.assert_allclose(few.K, uniform.K, atol=1e-12 * scale)
    standing = {"operation": {"held": ["carrier"], "speed": {"sun": "0 rpm"}}}
    # a frame that stands sees the bolts where they are
    split = assemble(
        train_of(
            modes=5,
            more=bolts(6)
            | standing
            | {"stages.main.meshes.sun-planet.stiffness": "1 N/m", "stages.main.meshes.planet-ring.stiffness": "1 N/m"},
        )
    )
    assert not any("bolts" in text for text in split.warnings)
    found = modal(split).frequency.values
    # cos 3 psi is on the radial springs of all bolts, sin 3 psi on the tangential ones
    for printed in (964.892, 1769.153):
        assert np.abs(found - printed).min() < 1e-3


def test_bolts_that_pass_stay_those_of_the_drawing() -> None:
    """Their mean is a matter of the equation: the train, and what `check` makes of it, has those that are drawn."""
    train = train_of(modes=5, more=bolts(6, "3e7 N/m"))
    names = [link.name for link in train.links if "/bolts/" in link.name]
    assert names == [f"main/ring/support/bolts/{i}" for i in range(1, 7)]
    rows = [name for name in assemble(train).links.link if "/bolts/" in name]
    assert len(dict.fromkeys(rows)) == 17  # 2 W + m + 1 places, W = 5 and m = 6
    (tilt,) = [choice for choice in choices(train) if choice.path == "stages.main.ring.support.tilt"]
    assert f"{6 * 3e7 * RADIUS**2 / 2:.4g} N m/rad" in tilt.value  # n k_z r^2/2


def test_force_of_a_passing_bolt_is_that_of_one() -> None:
    """Under a shift of the ring the load of all places is that of all bolts, the force of a row that of one bolt."""
    system = assemble(train_of(modes=5, more=bolts(6)))
    shift = np.array([1e-6 * (name == "main/ring/x") for name in system.dofs.names])
    at = [i for i, name in enumerate(system.links.name) if name.startswith("main/ring/support/bolts/0 deg")]
    forces = system.links.stiffness[at] * (system.links.B[:, at].T @ shift)
    assert np.abs(forces).max() == pytest.approx(2e7 * 1e-6, rel=1e-12)
    x = system.dofs.names.index("main/ring/x")
    own = [i for i, name in enumerate(system.links.name) if "/bolts/" in name]
    B, k = system.links.B[:, own], system.links.stiffness[own]
    assert ((B * k) @ (B.T @ shift))[x] == pytest.approx(6 * (2e7 + 1e7) / 2 * 1e-6, rel=1e-12)


def test_rigid_bolts_that_turn_are_refused() -> None:
    with pytest.raises(ModelError, match="finite stiffnesses"):
        load(
            "lin1999-n4",
            {
                "stages.main.ring.elastic": {"radius": "155 mm", "bending": "770 N m^2"},
                "stages.main.ring.support": {"bolts": {"count": 6, "radius": "160 mm"}},
                **BOLTED,
            },
        )


def block(system: System, matrix: Array, n: int) -> Array:
    """Block of a matrix on the coordinates of one order, (2, 2)."""
    at = [system.dofs.names.index(f"main/ring/{part}{n}") for part in "ab"]
    return matrix[np.ix_(at, at)]


@pytest.mark.parametrize(("ring_speed", "lag"), [(0, 2e-6), (700, 2e-6)])
def test_terms_of_the_speed_are_the_closed_ones(ring_speed: Any, lag: Any) -> None:
    """G, Kg, E and the skew term of material damping of a held and of a turning ring, order by order."""
    stage = free_stage(None)
    stage["operation"] = {"speed": {"carrier": "1500 rpm", "ring": f"{ring_speed} rpm"}}
    stage["damping"] = {"stiffness": lag}
    train = load(stage)
    system = assemble(train)
    ring = next(body.elastic for body in train.bodies if body.elastic is not None)
    frame, spin = math.tau * 25, math.tau * ring_speed / 60
    nu, J = spin - frame, np.array([[0.0, 1.0], [-1.0, 0.0]])
    for n in (2, 3, 6):
        slope = (n**2 - 1) / (n * ring.radius) * ring.section_turn(n)
        line = math.pi * ring.line_mass * ring.radius
        # per w = 1: v = -1/n and slope act together by the static moment rho I/R, on the slope alone by rho I
        static, second = math.pi * ring.line_inertia, math.pi * ring.radius * ring.line_inertia
        M = line * (1 + 1 / n**2) - 2 * static * slope / n + second * slope**2
        K = math.pi * ring.bending * (n**2 - 1) ** 2 / ring.radius**3 * ring.section_turn(n)
        along = line / n - static * slope
        coriolis = 2 * (M * nu * n - 2 * spin * along) * J
        own = line * (n**2 - 3) + 2 * n * static * slope + second * (n * slope) ** 2
        turning = own * spin**2 + 4 * nu * spin * n * along - (nu * n) ** 2 * M
        for matrix, expected in (
            (system.M, M * np.eye(2)),
            (system.G, coriolis),
            (system.euler, coriolis / 2),
            (system.Kg, turning * np.eye(2)),
            (system.Cskew, nu * lag * K * n * J),
        ):
            np.testing.assert_allclose(block(system, matrix, n), expected, atol=1e-12 * np.abs(expected).max())


def test_spin_widens_an_extensible_ring() -> None:
    """w = rho R^2 w^2 R/E, and of a rim rho I and E I beside rho A R^2 and E A R^2: its own centrifugal load."""
    train = load(free_stage(True))
    system = assemble(train)
    ring = next(body.elastic for body in train.bodies if body.elastic is not None)
    spin = math.tau * 700 / 60
    at = system.dofs.names.index("main/ring/a0")
    (still,) = [line for line in system.lines if line.frequency == 0]
    widened = float(still.force[2][at].real) / float(system.K[at, at])
    mass, stiffness = (
        ring.line_mass * ring.radius**2 + ring.line_inertia,
        ring.axial * ring.radius**2 + ring.bending,
    )
    assert widened == pytest.approx(mass * ring.radius**3 * spin**2 / stiffness, rel=1e-12)
    assert "stages.main.ring.elastic" in still.causes


def test_compliance_at_a_tooth_does_not_depend_on_the_orders() -> None:
    """What the ring has by its coordinates the stiffness of the teeth leaves out."""
    total = []
    for modes in (4, 8, 12, 20):
        stage = free_stage(None)
        stage["stages"]["main"]["ring"]["elastic"] = {"modes": modes}
        stage["stages"]["main"]["meshes"] = {"planet-ring": {"stiffness": "energy"}}
        train = load(stage)
        assert not any("rim-in-stiffness" in text for text in train.warnings)
        mesh = next(mesh for mesh in train.meshes if mesh.internal)
        ring = next(body.elastic for body in train.bodies if body.elastic is not None)
        normal = (math.sin(mesh.pressure_angle), math.cos(mesh.pressure_angle))
        total.append(1 / mesh.stiffness + order_compliances(ring, normal, mesh.radius_b).sum())
    assert 1 / mesh.stiffness < 0.1 * total[0]  # most of it is the ring
    np.testing.assert_allclose(total, total[-1], rtol=4e-3)


def test_speeds_reach_the_modes_of_bodies_and_not_the_waves_of_a_ring() -> None:
    system = assemble(train_of(axial="63474037.299656756 N"))
    rigid = assemble(load("lin1999-n4"))
    found, known = frequencies_of_bodies(system), frequencies_of_bodies(rigid)
    assert found.max() < 1.2 * known.max() < 0.5 * modal(system).frequency.max()
    np.testing.assert_allclose(known, modal(rigid).frequency[1:], rtol=1e-9)


@pytest.mark.parametrize("places", [{"angles": "[0, 10, 20] deg"}, {"angles": "[0, 180] deg"}, {"count": 1}])
def test_uneven_bolts_that_pass_a_rigid_ring_are_refused(places: dict[str, object]) -> None:
    more = bolts(6)
    of_one = more["stages.main.ring.support"]["bolts"]
    more["stages.main.ring.support"]["bolts"] = {k: v for k, v in of_one.items() if k != "count"} | places
    assert assemble(train_of(modes=5, more=more)).passing is not None
    with pytest.raises(ModelError, match="three or more equal bolts evenly spaced"):
        assemble(load("lin1999-n4", more))


def test_a_displaced_seat_moves_the_mean_of_passing_bolts_as_the_bolts() -> None:
    """Bolts whose circle is off by 20 um in x: the same load of the ring for 12 bolts as drawn and 6 by their mean."""
    off = {"deviations.ring.position": {"x": "20 um"}}
    loads = []
    for count in (12, 6):
        system = assemble(train_of(modes=5, more=bolts(count) | off))
        lines = [line for line in system.lines if "deviations.main.ring.position" in line.causes]
        assert [line.frequency for line in lines] == ([30] if count == 12 else [30, 150, 210])
        line = lines[0]
        at = [i for i, name in enumerate(system.dofs.names) if name.startswith("main/ring")]
        loads.append(line.force[0][at])
    assert np.abs(loads[0]).max() == pytest.approx(6 * 1.5e7 * 20e-6, rel=1e-9)
    np.testing.assert_allclose(loads[1], loads[0], atol=1e-9 * np.abs(loads[0]).max())


@pytest.mark.parametrize("ratio", [1e-4, 9e-3, 0.011, 0.3])
def test_bending_of_a_curved_rectangle_is_its_integral(ratio: float) -> None:
    """E I of a rim of the drawing, by the series of a thin one and by the logarithm."""
    stage = free_stage(None)
    root = load(stage).bodies[1].gear
    assert root is not None
    height = 2 * root.root_radius * ratio / (2 - ratio)
    stage["stages"]["main"]["ring"]["rim"] = f"{height!r} m"
    ring = next(body.elastic for body in load(stage).bodies if body.elastic is not None)
    y, weight = np.polynomial.legendre.leggauss(20)
    y = y * height / 2
    radius = root.root_radius + height / 2
    second = float(np.sum(weight * height / 2 * y**2 / (1 + y / radius)))
    assert ring.bending == pytest.approx(206e9 * 0.025 * second, rel=1e-8)


def test_bolts_of_a_ring_that_turns_are_refused() -> None:
    turning = {"operation": {"held": ["carrier"], "speed": {"sun": "1800 rpm"}}}
    with pytest.raises(
        ModelError, match=r"ring\.support\.bolts = -497.* rpm: bolts in the housing hold a body that turns"
    ):
        train_of(modes=5, more=bolts(6) | turning)


def test_orders_that_end_below_the_planets_are_warned_of() -> None:
    """Four planets drive order 4."""
    texts = [str(text) for text in train_of(modes=3, more=bolts(12)).warnings]
    assert any("4 planets drive the orders 4, 8, ..; orders end at 3" in text for text in texts)
    assert not any("planets drive" in str(text) for text in train_of(modes=4, more=bolts(12)).warnings)
