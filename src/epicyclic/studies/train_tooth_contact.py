"""Loaded tooth contact of all meshes of a train at once, in its own static equilibrium."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..analyses.static.contact_equilibrium import ContactEquilibrium, ContactProblem, contact_equilibrium
from ..analyses.static.equilibrium import Compliance, compliance_of, equilibrium, require_balance
from ..analyses.static.record import Excitation, Record, excitation, positive_count, record_of, turn_fraction
from ..analyses.static.static import free_position_warnings, law_attributes
from ..assemble import assemble
from ..assemble.faces import FaceLoad, MeshFaceLaw, face_laws, with_three_rows
from ..assemble.tooth_pairs import tooth_warnings
from ..errors import ModelError
from ..results.dataset import dataset
from ..system.faces import faces
from ..system.system import System
from ..train.train import Train

__all__ = ["TORQUES", "train_contact"]

Array = NDArray[np.float64]

TORQUES = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
_PLACES = 81
# A mesh below this part of the largest force is open.
_NOTHING = 1e-7


def train_contact(
    train: Train,
    *,
    factors: Sequence[float] = TORQUES,
    cycles: int | None = 1,
    turns: int | None = None,
    of: str | None = None,
    samples: int = 32,
    slices: int = 20,
    linear_at: float | None = None,
    corner: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Contact of every mesh over a record: branches, sides and flanks share the load as the train lets them.

    Misalignment is what comes of the bodies' own tilt and twist, of pins and carrier, beside what deviations say.
    Springs of meshes play no part in the result.

    Parameters
    ----------
    factors : torques beside the operating ones, relative to them; weight and other loads stay.
    cycles, turns, of, samples : the record, as of `static`; one mesh cycle if nothing is said.
    slices : pieces of each face.  linear_at : load per length [N/m] at which the contact of the flanks is made linear;
        None: Hertz.  corner : let tips bear beyond the path of contact.  progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : no torque, no face width, options out of range, and all that `static` and `contact` refuse.
    ConvergenceError : no equilibrium.
    """
    levels = _levels(train, factors)
    case = _case(train, record=(None if turns or of else cycles, turns, of, positive_count("samples", samples, 32)))
    contacts = face_laws(train, slices=slices, linear_at=linear_at, corner=corner)
    ready = _ready(case, contacts)
    states: list[ContactEquilibrium] = []
    for i, level in enumerate(levels):
        states.append(_loaded(case, ready, float(level)))
        if progress is not None:
            progress((i + 1) / len(levels))
    loads = [_faces(case, contacts, ready, state) for state in states]
    now = int(np.argmin(np.abs(levels - 1.0)))
    force = np.array([_mesh_force(state) for state in states])
    options = {"samples": samples, "slices": slices, "linear_at": linear_at, "corner": corner}
    result = dataset(
        {
            **_forces(case.system, case.record, force),
            **_over_faces(case, contacts, loads, now),
            **_motion(case, states[now]),
            "contact_residual": ("torque_factor", np.array([state.contact_residual.max() for state in states])),
            "balance_residual": ("torque_factor", np.array([state.force_residual.max() for state in states])),
        },
        coords={
            "torque_factor": levels,
            "mesh": [mesh.name for mesh in train.meshes],
            "mesh_pair": list(dict.fromkeys(mesh.pair for mesh in train.meshes)),
            "width": (np.arange(slices) + 0.5) / slices,
            "flank_place": np.linspace(0.0, 1.0, _PLACES),
            "dof": list(case.system.dofs.names),
            "link_row": list(case.system.links.name),
            "time": np.arange(case.record.instants) / case.record.samples / float(case.record.unit),
        },
        verb="train_contact",
        options=options,
        warnings=_warnings(case, contacts, force[now]),
        provenance={**case.system.provenance, **law_attributes(case.system, case.record)},
    )
    result["time"].attrs.update({"units": "s" if case.system.tones else "mesh cycles", "long_name": "time"})
    result.attrs["torques"] = json.dumps(dict(train.torques))
    return result


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Case:
    """A train with three rows a mesh, what acts on it at the instants of a record, and the mesh cycles there (T, w)."""

    system: System
    flexible: Compliance
    record: Record
    acting: Excitation
    cycles: Array


