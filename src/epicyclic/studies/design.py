"""Load sharing over what a designer may change: lateral support stiffness and run-out tolerance, member by member."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..errors import ModelError
from ..results.dataset import dataset
from .check import train_provenance
from .curves import vary

if TYPE_CHECKING:
    from ..system.system import System
    from ..train.train import Train

__all__ = ["run_out_study", "support_study", "worst_sharing"]

Progress = Callable[[float], None] | None


# mesh cycles of a record where links have laws, each instant of which is solved for itself
_CYCLES = 64


def worst_sharing(system: System) -> float:
    """Load-sharing coefficient of the train [1] at rest, peaks per mesh cycle, worst over the hunting period.

    Where several mesh frequencies vary the stiffness it is that at the mean stiffness, and where links have laws the
    worst of 64 mesh cycles: a study asks for many points.
    """
    from ..analyses.sharing.sharing import sharing

    varying = {int(tone) for tone, row in zip(system.meshes.tone, system.meshes.variation, strict=True) if row.any()}
    if len(varying) > 1:
        system = replace(system, meshes=replace(system.meshes, variation=system.meshes.variation[:, :0]))
    coefficients = sharing(system, method="static", cycles=_CYCLES if system.groups else 1).system_load_sharing
    return float(coefficients.sel(definition="cycle-peak" if system.groups else "worst-case"))


def support_study(train: Train, *, points: int = 9, progress: Progress = None) -> xr.Dataset:
    """Static load sharing over the lateral support stiffness of each supported member, the others as the model says.

    Parameters
    ----------
    points : stiffnesses, from a thirtieth of the smallest to ten times the largest given.

    Raises
    ------
    ModelError : no member has an elastic lateral support, or no point could be computed.
    """
    given = {
        link.path: link.stiffness[0]
        for link in train.links
        if link.kind == "support" and np.isfinite(link.stiffness[:2]).all() and min(link.stiffness[:2]) > 0
    }
    if not given:
        raise ModelError("no member has an elastic lateral support", path="stages", allowed="support.radial")
    values = np.geomspace(min(given.values()) / 30, max(given.values()) * 10, points)
    changes = {path: (f"{path}.x", f"{path}.y") for path in given}
    return _study(
        train, changes, values, ("support_stiffness", "Load sharing over lateral support stiffness"), progress
    )


def run_out_study(train: Train, *, points: int = 5, progress: Progress = None) -> xr.Dataset:
    """Static load sharing over the run-out of each member that has one, the others as the model says.

    Parameters
    ----------
    points : run-outs, from none to four times the largest given.

    Raises
    ------
    ModelError : the model has no run-out, or no point could be computed.
    """
    given = {d.path: float(np.abs(d.vector[:2]).max()) for d in train.displacements if d.cause == "run_out"}
    if not given:
        raise ModelError("no member has a run-out", path="deviations", allowed='run_out = "20 um"')
    values = np.linspace(0.0, 4 * max(given.values()), points)
    changes = {path: (path,) for path in given}
    result = _study(train, changes, values, ("run_out", "Load sharing over run-out"), progress)
    return result.assign_coords(run_out=result.run_out.copy(data=values * 1e6))  # as drawings say it


def _study(
    train: Train,
    changes: Mapping[str, Sequence[str]],
    values: NDArray[np.float64],
    words: tuple[str, str],
    progress: Progress,
) -> xr.Dataset:
    """One curve per entry of `changes` (path -> paths set together); words: coordinate and title."""
    curves = []
    for place, paths in enumerate(changes.values()):
        over = {path: [float(value) for value in values] for path in paths}
        curves.append(vary(train.document, over, quantity=worst_sharing))
        if progress is not None:
            progress((place + 1) / len(changes))
    status = np.array([curve.status.values for curve in curves])
    failed = int((status != "ok").sum())
    if failed == status.size:
        raise ModelError(str(status.flat[0]))
    coordinate, title = words
    result = dataset(
        {
            "system_load_sharing": (("member", coordinate), np.array([curve.quantity.values for curve in curves])),
            "status": (("member", coordinate), status),
        },
        coords={"member": [_short(path) for path in changes], coordinate: values},
        verb="vary",
        options={"definition": "cycle-peak" if _lawful(train) else "worst-case", "method": "static"},
        warnings=[f"{title}: {failed} of {status.size} points failed"] if failed else (),
        provenance=train_provenance(train),
    )
    return result.assign_attrs(study=title)


def _lawful(train: Train) -> bool:
    """Whether any link follows a law, as `worst_sharing` asks of the System."""
    from ..assemble import assemble

    return bool(assemble(train).groups)


def _short(path: str) -> str:
    """``main.sun`` of ``stages.main.sun.support`` or ``deviations.main.sun.run_out``."""
    return ".".join(part for part in path.split(".")[1:] if part not in ("support", "run_out"))
