"""What a search for relief returns: solutions, how it went, and the meshes before and after."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..train.train import Train
from .relief_objectives import DYNAMIC, OBJECTIVES, Cut, Helix, Judge, histories, judged, speed_curves
from .relief_variables import Setting, Variable, length_text
from .search import Found
from .tooth_contact import contact

__all__ = ["compared", "coords", "over_speed", "said", "solutions"]

Array = NDArray[np.float64]

_SHOWN = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
_ALL = 200_000  # evaluations kept in a result


def coords(judge: Judge, found: Found) -> dict[Any, Any]:
    return {
        "variable": [one.name for one in judge.variables],
        "objective": list(judge.objectives),
        "solution": np.arange(len(found.best)),
        "state": ["before", "after"],
        "relieved_mesh": [_name(sides) for sides in judge.meshes],
        **({} if judge.speeds is None else {"speed": judge.speeds}),
    }


def _name(sides: Sequence[Helix]) -> str:
    name = sides[0].mesh.name
    return name if len(sides) == 1 else name.rsplit("/", 1)[0]


def solutions(judge: Judge, found: Found, answer: int, flanks: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    places = found.place[found.best]
    values = [[one.value(at) for one, at in zip(judge.variables, place.tolist(), strict=True)] for place in places]
    numbers = [[one.number(v) for one, v in zip(judge.variables, row, strict=True)] for row in values]
    words = [[_words(one, v) for one, v in zip(judge.variables, row, strict=True)] for row in values]
    drawn = judged(judge, [{path: {} for path in flanks}])[0]
    return {
        "lower_bound": ("variable", np.array([one.low for one in judge.variables])),
        "upper_bound": ("variable", np.array([one.high for one in judge.variables])),
        "solution_value": (("solution", "variable"), np.array(numbers)),
        "solution_text": (("solution", "variable"), np.array(words, dtype=object)),
        "solution_objective": (("solution", "objective"), found.objective[found.best]),
        "objective_before": ("objective", drawn),
        "objective_after": ("objective", found.objective[answer]),
        "objective_meaning": ("objective", np.array([OBJECTIVES[name][1] for name in judge.objectives], dtype=object)),
        "objective_unit": ("objective", np.array([OBJECTIVES[name][0] for name in judge.objectives], dtype=object)),
        "evaluated_place": (("evaluation", "variable"), found.place[:_ALL]),
        "evaluated_objective": (("evaluation", "objective"), found.objective[:_ALL]),
        "evaluated_generation": ("evaluation", found.generation[:_ALL]),
        "best_so_far": (("generation", "objective"), _best_so_far(found)),
    }


def _words(variable: Variable, value: float | str) -> str:
    if isinstance(value, str):
        return value
    return length_text(value, -3 if variable.key.endswith("length") else -6)


def _best_so_far(found: Found) -> Array:
    """Least of each objective up to the end of every generation, (G, o)."""
    count = int(found.generation.max()) + 1
    least = [np.nanmin(np.where(found.generation[:, None] <= g, found.objective, np.nan), axis=0) for g in range(count)]
    return np.array(least)


def compared(judge: Judge, trains: Sequence[Train], torque: float | str | None, cut: Cut) -> dict[str, tuple[Any, Any]]:
    """Loaded contact before and after, of every mesh at several loads."""
    factors = np.array(sorted({*_SHOWN, *judge.factors.tolist()}))
    runs = [
        [
            contact(train, mesh=_name(sides), torque=torque, factors=factors.tolist(), **asdict(cut))
            for sides in judge.meshes
        ]
        for train in trains
    ]

    def each(take: Callable[[xr.Dataset], Array]) -> Array:
        return np.array([[take(one) for one in meshes] for meshes in runs])

    over = ("state", "relieved_mesh", "load_factor")
    return {
        "load_factor": ("load_factor", factors),
        "mesh_phase": ("mesh_phase", np.arange(cut.samples) / cut.samples),
        "relieved_force": ("relieved_mesh", np.array([float(one.attrs["force"]) for one in runs[0]])),
        "relieved_error": ((*over, "mesh_phase"), each(lambda one: one.loaded_transmission_error.values)),
        "relieved_peak_to_peak": (over, each(lambda one: one.transmission_error_peak_to_peak.values)),
        "relieved_largest_load": (over, each(lambda one: one.largest_load_per_length.values.max(axis=0))),
        "relieved_place": (("relieved_mesh", "path_point"), np.array([one.path_place.values for one in runs[0]])),
        "relieved_load": (
            ("state", "relieved_mesh", "path_point"),
            each(_along_path),
        ),
    }


def _along_path(one: xr.Dataset) -> Array:
    """Largest load per length of both faces at places of the path; 0 where nothing touches."""
    return np.asarray(np.nan_to_num(one.flank_load_per_length.values).max(axis=(0, 1)))


def over_speed(judge: Judge, settings: Mapping[str, Setting]) -> dict[str, tuple[Any, Any]]:
    """Dynamic mesh force over the speed, before and after."""
    plain: dict[str, Setting] = {path: {} for path in settings}
    curves = [speed_curves(judge, histories(judge, one)) for one in (plain, settings)]
    return {DYNAMIC[name]: (("state", "speed"), np.array([one[name] for one in curves])) for name in DYNAMIC}


def said(train: Train, after: Train, judge: Judge, found: Found, generations: int) -> list[str]:
    told = [*train.warnings, *(text for text in after.warnings if text not in train.warnings)]
    done = int(found.generation.max()) + 1
    if found.stopped:
        told.append(f"stopped after {done} of {generations} generations: the best so far")
    failed = int((~np.isfinite(found.objective)).any(axis=1).sum())
    if failed:
        told.append(f"{failed} of {len(found.objective)} candidates could not be computed")
    for column, variable in enumerate(judge.variables):
        at = found.place[found.best, column]
        if not variable.shapes and len(at) == 1 and (at[0] < 1e-3 or at[0] > 1 - 1e-3):
            told.append(f"{variable.name} ends at its {'lower' if at[0] < 0.5 else 'upper'} bound")
    return told
