"""Systems that benchmarks and tests share: a double-helical set, two of them coupled, and what opens their flanks."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from epicyclic.system.assembly import assemble
from epicyclic.system.system import Dofs, FarFlanks, Line, LinkRows, MeshRows, System
from epicyclic.train.resolution import load

Array = NDArray[np.float64]
TONE = 1000
TILTS = {
    "stages.main.sun.support.tilt": 5e7,
    "stages.main.planet.bearing.tilt": 2e7,
    "stages.main.ring.support.tilt": 1e9,
    "stages.main.carrier.support.tilt": 1e8,
    "stages.main.sun.neck.tilt": 2e8,
    "stages.main.ring.neck.tilt": 2e8,
    "stages.main.carrier.neck.tilt": 2e8,
    "stages.main.carrier.tilt_inertia": "90 kg m^2",
}


RATIO = Fraction(71, 220)
# first mesh frequency [Hz]: RMS of the dynamic mesh force of four meshes of `bench112` [N]
MESHES112 = [0, 1, 16, 17]
KNOWN112 = {
    930: (647.204, 727.369, 379.794, 444.818),
    1646: (4030.180, 6760.743, 390.972, 449.015),
    3500: (567.812, 632.552, 313.842, 446.775),
}


def bench56() -> System:
    """M q'' + (C + w_c G) q' + (K - w_c^2 Kw + sum k_m(t) n n') q = F + sum n k_m e_m with w_c = w_mesh / 89.

    Raises
    ------
    FileNotFoundError : the file is not there; the message names where it was looked for.
    """
    data, frame = _arrays("bench56.npz"), 2 * np.pi * TONE / 89
    return _system(data, G=frame * data["G"], Kg=-(frame**2) * data["Kw"], tone=np.zeros(data["N"].shape[1], np.int64))


def bench112() -> System:
    """Two such sets, the sun of one welded to the carrier of the other: mesh frequencies f and 71/220 f.

    The known forces were found with modal damping, ratio `zeta`; the array C of the file is another one.

    Raises
    ------
    FileNotFoundError : as of `bench56`.
    """
    data = _arrays("bench112.npz")
    first, second = 2 * np.pi * TONE / 89, 2 * np.pi * float(RATIO * TONE) / 89
    return _system(
        data,
        G=first * data["GA"] + second * data["GB"],
        Kg=-(first**2) * data["KwA"] - second**2 * data["KwB"],
        tone=data["tone"],
        zeta=float(data["zeta"]),
    )


def with_backlash(system: System, *, backlash: float = 100e-6, load: float = 1.0) -> System:
    """The system with backlash [m], far flanks opposite to the loaded ones (exact in pure torsion), its force scaled.

    The force of `bench56` is 2000 N m, 20 kN on each half of the sun.
    """
    meshes = system.meshes
    return replace(
        system,
        force=load * system.force,
        meshes=replace(meshes, backlash=np.full(len(meshes.name), backlash)),
        lines=tuple(replace(line, far_gap=-line.gap) for line in system.lines),
        far=FarFlanks(mesh=np.arange(len(meshes.name)), B=-meshes.B, variation=meshes.variation),
    )


def sliced_xu2020(slices: int, **more: Any) -> System:
    """The ready herringbone set with all six directions of every half, 84 degrees of freedom, cut along the face."""
    cut = {"stages.main.meshes": {pair: {"slices": slices} for pair in ("sun-planet", "planet-ring")}}
    return assemble(load("xu2020", overrides={**cut, **TILTS, **more}))


def _arrays(name: str) -> Mapping[str, Any]:
    folder = os.environ.get("EPICYCLIC_DATA") or Path(__file__).parents[2] / "shared" / "data"
    path = Path(folder) / name
    if not path.is_file():
        raise FileNotFoundError(f"{path} is absent; set EPICYCLIC_DATA to its folder")
    loaded: Mapping[str, Any] = np.load(path)
    return loaded


def _system(
    data: Mapping[str, Any], *, G: Array, Kg: Array, tone: NDArray[np.int64], zeta: float | None = None
) -> System:
    n, m = data["N"].shape
    k, e = data["k_harmonics"], data["e_harmonics"]
    tones = (Fraction(TONE), RATIO * TONE)[: 1 + int(tone.max())]
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
        C=data["C"] if zeta is None else np.zeros((n, n)),
        G=G,
        K=data["K"],
        Kg=Kg,
        Cskew=np.zeros((n, n)),
        meshes=MeshRows(
            name=tuple(f"mesh/{i}" for i in range(m)),
            pair=("mesh",) * m,
            stage=tuple(f"stage{t}" for t in tone),
            branch=(0,) * m,
            side=("",) * m,
            B=data["N"],
            stiffness=k[:, 0].real,
            variation=k[:, 1:] / k[:, :1].real,
            tone=tone,
            damping=np.zeros(m),
            backlash=np.full(m, np.inf),
            cos_base_helix=np.ones(m),
        ),
        links=LinkRows(name=(), link=(), B=np.zeros((n, 0)), stiffness=np.zeros(0), damping=np.zeros(0)),
        force=data["F"],
        tones=tones,
        lines=tuple(
            Line(
                frequency=f * h,
                gap=np.where(tone == j, e[:, h], 0.0),
                link_gap=np.zeros(0, complex),
                force=np.zeros((3, n), complex),
            )
            for j, f in enumerate(tones)
            for h in range(1, e.shape[1])
            if e[tone == j, h].any()
        ),
        zeta=zeta,
    )
