"""One-parameter studies: a quantity of the train over values in the model file.

`vary` takes any path and any quantity; load sharing over support stiffness and run-out has its points on several cores.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...engine.workers import each
from ...errors import ConvergenceError, ModelError
from ...results.dataset import dataset
from ...system.assembly import assemble, train_provenance
from ...user_input import checked
from ...warning_codes import coded

if TYPE_CHECKING:
    from ...system.system import System
    from ...train.train import Train

Progress = Callable[[float], None] | None
# Mesh cycles of a record where links or meshes have laws, each instant of which is an equilibrium of its own.
_CYCLES = 64


def largest_sharing(system: System) -> float:
    """Load-sharing coefficient of the train [1] by the first definition of `sharing`, peak per mesh cycle."""
    from ..sharing.sharing import sharing

    return float(sharing(system).system_load_sharing[0])


def worst_sharing(system: System) -> float:
    """Static load-sharing coefficient of the train [1], peaks per mesh cycle, worst case over the hunting period.

    To keep a study of many points short, several varying mesh frequencies are replaced by the mean stiffness, and
    where links or meshes have laws the coefficient is the largest of 64 mesh cycles.
    """
    from ..sharing.sharing import sharing

    varying = {int(tone) for tone, row in zip(system.meshes.tone, system.meshes.variation, strict=True) if row.any()}
    if len(varying) > 1:
        far = None if system.far is None else replace(system.far, variation=system.far.variation[:, :0])
        system = replace(system, meshes=replace(system.meshes, variation=system.meshes.variation[:, :0]), far=far)
    lawful = _has_laws(system)
    coefficients = sharing(system, method="static", cycles=_CYCLES if lawful else 1).system_load_sharing
    return float(coefficients.sel(definition="cycle-peak" if lawful else "worst-case"))


@checked
def vary(
    source: str | Path | Mapping[str, Any],
    path_values: Mapping[str, Sequence[Any]],
    *,
    quantity: Callable[[System], float] = largest_sharing,
    overrides: Mapping[str, Any] | None = None,
    unit: str = "1",
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """A quantity of the System over values in the model file; several paths take their values together.

    A point that fails holds nan, its ``status`` the message; the other points are computed.

    Parameters
    ----------
    source, overrides : as of `load`; the model file that the values override.
    path_values : path in the file -> its value at each of P points.
    quantity : function of the System of each point.  unit : of its value.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : quantity (point), status (point) ("ok" or the message); the values as coordinates named by their paths.

    Raises
    ------
    ModelError : no path, or not the same number of values for every path.
    """
    counts = {path: len(values) for path, values in path_values.items()}
    if len(set(counts.values())) != 1:
        raise ModelError("needs the same number of values for each path", path="path_values", given=counts)
    count = next(iter(counts.values()))
    quantities, status = np.full(count, np.nan), np.full(count, "ok", dtype=object)
    for point in range(count):
        values = {path: values[point] for path, values in path_values.items()}
        try:
            quantities[point] = _evaluate(source, {**(overrides or {}), **values}, quantity)
        except (ModelError, ConvergenceError) as error:
            status[point] = str(error)
        if progress is not None:
            progress((point + 1) / count)
    return dataset(
        {"quantity": ("point", quantities), "status": ("point", status)},
        coords={"point": np.arange(count), **{path: ("point", list(values)) for path, values in path_values.items()}},
        verb="vary",
        options={"paths": list(path_values), "overrides": dict(overrides or {})},
        units={"quantity": unit},
        warnings=[coded("points-failed", f"{int(np.sum(status != 'ok'))} of {count} points failed")]
        if np.any(status != "ok")
        else (),
    )


def _evaluate(
    source: str | Path | Mapping[str, Any], overrides: Mapping[str, Any], quantity: Callable[[System], float]
) -> float:
    from ...train.resolution import load

    return float(quantity(assemble(load(source, overrides=overrides))))


def support_study(train: Train, *, points: int = 9, progress: Progress = None) -> xr.Dataset:
    """Static load sharing over the lateral support stiffness of one member after the other.

    Parameters
    ----------
    points : stiffnesses in equal ratios, from a thirtieth of the smallest given to ten times the largest.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : system_load_sharing [1] and status (member, support_stiffness [N/m]); the other members as drawn.

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
    return _sharing_study(
        train, changes, values, ("support_stiffness", "Load sharing over lateral support stiffness"), progress
    )


