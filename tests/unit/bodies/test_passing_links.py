"""Links that pass a ring: bolts and a housing as a tone, beside a ring solved in the housing.

In the housing bolts stand and a load that stands in the frame turns: with constant matrices, each wave of a load at w
is one at w +- n Omega, and is read so.  Nothing but the shape of the ring is shared with the rows under test.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.unit.bodies.bricks import brick_ring

from epicyclic import (
    ModelError,
    assemble,
    load,
    modes,
    modulation,
    sharing,
    stability,
    static,
    steady,
    sweep,
    transient,
)
from epicyclic.bodies.elastic_body import Array
from epicyclic.bodies.files import native_bytes
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.response import respond, response
from epicyclic.questions.response.spectra import motion_signal
from epicyclic.questions.response.sweep_table import speeds_of
from epicyclic.questions.stability.stability import _each_alone, _floquet_at, floquet_scan, parametric_system
from epicyclic.questions.studies.gradient import force_derivatives
from epicyclic.questions.transient.equation import highest_rate, in_modes_of_its_speed
from epicyclic.questions.transient.equation import motion as motion_in_time
from epicyclic.statics.signals import line_label
from epicyclic.system.system import ComplexArray, ErrorRows, Line, System

from .test_ring_in_a_train import BENDING, RADIUS, bolts, train_of

ORDERS, FRAME = 5, 30  # Hz
NAMES = ("name", "pair", "stage", "branch", "side", "slice", "ends", "internal")  # of mesh rows
VALUES = ("stiffness", "variation", "tone", "damping", "backlash", "cos_base_helix", "direction")
RATE = 0.04 * math.tau * 900  # C per M [1/s], of the material of the ring
LOOSE = {name: {"stiffness": "1e-3 N/m", "variation": "none"} for name in ("sun-planet", "planet-ring")}


def housing_matrices(
    angles: Sequence[float], arm: tuple[float, ...] = (), bolt: float = 1e7, *, ground: bool = False
) -> tuple[Array, Array]:
    """M and K in the housing of a_1 b_1 .. a_5 b_5 and the rotation of the ring, then x, y, rz of an arm behind it.

    arm : mass [kg], inertia [kg m^2], lateral [N/m] and torsional [N m/rad] stiffness of what holds it.
    bolt : stiffness of one along the circle, half of that along the radius [N/m].
    ground : whether six bolts in the housing hold the ring beside the arm.
    """
    count, own = 2 * ORDERS + 1, 3 if arm else 0
    n = np.repeat(np.arange(1, ORDERS + 1), 2)
    line_mass = 2.35 / (math.tau * RADIUS)
    M = np.append(math.pi * line_mass * RADIUS * (1 + 1 / n**2), 3 * 0.13752**2)
    K = np.append(math.pi * BENDING * (n**2 - 1) ** 2 / RADIUS**3, 0.0)
    if arm:
        M, K = np.append(M, [arm[0], arm[0], arm[1]]), np.append(K, [arm[2], arm[2], arm[3]])
    M, K = np.diag(M), np.diag(K)
    for psi in [*angles, *(EVEN if ground else [])]:
        radial, tangential = np.zeros(count + own), np.zeros(count + own)
        radial[:count], tangential[:count] = radial_row(psi), tangential_row(psi)
        if arm and not (ground and psi in EVEN):
            radial[count:] = -math.cos(psi), -math.sin(psi), 0.0
            tangential[count:] = math.sin(psi), -math.cos(psi), -RADIUS
        K += bolt * (2 * np.outer(radial, radial) + np.outer(tangential, tangential))
    return M, K


EVEN = [math.tau * i / 6 for i in range(6)]
UNEVEN = [math.radians(angle) for angle in (0, 50, 130, 145, 290)]


def radial_row(psi: float) -> Array:
    """w at an angle of a_1 b_1 .. and the rotation."""
    return np.array([f(n * psi) for n in range(1, ORDERS + 1) for f in (math.cos, math.sin)] + [0.0])


def tangential_row(psi: float) -> Array:
    waves = [value / n for n in range(1, ORDERS + 1) for value in (-math.sin(n * psi), math.cos(n * psi))]
    return np.array([*waves, RADIUS])


def read_in_the_frame(solved: Mapping[int, ComplexArray]) -> dict[int, complex]:
    """Amplitudes by frequency [Hz] of w at the angle 0 of the frame, of motions in the housing."""
    found: dict[int, complex] = {}
    for f, q in solved.items():
        for n in range(1, ORDERS + 1):
            a, b = q[2 * n - 2], q[2 * n - 1]
            for at, value in ((f + FRAME * n, a / 2 + b / 2j), (f - FRAME * n, a / 2 - b / 2j)):
                found[at] = found.get(at, 0.0) + value
    return found


def housing_response(M: Array, K: Array, frequency: int) -> dict[int, complex]:
    """w at the angle 0 of the frame under 1 N there, by frequency [Hz]; M, K : of a_1 b_1 .. and others behind."""
    solved: dict[int, ComplexArray] = {}
    for n in range(1, ORDERS + 1):
        for sense in (1, -1):
            force, w = np.zeros(len(M), complex), math.tau * (frequency + sense * n * FRAME)
            force[2 * n - 2 : 2 * n] = 0.5, -0.5j * sense
            solved[frequency + sense * n * FRAME] = np.asarray(
                np.linalg.solve(K + (1j * w * RATE - w**2) * M, force), complex
            )
    return read_in_the_frame(solved)


def with_damped_material(system: System) -> System:
    """The system with C of the ring's material: its skew term in the frame, c nu M D."""
    names, skew = list(system.dofs.names), np.zeros_like(system.M)
    for n, (a, b) in enumerate([("x", "y")] + [(f"a{n}", f"b{n}") for n in range(2, ORDERS + 1)], start=1):
        i, j = names.index(f"main/ring/{a}"), names.index(f"main/ring/{b}")
        skew[i, j] = -math.tau * FRAME * RATE * system.M[i, i] * n
        skew[j, i] = -skew[i, j]
    return replace(system, Cskew=skew)


