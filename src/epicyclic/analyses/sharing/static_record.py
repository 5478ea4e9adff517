"""Load sharing from a record of equilibria, one after the other: with laws, several mesh frequencies, or a window."""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.faces import faces
from ...system.system import Array, System
from ..static.equilibrium import compliance_of
from ..static.quasi_static import Piece, trace
from ..static.record import Record, positive
from ..static.static import OPEN, free_position_warnings, group_columns, law_attributes, whole_contact
from .definitions import DEFINITIONS, Group, Tally, coefficients, cycle_ratio, groups, simultaneous

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["carries_load", "cycle_starts", "record_tally", "recorded", "require_speed", "share_notes", "total"]

# instants stored by default: a few MB
_STORED = 20_000


def recorded(
    system: System,
    *,
    record: Record,
    relative_speed: float,
    stored: int | None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Load-sharing coefficients over a record of static equilibria.

    A mesh cycle is that of the group's own mesh frequency; where fewer instants than one fall into a cycle, each is
    its own peak.  The worst case is known where the record covers the common period of all lines, else it is nan.

    Parameters
    ----------
    record : its instants.  stored : units kept of forces and ratios, all up to 20 000 instants where None.

    Raises
    ------
    ModelError : no load, or a load that nothing balances or holds.  ConvergenceError : no equilibrium.
    """
    kept = positive("stored_cycles", stored, max(1, min(record.count, _STORED // record.samples)))
    flexible = compliance_of(system)
    forces: list[Array] = []
    pieces: list[Piece] = []
    for piece in trace(system, flexible, record, progress):
        if sum(map(len, forces)) < kept * record.samples:
            pieces.append(piece)
        forces.append(piece.state.mesh_force)
    rows, members, face = np.concatenate(forces), groups(system.meshes), faces(system.meshes)
    force = face.total(rows, axis=1)
    loaded = carries_load(force.mean(axis=0), members)
    tally = record_tally(force, members, [cycle_starts(system, group, record) for group in members])
    whole = record.count >= record.period
    worst = 1.0 + np.maximum(tally.ratio_high - 1.0, 1.0 - tally.ratio_low)
    values = np.where(loaded, coefficients(tally, worst if whole else np.full_like(worst, np.nan), members), np.nan)
    touching = whole_contact(face, rows > OPEN * rows.max(initial=0.0))
    notes = [*free_position_warnings(system, flexible.free), *record.notes]
    notes += share_notes(face.name, np.asarray(~touching.all(axis=0)), loaded)
    return _dataset(
        system,
        record,
        (values, np.where(whole, tally.peak, np.nan), force, touching),
        pieces,
        min(kept, record.count) * record.samples,
        relative_speed,
        notes,
    )


def record_tally(force: Array, members: Sequence[Group], starts: Sequence[NDArray[np.int64]]) -> Tally:
    """Extremes over a record (T, m) whose mesh cycles start at given instants, for each group its own."""
    high, low, together = (np.full(force.shape[1], fill) for fill in (-np.inf, np.inf, -np.inf))
    for group, start in zip(members, starts, strict=True):
        mine = force[:, group]
        ratio = cycle_ratio(np.maximum.reduceat(mine, start, axis=0), [np.arange(len(group))])
        high[group], low[group] = ratio.max(axis=0), ratio.min(axis=0)
        shares = simultaneous(mine.T)
        together[group] = np.where(np.isnan(shares), np.inf, shares).max(axis=1)
    return Tally(ratio_high=high, ratio_low=low, simultaneous=together, peak=force.max(axis=0), least=force.min(axis=0))


def cycle_starts(system: System, group: Group, record: Record) -> NDArray[np.int64]:
    """First instant of every mesh cycle of a group that holds any, exact."""
    tone = system.tones[int(system.meshes.tone[faces(system.meshes).first[group[0]]])] if system.tones else Fraction(1)
    ratio = tone / record.unit / record.samples
    cycle = np.arange(record.instants, dtype=object) * ratio.numerator // ratio.denominator
    changed = np.flatnonzero(np.diff(cycle.astype(np.int64))) + 1
    return np.concatenate([[0], changed]).astype(np.int64)


def require_speed(relative_speed: float) -> None:
    """Raise ModelError where the speed is not above zero."""
    if not relative_speed > 0:
        raise ModelError("must be above zero", path="relative_speed", given=relative_speed, allowed="> 0")


def carries_load(mean: Array, members: Sequence[Group]) -> NDArray[np.bool_]:
    """Meshes of groups that carry load in the mean, (m,), from mean forces (m,).

    Raises
    ------
    ModelError : none does.
    """
    # an idle group beside loaded ones carries rounding
    least = 1e-9 * float(np.max(np.abs(mean), initial=0.0))
    loaded = np.zeros(len(mean), dtype=bool)
    for group in members:
        loaded[group] = mean[group].sum() > least
    if not loaded.any():
        raise ModelError(
            "load sharing needs a load, and no mesh carries any", path="operation.torque", allowed="a torque"
        )
    return loaded


def share_notes(meshes: tuple[str, ...], open_: NDArray[np.bool_], loaded: NDArray[np.bool_]) -> list[str]:
    """Warnings of meshes that open, (m,), and of those without load."""

    def names(chosen: NDArray[np.bool_]) -> str:
        return ", ".join(name for name, yes in zip(meshes, chosen, strict=True) if yes)

    notes = [f"meshes open: {names(open_)}"] if open_.any() else []
    if not loaded.all():
        notes.append(f"no load, hence no load sharing, in {names(~loaded)}")
    return notes


def total(values: Array) -> Array:
    """Coefficient of the train, the largest of its meshes, by definition (d, m) -> (d,); nan where none is known."""
    known = np.isfinite(values).any(axis=1) | np.isinf(values).any(axis=1)
    return np.where(known, np.max(np.where(np.isnan(values), -np.inf, values), axis=1), np.nan)


def _dataset(
    system: System,
    record: Record,
    found: tuple[Array, Array, Array, NDArray[np.bool_]],
    pieces: list[Piece],
    stored: int,
    relative_speed: float,
    notes: list[str],
) -> xr.Dataset:
    from ...results.dataset import dataset

    values, largest, force, touching = found
    members, names = groups(system.meshes), faces(system.meshes).name
    ratio = np.empty_like(force[:stored])
    for group in members:
        ratio[:, group] = simultaneous(force[:stored, group].T).T
    options: dict[str, object] = {
        "method": "static",
        "cycles" if record.name == "mesh cycles" else record.name: record.count,
        "samples": record.samples,
        "relative_speed": relative_speed,
        "record": f"{record.count} {record.name}, {record.instants} instants",
        "common_period": record.period,
        "worst_case": "every cycle of the common period" if record.count >= record.period else "not known",
    }
    coords: dict[Hashable, np.ndarray] = {
        "definition": np.array(DEFINITIONS, dtype=object),
        "mesh": np.array(names, dtype=object),
        "time": np.arange(stored) / record.samples / (float(record.unit) * relative_speed),
    }
    laws = {name: (dims, array[:, :stored]) for name, (dims, array) in group_columns(system, pieces).items()}
    if laws:
        coords["group"] = np.array([group.name for group in system.groups], dtype=object)
    result = dataset(
        {
            "load_sharing": (("definition", "mesh"), values),
            "system_load_sharing": ("definition", total(values)),
            "load_sharing_history": (("mesh", "time"), ratio.T),
            "mesh_force": (("mesh", "time"), force[:stored].T),
            "mesh_force_bound": ("mesh", largest),
            "mesh_contact": (("mesh", "time"), touching[:stored].T),
            "contact_lost": ("mesh", ~touching.all(axis=0)),
            **laws,
        },
        coords,
        verb="sharing",
        options=options,
        provenance={**system.provenance, **law_attributes(system, record)},
        warnings=[*system.warnings, *notes],
    )
    result["time"].attrs.update({"units": "s" if system.tones else "mesh cycles", "long_name": "time"})
    result.attrs.update({name: str(v) if isinstance(v, int) and v >= 2**63 else v for name, v in options.items()})
    result.attrs["groups"] = json.dumps([[names[i] for i in group] for group in members])
    return result
