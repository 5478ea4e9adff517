"""A 56-degree-of-freedom double-helical planetary set with known dynamic mesh forces."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from epicyclic.analyses.harmonic.steady import periodic
from epicyclic.analyses.harmonic.sweep import sweep
from epicyclic.analyses.modes.basis import mean_modes
from epicyclic.system.system import Dofs, Line, LinkRows, MeshRows, System

DATA = Path(os.environ.get("EPICYCLIC_DATA", Path(__file__).parents[5] / "shared" / "data")) / "bench56.npz"
pytestmark = pytest.mark.skipif(not DATA.is_file(), reason=f"{DATA} is absent (set EPICYCLIC_DATA)")

# mesh frequency [Hz]: RMS of the dynamic mesh force of meshes 0 and 1 [N]
REFERENCE = {600: (316.448, 382.234), 1646: (4019.837, 6745.458), 3500: (511.594, 643.363)}
TONE = 1000


@pytest.fixture(scope="module")
def bench() -> System:
    data = np.load(DATA)
    n, m = data["N"].shape
    frame = 2 * np.pi * TONE / 89
    k, e = data["k_harmonics"], data["e_harmonics"]
    none = np.zeros((3, n), complex)
    return System(
        dofs=Dofs(
            names=tuple(f"body/{i}" for i in range(n)),
            body=("body",) * n,
            direction=("x",) * n,
            radius=np.ones(n),
            bodies=("body",),
            expand=np.zeros((6, n)),
        ),
        M=data["M"],
        C=data["C"],
        G=frame * data["G"],
        K=data["K"],
        Kg=-(frame**2) * data["Kw"],
        Cskew=np.zeros((n, n)),
        meshes=MeshRows(
            name=tuple(f"mesh/{i}" for i in range(m)),
            pair=("mesh",) * m,
            stage=("main",) * m,
            branch=(0,) * m,
            side=("",) * m,
            B=data["N"],
            stiffness=k[:, 0].real,
            variation=k[:, 1:] / k[:, :1].real,
            tone=np.zeros(m, np.int64),
            damping=np.zeros(m),
            backlash=np.full(m, np.inf),
            cos_base_helix=np.ones(m),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((n, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=data["F"],
        tones=(Fraction(TONE),),
        lines=tuple(
            Line(frequency=Fraction(TONE * h), gap=e[:, h], link_gap=np.zeros(0, complex), force=none)
            for h in range(1, 9)
            if e[:, h].any()
        ),
    )


def test_its_modes_span_the_known_range(bench: System) -> None:
    frequency = np.sqrt(mean_modes(bench)[0]) / (2 * np.pi)
    assert frequency[0] == pytest.approx(183, abs=0.6)  # printed to 1 Hz
    assert frequency[-1] == pytest.approx(5743, abs=0.6)


@pytest.mark.parametrize("frequency", REFERENCE)
def test_dynamic_mesh_forces(bench: System, frequency: int) -> None:
    found = periodic(bench, relative_speed=frequency / TONE)
    # the reference is printed to 1e-6 and known to 1e-5
    np.testing.assert_allclose(found.force[:2].std(axis=1), REFERENCE[frequency], rtol=1e-5)


def test_a_sweep_at_its_own_tolerance(bench: System) -> None:
    result = sweep(bench, mesh_frequency=list(REFERENCE))
    np.testing.assert_allclose(result.mesh_force_rms[:2].T, list(REFERENCE.values()), rtol=2e-5)
