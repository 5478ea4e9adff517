"""Linearisation of the laws of links: every bearing and spline by its tangent at the mean load.

Modes and linear response stand on the linearised System; derived here from the laws of `system.laws`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...system.laws.groups import STATES, LawGroup, Laws
from ...system.symmetry import commutes
from ...system.system import Array, Line, LinkRows, System
from .equilibrium import Equilibrium, compliance_of, equilibrium, require_balance
from .record import group_gap

__all__ = ["linearised", "mean_stretch", "small_motion_tangent"]


def linearised(system: System) -> System:
    """The system with tangents in place of laws, at the static state under the mean load; itself where it has none.

    The mean load is what stands still in the stage's frame, with mean mesh stiffness.  A spline with Coulomb friction
    sticks in small vibration and keeps its elastic stiffness.  Each law becomes two links, along its load and across
    it (``/radial``, ``/tangential``), or the one row it has; the warnings name the stiffness taken.  Forces of the
    laws at the mean state stay, so that the mean of the linear system is that of the system with laws.

    Raises
    ------
    ModelError, ConvergenceError : the mean load has no equilibrium.
    """
    if not system.groups:
        return system
    mean = _mean_state(system)
    rows, stretch = system.group_rows, mean.group_stretch[0]
    tangent = small_motion_tangent(system.laws, stretch)
    lag = np.repeat([group.lag for group in system.groups], [len(group.rows) for group in system.groups])
    K, C = rows @ tangent @ rows.T, rows @ (lag[:, None] * tangent) @ rows.T
    axes_of_groups = [_axes(group, part) for group, part in zip(system.groups, _by_group(system, stretch), strict=True)]
    result = replace(
        system,
        K=system.K + K,
        C=system.C + C,
        links=_linearised_links(system, tangent, axes_of_groups, mean.group_force[0] - tangent @ stretch),
        force=system.force + rows @ (tangent @ stretch - mean.group_force[0]),
        lines=tuple(_linearised_line(line, rows, tangent, lag, axes_of_groups, system) for line in system.lines),
        warnings=(*system.warnings, *_law_warnings(system, stretch, tangent, axes_of_groups)),
        groups=(),
    )
    held = tuple(replace(s, holds=s.holds and commutes(s.operator, result.mean_stiffness)) for s in system.symmetries)
    return replace(result, symmetries=held)


def small_motion_tangent(laws: Laws, stretch: Array) -> Array:
    """Tangent (R, R) [N/m] of the laws for small vibration about a stretch (R,) [m]; laws with a memory stick."""
    sticking = laws.rows.spread(laws.memory)
    return np.where(sticking[:, None], np.diag(laws.row_stiffness), laws.tangent(stretch))


def mean_stretch(system: System) -> Array:
    """Stretch of every row of the groups under what stands still, (R,) [m].

    Raises
    ------
    ModelError, ConvergenceError : as of `linearised`.
    """
    stretch: Array = _mean_state(system).group_stretch[0]
    return stretch


def _mean_state(system: System) -> Equilibrium:
    """Equilibrium under the mean load and errors, with mean mesh stiffness."""
    flexible = compliance_of(system)
    still = [line for line in system.lines if line.frequency == 0]
    force = system.force + sum((line.force[0].real for line in still), np.zeros(len(system.force)))
    gap = np.zeros(len(flexible.stiffness))
    for line in still:
        gap += np.concatenate([line.gap, group_gap(line, system.group_rows.shape[1])]).real
    require_balance(flexible.free, force[None], system.dofs.names)
    return equilibrium(
        flexible, stiffness=system.meshes.stiffness[None], gap=gap[None], force=force[None], laws=system.laws
    )


def _by_group(system: System, rows: Array) -> list[Array]:
    """Values (R,) of all rows, split by group."""
    return np.split(rows, system.laws.rows.first[1:])


def _axes(group: LawGroup, stretch: Array) -> Array:
    """Unit vectors along the stretch (r,) [m] and across it as columns, (r, r); x and y where there is none."""
    length = float(np.linalg.norm(stretch))
    if len(group.rows) == 1 or length == 0:
        return np.eye(len(group.rows))
    x, y = stretch / length
    return np.array([[x, -y], [y, x]])


def _linearised_links(system: System, tangent: Array, axes_of_groups: list[Array], offset: Array) -> LinkRows:
    """The links of the system and two for every group, with the group's tangent and the preload `offset` (R,) [N]."""
    links, laws = system.links, system.laws
    names: list[str] = []
    columns, stiffness, damping = [links.B], [links.stiffness], [links.damping]
    preload = [links.preload if links.preload.size else np.zeros(len(links.name))]
    for group, axes, first in zip(system.groups, axes_of_groups, laws.rows.first, strict=True):
        block = tangent[first : first + len(axes), first : first + len(axes)]
        values = np.diag(axes.T @ block @ axes)
        names += [f"{group.name}/radial", f"{group.name}/tangential"] if len(axes) == 2 else group.rows
        columns.append(group.B @ axes)
        stiffness.append(values)
        preload.append(axes.T @ offset[first : first + len(axes)])
        damping.append(np.diag(axes.T @ np.diag(group.damping) @ axes) + group.lag * values)
    return LinkRows(
        name=(*links.name, *names),
        link=(*links.link, *(group.name for group in system.groups for _ in group.rows)),
        B=np.concatenate(columns, axis=1),
        stiffness=np.concatenate(stiffness),
        damping=np.concatenate(damping),
        skew=_padded_skew(links.skew, sum(map(len, stiffness))),
        preload=np.concatenate(preload),
    )


