"""Where the numbers of a report come from: assumed values, options of the analyses, every resolved value, the model."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from .elements import Details, Listing, Part, Section, Table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["assumed_tables", "provenance", "value_tables"]


def provenance(results: Mapping[str, xr.Dataset]) -> Section:
    """The last section of a report: the model of the first result that says it, and every analysis with its options."""
    assumed, values, model = (_first(results, name) for name in ("assumed", "values", "model"))
    parts: list[Part] = [] if assumed is None else [*assumed_tables(assumed)]
    parts.append(_runs(results))
    if values is not None:
        parts += [Details(summary=one.title, parts=[replace(one, title="")]) for one in value_tables(values)]
    if model is not None:
        parts.append(Details(summary="Resolved model", parts=[Listing(text=_indented(str(model.attrs["model"])))]))
    return Section(anchor="model", title="Model and provenance", parts=parts)


def _first(results: Mapping[str, xr.Dataset], name: str) -> xr.Dataset | None:
    """The first result that has an attribute."""
    return next((result for result in results.values() if result.attrs.get(name)), None)


def assumed_tables(result: xr.Dataset) -> list[Table]:
    """Values that the source does not print, by path, and why they were chosen; none where all are printed."""
    assumed = json.loads(result.attrs.get("assumed", "{}"))
    columns = {"path": list(assumed), "why": [str(reason) for reason in assumed.values()]}
    return [Table(title="Assumed values", columns=columns)] if assumed else []


def value_tables(result: xr.Dataset) -> list[Table]:
    """Every resolved value of the model, its unit and its origin."""
    values = json.loads(result.attrs.get("values", "[]"))
    columns = {
        "path": [path for path, *_ in values],
        "value": [_number(value) for _, value, *_ in values],
        "unit": [unit or "" for _, _, unit, _ in values],
        "from": [origin or "" for *_, origin in values],
    }
    return [Table(title="Every resolved value", columns=columns, digits=7)] if values else []


def _number(value: Any) -> Any:
    """A value as it was resolved: numbers stay numbers, text that reads as one becomes one."""
    if value is None:
        return ""
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return value
    return str(value) if isinstance(value, bool) else value


def _runs(results: Mapping[str, xr.Dataset]) -> Table:
    attributes = [result.attrs for result in results.values()]
    columns = {
        "analysis": list(results),
        "options": [_options(str(one.get("options", "{}"))) for one in attributes],
        "package": [str(one.get("package", "")) for one in attributes],
        "version": [str(one.get("version", "")) for one in attributes],
    }
    return Table(title="", columns=columns)


def _options(text: str) -> str:
    try:
        found = json.loads(text)
    except json.JSONDecodeError:
        return text
    return "; ".join(f"{key}: {_shortened(value)}" for key, value in found.items())


def _shortened(value: object) -> str:
    text = json.dumps(value) if isinstance(value, list | dict) else str(value)
    return text if len(text) <= 120 else f"{text[:117]}..."


def _indented(text: str) -> str:
    try:
        return json.dumps(json.loads(text), indent=2, ensure_ascii=False)
    except json.JSONDecodeError:
        return text
