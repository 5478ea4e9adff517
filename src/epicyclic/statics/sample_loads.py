"""Load sharing of many samples of one train: closed contact by one product, open contact by active sets.

A row whose stiffness is kappa instead of k0 adds the pull y = (k0 - kappa) g to the closed stretches, g = g0 + S y
(`load_map`).  Samples with one set of such rows share one small inverse.  All rows change at first that contradict
their state, a Newton step of the contact problem; samples that still change after some steps go on with the first
contradicting row alone, which ends where S is that of a train that is held [murty1974].  A set that contradicts none
of its rows is the equilibrium; stretches that do not solve its equations to `_CONSISTENT` are not found, nor are those
whose rows would press otherwise by `LEFT` of the largest force.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ConvergenceError, ModelError
from ..limits import carries_load
from ..system.gaps import net_force
from ..system.system import Array, ComplexArray, System
from .equilibrium import LEFT
from .load_map import (
    LawMap,
    LoadMap,
    SlowPhases,
    closed_loads,
    falls_below,
    law_forces,
    law_map,
    least_forces,
    load_map,
    phase_points,
    phase_steps,
    slow_phases,
    units_of_largest,
)
from .record import MeshGroup, shares
from .static import HeldTrain
from .tangent import linear

ContactMethod = Literal["auto", "linear", "static"]

# Steps with all rows at once, and altogether: one row at a time needs about as many as there are rows.
_NEWTON, _STEPS = 12, 120
# Part of its stiffness that an open row keeps while sets are sought, so that a body all of whose meshes are open
# does not make the set singular; the forces of the set that is found are without it.
_OPEN = 1e-9
# Stretch that is neither open nor closed, per the largest of the sample: rounding.
_ROUNDING = 1e-12
# Part of the largest closed stretch of a sample that a solution of its set may miss: not of the stretches of the set,
# which rounding alone may be, where a branch is open on both sides and its gaps are not unique.
_CONSISTENT = 1e-9
# Numbers of one batch of matrices.
_BATCH = 4_000_000
# Force that is none, per the largest of the sample.
_NONE = 1e-9
# Slow phases of open contact, points of a lattice: of nine sets of three to five planets at three loads, 24 samples
# each, against 20 000 points, the mean share of a mesh errs by at most 3.5e-3 where teeth part most of the time (144
# points: 5.1e-2) and the largest while turning, searched for, is up to 6.5e-3 low (144: 3.0e-2); twice the time of 144.
_PHASES = 1152
# Those where one train is asked, or how far the others are from it; and of links with laws, each phase of which takes a
# hundred times as long.
_DENSE_PHASES, _LAW_PHASES = 4 * _PHASES, 144
# Search for the largest share of open contact: rounds, first step in the phases [rad], by which steps shrink in a round
# without success.
_ROUNDS, _FIRST_STEP, _SHORTER = 14, 0.5, 0.6
# Instants of one batch of open samples.
_INSTANTS = 40_000


class SampleLoads(NamedTuple):
    """Load sharing of S samples, definitions as of `load_map.MEAN_LOADS`.

    k : (S, 2, g) coefficient of each group [1], nan of samples that failed and of groups without load.
    load : (S, 2, w) N F_i / sum F of each whole mesh [1].
    least : (S, w) least force of each whole mesh at any slow phases [N], nan of groups without load, which part freely.
    open, failed : (S,) whether contact opens or a far flank touches at some phases; whether no state was found.
    """

    k: Array
    load: Array
    least: Array
    open: NDArray[np.bool_]
    failed: NDArray[np.bool_]


class _ClosedContact(NamedTuple):
    """Closed contact of S samples.

    stiffness : (S, M) [N/m].
    force, wave : (S, w), (G, S, w) of the whole meshes [N], positive where the train of the map loads them.
    left : (S,) force on a body that a stiffness of its own leaves [N].
    leaves, failed : (S,) whether a row leaves its state at some phases; whether a stiffness is no stiffness.
    """

    stiffness: Array
    force: Array
    wave: ComplexArray
    left: Array
    leaves: NDArray[np.bool_]
    failed: NDArray[np.bool_]


Forces = Callable[[NDArray[np.int64], ComplexArray], tuple[Array, NDArray[np.bool_]]]
"""(samples (s,), units (G, s, T) of slow phases) -> forces of whole meshes (s, T, w) [N], whether found (s,)."""


# open contact ---------------------------------------------------------------------------------------------------------


def net_forces(
    loads: LoadMap, closed: Array, rows: NDArray[np.int64] | None = None, stiffness: Array | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """Forces of the mesh rows (T, m) [N], negative on far flanks, and whether each was found (T,).

    Parameters
    ----------
    closed : (T, M) stretches with the stiffness of the map in all rows, loaded flanks closed [m].
    rows, stiffness : (V,) mesh rows and links with a stiffness of their own, and that (T, V) [N/m].
    """
    m, c = loads.mesh_count, loads.far.size
    F = m + c
    # stiffness of every row that presses [N/m], (M,) of all samples or (T, M)
    pressing = loads.flexible.stiffness.copy()
    pressing[m:F] = loads.far_stiffness
    same = rows is None or stiffness is None
    if not same:
        pressing = np.tile(pressing, (len(closed), 1))
        pressing[:, rows] = stiffness
        pressing[:, m:F] = pressing[:, loads.far]
    state = np.tile(loads.flexible.stiffness[:F] > 0, (len(closed), 1))

    def stretches(at: NDArray[np.int64], open_part: float) -> tuple[Array, NDArray[np.bool_]]:
        """Stretches of the sets of some samples, as of `_stretches_of_sets`."""
        if same:
            return _stretches_of_sets(loads, closed[at], state[at], pressing, open_part)
        return _stretches_of_each(loads, closed[at], state[at], pressing[at], open_part)

    found = np.zeros(len(closed), bool)
    size = _ROUNDING * np.abs(closed).max(axis=1, initial=0.0)
    everyone = todo = np.arange(len(closed))
    for step in range(_STEPS):
        g, regular = stretches(todo, _OPEN)
        wrong = (g[:, :F] > 0) != state[todo]
        wrong &= np.abs(g[:, :F]) > size[todo, None]
        wrong[~regular] = False
        found[todo] = ~wrong.any(axis=1) & regular
        if step >= _NEWTON:  # the first alone
            wrong &= np.cumsum(wrong, axis=1) == 1
        state[todo] ^= wrong
        todo = todo[wrong.any(axis=1)]
        if not todo.size:
            break
    stretch, regular = stretches(everyone, 0.0)
    found &= np.asarray(regular & np.isfinite(stretch.sum(axis=1)))
    force = stretch[:, :F] * np.where(state, pressing[..., :F], 0.0)
    return net_force(force, loads.far), np.asarray(found, bool)


def _stretches_of_each(
    loads: LoadMap, closed: Array, state: NDArray[np.bool_], pressing: Array, open_part: float
) -> tuple[Array, NDArray[np.bool_]]:
    """As `_stretches_of_sets`, of samples with stiffnesses (T, M) of their own: one full set of equations each."""
    T, M = closed.shape
    F, k0, S = state.shape[1], loads.flexible.stiffness, loads.flexible.to_mesh
    stretch, regular = closed.copy(), np.ones(T, bool)
    kappa = pressing.copy()
    kappa[:, :F] = np.where(state, pressing[:, :F], open_part * k0[:F])
    step = max(1, _BATCH // M**2)
    for first in range(0, T, step):
        at = slice(first, first + step)
        matrix = np.eye(M) - S * (k0 - kappa[at])[:, None, :]
        solution, regular[at] = _solutions(matrix, closed[at, :, None])
        stretch[at] = solution[..., 0]
        if not open_part:
            missed = (matrix @ solution)[..., 0] - closed[at]
            regular[at] &= _at_most(_CONSISTENT, missed, closed[at])
            regular[at] &= _at_most(LEFT, np.maximum(k0, kappa[at]) * missed, kappa[at] * stretch[at])
    return stretch, regular


def _stretches_of_sets(
    loads: LoadMap, closed: Array, state: NDArray[np.bool_], pressing: Array, open_part: float
) -> tuple[Array, NDArray[np.bool_]]:
    """Stretches (T, M) [m] of given sets, and whether the train is held in each (T,).

    state : (T, F) flanks that press.  pressing : (M,) stiffness of those [N/m].  open_part : of it that open rows keep.
    """
    F, k0, S = state.shape[1], loads.flexible.stiffness, loads.flexible.to_mesh
    stretch, regular = closed.copy(), np.ones(len(closed), bool)
    changed = np.flatnonzero((state != (k0[:F] > 0)).any(axis=1))
    packed = np.packbits(state[changed], axis=1)  # as bytes of one length, which are sorted four times as quickly
    _, number, count = np.unique(packed.view(f"S{packed.shape[1]}"), return_inverse=True, return_counts=True)
    alike = np.split(changed[np.argsort(number.ravel(), kind="stable")], np.cumsum(count)[:-1])
    for at in alike if changed.size else ():
        kappa = k0.copy()
        kappa[:F] = np.where(state[at[0]], pressing[:F], open_part * k0[:F])
        differs = np.flatnonzero(k0 != kappa)
        D = (k0 - kappa)[differs]
        matrix = np.eye(differs.size) - S[np.ix_(differs, differs)] * D
        right = closed[np.ix_(at, differs)]
        solution, regular[at] = _solutions(matrix[None], right.T[None])
        if not open_part:
            regular[at] &= _at_most(_CONSISTENT, (matrix @ solution[0]).T - right, closed[at])
        stretch[at] = closed[at] + (solution[0].T * D) @ S[:, differs].T
        if not open_part:
            missed = stretch[np.ix_(at, differs)] - solution[0].T
            regular[at] &= _at_most(LEFT, np.maximum(k0, kappa)[differs] * missed, kappa * stretch[at])
    return stretch, regular


def _solutions(matrix: Array, right: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Solutions (T, n, r) of batched linear equations and whether each matrix (T, n, n) is regular.

    A branch that is open on both sides turns freely: the gaps of its rows are not unique, all forces are.  Of singular
    equations the solution of least size stands, if it is one.
    """
    try:
        return np.asarray(np.linalg.solve(matrix, right), float), np.ones(len(matrix), bool)
    except np.linalg.LinAlgError:
        if len(matrix) == 1:
            least = np.linalg.lstsq(matrix[0], right[0], rcond=None)[0]
            missed = (matrix[0] @ least - right[0]).reshape(1, -1)
            return least[None], _at_most(_CONSISTENT, missed, right.reshape(1, -1))
        halves = [_solutions(*half) for half in zip(np.array_split(matrix, 2), np.array_split(right, 2), strict=True)]
        return np.concatenate([half[0] for half in halves]), np.concatenate([half[1] for half in halves])


