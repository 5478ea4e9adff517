"""What XML and JSON have in common: ids that are numbers, attributes once each, relations of components that exist."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from ..errors import ModelError
from .structure import Attribute, Component, LoadCase, Relation, RexsFile
from .values import plain_text

__all__ = ["Gathered", "add_attribute", "checked_id", "gathered_file", "is_custom", "referred"]

_ID = re.compile(r"[0-9]{1,15}")


@dataclass(slots=True)
class Gathered:
    """Parts of a file while it is read.

    notes : what is the user's own and left out.  custom : ids of components left out.
    """

    components: dict[int, Component] = field(default_factory=dict)
    relations: list[Relation] = field(default_factory=list)
    load_cases: list[LoadCase] = field(default_factory=list)
    accumulations: list[Component] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    custom: set[int] = field(default_factory=set)

    def add(self, component: Component) -> None:
        """Take a component. Raises ModelError for a second one of the same id, or one without type."""
        where = f"component {component.id}"
        if component.id in self.components or component.id in self.custom:
            raise ModelError("two components with one id", path=where, allowed="each id once")
        if not component.type:
            raise ModelError("missing", path=f"{where}, type", allowed="a type of the standard")
        if is_custom(component.type):
            self.custom.add(component.id)
            self.notes.append(f"component {component.id}: {component.type}")
            return
        self.components[component.id] = component


def is_custom(name: str) -> bool:
    """Whether a name is the user's own, which the standard leaves to him."""
    return name.startswith("custom_")


def checked_id(value: object, what: str) -> int:
    """An id as a number. Raises ModelError where it is none."""
    if isinstance(value, str) and _ID.fullmatch(value.strip()):
        return int(value)
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 10**15:
        return value
    if isinstance(value, float) and value.is_integer() and 0 <= value < 10**15:
        return int(value)
    raise ModelError("not an id", path=f"{what}, id", given=value, allowed="a whole number")


def add_attribute(attributes: dict[str, Attribute], attribute: Attribute, where: str) -> None:
    """Take an attribute of a component. Raises ModelError for one without id, or a second one of the same id."""
    if not attribute.id:
        raise ModelError("an attribute without id", path=where)
    if attribute.id in attributes:
        raise ModelError("stands twice", path=where, allowed="each attribute once")
    attributes[attribute.id] = attribute


def referred(
    number: int, kind: str, order: object, refs: Iterable[tuple[str, object]], gathered: Gathered
) -> Relation | None:
    """A relation of components that exist; None where it, or a component in it, is the user's own.

    Raises
    ------
    ModelError : no type, an order that is no number, a component that is not there.
    """
    where = f"relation {number}"
    if is_custom(kind):
        gathered.notes.append(f"{where}: {kind}")
        return None
    if not kind:
        raise ModelError("missing", path=f"{where}, type", allowed="a type of the standard")
    found = [(role, checked_id(part, where)) for role, part in refs if not is_custom(role)]
    if any(part in gathered.custom for _, part in found):
        return None
    for role, part in found:
        if part not in gathered.components:
            raise ModelError("no such component", path=f"{where}, {role}", given=part, allowed="an id of a component")
    place = None if order is None or order == "" else checked_id(order, f"{where}, order")
    return Relation(number, kind, place, tuple(found))


def gathered_file(gathered: Gathered, heads: Mapping[str, str], *, encoding: Literal["xml", "json"]) -> RexsFile:
    """The file of what was gathered and of the attributes of its root."""
    return RexsFile(
        version=plain_text(heads["version"]),
        application=plain_text(heads["applicationId"]),
        application_version=plain_text(heads["applicationVersion"]),
        date=plain_text(heads["date"]),
        components=tuple(gathered.components.values()),
        relations=tuple(gathered.relations),
        load_cases=tuple(gathered.load_cases),
        accumulations=tuple(gathered.accumulations),
        encoding=encoding,
        notes=tuple(gathered.notes),
    )
