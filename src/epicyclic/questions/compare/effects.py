"""What one train does: ratio, speeds, modes, load sharing and mesh forces at operation; and what it cannot say.

Modes of two trains are paired by their shapes where the coordinates are the same, else by kind and order.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal, TypeVar

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from ...errors import ConvergenceError, ModelError
from ...results.ties import largest
from ...statics.tangent import linear
from ...system.assembly import assemble
from ...system.system import System
from ...train.train import Train
from ...warning_codes import CodedText, coded
from ..modes.eigen import classify_modes, mean_modes, repeated_roots
from ..sharing.sharing import sharing

Array = NDArray[np.float64]
BY_SHAPE, BY_KIND = "mode shapes (MAC)", "kind and order"
T = TypeVar("T")
Method = Literal["steady", "static"]
_RIGID = "rigid"
# Coefficients of meshes this close are equal but for rounding of the linear solves: no mesh is the worst.
_ALIKE = 1e-6


# --- modes of two trains ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrainModes:
    """Modes of the undamped mean system of one train, rising.

    squared : (n,) omega^2 [rad^2/s^2].  vectors : (n, n), Phi^T M Phi = 1.  mass : M (n, n).  kind : (n,).
    dofs : (n,) names of the coordinates.
    """

    squared: Array
    vectors: Array
    mass: Array
    kind: tuple[str, ...]
    dofs: tuple[str, ...]

    @property
    def frequency(self) -> Array:
        """Natural frequencies (n,) [Hz]."""
        return np.asarray(np.sqrt(self.squared) / (2 * np.pi))


def mode_pairs(a: TrainModes, b: TrainModes) -> tuple[NDArray[np.int64], Array, str]:
    """Mode of b that each mode of a corresponds to.

    Returns
    -------
    (place in b (n,), -1 without one; modal assurance criterion (n,) [1], nan where modes are paired by kind; which of
    `BY_SHAPE` and `BY_KIND`).
    """
    if a.dofs == b.dofs:
        return *_by_shape(a, b), BY_SHAPE
    place = _by_kind(a.kind, b.kind)
    return place, np.full(place.size, np.nan), BY_KIND


def _by_shape(a: TrainModes, b: TrainModes) -> tuple[NDArray[np.int64], Array]:
    """Pairs of the largest sum of modal assurance criteria [allemang1982] with the mean of both M as weight.

    Of repeated roots the shapes are any basis of an eigenspace: the criterion is that of the eigenspaces, the share of
    the smaller one that lies in the other.
    """
    mass = (a.mass + b.mass) / 2
    left, right = (phi / np.sqrt(np.einsum("ij,ik,kj->j", phi, mass, phi)) for phi in (a.vectors, b.vectors))
    overlap = (left.T @ mass @ right) ** 2
    criterion = np.empty_like(overlap)
    for of_a in repeated_roots(a.squared):
        for of_b in repeated_roots(b.squared):
            block = overlap[of_a, of_b]
            criterion[of_a, of_b] = block.sum() / min(block.shape)
    criterion = np.clip(criterion, 0.0, 1.0)
    _, place = scipy.optimize.linear_sum_assignment(criterion, maximize=True)
    return np.asarray(place, dtype=np.int64), criterion[np.arange(place.size), place]


def _by_kind(a: Sequence[str], b: Sequence[str]) -> NDArray[np.int64]:
    """The k-th mode of a kind to the k-th of the same kind."""
    ranks = [(kind, list(b[:i]).count(kind)) for i, kind in enumerate(b)]
    place = {rank: i for i, rank in enumerate(ranks)}
    return np.array([place.get((kind, list(a[:i]).count(kind)), -1) for i, kind in enumerate(a)], dtype=np.int64)


# --- effects of one train --------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Effects:
    """What a train does; what is not known is empty or nan.

    ratio : speed of the driving member per speed of the driven one [1].  speed : of members [rpm].
    mesh_frequency : of stages [Hz].  modes : of the mean system.
    k_gamma : `mean-load` of the train [1], and the mesh it is of, empty where all are alike.
    method : of the mesh forces.
    meshes : name -> coefficient `mean-load` [1], mean and largest force of the whole mesh [N].
    """

    ratio: float = math.nan
    speed: Mapping[str, float] = field(default_factory=dict)
    mesh_frequency: Mapping[str, float] = field(default_factory=dict)
    modes: TrainModes | None = None
    k_gamma: float = math.nan
    worst_mesh: str = ""
    method: str = ""
    meshes: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    warnings: tuple[CodedText, ...] = ()


def effects_of(train: Train, *, methods: Sequence[Method] = ("steady", "static")) -> Effects:
    """Effects of one train; an analysis that its model does not allow is left out, and a warning says why.

    methods : of the mesh forces, the first that the model allows counts.
    """
    said: list[CodedText] = list(train.warnings)
    speeds, frequencies = train.kinematics.speed or {}, train.kinematics.mesh_frequency or {}
    effects = Effects(
        ratio=_ratio(train),
        speed={name: float(value) for name, value in speeds.items()},
        mesh_frequency={stage: float(value) for stage, value in frequencies.items()},
    )
    system = _tried("equations", lambda: assemble(train), said)
    if system is not None:
        effects = replace(effects, modes=_tried("natural frequencies", lambda: _modes(system), said))
        effects = _with_loads(effects, system, methods, said)
    return replace(effects, warnings=tuple(dict.fromkeys(said)))


def _tried(what: str, run: Callable[[], T], said: list[CodedText]) -> T | None:
    """What a function gives; None and a warning where the model does not allow it."""
    try:
        return run()
    except (ModelError, ConvergenceError) as error:
        said.append(coded("section-left-out", f"no {what}: {error}"))
        return None


def _ratio(train: Train) -> float:
    """Speed of the member that takes in most power per speed of the one that gives off most."""
    power, speed = train.kinematics.power or {}, train.kinematics.speed or {}
    if not power or max(power.values()) <= 0 or min(power.values()) >= 0:
        return math.nan
    driving, driven = max(power, key=lambda name: power[name]), min(power, key=lambda name: power[name])
    return float(speed[driving] / speed[driven]) if speed.get(driven) else math.nan


def _modes(system: System) -> TrainModes:
    tangent = linear(system)
    squared, vectors = mean_modes(tangent)
    kinds = classify_modes(tangent, squared, vectors)
    return TrainModes(
        squared=squared,
        vectors=np.real(kinds.vectors),
        mass=tangent.M,
        kind=tuple(_RIGID if value == 0 else kind for kind, value in zip(kinds.kind, squared, strict=True)),
        dofs=tuple(tangent.dofs.names),
    )


def _with_loads(effects: Effects, system: System, methods: Sequence[Method], said: list[CodedText]) -> Effects:
    """The same with K_gamma and mesh forces by the first method that the model allows."""
    refused: list[CodedText] = []
    for method in methods:
        result = _tried(f"mesh forces by {method}", partial(sharing, system, method=method), refused)
        if result is None:
            continue
        said += [*refused, *json.loads(result.attrs["warnings"])]
        names = [str(name) for name in result.mesh.values]
        coefficient = result.load_sharing.sel(definition="mean-load").values
        mean, most = result.mesh_force_mean.values.tolist(), result.mesh_force_peak.values.tolist()
        rows = zip(coefficient.tolist(), mean, most, strict=True)
        known = coefficient[np.isfinite(coefficient)]
        alike = not known.size or np.ptp(known) <= _ALIKE
        return replace(
            effects,
            k_gamma=float(result.system_load_sharing.sel(definition="mean-load")),
            worst_mesh="" if alike else names[largest(coefficient)],
            method=method,
            meshes={
                name: (float(k), float(mean), float(most)) for name, (k, mean, most) in zip(names, rows, strict=True)
            },
        )
    said += refused[-1:]
    return effects
