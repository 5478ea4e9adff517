"""The verb output."""

from typing import TYPE_CHECKING

from ...options import Progress
from ...verbs.record import Verb, takes
from . import OutputOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive


@takes(OutputOptions)
def output(drive: "Drive", options: OutputOptions, progress: Progress | None = None) -> "xr.Dataset":
    """The gearbox at its output, the other shafts locked: stiffness, hysteresis, lost motion, reflected inertia.

    Friction of the teeth is not in the hysteresis; play, clearances and friction of splines are.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : the model or an option is wrong; no one output; a train that is not locked; no rated torque.
    ConvergenceError : no equilibrium.
    """
    from .output import output as run

    return run(drive.train, options, progress=progress)


VERBS = (
    Verb(
        run=output,
        gives=("output",),
        question="How do planets share the load?",
        line="Stiffness, hysteresis and lost motion at the output, the input locked.",
        needs="torque",
        drawing=True,
        examples=({"points": 8, "phases": 2},),
        in_report=66,
    ),
)
