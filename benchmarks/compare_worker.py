"""Runs tasks of `compare.py` in one checkout: a line in, a pickle of plain numbers and texts out, one after another.

Started by `compare.py` with PYTHONPATH at the checkout; only public names of the package are used.
"""

from __future__ import annotations

import ast
import os
import pickle
import sys
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["leaves", "plain_dataset", "run"]

_DATED = ("Deprecat", "FutureWarning", "Numba")


def run(verb: str, source: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Call a verb; the record of what came of it."""
    begin, spent = time.perf_counter(), time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            record = {"outcome": "result", **_called(verb, source, dict(options))}
        except Exception as error:
            path = getattr(error, "path", "")
            record = {"outcome": "error", "type": type(error).__name__, "path": str(path), "message": str(error)}
    record["seconds"] = time.perf_counter() - begin
    record["cpu_seconds"] = time.process_time() - spent
    told = [(warning.category.__name__, str(warning.message)) for warning in caught]
    record["caught"] = [entry for entry in told if not any(word in entry[0] for word in _DATED)]
    return record


def _called(verb: str, source: str, options: dict[str, Any]) -> dict[str, Any]:
    import epicyclic

    if verb == "system":
        return {"variables": dict(leaves(epicyclic.assemble(epicyclic.load(source)))), "attrs": {}}
    if verb == "examples":
        return _examples(source, options["listed"])
    if options.get("mesh") == "first":
        options["mesh"] = "/".join(epicyclic.load(source).meshes[0].name.split("/")[:3])
    result = getattr(epicyclic, verb)(source, **options)
    return plain_dataset(result)


def _examples(source: str, listed: Sequence[str]) -> dict[str, Any]:
    """Results of the examples of all verbs but those listed; none where a checkout has no records of verbs."""
    try:
        from epicyclic.verbs.record import verbs
    except ImportError:
        return {"variables": {}, "attrs": {}}
    variables = {
        f"{name}[{place}].{variable}": entry
        for name, verb in verbs().items()
        if name not in listed
        for place, keywords in enumerate(verb.examples)
        for variable, entry in plain_dataset(verb.run(source, **keywords))["variables"].items()
    }
    return {"variables": variables, "attrs": {}}


def plain_dataset(result: Any) -> dict[str, Any]:
    """A Dataset as plain dicts: name -> (dims, values, unit, long name)."""
    variables = {
        str(name): (
            tuple(str(dim) for dim in variable.dims),
            np.asarray(variable.values),
            str(variable.attrs.get("units", "")),
            str(variable.attrs.get("long_name", "")),
        )
        for name, variable in result.variables.items()
    }
    attrs = {str(key): value if np.isscalar(value) else np.asarray(value) for key, value in result.attrs.items()}
    return {"variables": variables, "attrs": attrs}


def leaves(value: object, path: str = "") -> Iterator[tuple[str, tuple[tuple[str, ...], Any, str, str]]]:
    """Arrays, numbers and texts of a tree of frozen dataclasses, by their places."""
    if is_dataclass(value) and not isinstance(value, type):
        for entry in fields(value):
            yield from leaves(getattr(value, entry.name), f"{path}.{entry.name}".lstrip("."))
    elif isinstance(value, np.ndarray):
        yield path, (tuple(f"axis{axis}" for axis in range(value.ndim)), value, "", "")
    elif isinstance(value, Mapping):
        for key in sorted(value, key=str):
            yield from leaves(value[key], f"{path}[{key}]")
    elif isinstance(value, (tuple, list, frozenset, set)):
        entries = sorted(value, key=str) if isinstance(value, (set, frozenset)) else list(value)
        if all(isinstance(entry, (str, int, Fraction)) for entry in entries):
            yield path, (("entry",), np.array([str(entry) for entry in entries], dtype=object), "", "")
        elif all(isinstance(entry, float) for entry in entries):
            yield path, (("entry",), np.array(entries), "", "")
        else:
            for at, entry in enumerate(entries):
                yield from leaves(entry, f"{path}[{at}]")
    elif isinstance(value, (float, complex, np.floating, np.complexfloating)):
        yield path, ((), np.asarray(value), "", "")
    elif value is not None and isinstance(value, (str, int, Fraction, np.integer)):
        yield path, ((), np.asarray(str(value), dtype=object), "", "")
    elif value is not None:
        yield path, ((), np.asarray(f"<{type(value).__name__}>", dtype=object), "", "")


def _versions() -> dict[str, str]:
    """The interpreter, what it computes with, and where the package comes from."""
    from importlib.metadata import PackageNotFoundError, version

    import epicyclic

    found = {"python": sys.version.split()[0], "package": str(Path(str(epicyclic.__file__)).resolve().parent)}
    for name in ("numpy", "scipy", "xarray", "pandas", "numba", "pymoo"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = ""
    return found


def main() -> None:
    """Answer lines until there are no more: first the versions, then ``done`` for each task."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what a verb prints is none of the answers
    print(repr(_versions()), file=answers, flush=True)
    for line in sys.stdin:
        verb, source, options, target = ast.literal_eval(line)
        record = run(verb, source, options)
        partial = Path(target).with_suffix(".part")
        partial.write_bytes(pickle.dumps(record))
        partial.replace(target)
        print("done", file=answers, flush=True)


if __name__ == "__main__":
    main()
