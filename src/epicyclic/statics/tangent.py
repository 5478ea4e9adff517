"""The one door of linear analyses: tangents in place of the laws of gaps.

Those of links are taken here at the mean load; those of flanks are data of the System, at the load of their law.  Modes
and linear response stand on the linear System; derived here from the laws.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from ..errors import ConvergenceError, ModelError
from ..system.flank_laws import LawRows, LinearLaw
from ..system.link_laws import STATES, LawGroup, Laws
from ..system.system import Array, Line, LinkRows, MeshRows, System, commutes, faces
from ..warning_codes import CodedText, coded
from .equilibrium import Equilibrium, compliance_of, equilibrium, require_balance, thrust_named
from .record import Record, group_gap, hunting_cycles, reference_tone, standing_excitation
from .static import held_train, quasi_static

# Stiffness per nominal one of a link that floats in its clearance, for the mean system of analyses that ask its law:
# its motion is a million times slower than that of a pressed one, and far from rounding of rigid modes (1e-11).
_FLOATING = 1e-6
# First touch [m] and relative error of a force below which a law is its tangent: rounding.
_NO_TOUCH, _NO_ERROR = 1e-15, 1e-9
# Phases of the mesh cycle at which a law stands beside its tangent: five a wave of the 12th order, the last of a table.
_PHASES = 64
# Mesh cycles, even over the common period of all lines, and instants of each, at which laws of links stand beside their
# tangents; a difference below this part of the largest force is none.
_CYCLES, _INSTANTS, _SAME = 64, 8, 1e-3
# Tangents along x and y, per their mean, that differ by no more have no axes of their own: rounding.
_ISOTROPIC = 1e-9
# Stiffness left along a direction, per that of the whole tangent, that is rounding.
_NOTHING = 1e-12
# What a law without a memory does at the mean load outside its clearance, in words.
_DOING = {"stick": "sticking", "slip": "sliding", "stop": "pressed"}


def linear(system: System, *, asks_laws: bool = False, floating: bool = False) -> System:
    """The system with tangents in place of laws, for linear analyses; itself where it has none.

    Flanks have the tangents that `MeshRows` and `FarFlanks` state and lose their laws.  The warnings say of every pair
    what its tangent leaves out, and of links which stiffness was taken.

    Parameters
    ----------
    asks_laws : the analysis asks the laws itself, or takes numbers alone and leaves warnings to its caller: flanks keep
        their laws, links have their tangents in K as always, and the warnings are of links with a memory alone.
    floating : of `small_motion_tangent`, for mean systems of analyses that ask the laws of links.

    Raises
    ------
    ModelError, ConvergenceError : the mean load has no equilibrium.
    """
    flanks_ready = system if asks_laws else _without_flank_laws(system)
    return _without_link_laws(flanks_ready, memory_alone=asks_laws, floating=floating)


def _without_flank_laws(system: System) -> System:
    """The system with flanks of linear laws alone; itself where it has no others."""
    meshes, far = system.meshes, system.far
    if not meshes.laws and (far is None or not far.laws):
        return system
    return replace(
        system,
        meshes=replace(meshes, laws=()),
        far=None if far is None else replace(far, laws=()),
        warnings=(*system.warnings, *flank_warnings(system)),
    )


def _without_link_laws(system: System, *, memory_alone: bool, floating: bool) -> System:
    """The system with tangents in place of the laws of links, at the static state under the mean load.

    memory_alone : warnings of links with a memory alone.  floating : of `small_motion_tangent`.

    The mean load is what stands still in the stage's frame, with mean mesh stiffness.  A spline with Coulomb friction
    sticks in small vibration and keeps its elastic stiffness.  Each law becomes two links, along its load and across
    it (``/radial``, ``/tangential``), or keeps its rows where it has one or is alike in x and y; the warnings name the
    stiffness taken.  Forces of the laws at the mean state stay, so that the mean of the linear system is that of the
    system with laws.

    Raises
    ------
    ModelError, ConvergenceError : the mean load has no equilibrium.
    """
    if not system.groups:
        return system
    laws, rows = _link_tangents(system, floating=floating), system.group_rows
    result = replace(
        system,
        K=system.K + rows @ laws.tangent @ rows.T,
        C=system.C + rows @ (laws.lag[:, None] * laws.tangent) @ rows.T,
        links=_linearised_links(system, laws),
        force=system.force - rows @ laws.offset,
        lines=tuple(_linearised_line(system, laws, line) for line in system.lines),
        scaled=tuple(_linearised_line(system, laws, line) for line in system.scaled),
        warnings=(*system.warnings, *_law_warnings(system, laws, memory_alone)),
        groups=(),
    )
    held = tuple(replace(s, holds=s.holds and commutes(s.operator, result.mean_stiffness)) for s in system.symmetries)
    return replace(result, symmetries=held)


class _GroupTangent(NamedTuple):
    """A group of r rows: which these are, names of its axes, the axes a_i as columns (r, r), and the stiffness k (r,).

    The tangent is sum_i k_i a_i a_i' [N/m, N m/rad].
    """

    group: LawGroup
    rows: slice
    names: tuple[str, ...]
    axes: Array
    stiffness: Array


class _LinkTangents(NamedTuple):
    """Laws of links at the mean state, of R rows.

    stretch : (R,) [m].  offset : (R,) force there beside that of the tangent [N].  tangent : (R, R) [N/m].
    lag : (R,) [s].
    """

    stretch: Array
    offset: Array
    tangent: Array
    lag: Array
    groups: list[_GroupTangent]


def _link_tangents(system: System, *, floating: bool) -> _LinkTangents:
    """Tangents of the laws of links at the mean state.

    Raises
    ------
    ModelError, ConvergenceError : the mean load has no equilibrium.
    """
    mean = _mean_state(system)
    stretch = mean.group_stretch[0]
    tangent = small_motion_tangent(system.laws, stretch, floating=floating)
    lag = np.repeat([group.lag for group in system.groups], [len(group.rows) for group in system.groups])
    begins = zip(system.groups, system.laws.rows.first, strict=True)
    slices = [(group, slice(first, first + len(group.rows))) for group, first in begins]
    groups = [_along_axes(group, rows, stretch[rows], tangent[rows, rows]) for group, rows in slices]
    return _LinkTangents(stretch, mean.group_force[0] - tangent @ stretch, tangent, lag, groups)


def linear_columns(system: System, columns: Sequence[Line]) -> tuple[Line, ...]:
    """Further lines of a system as lines of ``linear(system)``, whose tangents are those of the mean load without them.

    Raises
    ------
    ModelError, ConvergenceError : as of `linear`.
    """
    if not system.groups or not columns:
        return tuple(columns)
    laws = _link_tangents(system, floating=False)
    return tuple(_linearised_line(system, laws, line) for line in columns)


def small_motion_tangent(laws: Laws, stretch: Array, *, floating: bool = False) -> Array:
    """Tangent (R, R) [N/m] of the laws for small vibration about a stretch (R,) [m]; laws with a memory stick.

    floating : a link that is in its clearance, or slides, keeps a millionth of its stiffness where its tangent has
        less.  A motion that only its stops hold is then no rigid one of the mean system, whose laws would be dropped.
    """
    sticking = laws.rows.spread(laws.memory)
    tangent = np.where(sticking[:, None], np.diag(laws.row_stiffness), laws.tangent(stretch))
    if not floating:
        return tangent
    for group in range(laws.rows.first.size):
        rows = np.flatnonzero(laws.rows.owner == group)
        block, nominal = np.ix_(rows, rows), laws.row_stiffness[rows]
        if np.linalg.eigvalsh(tangent[block] / np.sqrt(np.outer(nominal, nominal)))[0] < _FLOATING:
            tangent[block] += _FLOATING * np.diag(nominal)
    return tangent


def mean_stretch(system: System) -> Array:
    """Stretch of every row of the groups under what stands still, (R,) [m].

    Raises
    ------
    ModelError, ConvergenceError : as of `linear`.
    """
    return np.asarray(_mean_state(system).group_stretch[0])


def _mean_state(system: System) -> Equilibrium:
    """Equilibrium under the mean load and errors, with mean mesh stiffness."""
    flexible, excited = compliance_of(system), standing_excitation(system)
    gap, force = excited[: len(flexible.stiffness)], excited[-len(system.force) :]
    require_balance(flexible.free, force[None], system)
    with thrust_named(system):
        return equilibrium(
            flexible, stiffness=system.meshes.stiffness[None], gap=gap[None], force=force[None], laws=system.laws
        )


def _along_axes(group: LawGroup, rows: slice, stretch: Array, tangent: Array) -> _GroupTangent:
    """A group by its stretch (r,) [m, rad] and tangent (r, r) [N/m, N/rad, N m/rad].

    x and y have axes along the stretch and across it, `_lateral_axes`, on which the forces are the lateral force of the
    group.  Directions z, rx, ry of a contact set follow one after the other, each with what the tangent holds where
    the axes before it give way: T = T - k a a' with k = e' T e and a = T e / k, e the direction (derived here).
    """
    axes, names = np.eye(len(stretch)), group.rows
    if len(stretch) == 2 or (len(stretch) > 2 and names[1].endswith("/y")):
        axes[:2, :2] = _lateral_axes(stretch[:2], tangent[:2, :2])
        if not np.array_equal(axes[:2, :2], np.eye(2)):
            names = (f"{group.name}/radial", f"{group.name}/tangential", *names[2:])
    stiffness, left = np.diag(axes.T @ tangent @ axes).copy(), tangent.copy()
    for i in range(len(stretch) if len(stretch) > 2 else 0):
        direction, whole = axes[:, i].copy(), stiffness[i]
        stiffness[i] = direction @ left @ direction
        if stiffness[i] <= _NOTHING * whole:
            stiffness[i] = 0.0
            continue
        axes[:, i] = left @ direction / stiffness[i]
        left -= stiffness[i] * np.outer(axes[:, i], axes[:, i])
    return _GroupTangent(group, rows, names, axes, stiffness)


def _lateral_axes(stretch: Array, tangent: Array) -> Array:
    """Unit vectors along the stretch (2,) of x and y and across it as columns (2, 2).

    Principal ones, the stiffer first, where the tangent (2, 2) couples these; x and y themselves where there is no
    stretch, or the tangent is alike in all directions.
    """
    length, mean = float(np.linalg.norm(stretch)), float(np.abs(np.diag(tangent)).mean())
    alike = np.abs(tangent - np.eye(2) * np.diag(tangent).mean()).max()
    if length == 0 or alike <= _ISOTROPIC * mean:
        return np.eye(2)
    x, y = stretch / length
    axes = np.array([[x, -y], [y, x]])
    if abs(axes[:, 0] @ tangent @ axes[:, 1]) > _ISOTROPIC * mean:
        axes = np.linalg.eigh(tangent)[1][:, ::-1]
    return axes


def _linearised_links(system: System, laws: _LinkTangents) -> LinkRows:
    """The links of the system and the axes of every group, with its tangent and the offset as preload."""
    links = system.links
    names: list[str] = []
    columns, stiffness, damping = [links.B], [links.stiffness], [links.damping]
    preload = [links.preload if links.preload.size else np.zeros(len(links.name))]
    for group, rows, of_axes, axes, values in laws.groups:
        names += of_axes
        columns.append(group.B @ axes)
        stiffness.append(values)
        along = np.linalg.inv(axes)
        preload.append(along @ laws.offset[rows])
        damping.append(np.diag(along @ np.diag(group.damping) @ along.T) + group.lag * values)
    count = sum(map(len, stiffness))
    turns = (
        *(links.turn or (Fraction(0),) * len(links.name)),
        *(group.turn for group in system.groups for _ in group.rows),
    )
    return LinkRows(
        name=(*links.name, *names),
        link=(*links.link, *(group.name for group in system.groups for _ in group.rows)),
        B=np.concatenate(columns, axis=1),
        stiffness=np.concatenate(stiffness),
        damping=np.concatenate(damping),
        skew=np.pad(links.skew, (0, count - len(links.skew))) if links.skew.size else links.skew,
        preload=np.concatenate(preload),
        turn=turns if any(turns) else (),
    )


def _linearised_line(system: System, laws: _LinkTangents, line: Line) -> Line:
    """A line whose errors in laws act as forces through the tangents and their dampers."""
    rows, gap = system.group_rows, group_gap(line, len(laws.lag))
    force = line.force.copy()
    force[0] += rows @ (laws.tangent @ gap)
    force[1] += 2j * math.pi * float(line.frequency) * (rows @ (laws.lag * (laws.tangent @ gap)))
    link_gap = [line.link_gap, *(part.axes.T @ gap[part.rows] for part in laws.groups)]
    return replace(line, force=force, link_gap=np.concatenate(link_gap), group_gap=np.zeros(0, dtype=complex))


def _law_warnings(system: System, laws: _LinkTangents, memory_alone: bool) -> list[CodedText]:
    """Warnings that name the stiffness [N/m] in place of each law.

    Groups of one text together.
    """
    groups_by_text: dict[str, list[str]] = {}
    for (group, _, _, _, values), doing in zip(laws.groups, system.laws.state(laws.stretch), strict=True):
        if memory_alone and not group.law.memory:
            continue
        unit = "N m/rad" if group.rows[0].endswith(("/rx", "/ry", "/rz")) else "N/m"
        if STATES[doing] == "play":
            text = "inside its clearance under the mean load, stiffness 0"
        elif group.law.memory:
            text = f"sticks in small vibration, stiffness {group.law.stiffness:.4g} {unit}"
        else:
            across = f", across {values[1]:.4g} {unit}" if len(values) >= 2 else ""
            text = f"{_DOING[STATES[doing]]} at the mean load, stiffness along it {values[0]:.4g} {unit}{across}"
        groups_by_text.setdefault(f"{group.law.kind} {text}", []).append(group.name)
    return [
        coded("law-linearised", f"linearised: {', '.join(names)}: {text}") for text, names in groups_by_text.items()
    ]


def turn_warnings(system: System) -> list[CodedText]:
    """A warning of links whose tangents at the mean load miss forces of their laws over the turn, with the error.

    A load that stands still in the housing turns in the frame of the carrier, where its mean is zero: the tangent there
    cannot see it.  At instants over the common period of all lines the quasi-static forces with the laws of links stand
    beside those with their tangents; flanks are linear in both.  No warning where no force differs by more than 1e-3 of
    the largest.  Derived here.
    """
    if not system.groups or not any(line.frequency for line in system.lines):
        return []
    lawful, tone = _without_flank_laws(system), reference_tone(system)
    period = hunting_cycles([f / tone for f in (*(line.frequency for line in system.lines), *system.tones)])
    in_a_row = bool(system.laws.memory.any())  # as a history is
    cycles = min(period, _CYCLES)
    record = Record(unit=tone, name="mesh cycles", count=cycles, samples=_INSTANTS, period=period, spread=not in_a_row)
    try:
        law, tangent = (_slow_forces(each, system, record) for each in (lawful, linear(lawful)))
    except (ConvergenceError, ModelError) as failure:
        text = f"how far the tangents of links are off over the turn is not known: {failure}"
        return [coded("law-over-turn", text)]
    names = [*faces(system.meshes).name, *(group.name for group in system.groups)]
    most, error = np.maximum(law, tangent).max(axis=0), np.abs(tangent - law).max(axis=0)
    meshes = len(names) - len(system.groups)
    largest = np.append(np.full(meshes, most[:meshes].max()), most[meshes:])
    off = np.flatnonzero(error > _SAME * np.maximum(largest, _SAME * largest[0]))
    if not off.size:
        return []
    # of the meshes that which is worst, and every link
    worst = int(np.argmax(error[:meshes] > (1 - _SAME) * error[:meshes].max()))  # of equal ones the first
    told = [i for i in off.tolist() if i >= meshes or i == worst]
    said = [
        f"{names[i]} {law[:, i].max() / 1e3:.5g} kN by the law, {tangent[:, i].max() / 1e3:.5g} kN by the tangent, "
        f"off by up to {error[i] / 1e3:.3g} kN ({100 * error[i] / largest[i]:.3g} % of the largest) at an instant"
        for i in told
    ]
    text = (
        "links open, close or turn their load over the turn, which tangents at the mean load do not see; forces at rest"
    )
    return [coded("law-over-turn", f"{text}: {'; '.join(said)}")]


def _slow_forces(system: System, of: System, record: Record) -> Array:
    """Quasi-static forces (T, w + G) of whole meshes and of the links that are groups `of` a System [N, N m]."""
    forces, links, face = list[Array](), system.links, faces(system.meshes)
    held = held_train(system)
    # what stands for a group: of its link neither a row beside its law nor, of forces, a moment
    beside, moments = set(of.links.name), ("/rx", "/ry", "/rz")
    own = [
        [
            link == group.name and name not in beside and name.endswith(moments) == group.rows[0].endswith(moments)
            for name, link in zip(links.name, links.link, strict=True)
        ]
        for group in of.groups
    ]
    for piece in quasi_static(held, record):
        if system.groups:
            of_groups = system.laws.rows.size(piece.state.group_force)
        else:
            rows = links.stiffness * piece.link_deflection + links.preload
            of_groups = np.stack([np.linalg.norm(rows[:, at], axis=1) for at in own], axis=1)
        forces.append(np.hstack([face.total(held.net_force(piece.state), axis=1), of_groups]))
    return np.concatenate(forces)


# flanks ---------------------------------------------------------------------------------------------------------------


def flank_warnings(system: System) -> Iterator[CodedText]:
    """A warning for every pair whose flanks follow a law: how far their tangent at the operating load is from it.

    First touch of the law less that of the tangent, and the force of the tangent over that of the law, less one, at the
    gap where the tangent gives half of the operating load: of both the largest in size, over the mesh cycle and the
    rows of the pair.
    """
    meshes = system.meshes
    if not meshes.laws:
        return
    load, touch, error = (np.full(len(meshes.name), np.nan) for _ in range(3))
    lawful = np.zeros(len(meshes.name), bool)
    for part in meshes.laws:
        lawful[part.rows], load[part.rows] = True, part.law.load
        touch[part.rows], error[part.rows] = _departure(meshes, part)
    whole = faces(meshes)
    pairs = np.array(meshes.pair)
    for pair in dict.fromkeys(pairs[lawful].tolist()):
        rows = np.flatnonzero(lawful & (pairs == pair))
        mesh_load = whole.total(load)[np.unique(whole.row[rows])]
        text = _departure_text(mesh_load, float(_largest(touch[rows])), float(_largest(error[rows])))
        yield coded("law-linearised", f"{pair}: {text}")


def _departure(meshes: MeshRows, part: LawRows) -> tuple[Array, Array]:
    """First touch (c,) [m] of the rows of a law less that of their tangent, and relative error (c,) [1] of the tangent
    where it gives half of the operating load, nan where that is not known; the largest in size over the mesh cycle.
    """
    rows = part.rows
    tangent = LinearLaw(stiffness=meshes.stiffness[rows], variation=meshes.variation[rows], tone=meshes.tone[rows])
    phases = np.repeat(np.arange(_PHASES)[:, None] / _PHASES, int(meshes.tone.max()) + 1, axis=1)
    law, line = part.law.at(phases), tangent.at(phases)
    half = part.law.load / 2
    force = law.evaluate(half / line.stiffness)[0]
    with np.errstate(divide="ignore"):  # a law may be open there: the error is inf
        error = half / force - 1
    return _largest(law.touch - line.touch), _largest(error)


def _largest(values: Array) -> Array:
    """The values largest in size along the first axis, with their signs; nan where one is."""
    return np.asarray(np.take_along_axis(values, np.abs(values).argmax(axis=0)[None], axis=0)[0])


def _departure_text(load: Array, touch: float, error: float) -> str:
    """What a tangent taken at loads (w,) [N] leaves out, from first touch [m] and relative error [1]."""
    sense = "after" if touch > 0 else "before"
    first = f"teeth touch {abs(touch) * 1e6:.2g} µm {sense} the tangent does"
    if abs(touch) < _NO_TOUCH:
        first = "teeth touch where the tangent does"
    if np.isnan(error):
        return f"tangent in place of the law of its gaps: {first} (worst of the mesh cycle)"
    low, high = (f"{value / 1e3:.4g}" for value in (load.min(), load.max()))
    taken = high if low == high else f"{low} .. {high}"
    if np.isinf(error):
        beside = "the law gives no force"
    elif abs(error) < _NO_ERROR:
        beside = "both forces agree"
    else:
        beside = f"its force is {abs(error) * 100:.2g} % {'above' if error > 0 else 'below'} that of the law"
    return (
        f"tangent at {taken} kN in place of the law of its gaps: {first}; where the tangent gives half of that load, "
        f"{beside} (worst of the mesh cycle)"
    )
