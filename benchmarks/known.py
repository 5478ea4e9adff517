"""A 56-degree-of-freedom double-helical planetary set, from its arrays."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path

import numpy as np

from epicyclic.system.system import Dofs, Line, LinkRows, MeshRows, System

TONE = 1000


def bench56() -> System:
    """M q'' + (C + w_c G) q' + (K - w_c^2 Kw + sum k_m(t) n n') q = F + sum n k_m e_m with w_c = w_mesh / 89.

    Raises
    ------
    FileNotFoundError : the file is not there; the message names where it was looked for.
    """
    folder = os.environ.get("EPICYCLIC_DATA") or Path(__file__).parents[2] / "shared" / "data"
    path = Path(folder) / "bench56.npz"
    if not path.is_file():
        raise FileNotFoundError(f"{path} is absent; set EPICYCLIC_DATA to its folder")
    data = np.load(path)
    n, m = data["N"].shape
    k, e, frame = data["k_harmonics"], data["e_harmonics"], 2 * np.pi * TONE / 89
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
            Line(
                frequency=Fraction(TONE * h),
                gap=e[:, h],
                link_gap=np.zeros(0, complex),
                force=np.zeros((3, n), complex),
            )
            for h in range(1, e.shape[1])
            if e[:, h].any()
        ),
    )
