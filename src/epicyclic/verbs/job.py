"""A described run: what the command line builds, runs and shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from . import verbs

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Job", "run"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One run: a verb on a source.

    verb : name in `verbs.VERBS`.  source : path, name of a ready drive, or dict.
    overrides : path -> value.  options : keyword arguments of the verb.
    """

    verb: str
    source: str | Path | Mapping[str, Any]
    overrides: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)


def run(job: Job, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """Do a described run.

    Parameters
    ----------
    progress : called with the share done, 0..1, by the verbs that take long.

    Raises
    ------
    ModelError : the model or the verb is wrong.  ConvergenceError : the analysis did not converge.
    """
    if job.verb not in verbs.VERBS:
        raise ModelError("no such verb", path="verb", given=job.verb, allowed=", ".join(verbs.VERBS))
    options = dict(job.options)
    if progress is not None and job.verb in _LONG:
        options["progress"] = _LONG[job.verb](progress)
    return verbs.VERBS[job.verb](job.source, overrides=job.overrides or None, **options)


def _share(progress: Callable[[float], None]) -> Callable[[float], None]:
    return progress


def _count(progress: Callable[[float], None]) -> Callable[[int, int], None]:
    return lambda done, of: progress(done / of)


# how the verbs that take long call back: with the share done, or with points done and points
_LONG: Mapping[str, Callable[[Callable[[float], None]], Callable[..., None]]] = {
    "campbell": _share,
    "sensitivity": _share,
    "relief": _share,
    "sharing": _share,
    "static": _share,
    "sweep": _count,
    "track": _share,
    "stability": _count,
    "transient": _share,
}