def _padded_skew(skew: Array, size: int) -> Array:
    """A skew matrix (p, p) [N/m] with zeros for rows added behind, (size, size); empty where it is."""
    return np.pad(skew, (0, size - len(skew))) if skew.size else skew


def _linearised_line(
    line: Line, rows: Array, tangent: Array, lag: Array, axes_of_groups: list[Array], system: System
) -> Line:
    """A line whose errors in laws act as forces through the tangents (R, R) [N/m] and their dampers."""
    gap = group_gap(line, system.group_rows.shape[1])
    push = rows @ (tangent @ gap)
    force = line.force.copy()
    force[0] += push
    force[1] += 2j * math.pi * float(line.frequency) * (rows @ (lag * (tangent @ gap)))
    parts = [
        axes.T @ part for axes, part in zip(axes_of_groups, np.split(gap, system.laws.rows.first[1:]), strict=True)
    ]
    return replace(
        line, force=force, link_gap=np.concatenate([line.link_gap, *parts]), group_gap=np.zeros(0, dtype=complex)
    )


def _law_warnings(system: System, stretch: Array, tangent: Array, axes_of_groups: list[Array]) -> list[str]:
    """Warnings that name the stiffness [N/m] in place of each law at a stretch (R,) [m].

    Groups of one text together.
    """
    state = system.laws.state(stretch)
    groups_by_text: dict[str, list[str]] = {}
    for group, axes, first, doing in zip(system.groups, axes_of_groups, system.laws.rows.first, state, strict=True):
        block = tangent[first : first + len(axes), first : first + len(axes)]
        values = np.diag(axes.T @ block @ axes)
        if STATES[doing] == "play":
            text = "inside its clearance under the mean load, stiffness 0"
        elif group.law.memory:
            text = f"sticks in small vibration, stiffness {group.law.stiffness:.4g} N/m"
        else:
            across = f", across {values[1]:.4g} N/m" if len(values) == 2 else ""
            text = f"at the mean load in {STATES[doing]}, stiffness along it {values[0]:.4g} N/m{across}"
        groups_by_text.setdefault(f"{group.law.kind} {text}", []).append(group.name)
    return [f"linearised: {', '.join(names)}: {text}" for text, names in groups_by_text.items()]
