"""Nested tables of a model file: cleaned, merged, walked, values written as TOML, shorthands expanded, normalised.

Shorthands are those of one layer of a file: each layer is expanded before one is laid over the other.  What a table
is, is known from its place.  Values of a wrong form pass through: validation names them.  The expanded document is then
normalised for the schema: values by full member path.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial, reduce
from operator import not_
from typing import Any, Final

from ..errors import ModelError
from .deviations import MemberDeviationsTable, MeshDeviationsTable, bare_keys
from .schema import BY_MEMBER, LOADING, SIDES, STAGE_KEYS, Names, full_path, mesh_name, nearest, reference
from .schema_fields import LINK_KEYS

PlainTable = dict[str, Any]
Ends = Callable[[Mapping[str, Any]], bool]
MAX_DEPTH = 24
# points of one dotted key: tomllib takes time as the square of their number, and there are 24 levels at most
_MAX_POINTS = 300
# a text, to the end of the line where it does not end there; a dotted key of too many points
_QUOTED = re.compile(r"""\"(?:[^"\\]|\\.)*(?:"|\\?$)|'[^']*(?:'|$)""")
_DOTTED = re.compile(rf"(?<![\w-])(?:[\w-]+[ \t]*\.[ \t]*){{{_MAX_POINTS + 1}}}")
# no line of text needs them, and a terminal takes them as orders
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")
# numbers above are no input; in a message or a file Python takes long over their digits, or refuses
_MAX_BITS = 1024


class _Remove:
    """What an empty override stands for: the key goes."""

    def __repr__(self) -> str:
        return "(nothing)"


REMOVE: Final = _Remove()


def clean(value: object, path: str = "", depth: int = 0) -> Any:
    """Return a value as plain JSON: tables with text keys, lists, texts, numbers; infinity as "inf".

    numpy scalars and arrays become numbers and lists. Raises ModelError for anything else, nan, numbers of hundreds of
    digits, control characters in texts, and deep nesting.
    """
    if depth > MAX_DEPTH:
        raise ModelError("nested too deeply", path=path[:80], allowed=f"at most {MAX_DEPTH} levels")
    if isinstance(value, str):
        return _clean_text(value, path)
    if value is REMOVE or isinstance(value, bool):
        return value
    if isinstance(value, int):
        if value.bit_length() > _MAX_BITS:
            raise ModelError("too large", path=path, given="a number of hundreds of digits", allowed="a number")
        return int(value)  # not the mark of a number typed on the command line
    if isinstance(value, float):
        if math.isnan(value):
            raise ModelError("not a number", path=path, given="nan", allowed="a number")
        return ("inf" if value > 0 else "-inf") if math.isinf(value) else float(value)
    if isinstance(value, Mapping):
        return {
            _clean_text(str(k), path): clean(v, f"{path}.{k}" if path else str(k), depth + 1)
            for k, v in value.items()
            if v is not None
        }
    if isinstance(value, (list, tuple)):
        return [clean(v, path, depth + 1) for v in value]
    if hasattr(value, "tolist"):
        return clean(value.tolist(), path, depth + 1)
    kinds = "a text, a number, true or false, a list or a table"
    raise ModelError(f"a {type(value).__name__} cannot stand here", path=path, given=value, allowed=kinds)


def _clean_text(text: str, path: str) -> str:
    """Return a text without control characters but tab and line breaks."""
    found = _CONTROL.search(text)
    if found is not None:
        problem = f"holds a control character, U+{ord(found[0]):04X}"
        raise ModelError(problem, path=path, given=ascii(text), allowed="a text")
    return text


def dotted_line(text: str) -> int | None:
    """Return the number of the first line of a TOML text with a dotted key of more points than a parser can bear."""
    for number, line in enumerate(text.splitlines(), start=1):
        if line.count(".") > _MAX_POINTS and _DOTTED.search(_QUOTED.sub("x", line)):
            return number
    return None


def split_path(text: str, *, path: str = "") -> tuple[str, ...]:
    """Return the segments of a path; quotes round a segment are dropped.

    Raises ModelError for an empty one, and for more than any table has levels.
    """
    if text.count(".") > MAX_DEPTH:
        raise ModelError("nested too deeply", path=path[:80], given=text, allowed=f"at most {MAX_DEPTH} levels")
    segments = tuple(part.strip().strip("\"'").strip() for part in text.replace('"', "").split("."))
    if not all(segments):
        raise ModelError("not a path", path=path, given=text, allowed="names joined by points, stages.main.sun.mass")
    return segments


