"""`relief`: the best relief and lead modification, what it does to the objectives and to every mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Drawing, Section, Table, number

if TYPE_CHECKING:
    import xarray as xr

ORDER = 150

_SHOWN = 20
# what objectives are read in: factor from SI, unit
_READ = {"m": (1e6, "um"), "N/m": (1e-3, "N/mm"), "N": (1.0, "N")}


def tables(result: xr.Dataset) -> Sequence[Table]:
    """The answer, the Pareto set where there are several objectives, and every mesh before and after."""
    front = [_front(result)] if result.sizes["objective"] > 1 else []
    return [_answer(result), _objectives(result), *front, _meshes(result)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The search, and error, load and force before and after."""
    from ..charts.relief import relief_effect, relief_search

    parts = [
        Drawing(anchor="relief", figure=relief_search(result)),
        Drawing(anchor="relief-effect", figure=relief_effect(result)),
    ]
    return [Section(anchor="relief", title="Relief", parts=parts)]


def _answer(result: xr.Dataset) -> Table:
    picked = int(result.attrs["picked"])
    candidates, generations = result.sizes["evaluation"], result.sizes["generation"]
    title = f"{result.attrs['method']}, {candidates} candidates in {generations} generations"
    names = [str(name) for name in result.variable.values]
    columns: dict[str, Any] = {
        "varied": names,
        "found": [str(text) for text in result.solution_text.values[picked]],
        "from": [_bound(name, value) for name, value in zip(names, result.lower_bound.values, strict=True)],
        "to": [_bound(name, value) for name, value in zip(names, result.upper_bound.values, strict=True)],
    }
    return Table(title=title, columns=columns, lead=_resolution(result))


def _resolution(result: xr.Dataset) -> str:
    """Phases and slices of the answer, and the error they leave; empty of a result of an earlier version."""
    attrs = result.attrs
    if "estimated_error" not in attrs:
        return ""
    error = float(attrs["estimated_error"])
    left = "" if np.isnan(error) else f", estimated error {100 * error:.2g} %"
    return f"Before and after: {attrs['samples']} phases and {attrs['slices']} slices{left}."


def _bound(name: str, value: float) -> str:
    """A bound with its unit; of shapes nothing."""
    if name.endswith("shape"):
        return ""
    return f"{number(value * 1e3)} mm" if name.endswith("length") else f"{number(value * 1e6)} µm"


def _objectives(result: xr.Dataset) -> Table:
    before, after = result.objective_before.values, result.objective_after.values
    units = [_READ[str(unit)] for unit in result.objective_unit.values]
    columns: dict[str, Any] = {
        "objective": [str(name) for name in result.objective.values],
        "what is made least": [str(text) for text in result.objective_meaning.values],
        "unit": [unit for _, unit in units],
        "before": [value * factor for value, (factor, _) in zip(before, units, strict=True)],
        "after": [value * factor for value, (factor, _) in zip(after, units, strict=True)],
        "change": [f"{100 * (b / a - 1):+.3g} %" if a else "" for a, b in zip(before, after, strict=True)],
    }
    return Table(title="Before and after", columns=columns)


def _front(result: xr.Dataset) -> Table:
    """The Pareto set, evenly thinned where it is long, the answer always among it."""
    count, picked = result.sizes["solution"], int(result.attrs["picked"])
    rows = np.unique([picked, *np.linspace(0, count - 1, min(count, _SHOWN)).round().astype(int)])
    units = [_READ[str(unit)] for unit in result.objective_unit.values]
    columns: dict[str, Any] = {"number": [f"{row}{' *' if row == picked else ''}" for row in rows]}
    for i, name in enumerate(result.variable.values):
        columns[str(name)] = [str(text) for text in result.solution_text.values[rows, i]]
    for i, (name, (factor, unit)) in enumerate(zip(result.objective.values, units, strict=True)):
        columns[f"{name} [{unit}]"] = list(result.solution_objective.values[rows, i] * factor)
    return Table(title=f"Pareto set, {len(rows)} of {count}; * the answer", columns=columns)


def _meshes(result: xr.Dataset) -> Table:
    swing, load = result.relieved_peak_to_peak.values * 1e6, result.relieved_largest_load.values / 1e3
    cells = [(i, j) for i in range(result.sizes["relieved_mesh"]) for j in range(result.sizes["load_factor"])]
    columns: dict[str, Any] = {
        "mesh": [str(result.relieved_mesh.values[i]) for i, _ in cells],
        "force of a helix [N]": [result.relieved_force.values[i] * result.load_factor.values[j] for i, j in cells],
        "error before [µm]": [swing[0, i, j] for i, j in cells],
        "error after [µm]": [swing[1, i, j] for i, j in cells],
        "largest load before [N/mm]": [load[0, i, j] for i, j in cells],
        "largest load after [N/mm]": [load[1, i, j] for i, j in cells],
    }
    return Table(title="Peak to peak of the loaded transmission error, and load on the flank", columns=columns)
