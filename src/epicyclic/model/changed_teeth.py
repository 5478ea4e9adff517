"""Teeth changed by an override: what the file states of the size of the old gear follows, and a warning names it.

A file may state radii and masses that the teeth would give as well, a publication prints them.  With other teeth they
are those of another gear.  They are scaled with the gear, at the same module, so that they move with the teeth and not
by the difference between what is printed and what would be derived: lengths with the number of teeth, a mass with its
square, an inertia with its fourth power, and of a ring, whose thickness stays, with the first and the third power.
Centre distances and pin radii are scaled as those of the reference circles.  What the same overrides state stays.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..errors import ModelError
from ..warning_codes import CodedText, coded
from .model_writer import quantity_text
from .names import SIDES, Names
from .tables import PlainTable
from .units import KINDS, Bounds, Quantity, read_quantity

__all__ = ["Followed", "follow_teeth"]

Followed = tuple[PlainTable, tuple[CodedText, ...], tuple[CodedText, ...], frozenset[str]]
# key -> kinds of quantity, and the power of the number of teeth for a gear and for a ring; None: it goes, and follows
_POWERS: dict[str, tuple[tuple[str, ...], int | None, int | None]] = {
    "base_radius": (("length",), 1, 1),
    "tip_diameter": (("length",), None, None),
    "root_diameter": (("length",), None, None),
    "outer_diameter": (("length",), 1, 1),
    "mass": (("mass",), 2, 1),
    "inertia": (("inertia", "mass"), 4, 3),
    "tilt_inertia": (("inertia",), 4, 3),
}
_REDUCED = 2  # less for an inertia in kg, J/r^2
_DISTANCES = ("centre_distance", "pin_radius")


def follow_teeth(data: PlainTable, before: PlainTable, overridden: frozenset[str], names: Names) -> Followed:
    """A document after its overrides, with what belongs to the teeth of before scaled to those of now.

    data : shorthands expanded, overrides laid over.  before : without them.  overridden : paths that overrides set.
    Returns the document, a warning for each stage whose numbers moved, one for each ring that no longer fits, and the
    paths of what moved.
    """
    changed = {stage: _changed(data, before, stage, members) for stage, members in names.stages.items()}
    warnings: list[CodedText] = []
    hints: list[CodedText] = []
    moved: set[str] = set()
    for stage, teeth in changed.items():
        if not any(old != new for old, new in teeth.values()):
            continue
        said: list[str] = []
        for path, ratio, powers in _scaled_paths(data["stages"][stage], stage, teeth, names):
            if path in overridden or ratio == 1:
                continue
            if (found := _scaled(_at(data, path), path, ratio, powers)) is not None:
                text, value = found
                data = _with(data, path.split("."), value)
                said.append(text)
                moved.add(path)
        other = ", ".join(f"{m} {new} for {old}" for m, (old, new) in teeth.items() if old != new)
        if said:
            text = (
                f"stages.{stage}: other teeth than the file's ({other}); what it states of their size is scaled at the "
                f"same module: {', '.join(said)}; set it beside the teeth to have it otherwise"
            )
            warnings.append(coded("teeth-changed", text))
        hints += _ring_hint(stage, teeth, names.stages[stage])
    return data, tuple(warnings), tuple(hints), frozenset(moved)


def _changed(data: PlainTable, before: PlainTable, stage: str, members: Any) -> dict[str, tuple[int, int]]:
    """Teeth before and now of every gear of a stage that has both."""
    found = {}
    for member in members:
        old, new = (_at(table, f"stages.{stage}.{member}.teeth") for table in (before, data))
        if all(isinstance(z, int) and not isinstance(z, bool) and z > 0 for z in (old, new)):
            found[member] = (old, new)
    return found


def _scaled_paths(
    table: PlainTable, stage: str, teeth: dict[str, tuple[int, int]], names: Names
) -> Iterator[tuple[str, float, tuple[tuple[str, ...], int | None]]]:
    """Path, ratio of sizes, and kinds and power of every number of a stage that belongs to its teeth."""
    kinds = names.stages[stage]
    for member, (old, new) in teeth.items():
        for inner in ("", *(f".{side}" for side in SIDES)):
            for key, (quantity, gear, ring) in _POWERS.items():
                yield (
                    f"stages.{stage}.{member}{inner}.{key}",
                    new / old,
                    (quantity, ring if kinds[member] == "ring" else gear),
                )
    pairs = _pairs(table, teeth, kinds)
    length = (("length",), 1)
    for name, ratio in pairs.items():
        yield f"stages.{stage}.meshes.{name}.centre_distance", ratio, length
    central = [r for name, r in pairs.items() if {"sun", "ring", "gear"} & {kinds[m] for m in name.split("-")}]
    for ratio in central[:1]:
        yield f"stages.{stage}.centre_distance", ratio, length
        for member in kinds:
            yield f"stages.{stage}.{member}.pin_radius", ratio, length


def _pairs(table: PlainTable, teeth: dict[str, tuple[int, int]], kinds: Any) -> dict[str, float]:
    """Ratio of the reference centre distances now and before, by mesh; those with a sun first."""
    planets = [m for m in teeth if kinds[m] == "planet"]
    named = list(table["meshes"]) if isinstance(table.get("meshes"), dict) else []
    implied = [f"{m}-{planets[0]}" for m in teeth if kinds[m] == "sun"] if len(planets) == 1 else []
    implied += [f"{planets[0]}-{m}" for m in teeth if kinds[m] == "ring"] if len(planets) == 1 else []
    if not planets and len(teeth) == 2:
        implied = ["-".join(sorted(teeth, key=lambda m: kinds[m] == "ring"))]
    found = {}
    for name in dict.fromkeys((*implied, *named)):
        a, _, b = name.partition("-")
        if a not in teeth or b not in teeth:
            continue
        sign = -1 if kinds[b] == "ring" else 1
        old, new = (teeth[b][i] + sign * teeth[a][i] for i in (0, 1))
        if old > 0 and new > 0:
            found[name] = new / old
    return dict(sorted(found.items(), key=lambda entry: "sun" not in {kinds[m] for m in entry[0].split("-")}))


def _scaled(
    value: object, path: str, ratio: float, powers: tuple[tuple[str, ...], int | None]
) -> tuple[str, Any] | None:
    """What is said of a number that moves, and its new text; None where there is no number, or one of wrong form."""
    kinds, power = powers
    if value is None or isinstance(value, (dict, list, bool)):
        return None
    short = path.split(".", 2)[2]
    if power is None:
        return f"{short} follows from the teeth (was {value})", None
    try:
        read = read_quantity(value, kinds, Bounds(inf=True))
    except ModelError:  # validation names it
        return None
    kind = kinds[0]
    if isinstance(read, Quantity):
        kind = next(k for k in kinds if KINDS[k].unit == read.unit)
        power -= _REDUCED if kind == "mass" else 0
        read = read.value
    if not isinstance(read, float):
        return None
    number = read * ratio**power
    if number == read:
        return None
    text = quantity_text(number, kind)
    near = quantity_text(float(f"{number:.5g}"), kind)
    return f"{short} {near} (was {value})", text


def _ring_hint(stage: str, teeth: dict[str, tuple[int, int]], kinds: Any) -> list[CodedText]:
    """What ring a simple planetary set wants whose teeth fitted before and do not now."""
    by_kind: dict[str, list[str]] = {}
    for member in teeth:
        by_kind.setdefault(kinds[member], []).append(member)
    if any(len(by_kind.get(kind, ())) != 1 for kind in ("sun", "planet", "ring")):
        return []
    sun, planet, ring = (by_kind[kind][0] for kind in ("sun", "planet", "ring"))
    want = [teeth[sun][i] + 2 * teeth[planet][i] for i in (0, 1)]
    if want[0] != teeth[ring][0] or want[1] == teeth[ring][1] or teeth[ring][0] != teeth[ring][1]:
        return []
    path, sum_of = f"stages.{stage}.{ring}.teeth", f"{teeth[sun][1]} + 2 x {teeth[planet][1]}"
    text = f"{path} = {teeth[ring][1]}: {sum_of} teeth want a ring of {want[1]}; set {path} = {want[1]} too"
    return [coded("ring-teeth", text)]


def _at(table: object, path: str) -> Any:
    """What stands at a path, None where nothing does."""
    for part in path.split("."):
        table = table.get(part) if isinstance(table, dict) else None
    return table


def _with(table: PlainTable, path: list[str], value: Any) -> PlainTable:
    """A table with another value at a path; None removes it."""
    first, *rest = path
    if rest:
        return {**table, first: _with(table[first], rest, value)}
    return {**table, first: value} if value is not None else {k: v for k, v in table.items() if k != first}