def nested(path: tuple[str, ...], value: Any) -> Any:
    """Return tables inside each other that hold `value` at `path`."""
    for name in reversed(path):
        value = {name: value}
    return value


def union(first: PlainTable, second: PlainTable, path: str) -> PlainTable:
    """Return two tables of one layer as one. Raises ModelError where both give the same key."""
    result = dict(first)
    for name, value in second.items():
        where = key_path(path, name)
        if name not in result:
            result[name] = value
        elif isinstance(value, dict) and isinstance(result[name], dict):
            result[name] = union(result[name], value, where)
        elif value is not REMOVE or result[name] is not REMOVE:  # removed twice, by two spellings, is removed
            raise ModelError("given twice", path=where, given=value, allowed="one of the two")
    return result


def together(parts: Iterable[PlainTable], path: str) -> PlainTable:
    """Return tables of one layer as one, as of `union`."""
    return reduce(partial(union, path=path), parts, PlainTable())


class Whole(dict[str, Any]):
    """A table that takes the place of the one it is laid over, as a list does."""


def merge(base: PlainTable, layer: PlainTable, path: str = "") -> PlainTable:
    """Return `layer` laid over `base`: tables entry by entry, all else replaced, `REMOVE` removes.

    Raises ModelError where there is nothing to remove.
    """
    result = dict(base)
    for name, value in layer.items():
        where = key_path(path, name)
        if value is REMOVE:
            if name not in result:
                allowed = f"one of {', '.join(base)}" if base else "nothing: the file has none"
                raise ModelError("nothing there to remove", path=where, allowed=allowed)
            del result[name]
        elif isinstance(value, dict) and not isinstance(value, Whole):
            below = result.get(name)
            result[name] = merge(below if isinstance(below, dict) else {}, value, where)
        else:
            result[name] = value
    return result


def value_at(table: object, path: Iterable[str]) -> Any:
    """Return what stands at the names of a path in nested tables, None where nothing does."""
    for name in path:
        table = table.get(name) if isinstance(table, Mapping) else None
    return table


def key_path(path: str, name: str) -> str:
    """Return the path of a key in the table at a path, "" for the file itself."""
    return f"{path}.{name}" if path else name


def paths(table: object, path: str = "") -> Iterator[str]:
    """Paths of every value and every table in nested tables."""
    for name, value in table.items() if isinstance(table, dict) else ():
        yield (where := key_path(path, name))
        yield from paths(value, where)


def leaves(table: Mapping[str, Any], ends: Ends = not_) -> Iterator[tuple[str, object]]:
    """Path and value of everything that is no table, and of the tables at which a path ends: empty ones."""
    return ((".".join(keys), value) for keys, value in keyed(table, ends=ends))


def keyed(
    table: Mapping[str, Any], above: tuple[str, ...] = (), *, ends: Ends = not_
) -> Iterator[tuple[tuple[str, ...], object]]:
    """The same by keys from the top down."""
    for key, value in table.items():
        if isinstance(value, Mapping) and not ends(value):
            yield from keyed(value, (*above, key), ends=ends)
        else:
            yield (*above, key), value


# written as TOML ------------------------------------------------------------------------------------------------------

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def key_text(name: str) -> str:
    """Return a key, quoted where it must be."""
    return name if _BARE_KEY.fullmatch(name) else _text(name)


def value_text(value: object) -> str:
    """Return one value in TOML."""
    if hasattr(value, "tolist"):  # a number or array of numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(value_text(v) for v in value)}]"
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key_text(k)} = {value_text(v)}' for k, v in value.items())} }}" if value else "{}"
    return repr(float(value)) if isinstance(value, float) else str(value)


