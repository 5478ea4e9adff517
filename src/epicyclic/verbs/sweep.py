"""The verb sweep."""

import warnings
from typing import TYPE_CHECKING, Annotated, Literal

from .options import FrameSpeed, MeshFrequencies, RelativeSpeeds, ShaftOrders, ShaftTones, Start, Stop
from .record import Option, Verb, bounded, former, given, refuse_without
from .speeds import mesh_frequencies, train_and_system

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    from ..studies.source import Overrides, Source

__all__ = ["VERB", "sweep"]


@former(slow_tones="shaft_tones")
@bounded
def sweep(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    start: Start = None,
    stop: Stop = None,
    points: Annotated[int | None, Option("Number of speeds.", least=1, most=100_000, default="200")] = None,
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
    compiled: Annotated[
        bool | None, Option("Solve by numba, of linear contact.", default="by the size of the job")
    ] = None,
    contact_loss: Annotated[bool, Option("Teeth part and touch again: run-up, coast-down, all branches.")] = False,
    unstable: Annotated[
        Literal["replace", "report", "ignore", "tell"] | None,
        Option(
            "With --contact-loss: replace motions that are not stable, or report them; tell is the old word.",
            default="replace",
        ),
    ] = None,
    harmonics: Annotated[
        int | None, Option("With --contact-loss: harmonics where teeth part.", least=1, default="as each point needs")
    ] = None,
    shaft_tones: ShaftTones = None,
    progress: "Callable[[int, int], None] | None" = None,
) -> "xr.Dataset":
    """Steady vibration over speed: mesh and bearing forces, K_v, spectra, accelerations.

    A speed in rpm is that of the first member whose speed the model gives; % is of the operating speed. Without ends
    the range is from a fifth of the lowest to 1.2 times the highest of the natural frequencies and the mesh frequency.

    Parameters
    ----------
    progress : called with (points done, points); an exception in it ends the sweep.

    Raises
    ------
    ModelError : the model or an option is wrong; no speed, torque or damping.
    """
    refuse_without(contact_loss, "contact loss", unstable=unstable, harmonics=harmonics, shaft_tones=shaft_tones)
    refuse_without(not contact_loss, "linear contact", orders=orders, tolerance=tolerance, compiled=compiled)
    if unstable == "tell":
        warnings.warn("sweep: unstable='tell' is now 'report'", DeprecationWarning, stacklevel=4)
        unstable = "report"
    train, system = train_and_system(source, overrides)
    if start is not None or stop is not None or points is not None:
        mesh_frequency = mesh_frequencies(system, train, start, stop, points or 200)
    if contact_loss:
        from ..analyses.contact_loss.sweep import contact_sweep

        return contact_sweep(
            system,
            mesh_frequency=mesh_frequency,
            relative_speed=relative_speed,
            frame_speed=frame_speed,
            shaft_orders=shaft_orders,
            progress=progress,
            **given(unstable=unstable, harmonics=harmonics, shaft_tones=shaft_tones),
        )
    from ..analyses.steady.sweep import sweep as run

    return run(
        system,
        mesh_frequency=mesh_frequency,
        relative_speed=relative_speed,
        frame_speed=frame_speed,
        shaft_orders=shaft_orders,
        progress=progress,
        **given(orders=orders, tolerance=tolerance, compiled=compiled),
    )


VERB = Verb(
    run=sweep,
    gives=("sweep", "contact_sweep"),
    examples=({"points": 3, "stop": 40.0}, {"points": 3, "stop": 40.0, "contact_loss": True}),
    in_report=70,
)
