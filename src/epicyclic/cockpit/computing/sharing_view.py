"""Load sharing as the page draws it: coefficients of the meshes, the hunting period, and the twin whose sun floats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...questions.sharing.definitions import DEFINITIONS
from ...questions.sharing.sharing import SpreadSharing, spread_sharing
from ...statics.sample_loads import mean_loads
from ...system.assembly import assemble
from ...system.system import Array, System
from ...train.bodies import Link
from ...train.train import Train

__all__ = ["SharingView", "Twin", "full_sharing", "live_sharing", "sharing_head", "twin_of", "twin_train"]

# Parts of the hunting period that are drawn, each by the largest ratio in it: a strip is some 500 pixels wide.
_PARTS = 256
# Support of a sun below this part of its stiffest mesh is a float.
_SOFT = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SharingView:
    """Load sharing of w whole meshes.

    coefficient, turning : (w,) N F_i / sum F without mesh-frequency content, and the largest of that over the hunting
        period [1], nan of meshes without load.  cycle_peak : (w,) largest deviation of a cycle peak, 1 + max |b - 1|.
    over_period : (w, parts) largest ratio b in each part of the hunting period [1].  load : (w,) mean force over the
        mean of its parallel meshes [1].  period : mesh cycles.  whole : whether every cycle or the search is behind it.
    quick : whether that takes less than a second.
    """

    mesh: tuple[str, ...]
    coefficient: Array
    turning: Array
    cycle_peak: Array
    over_period: Array
    load: Array
    period: int
    whole: bool
    quick: bool

    @property
    def k_gamma(self) -> float:
        """Largest coefficient of any mesh [1]; nan where unknown."""
        return _largest(self.coefficient)

    @property
    def k_gamma_turning(self) -> float:
        """The same of the largest over the hunting period [1]."""
        return _largest(self.turning)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Twin:
    """The same train with the radial support of a sun taken away, or, where it floats, made rigid.

    label : in words.  stage : whose sun.  path, value : override that makes the model so.  coefficient : (w,) [1].
    """

    label: str
    stage: str
    path: str
    value: object
    coefficient: Array

    @property
    def head(self) -> dict[str, Any]:
        """``head["sharing"]["twin"]``."""
        return {
            "label": self.label,
            "k_gamma": _largest(self.coefficient),
            "stage": self.stage,
            "path": self.path,
            "value": self.value,
        }


def _largest(values: Array) -> float:
    """Largest of values that are known; nan where none is."""
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else float("nan")


def live_sharing(system: System, *, patience: float = 0.1) -> SharingView:
    """Load sharing at rest from spread mesh cycles; patience : as of `spread_sharing` [s].

    Raises
    ------
    ModelError : no load, or what the static method raises.  ConvergenceError : no equilibrium.
    """
    found = spread_sharing(system, patience=patience)
    return SharingView(
        mesh=found.mesh,
        coefficient=found.mean_load[0],
        turning=found.mean_load[1],
        cycle_peak=found.cycle_peak,
        over_period=found.over_period(_parts(found)),
        # the mean over the hunting period is exact, that of a few cycles stands in where it is not known
        load=np.where(np.isnan(found.mean_load[0]), _relative_load(found.mean, found.groups), found.mean_load[0]),
        period=found.period,
        whole=False,
        quick=found.quick,
    )


def _parts(found: SpreadSharing) -> int:
    """Parts of the hunting period: as many as have some cycles each."""
    return int(np.clip(min(found.ratio.shape[1] // 4, found.period), 1, _PARTS))


def _relative_load(mean: Array, groups: Sequence[NDArray[np.int64]]) -> Array:
    """Mean forces (w,) over the mean of their group [1]; nan of groups without load."""
    result = np.full(len(mean), np.nan)
    for group in groups:
        total = float(mean[group].mean())
        if total > 0:
            result[group] = mean[group] / total
    return result


def full_sharing(result: xr.Dataset, live: SharingView) -> SharingView:
    """The same from the Dataset of `sharing`; the strip over the hunting period stays that of spread cycles."""
    values = result["load_sharing"].transpose("definition", "mesh").values
    place = {name: i for i, name in enumerate(DEFINITIONS)}
    worst = values[place["worst-case"]]
    return replace(
        live,
        coefficient=values[place["mean-load"]],
        turning=values[place["mean-load-turning"]],
        cycle_peak=np.where(np.isnan(worst), values[place["cycle-peak"]], worst),
        whole=True,
    )


def sharing_head(
    view: SharingView, twin: Twin | None, train: Train, labels: Mapping[str, str]
) -> tuple[dict[str, Any], dict[str, Array]]:
    """``head["sharing"]``, and its arrays ``coefficient``, ``turning``, ``cycle_peak``, ``over_period`` and ``twin``.

    labels : of the meshes.
    """
    pair = {mesh.name: mesh.pair.rpartition(".")[2] for mesh in train.meshes}
    head = {
        "definition": "mean-load",
        "stage": "whole" if view.whole else "at rest",
        "rows": [
            {"label": labels.get(name, name), "mesh": row, "pair": pair.get(name, "")}
            for row, name in enumerate(view.mesh)
        ],
        "k_gamma": view.k_gamma,
        "k_gamma_turning": view.k_gamma_turning,
        "cycle_peak": _largest(view.cycle_peak),
        "cycles": view.period,
        "parts": view.over_period.shape[1],
        "twin": None if twin is None else twin.head,
    }
    arrays = {
        "coefficient": view.coefficient,
        "turning": view.turning,
        "cycle_peak": view.cycle_peak,
        "over_period": view.over_period,
    }
    return head, arrays if twin is None else {**arrays, "twin": twin.coefficient}


def twin_of(train: Train, view: SharingView) -> Twin | None:
    """The twin of a train: with a floating sun, or, where it floats, with a rigid support of it.

    The sun is that of the stage with the largest coefficient that has one.  None without a sun, and where the twin has
    no equilibrium, as of a sun that only its support holds.
    """
    suns = {body.frame for body in train.bodies if body.kind == "sun" and body.gear is not None}
    stage_of = {mesh.name: mesh.stage for mesh in train.meshes}
    with_stage = [(stage_of.get(name, ""), value) for name, value in zip(view.mesh, view.coefficient, strict=True)]
    ranked = sorted(((value, stage) for stage, value in with_stage if stage in suns and value > 0), key=lambda x: -x[0])
    if not ranked:
        return None
    stage = ranked[0][1]
    changed, floats = twin_train(train, stage)
    if changed is None:
        return None
    try:
        coefficient = mean_loads(assemble(changed))[0]
    except (ModelError, ConvergenceError):
        return None
    where = f" of {stage}" if len(train.planets) > 1 else ""
    sun = next(body.member for body in train.bodies if body.frame == stage and body.kind == "sun")
    return Twin(
        label=f"with a supported sun{where}" if floats else f"with a floating sun{where}",
        stage=stage,
        path=f"stages.{sun}.support.radial",
        value="inf" if floats else 0,
        coefficient=np.where(np.isnan(view.coefficient), np.nan, coefficient),
    )


def twin_train(train: Train, stage: str) -> tuple[Train | None, bool]:
    """A train whose sun of a stage has no radial support, or a rigid one where it has none; and whether it has none.

    None where nothing but a shaft or coupling could be taken away.
    """
    suns = {body.name for body in train.bodies if body.frame == stage and body.kind == "sun"}
    supports = [link for link in train.links if link.kind == "support" and link.first in suns]
    if not supports:
        return None, False
    stiffest = max((mesh.stiffness for mesh in train.meshes if mesh.stage == stage), default=1.0)
    floats = all(max(link.stiffness[:2]) <= _SOFT * stiffest for link in supports)
    names = {link.name for link in supports}
    links = tuple(
        _with_radial(link, float("inf") if floats else 0.0) if link.name in names else link for link in train.links
    )
    return replace(train, links=links), floats


def _with_radial(link: Link, stiffness: float) -> Link:
    """A link with that radial stiffness [N/m], free or rigid, hence without a law or a damper there."""
    return replace(
        link,
        stiffness=(stiffness, stiffness, *link.stiffness[2:]),
        damping=(0.0, 0.0, *link.damping[2:]),
        clearance=0.0,
        exponent=1.0,
        curves=tuple(one for one in link.curves if one[0] > 1),
    )
