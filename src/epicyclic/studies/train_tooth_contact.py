"""Loaded tooth contact of all meshes of a train at once, in the static equilibrium of the train."""

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
from ..analyses.static.record import Record, RecordExcitation, excitation, positive_count, record_of, turn_fraction
from ..analyses.static.static import free_position_warnings, law_attributes
from ..assemble import assemble
from ..assemble.faces import FaceLoad, MeshFaceLaw, face_laws, with_three_rows
from ..assemble.tooth_pairs import tooth_warnings
from ..errors import ModelError
from ..results.dataset import dataset
from ..system.faces import faces
from ..system.system import System
from ..train.train import Train
from .tooth_contact import flank_map

__all__ = ["TORQUES", "train_contact"]

Array = NDArray[np.float64]

TORQUES = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
"""Torques by default, relative to the operating ones [1]."""
# places along the path of contact of a flank map
_PLACES = 81
# mesh force per largest one below which a mesh is open: rounding of the equilibrium is far below
_OPEN_RATIO = 1e-7


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
    """Loaded contact of every mesh over a record: branches, sides and flanks share the load as the train lets them.

    Misalignment follows from tilt and twist of the bodies, of pins and carrier, and from deviations.  Mesh stiffnesses
    of the model have no part in the result.

    Parameters
    ----------
    factors : torques beside the operating ones, relative to them [1]; weight and other loads stay.
    cycles, turns, of, samples : the record, as of `static`; one mesh cycle by default.
    slices : segments of each face.
    linear_at : load per length [N/m] at which the contact of the flanks is linearised; None: Hertz.
    corner : solve corner contact, tips that bear beyond the path of contact.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : mesh_force [N] (torque_factor, mesh, time), face_load [N/m] (torque_factor, mesh, width), factors of face,
        side and branch (torque_factor, mesh or mesh_pair), flank_load_per_length [N/m] (mesh, width, flank_place),
        displacement [m, rad] (dof, time), link_force and link_deflection (link_row, time), relative residuals
        (torque_factor).

    Raises
    ------
    ModelError : no torque, no face width, options out of range, and all that `static` and `contact` refuse.
    ConvergenceError : no equilibrium.
    """
    levels = _levels(train, factors)
    case = _case(train, record=(None if turns or of else cycles, turns, of, positive_count("samples", samples, 32)))
    laws = face_laws(train, slices=slices, linear_at=linear_at, corner=corner)
    contacts = _face_contacts(case, laws)
    states: list[ContactEquilibrium] = []
    for i, level in enumerate(levels):
        states.append(_equilibrium(case, contacts, float(level)))
        if progress is not None:
            progress((i + 1) / len(levels))
    loads = [_face_loads(laws, contacts, state) for state in states]
    operating = int(np.argmin(np.abs(levels - 1.0)))
    force = np.array([_mesh_force(state) for state in states])
    options = {"samples": samples, "slices": slices, "linear_at": linear_at, "corner": corner}
    result = dataset(
        {
            **_force_columns(case.system, case.record, force),
            **_face_columns(laws, loads, operating),
            **_motion_columns(case, states[operating]),
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
        warnings=_warnings(train, case, laws, force[operating]),
        provenance={**case.system.provenance, **law_attributes(case.system, case.record)},
    )
    result["time"].attrs.update({"units": "s" if case.system.tones else "mesh cycles", "long_name": "time"})
    result.attrs["torques"] = json.dumps(dict(train.torques))
    return result


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Case:
    """A train with three rows a mesh over a record of T instants.

    flexible : its compliance without meshes.  acting : stiffness, errors and loads at the instants.
    cycles : (T, w) time of each of w meshes [mesh cycles].
    """

    system: System
    flexible: Compliance
    record: Record
    acting: RecordExcitation
    cycles: Array


# contact of equal meshes at all instants, and the numbers of these meshes
_FaceContacts = Sequence[tuple[Any, NDArray[np.int64]]]


def _levels(train: Train, factors: Sequence[float]) -> Array:
    """Torque factors (F,) [1] rising, the operating one among them."""
    levels = np.array(sorted({1.0, *(float(factor) for factor in factors)}))
    if not (np.isfinite(levels).all() and (levels > 0).all()):
        raise ModelError("relative torques", path="loads", given=list(factors), allowed="above 0")
    if not any(train.torques.values()):
        raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")
    return levels


def _case(train: Train, *, record: tuple[int | None, int | None, str | None, int]) -> _Case:
    """Train, loads and phases over a record of (cycles, turns, of, samples)."""
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


def _face_contacts(case: _Case, laws: Sequence[MeshFaceLaw]) -> _FaceContacts:
    """Contact segments of all meshes at all instants."""
    return [(law.at(case.cycles[:, list(law.meshes)]), np.array(law.meshes, np.int64)) for law in laws]


def _equilibrium(case: _Case, contacts: _FaceContacts, factor: float) -> ContactEquilibrium:
    """Equilibrium at a multiple of the torques; Newton starts from that of the train with springs for meshes."""
    acting = replace(case.acting, force=case.acting.force + (factor - 1.0) * case.system.force)
    springs = equilibrium(
        case.flexible, stiffness=acting.stiffness, gap=acting.gap, force=acting.force, laws=case.system.laws
    )
    problem = ContactProblem(
        system=case.system, flexible=case.flexible, contacts=contacts, gap=acting.gap, force=acting.force
    )
    return contact_equilibrium(problem, springs.displacement)


def _mesh_force(state: ContactEquilibrium) -> Array:
    """Forces of the meshes along the tooth normal, (w, T) [N]."""
    total: Array = state.row_force.reshape(len(state.row_force), -1, 3).sum(axis=2).T
    return total


def _face_loads(laws: Sequence[MeshFaceLaw], contacts: _FaceContacts, state: ContactEquilibrium) -> list[FaceLoad]:
    """Load along the faces of the meshes of each law."""
    rows = state.approach.reshape(len(state.approach), -1, 3)
    return [
        at.face(rows[:, list(law.meshes)], start)
        for law, (at, _), start in zip(laws, contacts, state.states, strict=True)
    ]


def _force_columns(system: System, record: Record, force: Array) -> dict[str, Any]:
    """Mesh forces (F, w, T) [N], and how branches and sides share them [1]."""
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
            whole = mean.sum(axis=1, keepdims=True)
            # a branch that carries nothing at a small torque has no share
            share[:, meshes] = np.where(whole > 0, mean / np.where(whole > 0, whole, 1.0), np.nan)
    return {
        "mesh_force": (("torque_factor", "mesh", "time"), force),
        "branch_load_factor": (("torque_factor", "mesh_pair"), factor),
        "side_share": (("torque_factor", "mesh"), share),
    }


def _face_columns(laws: Sequence[MeshFaceLaw], loads: Sequence[Sequence[FaceLoad]], operating: int) -> dict[str, Any]:
    """Variables along the faces of all meshes; loads : at each torque, by law; operating : index of that torque."""
    order = np.argsort([mesh for law in laws for mesh in law.meshes])

    def gathered(parts: Sequence[Array]) -> Array:
        """Values (g, ...) of the meshes of each law as one array (w, ...) in the order of the meshes."""
        return np.concatenate(parts)[order]

    mean, largest, smallest = [], [], []
    for load in loads:
        mean.append(gathered([one.force.sum(axis=2).mean(axis=0) for one in load]))
        largest.append(gathered([np.nanmax(one.per_length, axis=(0, 2, 3)) for one in load]))
        smallest.append(gathered([np.nanmin(one.per_length, axis=(0, 2, 3)) for one in load]))
    slice_load = np.array(mean)
    span = gathered([np.full(len(law.meshes), law.pair.plane.width / law.pair.slices) for law in laws])
    with np.errstate(invalid="ignore", divide="ignore"):
        factor = slice_load.max(axis=2) / slice_load.mean(axis=2)
    return {
        "face_load": (("torque_factor", "mesh", "width"), slice_load / span[:, None]),
        "face_load_factor": (("torque_factor", "mesh"), factor),
        "largest_load_per_length": (("torque_factor", "mesh"), np.array(largest)),
        "smallest_load_per_length": (("torque_factor", "mesh"), np.array(smallest)),
        "flank_load_per_length": (
            ("mesh", "width", "flank_place"),
            gathered([_flank_maps(one) for one in loads[operating]]),
        ),
    }


def _flank_maps(load: FaceLoad) -> Array:
    """Load per length of all instants laid on the flank of one tooth, (g, K, P) [N/m] from end to end of the path."""
    maps = []
    for mesh in range(load.per_length.shape[1]):
        sigma, value = load.sigma[:, mesh], load.per_length[:, mesh]
        loaded = np.isfinite(value)
        # stretch of the path that every slice of the face reaches
        slices = range(value.shape[2])
        low = max(sigma[:, :, k][loaded[:, :, k]].min() for k in slices)
        high = min(sigma[:, :, k][loaded[:, :, k]].max() for k in slices)
        maps.append(flank_map(sigma, value, loaded, np.linspace(low, high, _PLACES)))
    return np.array(maps)


def _motion_columns(case: _Case, state: ContactEquilibrium) -> dict[str, Any]:
    """Displacement of every degree of freedom (n, T) [m, rad], force and deflection of every link row (p, T)."""
    links = case.system.links
    deflection = state.displacement @ links.B - case.acting.link_gap
    return {
        "displacement": (("dof", "time"), (state.displacement * case.system.dofs.radius).T),
        "link_force": (("link_row", "time"), (links.stiffness * deflection).T),
        "link_deflection": (("link_row", "time"), deflection.T),
    }


def _warnings(train: Train, case: _Case, laws: Sequence[MeshFaceLaw], force: Array) -> list[str]:
    """Warnings of train, teeth and record, and the meshes that open; force : (w, T) of the meshes [N]."""
    system = case.system
    messages = [text for law in laws for text in tooth_warnings(law.pair, train.meshes[law.meshes[0]])]
    parted = (force <= _OPEN_RATIO * force.max(initial=0.0)).any(axis=1)
    names = [name for name, lost in zip(faces(system.meshes).name, parted, strict=True) if lost]
    if names:
        messages.append(f"meshes open at some instants: {', '.join(names)}")
    if system.laws.memory.any():
        messages.append("friction of splines has no history here: they follow their first pull")
    return [
        *system.warnings,
        *dict.fromkeys(messages),
        *free_position_warnings(system, case.flexible.free),
        *case.record.warnings,
    ]
