"""Between a Dataset and what is shown of it: what tables, key figures and charts read alike.  No plotly.

Plain arrays, short names, curves that coincide drawn once, long records thinned; members, groups of modes, sums over
branches, largest values; of tolerances short names of drawing entries, per cent, histograms on even bins.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..limits import JUDGED_AT
from ..results.dataset import EQUAL, first_largest, largest

Array = NDArray[np.float64]
Key = TypeVar("Key")
One = TypeVar("One")
# Values whose spread is below this part of them are one level: what differs is rounding of what was computed.
_LEVEL = 1e-9
# Definitions of load sharing by the size of a deviation, too much or too little [ren2021, eq. 21-24].
_BY_SIZE = ("cycle-peak", "worst-case")
_SIDES = ("left", "right")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Series:
    """One curve, or several that coincide: what it belongs to, and its values.

    stage, pair, side ("" = none or both).  note : " L, R" of both sides.  equal : branches that the curve is of, 0 of
    none.  values : (k,).
    """

    stage: str
    pair: str
    side: str
    note: str = ""
    equal: tuple[int, ...]
    values: Array

    @property
    def branch(self) -> int:
        """The first of its branches."""
        return self.equal[0]

    @property
    def label(self) -> str:
        """What it is in a legend."""
        several = len(self.equal) > 1
        who = f"branch{'es' if several else ''} {spans(self.equal)}" if self.branch else self.pair
        return f"{who}{self.note or (self.side and f' {self.side[0].upper()}')}{' alike' if several else ''}"


def numbers(data: xr.Dataset, name: str, dim: str = "") -> Array:
    """Values of a variable as floats; nan along `dim` where the Dataset has no such variable."""
    if name in data.variables:
        return np.asarray(data.variables[name].values, dtype=np.float64)
    return np.full(data.sizes[dim], np.nan)


def texts(data: xr.Dataset, name: str, dim: str = "") -> list[str]:
    """Values of a variable as strings; empty along `dim` where the Dataset has no such variable."""
    if name in data.variables:
        return [str(value) for value in data.variables[name].values]
    return [""] * data.sizes[dim]


def grouped(keys: Iterable[Key], values: Iterable[One]) -> dict[Key, list[One]]:
    """Values of each key, keys in order of appearance."""
    found: dict[Key, list[One]] = {}
    for key, value in zip(keys, values, strict=True):
        found.setdefault(key, []).append(value)
    return found


def split_name(name: str) -> tuple[str, str, int, str]:
    """Stage, pair or member, branch (0 = none) and side of ``stage/pair[/branch][/side]``."""
    parts = name.split("/")
    side = parts.pop() if parts[-1] in ("left", "right") else ""
    branch = int(parts.pop()) if parts[-1].isdigit() else 0
    stage = parts[0] if len(parts) > 1 else ""
    return stage, "/".join(parts[1:]) if len(parts) > 1 else parts[0], branch, side


def label(name: str, *, stage: bool) -> str:
    """Short name for a legend: ``main/sun-planet/2/left`` -> ``sun-planet 2 L``, behind its stage where asked for."""
    where, pair, branch, side = split_name(name)
    parts = [where if stage else "", pair, str(branch) if branch else "", side[:1].upper()]
    return " ".join(part for part in parts if part)


def short_names(names: Sequence[str]) -> list[str]:
    """Short names; the stage is left out where there is only one."""
    several = len({split_name(name)[0] for name in names if "/" in name}) > 1
    return [label(name, stage=several) for name in names]


def pair_titles(pairs: Collection[tuple[str, str]]) -> list[str]:
    """Names of pairs of gears, each behind its stage where there are several."""
    several = len({stage for stage, _ in pairs}) > 1
    return [f"{stage}: {pair}" if several and stage else pair for stage, pair in pairs]


def pair_names(paths: Sequence[str]) -> list[str]:
    """``sun-planet`` of ``stages.main.meshes.sun-planet``, behind its stage where there are several."""
    return pair_titles([(part[1], part[-1]) for part in (path.split(".") for path in paths)])


def by_panel(series: Sequence[Series]) -> dict[str, list[Series]]:
    """Title of the panel of each pair of gears, in order of appearance, and its curves."""
    pairs = grouped(((one.stage, one.pair) for one in series), series)
    return dict(zip(pair_titles(pairs), pairs.values(), strict=True))


def merged(names: Sequence[str], values: Array, *, branches: bool = False) -> list[Series]:
    """Curves of meshes, where the left and right helix coincide one for both.

    Parameters
    ----------
    names : (m,) mesh names.  values : (m, k).  branches : also one for all branches of a pair that coincide, so that
        no curve lies under another; its label counts them.
    """
    kept: dict[tuple[str, str, int], list[Series]] = {}
    for name, row in zip(names, np.atleast_2d(values), strict=True):
        stage, pair, branch, side = split_name(name)
        same = kept.setdefault((stage, pair, branch), [])
        one = Series(stage=stage, pair=pair, side=side, equal=(branch,), values=row)
        twin = next((place for place, other in enumerate(same) if _coincide(other.values, row)), None)
        if twin is None:
            same.append(one)
        else:
            same[twin] = replace(one, side="", note=" L, R")
    found = [one for group in kept.values() for one in group]
    return _equal_branches(found) if branches else found


def _equal_branches(every: list[Series]) -> list[Series]:
    """Curves of one pair and side that coincide as one."""
    groups: list[list[Series]] = []
    for one in every:
        group = next((group for group in groups if _alike(group[0], one)), [])
        groups += [] if group else [group]
        group.append(one)
    return [replace(group[0], equal=tuple(one.branch for one in group)) for group in groups]


def _alike(one: Series, other: Series) -> bool:
    same = (one.stage, one.pair, one.side, one.note) == (other.stage, other.pair, other.side, other.note)
    return same and one.branch > 0 and other.branch > 0 and _coincide(one.values, other.values)


def equal_runs(values: NDArray[Any]) -> list[NDArray[np.int64]]:
    """Places of equal values (k,) that follow each other, run by run."""
    return np.split(np.arange(len(values)), np.flatnonzero(values[1:] != values[:-1]) + 1) if len(values) else []


def spans(branches: Sequence[int]) -> str:
    """Numbers in short: ``1–3, 5``; two that follow each other stay two."""
    own = np.sort(branches)
    runs = [own[run] for run in equal_runs(own - np.arange(len(own)))]
    return ", ".join(f"{run[0]}–{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)


def _coincide(one: Array, other: Array) -> bool:
    """Whether two curves (k,) lie closer than a line is wide on any screen."""
    scale = float(np.nanmax(np.abs(one), initial=0.0))
    return bool(np.allclose(one, other, rtol=0, atol=1e-4 * scale, equal_nan=True))


def thinned(x: Array, y: Array, *, most: int = 1200) -> tuple[Array, Array]:
    """A long record with fewer samples, highest and lowest of each stretch kept, so that peaks survive.

    Parameters
    ----------
    x, y : (k,).  most : samples left at most.
    """
    stretch = -(-len(x) // (most // 2))
    if len(x) <= most or stretch < 2 or bool(np.isnan(y).any()):
        return x, y
    count = len(x) // stretch
    block = y[: count * stretch].reshape(count, stretch)
    first = np.arange(count) * stretch
    picks = np.sort(np.stack([first + block.argmin(axis=1), first + block.argmax(axis=1)], axis=1), axis=1)
    keep = np.concatenate([picks.ravel(), np.arange(count * stretch, len(x))])
    return x[keep], y[keep]


def kept_apart(at: ArrayLike, order: Iterable[int], distance: float, most: int | None = None) -> list[int]:
    """Places, in their order, whose values stand further from each other than a distance: names there have room.

    Parameters
    ----------
    at : (k,).  order : places in it, the first ones first.  most : places kept at most.
    """
    values, kept = np.asarray(at, dtype=np.float64), list[int]()
    for place in order:
        if all(abs(values[place] - values[other]) > distance for other in kept):
            kept.append(int(place))
    return kept[:most]


Box = tuple[float, float, float, float]
"""Middle right and up, width and height of a name in a figure."""


def has_room(one: Box, taken: Iterable[Box]) -> bool:
    """Whether a box lies on none of those that are taken."""
    return all(
        abs(one[0] - other[0]) >= (one[2] + other[2]) / 2 or abs(one[1] - other[1]) >= (one[3] + other[3]) / 2
        for other in taken
    )


def compact(values: ArrayLike, *, digits: int = 5) -> list[float | None]:
    """Values (k,) rounded to so many significant digits of the largest, as a list (short JSON); nan -> None (a gap).

    Values that lie close together keep three digits of their spread, so that no curve becomes a staircase.
    """
    array = np.asarray(values, dtype=np.float64).ravel()
    finite = array[np.isfinite(array)]
    top = float(np.abs(finite).max()) if finite.size else 0.0
    places = digits - 1 - math.floor(math.log10(top)) if top > 1e-200 else 0
    spread = float(np.ptp(finite)) if finite.size else 0.0
    if spread > max(_LEVEL * top, 1e-200):
        places = max(places, 2 - math.floor(math.log10(spread)))
    rounded = np.round(array, places) + 0.0  # without -0.0
    return [value if math.isfinite(value) else None for value in rounded.tolist()]


ARCMIN = 180 * 60 / np.pi
"""Minutes of arc per radian."""
ARCSEC = 60 * ARCMIN


def engineering(value: float, digits: int = 4) -> str:
    """A number to read: so many significant digits, no exponent between 0.001 and a million, nothing for nan."""
    if not np.isfinite(value):
        return "" if np.isnan(value) else ("∞" if value > 0 else "-∞")
    if value == 0:
        return "0"
    if not 1e-3 <= abs(value) < 1e6:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        shown = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        return f"{shown}e{int(exponent)}"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{places}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def stage_count(names: Iterable[str]) -> int:
    """Number of stages of names of meshes, ``stage/gear-gear[/branch][/side]``; other names count for none."""
    parts = [split_name(name) for name in names]
    return len({stage for stage, pair, _, _ in parts if stage and "-" in pair and "/" not in pair})


def unbroken(mesh: str, *, stages: int = 1) -> str:
    """Short name of a mesh that does not break over a line; with its stage where the train has several."""
    return label(mesh, stage=stages > 1).replace(" ", "\u00a0").replace("-", "\u2011")


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
    for name, own in grouped(names, range(len(names))).items():
        alike = {field: float(values[field][own[0]]) for field in ("speed", "mass", "inertia")}
        summed = {field: float(values[field][own].sum()) for field in ("torque", "power")}
        found.append(Member(name=name, kind=kinds[own[0]], count=len(own), **alike, **summed))
    return found


class ModeGroup(NamedTuple):
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
        found.append(ModeGroup(place + 1, float(hertz[place]), kinds[place], several))
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
    groups = grouped(keys, range(len(keys)))
    total = np.array([shares[own].sum(axis=0) for own in groups.values()]).reshape(len(groups), -1)
    return [name.replace("/", " ") for name in short_names(list(groups))], total


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
    parts = map(split_name, names)
    return grouped(((f"{stage}/{pair}", side) for stage, pair, _, side in parts), range(len(names)))


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
    pairs = grouped((split_name(name)[:2] for name in names), loss.tolist())
    return [(stage, pair, sum(losses)) for (stage, pair), losses in pairs.items()]


DRAWN = (0.5, 0.95, 0.99)
"""Probabilities of figures and key figures."""

_TABLES = ("deviations", "stages", "operation", "meshes")


def ring_deflection(names: Sequence[str], angle: Array) -> Array:
    """Motion of the centre line of a ring that bends, at polar angles (P,) [rad], per coordinate (e,), (2, P, e) [1].

    Outward and along, w and v.  names : a2, b2, .. of w = a cos n psi + b sin n psi, v = (b cos - a sin)/n; of a ring
    that stretches also a0, its breathing, and c1, d1, c2, .. of what does not keep its length
    (docs/conventions.md, A ring that bends).
    """
    moved = np.zeros((2, len(angle), len(names)))
    for i, name in enumerate(names):
        part, n = name[0], int(name[1:])
        cos, sin = np.cos(n * angle), np.sin(n * angle)
        out, along = (cos, -sin) if part in "ac" else (sin, cos)
        if part in "ab":
            moved[:, :, i] = out, along / max(n, 1)
        else:
            moved[:, :, i] = (out, -along) if n == 1 else (0 * out, along)
    return moved


def bent_rows(names: Sequence[str]) -> dict[str, dict[str, int]]:
    """Ring that bends -> name a2, b2, .. of each coordinate by which it does and its place among ``main/ring/a2`` .."""
    found: dict[str, dict[str, int]] = {}
    for i, name in enumerate(names):
        body, _, word = name.rpartition("/")
        if word[:1] in tuple("abcd") and word[1:].isdigit():  # matrices of another program have e1, e2, ..
            found.setdefault(body, {})[word] = i
    return found


def percent(probability: float) -> str:
    """A probability as per cent: ``99.9 %``."""
    return f"{100 * probability:.10g}\u00a0%"


def share_of_trains(result: xr.Dataset) -> str:
    """``99 % of the trains`` of a result of `allocate`, over load cases of their time."""
    what = "the time of all trains" if "case" in result.dims else "the trains"
    return f"{percent(float(result.attrs['probability']))} of {what}"


def short_entries(paths: Sequence[str]) -> list[str]:
    """Drawing entries in short: without table and kind of branch, without their stage where all are of one."""
    rows = [path.split(".") for path in paths]
    stages = {_stage(row) for row in rows}
    dropped = {*_TABLES, *(stages if len(stages) == 1 else ())}
    return [" ".join(word for word in row if word not in dropped).replace("_", "-") for row in rows]


def _stage(row: Sequence[str]) -> str:
    """``main`` of ``deviations.main.planet.position`` and of ``operation.torque.main.carrier``."""
    return row[2] if row[0] == "operation" and len(row) > 3 else row[1] if len(row) > 1 else row[0]


def pair_labels(names: Sequence[str]) -> list[str]:
    """Groups of meshes, pair and side: ``main.meshes.sun-planet.left`` -> ``sun-planet L``; stages where several."""
    rows = [name.split(".") for name in names]
    several = len({row[0] for row in rows}) > 1
    found = []
    for stage, *rest in rows:
        words = [word for word in rest if word != "meshes"] or [stage]
        words = [word[0].upper() if word in ("left", "right") else word for word in words]
        found.append(" ".join([stage, *words] if several and rest else words))
    return found


def scattering_pair(one: xr.Dataset) -> int:
    """Place of the pair whose K_gamma scatters most, of equal ones the first; 0 where the scatter is not known."""
    return largest(one["k_gamma_std"].values, equal=EQUAL) if "k_gamma_std" in one else 0


def micrometres(result: xr.Dataset) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Entries (tolerance,) whose spread is a length, so that a slope per micrometre means something."""
    return np.array([unit == "m" for unit in texts(result, "tolerance_unit", "tolerance")], dtype=bool)


