"""The result of a search for tip relief as the page shows it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from ...document.written_numbers import written
from .answer import answer, number, per_cent
from .job_frame import JobFrame, job_frame, lines

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["relief_frame"]

# A change of the objective below this part of it is none.
_WORTH = 0.02
# Words before the values that are searched by default.
_NAMES = {"tip_relief.amount": "", "tip_relief.length": "over "}


def relief_frame(result: xr.Dataset, pair: str) -> JobFrame:
    """Transmission error over the mesh cycle before and after; the answer on relief, and the overrides that draw it."""
    mean = result["relieved_error"].transpose("state", "relieved_mesh", "load_factor", "mesh_phase")
    load = int(np.abs(result["load_factor"].values - 1).argmin())
    error = 1e6 * mean.values[:, 0, load]
    x = np.asarray(result["mesh_phase"].values, dtype=float)
    curves = {"after": error[1] - error[1].mean(), "before": error[0] - error[0].mean()}
    drawn = lines("mesh cycle [1]", "error about its mean [µm]", x, curves)
    picked = int(result.attrs["picked"])
    solution = [_rounded(str(one)) for one in result["solution_text"].values[picked]]
    names = [_NAMES.get(str(name), str(name)) for name in result["variable"].values]
    found = " ".join(f"{name}{value}" for name, value in zip(names, solution, strict=True))
    before, after = (float(result[f"objective_{when}"].values[0]) for when in ("before", "after"))
    gain = 1 - after / before if before else 0.0
    scale, unit = (1e6, "µm") if str(result["objective_unit"].values[0]) == "m" else (1.0, "")
    change = f"{number(scale * before)} to {number(scale * after)} {unit}".strip()
    text = f"Tip relief {found} on {pair}: {result['objective_meaning'].values[0].split(',')[0]} from {change}."
    overrides = json.loads(str(result.attrs["overrides"])) if gain > _WORTH else {}
    words = (
        f"Grind {found} at the tips of {pair}: transmission error {change}, {per_cent(gain)} less."
        if gain > _WORTH
        else f"None other than drawn: the search finds no smaller transmission error on {pair} ({change})."
    )
    said = answer(
        "relief",
        words,
        figure=solution[0],
        level="warn" if gain > _WORTH else "good",
        apply=overrides,
        apply_label="Draw this relief",
        evidence="relief",
        job="relief",
    )
    return job_frame(
        "relief", "Tip relief", text, drawn, apply=overrides, apply_label="Draw this relief", answers=[said]
    )


def _rounded(text: str) -> str:
    """``15.9 µm`` of ``15.936 um``; what is no length stays."""
    found = written(text)
    if found is None or not found.unit:
        return text
    return f"{number(found.values[0])} {found.unit.replace('um', 'µm')}"
