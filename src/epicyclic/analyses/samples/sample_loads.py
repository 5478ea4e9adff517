"""Load sharing of many samples of one train: closed contact by one product, open contact by active sets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...system.system import Array, ComplexArray
from .load_map import LoadMap
from .mean_load import closed_loads, largest_of_groups, least_forces, loads_at_phases
from .open_contact import net_forces
from .phases import SlowPhases, phase_points, slow_phases, units_of_largest

__all__ = ["METHODS", "ContactMethod", "SampleLoads", "nominal_signs", "sample_loads"]

ContactMethod = Literal["auto", "linear", "static"]
METHODS: tuple[ContactMethod, ...] = get_args(ContactMethod)

# Force that is none, per the largest of the sample.
_NONE = 1e-9
# Slow phases that forces of open contact are averaged over: the additive sequence errs by some 1e-3 of the part of the
# mean that comes from opening.
_PHASES = 64
# Instants of one batch of open samples.
_INSTANTS = 40_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampleLoads:
    """Load sharing of S samples, definitions as of `mean_load.MEAN_LOADS`.

    k : (S, 2, g) coefficient of each group [1], nan of samples that failed and of groups without load.
    load : (S, 2, w) N F_i / sum F of each whole mesh [1].
    least : (S, w) least force of each whole mesh at any slow phases [N].
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
) -> SampleLoads:
    """Load sharing of S samples.

    Parameters
    ----------
    factors : (S, C) on the columns of the map.  torque : factor on the torques, one or (S,).
    rows, stiffness : (V,) mesh rows and links whose stiffness varies, and that (S, V) [N/m].
    method : ``auto`` solves those samples anew whose contact opens, ``static`` all of them, ``linear`` none.
    count : samples, from the first on, that are wanted; the rest only fill a piece up.

    Raises
    ------
    ModelError : no such method.
    """
    if method not in METHODS:
        raise ModelError("no such method", path="method", given=method, allowed=", ".join(METHODS))
    phases = slow_phases(given.frequency)
    still, turning = given.stretches(factors, torque)
    failed = np.zeros(len(factors), bool)
    closed, waves = still, turning
    if rows is not None and stiffness is not None and rows.size:
        failed |= ~((stiffness > 0) & np.isfinite(stiffness)).all(axis=1)
        # samples that failed take the stiffness of the map, so that they do not disturb the others
        stiffness = np.where(failed[:, None], given.flexible.stiffness[rows], stiffness)
        closed, waves = _with_stiffness(given, still, turning, rows, stiffness)
    sign, loaded = nominal_signs(given)
    m = given.mesh_count
    k = np.broadcast_to(given.flexible.stiffness, still.shape).copy()
    if rows is not None and stiffness is not None:
        k[:, rows] = stiffness
    force, wave = k[:, :m] * closed[:, :m], k[:, :m] * waves[:, :, :m]
    leaves = _leaves(given, closed, waves, force, wave, phases)
    total, total_wave = sign * given.face.total(force, axis=1), sign * given.face.total(wave, axis=2)
    load = closed_loads(total, total_wave, given.group, phases)
    least = least_forces(total, total_wave, phases)
    again = np.flatnonzero({"auto": leaves, "linear": np.zeros_like(leaves), "static": ~failed}[method] & ~failed)
    again = again[again < (len(factors) if count is None else count)]
    size = max(1, _INSTANTS // (_PHASES + 2 * total.shape[1]))
    for first in range(0, again.size, size):
        at = again[first : first + size]
        own = None if rows is None or stiffness is None else stiffness[at]
        units = _phases_of(total[at], total_wave[:, at], phases)
        instants = still[at, None] + np.einsum("gst,gsm->stm", units, turning[:, at]).real
        S, T, M = instants.shape
        repeated = None if own is None else np.repeat(own, T, axis=0)
        net, found = net_forces(given, instants.reshape(-1, M), None if own is None else rows, repeated)
        whole = sign * given.face.total(net.reshape(S, T, -1), axis=2)
        mean = total[at] + _opening(whole, total[at], total_wave[:, at], units)
        load[:, at] = loads_at_phases(whole, mean, given.group)
        least[at] = whole.min(axis=1)
        failed[at] |= ~found.reshape(S, T).all(axis=1)
    load = load.transpose(1, 0, 2)
    load[failed], least[failed] = np.nan, np.nan
    for group, any_load in zip(given.group, loaded, strict=True):
        if not any_load:
            load[:, :, group] = np.nan
    return SampleLoads(
        k=largest_of_groups(load, given.group), load=load, least=least, open=leaves & ~failed, failed=failed
    )


def _opening(whole: Array, total: Array, wave: ComplexArray, units: ComplexArray) -> Array:
    """Mean over the even phases of what opening adds to the forces of closed contact, (S, w) [N].

    Forces of closed contact have a known mean, so that only what opening adds is averaged over points.

    whole : (S, T, w) forces.  total, wave : (S, w), (G, S, w) of closed contact.  units : (G, S, T).
    """
    even = _PHASES if len(wave) else 1
    closed = total[:, None] + np.einsum("gst,gsm->stm", units[:, :, :even], wave).real
    added: Array = (whole[:, :even] - closed).mean(axis=1)
    return added


def _with_stiffness(
    given: LoadMap, still: Array, turning: ComplexArray, rows: NDArray[np.int64], stiffness: Array
) -> tuple[Array, ComplexArray]:
    """Stretches (S, M), (G, S, M) [m] where some rows have another stiffness (S, V), all loaded flanks closed."""
    S = given.flexible.to_mesh
    D = given.flexible.stiffness[rows] - stiffness
    matrix = np.eye(rows.size) - S[np.ix_(rows, rows)] * D[:, None, :]
    right = np.concatenate([still[None], turning.real, turning.imag])[:, :, rows]
    own = np.linalg.solve(matrix, right.transpose(1, 2, 0))  # (S, V, 1 + 2 G)
    added = (own * D[:, :, None]).transpose(2, 0, 1) @ S[:, rows].T
    G = len(turning)
    return still + added[0], turning + added[1 : G + 1] + 1j * added[G + 1 :]


def _leaves(
    given: LoadMap, closed: Array, waves: ComplexArray, force: Array, wave: ComplexArray, phases: SlowPhases
) -> NDArray[np.bool_]:
    """Samples (S,) of which a row leaves the state it has in the map at some phases."""
    m, c = given.mesh_count, given.far.size
    size = np.abs(force).max(axis=1, initial=0.0)
    leaves: NDArray[np.bool_] = (least_forces(force, wave, phases) < -_NONE * size[:, None]).any(axis=1)
    if c:
        shut = given.flexible.stiffness[m : m + c] > 0
        side = np.where(shut, 1.0, -1.0)
        reach, swing = side * closed[:, m : m + c], side * waves[:, :, m : m + c]
        leaves |= (least_forces(reach, swing, phases) < 0).any(axis=1)
    return leaves


def _phases_of(total: Array, wave: ComplexArray, phases: SlowPhases) -> ComplexArray:
    """Units (G, S, T) of the slow phases at which open contact is solved: even ones, then the worst of each mesh."""
    even = phase_points(phases, _PHASES)
    G, S, w = wave.shape
    if not G:
        return np.ones((0, S, 1), complex)
    same = np.broadcast_to(even.T[:, None, :], (G, S, len(even)))
    return np.concatenate([same, units_of_largest(phases, wave), units_of_largest(phases, -wave)], axis=2)


def nominal_signs(given: LoadMap) -> tuple[Array, NDArray[np.bool_]]:
    """Sign (w,) of the load of each mesh in the train of the map, and groups (g,) that carry any."""
    net, found = net_forces(given, (given.still + given.torque)[None])
    k = given.flexible.stiffness[: given.mesh_count]
    rows = net[0] if found[0] else k * (given.still + given.torque)[: given.mesh_count]
    whole = given.face.total(rows)
    least = _NONE * np.abs(whole).max(initial=0.0)
    sums = np.array([whole[group].sum() for group in given.group])
    sign = np.ones(whole.size)
    for group, value in zip(given.group, sums, strict=True):
        sign[group] = -1.0 if value < -least else 1.0
    return sign, np.asarray(np.abs(sums) > least)
