"""What other clearances, ratings and floating suns would make of the life of the bearing that lives shortest.

One frozen list of changes, each one more run: twice the clearance, or 20 um more where that is larger, a tenth more
rating, and every sun that is held in x and y floating.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from ...bearings.rating_life import dynamic_rating
from ...engine.points import outcomes
from ...engine.source import StudyAxis
from ...results.dataset import dataset, largest
from ...train.resolution import load
from .bearing_state import rolling_links

_MORE_CLEARANCE, _MORE_RATING = 20e-6, 1.1


def changes_of(result: xr.Dataset) -> StudyAxis:
    """The changes of a result of `life`, as overrides of its model file."""
    train = load(json.loads(result.attrs["model"]))
    shortest = result["bearing"].values[largest(-result["bearing_duty_life_reference"].values)]
    link = next(one for one in rolling_links(train) if one.name == shortest)
    assert link.rolling is not None
    clearance = link.rolling.clearance + max(link.rolling.clearance, _MORE_CLEARANCE)
    rating = _MORE_RATING * dynamic_rating(link.rolling)
    suns = {body.name for body in train.bodies if body.kind == "sun"}
    held = [one.path for one in train.links if one.kind == "support" and one.first in suns and any(one.stiffness[:2])]
    tried: dict[str, dict[str, Any]] = {
        f"{link.path}.internal_clearance = {1e6 * clearance:.4g} um": {f"{link.path}.internal_clearance": clearance},
        f"{link.path}.rating = {1e-3 * rating:.4g} kN": {f"{link.path}.rating": rating},
        **{f"{path}.radial = 0": {f"{path}.radial": 0} for path in held},
    }
    label = np.array(list(tried), dtype=object), {"long_name": "change of the model file"}
    return StudyAxis(name="change", changes=tuple(tried.values()), labels={"change": label})


def with_changes(
    result: xr.Dataset, run: Callable[[Mapping[str, Any]], xr.Dataset], progress: Callable[[float], None] | None
) -> xr.Dataset:
    """A result of `life` with change_life [s] and change_reason of every change; run : the lives with one.

    The life is that of the bearing that then lives shortest, nan where there is none, with the reason.
    """
    axis = changes_of(result)
    found = outcomes(run, axis.changes, progress=progress)
    shortest = [one.then(lambda lives: float(lives["bearing_duty_life_reference"].min())) for one in found]
    columns = {
        "change_life": ("change", [np.nan if one.value is None else one.value for one in shortest]),
        "change_reason": ("change", [one.reason for one in shortest]),
    }
    made = dataset(columns, {"change": axis.labels["change"][0]}, verb="life")
    return result.assign_coords(made.coords).assign(made.data_vars)
