"""Every analysis a model allows, in one run: what the report shows."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache, partial
from typing import TYPE_CHECKING

from ..errors import ConvergenceError, ModelError
from .record import Verb, verbs

if TYPE_CHECKING:
    import xarray as xr

    from ..studies.source import Overrides, Source
    from ..system.system import System
    from ..train.train import Train

__all__ = ["STUDIES", "TO_MODES", "report_verbs", "run_report"]

STUDIES = ("support stiffness", "run-out")
TO_MODES = "sweep to the modes"
# Speeds of the sweeps of a report, about operation and to the modes: with three mesh frequencies one about operation
# takes half a second, one to the modes half of that.
_POINTS, _POINTS_OF_MANY_TONES = (200, 200), (40, 40)


def report_verbs() -> tuple[str, ...]:
    """Names of the verbs of a report, in the order in which they run."""
    shown = [verb for verb in verbs().values() if verb.in_report]
    return tuple(verb.name for verb in sorted(shown, key=lambda verb: verb.in_report))


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
    name -> Dataset, in the order of `report_verbs`, `TO_MODES` and `STUDIES`.

    Raises
    ------
    ModelError : the model itself is wrong.
    """
    from ..studies.source import train_of

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
    first = next(iter(results.values()))
    first.attrs["warnings"] = json.dumps([*json.loads(first.attrs.get("warnings", "[]")), *left_out])
    return results


def _steps(train: Train) -> dict[str, Callable[[], xr.Dataset]]:
    """Everything a report shows, by name; the System is made once, when first asked for."""
    from ..studies.parameter_studies import run_out_study, support_study
    from ..studies.source import system_of

    system = cache(lambda: system_of(train))
    steps: dict[str, Callable[[], xr.Dataset]] = {
        name: partial(_run, verbs()[name], train, system) for name in report_verbs()
    }
    if "sweep" in steps:
        steps["sweep"] = partial(_sweep, system, "operation", 0)
        steps[TO_MODES] = partial(_sweep, system, "modes", 1)
    studies = (partial(support_study, train), partial(run_out_study, train))
    return steps | dict(zip(STUDIES, studies, strict=True))


def _sweep(system: Callable[[], System], speed_range: str, which: int) -> xr.Dataset:
    """One of the two sweeps of a report."""
    points = _POINTS if len(system().tones) <= 2 else _POINTS_OF_MANY_TONES
    result = verbs()["sweep"].run(system(), range=speed_range, points=points[which])
    if speed_range == "modes":  # what is only far from operation is said to be so
        highest = 100 * float(result["speed"].max())
        found = json.loads(result.attrs.get("warnings", "[]"))
        far = [
            one if one in system().warnings else f"up to {highest:.0f} % of the operating speed: {one}" for one in found
        ]
        result.attrs["warnings"] = json.dumps(far)
    return result


def _run(verb: Verb, train: Train, system: Callable[[], System]) -> xr.Dataset:
    return verb.run(train if verb.drawing else system())