def ring_alone(table: dict[str, Any] | None = None, more: dict[str, Any] | None = None) -> System:
    """The ring of the set and what holds it, with bolts behind it, on coordinates of its own."""
    of_bolts = bolts(6)
    if table is not None:
        of_one = of_bolts["stages.main.ring.support"]["bolts"]
        of_bolts["stages.main.ring.support"]["bolts"] = {k: v for k, v in of_one.items() if k != "count"} | table
    loose = {"stages.main.meshes": LOOSE, "damping": {"mass": RATE}}
    system = assemble(train_of(modes=ORDERS, more=of_bolts | loose | (more or {})))
    at = [i for i, body in enumerate(system.dofs.body) if body in ("main/ring", "arm")]
    own, dofs, passing, meshes = np.ix_(at, at), system.dofs, system.passing, system.meshes
    rows = np.flatnonzero(meshes.B[at].any(axis=0))
    ring_meshes: dict[str, Any] = {name: getattr(meshes, name)[rows] for name in VALUES}
    ring_meshes |= {name: tuple(getattr(meshes, name)[i] for i in rows) for name in NAMES}
    return replace(
        system,
        **{name: getattr(system, name)[own] for name in ("M", "C", "G", "K", "Kg", "Cskew")},
        force=system.force[at],
        euler=np.zeros((0, 0)),
        spin_up=np.zeros(0),
        dofs=replace(
            dofs,
            **{name: tuple(getattr(dofs, name)[i] for i in at) for name in ("names", "body", "direction")},
            radius=dofs.radius[at],
            expand=dofs.expand[:, at],
        ),
        meshes=replace(meshes, **ring_meshes, B=meshes.B[at][:, rows]),
        links=replace(system.links, B=system.links.B[at]),
        lines=tuple(replace(line, force=line.force[:, at], gap=line.gap[rows]) for line in system.lines),
        passing=None if passing is None else replace(passing, B=passing.B[at]),
        symmetries=(),
        errors=ErrorRows(),
    )


def radial_dofs(system: System) -> Array:
    """w at the angle 0 of the frame, on the coordinates."""
    wanted = {"main/ring/x", *(f"main/ring/a{n}" for n in range(2, ORDERS + 1))}
    return np.array([float(name in wanted) for name in system.dofs.names])


