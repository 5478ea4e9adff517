"""Overrides of a document as a layer laid over the file, and what follows from them.

Alternatives of one key (rule 3) are an error in one layer; a later layer replaces them.

Of teeth that an override changes, what the file states of the size of the old gear follows, and a warning names it.
A file may state radii and masses that the teeth would give as well, a publication prints them.  With other teeth they
are those of another gear.  They are scaled with the gear, at the same module, so that they move with the teeth and not
by the difference between what is printed and what would be derived: lengths with the number of teeth, a mass with its
square, an inertia with its fourth power, and of a ring, whose thickness stays, with the first and the third power.
Centre distances and pin radii are scaled as those of the reference circles.  What the same overrides state stays.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from itertools import permutations
from typing import Any

from ..errors import ModelError
from ..warning_codes import CodedText, coded
from .schema import LOADING, SIDES, Names, implied_pairs, nearest
from .tables import REMOVE, PlainTable, clean, dotted_line, leaves, nested, split_path, together, union, value_at
from .units import KINDS, Bounds, Quantity, finite_float, is_typed, read_quantity, typed
from .writer import quantity_text

_NAMED = ("stages", "bodies", "couplings", "loads")  # tables whose entries an override changes but does not invent


def parse_setting(text: str) -> tuple[str, object]:
    """Return path and value of a `PATH=VALUE` from the command line: a TOML value, else a text; None where it is empty.

    Numbers are marked as typed, so that a quantity without its unit is told or refused.

    Raises ModelError without `=`, and for a number that is too large to be one.
    """
    path, equals, value = text.partition("=")
    if not equals or not path.strip():
        raise ModelError(
            "not a setting", path="overrides", given=text, allowed="PATH=VALUE, stages.main.sun.mass=750 kg"
        )
    path, value = path.strip(), value.strip()
    if not value:
        return path, None
    if "\n" in value or len(value) > 100_000 or dotted_line(value) is not None:
        return path, typed(value)
    try:
        table = tomllib.loads(f"value = {value}", parse_float=finite_float)
    except OverflowError:
        raise ModelError("too large", path=path, given=value, allowed="a number below 1.8e308, or inf") from None
    except (ValueError, RecursionError):
        return path, typed(value)
    return path, typed(table["value"] if len(table) == 1 else value)


def stepwise(overrides: Mapping[str, object]) -> list[dict[str, object]]:
    """Return the overrides as layers, in the order in which they are laid; the last one has all that are no step.

    A table that others reach into is removed before they fill it, and after what they remove of it.  What a table of
    overrides removes is an override of its own, by its path.
    """
    overrides = _removals_apart(overrides)
    paths = {text: split_path(str(text), path=str(text)) for text in overrides}
    removed = {text: path for text, path in paths.items() if _removes(overrides[text])}
    above = {text: sum(path[: len(p)] == p != path for p in removed.values()) for text, path in removed.items()}
    emptied = {text for text, path in removed.items() if any(p[: len(path)] == path != p for p in paths.values())}
    steps = [
        {text: overrides[text] for text in removed if above[text] == level and (level or text in emptied)}
        for level in range(max(above.values(), default=0), -1, -1)
    ]
    done = {text for step in steps for text in step}
    return [*steps, {text: value for text, value in overrides.items() if text not in done}]


def _removals_apart(overrides: Mapping[str, object]) -> dict[str, object]:
    """Return overrides, those that tables of overrides remove by their paths and None. Raises ModelError."""
    apart: dict[str, object] = {}

    def without_removals(path: str, value: object) -> object:
        if not isinstance(value, Mapping) or not value:
            return value
        kept: dict[str, object] = {}
        for name, entry in value.items():
            where = f"{path}.{name}"
            if _removes(entry):
                state(where, None)
            elif (inner := without_removals(where, entry)) is not None:
                kept[name] = inner
        return kept or None

    def state(path: str, value: object) -> None:
        if path in apart and not (_removes(value) and _removes(apart[path])):
            raise ModelError("given twice", path=path, given=value, allowed="one of the two")
        apart[path] = value

    for text, value in overrides.items():
        kept = without_removals(str(text), value)
        if kept is not None or value is None:
            state(str(text), kept)
    return apart


def _removes(value: object) -> bool:
    return value is None or (isinstance(value, str) and not value.strip())


def layer_of(overrides: Mapping[str, object], base: PlainTable) -> PlainTable:
    """Return overrides as one layer; None or an empty text removes the key.

    Raises ModelError where one reaches into a stage, body, coupling or load that the file does not have, and where an
    empty table is laid over one that is not empty.
    """
    layer: PlainTable = {}
    for text, value in overrides.items():
        path = split_path(str(text), path=str(text))
        _check_known(path, value, base)
        if isinstance(value, Mapping) and not value and value_at(base, path):
            raise ModelError(
                "an empty table changes nothing", path=str(text), given="{}", allowed=f"{text}= removes it"
            )
        layer = union(layer, nested(path, REMOVE if _removes(value) else clean(value, str(text))), "")
    return layer


def settings_of(overrides: Mapping[str, object]) -> PlainTable:
    """Return the overrides with numbers that a person typed, as a table."""
    typed_ones = ((str(text), value) for text, value in overrides.items() if is_typed(value))
    return together((nested(split_path(text, path=text), clean(value, text)) for text, value in typed_ones), "")


def _check_known(path: tuple[str, ...], value: object, base: PlainTable) -> None:
    """Raise ModelError for a path through a table the file does not have; a whole table may be added."""
    known = base.get(path[0], {})
    if path[0] not in _NAMED or len(path) < 2 or not isinstance(known, dict):
        return
    if path[1] in known or (len(path) == 2 and isinstance(value, Mapping)):
        return
    problem = f"no '{path[1]}' in {path[0]}{nearest(path[1], known)}"
    allowed = f"one of {', '.join(known)}" if known else f"a whole table, {path[0]}.{path[1]} = {{...}}"
    raise ModelError(problem, path=".".join(path), given="(nothing)" if value is None else value, allowed=allowed)


# alternatives ---------------------------------------------------------------------------------------------------------

# groups of keys of which only one stands in a table; no other table has keys of two groups of one line
ALTERNATIVES: tuple[tuple[tuple[str, ...], ...], ...] = (
    (("planets",), ("planet_angles",)),
    (("module",), ("transverse_module",)),
    (("amplitude", "phase"), ("x", "y")),
    (("diameter", "bore"), ("torsional_rigidity",)),
    (("cosine", "sine"), ("values",)),
    (("rim",), ("outer_diameter",)),
    (("modal",), ("mass", "stiffness"), ("mesh",)),
    (("force",), ("coefficient", "radius")),
    (("count",), ("angles",)),
)
_ALTERNATIVE = {key for groups in ALTERNATIVES for group in groups for key in group}


def check_alternatives(layer: PlainTable) -> None:
    """Raise ModelError where one layer says the same in two ways."""
    _check(layer, "")
    for path, operation in _operations(layer):
        torques = _given(operation.get("torque"))
        for member in _given(operation.get("power")) & torques:
            _clash(f"{'.'.join(path)}.power.{member}", "torque", ("torque", "power"))


def replace_alternatives(base: PlainTable, layer: PlainTable) -> PlainTable:
    """Return `base` without the keys that `layer` states by an alternative."""
    result = _replace(base, layer)
    before = dict(_operations(result))
    for path, after in _operations(layer):
        if path not in before:
            continue
        operation = dict(before[path])
        for mine, other in permutations(LOADING):
            stated = after.get(other)
            removed = {path for path, _ in leaves(stated)} if isinstance(stated, dict) else set()
            for member in _given(after.get(mine)) & _given(operation.get(other)) - removed:
                operation[other] = _with(operation[other], member.split("."), None)
        result = _with(result, list(path), operation)
    return result


def _operations(layer: PlainTable) -> Iterator[tuple[tuple[str, ...], PlainTable]]:
    """Path and table of the nominal operation and of every case."""
    cases = layer.get("cases")
    named = {("cases", name): table for name, table in cases.items()} if isinstance(cases, dict) else {}
    for path, table in ((("operation",), layer.get("operation")), *named.items()):
        if isinstance(table, dict):
            yield path, table


def _check(table: PlainTable, path: str) -> None:
    """Check one table and those in it."""
    keys = {k for k in table.keys() & _ALTERNATIVE if table[k] is not REMOVE}
    for groups in ALTERNATIVES if len(keys) > 1 else ():
        found = [k for group in groups for k in group if k in keys]
        if sum(bool(keys & set(group)) for group in groups) > 1:
            _clash(f"{path}.{found[-1]}" if path else found[-1], found[0], tuple(found))
    for name, value in table.items():
        if isinstance(value, dict):
            _check(value, f"{path}.{name}" if path else name)


def _clash(path: str, other: str, both: tuple[str, ...]) -> None:
    raise ModelError(f"says the same as {other}, which is given too", path=path, allowed=f"one of {', '.join(both)}")


def _replace(base: PlainTable, layer: PlainTable) -> PlainTable:
    """Drop the keys of other groups from one table and those in it."""
    given = {k for k in layer.keys() & _ALTERNATIVE if layer[k] is not REMOVE}
    gone = {
        k
        for groups in (ALTERNATIVES if given else ())
        for mine, other in permutations(groups, 2)
        if given & set(mine)
        for k in other
        if k not in layer
    }
    kept = {k: v for k, v in base.items() if k not in gone}
    return {
        k: _replace(v, layer[k]) if isinstance(v, dict) and isinstance(layer.get(k), dict) else v
        for k, v in kept.items()
    }


def _given(table: object) -> set[str]:
    """Return the paths of the values in a table that are given."""
    return {path for path, value in leaves(table) if value is not REMOVE} if isinstance(table, dict) else set()


# what follows the teeth -----------------------------------------------------------------------------------------------

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


def follow_teeth(
    data: PlainTable, before: PlainTable, overridden: frozenset[str], names: Names
) -> tuple[PlainTable, tuple[CodedText, ...], tuple[CodedText, ...], frozenset[str]]:
    """A document after its overrides, with what belongs to the teeth of before scaled to those of now.

    data : shorthands expanded, overrides laid over.  before : without them.  overridden : paths that overrides set.
    Returns the document, a warning for each stage whose numbers moved, one for each ring that no longer fits, and the
    paths of what moved.
    """
    warnings: list[CodedText] = []
    hints: list[CodedText] = []
    moved: set[str] = set()
    for stage, members in names.stages.items():
        teeth: dict[str, tuple[int, int]] = {}  # before and now, of every gear that has both
        for member in members:
            old, new = (value_at(table, ("stages", stage, member, "teeth")) for table in (before, data))
            if all(isinstance(z, int) and not isinstance(z, bool) and z > 0 for z in (old, new)):
                teeth[member] = (old, new)
        if not any(old != new for old, new in teeth.values()):
            continue
        said: list[str] = []
        for path, ratio, powers in _scaled_paths(data["stages"][stage], stage, teeth, names):
            if path in overridden or ratio == 1:
                continue
            if (scaled := _scaled(value_at(data, path.split(".")), path, ratio, powers)) is not None:
                text, value = scaled
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
        hints += _ring_hint(stage, teeth, members)
    return data, tuple(warnings), tuple(hints), frozenset(moved)


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


def _pairs(table: PlainTable, teeth: dict[str, tuple[int, int]], kinds: Mapping[str, str]) -> dict[str, float]:
    """Ratio of the reference centre distances now and before, by mesh; those with a sun first."""
    named = list(table["meshes"]) if isinstance(table.get("meshes"), dict) else []
    implied = map("-".join, implied_pairs({m: kinds[m] for m in teeth}))
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
        read = read_quantity(value, kinds, Bounds(inf=True), listed=True)
    except ModelError:  # validation names it
        return None
    kind = kinds[0]
    if isinstance(read, Quantity):
        kind = next(k for k in kinds if KINDS[k].unit == read.unit)
        power -= _REDUCED if kind == "mass" else 0
        read = read.value
    if not isinstance(read, float):
        return None
    try:
        number = read * ratio**power
    except OverflowError:  # of teeth beyond all bounds: validation names them
        return None
    if number == read:
        return None
    text = quantity_text(number, kind)
    near = quantity_text(float(f"{number:.5g}"), kind)
    return f"{short} {near} (was {value})", text


def _ring_hint(stage: str, teeth: dict[str, tuple[int, int]], kinds: Mapping[str, str]) -> list[CodedText]:
    """What ring a simple planetary set wants whose teeth fitted before and do not now."""
    members = {kind: [m for m in teeth if kinds[m] == kind] for kind in ("sun", "planet", "ring")}
    if any(len(gears) != 1 for gears in members.values()):
        return []
    sun, planet, ring = (teeth[gears[0]] for gears in members.values())
    fitting, wanted = (sun[i] + 2 * planet[i] for i in (0, 1))
    if fitting != ring[0] or wanted == ring[1] or ring[0] != ring[1]:
        return []
    path = f"stages.{stage}.{members['ring'][0]}.teeth"
    sum_of = f"{sun[1]} + 2 x {planet[1]}"
    text = f"{path} = {ring[1]}: {sum_of} teeth want a ring of {wanted}; set {path} = {wanted} too"
    return [coded("ring-teeth", text)]


def _with(table: PlainTable, path: list[str], value: Any) -> PlainTable:
    """A table with another value at a path; None removes it, and the tables that empties."""
    first, *rest = path
    inner = _with(table[first], rest, value) or None if rest else value
    return {**table, first: inner} if inner is not None else {k: v for k, v in table.items() if k != first}
