"""A REXS file asked by what its components are to each other, and what of it was asked: the rest is dropped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from ..errors import ModelError
from .structure import Component, Relation, RexsFile, Value
from .units import Number, number_of

__all__ = ["Entry", "View", "view_of"]

_Index = Mapping[int, tuple[int, ...]]
_Types = Mapping[str, tuple[int, ...]]


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


@dataclass(slots=True, kw_only=True)
class View:
    """A REXS file with the values of one load case, and the list of what was read, assumed and lost.

    components : by id, attributes of the load case laid over.  types : ids by type, ascending.
    assembled : assembly -> its parts.  assemblies : part -> what it is assembled to.
    references : origin -> referenced.  flanks : gear -> left and right flank.  by_type : relations by their type.
    entries, assumptions, losses : each entry once, in the order of the questions.
    asked : component -> attributes that were asked for.
    unread : stages without planets, which are not read -> their two gears.
    """

    file: RexsFile
    components: Mapping[int, Component]
    types: _Types
    assembled: _Index
    assemblies: _Index
    references: _Index
    flanks: _Index
    by_type: Mapping[str, tuple[Relation, ...]]
    entries: dict[Entry, None] = field(default_factory=dict)
    assumptions: dict[Entry, None] = field(default_factory=dict)
    losses: dict[Entry, None] = field(default_factory=dict)
    asked: dict[int, dict[str, None]] = field(default_factory=dict)
    unread: dict[int, tuple[int, int]] = field(default_factory=dict)

    def of_type(self, *types: str) -> list[Component]:
        """Components of some types, by id."""
        return [self.components[i] for i in sorted(i for kind in types for i in self.types.get(kind, ()))]

    def relations(self, *types: str) -> Iterable[Relation]:
        """Relations of some types, in the order of the file."""
        return (relation for kind in types for relation in self.by_type.get(kind, ()))

    def parts(self, assembly: int, *types: str) -> list[int]:
        """Parts of an assembly, of some component types or of all."""
        return [p for p in self.assembled.get(assembly, ()) if not types or self.components[p].type in types]

    def shaft_of(self, part: int) -> int | None:
        """Shaft a gear or load is assembled to, None where there is none."""
        return next((a for a in self.assemblies.get(part, ()) if self.components[a].type == "shaft"), None)

    def referenced(self, origin: int) -> list[Component]:
        """What a component refers to: material, tool, flank modification."""
        return [self.components[part] for part in self.references.get(origin, ())]

    def flanks_of(self, gear: int) -> list[Component]:
        """Left and right flank of a gear, those that are given."""
        return [self.components[part] for part in self.flanks.get(gear, ())]

    def number(self, component: int, name: str, kind: str) -> Number | None:
        """A number of a component; None where it is not given. Raises ModelError as of `number_of`."""
        self.asked.setdefault(component, {})[name] = None
        return number_of(self.components[component], name, kind)

    def value(self, component: int, name: str) -> Value:
        """A value of a component as it stands; None where it is not given."""
        self.asked.setdefault(component, {})[name] = None
        attribute = self.components[component].attributes.get(name)
        return None if attribute is None else attribute.value

    def read(self, component: int, attribute: str, path: str, text: object) -> None:
        """Note that an attribute became what stands at a path."""
        self.entries[Entry(component, attribute, path, str(text))] = None

    def assume(self, component: int | None, attribute: str, path: str, reason: str) -> None:
        """Note what the file does not say and what was taken."""
        self.assumptions[Entry(component, attribute, path, reason)] = None

    def lose(self, component: int | None, attribute: str, reason: str) -> None:
        """Note what was asked and cannot be carried."""
        self.losses[Entry(component, attribute, "", reason)] = None

    def label(self, component: int) -> str:
        """``53 (cylindrical_gear)``."""
        return f"{component} ({self.components[component].type})"


def view_of(file: RexsFile, load_case: int | None) -> View:
    """The view of a file, with the attributes of a load case laid over.

    Raises
    ------
    ModelError : a load case that is not there.
    """
    components = {component.id: component for component in file.components}
    if load_case is not None:
        case = next((case for case in file.load_cases if case.id == load_case), None)
        if case is None:
            ids = ", ".join(str(c.id) for c in file.load_cases[:20]) or "none in this file"
            raise ModelError("no such load case", path="load_case", given=load_case, allowed=ids)
        for over in case.components:
            if over.id in components:
                merged = {**components[over.id].attributes, **over.attributes}
                components[over.id] = replace(components[over.id], attributes=merged)
    types: dict[str, list[int]] = {}
    for number in sorted(components):
        types.setdefault(components[number].type, []).append(number)
    by_type: dict[str, list[Relation]] = {}
    for relation in file.relations:
        by_type.setdefault(relation.type, []).append(relation)
    assemblies = [*by_type.get("assembly", ()), *by_type.get("ordered_assembly", ())]
    references = [*by_type.get("reference", ()), *by_type.get("ordered_reference", ())]
    flanks: dict[int, tuple[int, ...]] = {}
    for relation in by_type.get("flank", ()):
        gear, sides = relation.part("gear"), (relation.part("left"), relation.part("right"))
        if gear is not None:
            flanks.setdefault(gear, tuple(side for side in sides if side is not None))
    return View(
        file=file,
        components=components,
        types={kind: tuple(ids) for kind, ids in types.items()},
        assembled=_index(assemblies, "assembly", "part"),
        assemblies=_index(assemblies, "part", "assembly"),
        references=_index(references, "origin", "referenced"),
        flanks=flanks,
        by_type={kind: tuple(found) for kind, found in by_type.items()},
    )


def _index(relations: Iterable[Relation], key: str, value: str) -> _Index:
    """Components in one role by that in another, each once."""
    found: dict[int, dict[int, None]] = {}
    for relation in relations:
        a, b = relation.part(key), relation.part(value)
        if a is not None and b is not None:
            found.setdefault(a, {})[b] = None
    return {a: tuple(parts) for a, parts in found.items()}
