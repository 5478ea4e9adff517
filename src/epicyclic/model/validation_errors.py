"""One readable ModelError from whatever pydantic found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from ..errors import ModelError
from .names import nearest
from .schema import KIND_BY_NAME, MemberTable, MeshTable, ModelFile, StageTable
from .schema_links import LinkDampingTable, LinkTable

__all__ = ["as_model_error", "error_of", "path_of", "words_of"]

_WORDS = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "a text",
    "float_type": "a number",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "tuple_type": "a list",
    "list_type": "a list",
}
_FAULTS = {
    "missing": ("missing", ""),
    "finite_number": ("not finite", "a finite number"),
    "string_too_short": ("empty", "a text"),
    "float_parsing": ("not a number", "a number"),
    "int_parsing": ("not a whole number", "a whole number"),
    "bool_parsing": ("not true or false", "true or false"),
    "too_short": ("too few", "a longer list"),
    "too_long": ("too many", "a shorter list"),
}
_ORDER = ("extra_forbidden",)  # reported first: a misspelt key is also a missing one
_HIDDEN = {"members", "bearings", "form"}
Loc = tuple[int | str, ...]


def as_model_error(error: ValidationError) -> ModelError:
    """Return one ModelError: the first problem with path, value and what is allowed, and where the others are."""
    return error_of(error.errors(include_url=False))


def error_of(faults: Sequence[Any]) -> ModelError:
    """Return one ModelError of faults as pydantic lists them."""
    details = sorted(faults, key=lambda e: e["type"] not in _ORDER)
    first = details[0]
    loc = first["loc"]
    problem, allowed = _describe(first, loc)
    others = [path_of(d["loc"]) for d in details[1:] if d["loc"] != loc]
    if others:
        problem += f" (and {len(others)} more, at {', '.join(others[:3])}{', ...' if len(others) > 3 else ''})"
    inner = first.get("ctx", {}).get("error")
    if isinstance(inner, ModelError) and inner.path:  # about a part of the value
        return ModelError(problem, path=f"{path_of(loc)}.{inner.path}", given=inner.given, allowed=allowed)
    if first["type"] == "missing":
        return ModelError(problem, path=path_of(loc), allowed=allowed)
    return ModelError(problem, path=path_of(loc), given=first["input"], allowed=allowed)


def path_of(loc: Loc) -> str:
    """Return the path in the file of a place in the schema, without the tables only the schema has."""

    def only_schema(i: int, part: int | str) -> bool:
        return (
            (i == 1 and loc[0] == "deviations")
            or (i == 2 and loc[0] == "stages" and part == "members")
            or (i > 2 and part == "bearings")
        )

    return ".".join(str(part).strip() for i, part in enumerate(loc) if not only_schema(i, part))


def _describe(detail: Any, loc: Loc) -> tuple[str, str]:
    """Return what is wrong and what is allowed."""
    kind, context = detail["type"], detail.get("ctx", {})
    if isinstance(context.get("error"), ModelError):
        return context["error"].problem, context["error"].allowed
    if kind == "extra_forbidden":
        known = _keys(loc[:-1])
        if (elsewhere := _key_of_a_mesh(loc)) and str(loc[-1]) not in known:
            return "unknown key here; it stands in the table of a mesh", elsewhere
        near = nearest(loc[-1], known)
        return f"unknown key{near}", "" if near else f"one of {', '.join(known)}"
    if kind == "missing":
        near = nearest(loc[-2], (*_keys(loc[:-3]),)) if loc[-1] == "kind" else ""
        return f"missing{near}", _described(loc)
    return words_of(detail)


def words_of(detail: Any) -> tuple[str, str]:
    """What is wrong and what is allowed, of a fault as pydantic lists it, whatever the schema."""
    kind, context = detail["type"], detail.get("ctx", {})
    if kind == "literal_error":
        return "not a word known here", context["expected"].replace("'", '"')
    if kind in _WORDS:
        return f"not {_WORDS[kind]}", _WORDS[kind]
    if kind in _FAULTS:
        return _FAULTS[kind]
    limits = [f"{sign} {context[name]}" for name, sign in (("ge", ">="), ("le", "<=")) if name in context]
    return ("out of range", limits[0]) if limits else (str(detail["msg"]), "")


def _key_of_a_mesh(loc: Loc) -> str:
    """Where a key that a stage or a gear does not have stands in a mesh; "" of any other key."""
    here = _table_at(loc[:-1])
    if here not in (StageTable, MemberTable) or loc[-1] not in _names(MeshTable):
        return ""
    return f"{loc[0]}.{loc[1]}.meshes.A-B.{loc[-1]}, with A-B such as sun-planet"


def _described(loc: Loc) -> str:
    """Return what a missing key stands for."""
    table = _table_at(loc[:-1])
    field = table.model_fields.get(str(loc[-1])) if table else None
    if loc[-1] == "kind":
        names = ", ".join(KIND_BY_NAME)
        return f"kind = sun, planet, ring, carrier or gear, for a table that is none of {names}"
    return field.description or "" if field else ""


def _keys(loc: Loc) -> tuple[str, ...]:
    """Return the keys a table may have, as they are written."""
    table = _table_at(loc)
    if table is None:
        return ()
    names = _names(table)
    if issubclass(table, StageTable):
        names += KIND_BY_NAME
    if issubclass(table, LinkTable | LinkDampingTable):
        names += ["radial", "tilt"]
    return tuple(names)


def _names(table: type[BaseModel]) -> list[str]:
    """Return the keys of a table as they are written."""
    return [field.alias or name for name, field in table.model_fields.items() if name not in _HIDDEN]


def _table_at(loc: Loc) -> type[BaseModel] | None:
    """Return the model of the table at a place in the schema."""
    here: Any = ModelFile
    for part in loc:
        if get_origin(here) is dict:
            here = get_args(here)[1]
        elif _is_model(here) and part in here.model_fields:
            here = _unwrap(here.model_fields[str(part)].annotation)
        else:
            return None
    return here if _is_model(here) else None


def _unwrap(annotation: Any) -> Any:
    """Return the model in `X | None` or `Annotated[Quantity | X, ...] | None`, anything else as it is."""
    if get_origin(annotation) is dict:
        return annotation
    parts = (_unwrap(part) for part in get_args(annotation))
    return next((part for part in parts if _is_model(part)), annotation)


def _is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)