def _at_most(part: float, missed: Array, beside: Array) -> NDArray[np.bool_]:
    """Whether what equations of a sample miss (T, n) is at most a part of what is beside it (T, M), each sample (T,).

    That are the closed stretches [m], or the forces of all rows [N]; where these are zero, what is missed is rounding.
    """
    left = np.max(np.abs(missed), axis=1, initial=0.0)
    largest = np.max(np.abs(beside), axis=1, initial=0.0)
    return np.asarray((left <= part * largest) | (largest == 0))


# samples --------------------------------------------------------------------------------------------------------------


def sample_loads(
    loads: LoadMap,
    factors: Array,
    *,
    torque: float | Array = 1.0,
    rows: NDArray[np.int64] | None = None,
    stiffness: Array | None = None,
    method: ContactMethod = "auto",
    count: int | None = None,
    laws: LawMap | None = None,
    held: Callable[[int], HeldTrain | None] | None = None,
    dense: bool = False,
) -> SampleLoads:
    """Load sharing of S samples.

    Parameters
    ----------
    factors : (S, C) on the columns of the map.  torque : factor on the torques, one or (S,).
    rows, stiffness : (V,) mesh rows and links whose stiffness varies, and that (S, V) [N/m].
    method : ``auto`` solves those samples anew whose contact opens, ``static`` all of them, ``linear`` none.
    count : samples, from the first on, that are wanted, and returned; the rest only fill a piece up.
    laws : of a train with laws, which all samples ask then except with ``linear``; `loads` has tangents for them.
    held : the train of a sample with laws of its own, None where it is no train.
    dense : open contact at four times as many slow phases, before the largest share is searched for.

    Raises
    ------
    ModelError : a stiffness that varies beside laws that do not allow for it.
    """
    if rows is None or not rows.size:
        rows = stiffness = None
    if laws is not None and method != "linear":
        method = "static"
        _require_law_rows(loads, laws, rows)
    # the products have the shape of the whole piece: BLAS gives the same bits only to the same shape
    still, turning = loads.stretch.values(factors, torque)
    still, turning = still[:count], turning[:, :count]
    (sign, loaded), slow = nominal_signs(loads), slow_phases(loads.stretch.frequency)
    closed = _closed(loads, still, turning, rows, None if stiffness is None else stiffness[:count], sign, slow)
    load = closed_loads(closed.force, closed.wave, loads.group, slow)
    least = least_forces(closed.force, closed.wave, slow)
    nominal = np.max([np.abs(closed.force[:, group].mean(axis=1)) for group in loads.group], axis=0, initial=0.0)
    balanced = _left(loads, factors, torque)[:count] + closed.left <= LEFT * nominal
    failed, opens = closed.failed | ~balanced, closed.leaves.copy()
    wanted = {"auto": opens, "linear": np.zeros_like(opens), "static": np.ones_like(opens)}[method] & ~failed
    excitation = (still, turning) if laws is None else laws.excitation.values(factors, torque)
    forces = _forces_of(loads, laws, excitation, rows, closed.stiffness, sign, held)
    phases = _LAW_PHASES if laws is not None else _DENSE_PHASES if dense else _PHASES
    even = phases if len(closed.wave) else 1
    again = np.flatnonzero(wanted)
    size = max(1, _INSTANTS // (phases + 2 * least.shape[1]))
    for first in range(0, again.size, size):
        at = again[first : first + size]
        units = _phases_of(slow, closed.wave[:, at], phases)
        whole, known = forces(at, units)
        # the mean of closed contact is known: only what opening adds is averaged over the even phases, whose number may
        # divide the order of a tied wave
        shut = _instants(closed.force, closed.wave, at, units[:, :, :even]).reshape(at.size, even, -1)
        mean = closed.force[at] + (whole[:, :even] - shut).mean(axis=1)
        if laws is None:
            whole = _with_largest(forces, slow, loads.group, at, units, whole)
        load[:, at] = shares(mean, loads.group), shares(whole, loads.group).max(axis=1)
        least[at], failed[at] = whole.min(axis=1), ~known
        opens[at] |= (least[at] <= 0).any(axis=1)
    load = load.transpose(1, 0, 2)
    load[failed], least[failed] = np.nan, np.nan
    for group, carries in zip(loads.group, loaded, strict=True):
        if not carries:
            load[:, :, group], least[:, group] = np.nan, np.nan
    k = np.stack([load[..., group].max(axis=-1) for group in loads.group], axis=-1)
    return SampleLoads(k=k, load=load, least=least, open=opens & ~failed, failed=failed)


def mean_loads(system: System) -> Array:
    """N F_i / sum F of each whole mesh of one train, (2, w) [1] by `MEAN_LOADS`; nan in groups without load.

    Links follow their laws; meshes have their mean stiffness, those with a table its tangent.

    Raises
    ------
    ModelError, ConvergenceError : the load has no equilibrium.
    """
    laws = law_map(system) if system.groups else None
    found = sample_loads(load_map(linear(system)), np.zeros((1, 0)), laws=laws, dense=True)
    if found.failed[0]:
        raise ConvergenceError("no static equilibrium at some phases of the errors")
    return np.asarray(found.load[0])


def nominal_signs(loads: LoadMap) -> tuple[Array, NDArray[np.bool_]]:
    """Sign (w,) of the load of each mesh in the train of the map, and groups (g,) that carry any to share."""
    net, found = net_forces(loads, (loads.stretch.still + loads.stretch.torque)[None])
    k = loads.flexible.stiffness[: loads.mesh_count]
    rows = net[0] if found[0] else k * (loads.stretch.still + loads.stretch.torque)[: loads.mesh_count]
    whole = loads.face.total(rows)
    least = _NONE * np.abs(whole).max(initial=0.0)
    sums = np.array([whole[group].sum() for group in loads.group])
    sign = np.ones(whole.size)
    for group, value in zip(loads.group, sums, strict=True):
        sign[group] = -1.0 if value < -least else 1.0
    size = np.array([abs(value) / len(group) for group, value in zip(loads.group, sums, strict=True)])
    stages = [pair.partition(".")[0] for pair in loads.pair]
    return sign, np.asarray((np.abs(sums) > least) & carries_load(size, stages))


def _require_law_rows(loads: LoadMap, laws: LawMap, rows: NDArray[np.int64] | None) -> None:
    """Raise ModelError where links vary beside laws, or meshes that have a table."""
    links = rows is not None and bool((rows >= loads.mesh_count).any())
    tables = rows is not None and bool(laws.held.system.meshes.laws)
    if links or tables:
        raise ModelError(
            "the stiffness of a link varies, where another has play or friction" if links else "a table varies",
            path="method",
            allowed="linear",
        )


def _closed(
    loads: LoadMap,
    still: Array,
    turning: ComplexArray,
    rows: NDArray[np.int64] | None,
    stiffness: Array | None,
    sign: Array,
    slow: SlowPhases,
) -> _ClosedContact:
    """Closed contact of S samples, of their stretches (S, M), (G, S, M) with the stiffness of the map [m].

    sign : (w,) as of `nominal_signs`.
    """
    failed = np.zeros(len(still), bool)
    closed, waves, left = still, turning, np.zeros(len(still))
    k = np.broadcast_to(loads.flexible.stiffness, still.shape)
    if rows is not None and stiffness is not None:
        failed |= ~((stiffness > 0) & np.isfinite(stiffness)).all(axis=1)
        k = k.copy()
        # samples that failed keep the stiffness of the map, so that they do not disturb the others
        k[np.ix_(~failed, rows)] = stiffness[~failed]
        closed, waves, left = _with_stiffness(loads, still, turning, rows, k[:, rows])
    m = loads.mesh_count
    force, wave = k[:, :m] * closed[:, :m], k[:, :m] * waves[:, :, :m]
    return _ClosedContact(
        stiffness=k,
        force=sign * loads.face.total(force, axis=1),
        wave=sign * loads.face.total(wave, axis=2),
        left=left,
        leaves=_leaves(loads, closed, waves, force, wave, slow),
        failed=failed,
    )


def _with_stiffness(
    loads: LoadMap, still: Array, turning: ComplexArray, rows: NDArray[np.int64], stiffness: Array
) -> tuple[Array, ComplexArray, Array]:
    """Stretches (S, M), (G, S, M) [m] where some rows have another stiffness (S, V), all loaded flanks closed.

    With them the largest force that rounding leaves in one of these rows (S,) [N].
    """
    S = loads.flexible.to_mesh
    D = loads.flexible.stiffness[rows] - stiffness
    matrix = np.eye(rows.size) - S[np.ix_(rows, rows)] * D[:, None, :]
    right = np.concatenate([still[None], turning.real, turning.imag])[:, :, rows]
    solution = np.linalg.solve(matrix, right.transpose(1, 2, 0))  # (S, V, 1 + 2 G)
    added = (solution * D[:, :, None]).transpose(2, 0, 1) @ S[:, rows].T
    G = len(turning)
    missed = np.abs(right + added[:, :, rows] - solution.transpose(2, 0, 1)).sum(axis=0)
    return (
        still + added[0],
        turning + added[1 : G + 1] + 1j * added[G + 1 :],
        np.max(np.abs(D) * missed, axis=1, initial=0.0),
    )


def _left(loads: LoadMap, factors: Array, torque: float | Array) -> Array:
    """Largest force (S,) [N] that rounding of the map leaves on a body of each sample."""
    still, turning = loads.left.values(np.abs(factors), np.abs(torque))
    return np.asarray(still[:, 0] + turning[:, :, 0].real.sum(axis=0))


def _leaves(
    loads: LoadMap, closed: Array, waves: ComplexArray, force: Array, wave: ComplexArray, phases: SlowPhases
) -> NDArray[np.bool_]:
    """Samples (S,) of which a row leaves the state it has in the map at some phases."""
    m, c = loads.mesh_count, loads.far.size
    size = np.abs(force).max(axis=1, initial=0.0)
    leaves = falls_below(force, wave, phases, -_NONE * size[:, None])
    if c:
        side = np.where(loads.flexible.stiffness[m : m + c] > 0, 1.0, -1.0)
        reach, swing = side * closed[:, m : m + c], side * waves[:, :, m : m + c]
        leaves |= falls_below(reach, swing, phases, np.zeros((len(reach), 1)))
    return leaves


def _forces_of(
    loads: LoadMap,
    laws: LawMap | None,
    excitation: tuple[Array, ComplexArray],
    rows: NDArray[np.int64] | None,
    stiffness: Array,
    sign: Array,
    held: Callable[[int], HeldTrain | None] | None,
) -> Forces:
    """Forces of samples in open contact, or by the laws of their train.

    excitation : (S, Q), (G, S, Q) what stands still and turns: stretches [m], or of the laws.
    stiffness : (S, M), asked where `rows` vary [N/m].  sign : (w,) as of `nominal_signs`.  held : as of `sample_loads`.
    """

    def forces(at: NDArray[np.int64], units: ComplexArray) -> tuple[Array, NDArray[np.bool_]]:
        """The forces of some samples."""
        T, m = units.shape[2], loads.mesh_count
        values = _instants(*excitation, at, units)
        k = None if rows is None else np.repeat(stiffness[at], T, axis=0)
        if laws is None:
            net, known = net_forces(loads, values, rows, None if k is None else k[:, rows])
        elif held is None:
            net, known = law_forces(laws, values, None if k is None else k[:, :m])
        else:
            net, known = np.full((at.size * T, m), np.nan), np.zeros(at.size * T, bool)
            for place, sample in enumerate(at.tolist()):
                if (train := held(sample)) is not None:
                    one = slice(place * T, (place + 1) * T)
                    own = None if k is None else k[one, :m]
                    net[one], known[one] = law_forces(replace(laws, held=train), values[one], own)
        whole = sign * loads.face.total(net.reshape(at.size, T, m), axis=2)
        return whole, np.asarray(known.reshape(at.size, T).all(axis=1))

    return forces


def _phases_of(slow: SlowPhases, wave: ComplexArray, count: int) -> ComplexArray:
    """Units (G, s, T) of the slow phases at which samples are solved, of their waves (G, s, w).

    Even ones, then those that load a mesh most, then those that load it least.
    """
    if not len(wave):
        return np.ones((0, wave.shape[1], 1), complex)
    even = phase_points(slow, count).T
    same = np.broadcast_to(even[:, None, :], (*wave.shape[:2], count))
    most, least = units_of_largest(slow, wave), units_of_largest(slow, -wave)
    return np.concatenate([same, most, least], axis=2)


def _with_largest(
    forces: Forces,
    slow: SlowPhases,
    members: Sequence[MeshGroup],
    at: NDArray[np.int64],
    units: ComplexArray,
    whole: Array,
) -> Array:
    """Forces (s, T + .., w) [N] with those at the phases of the largest share of each mesh behind them.

    Shares have edges where teeth open and close, so that no slope leads along them: from the best point of each mesh
    steps in fixed random directions are tried and the best is taken; after a round without any the steps are shorter.

    units : (G, s, T).  whole : (s, T, w) forces at them [N].
    """
    G, s, w = len(units), at.size, whole.shape[2]
    sample, mesh = np.arange(s)[:, None], np.arange(w)
    start = shares(whole, members)
    unit, largest = units[:, sample, start.argmax(axis=1)], start.max(axis=1)
    length = np.full((s, w), _FIRST_STEP)
    added = [whole]
    for turn in phase_steps(slow, _ROUNDS) if G else ():
        tried = unit[..., None] * np.exp(1j * length[..., None] * turn[:, None, None])
        reached, _ = forces(at, tried.reshape(G, s, -1))
        share = shares(reached, members).reshape(s, w, -1, w)[:, mesh, :, mesh].transpose(1, 0, 2)
        share = np.where(np.isfinite(share) | np.isposinf(share), share, -np.inf)
        best, most = share.argmax(axis=2), share.max(axis=2)
        higher = most > largest
        unit = np.where(higher, tried[:, sample, mesh, best], unit)
        added.append(np.where(higher[..., None], reached.reshape(s, w, -1, w)[sample, mesh, best], whole[:, :1]))
        largest, length = np.maximum(largest, most), np.where(higher, length, _SHORTER * length)
    return np.concatenate(added, axis=1)


def _instants(still: Array, turning: ComplexArray, at: NDArray[np.int64], units: ComplexArray) -> Array:
    """Values (S T, Q) of the samples `at` at their T slow phases, units (G, S, T)."""
    values: Array = still[at, None] + np.einsum("gst,gsm->stm", units, turning[:, at]).real
    return values.reshape(-1, values.shape[2])
