"""A REXS file asked by what its components are to each other, and what of it was asked: the rest is dropped."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from ..errors import ModelError
from .structure import Component, Relation, RexsFile, Value
from .units import Number, number_of

__all__ = ["Entry", "View"]


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of what an import did.

    component : id of the component, None where it is of the whole file.  attribute : which, or several.
    path : in the model file, empty where it went nowhere.  text : value, or reason.
    """

    component: int | None
    attribute: str
    path: str
    text: str


@dataclass(slots=True)
class View:
    """A REXS file with the values of one load case, and the list of what was read and assumed.

    components : by id, attributes of the load case laid over.
    """

    file: RexsFile
    components: dict[int, Component]
    entries: list[Entry] = field(default_factory=list)
    assumptions: list[Entry] = field(default_factory=list)
    losses: list[Entry] = field(default_factory=list)
    asked: set[tuple[int, str]] = field(default_factory=set)
    _by_type: dict[str, list[Relation]] = field(default_factory=dict)

    @classmethod
    def of(cls, file: RexsFile, load_case: int | None) -> View:
        """The view of a file. Raises ModelError for a load case that is not there."""
        components = {component.id: component for component in file.components}
        if load_case is not None:
            case = next((case for case in file.load_cases if case.id == load_case), None)
            if case is None:
                ids = ", ".join(str(c.id) for c in file.load_cases) or "none in this file"
                raise ModelError("no such load case", path="load_case", given=load_case, allowed=ids)
            for over in case.components:
                if over.id in components:
                    merged = {**components[over.id].attributes, **over.attributes}
                    components[over.id] = replace(components[over.id], attributes=merged)
        view = cls(file, components)
        for relation in file.relations:
            view._by_type.setdefault(relation.type, []).append(relation)
        return view

    def of_type(self, *types: str) -> list[Component]:
        """Components of some types, by id."""
        return sorted((c for c in self.components.values() if c.type in types), key=lambda c: c.id)

    def relations(self, *types: str) -> Iterable[Relation]:
        """Relations of some types, in the order of the file."""
        return (relation for kind in types for relation in self._by_type.get(kind, ()))

    def parts(self, assembly: int, *types: str) -> list[int]:
        """Parts of an assembly, of some component types or of all."""
        found = [
            part
            for relation in self.relations("assembly", "ordered_assembly")
            if relation.part("assembly") == assembly and (part := relation.part("part")) is not None
        ]
        return [part for part in dict.fromkeys(found) if not types or self.components[part].type in types]

    def referenced(self, origin: int) -> list[Component]:
        """What a component refers to: material, tool, flank modification."""
        relations = self.relations("reference", "ordered_reference")
        found = [r.part("referenced") for r in relations if r.part("origin") == origin]
        return [self.components[part] for part in found if part is not None]

    def number(self, component: int, name: str, kind: str) -> Number | None:
        """A number of a component; None where it is not given. Raises ModelError as of `number_of`."""
        self.asked.add((component, name))
        return number_of(self.components[component], name, kind)

    def value(self, component: int, name: str) -> Value:
        """A value of a component as it stands; None where it is not given."""
        self.asked.add((component, name))
        attribute = self.components[component].attributes.get(name)
        return None if attribute is None else attribute.value

    def read(self, component: int, attribute: str, path: str, text: object) -> None:
        """Note that an attribute became what stands at a path."""
        self.entries.append(Entry(component, attribute, path, str(text)))

    def assume(self, component: int | None, attribute: str, path: str, reason: str) -> None:
        """Note what the file does not say and what was taken."""
        entry = Entry(component, attribute, path, reason)
        if entry not in self.assumptions:
            self.assumptions.append(entry)

    def lose(self, component: int | None, attribute: str, reason: str) -> None:
        """Note what was asked and cannot be carried."""
        entry = Entry(component, attribute, "", reason)
        if entry not in self.losses:
            self.losses.append(entry)

    def label(self, component: int) -> str:
        """``53 (cylindrical_gear)``."""
        return f"{component} ({self.components[component].type})"
