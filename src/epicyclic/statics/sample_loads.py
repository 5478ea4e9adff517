"""Load sharing of many samples of one train: closed contact by one product, open contact by active sets.

Contact that opens, of many samples at once: active sets, grouped by the rows that differ from the closed train.

A row whose stiffness is kappa instead of k0 adds the pull y = (k0 - kappa) g to the closed stretches, g = g0 + S y
(`load_map`).  Samples with one set of such rows share one small inverse.  All rows change at first that contradict
their state, a Newton step of the contact problem; samples that still change after some steps go on with the first
contradicting row alone, which ends where S is that of a train that is held [murty1974].  A set that contradicts none
of its rows is the equilibrium; stretches that do not solve its equations to `_CONSISTENT` are not found, nor are those
whose rows would press otherwise by `LEFT` of the largest force.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..errors import ConvergenceError, ModelError
from ..system.system import Array, ComplexArray, System
from .equilibrium import LEFT
from .load_map import LawMap, LoadMap, law_forces, law_map, load_map
from .mean_load import (
    SlowPhases,
    closed_loads,
    falls_below,
    largest_of_groups,
    least_forces,
    loads_at_phases,
    phase_points,
    phase_steps,
    shares,
    slow_phases,
    units_of_largest,
)
from .tangent import linear

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


def net_forces(
    given: LoadMap, closed: Array, rows: NDArray[np.int64] | None = None, stiffness: Array | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """Forces of the mesh rows (T, m) [N], negative on far flanks, and whether each was found (T,).

    Parameters
    ----------
    closed : (T, M) stretches with the stiffness of the map in all rows, loaded flanks closed [m].
    rows, stiffness : (V,) mesh rows and links with a stiffness of their own, and that (T, V) [N/m].
    """
    pressing = _pressing(given, len(closed), rows, stiffness)
    F = given.mesh_count + given.far.size
    state = np.tile(given.flexible.stiffness[:F] > 0, (len(closed), 1))
    found = np.zeros(len(closed), bool)
    stretch = np.empty_like(closed)
    size = _ROUNDING * np.abs(closed).max(axis=1, initial=0.0)
    todo = np.arange(len(closed))
    same = rows is None
    for step in range(_STEPS):
        own = pressing if same else pressing[todo]
        g, regular = _stretch_of(given, closed[todo], state[todo], own, open_part=_OPEN, same=same)
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
    stretch, regular = _stretch_of(given, closed, state, pressing, open_part=0.0, same=same)
    found &= np.asarray(regular & np.isfinite(stretch.sum(axis=1)))
    force = stretch[:, :F] * np.where(state, pressing[..., :F], 0.0)
    net = force[:, : given.mesh_count].copy()
    net[:, given.far] -= force[:, given.mesh_count :]
    return net, np.asarray(found, bool)


def _pressing(given: LoadMap, count: int, rows: NDArray[np.int64] | None, stiffness: Array | None) -> Array:
    """Stiffness of every row that presses [N/m], (M,) of all samples or (T, M)."""
    k = given.flexible.stiffness.copy()
    m, c = given.mesh_count, given.far.size
    k[m : m + c] = given.far_stiffness
    if rows is None or stiffness is None:
        return k
    own = np.tile(k, (count, 1))
    own[:, rows] = stiffness
    own[:, m : m + c] = own[:, given.far]
    return own


def _stretch_of(
    given: LoadMap, closed: Array, state: NDArray[np.bool_], pressing: Array, *, open_part: float, same: bool
) -> tuple[Array, NDArray[np.bool_]]:
    """Stretches (T, M) [m] of given sets, and whether the train is held in each (T,).

    state : (T, F) flanks that press.  pressing : (M,) or (T, M) stiffness of those [N/m].  same : of all samples.
    """
    T, M = closed.shape
    F, k0, S = state.shape[1], given.flexible.stiffness, given.flexible.to_mesh
    stretch, regular = closed.copy(), np.ones(T, bool)
    if not same:
        kappa = pressing.copy()
        kappa[:, :F] = np.where(state, pressing[:, :F], open_part * k0[:F])
        for first in range(0, T, max(1, _BATCH // M**2)):
            part = slice(first, first + max(1, _BATCH // M**2))
            matrix = np.eye(M) - S * (k0 - kappa[part])[:, None, :]
            stretch[part], regular[part] = _solutions(matrix, closed[part])
            if not open_part:
                missed = (matrix @ stretch[part, :, None])[..., 0] - closed[part]
                regular[part] &= _consistent(missed, closed[part])
                regular[part] &= _balanced(np.maximum(k0, kappa[part]) * missed, kappa[part] * stretch[part])
        return stretch, regular
    for at in _alike(state, np.flatnonzero((state != (k0[:F] > 0)).any(axis=1))):
        kappa = k0.copy()
        kappa[:F] = np.where(state[at[0]], pressing[:F], open_part * k0[:F])
        differs = np.flatnonzero(k0 != kappa)
        D = (k0 - kappa)[differs]
        matrix = np.eye(differs.size) - S[np.ix_(differs, differs)] * D
        right = closed[np.ix_(at, differs)]
        own, regular[at] = _solutions(matrix[None], right.T[None])
        if not open_part:
            regular[at] &= _consistent((matrix @ own[0]).T - right, closed[at])
        stretch[at] = closed[at] + (own[0].T * D) @ S[:, differs].T
        if not open_part:
            missed = stretch[np.ix_(at, differs)] - own[0].T
            regular[at] &= _balanced(np.maximum(k0, kappa)[differs] * missed, kappa * stretch[at])
    return stretch, regular


def _alike(state: NDArray[np.bool_], chosen: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The chosen samples in groups of one set of rows each."""
    if not chosen.size:
        return []
    packed = np.packbits(state[chosen], axis=1)
    order = np.lexsort(packed.T)
    new = np.any(np.diff(packed[order], axis=0) != 0, axis=1)
    return np.split(chosen[order], np.flatnonzero(new) + 1)


