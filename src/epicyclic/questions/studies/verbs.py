"""The verbs sensitivity and track, and study, a verb over many points, whose source is a job file."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from ...user_input import checked
from ...verbs.options import MOST_SPEED, frequency, relative
from ...verbs.record import Option, Progress, Verb, bounded, keywords, verbs

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Overrides, Source


@bounded
def sensitivity(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    of: Annotated[
        Literal["frequency", "force"], Option("Natural frequencies, or the RMS of the dynamic mesh forces.")
    ] = "frequency",
    mode: Annotated[int | None, Option("Rank by this mode, from 1.", default="lowest elastic")] = None,
    mesh: Annotated[str | None, Option("Rank by this mesh, e.g. main/sun-planet/1.", default="largest force")] = None,
    paths: Annotated[
        Sequence[str] | None,
        Option(
            "A number of the model, PATH[2] for an entry of a list; may be repeated.",
            default="all that move something",
        ),
    ] = None,
    mesh_frequency: Annotated[
        float | str | None,
        Option('Mesh frequency for forces [Hz], e.g. "0.6 kHz".', default="operating speed"),
    ] = None,
    harmonic: Annotated[
        int | None, Option("Amplitude of this mesh order in place of the RMS.", least=1, most=1_000_000, default="RMS")
    ] = None,
    relative_speed: Annotated[
        float | str | None,
        Option(
            'Speed per operating speed, or e.g. "20 Hz", "50 rpm", "50 %"; gyroscopic terms for frequencies.',
            least=0,
            most=MOST_SPEED,
            default="standstill; of forces 1",
        ),
    ] = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Which number of the model moves a natural frequency or a mesh force most: percent per percent, ranked.

    Raises
    ------
    ModelError : the model is wrong; a path that is no number; options that do not go together; no damping or speed.
    """
    from ...engine.source import system_of, train_of
    from .sensitivity import sensitivity as run

    train = train_of(source, overrides=overrides)
    if isinstance(relative_speed, str):
        relative_speed = relative(relative_speed, system_of(train), train)
    return run(
        train,
        of=of,
        mode=mode,
        mesh=mesh,
        paths=paths,
        mesh_frequency=None if mesh_frequency is None else frequency(mesh_frequency, "mesh_frequency"),
        relative_speed=relative_speed,
        harmonic=harmonic,
        progress=progress,
    )


@bounded
def track(
    source: "Source",
    *,
    over: Annotated[str, Option("The number that is moved, PATH[2] for an entry of a list.", metavar="PATH")],
    overrides: "Overrides | None" = None,
    start: Annotated[
        float | str | None,
        Option('First value, as the file says it: "1e8 N/m".', default="half of it"),
    ] = None,
    stop: Annotated[float | str | None, Option("Last value.", default="twice")] = None,
    points: Annotated[int, Option("Values to begin with; more where modes meet.", least=3, most=10_000)] = 41,
    modes: Annotated[int | None, Option("How many modes, from the lowest.", least=1, default="all")] = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Natural frequencies along a number of the model, each mode followed; where they cross and where they veer.

    Raises
    ------
    ModelError : the model is wrong; a path that is no number, an empty range, a value the model cannot have.
    """
    from ...engine.source import train_of
    from .parameter_studies import track as run

    return run(
        train_of(source, overrides=overrides),
        over=over,
        start=start,
        stop=stop,
        points=points,
        modes=modes,
        progress=progress,
    )


# what a study gives each point itself, and what none has
_OWN = ("folder", "resume", "store", "workers", "scheduler", "worst")


@checked
def study(
    job: "str | Path | Mapping[str, Any]",
    *,
    store: "str | Path | None" = None,
    resume: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> "xr.Dataset":
    """A verb over a grid, a list or a sample of values in the model file and of options, as one labelled Dataset.

    Parameters
    ----------
    job : a TOML file with verb, model, options and what varies, or its tables.
    store : folder of a Zarr store that keeps every point that is done.  resume : go on with what lies there.
    workers : local processes.  scheduler : address of a Dask scheduler instead, tcp://HOST:8786.
    progress : called with the share done.

    Returns
    -------
    Dataset : variables of the verb, a dimension for each path of the grid, and `point`; the paths as coordinates;
        `status` and `reason` of each point.

    Raises
    ------
    ModelError : the job is wrong, with the path in it; a store or scheduler that will not do; every point fails.
    """
    from ...engine.study import run_study

    known = {name: [key for key in keywords(verb.run) if key not in _OWN] for name, verb in verbs().items()}
    return run_study(
        job,
        lambda name: partial(_evaluate, name),
        known,
        store=store,
        resume=resume,
        workers=workers,
        scheduler=scheduler,
        progress=progress,
    )


def _evaluate(
    name: str, model: Mapping[str, Any], overrides: Mapping[str, Any], options: Mapping[str, Any]
) -> "xr.Dataset":
    """Result of a verb at one point."""
    return verbs()[name].run(model, overrides=dict(overrides), **options)


VERBS = (
    Verb(
        run=sensitivity,
        gives=("sensitivity",),
        examples=({"paths": ("stages.main.sun.mass",)}, {"of": "force", "paths": ("stages.main.sun.mass",)}),
        drawing=True,
    ),
    Verb(
        run=track, gives=("track",), examples=({"over": "stages.main.sun.support.radial", "points": 5},), drawing=True
    ),
)