def of_definition(result: xr.Dataset, definition: str = "") -> xr.Dataset:
    """A result of one definition, `mean-load` where not said, else the first; as it is without such a dimension."""
    if "definition" not in result.dims:
        return result
    names = texts(result, "definition")
    wanted = definition or "mean-load"
    return result.isel(definition=names.index(wanted) if wanted in names else 0)


def system_quantiles(result: xr.Dataset) -> dict[float, float]:
    """K_gamma of the train that is not exceeded with each of the probabilities `DRAWN` that the result has."""
    given = np.asarray(result["probability"].values, dtype=np.float64)
    values = of_definition(result)["system_k_gamma_quantile"].values
    pairs = {float(p): float(values[i]) for p in DRAWN for i in np.flatnonzero(np.isclose(given, p))}
    return {p: value for p, value in pairs.items() if np.isfinite(value)}


def judged_quantile(result: xr.Dataset) -> tuple[float, float]:
    """The largest probability that is drawn and that the trains tell, at which K_gamma is judged, and K_gamma of the
    train there; nan where none is known."""
    quantiles = system_quantiles(result)
    p = max(quantiles, default=math.nan)
    return p, quantiles.get(p, math.nan)


class TenthLess(NamedTuple):
    """What a tenth less spread of each tolerance changes of the K_gamma that is held against its limit, (E,) each [1].

    order : of the entries by their places.  first, last : places of each, alike of those that the samples do not tell
    apart.  value, low, high : of the change.  probability : at which.  samples : that it was estimated on.
    """

    order: list[int]
    first: np.ndarray[tuple[int], np.dtype[np.int64]]
    last: np.ndarray[tuple[int], np.dtype[np.int64]]
    value: Array
    low: Array
    high: Array
    probability: float
    samples: int

    def place(self, entry: int) -> str:
        """``2``, or ``2-3`` of tied ones."""
        first, last = int(self.first[entry]), int(self.last[entry])
        return f"{first}" if first == last else f"{first}-{last}"

    def banded(self, entry: int) -> str:
        """The change with its band."""
        return banded(*(float(ends[entry]) for ends in (self.value, self.low, self.high)))

    def tied_first(self) -> list[int]:
        """Entries of the first place."""
        return [entry for entry in self.order if self.first[entry] == 1]