def _solutions(matrix: Array, right: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Solutions of batched linear equations and whether each matrix is regular."""
    vector = right.ndim == 2
    try:
        found = np.linalg.solve(matrix, right[..., None] if vector else right)
        return np.asarray(found[..., 0] if vector else found), np.ones(len(matrix), bool)
    except np.linalg.LinAlgError:
        if len(matrix) == 1:
            return _of_least_size(matrix, right)
        halves = [_solutions(*each) for each in zip(np.array_split(matrix, 2), np.array_split(right, 2), strict=True)]
        solution: Array = np.concatenate([half[0] for half in halves])
        return solution, np.concatenate([half[1] for half in halves])


def _of_least_size(matrix: Array, right: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The solution of least size of one singular equation (1, n, n), and whether it is one.

    A branch that is open on both sides turns freely: the gaps of its rows are not unique, all forces are.
    """
    found = np.linalg.lstsq(matrix[0], right[0], rcond=None)[0]
    return found[None], _consistent((matrix[0] @ found - right[0]).reshape(1, -1), right.reshape(1, -1))


def _consistent(missed: Array, closed: Array) -> NDArray[np.bool_]:
    """Whether what equations miss (T, n) [m] is rounding beside the closed stretches (T, M) [m], each sample (T,)."""
    size = np.max(np.abs(closed), axis=1, initial=0.0)
    agree: NDArray[np.bool_] = np.max(np.abs(missed), axis=1, initial=0.0) <= _CONSISTENT * size
    return agree


def _balanced(missed: Array, force: Array) -> NDArray[np.bool_]:
    """Whether forces that rows miss (T, n) [N] are rounding beside those of all rows (T, M) [N], each sample (T,)."""
    left = np.max(np.abs(missed), axis=1, initial=0.0)
    largest = np.max(np.abs(force), axis=1, initial=0.0)
    return np.asarray((left <= LEFT * largest) | (largest == 0))


ContactMethod = Literal["auto", "linear", "static"]
METHODS: tuple[ContactMethod, ...] = get_args(ContactMethod)

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampleLoads:
    """Load sharing of S samples, definitions as of `mean_load.MEAN_LOADS`.

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


def sample_loads(
    given: LoadMap,
    factors: Array,
    *,
    torque: float | Array = 1.0,
    rows: NDArray[np.int64] | None = None,
    stiffness: Array | None = None,
    method: ContactMethod = "auto",
    count: int | None = None,
    laws: LawMap | None = None,
    dense: bool = False,
) -> SampleLoads:
    """Load sharing of S samples.

    Parameters
    ----------
    factors : (S, C) on the columns of the map.  torque : factor on the torques, one or (S,).
    rows, stiffness : (V,) mesh rows and links whose stiffness varies, and that (S, V) [N/m].
    method : ``auto`` solves those samples anew whose contact opens, ``static`` all of them, ``linear`` none.
    count : samples, from the first on, that are wanted, and returned; the rest only fill a piece up.
    laws : of a train with laws, which all samples ask then except with ``linear``; `given` has tangents for them.
    dense : open contact at four times as many slow phases, before the largest share is searched for.

    Raises
    ------
    ModelError : no such method; a stiffness that varies beside laws that do not allow for it.
    """
    if method not in METHODS:
        raise ModelError("no such method", path="method", given=method, allowed=", ".join(METHODS))
    if rows is None or not rows.size:
        rows = stiffness = None
    if laws is not None and method != "linear":
        method = "static"
        _require_law_rows(given, laws, rows)
    # the products have the shape of the whole piece: BLAS gives the same bits only to the same shape
    still, turning = given.stretch.values(factors, torque)
    still, turning = still[:count], turning[:, :count]
    found = _closed(given, still, turning, rows, None if stiffness is None else stiffness[:count])
    S = len(still)
    load = closed_loads(found.force, found.wave, given.group, found.phases)
    least = least_forces(found.force, found.wave, found.phases)
    balanced = _left(given, factors, torque)[:count] + found.left <= LEFT * found.nominal
    failed, opens = found.failed | ~balanced, found.leaves.copy()
    wanted = {"auto": opens, "linear": np.zeros(S, bool), "static": np.ones(S, bool)}[method] & ~failed
    again = np.flatnonzero(wanted)
    phases = _LAW_PHASES if laws is not None else _DENSE_PHASES if dense else _PHASES
    asked = None if laws is None else (laws, *laws.excitation.values(factors, torque))
    size = max(1, _INSTANTS // (phases + 2 * least.shape[1]))
    for first in range(0, again.size, size):
        at = again[first : first + size]
        units = _phases_of(found, at, phases)
        net, known = _solved(given, found, asked, at, units, rows)
        whole = found.sign * given.face.total(net, axis=2)
        mean = _mean_of(found, at, units, whole, phases)
        if asked is None:
            whole = _with_largest(given, found, at, units, whole, rows)
        load[:, at] = loads_at_phases(whole, mean, given.group)
        least[at], failed[at] = whole.min(axis=1), ~known
        opens[at] |= (least[at] <= 0).any(axis=1)
    load = load.transpose(1, 0, 2)
    load[failed], least[failed] = np.nan, np.nan
    for group, carries in zip(given.group, found.loaded, strict=True):
        if not carries:
            load[:, :, group], least[:, group] = np.nan, np.nan
    return SampleLoads(
        k=largest_of_groups(load, given.group), load=load, least=least, open=opens & ~failed, failed=failed
    )


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
    load: Array = found.load[0]
    return load


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _ClosedContact:
    """Closed contact of S samples.

    still, turning : (S, M), (G, S, M) stretches with the stiffness of the map [m].  stiffness : (S, M) [N/m].
    force, wave : (S, w), (G, S, w) of the whole meshes [N], positive where the train of the map loads them.
    left : (S,) force on a body that a stiffness of its own leaves [N].  nominal : (S,) largest mean of a group [N].
    leaves, failed : (S,) whether a row leaves its state at some phases; whether a stiffness is no stiffness.
    sign, loaded : (w,) and (g,) as of `nominal_signs`.
    """

    still: Array
    turning: ComplexArray
    stiffness: Array
    force: Array
    wave: ComplexArray
    left: Array
    nominal: Array
    leaves: NDArray[np.bool_]
    failed: NDArray[np.bool_]
    phases: SlowPhases
    sign: Array
    loaded: NDArray[np.bool_]


def _closed(
    given: LoadMap, still: Array, turning: ComplexArray, rows: NDArray[np.int64] | None, stiffness: Array | None
) -> _ClosedContact:
    """Closed contact of S samples, of their stretches (S, M), (G, S, M) with the stiffness of the map [m]."""
    phases = slow_phases(given.stretch.frequency)
    failed = np.zeros(len(still), bool)
    closed, waves, left = still, turning, np.zeros(len(still))
    k = np.broadcast_to(given.flexible.stiffness, still.shape)
    if rows is not None and stiffness is not None:
        failed |= ~((stiffness > 0) & np.isfinite(stiffness)).all(axis=1)
        k = k.copy()
        # samples that failed keep the stiffness of the map, so that they do not disturb the others
        k[np.ix_(~failed, rows)] = stiffness[~failed]
        closed, waves, left = _with_stiffness(given, still, turning, rows, k[:, rows])
    sign, loaded = nominal_signs(given)
    m = given.mesh_count
    force, wave = k[:, :m] * closed[:, :m], k[:, :m] * waves[:, :, :m]
    whole = sign * given.face.total(force, axis=1)
    nominal = np.max([np.abs(whole[:, group].mean(axis=1)) for group in given.group], axis=0, initial=0.0)
    return _ClosedContact(
        still=still,
        turning=turning,
        stiffness=k,
        force=whole,
        wave=sign * given.face.total(wave, axis=2),
        left=left,
        nominal=nominal,
        leaves=_leaves(given, closed, waves, force, wave, phases),
        failed=failed,
        phases=phases,
        sign=sign,
        loaded=loaded,
    )


def _solved(
    given: LoadMap,
    found: _ClosedContact,
    asked: tuple[LawMap, Array, ComplexArray] | None,
    at: NDArray[np.int64],
    units: ComplexArray,
    rows: NDArray[np.int64] | None,
) -> tuple[Array, NDArray[np.bool_]]:
    """Net forces of the mesh rows (s, T, m) [N] of the samples `at` (s,), units (G, s, T), and whether found (s,)."""
    T, m = units.shape[2], given.mesh_count
    own = None if rows is None else np.repeat(found.stiffness[at], T, axis=0)
    if asked is None:
        values = _instants(found.still, found.turning, at, units)
        net, known = net_forces(given, values, rows, None if own is None else own[:, rows])
    else:
        laws, still, turning = asked
        net, known = law_forces(laws, _instants(still, turning, at, units), None if own is None else own[:, :m])
    return net.reshape(at.size, T, m), np.asarray(known.reshape(at.size, T).all(axis=1))


def _with_largest(
    given: LoadMap,
    found: _ClosedContact,
    at: NDArray[np.int64],
    units: ComplexArray,
    whole: Array,
    rows: NDArray[np.int64] | None,
) -> Array:
    """Forces (s, T + .., w) [N] with those at the phases of the largest share of each mesh behind them.

    Shares have edges where teeth open and close, so that no slope leads along them: from the best point of each mesh
    steps in fixed random directions are tried and the best is taken; after a round without any the steps are shorter.

    units : (G, s, T).  whole : (s, T, w) forces at them [N].
    """
    G, s, w = len(units), at.size, whole.shape[2]
    sample, mesh = np.arange(s)[:, None], np.arange(w)
    start = shares(whole, given.group)
    unit, largest = units[:, sample, start.argmax(axis=1)], start.max(axis=1)
    step = np.full((s, w), _FIRST_STEP)
    added = [whole]
    for turn in phase_steps(found.phases, _ROUNDS) if G else ():
        tried = unit[..., None] * np.exp(1j * step[..., None] * turn[:, None, None])
        net, _ = _solved(given, found, None, at, tried.reshape(G, s, -1), rows)
        reached = found.sign * given.face.total(net, axis=2)
        share = shares(reached, given.group).reshape(s, w, -1, w)[:, mesh, :, mesh].transpose(1, 0, 2)
        share = np.where(np.isfinite(share) | np.isposinf(share), share, -np.inf)
        best, most = share.argmax(axis=2), share.max(axis=2)
        higher = most > largest
        unit = np.where(higher, tried[:, sample, mesh, best], unit)
        added.append(np.where(higher[..., None], reached.reshape(s, w, -1, w)[sample, mesh, best], whole[:, :1]))
        largest, step = np.maximum(largest, most), np.where(higher, step, _SHORTER * step)
    return np.concatenate(added, axis=1)


def _require_law_rows(given: LoadMap, laws: LawMap, rows: NDArray[np.int64] | None) -> None:
    """Raise ModelError where links vary beside laws, or meshes that have a table."""
    links = rows is not None and bool((rows >= given.mesh_count).any())
    tables = rows is not None and rows.size > 0 and bool(laws.system.meshes.laws)
    if links or tables:
        raise ModelError(
            "the stiffness of a link varies, where another has play or friction" if links else "a table varies",
            path="method",
            allowed="linear",
        )


def _instants(still: Array, turning: ComplexArray, at: NDArray[np.int64], units: ComplexArray) -> Array:
    """Values (S T, Q) of the samples `at` at their T slow phases, units (G, S, T)."""
    values: Array = still[at, None] + np.einsum("gst,gsm->stm", units, turning[:, at]).real
    return values.reshape(-1, values.shape[2])


def _mean_of(found: _ClosedContact, at: NDArray[np.int64], units: ComplexArray, whole: Array, phases: int) -> Array:
    """Mean over the slow phases of the forces (s, w) [N] of the samples `at`.

    That of closed contact is known, so that only what opening adds is averaged over the even phases, whose number may
    divide the order of a tied wave.

    units : (G, s, T).  whole : (s, T, w) forces [N].
    """
    even = phases if len(found.wave) else 1
    closed = _instants(found.force, found.wave, at, units[:, :, :even]).reshape(at.size, even, -1)
    mean: Array = found.force[at] + (whole[:, :even] - closed).mean(axis=1)
    return mean


def _with_stiffness(
    given: LoadMap, still: Array, turning: ComplexArray, rows: NDArray[np.int64], stiffness: Array
) -> tuple[Array, ComplexArray, Array]:
    """Stretches (S, M), (G, S, M) [m] where some rows have another stiffness (S, V), all loaded flanks closed.

    With them the largest force that rounding leaves in one of these rows (S,) [N].
    """
    S = given.flexible.to_mesh
    D = given.flexible.stiffness[rows] - stiffness
    matrix = np.eye(rows.size) - S[np.ix_(rows, rows)] * D[:, None, :]
    right = np.concatenate([still[None], turning.real, turning.imag])[:, :, rows]
    own = np.linalg.solve(matrix, right.transpose(1, 2, 0))  # (S, V, 1 + 2 G)
    added = (own * D[:, :, None]).transpose(2, 0, 1) @ S[:, rows].T
    G = len(turning)
    missed = np.abs(right + added[:, :, rows] - own.transpose(2, 0, 1)).sum(axis=0)
    return (
        still + added[0],
        turning + added[1 : G + 1] + 1j * added[G + 1 :],
        np.max(np.abs(D) * missed, axis=1, initial=0.0),
    )


def _left(given: LoadMap, factors: Array, torque: float | Array) -> Array:
    """Largest force (S,) [N] that rounding of the map leaves on a body of each sample."""
    still, turning = given.left.values(np.abs(factors), np.abs(torque))
    left: Array = still[:, 0] + turning[:, :, 0].real.sum(axis=0)
    return left


def _leaves(
    given: LoadMap, closed: Array, waves: ComplexArray, force: Array, wave: ComplexArray, phases: SlowPhases
) -> NDArray[np.bool_]:
    """Samples (S,) of which a row leaves the state it has in the map at some phases."""
    m, c = given.mesh_count, given.far.size
    size = np.abs(force).max(axis=1, initial=0.0)
    leaves = falls_below(force, wave, phases, -_NONE * size[:, None])
    if c:
        shut = given.flexible.stiffness[m : m + c] > 0
        side = np.where(shut, 1.0, -1.0)
        reach, swing = side * closed[:, m : m + c], side * waves[:, :, m : m + c]
        leaves |= falls_below(reach, swing, phases, np.zeros((len(reach), 1)))
    return leaves


def _phases_of(found: _ClosedContact, at: NDArray[np.int64], phases: int) -> ComplexArray:
    """Units (G, s, T) of the slow phases at which samples are solved: even ones, then those that load a mesh most.

    Those that load it least follow them.
    """
    wave = found.wave[:, at]
    if not len(wave):
        return np.ones((0, at.size, 1), complex)
    even = phase_points(found.phases, phases).T
    same = np.broadcast_to(even[:, None, :], (len(wave), at.size, phases))
    most, least = units_of_largest(found.phases, wave), units_of_largest(found.phases, -wave)
    return np.concatenate([same, most, least], axis=2)


def nominal_signs(given: LoadMap) -> tuple[Array, NDArray[np.bool_]]:
    """Sign (w,) of the load of each mesh in the train of the map, and groups (g,) that carry any."""
    net, found = net_forces(given, (given.stretch.still + given.stretch.torque)[None])
    k = given.flexible.stiffness[: given.mesh_count]
    rows = net[0] if found[0] else k * (given.stretch.still + given.stretch.torque)[: given.mesh_count]
    whole = given.face.total(rows)
    least = _NONE * np.abs(whole).max(initial=0.0)
    sums = np.array([whole[group].sum() for group in given.group])
    sign = np.ones(whole.size)
    for group, value in zip(given.group, sums, strict=True):
        sign[group] = -1.0 if value < -least else 1.0
    return sign, np.asarray(np.abs(sums) > least)