def amplitudes(system: System, tolerance: float = 1e-12) -> dict[Fraction, complex]:
    """Amplitudes by frequency [Hz] of w at the angle 0 of the frame, at the operating speed."""
    ready = response(system)
    (block,) = respond(ready, np.array([1.0]), tolerance=tolerance)
    assert block.residual[0] < 1e-9
    signal = motion_signal(ready, block)
    lines = signal.line_frequencies
    values = radial_dofs(system) @ lines.merged(signal.values)[:, 0]
    return {Fraction(int(f), lines.unit): value for f, value in zip(lines.distinct, values, strict=True)}


def under_unit_force(system: System, frequency: int) -> System:
    """The system with 1 N along w at the angle 0 of the frame as its only load."""
    force = np.zeros((3, len(system.force)), complex)
    force[0] = radial_dofs(system)
    still = np.zeros(len(system.meshes.name), complex), np.zeros(len(system.links.name), complex)
    line = Line(frequency=Fraction(frequency), gap=still[0], link_gap=still[1], force=force)
    return replace(system, lines=(line,), force=np.zeros_like(system.force))


def test_six_bolts_have_the_printed_lines() -> None:
    """1 N at 500 Hz, frame 30 Hz: 500 +- 180 Hz and no other line."""
    found = amplitudes(under_unit_force(with_damped_material(ring_alone()), 500))
    large = {int(f): abs(value) for f, value in found.items() if abs(value) > 1e-14}
    assert large.keys() == {320, 500, 680}
    np.testing.assert_allclose([large[f] for f in sorted(large)], [1.25708e-8, 6.85476e-8, 1.73576e-8], rtol=5e-6)
    known = housing_response(*housing_matrices(EVEN), 500)
    for f, value in large.items():
        assert value == pytest.approx(abs(known[f]), rel=1e-9)


def test_uneven_bolts_have_the_lines_of_the_housing() -> None:
    system = ring_alone({"angles": "[0, 50, 130, 145, 290] deg"})
    assert system.passing is not None
    assert system.passing.tones == (Fraction(FRAME),)
    found, known = (
        amplitudes(under_unit_force(with_damped_material(system), 500)),
        housing_response(*housing_matrices(UNEVEN), 500),
    )
    largest = max(map(abs, known.values()))
    for f, value in known.items():
        assert abs(found.get(Fraction(f), 0.0) - value) < 1e-8 * largest
    assert sum(abs(value) > 1e-3 * largest for value in known.values()) > 10


def test_multipliers_over_a_turn_are_those_of_the_bolted_ring_at_rest() -> None:
    """To the step of fourth order: 16 times the steps of a verb."""
    system = replace(ring_alone(), C=np.zeros_like(ring_alone().C))
    ready = parametric_system(system)
    period = float(ready.cycles / ready.tones[0])
    turns = round(1 / FRAME / period)
    M, K = housing_matrices(EVEN)
    omega = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    found = _floquet_at(ready, float(ready.tones[0]), 4000).multipliers ** turns
    off = [np.abs(found - np.exp(sign * 1j * w / FRAME)).min() for w in omega for sign in (1, -1)]
    assert turns * period == pytest.approx(1 / FRAME, rel=1e-12)
    assert max(off) < 2e-8


def test_stiffness_at_an_instant_is_that_of_bolts_where_they_then_are() -> None:
    """K of the frame and that of a frame that stands, with bolts drawn where they have come to."""
    system = ring_alone({"angles": "[0, 50, 130, 145, 290] deg"})
    passing = system.passing
    assert passing is not None
    for instant in (0.0, 0.0021, 0.0173):
        angles = [math.degrees(psi) - 360 * FRAME * instant for psi in UNEVEN]
        drawn = ", ".join(f"{angle % 360:.12f}" for angle in angles)
        standing = {"operation": {"held": ["carrier"], "speed": {"sun": "0 rpm"}}}
        there = ring_alone({"angles": f"[{drawn}] deg"}, standing)
        turns = np.exp(2j * np.pi * np.arange(1, passing.wave.shape[1] + 1) * FRAME * instant)
        K = system.K + (passing.B * (passing.wave @ turns).real) @ passing.B.T
        at = [i for i, name in enumerate(system.dofs.names) if name.startswith("main/ring")]
        same = [there.dofs.names.index(system.dofs.names[i]) for i in at]
        scale = np.abs(there.K).max()
        np.testing.assert_allclose(K[np.ix_(at, at)], there.K[np.ix_(same, same)], atol=1e-9 * scale)


