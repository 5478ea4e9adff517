"""Which deviation costs most load sharing: K_gamma of the train without each of them, all from one linear map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ...statics.load_map import law_map, load_map
from ...statics.sample_loads import sample_loads
from ...statics.tangent import linear
from ...system.excitation import unit_lines
from ...system.system import Array, System
from ...train.train import Displacement, MeshError, Train
from .names import as_overridden, member_words, rounded

__all__ = ["ErrorView", "error_head", "error_view"]

# What is shown of a list that nobody reads to its end.
_MOST = 12
# Above 1 a K_gamma this close to it is 1; a share below the second is rounding of it.
_NONE, _ROUNDING = 1e-9, 1e-6
_WORDS = {
    "run_out": "run-out",
    "position": "position",
    "bearing_run_out": "bearing run-out",
    "tilt": "tilt",
    "profile": "profile",
    "gap": "gap",
    "pitch": "pitch",
    "errors": "turning error",
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorView:
    """K_gamma without each deviation, of E deviations, by their path in the model file.

    path, label : (E,).  k_gamma, k_turning : of the train as it is [1].  without, without_turning : (E,) the same of
    the train without that deviation [1].
    """

    path: tuple[str, ...]
    label: tuple[str, ...]
    k_gamma: float
    k_turning: float
    without: Array
    without_turning: Array

    @property
    def turning(self) -> bool:
        """Whether nothing stands still in the train that would part the load, so that the turning K_gamma ranks."""
        return not self.k_gamma > 1 + _NONE


def error_view(train: Train, system: System) -> ErrorView | None:
    """K_gamma of a train and of the train without each of its deviations; None without deviations that count.

    What follows the mesh frequency is no part of K_gamma.

    Raises
    ------
    ModelError, ConvergenceError : no load, or a load without equilibrium.
    """
    tones = set(system.tones)
    found: dict[str, list[Displacement | MeshError]] = {}
    deviations: list[Displacement | MeshError] = [*train.displacements, *train.mesh_errors]
    for item in deviations:
        if item.cause != "contact" and not _at_mesh_order(item.frequency, tones) and _size(item) > 0:
            found.setdefault(item.path, []).append(item)
    if not found:
        return None
    items = [item for group in found.values() for item in group]
    columns = unit_lines(train, items)
    given = load_map(linear(system), columns)
    laws = law_map(system, columns) if system.groups else None
    factors = np.zeros((1 + len(found), len(items)))
    last = 0
    for row, group in enumerate(found.values()):
        factors[1 + row, last : last + len(group)] = -1.0
        last += len(group)
    loads = sample_loads(given, factors, laws=laws)
    k = np.array([[_largest(one) for one in sample] for sample in loads.k])
    return ErrorView(
        path=tuple(found),
        label=tuple(_label(train, group) for group in found.values()),
        k_gamma=float(k[0, 0]),
        k_turning=float(k[0, 1]),
        without=k[1:, 0],
        without_turning=k[1:, 1],
    )


def _at_mesh_order(frequency: Fraction, tones: set[Fraction]) -> bool:
    """Whether a frequency above zero is a multiple of a mesh frequency."""
    return frequency != 0 and any((frequency / tone).denominator == 1 for tone in tones)


def _largest(values: Array) -> float:
    """Largest value that is known, nan where none is."""
    known = values[~np.isnan(values)]
    return float(known.max()) if known.size else float("nan")


def _size(item: Displacement | MeshError) -> float:
    """Largest amplitude of a deviation [m, rad]."""
    return abs(item.amplitude) if isinstance(item, MeshError) else float(np.abs(item.vector).max(initial=0.0))


def _label(train: Train, group: Sequence[Displacement | MeshError]) -> str:
    """A deviation in words with its size: ``pin position of planet 1, 20 um``."""
    first = group[0]
    word = _WORDS.get(first.cause, first.cause.replace("_", " "))
    sizes = sorted({float(rounded(_length(item))) for item in group})
    unit = "um"
    if isinstance(first, Displacement) and np.any(first.vector[3:]) and not np.any(first.vector[:3]):
        unit = "urad"
    size = " to ".join(rounded(value) for value in ([sizes[0], sizes[-1]] if len(sizes) > 1 else sizes))
    return f"{_whose(train, group, word)}, {size} {unit}"


def _length(item: Displacement | MeshError) -> float:
    """Length of a deviation [um, urad]: radius of what turns, length of what stands still."""
    if isinstance(item, MeshError):
        return 1e6 * abs(item.amplitude)
    own = item.vector[:3] if np.any(item.vector[:3]) else item.vector[3:]
    # of a turning vector (1, -i) r the radius is that of either component
    length = np.abs(own).max() if item.frequency != 0 else float(np.linalg.norm(own))
    return 1e6 * float(length)


def _whose(train: Train, group: Sequence[Displacement | MeshError], word: str) -> str:
    """The kind of deviation with the bodies or the pair that have it."""
    first = group[0]
    if isinstance(first, MeshError):
        mesh = next(one for one in train.meshes if one.name == first.mesh)
        stage = f"{mesh.stage} " if len(train.planets) > 1 else ""
        return f"{word} of {stage}{mesh.pair.rpartition('.')[2]}"
    bodies = {body.name: body for body in train.bodies}
    own = [bodies[item.body] for item in group if isinstance(item, Displacement)]
    branches = sorted({body.branch for body in own if body.branch is not None})
    pins = own[0].kind == "planet" and first.cause == "position"
    whose = member_words(train, own[0].member, branches)
    # all of a member are "the planets", some of them "planets 1, 2"
    numbered = whose[-1].isdigit()
    return f"{'pin ' if pins else ''}{word} of {'' if numbered else 'the '}{whose}"


def error_head(view: ErrorView, overrides: Mapping[str, object]) -> tuple[dict[str, Any], dict[str, Array]]:
    """``head["errors"]`` and its arrays, those that cost most first: ``share`` (row,) of what K_gamma is above 1 that
    goes with the deviation [%], ``turning`` the same of the largest over the hunting period [%], ``without`` (row,)
    K_gamma without it [1].
    """
    k, without = (view.k_turning, view.without_turning) if view.turning else (view.k_gamma, view.without)
    share, turning = _share(k, without), _share(view.k_turning, view.without_turning)
    order = np.lexsort((-turning, -share))[:_MOST]
    head = {
        "rows": [
            {
                "label": view.label[i],
                "path": as_overridden(view.path[i], overrides),
                "share": float(share[i]),
                "turning": float(turning[i]),
                "without": float(without[i]),
            }
            for i in order
        ],
        "of": "K_gamma while turning" if view.turning else "mean-load K_gamma",
        "unit": "%",
        "k_gamma": k,
    }
    return head, {"share": share[order], "turning": turning[order], "without": without[order]}


def _share(k: float, without: Array) -> Array:
    """Share of K_gamma above 1 that goes with each deviation, (E,) [%]; 0 where there is none."""
    above = k - 1
    if not above > _NONE:
        return np.zeros(len(without))
    share = np.nan_to_num((k - without) / above)
    result: Array = np.where(np.abs(share) < _ROUNDING, 0.0, 100 * share)
    return result
