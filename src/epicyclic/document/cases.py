"""Load cases: the operation that a case stands for, the couplings that it opens, and overrides of what it states.

A key that a case states stands in place of that of `[operation]`, a torque or a power in place of both; what it leaves
out is that of `[operation]`.  Loads of a case stand beside those of the file, or by the same name in their place.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from ..errors import ModelError
from ..options import ALL_CASES
from .schema import CaseTable, ModelFile, OperationTable, case_states, nearest
from .tables import REMOVE, PlainTable, union, value_at
from .units import Quantity


def at_case(model: ModelFile) -> ModelFile:
    """Model whose operation and loads are those of the case that it names, its open couplings without torque.

    Raises
    ------
    ModelError : no such case or coupling; the operation of the case contradicts itself.
    """
    if model.case:
        case = _named(model.cases, model.case, "case", "case")
        stated = {name for name in OperationTable.model_fields if case_states(name, case.model_fields_set)}
        operation = model.operation.model_copy(update={name: getattr(case, name) for name in stated})
        model = model.model_copy(update={"operation": operation, "loads": {**model.loads, **case.loads}})
    _check_operation(model)
    opened = {name: _opened(model, name) for name in model.operation.open}
    return model.model_copy(update={"couplings": {**model.couplings, **opened}}) if opened else model


def _named(tables: Mapping[str, Any], name: str, path: str, what: str) -> Any:
    if path == "case" and name == ALL_CASES:
        raise ModelError(
            "stands for every case, which a verb computes one by one", path=path, given=name, allowed=", ".join(tables)
        )
    if name not in tables:
        allowed = f"one of {', '.join(tables)}" if tables else f"a name of [{what}s], which has none"
        raise ModelError(f"no such {what}{nearest(name, tables)}", path=path, given=name, allowed=allowed)
    return tables[name]


def _opened(model: ModelFile, name: str) -> Any:
    """Coupling without stiffness about z."""
    path = f"{model.operation_path('open')}.open"
    table = _named(model.couplings, name, path, "coupling")
    if table.bolts is not None or table.ends == "fixed":
        what = "bolts" if table.bolts is not None else "fixed ends"
        raise ModelError(f"a coupling with {what} does not open", path=path, given=name, allowed="one with rz, or none")
    return table.model_copy(update={"rz": Quantity(value=0.0, unit="N m/rad")})


def _check_operation(model: ModelFile) -> None:
    """Check that held members and open couplings are named once, and that no held member is given a speed."""
    operation = model.operation
    for name, path in ((name, f"{model.operation_path(name)}.{name}") for name in ("held", "open")):
        listed = getattr(operation, name)
        for i, member in enumerate(listed):
            if member in listed[:i]:
                raise ModelError(f"{name} twice", path=path, given=member, allowed="each name once")
    for member in operation.held:
        if operation.speed.get(member, 0.0) != 0.0:
            path = f"{model.operation_path('speed')}.speed.{member}"
            raise ModelError("is held", path=path, given=operation.speed[member], allowed="no speed of a held member")


def check_cases(cases: Mapping[str, CaseTable]) -> None:
    """Check the names of cases, and that their weights are all durations or all shares.

    Raises
    ------
    ModelError : a case with the name that stands for all; durations beside shares; shares of more than the whole.
    """
    if ALL_CASES in cases:
        raise ModelError("stands for every case", path=f"cases.{ALL_CASES}", allowed="another name")
    shares = {name: case.share for name, case in cases.items() if case.share is not None}
    for name, case in cases.items():
        if case.duration is not None and shares:
            allowed = f"a duration in every case, or a share as cases.{next(iter(shares))} has"
            raise ModelError("beside shares", path=f"cases.{name}.duration", given=case.duration, allowed=allowed)
    if (whole := sum(shares.values())) > 1 + 1e-9:
        last = next(reversed(shares))
        problem = f"the shares of all cases add up to {whole:g}"
        raise ModelError(problem, path=f"cases.{last}.share", given=shares[last], allowed="1 in all at most")


def of_another_point(data: Mapping[str, object], path: str) -> bool:
    """Whether a path of a document is of the operation or of a case, and not of the point that is computed.

    That is a key of the operation that the case states, and all of other cases.
    """
    table, name, *_ = (*path.split("."), "")
    case = str(data.get("case") or "")
    if table == "operation":
        return case_states(name, value_at(data, ["cases", case]) or ())
    return table == "cases" and name != case


def of_case(layer: PlainTable, case: str, table: PlainTable) -> PlainTable:
    """Layer of overrides whose keys of the operation, and loads, lie in the case where that states them.

    table : of the case, expanded.
    """
    result, moved = dict(layer), PlainTable()
    own_loads = table.get("loads") or {}
    for part, stands in (("operation", partial(case_states, stated=table)), ("loads", own_loads.__contains__)):
        whole = layer.get(part)
        if not isinstance(whole, dict):
            continue
        found = {name: value for name, value in whole.items() if stands(name)}
        # what is removed is removed from both: else that of the operation would stand in its place
        result[part] = {name: value for name, value in whole.items() if name not in found or value is REMOVE}
        moved |= {part: found} if part == "loads" and found else found if part == "operation" else {}
    return union({"cases": {case: moved}}, result, "") if moved else layer
