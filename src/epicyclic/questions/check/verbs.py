"""The verbs check and matrices."""

from typing import TYPE_CHECKING

from ...results.files import MATRIX_FILES, save_matrices
from ...verbs.record import Verb, takes, verbs
from ..rating import EXAMPLE
from . import MatricesOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive


@takes()
def check(drive: "Drive") -> "xr.Dataset":
    """Speeds, torques, geometry, phases; every derived value and where it came from.

    Raises
    ------
    ModelError : the model is wrong, or a System is given, which has no drawing left.
    """
    from .check import check as run

    return run(drive.train, {name: verb.needs.split() for name, verb in verbs().items() if name != "check"})


@takes(MatricesOptions)
def matrices(drive: "Drive", options: MatricesOptions) -> "xr.Dataset":
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

    return mean_matrices(drive.system, relative_speed=options.relative_speed)


VERBS = (
    Verb(
        run=check,
        gives=("check",),
        question="What does the drawing say?",
        line="Ratio, speeds, torques, mesh frequencies, assembly; all values by --all.",
        drawing=True,
        in_report=10,
        examples=({}, EXAMPLE),
    ),
    Verb(
        run=matrices,
        gives=("matrices",),
        question="How do I take it away?",
        line="The linear system M, C, G, K as .mat or .npz.",
        needs="equations inertia",
        writers=dict.fromkeys(MATRIX_FILES, save_matrices),
    ),
)