def _text(text: str) -> str:
    """Return a basic TOML string; JSON's escapes are TOML's, but for DEL, which TOML wants escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


# shorthands -----------------------------------------------------------------------------------------------------------

TOLERANCE_TABLES = ("cost", "correlation")
"""Tables of `[tolerance]` that are no tolerances."""

_MOST_CHARACTERS = 1000  # of a path: 24 names of 60 letters at most do not all stand in one
PAIRS = {"radial": ("x", "y"), "tilt": ("rx", "ry")}
"""Keys of stiffnesses that stand for two."""
_BARE = bare_keys(MemberDeviationsTable) | bare_keys(MeshDeviationsTable)


def expand(layer: PlainTable, names: Names) -> PlainTable:
    """Return a layer with its shorthands expanded and its references as full paths.

    Raises ModelError for a shorthand beside what it stands for, and for a reference to nothing.
    """
    parts: dict[str, Callable[..., PlainTable]] = {
        "stages": _stages,
        **{kind: partial(_entries, kind=kind) for kind in ("bodies", "couplings", "loads", "sensors")},
        "operation": _operation,
        "cases": _cases,
        "deviations": _deviations,
        "assumed": lambda table, names: _by_path(table, names, "assumed"),
        "tolerance": _tolerances,
    }
    return {k: parts[k](v, names=names) if k in parts and isinstance(v, dict) else v for k, v in layer.items()}


def expand_path(text: str, names: Names, *, path: str) -> tuple[str, ...]:
    """Return the paths a path with shorthands stands for: the stage put in, `radial` and `tilt` as their two.

    path : where the text stands.  Raises ModelError there for a text that is no path, or refers to nothing.
    """
    segments = split_path(text, path=path)
    try:
        table = expand(nested(segments, REMOVE), names)
    except ModelError as error:
        raise ModelError(error.problem, path=path, given=text, allowed=error.allowed) from None
    return tuple(found for found, _ in leaves(table))


def as_written(table: PlainTable, found: Container[str], names: Names) -> Iterator[tuple[str, str]]:
    """Paths of a table as they are written, each with those of `found` that it stands for; none of what expands not."""
    for path, value in leaves(table):
        with suppress(ModelError):
            expanded = leaves(expand(nested(tuple(path.split(".")), value), names))
            yield from ((path, full) for full, _ in expanded if full in found)


def _each(table: PlainTable, path: str, change: Callable[[PlainTable, str], Any]) -> PlainTable:
    """Return a table of named tables, each changed."""
    return {k: change(v, f"{path}.{k}") if isinstance(v, dict) else v for k, v in table.items()}


def _stages(table: PlainTable, names: Names) -> PlainTable:
    """Expand `[stages]`: the members of each and the names of its meshes."""
    result = dict(table)
    for stage, keys in table.items():
        if not isinstance(keys, dict):
            continue
        result[stage] = {}
        for name, value in keys.items():
            path = f"stages.{stage}.{name}"
            if name == "meshes" and isinstance(value, dict):
                value = _renamed(value, stage, names, path)
            elif name not in STAGE_KEYS and isinstance(value, dict):
                value = dict(_member(value, path, stage, names))
            result[stage][name] = value
    return result


def _renamed(table: PlainTable, stage: str, names: Names, path: str) -> PlainTable:
    """Return a table of meshes with their gears in the order sun, planet, ring."""
    renamed = ({mesh_name(name, stage, names, path=f"{path}.{name}"): value} for name, value in table.items())
    return together(renamed, path)


def _member(table: PlainTable, path: str, stage: str, names: Names) -> Iterator[tuple[str, Any]]:
    """Expand one gear or carrier, or one side of it."""
    for name, value in table.items():
        where = f"{path}.{name}"
        if isinstance(value, dict) and name in ("support", "bearing", "neck", "shaft"):
            value = _link(value, where, names)
        elif isinstance(value, dict) and name in SIDES:
            value = dict(_member(value, where, stage, names))
        elif name == "shaft_sections":
            value = _numbered(value)
        elif name == "elastic" and value is True:  # a key that is laid over it changes this one alone
            value = {"axial": True}
        elif name == "reduced" and isinstance(value, str):
            value = {"file": value}
        elif name == "on" and isinstance(value, str):
            value = reference(value if "." in value else f"{stage}.{value}", names, path=where, sides=False)
        yield name, value


def _link(table: PlainTable, path: str, names: Names) -> PlainTable:
    """Expand a link: `radial`, `tilt`, a bare damper, and its named sub-tables."""
    result = _pairs(table, path)
    for name, value in result.items():
        where = f"{path}.{name}"
        if name == "damping" and value is not REMOVE:
            result[name] = _pairs(value, where) if isinstance(value, dict) else {d: value for d in ("x", "y", "z")}
        elif name not in LINK_KEYS and isinstance(value, dict):
            result[name] = _link(value, where, names)
        elif name == "to" and isinstance(value, str) and value != "housing":
            result[name] = reference(value, names, path=where)
    return result


def _pairs(table: PlainTable, path: str) -> PlainTable:
    """Replace `radial` by x and y, `tilt` by rx and ry."""
    result: PlainTable = {}
    for name, value in table.items():
        both = PAIRS.get(name, (name,))
        if any(d in result for d in both):
            raise ModelError(f"stands beside {' or '.join(both)}", path=f"{path}.{name}", given=value, allowed="one")
        result |= dict.fromkeys(both, value)
    return result


def _entries(table: PlainTable, kind: str, names: Names, path: str = "") -> PlainTable:
    """Expand `[bodies]`, `[couplings]`, `[loads]` or `[sensors]`, at a path: links, and what they stand on."""

    def entry(stated: PlainTable, path: str) -> PlainTable:
        result = _link(stated, path, names) if kind == "couplings" else dict(stated)
        if kind == "bodies" and isinstance(support := stated.get("support"), dict):
            result["support"] = _link(support, f"{path}.support", names)
        if kind == "bodies" and "shaft_sections" in stated:
            result["shaft_sections"] = _numbered(stated["shaft_sections"])
        if kind == "couplings" and isinstance(between := stated.get("between"), list):
            result["between"] = [reference(end, names, path=f"{path}.between") for end in between]
        if kind in ("loads", "sensors") and isinstance(on := stated.get("on"), str):
            result["on"] = reference(on, names, path=f"{path}.on")
        if kind == "sensors" and isinstance(link := stated.get("link"), str) and "." in link:
            result["link"] = ".".join(full_path(tuple(link.split(".")), names))
        return result

    return _each(table, path or kind, entry)


def _operation(table: PlainTable, names: Names, path: str = "operation") -> PlainTable:
    """Expand `[operation]`: the stage put in front of every member."""
    result = dict(table)
    for name in (*BY_MEMBER, "ripple"):
        if isinstance(by_member := table.get(name), dict):
            by_member = _ripples(by_member, names, f"{path}.{name}") if name == "ripple" else by_member
            result[name] = _full(by_member, names, f"{path}.{name}")
    if isinstance(held := table.get("held"), list):
        result["held"] = [reference(m, names, path=f"{path}.held", sides=False) for m in held]
    return result


def _ripples(value: Any, names: Names, path: str) -> Any:
    """Return tables with lists of tables as tables by number from 1, and full names of shafts whose turns count."""
    value = _numbered(value)
    if not isinstance(value, dict):
        return value
    result = type(value)({name: _ripples(entry, names, f"{path}.{name}") for name, entry in value.items()})
    if isinstance(of := value.get("of"), str):
        result["of"] = reference(of, names, path=f"{path}.of", sides=False)
    return result


def _numbered(value: Any) -> Any:
    """Return a list of tables as tables by number from 1, that take the place of those they are laid over."""
    if not (isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value)):
        return value
    return Whole({str(number): entry for number, entry in enumerate(value, start=1)})


def _cases(table: PlainTable, names: Names) -> PlainTable:
    """Expand `[cases]`: each as an operation with loads of its own."""

    def case(stated: PlainTable, path: str) -> PlainTable:
        result = _operation(stated, names, path)
        if isinstance(loads := stated.get("loads"), dict):
            result["loads"] = _entries(loads, "loads", names, f"{path}.loads")
        return result

    return _each(table, "cases", case)


def _full(table: PlainTable, names: Names, path: str) -> PlainTable:
    """Return a table by members with the stage put in front of each where it was left out."""
    full = (nested(full_path(split_path(name, path=path), names), value) for name, value in table.items())
    return together(full, path)


def _deviations(table: PlainTable, names: Names) -> PlainTable:
    """Expand `[deviations]`: the stage put in front, mesh names in order, bare amplitudes, members of errors."""
    result = _full(table, names, "deviations")
    for stage in names.stages:
        if isinstance(entry := result.get(stage), dict):
            if isinstance(meshes := entry.get("meshes"), dict):
                path = f"deviations.{stage}.meshes"
                renamed = _renamed(meshes, stage, names, path)
                entry = entry | {"meshes": {k: _errors(v, f"{path}.{k}", stage, names) for k, v in renamed.items()}}
            result[stage] = entry
    return {k: dict(_amplitudes(v)) if isinstance(v, dict) else v for k, v in result.items()}


def _errors(table: Any, path: str, stage: str, names: Names) -> Any:
    """Write out the member that each error of a mesh, or of a side of it, turns with."""
    if not isinstance(table, dict):
        return table

    def error(entry: PlainTable, where: str) -> PlainTable:
        member = entry.get("turns_with")
        if not isinstance(member, str):
            return entry
        full, path = member if "." in member else f"{stage}.{member}", f"{where}.turns_with"
        try:
            return entry | {"turns_with": reference(full, names, path=path, sides=False)}
        except ModelError as problem:
            allowed = "a gear of the mesh, or the carrier of the stage"
            raise ModelError(problem.problem, path=path, given=member, allowed=allowed) from None

    result = {k: _errors(v, f"{path}.{k}", stage, names) if k in SIDES else v for k, v in table.items()}
    if isinstance(errors := table.get("errors"), dict):
        result["errors"] = _each(errors, f"{path}.errors", error)
    return result


def _amplitudes(table: PlainTable) -> Iterator[tuple[str, Any]]:
    """Replace bare `run_out = "20 um"` and the like by their table, at any depth."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield name, value if name in _BARE else dict(_amplitudes(value))
        else:
            yield name, {_BARE[name]: value} if name in _BARE and value is not REMOVE else value