def tenth_less(result: xr.Dataset) -> TenthLess:
    """The ranking of a result of `tolerance`, as its analysis has it; of the pair that is judged, or of the train."""
    one, pair = of_definition(result), str(result.attrs.get("ranked_pair", ""))
    kind = "tenth_less" if pair else "system_tenth_less"
    at = int(np.flatnonzero(numbers(result, "probability") <= JUDGED_AT + 1e-9)[-1])
    judged = (one.sel(pair=pair) if pair else one).isel(probability=at)
    value, low, high = (numbers(judged, f"{kind}{end}") for end in ("", "_low", "_high"))
    first, last = (result[f"tenth_less_{name}"].values.astype(np.int64) for name in ("place", "last_place"))
    order, samples = np.lexsort((np.nan_to_num(value), first)).tolist(), int(result.attrs.get("ranking_samples", 0))
    return TenthLess(order, first, last, value, low, high, float(numbers(result, "probability")[at]), samples)


def banded(value: float, low: float, high: float) -> str:
    """A number with the ends of its band, to two digits of the band; nothing of one that is not known."""
    if not np.isfinite(value):
        return ""
    half = max(value - low, high - value)
    if not half > 0:
        return f"{value + 0.0:.3g}"  # without -0
    digits = max(0, 1 - math.floor(math.log10(half)))
    return f"{value:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def share_with_band(value: float, low: float, high: float) -> str:
    """A share [1] in per cent with its band; in words where the estimate lies beyond none or all."""
    if not np.isfinite(value) or value == low == high == 0:
        return "" if not np.isfinite(value) else "0"
    ends = f"[{100 * low:.1f}, {100 * high:.1f}]" if np.isfinite(low) else ""
    words = "about all" if value > 1 else "about none" if value < 0 else f"{100 * value:.1f}"
    return f"{words} {ends}".strip()


