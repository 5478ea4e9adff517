"""The verbs steady and sweep, with and without contact loss."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from ...verbs.options import (
    Folder,
    FrameSpeed,
    MeshFrequencies,
    Range,
    RelativeSpeed,
    RelativeSpeeds,
    Resume,
    ShaftOrders,
    ShaftTones,
    Start,
    Stop,
    mesh_frequencies,
    relative,
    train_and_system,
)
from ...verbs.record import Option, Verb, bounded, given, refuse_without

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    from ...engine.source import Overrides, Source


@bounded
def steady(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    relative_speed: RelativeSpeed = 1.0,
    samples: Annotated[
        int | None, Option("Phases of a mesh cycle in the result of linear contact.", least=1, default="64")
    ] = None,
    method: Annotated[
        Literal["exact", "superposition"] | None,
        Option("Of linear contact: coupled, or every frequency alone on the mean system.", default="exact"),
    ] = None,
    contact_loss: Annotated[bool, Option("Teeth only push; they part and touch again.")] = False,
    shaft_orders: Annotated[
        bool | None, Option("With --contact-loss: count run-outs and other shaft orders.", default="yes")
    ] = None,
    shaft_tones: ShaftTones = None,
) -> "xr.Dataset":
    """Steady vibration at one speed.

    Raises
    ------
    ModelError : the model or an option is wrong; no damping, no speed.  ConvergenceError : no steady motion found.
    """
    refuse_without(contact_loss, "contact loss", shaft_orders=shaft_orders, shaft_tones=shaft_tones)
    refuse_without(not contact_loss, "linear contact", samples=samples, method=method)
    train, system = train_and_system(source, overrides)
    speed = relative(relative_speed, system, train)
    if contact_loss:
        from ..contact_loss.steady import contact_steady

        options = given(shaft_orders=shaft_orders, shaft_tones=shaft_tones)
        return contact_steady(system, relative_speed=speed, **options)
    from .steady import steady as run

    return run(system, relative_speed=speed, **given(samples=samples, method=method))


@bounded
def sweep(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    start: Start = None,
    stop: Stop = None,
    points: Annotated[int | None, Option("Number of speeds.", least=1, most=100_000, default="200")] = None,
    range: Range = None,
    mesh_frequency: MeshFrequencies = None,
    relative_speed: RelativeSpeeds = None,
    frame_speed: FrameSpeed = "kinematic",
    shaft_orders: ShaftOrders = True,
    orders: Annotated[
        int | None,
        Option("Mesh orders whose amplitudes are reported, of linear contact.", least=1, most=100, default="12"),
    ] = None,
    tolerance: Annotated[
        float | None,
        Option("Relative residual of the harmonics kept, of linear contact.", least=1e-14, most=0.1, default="1e-6"),
    ] = None,
    contact_loss: Annotated[bool, Option("Teeth part and touch again: run-up, coast-down, all branches.")] = False,
    unstable: Annotated[
        Literal["replace", "report", "ignore"] | None,
        Option(
            "With --contact-loss: replace motions that are not stable, or report them.",
            default="replace",
        ),
    ] = None,
    harmonics: Annotated[
        int | None, Option("With --contact-loss: harmonics where teeth part.", least=1, default="as each point needs")
    ] = None,
    shaft_tones: ShaftTones = None,
    folder: Folder = None,
    resume: Resume = False,
    progress: "Callable[[int, int], None] | None" = None,
) -> "xr.Dataset":
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
    refuse_without(contact_loss, "contact loss", unstable=unstable, harmonics=harmonics, shaft_tones=shaft_tones)
    refuse_without(not contact_loss, "linear contact", orders=orders, tolerance=tolerance)
    from ...engine.run_folder import run_folder

    train, system = train_and_system(source, overrides)
    if start is not None or stop is not None:
        refuse_without(start is None or stop is None, "at most one end of its own", range=range)
        mesh_frequency = mesh_frequencies(system, train, start, stop, points or 200, range or "operation")
        range = points = None
    options: dict[str, Any] = {
        "mesh_frequency": mesh_frequency,
        "relative_speed": relative_speed,
        "speed_range": range,
        "points": points,
        "frame_speed": frame_speed,
        "shaft_orders": shaft_orders,
        **given(orders=orders, tolerance=tolerance),
        **given(unstable=unstable, harmonics=harmonics, shaft_tones=shaft_tones),
    }
    verb = "sweep with contact loss" if contact_loss else "sweep"
    with run_folder(folder, system, verb=verb, options=options, resume=resume) as (system, kept):
        if contact_loss:
            from ..contact_loss.sweep import ContactSweepOptions, contact_sweep

            return contact_sweep(system, ContactSweepOptions(**options), progress=progress, kept=kept)
        from .steady import SweepOptions
        from .steady import sweep as linear

        return linear(system, SweepOptions(**options), progress=progress, kept=kept)


VERBS = (
    Verb(run=steady, gives=("steady",), examples=({}, {"contact_loss": True})),
    Verb(
        run=sweep,
        gives=("sweep", "contact_sweep"),
        examples=({"points": 3, "stop": 40.0}, {"points": 3, "stop": 40.0, "contact_loss": True}),
        in_report=70,
    ),
)
