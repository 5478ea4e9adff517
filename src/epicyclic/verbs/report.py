"""Every analysis a model allows, in one run: what the report shows."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache, partial
from typing import TYPE_CHECKING

from ..errors import ConvergenceError, ModelError
from ..studies.source import system_of, train_of
from . import verbs

if TYPE_CHECKING:
    import xarray as xr

    from ..studies.source import Overrides, Source
    from ..system.system import System
    from ..train.train import Train

__all__ = ["REPORT_VERBS", "STUDIES", "run_report"]

REPORT_VERBS = ("check", "stiffness", "contact", "modes", "campbell", "sharing", "sweep")
STUDIES = ("support stiffness", "run-out")


def run_report(
    source: Source, *, overrides: Overrides | None = None, progress: Callable[[str], None] | None = None
) -> dict[str, xr.Dataset]:
    """Run all analyses a model allows, each once.

    An analysis that asks for what the model does not say (torque, speed, damping, masses), or does not converge, is
    left out, and the first result's warnings say why.

    Parameters
    ----------
    source, overrides : as of every verb.  progress : called with the name of what starts.

    Returns
    -------
    name -> Dataset, in the order of `REPORT_VERBS` and `STUDIES`.

    Raises
    ------
    ModelError : the model itself is wrong.
    """
    train = train_of(source, overrides=overrides)
    results: dict[str, xr.Dataset] = {}
    left_out: list[str] = []
    for name, step in _steps(train).items():
        if progress is not None:
            progress(name)
        try:
            results[name] = step()
        except (ModelError, ConvergenceError) as error:
            left_out.append(f"no {name}: {error}")
    _warn(results["check"], left_out)
    return results


def _steps(train: Train) -> dict[str, Callable[[], xr.Dataset]]:
    """Everything a report shows, by name; the System is made once, when first asked for."""
    from ..studies.design import run_out_study, support_study

    system = cache(lambda: system_of(train))
    drawn = {name: partial(verbs.VERBS[name], train) for name in ("check", "stiffness", "contact")}
    studies = dict(zip(STUDIES, (partial(support_study, train), partial(run_out_study, train)), strict=True))
    run = {name: partial(_on_system, verbs.VERBS[name], system) for name in REPORT_VERBS if name not in drawn}
    return {**drawn, **run, **studies}


def _on_system(verb: Callable[..., xr.Dataset], system: Callable[[], System]) -> xr.Dataset:
    return verb(system())


def _warn(result: xr.Dataset, texts: list[str]) -> None:
    warnings = json.loads(result.attrs.get("warnings", "[]"))
    result.attrs["warnings"] = json.dumps([*warnings, *texts])
