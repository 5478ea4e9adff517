"""The verbs check and matrices."""

from typing import TYPE_CHECKING

from ...results.files import MATRIX_FILES, save_matrices
from ...verbs.options import RelativeSpeed, relative, train_and_system
from ...verbs.record import Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Overrides, Source


@bounded
def check(source: "Source", *, overrides: "Overrides | None" = None) -> "xr.Dataset":
    """Speeds, torques, geometry, phases; every derived value and where it came from.

    Raises
    ------
    ModelError : the model is wrong, or a System is given, which has no drawing left.
    """
    from ...engine.source import train_of
    from .check import check as run

    return run(train_of(source, overrides=overrides))


@bounded
def matrices(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    relative_speed: RelativeSpeed = 1.0,
) -> "xr.Dataset":
    """The mean linear system as matrices, for MATLAB, SciPy and others.

    M q'' + (C + G) q' + K q = F u + B (k e + c e') + load, with the mean stiffness k and damping c of the meshes in K
    and C. Also written as .mat and .npz; `save_matrices` in Python.

    Returns
    -------
    Dataset with ``M, C, G, K`` (n, n), ``B`` (n, m), ``L`` (n, p), ``T`` (6 nb, n), ``F`` (n, u), and the names and
    units of their rows and columns; docs/how-to/take-away.md lists all.

    Raises
    ------
    ModelError : the model is wrong; mass or inertia missing.
    """
    from ..modes.modal import mean_matrices

    train, system = train_and_system(source, overrides)
    return mean_matrices(system, relative_speed=relative(relative_speed, system, train))


VERBS = (
    Verb(run=check, gives=("check",), drawing=True, in_report=10),
    Verb(run=matrices, gives=("matrices",), writers=dict.fromkeys(MATRIX_FILES, save_matrices)),
)
