"""The verb stability."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

from ...document.units import typed
from ...errors import ModelError
from ...verbs.options import (
    Folder,
    FrameSpeed,
    MeshFrequencies,
    RelativeSpeeds,
    Resume,
    Start,
    Stop,
    mesh_frequencies,
    spread,
    train_and_system,
)
from ...verbs.record import Option, Verb, bounded, given, refuse_without

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    from ...engine.source import Overrides, Source


@bounded
def stability(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    start: Start = None,
    stop: Stop = None,
    points: Annotated[
        int | None, Option("Number of speeds.", least=1, most=100_000, default="200, of a map 100")
    ] = None,
    range: Annotated[
        Literal["operation", "modes"] | None,
        Option("Speeds about operation, 5 to 130 %, or to 1.2 times the modes.", default="modes"),
    ] = None,
    mesh_frequency: MeshFrequencies = None,
    relative_speed: RelativeSpeeds = None,
    frame_speed: FrameSpeed = "kinematic",
    variation: Annotated[
        float | None, Option("Factor of the stiffness variation of all meshes.", least=0, most=1000, default="1")
    ] = None,
    damping: Annotated[float | None, Option("Factor of all damping.", least=0, most=1000, default="1")] = None,
    over: Annotated[
        str | None,
        Option(
            "Second parameter of a map: a path of the model file, or variation or damping, a factor.",
            metavar="PATH",
        ),
    ] = None,
    values: Annotated[Sequence[Any] | str | None, Option('Its values: "0..2", "1 %..5 %" or "1, 2, 5".')] = None,
    value_points: Annotated[int, Option("Number of values in a range.", least=1, most=10_000)] = 21,
    folder: Folder = None,
    resume: Resume = False,
    progress: "Callable[[int, int], None] | None" = None,
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
    if (over is None) != (values is None):
        raise ModelError("go together", path="over, values", allowed="a path and its values, damping.modal 0.01..0.05")
    from ...engine.run_folder import run_folder

    train, system = train_and_system(source, overrides)
    refuse_without(start is None or stop is None, "at most one end of its own", range=range)
    ranged = any(one is not None for one in (start, stop, points, range))
    chosen = range or "modes"
    options: dict[str, Any] = {"frame_speed": frame_speed}
    if over is None or values is None:
        from .stability import stability as run

        speeds = mesh_frequencies(system, train, start, stop, points or 200, chosen) if ranged else mesh_frequency
        options |= {
            "mesh_frequency": speeds,
            "relative_speed": relative_speed,
            **given(variation=variation, damping=damping),
        }
        with run_folder(folder, system, verb="stability", options=options, resume=resume) as (system, kept):
            return run(system, **options, progress=progress, kept=kept)
    import numpy as np

    from ..studies.parameter_studies import stability_map

    refuse_without(
        False, "speed as the only parameter", variation=variation, damping=damping, relative_speed=relative_speed
    )
    if mesh_frequency is None:
        mesh_frequency = mesh_frequencies(system, train, start, stop, points or 100, chosen)
    options |= {
        "path": over.strip(),
        "values": [typed(value) for value in spread(values, value_points)] if isinstance(values, str) else values,
        "mesh_frequency": np.atleast_1d(np.asarray(mesh_frequency, dtype=float)).tolist(),
    }
    with run_folder(folder, system, verb="stability map", options=options, resume=resume) as (_, kept):
        return stability_map(source, **options, overrides=overrides, progress=progress, kept=kept)


VERBS = (
    Verb(
        run=stability,
        gives=("stability",),
        examples=({"points": 3}, {"points": 2, "over": "damping", "values": (1.0, 2.0)}),
    ),
)
