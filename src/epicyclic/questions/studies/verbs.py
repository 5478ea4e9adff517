"""The verbs sensitivity, detune and track, and study, a verb over many points, whose source is a job file."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...options import Progress
from ...user_input import checked
from ...verbs.record import Verb, keywords, takes, verbs
from . import DetuneOptions, SensitivityOptions, TrackOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive


@takes(SensitivityOptions)
def sensitivity(drive: "Drive", options: SensitivityOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Which number of the model moves a natural frequency or a mesh force most: percent per percent, ranked.

    Raises
    ------
    ModelError : the model is wrong; a path that is no number; options that do not go together; no damping or speed.
    """
    from .sensitivity import sensitivity as run

    return run(drive.train, options, progress=progress)


@takes(DetuneOptions, turning=True)
def detune(drive: "Drive", options: DetuneOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Changes of the drawing that move a resonance away from operation, each computed again on the changed train.

    Raises
    ------
    ModelError : the model is wrong, has no speed or no modes; a resonance that is not near; a path that is no size.
    """
    from .detune import detune as run

    return run(drive.train, options, progress=progress)


@takes(TrackOptions)
def track(drive: "Drive", options: TrackOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Natural frequencies along a number of the model, each mode followed; where they cross and where they veer.

    Raises
    ------
    ModelError : the model is wrong; a path that is no number, an empty range, a value the model cannot have.
    """
    from .parameter_studies import track as run

    return run(drive.train, options, progress=progress)


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
    progress: Progress | None = None,
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
    from ...engine.block_store import run_blocks
    from ...engine.points import run_study

    known = {name: [key for key in keywords(verb.run) if key not in _OWN] for name, verb in verbs().items()}
    run = partial(run_blocks, store=store, resume=resume, workers=workers, scheduler=scheduler)
    return run_study(job, lambda name: partial(_evaluate, name), known, run=run, progress=progress)


def _evaluate(
    name: str, model: Mapping[str, Any], overrides: Mapping[str, Any], options: Mapping[str, Any]
) -> "xr.Dataset":
    """Result of a verb at one point."""
    return verbs()[name].run(model, overrides=dict(overrides), **options)


VERBS = (
    Verb(
        run=sensitivity,
        gives=("sensitivity",),
        question="Which number do I change?",
        line="Which number moves frequencies or forces most.",
        needs="equations inertia",
        examples=({"paths": ("stages.main.sun.mass",)}, {"of": "force", "paths": ("stages.main.sun.mass",)}),
        drawing=True,
    ),
    Verb(
        run=detune,
        gives=("detune",),
        question="Which number do I change?",
        line="What moves a resonance away from operation, computed again.",
        needs="equations inertia speed",
        examples=({"changes": 1},),
        drawing=True,
    ),
    Verb(
        run=track,
        gives=("track",),
        question="Which number do I change?",
        line="Modes along a number: crossings and veerings.",
        needs="equations inertia",
        examples=({"over": "stages.main.sun.support.radial", "points": 5},),
        drawing=True,
    ),
)