def test_displaced_bolts_push_the_ring_at_all_their_lines() -> None:
    """Bolts off by 20 um in x: in the housing a load that stands."""
    table = {"angles": "[0, 50, 130, 145, 290] deg", "z": "3e7 N/m"}
    system = ring_alone(table, {"deviations.ring.position": {"x": "20 um"}})
    M, K = housing_matrices(UNEVEN)
    unit = np.zeros(len(M))
    unit[0] = 20e-6
    bent = np.diag(
        [0.0] * 2 + [math.pi * BENDING * (n**2 - 1) ** 2 / RADIUS**3 for n in (2, 2, 3, 3, 4, 4, 5, 5)] + [0]
    )
    known = read_in_the_frame({0: np.asarray(np.linalg.solve(K, (K - bent) @ unit), complex)})
    found = amplitudes(replace(with_damped_material(system), force=np.zeros_like(system.force)))
    largest = max(map(abs, known.values()))
    for f in range(0, FRAME * ORDERS + 1, FRAME):
        value = known.get(f, 0.0) + (np.conj(known.get(-f, 0.0)) if f else 0.0)
        assert abs(found.get(Fraction(f), 0.0) - value) < 1e-7 * largest, f


FLANGE = {"count": 4, "radius": "150 mm", "radial": "2e7 N/m", "tangential": "1e7 N/m", "z": "1e7 N/m"}
ARM = (8.0, 0.3, 4e7, 3e6)
HELD_BY_ARM = {
    "stages.main.ring.support": {"radial": 0, "rz": "0 N m/rad"},
    "stages.main.ring.tilt_inertia": "0.02 kg m^2",
    "bodies.arm": {"mass": "8 kg", "inertia": "0.3 kg m^2", "support": {"radial": "4e7 N/m", "rz": "3e6 N m/rad"}},
    "couplings.bolted": {
        "between": ["main.ring", "arm"],
        "bolts": {"count": 6, "radius": f"{RADIUS!r} m", "radial": "2e7 N/m", "tangential": "1e7 N/m", "z": 0},
    },
    "operation": {"held": ["ring"], "speed": {"carrier": "1800 rpm"}},
}


@pytest.mark.parametrize("between", [["main.ring", "arm"], ["arm", "main.ring"]])
def test_a_torque_arm_behind_the_ring_has_the_lines_of_the_housing(between: list[str]) -> None:
    """Three bodies of freedom of the arm in the housing, the ring in the axes of the carrier."""
    behind = {**HELD_BY_ARM, "couplings.bolted": {**HELD_BY_ARM["couplings.bolted"], "between": between}}  # type: ignore[dict-item]
    system = ring_alone(more=behind)
    known = housing_response(*housing_matrices(EVEN, ARM), 500)
    found = amplitudes(under_unit_force(with_damped_material(system), 500), 1e-10)
    largest = max(map(abs, known.values()))
    assert abs(known[500] - housing_response(*housing_matrices(EVEN), 500)[500]) > 1e-2 * largest  # the arm gives way
    for f, value in known.items():
        assert abs(found.get(Fraction(f), 0.0) - value) < 1e-7 * largest, f


