"""The verbs tolerance and allocate."""

from typing import TYPE_CHECKING

from ...options import Progress
from ...verbs.record import Verb, model_in, takes
from . import AllocateOptions, ToleranceOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive


@takes(ToleranceOptions)
def tolerance(drive: "Drive", options: ToleranceOptions, progress: Progress | None = None) -> "xr.Dataset":
    """The mesh-load factor K_gamma as a distribution, from the tolerances of the drawing.

    The model states them in its table [tolerance]. Quantiles come with 95 % bands. With --store, Ctrl-C keeps what is
    done, and --resume goes on to the same bits, whatever the workers.

    Raises
    ------
    ModelError : the model or an option is wrong; no tolerance; a store of another job; no scheduler.
    """
    from .tolerance import tolerance as run

    return run(drive.train, options, progress=progress)


@takes(AllocateOptions, joint=True)
def allocate(drive: "Drive", options: AllocateOptions, progress: Progress | None = None) -> "xr.Dataset":
    """The cheapest grades of the drawing that keep K_gamma below a target in a share of the trains.

    The model has prices of grades in [tolerance.cost]. With -o MODEL.toml the model is written with the grades found.
    With --case all it is one drawing for all load cases: time above the target counts by their durations.

    Raises
    ------
    ModelError : the model or an option is wrong; no prices; a target that no grades reach.
    """
    from ...verbs.cases import duty_of
    from .allocation import allocate as run

    return run(duty_of(drive) or drive.train, options, progress=progress)


VERBS = (
    Verb(
        run=tolerance,
        gives=("tolerance",),
        question="How do planets share the load?",
        line="K_gamma as a distribution, from the tolerances of the drawing.",
        needs="equations torque balance tolerances",
        examples=({"samples": 256, "effects": "all", "raw": True, "reference": ("table=1.25",)},),
        drawing=True,
        in_report=65,
    ),
    Verb(
        run=allocate,
        gives=("allocate",),
        question="Which number do I change?",
        line="The cheapest grades that keep K_gamma below a target.",
        needs="equations torque balance tolerances prices",
        examples=({"target": 1.5, "samples": 1024, "fresh_samples": 1024},),
        drawing=True,
        model_text=model_in("allocated_model"),
    ),
)
