"""Lines at rest of single deviations, one by one: columns of maps that are linear in the deviations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..system.elimination import eliminate
from ..system.system import Line
from ..train.train import Displacement, MeshError, Train
from .excitation import FullModel, separate_lines
from .structure import structure_of

__all__ = ["unit_lines"]


def unit_lines(train: Train, deviations: Sequence[Displacement | MeshError]) -> tuple[Line, ...]:
    """One line for each deviation: gaps and the force at rest (``force[0]``); no part that grows with speed.

    Their arrays have the rows and coordinates of ``assemble(train)``.

    Raises
    ------
    ModelError : as of `assemble`.
    """
    structure = structure_of(train)
    T, S, _ = eliminate(structure.rigid, structure.pivots)
    six = 6 * len(train.bodies)
    still, none = np.zeros((six, six)), np.zeros(len(structure.links))
    model = FullModel(
        T=T,
        S=S,
        mass=np.zeros((len(train.bodies), 6)),
        G=still,
        Kg=still,
        euler=still,
        mass_damping=0.0,
        link_stiffness=np.array([0.0 if row.law else row.stiffness for row in structure.links]),
        link_damping=none,
        skew=still,
    )
    return separate_lines(deviations, structure, model)