def test_bolts_in_the_housing_beside_an_arm_share_its_tone() -> None:
    """Five uneven bolts to the arm, six to the housing: 180 Hz is a multiple of 30 Hz."""
    flange = {k: v for k, v in HELD_BY_ARM["couplings.bolted"]["bolts"].items() if k != "count"}  # type: ignore[index]
    flange["angles"] = "[10, 50, 130, 145, 290] deg"
    both = {k: v for k, v in HELD_BY_ARM.items() if k != "stages.main.ring.support"}
    system = ring_alone(more=both | {"couplings.bolted": {"between": ["main.ring", "arm"], "bolts": flange}})
    assert system.passing is not None
    assert system.passing.tones == (Fraction(30),)
    angles = [math.radians(10), *UNEVEN[1:]]
    known = housing_response(*housing_matrices(angles, ARM, ground=True), 500)
    found = amplitudes(under_unit_force(with_damped_material(system), 500), 1e-9)
    largest = max(map(abs, known.values()))
    for f, value in known.items():
        assert abs(found.get(Fraction(f), 0.0) - value) < 1e-5 * largest, f


def test_a_soft_arm_behind_stiff_bolts_is_found() -> None:
    """Bolts 200 times as stiff as what holds the arm: ring and arm are one body, which no mean stiffness is."""
    stiff = {**FLANGE, "count": 6, "radius": f"{RADIUS!r} m", "radial": "1e10 N/m", "tangential": "5e9 N/m", "z": 0}
    behind = {**HELD_BY_ARM, "couplings.bolted": {"between": ["main.ring", "arm"], "bolts": stiff}}
    known = housing_response(*housing_matrices(EVEN, ARM, 5e9), 500)
    found = amplitudes(under_unit_force(with_damped_material(ring_alone(more=behind)), 500), 1e-10)
    largest = max(map(abs, known.values()))
    for f, value in known.items():
        assert abs(found.get(Fraction(f), 0.0) - value) < 1e-5 * largest, f


def test_a_housing_that_bends_behind_the_ring_has_the_lines_of_the_housing(tmp_path: Path) -> None:
    """A housing by its matrices; of a train at rest its bolts are rows of constant coefficients."""
    file = tmp_path / "housing.npz"
    file.write_bytes(native_bytes(brick_ring(32)))
    flange = {f"bolt-{i}": {"nodes": [32 * i + 1, 32 * i + 2, 32 * i + 3, 32 * i + 4]} for i in range(4)}
    bolted = {**HELD_BY_ARM["couplings.bolted"], "bolts": FLANGE}  # type: ignore[dict-item]
    behind: dict[str, Any] = {
        **HELD_BY_ARM,
        "bodies.arm": {
            "reduced": {"file": str(file), "modes": 8, "interfaces": flange},
            "support": {"radial": "4e7 N/m", "rz": "3e6 N m/rad", "z": "1e8 N/m"},
        },
        "couplings.bolted": bolted,
    }
    standing = ring_alone(more=behind | {"operation": {"held": ["ring"]}})
    assert standing.passing is None
    names = list(standing.dofs.names)
    ring = ["x", "y", *(f"{part}{n}" for n in range(2, ORDERS + 1) for part in "ab")]
    own = [names.index(f"main/ring/{name}") for name in ring]
    at = np.ix_(*2 * [own + [i for i in range(len(names)) if i not in own]])
    known = housing_response(standing.M[at], standing.K[at], 500)
    system = with_damped_material(ring_alone(more=behind))
    found = amplitudes(under_unit_force(system, 500), 1e-10)
    largest = max(map(abs, known.values()))
    for f, value in known.items():
        assert abs(found.get(Fraction(f), 0.0) - value) < 1e-7 * largest, f


STAGE: dict[str, Any] = {
    "format": 2,
    "title": "Stage on bolts",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "meshes": {
                "sun-planet": {"stiffness": "3e8 N/m", "variation": {"cosine": [0.1]}},
                "planet-ring": {"stiffness": "3e8 N/m", "variation": {"cosine": [0.1, 0.03]}},
            },
            "sun": {"teeth": 27, "mass": "6 kg", "inertia": "0.01 kg m^2", "support": {"radial": "2e7 N/m"}},
            "planet": {"teeth": 24, "mass": "4 kg", "inertia": "0.006 kg m^2", "bearing": {"radial": "4e8 N/m"}},
            "carrier": {"mass": "30 kg", "inertia": "0.5 kg m^2", "support": {"radial": "5e8 N/m"}},
            "ring": {
                "teeth": 75,
                "mass": "20 kg",
                "inertia": "0.6 kg m^2",
                "tilt_inertia": "0.3 kg m^2",
                "elastic": {"radius": "165 mm", "bending": "20 kN m^2", "modes": 5},
                "support": {
                    "radial": 0,
                    "rz": "0 N m/rad",
                    "bolts": {
                        "count": 6,
                        "radius": "175 mm",
                        "radial": "2e8 N/m",
                        "tangential": "1e8 N/m",
                        "z": "1e8 N/m",
                    },
                },
            },
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "900 rpm"}, "torque": {"sun": "500 N m", "carrier": "balance"}},
}


