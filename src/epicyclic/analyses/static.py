"""Quasi-static equilibrium over the record, meshes carrying pressure only, as a labelled Dataset."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from ..system.faces import Faces, faces
from ..system.system import Array, System
from .equilibrium import Compliance, compliance_of, equilibrium, require_balance
from .record import excitation, hunting_cycles, positive, reference_tone

if TYPE_CHECKING:
    import xarray as xr

Columns = dict[str, tuple[Sequence[str] | str, Any]]

__all__ = ["OPEN", "free_position_warnings", "period_cycles", "static"]

_CHUNK = 2048
# A mesh force below this part of the largest is an open mesh: of two that open together one may just touch, with a
# force that is rounding (1e-16 times mesh per support stiffness, 1e7).
OPEN = 1e-7
# A record of this many mesh cycles is drawn in full; longer ones are asked for with `cycles`.
_CYCLES = 64


def static(
    system: System,
    *,
    cycles: int | None = None,
    samples: int = 32,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Static state at every instant of a record, with meshes that open and all errors, shaft orders included.

    Loads at rest count (torques, gravity, forces, link errors times stiffness); inertia does not.  The far flanks are
    taken as never touching: backlash is not used here.  Displacements leave out motions without stiffness (the turning
    of the whole train).  The twist of a neck or shaft is the ``link_deflection`` of its rz row [rad], first body less
    second: of a neck, left less right.  Time runs at the operating speed; without speeds it is counted in mesh cycles.

    Parameters
    ----------
    cycles : mesh cycles of the first mesh; the hunting period, at most 64, where None.
    samples : instants per mesh cycle.  progress : called with the share done, 0..1.

    Raises
    ------
    ModelError : an option out of range, or a load that nothing balances or holds.
    ConvergenceError : the equilibrium was not found.
    """
    tone, period = reference_tone(system), period_cycles(system)
    samples = positive("samples", samples, 32)
    cycles = positive("cycles", cycles, min(period, _CYCLES))
    flexible = compliance_of(system)
    force, displacement, deflection = _solve(system, flexible, tone, cycles * samples, samples, progress)
    warnings = [*system.warnings, *free_position_warnings(system, flexible.free)]
    if cycles < period:
        warnings.append(f"record of {cycles} mesh cycles is shorter than the hunting period of {period}")
    lost = np.any(force <= OPEN * np.max(force, initial=0.0), axis=0)
    if np.any(lost):
        names = [name for name, open_ in zip(system.meshes.name, lost, strict=True) if open_]
        warnings.append(f"meshes open: {', '.join(names)}; bodies held by them alone have no unique position")
    return _dataset(system, tone, cycles, samples, (force, displacement, deflection, lost), warnings)


def period_cycles(system: System) -> int:
    """Exact common period of all lines and mesh frequencies, in cycles of the reference mesh."""
    tone = reference_tone(system)
    return hunting_cycles([f / tone for f in (*(line.frequency for line in system.lines), *system.tones)])


def free_position_warnings(system: System, free: Array) -> list[str]:
    """A warning where a body's place is not unique: a free motion (n, r) moves more than the turning of the train does.

    Turning leaves the lateral place of central bodies and the z, rx, ry of all bodies alone.
    """
    dofs = system.dofs
    lateral = np.array(
        [
            d in ("z", "rx", "ry") or (d in ("x", "y") and not re.match(r"[^/]+/[^/]+/\d+", b))
            for b, d in zip(dofs.body, dofs.direction, strict=True)
        ]
    )
    # columns are unit vectors: 1e-9 is rounding of the null space
    moved = np.abs(free) > 1e-9
    bodies = dict.fromkeys(b for b, yes in zip(dofs.body, np.any(moved, axis=1) & lateral, strict=True) if yes)
    if not bodies:
        return []
    return [f"position of {', '.join(bodies)} is not unique: no support holds it; mesh forces are"]


def _solve(
    system: System,
    flexible: Compliance,
    tone: Fraction,
    count: int,
    samples: int,
    progress: Callable[[float], None] | None,
) -> tuple[Array, Array, Array]:
    """Mesh forces (count, m), displacements (count, n) and deflections of the links (count, p)."""
    parts = []
    for first in range(0, count, _CHUNK):
        index = np.arange(first, min(first + _CHUNK, count), dtype=np.int64)
        here = excitation(system, tone, index, samples)
        require_balance(flexible.free, here.force, system.dofs.names)
        state = equilibrium(flexible, stiffness=here.stiffness, gap=here.gap, force=here.force)
        parts.append((state.mesh_force, state.displacement, state.displacement @ system.links.B - here.link_gap))
        if progress is not None:
            progress((index[-1] + 1) / count)
    force, displacement, deflection = (np.concatenate(part) for part in zip(*parts, strict=True))
    return force, displacement, deflection


def _dataset(
    system: System,
    tone: Fraction,
    cycles: int,
    samples: int,
    state: tuple[Array, Array, Array, np.ndarray],
    warnings: list[str],
) -> xr.Dataset:
    from ..results import dataset

    force, displacement, deflection, lost = state
    face = faces(system.meshes)
    result = dataset(
        {
            "mesh_force": (("mesh", "time"), face.total(force.T)),
            "displacement": (("dof", "time"), (displacement * system.dofs.radius).T),
            "link_force": (("link_row", "time"), (system.links.stiffness * deflection).T),
            "link_deflection": (("link_row", "time"), deflection.T),
            "contact_lost": ("mesh", face.any(lost)),
            **_along_the_face(system, face, force, lost),
        },
        {
            "mesh": np.array(face.name, dtype=object),
            **({"mesh_slice": np.array(system.meshes.name, dtype=object)[face.cut]} if face.cut.any() else {}),
            "dof": np.array(system.dofs.names, dtype=object),
            "link_row": np.array(system.links.name, dtype=object),
            "time": np.arange(cycles * samples) / samples / float(tone),
        },
        verb="static",
        options={"cycles": cycles, "samples": samples},
        provenance=system.provenance,
        warnings=warnings,
    )
    result["time"].attrs.update({"units": "s" if system.tones else "mesh cycles", "long_name": "time"})
    return result


def _along_the_face(system: System, face: Faces, force: Array, lost: np.ndarray) -> Columns:
    """What the slices of meshes carry; nothing where no mesh is cut.

    The face-load factor is n times the largest mean force of a slice per sum of all n: largest over mean load per
    width, as K_H beta of gear standards, with each slice's load taken as even; nan of a mesh in one piece.
    """
    if not face.cut.any():
        return {}
    mean = force.mean(axis=0)
    total = face.total(mean)
    largest = -face.least(-mean)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where((face.count > 1) & (total > 0), face.count * largest / total, np.nan)
    return {
        "face_load_factor": ("mesh", factor),
        "slice_force": (("mesh_slice", "time"), force.T[face.cut]),
        "slice_contact_lost": ("mesh_slice", lost[face.cut]),
    }