def overlap(one: xr.Dataset) -> str:
    """Whether shares of the variance with interactions overlap, in words behind their name; one : of a pair."""
    whole, least = (float(np.nansum(one[f"sobol_total{end}"].values)) for end in ("", "_low"))
    if not least > 1:
        return "do not overlap beyond their bands"
    return f"overlap: with interactions they add up to {100 * whole:.0f} %, what two bring together counts in both"


def even_bins(edges: Array, counts: Array, low: float, high: float, bins: int) -> tuple[Array, Array]:
    """A histogram on even bins, counts shared out by width where a bin is cut.

    Parameters
    ----------
    edges : (b + 1,) of the bins.  counts : (b,).  low, high, bins : of the even bins, k.

    Returns
    -------
    centres (k,), share of all counts in each (k,) [1].
    """
    summed = np.concatenate([[0.0], np.cumsum(counts)])
    places = np.linspace(low, high, bins + 1)
    share = np.diff(np.interp(places, edges, summed)) / max(float(summed[-1]), 1.0)
    return (places[1:] + places[:-1]) / 2, np.asarray(share)


READ_IN = {"m": (1e6, "um"), "N/m": (1e-3, "N/mm"), "N": (1.0, "N")}
"""SI unit of an objective of a relief -> factor and unit in which it is read."""