def motion(system: System, time: Array) -> tuple[Array, Array]:
    """Coordinates and rates (n, T) of the steady response at instants (T,) [s]."""
    ready = response(system)
    (block,) = respond(ready, np.array([1.0]), tolerance=1e-9)
    signal = motion_signal(ready, block)
    lines = signal.line_frequencies
    omega = math.tau * np.array([float(Fraction(int(f), lines.unit)) for f in lines.distinct])
    wave, amplitude = np.exp(1j * np.outer(omega, time)), lines.merged(signal.values)[:, 0]
    return (amplitude @ wave).real, ((1j * omega * amplitude) @ wave).real


def test_transient_stays_on_the_steady_motion_of_both_tones() -> None:
    """Started on it, five cycles of the bolts later; without the tone the motion there is another one."""
    system = assemble(load(STAGE))
    assert system.passing is not None
    span = 5 / float(system.passing.tones[0])
    before, after = (np.stack(motion(system, np.array([t])))[:, :, 0] for t in (0.0, span))
    run = transient(system, initial=before, duration=span, contact="linear", samples=64)
    end = run.end_displacement.values / system.dofs.radius
    weight = np.abs(after[0]).max() * np.array([1.0 if r == 1.0 else 1 / r for r in system.dofs.radius])
    assert np.abs((end - after[0]) / weight).max() < 1e-5
    mean = replace(system, passing=None)
    assert np.abs((motion(mean, np.array([span]))[0][:, 0] - after[0]) / weight).max() > 1e-3


def test_steps_with_numpy_have_the_tone_of_compiled_ones() -> None:
    system = assemble(load(STAGE))
    runs = [transient(system, cycles=0.5, contact="linear", method=method) for method in ("rk4", "radau")]
    one, other = (run.mesh_force.values for run in runs)
    np.testing.assert_allclose(other, one, atol=1e-5 * np.abs(one).max())


def test_stability_and_steady_name_the_tone_of_the_bolts() -> None:
    system = assemble(load(STAGE))
    result = steady(system)
    assert any("main/ring/support/bolts" in str(name) for name in result.combination.values)
    assert stability(system, relative_speed=[1.0]).stable.item()
    assert np.isfinite(static(system).mesh_force.values).all()


def test_dampers_of_links_between_frames_are_refused() -> None:
    coupling = {**HELD_BY_ARM["couplings.bolted"], "x": "1e6 N/m", "y": "1e6 N/m", "damping": {"x": "10 N s/m"}}  # type: ignore[dict-item]
    with pytest.raises(ModelError, match="dampers between bodies of different frames"):
        assemble(train_of(modes=ORDERS, more={**HELD_BY_ARM, "couplings.bolted": coupling}))


@pytest.fixture(scope="module")
def bolted() -> System:
    """The stage on six bolts."""
    return assemble(load(STAGE))


@pytest.fixture(scope="module")
def averaged(bolted: System) -> System:
    """The same with the mean of the bolts."""
    return replace(bolted, passing=None)


def test_contact_loss_and_the_forces_at_resonances_have_the_mean(bolted: System, averaged: System) -> None:
    """What knows the mesh frequencies alone: equal to the train without the tone."""
    runs = [sweep(one, contact_loss=True, relative_speed=[0.9]) for one in (bolted, averaged)]
    np.testing.assert_array_equal(*(run.mesh_force_peak.values for run in runs))
    forces = [modes(one).resonance_amplitude.values for one in (bolted, averaged)]
    np.testing.assert_array_equal(*forces)
    assert len(forces[0])