def _by_path(table: PlainTable, names: Names, path: str) -> PlainTable:
    """Return a table by paths with every path written out, `radial` as x and y."""
    return {found: value for text, value in leaves(table) for found in expand_path(text, names, path=f"{path}.{text}")}


def _tolerances(table: PlainTable, names: Names) -> PlainTable:
    """Expand `[tolerance]`: the stage put into every path, in its costs and correlations too."""
    result: PlainTable = {}
    for text, value in leaves({k: v for k, v in table.items() if k not in TOLERANCE_TABLES}, ends=_is_entry):
        path = one_path(text, names, f"tolerance.{text}")
        if path in result:
            raise ModelError("given twice", path=f"tolerance.{text}", given=value, allowed="one of the two")
        result[path] = value
    for name in TOLERANCE_TABLES:
        inner = table.get(name)
        if isinstance(inner, dict):
            where, found = f"tolerance.{name}", leaves(inner, ends=_holds_no_table)
            by_path = ({one_path(text, names, f"{where}.{text}"): value} for text, value in found)
            result[name] = together(by_path, where)
        elif name in table:
            result[name] = inner
    return result


def _is_entry(table: Mapping[str, Any]) -> bool:
    """Whether a table is empty, or holds the distributions of one entry: its own, and that common to all planets."""
    return not table or (bool({"own", "common"} & set(table)) and _holds_no_table(table))