class ReliefEffect(NamedTuple):
    """What a relief does to its first objective: its name, values with their unit before and after, in words the mesh
    forces that they are for, "" of one over speed; the gain per value before [1]."""

    what: str
    before: str
    after: str
    at: str
    gain: float


def zones_of(result: xr.Dataset) -> dict[str, tuple[Array, Array]]:
    """Load zone of every bearing of `life` by its name, with the case that loads it most; of `static` without cases.

    Angles from the element that bears most, ascending [deg], and loads of the elements [kN].
    """
    result = result if "case" in result.dims else result[["element_load", "element_angle"]].expand_dims(case=[""])
    load = result["element_load"].transpose("bearing", "case", "element").values / 1e3
    angle = np.degrees(result["element_angle"].transpose("bearing", "case", "element").values)
    zones, cases = {}, texts(result, "case")
    for place, name in enumerate(texts(result, "bearing")):
        case = first_largest(np.fmax.reduce(load[place], axis=1))[0]
        most = largest(load[place, case])
        turn = (angle[place, case] - angle[place, case, most] + 180) % 360 - 180
        order = np.argsort(turn, kind="stable")
        zones[name + (f", {cases[case]}" if len(cases) > 1 else "")] = turn[order], load[place, case][order]
    return zones


def relief_effect(result: xr.Dataset) -> ReliefEffect:
    """The effect of the relief that a search has picked."""
    before, after = (float(result[f"objective_{when}"].values[0]) for when in ("before", "after"))
    factor, unit = READ_IN[str(result.objective_unit.values[0])]
    what = str(result.objective_meaning.values[0]).partition(", largest over the loads")[0].partition(", loads")[0]
    at = ""
    if str(result.objective.values[0]) in ("lte", "load"):
        factors = np.array(json.loads(str(result.attrs["options"]))["factors"], dtype=float)
        forces = 1e-3 * np.outer(numbers(result, "relieved_force"), factors)
        ends = dict.fromkeys(engineering(float(force), 3) for force in (forces.min(), forces.max()))
        at = f" at {' to '.join(ends)} kN a helix"
    first, then = (f"{engineering(factor * value, 3)} {unit.replace('um', 'µm')}" for value in (before, after))
    return ReliefEffect(what, first, then, at, 1 - after / before if before else 0.0)