def run_out_study(train: Train, *, points: int = 5, progress: Progress = None) -> xr.Dataset:
    """Static load sharing over the run-out of one member after the other.

    Parameters
    ----------
    points : run-outs, evenly spaced from zero to four times the largest given.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : system_load_sharing [1] and status (member, run_out [um]); the other members as drawn.

    Raises
    ------
    ModelError : the model has no run-out, or no point could be computed.
    """
    given = {d.path: float(np.abs(d.vector[:2]).max()) for d in train.displacements if d.cause == "run_out"}
    if not given:
        raise ModelError("no member has a run-out", path="deviations", allowed='run_out = "20 um"')
    values = np.linspace(0.0, 4 * max(given.values()), points)
    changes = {path: (path,) for path in given}
    result = _sharing_study(train, changes, values, ("run_out", "Load sharing over run-out"), progress)
    return result.assign_coords(run_out=result.run_out.copy(data=values * 1e6))  # um, as on drawings


def _sharing_study(
    train: Train,
    changes: Mapping[str, Sequence[str]],
    values: NDArray[np.float64],
    words: tuple[str, str],
    progress: Progress,
) -> xr.Dataset:
    """Sharing (member, value) of one curve per entry of `changes`.

    Parameters
    ----------
    changes : path of a member -> paths that take each value together.  values : (P,) in SI.
    words : name of the coordinate of the values, and title of the study.
    """
    points = [dict.fromkeys(paths, float(value)) for paths in changes.values() for value in values]
    arrived: list[int] = []

    def count(place: int, _: tuple[float, str]) -> None:
        arrived.append(place)
        if progress is not None:
            progress(len(arrived) / len(points))

    coefficients, texts = zip(*each(partial(_sharing_point, train.document), points, arrived=count), strict=True)
    shape = len(changes), len(values)
    sharing = np.array(coefficients).reshape(shape)
    status = np.array(texts, dtype=object).reshape(shape)
    failed = int((status != "ok").sum())
    if failed == status.size:
        raise ModelError(str(status.flat[0]))
    coordinate, title = words
    dims = "member", coordinate
    result = dataset(
        {"system_load_sharing": (dims, sharing), "status": (dims, status)},
        coords={"member": [_member_name(path) for path in changes], coordinate: values},
        verb="vary",
        options={"definition": "cycle-peak" if _has_laws(assemble(train)) else "worst-case", "method": "static"},
        warnings=[coded("points-failed", f"{title}: {failed} of {status.size} points failed")] if failed else (),
        provenance=train_provenance(train),
    )
    return result.assign_attrs(study=title)


def _sharing_point(document: Mapping[str, Any], values: Mapping[str, float]) -> tuple[float, str]:
    """`worst_sharing` [1] with values in place of those of a document, and "ok"; nan and the message where it fails."""
    try:
        return _evaluate(document, values, worst_sharing), "ok"
    except (ModelError, ConvergenceError) as error:
        return float("nan"), str(error)


def _has_laws(system: System) -> bool:
    """Whether any link or mesh follows a law, which decides the definition of `worst_sharing`."""
    return bool(system.groups or system.meshes.laws)


def _member_name(path: str) -> str:
    """``main.sun`` of ``stages.main.sun.support`` or ``deviations.main.sun.run_out``."""
    return ".".join(part for part in path.split(".")[1:] if part not in ("support", "run_out"))