def _holds_no_table(table: Mapping[str, Any]) -> bool:
    return not any(isinstance(value, dict) for value in table.values())


def one_path(text: str, names: Names, path: str) -> str:
    """Return one path with the stage put in; `radial`, `tilt` and a bare damper, one number of several keys, stay.

    Raises ModelError for a text that is no path.
    """
    if len(text) > _MOST_CHARACTERS:
        problem, allowed = f"a path of {len(text)} characters", f"at most {_MOST_CHARACTERS}"
        raise ModelError(problem, path=f"{path[:80]}...", given=text, allowed=allowed)
    found = expand_path(text, names, path=path)
    if len(found) == 1:
        return found[0]
    table, last = found[0].rpartition(".")[0], split_path(text, path=path)[-1]
    return table if table.endswith(f".{last}") else f"{table}.{last}"


# normalised for the schema --------------------------------------------------------------------------------------------

STANDARD_GRAVITY = 9.81  # m/s^2


def normalise(data: PlainTable, names: Names) -> PlainTable:
    """Return the expanded document as `ModelFile` takes it.

    Raises ModelError for a reference to nothing.
    """
    result = dict(data)
    if isinstance(operation := data.get("operation"), dict):
        result["operation"] = _normalised_operation(operation, names)
    if isinstance(cases := data.get("cases"), dict):
        result["cases"] = _each(cases, "cases", lambda table, path: _normalised_operation(table, names, path))
    if isinstance(deviations := data.get("deviations"), dict):
        result["deviations"] = _normalised_deviations(deviations, names)
    return result


