"""The points of a study, computed in blocks: each one's result, or why it has none, as plain bytes."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...errors import ConvergenceError, ModelError
from ...results.plain import plain_bytes, plain_value
from .axes import OPTIONS

__all__ = ["Evaluate", "computed_block", "points_of"]

Evaluate = Callable[[Mapping[str, Any], Mapping[str, Any], Mapping[str, Any]], xr.Dataset]
"""Model, overrides and options of one point -> its result; a function of a module."""
Row = Mapping[str, Any]


def computed_block(
    evaluate: Evaluate,
    model: Mapping[str, Any],
    options: Row,
    rows: Sequence[Row],
    size: int,
    keep: Sequence[str],
    block: int,
) -> dict[str, np.ndarray]:
    """Block of a job: the results of `size` points as bytes.

    Parameters
    ----------
    options : of every point.  rows : path -> value of each point.  keep : variables, () for all.
    """
    points = [_point(evaluate, model, options, row, keep) for row in rows[block * size : (block + 1) * size]]
    return {"points": np.frombuffer(plain_bytes(points), np.uint8)}


def points_of(block: Mapping[str, np.ndarray]) -> list[dict[str, Any]]:
    """Points of a block: status, reason, warnings and result (None of a point that failed), names of all variables."""
    points = plain_value(block["points"].tobytes())
    return [{**point, "result": _dataset(point["result"])} for point in points]


def _point(evaluate: Evaluate, model: Mapping[str, Any], options: Row, row: Row, keep: Sequence[str]) -> dict[str, Any]:
    overrides = {path: value for path, value in row.items() if not path.startswith(OPTIONS)}
    options = dict(options) | {
        path.removeprefix(OPTIONS).replace("-", "_"): value for path, value in row.items() if path.startswith(OPTIONS)
    }
    status, reason = "ok", ""
    try:
        result = evaluate(model, overrides, options)
    except ModelError as error:
        status, reason = "wrong input", str(error)
    except ConvergenceError as error:
        status, reason = "no convergence", str(error)
    except MemoryError:
        raise
    except Exception as error:  # one point of many must not end the others
        status, reason = "fault", f"{type(error).__name__}: {error}"
    if status != "ok":
        return {"status": status, "reason": reason, "warnings": [], "names": [], "kind": "", "result": None}
    return {
        **{"status": status, "reason": reason, "warnings": json.loads(result.attrs.get("warnings", "[]"))},
        **{"names": [str(name) for name in result.data_vars], "kind": str(result.attrs.get("verb", ""))},
        "result": _plain(result, keep),
    }


def _plain(result: xr.Dataset, keep: Sequence[str]) -> dict[str, Any]:
    """A result as plain data: name -> dims, values, attributes, whether it is a coordinate."""
    if keep:
        result = result[[name for name in keep if name in result.data_vars]]
    return {
        str(name): [
            [str(dim) for dim in variable.dims],
            np.asarray(variable.values),
            {key: str(variable.attrs[key]) for key in ("units", "long_name") if key in variable.attrs},
            name in result.coords,
        ]
        for name, variable in result.variables.items()
    }


def _dataset(plain: Mapping[str, Any] | None) -> xr.Dataset | None:
    """The result of such data."""
    if plain is None:
        return None
    variables = {name: (dims, values, attrs) for name, (dims, values, attrs, _) in plain.items()}
    return xr.Dataset(
        {name: one for name, one in variables.items() if not plain[name][3]},
        coords={name: one for name, one in variables.items() if plain[name][3]},
    )