_Ready = Sequence[tuple[Any, NDArray[np.int64]]]


def _levels(train: Train, factors: Sequence[float]) -> Array:
    levels = np.array(sorted({1.0, *(float(factor) for factor in factors)}))
    if not (np.isfinite(levels).all() and (levels > 0).all()):
        raise ModelError("relative torques", path="loads", given=list(factors), allowed="above 0")
    if not any(train.torques.values()):
        raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")
    return levels


def _case(train: Train, *, record: tuple[int | None, int | None, str | None, int]) -> _Case:
    system = assemble(with_three_rows(train))
    cycles, turned, of, samples = record
    over = record_of(system, cycles=cycles, turns=turned, of=of, samples=samples, most=64 * samples)
    index = np.arange(over.instants, dtype=np.int64)
    tones = system.tones or (over.unit,)
    phases = np.array([turn_fraction(tone / over.unit / over.samples, index) for tone in tones])
    first = faces(system.meshes).first
    flexible = compliance_of(system)
    acting = excitation(system, over.unit, index, over.samples)
    require_balance(flexible.free, acting.force, system.dofs.names)
    return _Case(
        system=system,
        flexible=flexible,
        record=over,
        acting=acting,
        cycles=phases[system.meshes.tone[first]].T,
    )


def _ready(case: _Case, contacts: Sequence[MeshFaceLaw]) -> _Ready:
    return [(one.at(case.cycles[:, list(one.meshes)]), np.array(one.meshes, np.int64)) for one in contacts]


def _loaded(case: _Case, ready: _Ready, factor: float) -> ContactEquilibrium:
    """Equilibrium at a multiple of the torques, from that of the train with springs for meshes."""
    acting = replace(case.acting, force=case.acting.force + (factor - 1.0) * case.system.force)
    springs = equilibrium(
        case.flexible, stiffness=acting.stiffness, gap=acting.gap, force=acting.force, laws=case.system.laws
    )
    problem = ContactProblem(
        system=case.system, flexible=case.flexible, contacts=ready, gap=acting.gap, force=acting.force
    )
    return contact_equilibrium(problem, springs.displacement)


def _mesh_force(state: ContactEquilibrium) -> Array:
    """Forces (w, T)."""
    total: Array = state.row_force.reshape(len(state.row_force), -1, 3).sum(axis=2).T
    return total


def _faces(case: _Case, contacts: Sequence[MeshFaceLaw], ready: _Ready, state: ContactEquilibrium) -> list[FaceLoad]:
    rows = state.approach.reshape(len(state.approach), -1, 3)
    return [
        at.face(rows[:, list(one.meshes)], start)
        for one, (at, _), start in zip(contacts, ready, state.states, strict=True)
    ]


def _forces(system: System, record: Record, force: Array) -> dict[str, Any]:
    """Variables of the forces (F, w, T)."""
    face = faces(system.meshes)
    pair = np.array(system.meshes.pair, dtype=object)[face.first]
    branch = np.array(system.meshes.branch)[face.first]
    cycle = force.reshape(*force.shape[:2], record.count, record.samples).mean(axis=3)
    factor = np.ones((len(force), len(dict.fromkeys(pair))))
    share = np.ones(force.shape[:2])
    for column, name in enumerate(dict.fromkeys(pair)):
        mine = [np.flatnonzero((pair == name) & (branch == b)) for b in np.unique(branch[pair == name])]
        each = np.array([cycle[:, meshes].sum(axis=1) for meshes in mine])
        factor[:, column] = (len(mine) * each / each.sum(axis=0)).max(axis=(0, 2))
        for meshes in mine:
            mean = force[:, meshes].mean(axis=2)
            share[:, meshes] = mean / mean.sum(axis=1, keepdims=True)
    return {
        "mesh_force": (("torque_factor", "mesh", "time"), force),
        "branch_load_factor": (("torque_factor", "mesh_pair"), factor),
        "side_share": (("torque_factor", "mesh"), share),
    }