def test_sharing_and_speeds_follow_the_mesh_frequency(bolted: System, averaged: System) -> None:
    one, other = (response(system) for system in (bolted, averaged))
    np.testing.assert_array_equal(speeds_of(one, SweepOptions()), speeds_of(other, SweepOptions()))
    assert sharing(bolted, method="steady").sizes["mesh"] == len(set(bolted.meshes.name))


def test_modulation_names_the_tone(bolted: System) -> None:
    families = set(modulation(bolted, floor=0.0).family.values.tolist())
    assert "main/ring/support/bolts passing" in families
    assert not any("another stage" in text for text in families)


def test_a_mesh_frequency_alone_has_its_own_rows(bolted: System) -> None:
    ready = parametric_system(bolted)
    alone = _each_alone(ready)
    assert [single.tones for single in alone] == [bolted.tones]
    for single in alone:
        assert len(single.modal.gaps) == single.system.varying.B.shape[1]
        assert floquet_scan(single, np.array([float(single.tones[0])])).kind[0] == "stable"


def test_steps_hold_the_stiffest_instant(bolted: System, averaged: System) -> None:
    """And no coordinates of the mean at its speed, which the tone would couple."""
    moving = motion_in_time(bolted)
    assert highest_rate(moving) > highest_rate(motion_in_time(averaged))
    assert in_modes_of_its_speed(moving) is moving


def test_derivatives_are_refused(bolted: System) -> None:
    with pytest.raises(ModelError, match="main/ring/support/bolts"):
        force_derivatives(bolted, [], relative_speed=[1.0])


@pytest.mark.parametrize(("key", "value"), [("clearance", "20 mm"), ("exponent", 1.1), ("friction", {"force": "1 N"})])
def test_laws_beside_bolts_that_hold_alone_are_refused(key: str, value: object) -> None:
    """They were left out without a word: the law is that of the link, and bolts are links of their own."""
    more = bolts(6)
    more["stages.main.ring.support"][key] = value
    if key == "exponent":
        more["stages.main.ring.support"]["load"] = "1 kN"
    with pytest.raises(ModelError, match=rf"stages\.main\.ring\.support\.{key}.*bolts alone hold here"):
        load("lin1999-n4", more)


def test_a_body_held_on_itself_is_refused() -> None:
    with pytest.raises(ModelError, match=r"bodies\.arm\.support\.to.*holds a body on itself"):
        load("lin1999-n4", {"bodies.arm": {"mass": "8 kg", "inertia": "0.3 kg m^2", "support": {"to": "arm"}}})


def test_at_a_slow_speed_the_mesh_frequency_is_judged_alone(bolted: System) -> None:
    """A turn of the carrier has too many steps there: a cycle of the mesh has not."""
    ready = parametric_system(bolted)
    slow = 2 * float(ready.cycles) * float(np.sqrt(ready.modal.squared.max())) / (20_000 * math.tau)
    scan = floquet_scan(ready, np.array([slow]))
    assert scan.alone[0]
    assert scan.kind[0] == "stable"
    constant = replace(bolted, meshes=replace(bolted.meshes, variation=0 * bolted.meshes.variation))
    scan = floquet_scan(parametric_system(constant), np.array([1e-2 * slow]))
    assert "too many steps" in scan.status[0]


def test_the_warning_says_what_many_orders_cost() -> None:
    """An arm passes by ten orders of a ring of five, six bolts by one."""
    (text,) = (text for text in train_of(modes=ORDERS, more=HELD_BY_ARM).warnings if "[bolts-averaged]" in text)
    assert "fewer modes of the ring" in text
    assert not any("fewer modes" in text for text in load(STAGE).warnings)


def test_lines_of_the_tone_have_the_name_of_what_passes() -> None:
    system = ring_alone()
    assert system.passing is not None
    assert line_label(system, system.passing.tones[0]) == "1 x main/ring/support/bolts passing"
    uneven = ring_alone({"angles": "[0, 50, 130, 145, 290] deg"})
    assert line_label(uneven, Fraction(2 * FRAME)) == "2 x main/ring/support/bolts passing"
    assert line_label(system, system.tones[0] - system.passing.tones[0]) == (
        "1 x main mesh - (1 x main/ring/support/bolts passing)"
    )
