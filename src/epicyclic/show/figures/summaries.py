"""What tables, key figures and figures read alike: members, groups of modes, sums over branches, largest values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from ...results.ties import EQUAL, largest
from .series import Array, numbers, short_names, split_name, stage_count, texts

__all__ = [
    "Member",
    "ModeGroup",
    "by_pair_and_side",
    "largest_coefficients",
    "losses_of_pairs",
    "members_of",
    "mesh_tones",
    "mode_groups",
    "of_first_stage",
    "own_tones",
    "ramps",
    "readable",
    "stability_verdict",
    "summed_shares",
]

# Definitions of load sharing by the size of a deviation, too much or too little [ren2021, eq. 21-24].
_BY_SIZE = ("cycle-peak", "worst-case")


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """One member: all bodies of one name in the model file.

    count : bodies.  speed [rpm]; torque [N m] and power [W] all bodies together; mass [kg] of one body.
    """

    name: str
    kind: str
    count: int
    speed: float
    torque: float
    power: float
    mass: float
    inertia: float


def members_of(check: xr.Dataset) -> list[Member]:
    """Members in the order of their first body."""
    names, kinds = texts(check, "member", "body"), texts(check, "kind", "body")
    values = {name: numbers(check, name, "body") for name in ("speed", "torque", "power", "mass", "inertia")}
    found = []
    for name in dict.fromkeys(names):
        own = [place for place, other in enumerate(names) if other == name]
        found.append(
            Member(
                name=name,
                kind=kinds[own[0]],
                count=len(own),
                speed=float(values["speed"][own[0]]),
                torque=float(values["torque"][own].sum()),
                power=float(values["power"][own].sum()),
                mass=float(values["mass"][own[0]]),
                inertia=float(values["inertia"][own[0]]),
            )
        )
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeGroup:
    """Modes of one frequency: first mode (from 1), frequency [Hz], kind, multiplicity."""

    first: int
    frequency: float
    kind: str
    multiplicity: int


def mode_groups(modes: xr.Dataset) -> list[ModeGroup]:
    """Modes of equal frequency put together, as their multiplicity says."""
    hertz, kinds = numbers(modes, "frequency"), texts(modes, "mode_kind", "mode")
    counts = np.nan_to_num(numbers(modes, "multiplicity", "mode"), nan=1.0)
    found: list[ModeGroup] = []
    place = 0
    while place < len(hertz):
        several = max(1, int(counts[place]))
        one = ModeGroup(first=place + 1, frequency=float(hertz[place]), kind=kinds[place], multiplicity=several)
        found.append(one)
        place += several
    return found


def mesh_tones(check: xr.Dataset | None) -> dict[str, float]:
    """Mesh frequency of each stage that turns [Hz]."""
    if check is None or "mesh_frequency" not in check.variables:
        return {}
    tones = zip(texts(check, "stage"), numbers(check, "mesh_frequency"), strict=True)
    return {stage: float(tone) for stage, tone in tones if np.isfinite(tone) and tone > 0}


def of_first_stage(result: xr.Dataset) -> str:
    """Of which stage ``mesh_frequency`` of a result is, `` of one``; "" where there is one stage."""
    names = texts(result, "mesh") if "mesh" in result.variables else []
    return f" of {names[0].split('/')[0]}" if stage_count(names) > 1 else ""


def own_tones(result: xr.Dataset) -> Array:
    """Mesh frequency of every mesh per that of the first mesh, (w,) [1]."""
    return numbers(result, "mesh_tone") if "mesh_tone" in result.variables else np.ones(result.sizes["mesh"])


def summed_shares(names: Sequence[str], shares: Array) -> tuple[list[str], Array]:
    """Shares of all branches and sides of one pair, link or member added up.

    Parameters
    ----------
    names : (p,) names such as ``main/sun-planet/2/left``.  shares : (p, modes).

    Returns
    -------
    names of the groups (g,), shares (g, modes).
    """
    keys = ["/".join(word for word in name.split("/") if not word.isdigit() and word not in _SIDES) for name in names]
    unique = list(dict.fromkeys(keys))
    total = np.array([shares[[place for place, key in enumerate(keys) if key == one]].sum(axis=0) for one in unique])
    return [name.replace("/", " ") for name in short_names(unique)], total.reshape(len(unique), -1)


_SIDES = ("left", "right")


def readable(name: str) -> str:
    """``cycle-peak`` -> ``cycle peak``."""
    return name.replace("_", " ").replace("-", " ")


def largest_coefficients(sharing: xr.Dataset) -> list[tuple[str, float, str]]:
    """Largest coefficient by each definition and the mesh that has it.

    Definitions by the size of a deviation count meshes that carry more than their share alone: a mesh that carries too
    little is no overload.
    """
    values = sharing["load_sharing"].transpose("definition", "mesh").values
    names, definitions = texts(sharing, "mesh"), texts(sharing, "definition")
    found = []
    for definition, row in zip(definitions, values, strict=True):
        if definition in _BY_SIZE and "signed-overload" in definitions:
            over = values[definitions.index("signed-overload")]
            row = np.where(~(over < 1 - EQUAL), row, np.nan)
        if np.isfinite(row).any():
            place = largest(row, equal=EQUAL)
            found.append((definition, float(row[place]), names[place]))
    return found


def ramps(result: xr.Dataset) -> bool:
    """Whether the speed changes in a run."""
    frequency = result["mesh_frequency"].values
    return bool(np.ptp(frequency) > 1e-9 * np.max(frequency))


def by_pair_and_side(names: list[str]) -> dict[tuple[str, str], list[int]]:
    """Meshes of each pair and side, by their names ``stage/pair/branch/side``."""
    found: dict[tuple[str, str], list[int]] = {}
    for i, name in enumerate(names):
        stage, pair, *rest = name.split("/")
        side = rest[-1] if rest and not rest[-1].isdigit() else ""
        found.setdefault((f"{stage}/{pair}", side), []).append(i)
    return found


def stability_verdict(kind: np.ndarray, points: str) -> str:
    """Headline of instability (...), "" where nothing is known: what was judged, and what could not be.

    points : what is counted, ``speeds`` or ``points`` of a map.
    """
    judged, unstable = int(np.sum(kind != "")), int(np.sum((kind != "") & (kind != "stable")))
    if not judged:
        return f"Stability not known at any of {kind.size} {points}"
    left = f", not known at {kind.size - judged}" if judged < kind.size else ""
    found = f"Unstable at {unstable} of {judged} {points}" if unstable else f"Stable at {judged} {points}"
    return (found + " judged" if left else found) + left


def losses_of_pairs(names: list[str], loss: Array) -> list[tuple[str, str, float]]:
    """Stage, pair and loss [W] of all branches and sides, of meshes (w,) by name, in their order."""
    found: dict[tuple[str, str], float] = {}
    for name, value in zip(names, loss, strict=True):
        stage, pair, _, _ = split_name(name)
        found[stage, pair] = found.get((stage, pair), 0.0) + float(value)
    return [(stage, pair, value) for (stage, pair), value in found.items()]
