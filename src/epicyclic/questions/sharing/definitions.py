"""Load-sharing coefficients by name, gathered over a record piece by piece.

A group is the meshes of one pair and one side, N of them, one per branch; the slices of a mesh are added up first.

    cycle-peak       P_i = peak of mesh i in a mesh cycle, b_i = N P_i / sum_j P_j, coefficient 1 + max |b_i - 1|
                     over the cycles [ren2021, eq. 21-24, with the sum of the peaks as divisor]
    signed-overload  the same without the absolute value: the largest b_i
    simultaneous     largest N F_i(t) / sum_j F_j(t) over the record
    record-peak      N max_t F_i / sum_j max_t F_j
    worst-case       cycle-peak over the whole hunting period
    mean-load, mean-load-turning
                     without mesh-frequency content, of the quasi-static forces at mean mesh stiffness whatever the
                     record (`statics.mean_load`); the first is K_gamma

Beside them the labelled result, and the checks and warnings that both kinds of record have.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...statics.load_map import MEAN_LOADS
from ...statics.record import MeshGroup, idle_warnings, loaded_meshes, parallel_meshes
from ...statics.sample_loads import mean_loads
from ...system.system import Array, System, faces
from ...warning_codes import CodedText, coded

if TYPE_CHECKING:
    import xarray as xr

DEFINITIONS = ("cycle-peak", "simultaneous", "record-peak", "signed-overload", "worst-case", *MEAN_LOADS)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Extremes:
    """Extremes over a piece of record, (m,) each.

    ratio_high, ratio_low : largest and smallest cycle-peak ratio b [1].  simultaneous : largest ratio at one instant
        [1].
    peak, least : largest and smallest force [N].  A ratio to forces that sum to nothing or less is inf.
    """

    ratio_high: Array
    ratio_low: Array
    simultaneous: Array
    peak: Array
    least: Array

    @property
    def cycle_peak(self) -> Array:
        """Coefficient 1 + max |b - 1| over the cycles, (m,) [1] [ren2021, eq. 21-24]."""
        return np.asarray(1.0 + np.maximum(self.ratio_high - 1.0, 1.0 - self.ratio_low))


def extremes(force: Array, members: Sequence[MeshGroup]) -> Extremes:
    """Extremes of a piece of record; force (cycles, m, samples) [N], members : groups of the m meshes."""
    peaks = force.max(axis=2)
    ratio = cycle_peak_ratio(peaks, members)
    together = np.empty(force.shape[1])
    for group in members:
        together[group] = instant_ratio(force[:, group]).max(axis=(0, 2))
    return Extremes(
        ratio_high=ratio.max(axis=0),
        ratio_low=ratio.min(axis=0),
        simultaneous=np.where(np.isnan(together), np.inf, together),
        peak=peaks.max(axis=0),
        least=force.min(axis=(0, 2)),
    )


def merge_extremes(a: Extremes, b: Extremes) -> Extremes:
    """Extremes of two pieces together, (m,) each."""
    return Extremes(
        ratio_high=np.maximum(a.ratio_high, b.ratio_high),
        ratio_low=np.minimum(a.ratio_low, b.ratio_low),
        simultaneous=np.maximum(a.simultaneous, b.simultaneous),
        peak=np.maximum(a.peak, b.peak),
        least=np.minimum(a.least, b.least),
    )


def cycle_peak_ratio(peaks: Array, members: Sequence[MeshGroup]) -> Array:
    """b = N P_i / sum P of each cycle, (cycles, m) [1]; peaks (cycles, m) [N] [ren2021, eq. 21-24].

    Peaks that sum to nothing or less (a linear model pulled open) have no ratio: inf.
    """
    ratio = np.empty_like(peaks)
    for group in members:
        total = peaks[:, group].sum(axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio[:, group] = np.where(total > 0, len(group) * peaks[:, group] / total, np.inf)
    return ratio


def instant_ratio(force: Array) -> Array:
    """N F_i / sum_j F_j at every instant of one group, (..., N, samples) [1]; nan where the sum is not positive."""
    total = force.sum(axis=-2, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares: Array = np.where(total > 0, force.shape[-2] * force / total, np.nan)
    return shares


def coefficients(record: Extremes, worst: Array, mean_load: Array, members: Sequence[MeshGroup]) -> Array:
    """Load-sharing coefficients, (definition, m) [1] in the order of `DEFINITIONS`.

    Parameters
    ----------
    worst : (m,) of the worst case.  mean_load : (2, m) by `MEAN_LOADS`.
    """
    record_peak = cycle_peak_ratio(record.peak[None], members)[0]
    return np.array([record.cycle_peak, record.simultaneous, record_peak, record.ratio_high, worst, *mean_load])


def known_mean_loads(system: System) -> tuple[Array, list[CodedText]]:
    """Coefficients (2, w) without mesh-frequency content [1], and a warning where they are not known, nan then.

    A train that vibrates may have no equilibrium at rest: a load that only inertia takes.
    """
    try:
        return mean_loads(system), []
    except (ModelError, ConvergenceError) as error:
        why = getattr(error, "problem", None) or str(error)
        unknown = np.full((len(MEAN_LOADS), len(faces(system.meshes).name)), np.nan)
        return unknown, [coded("mean-load-unknown", f"{' and '.join(MEAN_LOADS)} are not known: {why}")]


def require_speed(relative_speed: float) -> None:
    """Raise ModelError where the speed per operating speed [1] is not above zero."""
    if not relative_speed > 0:
        raise ModelError("must be above zero", path="relative_speed", given=relative_speed, allowed="> 0")


def meshes_with_load(mean: Array, members: Sequence[MeshGroup], *, most: Array, rounding: float) -> NDArray[np.bool_]:
    """Meshes (m,) that carry load; arguments as of `loaded_meshes`.  ModelError where none does."""
    loaded = loaded_meshes(mean, members, most=most, rounding=rounding)
    if not loaded.any():
        problem = "load sharing needs a load, and no mesh carries any"
        raise ModelError(problem, path="operation.torque", allowed="a torque")
    return loaded


def sharing_warnings(meshes: tuple[str, ...], open_: NDArray[np.bool_], loaded: NDArray[np.bool_]) -> list[CodedText]:
    """Warnings of meshes with load that open, (m,), and of those without load, (m,)."""
    parted = mesh_names(meshes, open_ & loaded)
    notes = [coded("contact-lost", f"meshes open: {parted}")] if parted else []
    return notes + idle_warnings(meshes, loaded, "load sharing")


def mesh_names(meshes: tuple[str, ...], chosen: NDArray[np.bool_]) -> str:
    """Names of the chosen meshes (m,)."""
    return ", ".join(name for name, yes in zip(meshes, chosen, strict=True) if yes)


def far_warnings(meshes: tuple[str, ...], far: NDArray[np.bool_]) -> list[CodedText]:
    """A warning of the meshes whose far flank presses at some instant, (m,)."""
    names = mesh_names(meshes, far)
    text = f"meshes on their far flank, where their force is negative: {names}"
    return [coded("far-flank-loaded", text)] if names else []


def bound_warnings(meshes: Sequence[str], bound: Array, why: Sequence[str]) -> list[CodedText]:
    """A warning where the largest force over all phases, (m,) [N], is not known, with the reason of each mesh (m,)."""
    missing: dict[str, list[str]] = {}
    for name, value, reason in zip(meshes, bound, why, strict=True):
        if np.isnan(value) and reason:
            missing.setdefault(reason, []).append(name)
    alone = len(missing) == 1 and len(next(iter(missing.values()))) == len(meshes)
    reasons = [reason if alone else f"{reason} ({', '.join(names)})" for reason, names in missing.items()]
    text = f"mesh_force_bound, the largest force over all phases, is not known: {'; '.join(reasons)}"
    return [coded("force-bound-unknown", text)] if reasons else []


def _undefined(meshes: tuple[str, ...], coefficients: Array, method: str) -> list[CodedText]:
    """Warning of coefficients (definition, m) that are infinite: there the forces of a group sum to nothing or less."""
    infinite = [
        f"{name} of {mesh_names(meshes, row)}"
        for name, row in zip(DEFINITIONS, np.isinf(coefficients), strict=True)
        if row.any()
    ]
    if not infinite:
        return []
    cure = "" if method == "static" else "; with method static the teeth part"
    problem = "load sharing undefined where a mesh carries nothing and the forces of its group sum to 0 or less"
    return [coded("load-sharing-undefined", f"{problem}: {'; '.join(infinite)}{cure}")]


def force_columns(mean: Array, most: Array, least: Array) -> dict[str, tuple[str, Array]]:
    """Variables of mean, largest and least mesh force (m,) [N] over the whole record, of which a part is kept."""
    return {
        "mesh_force_mean": ("mesh", mean),
        "mesh_force_peak": ("mesh", most),
        "mesh_force_minimum": ("mesh", least),
    }


def train_coefficient(values: Array) -> Array:
    """Coefficient of the train, the largest of its meshes: (definition, m) -> (definition,) [1]; nan where unknown."""
    known = np.isfinite(values).any(axis=1) | np.isinf(values).any(axis=1)
    return np.where(known, np.max(np.where(np.isnan(values), -np.inf, values), axis=1), np.nan)


def labelled(
    system: System,
    *,
    coefficients: Array,
    ratio: Array,
    force: Array,
    bound: Array,
    columns: Mapping[str, Any],
    time: Array,
    options: Mapping[str, object],
    provenance: Mapping[str, str],
    warnings: Sequence[CodedText],
) -> xr.Dataset:
    """The result of `sharing`.

    Parameters
    ----------
    coefficients : (definition, m) [1].  ratio : (m, T) simultaneous ratio [1].  force : (m, T) [N].  bound : (m,) [N].
    columns : further variables.  time : (T,) [s], or mesh cycles where the train has no speed.
    options : attributes of the result as well.
    """
    from ...results.dataset import dataset

    names = faces(system.meshes).name
    coords: dict[Hashable, Any] = {
        "definition": np.array(DEFINITIONS, dtype=object),
        "mesh": np.array(names, dtype=object),
        "time": time,
    }
    if "group_force" in columns:
        coords["group"] = np.array([group.name for group in system.groups], dtype=object)
    result = dataset(
        {
            "load_sharing": (("definition", "mesh"), coefficients),
            "system_load_sharing": ("definition", train_coefficient(coefficients)),
            "load_sharing_history": (("mesh", "time"), ratio),
            "mesh_force": (("mesh", "time"), force),
            "mesh_force_bound": ("mesh", bound),
            **columns,
        },
        coords,
        verb="sharing",
        options=options,
        provenance=provenance,
        warnings=[*system.warnings, *warnings, *_undefined(names, coefficients, str(options.get("method", "")))],
    )
    result["time"].attrs.update({"units": "s" if system.tones else "mesh cycles", "long_name": "time"})
    # a netCDF attribute holds 64 bits
    result.attrs.update({name: str(v) if isinstance(v, int) and v >= 2**63 else v for name, v in options.items()})
    result.attrs["groups"] = json.dumps([[names[i] for i in group] for group in parallel_meshes(system.meshes)])
    return result
