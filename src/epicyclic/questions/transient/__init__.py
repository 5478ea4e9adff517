"""Motion in time: run-up, torque steps, histories, from any start, with teeth that part.  Options of its verb."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from ...options import Folder, Option, Resume

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

    from .scenario import History

FIGURES = {"transient": ("transient", "spectrogram", "sensors")}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TransientOptions:
    """Options of a motion in time.

    duration : or cycles, of the first mesh; neither: that of the history, else 100 mesh cycles.
    initial : ``equilibrium``: what neither moves nor accelerates at time 0; ``rest``: nothing displaced; a state (2, n)
        q, q'; or a result of this verb, whose end is the beginning.
    samples : per mesh cycle at the highest speed, at least.
    method : ``rk4``, fixed steps, compiled where numba is installed; ``dop853``, ``radau``: scipy's, tolerance 1e-8.
    """

    duration: Annotated[
        float | None,
        Option('Length of the run [s], or e.g. "0.5 s".', least=0, default="100 mesh cycles", reads="time"),
    ] = None
    cycles: Annotated[float | None, Option("Length in mesh cycles instead.", above=0, default="100")] = None
    start: Annotated[
        float | None,
        Option('Mesh frequency at the beginning [Hz], or e.g. "20 Hz".', default="operating", reads="frequency"),
    ] = None
    stop: Annotated[
        float | None,
        Option(
            "Mesh frequency at the end; a straight ramp between.", default="that at the beginning", reads="frequency"
        ),
    ] = None
    mesh_frequency: Annotated[
        float | tuple[float, float] | None,
        Option("Mesh frequency [Hz], or that at the beginning and at the end.", flag=None),
    ] = None
    torque: Annotated[str | Path | None, Option("Torques over time: CSV, time [s], sun [N m], ...", metavar="FILE")] = (
        None
    )
    history: Annotated["History | None", Option("Torques of members over time, [s] and [N m].", flag=None)] = None
    torque_step: Annotated[
        tuple[float, float] | None,
        Option(
            'Factor of all torques and from when [s], or e.g. "1.5@0.2 s".', metavar="FACTOR@TIME", reads="torque step"
        ),
    ] = None
    torque_ramp: Annotated[
        float | None, Option("Time in which all torques grow from zero [s]: a start-up.", least=0, reads="time")
    ] = None
    initial: Annotated[
        "str | Path | NDArray[np.float64] | xr.Dataset",
        Option(
            "Initial state: equilibrium, rest, or the .nc file of a run, which goes on from its end; in Python also a "
            "result, or q and its rate (2, n) [m, m/s]."
        ),
    ] = "equilibrium"
    samples: Annotated[int, Option("Instants per mesh cycle at the highest speed.", least=1, most=1_000_000)] = 32
    decimate: Annotated[int, Option("Keep every so many of them.", least=1)] = 1
    contact: Annotated[Literal["unilateral", "linear"], Option("Teeth that part, or a linear model.")] = "unilateral"
    method: Annotated[Literal["rk4", "dop853", "radau"], Option("Fixed steps, or scipy's variable ones.")] = "rk4"
    folder: Folder = None
    resume: Resume = False
