"""The verb stability."""

from typing import TYPE_CHECKING, Any

from ...document.units import typed
from ...errors import ModelError
from ...verbs.options import mesh_frequencies, spread
from ...verbs.record import Verb, check_range, given, nondefault, refuse_without, takes
from . import StabilityOptions

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    from ...engine.source import Drive


@takes(StabilityOptions, turning=True)
def stability(
    drive: "Drive", options: StabilityOptions, progress: "Callable[[int, int], None] | None" = None
) -> "xr.Dataset":
    """Floquet stability over speed: where the varying mesh stiffness makes vibration grow by itself.

    Without ends the range is by the modes, for mesh frequencies excite parametric resonances from 2 f_n down; `--range
    operation` asks for 5 to 130 % of the operating speed, where periods are long and points dear. With a second
    parameter the result is a map over both, with the boundaries that averaging predicts.

    Parameters
    ----------
    folder : keeps the points that are done, so that a run that was stopped goes on with `resume`, to the same bits.
    progress : called with (points done, points).

    Raises
    ------
    ModelError : the model is wrong, or says no speed; one of `over` and `values` without the other.
    """
    over, values, points, folder = options.over, options.values, options.points, options.folder
    if (over is None) != (values is None):
        raise ModelError("go together", path="over, values", allowed="a path and its values, damping.modal 0.01..0.05")
    from ...engine.run_folder import run_folder

    check_range(options)
    alone = given(variation=options.variation, damping=options.damping)
    frequency: Any = options.mesh_frequency

    def speeds(points: int) -> list[float]:
        return mesh_frequencies(drive, options.start, options.stop, points, options.range or "modes")

    resume, recorded = options.resume, dict[str, Any](frame_speed=options.frame_speed)
    if over is None or values is None:
        from .stability import stability as run

        ranged = bool(nondefault(options, "start", "stop", "points", "range"))
        recorded |= {"mesh_frequency": speeds(points or 200) if ranged else frequency, **alone}
        recorded |= {"relative_speed": options.relative_speed}
        with run_folder(folder, drive.system, verb="stability", options=recorded, resume=resume) as (system, kept):
            return run(system, **recorded, progress=progress, kept=kept)
    import numpy as np

    from ..studies.parameter_studies import stability_map

    refuse_without(False, "speed as the only parameter", **alone, relative_speed=options.relative_speed)
    frequency = speeds(points or 100) if frequency is None else frequency
    recorded |= {
        "path": over.strip(),
        "values": (
            [typed(value) for value in spread(values, options.value_points)] if isinstance(values, str) else values
        ),
        "mesh_frequency": np.atleast_1d(np.asarray(frequency, dtype=float)).tolist(),
    }
    with run_folder(folder, drive.system, verb="stability map", options=recorded, resume=resume) as (_, kept):
        return stability_map(drive.source, **recorded, overrides=drive.overrides, progress=progress, kept=kept)


VERBS = (
    Verb(
        run=stability,
        gives=("stability",),
        question="How does it vibrate?",
        line="Parametric stability over speed, or a map over two numbers.",
        needs="equations inertia speed",
        examples=({"points": 3}, {"points": 2, "over": "damping", "values": (1.0, 2.0)}),
    ),
)
