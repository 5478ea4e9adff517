"""The verbs steady and sweep, with and without contact loss."""

from dataclasses import replace
from typing import TYPE_CHECKING

from ...verbs.options import mesh_frequencies
from ...verbs.record import RESPONSE, Verb, check_range, nondefault, recorded_options, refuse_without, takes
from . import SteadyOptions, SweepOptions

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    from ...engine.source import Drive


@takes(SteadyOptions, turning=True)
def steady(drive: "Drive", options: SteadyOptions) -> "xr.Dataset":
    """Steady vibration at one speed.

    Raises
    ------
    ModelError : the model or an option is wrong; no damping, no speed.  ConvergenceError : no steady motion found.
    """
    refuse_without(options.contact_loss, "contact loss", **nondefault(options, "shaft_orders", "shaft_tones"))
    refuse_without(not options.contact_loss, "linear contact", **nondefault(options, "samples", "method"))
    if options.contact_loss:
        from ..contact_loss.steady import contact_steady

        return contact_steady(drive.system, options)
    from .steady import steady as run

    return run(drive.system, options)


@takes(SweepOptions, turning=True)
def sweep(drive: "Drive", options: SweepOptions, progress: "Callable[[int, int], None] | None" = None) -> "xr.Dataset":
    """Steady vibration over speed: mesh and bearing forces, K_v, spectra, accelerations.

    A speed in rpm is that of the first member whose speed the model gives; % is of the operating speed. Without ends
    the range is 5 to 130 % of the operating speed, with the speeds at which mesh orders meet the modes; with --range
    modes a fifth of the lowest to 1.2 times the highest of the natural frequencies and the mesh frequency.

    Parameters
    ----------
    folder : keeps the points that are done, so that a run that was stopped goes on with `resume`, to the same bits;
        inside a branch with contact loss to the tolerance of a step.
    progress : called with (points done, points); an exception in it ends the sweep.

    Raises
    ------
    ModelError : the model or an option is wrong; no speed, torque or damping.
    """
    of_contact_loss = nondefault(options, "unstable", "harmonics", "shaft_tones")
    refuse_without(options.contact_loss, "contact loss", **of_contact_loss)
    refuse_without(not options.contact_loss, "linear contact", **nondefault(options, "orders", "tolerance"))
    from ...engine.run_folder import run_folder

    check_range(options)
    if options.start is not None or options.stop is not None:
        speeds = mesh_frequencies(
            drive, options.start, options.stop, options.points or 200, options.range or "operation"
        )
        options = replace(options, mesh_frequency=speeds, start=None, stop=None, range=None, points=None)
    verb = "sweep with contact loss" if options.contact_loss else "sweep"
    folder, recorded = options.folder, recorded_options(options)
    with run_folder(folder, drive.system, verb=verb, options=recorded, resume=options.resume) as (system, kept):
        if options.contact_loss:
            from ..contact_loss.sweep import contact_sweep

            return contact_sweep(system, options, progress=progress, kept=kept)
        from .steady import sweep as linear

        return linear(system, options, progress=progress, kept=kept)


VERBS = (
    Verb(
        run=steady,
        gives=("steady",),
        question="How does it vibrate?",
        line="Steady vibration at one speed: mesh and bearing forces, K_v.",
        needs=RESPONSE,
        examples=({}, {"contact_loss": True}),
    ),
    Verb(
        run=sweep,
        gives=("sweep", "contact_sweep"),
        question="How does it vibrate?",
        line="Steady vibration over speed; --contact-loss lets teeth part.",
        needs=RESPONSE,
        examples=({"points": 3, "stop": 40.0}, {"points": 3, "stop": 40.0, "contact_loss": True}),
        in_report=70,
    ),
)
