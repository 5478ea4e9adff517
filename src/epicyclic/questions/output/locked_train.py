"""The shaft that a gearbox is seen from; the train with its other shafts locked, by another operation of the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...document.cases import at_case
from ...document.document import read
from ...document.schema import collect, reference
from ...document.tables import value_at
from ...errors import ModelError
from ...train.kinematics import motions
from ...train.resolution import load
from ...train.train import Train

# Tables of a document that speak of its operation, and keys of that which a locked train keeps.
_OF_OPERATION, _KEPT = ("assumed", "case", "cases", "loads", "operation", "tolerance"), ("open", "gravity")
# Paths of tolerances that are of the operation, and what their table has beside paths that are drawn.
_NOT_DRAWN = ("operation.", "cases.", "cost")
# Power below this share of the largest is rounding.
_NONE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputShaft:
    """A shaft of a train.

    name : member.  held : members that do not turn.  torque : rated, in the sense of the operation [N m].
    rated_by : `rated` of the option, `operation.rated` of the file, or the torque of `operation`.
    """

    name: str
    held: tuple[str, ...]
    torque: float
    rated_by: str


def ports(train: Train) -> list[str]:
    """Members at which torque enters or leaves; of a train without torques all central ones that nothing couples."""
    kinematics = train.kinematics
    loaded = [*kinematics.held, *kinematics.stated, *kinematics.reacting]
    if kinematics.torque is None:
        coupled = {name for tie in kinematics.ties for name in (tie.a, tie.b)}
        loaded += [name for name in central(train) if name not in coupled]
    return list(dict.fromkeys(loaded))


def central(train: Train) -> list[str]:
    """Members whose axis no carrier takes along."""
    return list(dict.fromkeys(body.member for body in train.bodies if body.branch is None))


def output_shaft(train: Train, shaft: str | None, held: Sequence[str] | None, rated: float | None) -> OutputShaft:
    """The shaft that is asked for, or the output of the train, with what is locked and its rated torque.

    Raises
    ------
    ModelError : no such member, a planet; no one output; a shaft that is locked or cannot turn, others that leave the
        train free; no rated torque.
    """
    known, kinematics = collect(train.document), train.kinematics
    name = _output(train) if shaft is None else reference(shaft, known, path="shaft", sides=False)
    others = [reference(one, known, path="held", sides=False) for one in held or ()]
    for path, one in [("shaft", name), *(("held", other) for other in others)]:
        if one not in central(train):
            allowed = ", ".join(central(train))
            raise ModelError("turns about an axis of its own, which is carried", path=path, given=one, allowed=allowed)
    if name in others:
        raise ModelError("is the shaft that is seen", path="held", given=name, allowed="other shafts")
    still = dict.fromkeys(one for one in kinematics.held if one != name)
    locked = still | dict.fromkeys(one for one in (ports(train) if held is None else others) if one != name)
    _check_locked(train, name, list(still), list(locked))
    torque, rated_by = _rated(train, name, rated)
    return OutputShaft(name=name, held=tuple(locked), torque=torque, rated_by=rated_by)


def _output(train: Train) -> str:
    """The one member that power leaves by, of a locked train the one that is loaded."""
    kinematics, power = train.kinematics, train.kinematics.power or {}
    least = -_NONE * max(map(abs, power.values()), default=0.0)
    found = kinematics.stated if kinematics.locked else [name for name, value in power.items() if value < least]
    if len(found) != 1:
        free = [name for name in ports(train) if name not in kinematics.held]
        if kinematics.torque is None:
            allowed = f"a torque of a member, or shaft = one of {', '.join(free or central(train))}, and rated"
            raise ModelError("no torque says which shaft is the output", path="operation.torque", allowed=allowed)
        what = "power leaves by several shafts" if found else "no power says which shaft is the output"
        raise ModelError(what, path="shaft", allowed=f"one of {', '.join(found or free or central(train))}")
    return found[0]


def _check_locked(train: Train, shaft: str, still: Sequence[str], held: Sequence[str]) -> None:
    """Refuse a shaft that cannot turn beside what the file holds, and held members that leave the train free."""
    before, free = motions(train.kinematics, still), motions(train.kinematics, held)
    if before and not any(motion[shaft] for motion in before.values()):
        by = ", ".join(still) or "none"
        raise ModelError(f"cannot turn: held are {by}", path="shaft", given=shaft, allowed="a shaft that turns")
    if free:
        moving = [name for name in ports(train) if any(motion[name] for motion in free.values())]
        allowed = f"also {' or '.join([name for name in moving if name != shaft] or free)}"
        raise ModelError(f"leaves {shaft} free to turn", path="held", given=", ".join(held) or "none", allowed=allowed)


def _rated(train: Train, shaft: str, rated: float | None) -> tuple[float, str]:
    """Rated torque [N m] with the sign of the operation, and where it comes from.

    Raises
    ------
    ModelError : neither option, nor file, nor operation has one.
    """
    of_operation = (train.kinematics.torque or {}).get(shaft, 0.0)
    sense = -1.0 if of_operation < 0 else 1.0
    if rated is not None:
        return sense * rated, "rated"
    document: Any = train.document
    stated = at_case(read(document).model).operation.rated
    if shaft in stated:
        return sense * stated[shaft], "operation.rated"
    if not of_operation:
        allowed = f"rated, operation.rated.{shaft}, or a torque of operation"
        raise ModelError(f"{shaft} has no rated torque", path="rated", allowed=allowed)
    return of_operation, "operation"


def locked_train(train: Train, shaft: OutputShaft) -> Train:
    """The same drawing, of its load case, with the other shafts held and the rated torque at the shaft.

    Raises
    ------
    ModelError : it is refused by the model.
    """
    document: dict[str, Any] = {name: table for name, table in train.document.items() if name not in _OF_OPERATION}
    case = value_at(train.document, ("cases", str(train.document.get("case") or ""))) or {}
    both = [value_at(train.document, ("operation",)) or {}, case]
    operation = {name: table[name] for table in both for name in _KEPT if name in table}
    loads = {**(train.document.get("loads") or {}), **(case.get("loads") or {})}  # type: ignore[dict-item]
    locked = {"held": list(shaft.held), "torque": {shaft.name: shaft.torque}}
    stated: dict[str, Any] = value_at(train.document, ("tolerance",)) or {}
    drawn = {path: entry for path, entry in stated.items() if not path.startswith(_NOT_DRAWN)}
    return load({**document, "operation": {**operation, **locked}, "loads": loads, "tolerance": drawn})
