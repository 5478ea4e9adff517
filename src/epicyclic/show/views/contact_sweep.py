"""`sweep` with contact loss: run-up, coast-down, branches with their stability, folds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...results.ties import largest
from ..elements import Company, Drawing, Section, Table
from ..series import of_first_stage
from ..tables import extent, named_columns, status_table

if TYPE_CHECKING:
    import xarray as xr

ORDER = 110

_SHOWN = 40


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Largest forces of each mesh, ranges of speed by what moves there, folds."""
    title = f"{result.sizes['speed']} speeds, {extent(result)}"
    return [_forces(result, title), _ranges(result), *_folds(result), status_table(result)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The most loaded mesh over speed, with its branches."""
    from ..charts.over_speed import contact_sweep

    words = "Dashed: unstable branches. Large marks: motions that take the place of an unstable one. Circles: folds."
    parts = [Drawing(anchor="contact-sweep", figure=contact_sweep(result), caption=words)]
    return [Section(anchor="contact-sweep", title="Speed sweep with contact loss", parts=parts)]


def _forces(result: xr.Dataset, title: str) -> Table:
    rows = []
    for mesh in result.mesh.values:
        row: list[Any] = [str(mesh)]
        for direction in result.direction.values:
            series = result.mesh_force_rms.sel(mesh=mesh, direction=direction).values
            found = np.isfinite(series).any()
            at = largest(series)
            row += [float(series[at]), float(result.mesh_frequency.values[at]) if found else np.nan]
        # a mesh that rests on its far flank has negative forces alone: the largest in size counts
        ends = np.stack([result[name].sel(mesh=mesh).values for name in ("mesh_force_peak", "mesh_force_minimum")])
        known = ends[np.isfinite(ends)]
        force = float(known[np.abs(known).argmax()]) if known.size else np.nan
        apart = float(np.nanmax(result.contact_open.sel(mesh=mesh).values, initial=0.0)) if known.size else np.nan
        rows.append((*row, force, round(100 * apart, 1)))
    of = of_first_stage(result)
    where = f"at mesh frequency{of} [Hz]" if of else "at [Hz]"
    headings = (
        *("mesh", "up: largest rms [N]", where, "down: largest rms [N]", f"{where} "),
        *("largest force [N]", "apart at most [% of the time]"),
    )
    return Table(title=f"Dynamic mesh forces with contact loss, {title}", columns=named_columns(headings, rows))


def _ranges(result: xr.Dataset) -> Table:
    """Runs of speeds with one kind of motion, in each direction."""
    rank = np.argsort(result.mesh_frequency.values, kind="stable")
    frequency, rows = result.mesh_frequency.values[rank], []
    for direction in result.direction.values:
        part = result.sel(direction=direction)
        label = _labels(part)[rank]
        starts = np.flatnonzero(np.r_[True, label[1:] != label[:-1]])
        for first, last in zip(starts, [*(starts[1:] - 1), len(label) - 1], strict=True):
            rows.append((str(direction), float(frequency[first]), float(frequency[last]), str(label[first])))
    of = of_first_stage(result)
    ends = ("from mesh frequency{} [Hz]", "to mesh frequency{} [Hz]") if of else ("from{} [Hz]", "to{} [Hz]")
    headings = ("direction", *(end.format(of) for end in ends), "motion")
    left = f", first {_SHOWN} of {len(rows)}" if len(rows) > _SHOWN else ""
    return Table(title=f"What moves{left}", columns=named_columns(headings, rows[:_SHOWN]))


def _labels(part: xr.Dataset) -> np.ndarray[Any, np.dtype[np.object_]]:
    """``periodic``, ``integrated (quasi-periodic)``, ...: the motion, and what its branch was left by."""
    texts = []
    for motion, left, apart in zip(
        part.motion.values, part.branch_instability.values, part.contact_open.max("mesh").values, strict=True
    ):
        teeth = ", teeth part" if apart > 0 else ""
        texts.append(f"{motion or 'none'}{f' ({left})' if left else ''}{teeth}")
    return np.array(texts, dtype=object)


def _folds(result: xr.Dataset) -> list[Table]:
    if not result.sizes.get("fold"):
        return []
    heading = f"mesh frequency{of_first_stage(result)} [Hz]"
    return [Table(title="Folds of the branches", columns={heading: list(result.fold_frequency.values)})]
