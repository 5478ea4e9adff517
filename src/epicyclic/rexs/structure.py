"""A REXS file as plain data: components with attributes, the relations between them, load cases.  No meaning yet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Attribute", "Component", "LoadCase", "Relation", "RexsFile", "Value"]

Value = float | int | bool | str | tuple["Value", ...] | None
"""Value of an attribute: scalar, tuple (array), tuple of tuples (matrix, array of arrays); None where it is empty."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """A value of a component, in the unit beside it.

    id : name by the standard, ``normal_module``.
    value : in `unit`, as the file has it.
    unit : as the file spells it, ``"N / (mm mum)"``; ``"none"`` or empty without one.
    """

    id: str
    value: Value
    unit: str = "none"


@dataclass(frozen=True, slots=True)
class Component:
    """A part, a stage, a load, a material: whatever has attributes.

    id : its number in the file.  type : of the standard, ``cylindrical_gear``.  name : free text.
    attributes : by their id, in the order of the file.
    """

    id: int
    type: str
    name: str = ""
    attributes: Mapping[str, Attribute] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Relation:
    """A statement about components.

    id : its number in the file.  type : of the standard, ``side``.  order : of ordered relations, else None.
    refs : (role, id of the component), in the order of the file.
    """

    id: int
    type: str
    order: int | None
    refs: tuple[tuple[str, int], ...]

    def part(self, role: str) -> int | None:
        """Id of the first component in a role, None where there is none."""
        return next((part for name, part in self.refs if name == role), None)


@dataclass(frozen=True, slots=True)
class LoadCase:
    """A load case of a load spectrum: attributes that stand in place of those of the components, or beside them.

    id : its number in the file.  components : those with attributes of their own here.
    """

    id: int
    components: tuple[Component, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RexsFile:
    """A REXS file, read.

    version : ``"1.7"``, ``"2.0.0"``.  application, application_version, date : as the file says.
    components : in the order of the file, each id once.  relations : in the order of the file.
    load_cases : of all load spectra.  accumulations : attributes over a whole load spectrum.
    encoding : ``"xml"`` or ``"json"``.  notes : what the reader left out, in words.
    """

    version: str
    components: tuple[Component, ...]
    relations: tuple[Relation, ...]
    application: str = ""
    application_version: str = ""
    date: str = ""
    load_cases: tuple[LoadCase, ...] = ()
    accumulations: tuple[Component, ...] = ()
    encoding: str = "xml"
    notes: tuple[str, ...] = ()
