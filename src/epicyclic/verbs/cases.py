"""A verb over every load case of a model, in one Dataset: its variables along the dimension `case`."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np
import xarray as xr

from ..document.document import read
from ..engine.points import along, attempt
from ..engine.source import Drive, Duty, Overrides, Source, StudyAxis
from ..errors import ModelError
from ..options import ALL_CASES
from ..results.dataset import dataset
from ..system.system import System
from ..train.train import Train
from ..warning_codes import CodedText, coded, placed


def over_cases(
    run: Callable[..., xr.Dataset], source: Source, overrides: Overrides, keywords: Mapping[str, Any]
) -> xr.Dataset:
    """Results of a verb at every case of a model; a case that has none says why, and the others go on.

    Parameters
    ----------
    run : the public function of the verb, called with the keywords.  overrides : with ``case = "all"``.

    Returns
    -------
    Dataset : the variables of the verb with a first dimension ``case`` (c,), its ``case_duration`` [s] and
        ``case_share`` [1], ``case_status`` and ``case_reason``; attribute ``of``, the kind of the results, and
        ``cases``, JSON of the attributes of each.

    Raises
    ------
    ModelError : a source without a model file, a model without cases, keywords of a run that is kept; every case fails.
    """
    if kept := [name for name in ("folder", "resume", "store") if keywords.get(name)]:
        raise ModelError("goes with one case", path=kept[0], given=keywords[kept[0]], allowed="case = one name")
    cases = _cases(source, overrides)
    axis = StudyAxis(
        name="case",
        changes=tuple({"case": name} for name in cases),
        labels={"case": (np.array(list(cases), dtype=object), {"long_name": "load case"})},
    )
    progress, count = keywords.get("progress"), len(axis.changes)

    def at_case(index: int) -> xr.Dataset:
        def step(done: float, of: int = 0) -> None:
            assert progress is not None
            if of:
                progress(index * of + done, count * of)
            else:
                progress((index + done) / count)

        told = {} if progress is None else {"progress": step}
        return run(source, overrides={**overrides, **axis.changes[index]}, **{**keywords, **told})

    found = [attempt(at_case, index) for index in range(count)]
    results, names = [one.value for one in found], list(cases)
    if (first := next((one for one in results if one is not None), None)) is None:
        assert found[0].error is not None
        raise ModelError(f"every case fails, {names[0]} with: {found[0].reason}", path="case", given=ALL_CASES)
    said = [
        coded("case-failed", f"{name} has no result: {one.reason}")
        for name, one in zip(names, found, strict=True)
        if one.reason
    ]
    if 0 < len(without := _unweighed(cases)) < count:
        said.append(coded("cases-not-weighed", f"neither duration nor share of {', '.join(without)}"))
    said += _warnings_of({name: one for name, one in zip(names, results, strict=True) if one is not None})
    made = dataset(
        {
            "case_status": ("case", np.array([one.status for one in found], dtype=object)),
            "case_reason": ("case", np.array([one.reason for one in found], dtype=object)),
            **_weights(cases),
        },
        verb="cases",
        options=json.loads(first.attrs["options"]),
        provenance={name: first.attrs[name] for name in _PROVENANCE if name in first.attrs} | _model_of(first),
        warnings=said,
    )
    own = {name: _own_attributes(one) for name, one in zip(names, results, strict=True) if one is not None}
    more = {"of": str(first.attrs["verb"]), "cases": json.dumps(own)}
    whole = along([axis], results)
    return whole.assign(made.data_vars).assign_attrs(made.attrs | more)


def _warnings_of(results: Mapping[str, xr.Dataset]) -> list[CodedText]:
    """Warnings of the cases, one that several have once with their names."""
    of: dict[CodedText, list[str]] = {}
    for name, result in results.items():
        for text in json.loads(result.attrs["warnings"]):
            of.setdefault(text, []).append(name)
    every = "every case"
    return [
        placed(every if len(own) == len(results) > 1 else f"case {', '.join(own)}", text) for text, own in of.items()
    ]


def _model_of(result: xr.Dataset) -> dict[str, str]:
    """The model without the case that one result is of."""
    tables = json.loads(result.attrs["model"])
    return {"model": json.dumps({name: table for name, table in tables.items() if name != "case"})}


_PROVENANCE = ("title", "doi", "model", "assumed")


def _own_attributes(result: xr.Dataset) -> dict[str, Any]:
    """Attributes of one case beside those that all share; types of what may be joined with nan, its coordinates."""
    own = {
        str(name): value.item() if isinstance(value, np.generic) else value
        for name, value in result.attrs.items()
        if name not in _PROVENANCE
    }
    kinds = {str(name): one.dtype.name for name, one in result.variables.items() if one.dtype.kind in "bi"}
    return {**own, "whole_numbers": kinds, "labels": [str(name) for name in result.coords]}


def duty_of(drive: Drive) -> Duty | None:
    """All load cases of a drive with their shares of the time, which all need; None of a drive of one point.

    Raises
    ------
    ModelError : a source without cases, a case without duration or share, cases that last no time.
    """
    source, overrides = drive.source, drive.overrides or {}
    if overrides.get("case") != ALL_CASES:
        return None
    cases = _cases(source, overrides)
    shares = dict(zip(cases, _weights(cases)["case_share"][1].tolist(), strict=True))
    if not (whole := sum(shares.values())) > 0:
        without = _unweighed(cases)
        problem = "has no weight beside the other cases" if without else "lasts no time"
        allowed = "a duration or a share in every case, to weigh them"
        raise ModelError(problem, path=f"cases.{next(iter(without or cases))}", allowed=allowed)
    document = read(cast(Any, source), {path: value for path, value in overrides.items() if path != "case"}).data
    of_case = {name: Drive(source, {**overrides, "case": name}) for name in cases}
    return Duty({name: (of_case[name], share / whole) for name, share in shares.items() if share > 0}, document)


def _unweighed(cases: Mapping[str, Any]) -> list[str]:
    """Cases with neither duration nor share."""
    return [name for name, one in cases.items() if one.duration is None and one.share is None]


def case_names(source: Source, overrides: Overrides) -> tuple[str, ...]:
    """Names of the cases of a model.  Raises ModelError: a model without cases, a source without a model file."""
    return tuple(_cases(source, overrides))


def _cases(source: Source, overrides: Overrides) -> Mapping[str, Any]:
    if isinstance(source, Train | System):
        raise ModelError("cases belong to a model file", path="case", given=ALL_CASES, allowed="a model file or dict")
    cases = read(source, {path: value for path, value in overrides.items() if path != "case"}).model.cases
    if not cases:
        allowed = "tables [cases.NAME] in the model file"
        raise ModelError("the model has no cases", path="case", given=ALL_CASES, allowed=allowed)
    return cases


def _weights(cases: Mapping[str, Any]) -> dict[str, Any]:
    """Duration [s] and share [1] of every case, nan where the file states neither."""
    durations, shares = (
        np.array([np.nan if (value := getattr(case, name)) is None else value for case in cases.values()])
        for name in ("duration", "share")
    )
    if np.nansum(durations) > 0:
        shares = durations / durations.sum()  # none where one is not known
    return {"case_duration": ("case", durations), "case_share": ("case", shares)}