def _over_faces(
    case: _Case, contacts: Sequence[MeshFaceLaw], loads: Sequence[Sequence[FaceLoad]], now: int
) -> dict[str, Any]:
    """Variables along the faces of all meshes."""
    order = np.argsort([mesh for one in contacts for mesh in one.meshes])

    def gathered(parts: Sequence[Array]) -> Array:
        return np.concatenate(parts)[order]

    mean, largest, smallest = [], [], []
    for load in loads:
        mean.append(gathered([one.force.sum(axis=2).mean(axis=0) for one in load]))
        largest.append(gathered([np.nanmax(one.per_length, axis=(0, 2, 3)) for one in load]))
        smallest.append(gathered([np.nanmin(one.per_length, axis=(0, 2, 3)) for one in load]))
    slice_load = np.array(mean)
    span = gathered([np.full(len(one.meshes), one.pair.plane.width / one.pair.slices) for one in contacts])
    with np.errstate(invalid="ignore", divide="ignore"):
        factor = slice_load.max(axis=2) / slice_load.mean(axis=2)
    return {
        "face_load": (("torque_factor", "mesh", "width"), slice_load / span[:, None]),
        "face_load_factor": (("torque_factor", "mesh"), factor),
        "largest_load_per_length": (("torque_factor", "mesh"), np.array(largest)),
        "smallest_load_per_length": (("torque_factor", "mesh"), np.array(smallest)),
        "flank_load_per_length": (
            ("mesh", "width", "flank_place"),
            gathered([_on_flank(one) for one in loads[now]]),
        ),
    }


def _on_flank(load: FaceLoad) -> Array:
    """Load per length of all instants laid on the flank of one tooth, (g, K, places) from end to end of the path."""
    _, g, _, K = load.per_length.shape
    flank = np.full((g, K, _PLACES), np.nan)
    for mesh in range(g):
        on = np.isfinite(load.per_length[:, mesh])
        at, value = load.sigma[:, mesh], load.per_length[:, mesh]
        # what every slice of the face reaches
        low = max(at[:, :, k][on[:, :, k]].min() for k in range(K))
        high = min(at[:, :, k][on[:, :, k]].max() for k in range(K))
        place = np.linspace(low, high, _PLACES)
        for k in range(K):
            mine = on[:, :, k]
            order = np.argsort(at[:, :, k][mine])
            sorted_at, sorted_value = at[:, :, k][mine][order], value[:, :, k][mine][order]
            flank[mesh, k] = np.interp(place, sorted_at, sorted_value, left=np.nan, right=np.nan)
    return flank


def _motion(case: _Case, state: ContactEquilibrium) -> dict[str, Any]:
    links = case.system.links
    deflection = state.displacement @ links.B - case.acting.link_gap
    return {
        "displacement": (("dof", "time"), (state.displacement * case.system.dofs.radius).T),
        "link_force": (("link_row", "time"), (links.stiffness * deflection).T),
        "link_deflection": (("link_row", "time"), deflection.T),
    }


def _warnings(case: _Case, contacts: Sequence[MeshFaceLaw], force: Array) -> list[str]:
    system = case.system
    said = [text for one in contacts for text in tooth_warnings(one.pair)]
    open_ = (force <= _NOTHING * force.max(initial=0.0)).any(axis=1)
    names = [name for name, lost in zip(faces(system.meshes).name, open_, strict=True) if lost]
    if names:
        said.append(f"meshes open at some instants: {', '.join(names)}")
    if system.laws.memory.any():
        said.append("friction of splines has no history here: they follow their first pull")
    return [
        *system.warnings,
        *dict.fromkeys(said),
        *free_position_warnings(system, case.flexible.free),
        *case.record.warnings,
    ]
