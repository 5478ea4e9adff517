"""Load sharing from a record of static equilibria: with laws of links or meshes, or a record in turns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...statics.quasi_static import RecordPiece, held_train, quasi_static
from ...statics.record import MeshGroup, Record, parallel_meshes, positive_count
from ...statics.static import (
    contact_shares,
    flank_contact,
    free_position_warnings,
    group_columns,
    law_attributes,
    mesh_contact,
    rounding_of,
)
from ...system.gaps import flanks, groups_past_the_end, past_the_end
from ...system.system import Array, System, faces
from .definitions import Extremes, coefficients, cycle_peak_ratio, instant_ratio
from .outputs import (
    bound_warnings,
    far_warnings,
    force_columns,
    known_mean_loads,
    labelled,
    meshes_with_load,
    sharing_warnings,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["cycle_starts", "record_extremes", "sharing_of_record"]

# Instants stored by default: a few MB.
_STORED = 20_000
# Why the largest force over all phases is not known.
_PART = "the record is shorter than the common period"


def sharing_of_record(
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
    Meshes of a group that carries its mean load on the far flanks share that load: their coefficients take the force
    on the far flanks as positive, ``mesh_force`` does not.

    Parameters
    ----------
    record : its instants.  stored : units kept of forces and ratios, all up to 20 000 instants where None.

    Raises
    ------
    ModelError : no load, or a load that nothing balances or holds.  ConvergenceError : no equilibrium.
    """
    kept = positive_count("stored_cycles", stored, max(1, min(record.count, _STORED // record.samples)))
    train = held_train(system)
    forces: list[tuple[Array, Array]] = []
    pieces: list[RecordPiece] = []
    links: list[Array] = []
    for piece in quasi_static(train, record, progress):
        if sum(len(loaded) for loaded, _ in forces) < kept * record.samples:
            pieces.append(piece)
        forces.append((piece.state.mesh_force, piece.state.far_force))
        links.append(system.laws.rows.size(piece.state.group_force).max(axis=0, initial=0.0))
    contact = flank_contact(system, forces)
    members, face = parallel_meshes(system.meshes), faces(system.meshes)
    net = face.total(contact.force, axis=1)
    turned = _turned(net.mean(axis=0), members)
    force = net * turned
    mean, most = force.mean(axis=0), np.abs(force).max(axis=0)
    loaded = meshes_with_load(mean, members, most=most, rounding=rounding_of(system))
    over = record_extremes(force, members, [cycle_starts(system, group, record) for group in members])
    whole = record.count >= record.period
    worst = over.cycle_peak if whole else np.full(len(face.name), np.nan)
    mean_load, unknown = known_mean_loads(system)
    values = np.where(loaded, coefficients(over, worst, mean_load, members), np.nan)
    touching = mesh_contact(face, contact)
    lost = face.any(np.asarray(~contact.loaded.all(axis=0)))
    notes = [
        *free_position_warnings(system, train.loaded.free),
        *record.warnings(net.min(axis=0), net.max(axis=0)),
        *unknown,
    ]
    notes += sharing_warnings(face.name, np.asarray(~touching.all(axis=0)), loaded)
    notes += far_warnings(face.name, face.any(np.asarray(contact.far.any(axis=0))))
    most_known = np.where(whole, net.max(axis=0), np.nan)
    notes += bound_warnings(face.name, most_known, [_PART] * len(face.name))
    notes += past_the_end(system, flanks(system), contact.largest)
    notes += groups_past_the_end(system, np.max(links, axis=0)) if system.groups else []
    last = min(kept, record.count) * record.samples
    ratio = np.empty_like(force[:last])
    for group in members:
        ratio[:, group] = instant_ratio(force[:last, group].T).T
    laws = {name: (dims, array[:, :last]) for name, (dims, array) in group_columns(system, pieces).items()}
    return labelled(
        system,
        coefficients=values,
        ratio=ratio.T,
        force=net[:last].T,
        bound=most_known,
        columns={
            "mesh_contact": (("mesh", "time"), touching[:last].T),
            "contact_lost": ("mesh", lost),
            **contact_shares(system, face, contact),
            **force_columns(net.mean(axis=0), net.max(axis=0), net.min(axis=0)),
            **laws,
        },
        time=np.arange(last) / record.samples / (float(record.unit) * relative_speed),
        options=_options(record, relative_speed),
        provenance={**system.provenance, **law_attributes(system, record)},
        warnings=notes,
    )


def _turned(mean: Array, members: Sequence[MeshGroup]) -> Array:
    """-1 at the meshes (m,) of groups whose mean load [N] is on their far flanks, else 1."""
    turned = np.ones(len(mean))
    for group in members:
        turned[group] = -1.0 if mean[group].sum() < 0 else 1.0
    return turned


def _options(record: Record, relative_speed: float) -> dict[str, object]:
    """Options of the record as the result states them."""
    return {
        "method": "static",
        "cycles" if record.name == "mesh cycles" else record.name: record.count,
        "samples": record.samples,
        "relative_speed": relative_speed,
        "record": f"{record.count} {record.name}, {record.instants} instants",
        "common_period": record.period,
        "worst_case": "every cycle of the common period" if record.count >= record.period else "not known",
    }


def record_extremes(force: Array, members: Sequence[MeshGroup], starts: Sequence[NDArray[np.int64]]) -> Extremes:
    """Extremes over a record (T, m) [N] whose mesh cycles start at given instants (cycles,), for each group its own."""
    high, low, together = (np.full(force.shape[1], fill) for fill in (-np.inf, np.inf, -np.inf))
    for group, start in zip(members, starts, strict=True):
        mine = force[:, group]
        ratio = cycle_peak_ratio(np.maximum.reduceat(mine, start, axis=0), [np.arange(len(group))])
        high[group], low[group] = ratio.max(axis=0), ratio.min(axis=0)
        shares = instant_ratio(mine.T)
        together[group] = np.where(np.isnan(shares), np.inf, shares).max(axis=1)
    return Extremes(
        ratio_high=high, ratio_low=low, simultaneous=together, peak=force.max(axis=0), least=force.min(axis=0)
    )


def cycle_starts(system: System, group: MeshGroup, record: Record) -> NDArray[np.int64]:
    """First instant of every mesh cycle of a group that holds any, (cycles,), exact."""
    tone = system.tones[int(system.meshes.tone[faces(system.meshes).first[group[0]]])] if system.tones else Fraction(1)
    ratio = tone / record.unit / record.samples
    cycle = np.arange(record.instants, dtype=object) * ratio.numerator // ratio.denominator
    changed = np.flatnonzero(np.diff(cycle.astype(np.int64))) + 1
    return np.concatenate([[0], changed]).astype(np.int64)