def _normalised_operation(table: PlainTable, names: Names, path: str = "operation") -> PlainTable:
    """Flatten speeds, torques and powers to full member paths."""
    result = dict(table)
    for name in (*BY_MEMBER, "ripple"):
        if isinstance(table.get(name), dict):
            sides = None if name == "ripple" else name in LOADING
            result[name] = _by_member(table[name], names, f"{path}.{name}", sides=sides)
    if isinstance(gravity := table.get("gravity"), bool):
        result["gravity"] = f"[0, {-STANDARD_GRAVITY}, 0] m/s^2" if gravity else None
    return result


def _flat(
    table: PlainTable, names: Names, path: str, *, beside: tuple[str, ...] = ()
) -> Iterator[tuple[str, str, Any, str]]:
    """Stage ("" of a body), full path, value and place of every member of a table by stage and member.

    beside : keys of a stage that are no members.  Raises ModelError for a name that is not known.
    """
    allowed = ", and ".join(("a table of members", *beside))
    for first, value in table.items():
        where = f"{path}.{first}"
        if first in names.stages:
            for name, entry in _table(value, where, allowed).items():
                _known(name, (*names.stages[first], *beside), f"{where}.{name}", entry)
                yield first, f"{first}.{name}", entry, f"{where}.{name}"
        else:
            _known(first, (*names.bodies, *names.stages), where, value)
            yield "", first, value, where


def _by_member(table: PlainTable, names: Names, path: str, *, sides: bool | None) -> PlainTable:
    """Return {full path: value} of nested stage, member and side tables; sides None: the values are tables."""
    flat: PlainTable = {}
    for stage, member, value, where in _flat(table, names, path):
        flat |= _sides(member, value, where, sides) if stage else {member: value}
    return flat


def _sides(member: str, value: Any, path: str, sides: bool | None) -> PlainTable:
    """Return {member: value}, or one entry for each side."""
    if sides is None or not isinstance(value, dict):
        return {member: value}
    for side, entry in value.items():
        if not sides or side not in SIDES:
            raise ModelError("no such side", path=f"{path}.{side}", given=entry, allowed=" or ".join(SIDES))
    return {f"{member}.{side}": entry for side, entry in value.items()}


def _normalised_deviations(table: PlainTable, names: Names) -> PlainTable:
    """Flatten deviations to full member and mesh paths."""
    members: PlainTable = {}
    meshes: PlainTable = {}
    for stage, path, value, where in _flat(table, names, "deviations", beside=("meshes",)):
        if stage and path == f"{stage}.meshes":
            for mesh, errors in _table(value, where, "a table of meshes").items():
                mesh_name(mesh, stage, names, path=f"{where}.{mesh}")
                meshes |= _by_side(f"{path}.{mesh}", errors, MeshDeviationsTable.model_fields)
        else:
            members |= _by_side(path, value, MemberDeviationsTable.model_fields, sides=bool(stage))
    return {"members": members, "meshes": meshes}


def _by_side(path: str, value: Any, keys: Collection[str], *, sides: bool = True) -> PlainTable:
    """Return the deviations at a path of `[deviations]`, and of the sides where it has them, by path."""
    table = _table(value, f"deviations.{path}", f"a table of {', '.join(keys)}")
    apart = {k: v for k, v in table.items() if sides and k in SIDES}
    whole = {k: v for k, v in table.items() if k not in apart}
    return ({path: whole} if whole or not apart else {}) | {f"{path}.{side}": v for side, v in apart.items()}


def _table(value: Any, path: str, allowed: str) -> PlainTable:
    """Return a table. Raises ModelError for anything else."""
    if not isinstance(value, dict):
        raise ModelError("not a table", path=path, given=value, allowed=allowed)
    return value


def _known(name: str, known: Any, path: str, value: object) -> None:
    """Raise ModelError for a name that is none of those known."""
    if name not in known:
        words = tuple(known)
        allowed = f"one of {', '.join(words)}"
        raise ModelError(f"no such member{nearest(name, words)}", path=path, given=value, allowed=allowed)
