"""The verb matrices."""

from typing import TYPE_CHECKING

from ..results.files import MATRIX_FILES, save_matrices
from .options import RelativeSpeed
from .record import Verb, bounded
from .speeds import relative, train_and_system

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


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
    from ..questions.modes.modal import mean_matrices

    train, system = train_and_system(source, overrides)
    return mean_matrices(system, relative_speed=relative(relative_speed, system, train))


VERB = Verb(run=matrices, gives=("matrices",), writers=dict.fromkeys(MATRIX_FILES, save_matrices))
