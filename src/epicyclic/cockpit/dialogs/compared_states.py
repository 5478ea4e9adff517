"""Two states beside each other: plain functions that a process of its own runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...document.tables import PlainTable
from ...questions.compare.compare import compare_of
from ...show.views.compare import tables
from ...train.resolution import load

__all__ = ["Loadable", "compared_states"]

Loadable = tuple[PlainTable, Mapping[str, object]]
"""What `load` takes: source and overrides."""


def compared_states(first: Loadable, second: Loadable, names: tuple[str, str]) -> dict[str, Any]:
    """What differs between two states in the model and in its results.

    names : of the columns A and B.

    Returns
    -------
    ``rows``: texts by heading, one list a row.  ``headings``.  ``lead`` and ``notes``: what stands above and below.

    Raises
    ------
    ModelError : a state of which no train can be made.
    """
    trains = [load(source, overrides=overrides) for source, overrides in (first, second)]
    result = compare_of(trains)
    result = result.assign_coords(train=[f"{names[0]}, pinned", f"{names[1]}, present"])
    (table,) = tables(result)
    headings = list(table.columns)
    rows = [[str(cell) for cell in row] for row in zip(*table.columns.values(), strict=True)]
    return {"headings": headings, "rows": rows, "lead": table.lead, "notes": list(table.notes)}
