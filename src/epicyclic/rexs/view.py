"""A REXS file asked by what its components are to each other, and what of it was asked: the rest is dropped.

Support vectors in nested reference frames become points and axes of the gear unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from ..errors import ModelError
from .file import Component, Number, Relation, RexsFile, Value, number_in, number_of

Vector = tuple[float, float, float]
_Index = Mapping[int, Sequence[int]]
_MOST_FRAMES = 50  # references nested deeper than any gear unit: a loop


def along(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return math.fsum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a: Vector, b: Vector) -> Vector:
    """Difference."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@dataclass(frozen=True, slots=True)
class PartFrame:
    """A place [m] and the axes u, v, w of a component, in the frame of the gear unit."""

    place: Vector
    u: Vector
    v: Vector
    w: Vector

    def turned(self, vector: Vector) -> Vector:
        """A vector given along the axes."""
        u, v, w = self.u, self.v, self.w
        x, y, z = vector
        return (
            x * u[0] + y * v[0] + z * w[0],
            x * u[1] + y * v[1] + z * w[1],
            x * u[2] + y * v[2] + z * w[2],
        )


_UNIT = PartFrame((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


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
    asked : component -> attributes that were asked for.  frames : of components, found when asked.
    unread : stages without planets, which are not read -> their two gears.
    """

    file: RexsFile
    components: Mapping[int, Component]
    types: Mapping[str, Sequence[int]]
    assembled: _Index
    assemblies: _Index
    references: _Index
    flanks: _Index
    by_type: Mapping[str, Sequence[Relation]]
    entries: dict[Entry, None] = field(default_factory=dict)
    assumptions: dict[Entry, None] = field(default_factory=dict)
    losses: dict[Entry, None] = field(default_factory=dict)
    asked: dict[int, dict[str, None]] = field(default_factory=dict)
    frames: dict[int, PartFrame | None] = field(default_factory=dict)
    unread: dict[int, tuple[int, int]] = field(default_factory=dict)

    def of_type(self, *types: str) -> list[Component]:
        """Components of some types, by id."""
        return [self.components[i] for i in sorted(i for kind in types for i in self.types.get(kind, ()))]

    def relations(self, *types: str) -> Iterable[Relation]:
        """Relations of some types, in the order of the file."""
        return (relation for kind in types for relation in self.by_type.get(kind, ()))

    def shafts(self, relation: str, stage: int) -> list[int]:
        """Shafts that relations of a type join to a planetary stage, each once."""
        return list(_index_of(self.relations(relation), "planetary_stage", "shaft").get(stage, ()))

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

    def frame(self, component: int) -> PartFrame | None:
        """Frame of a component; None where the file gives no place.

        Raises
        ------
        ModelError : no vector of three numbers, axes without direction, references in a circle.
        """
        return self._frame(component, 0)

    def on_shaft(self, component: int, shaft: int, coordinate: str) -> Vector | None:
        """Place of what sits on a shaft: its own, else its coordinate along the shaft."""
        frame = self.frame(component)
        if frame is not None:
            return frame.place
        base, distance = self.frame(shaft), self.number(component, coordinate, "length")
        if base is None or distance is None:
            return None if base is None else base.place  # where along the shaft is not said
        (x, y, z), u, length = base.place, base.u, distance.si
        return (x + u[0] * length, y + u[1] * length, z + u[2] * length)

    def gear_place(self, gear: int, shaft: int | None) -> Vector | None:
        """Centre of a gear: its own place, else that on its shaft."""
        if shaft is not None:
            return self.on_shaft(gear, shaft, "u_coordinate_on_shaft")
        frame = self.frame(gear)
        return None if frame is None else frame.place

    def _frame(self, component: int, depth: int) -> PartFrame | None:
        if component in self.frames:
            return self.frames[component]
        if depth > _MOST_FRAMES:
            raise ModelError("references of position in a circle", path=f"component {self.label(component)}")
        place = self._vector(component, "support_vector")
        base = _UNIT
        reference = self.value(component, "reference_component_for_position")
        if isinstance(reference, (int, float)) and not isinstance(reference, bool) and int(reference) != component:
            if int(reference) in self.components:
                base = self._frame(int(reference), depth + 1) or _UNIT
        frame = None
        if place is not None:
            u = self._axis(component, "u_axis_vector", (1.0, 0.0, 0.0))
            w = self._axis(component, "w_axis_vector", (0.0, 0.0, 1.0))
            origin, absolute = base.place, base.turned(place)
            axis, third = base.turned(u), base.turned(w)
            centre = (origin[0] + absolute[0], origin[1] + absolute[1], origin[2] + absolute[2])
            frame = PartFrame(centre, axis, cross(third, axis), third)
        self.frames[component] = frame
        return frame

    def _vector(self, component: int, name: str) -> Vector | None:
        """A vector attribute as lengths in SI; None where it is not given."""
        value = self.value(component, name)
        if value is None:
            return None
        where = f"component {self.label(component)}, {name}"
        shown = list(value) if isinstance(value, tuple) else value
        if not isinstance(value, tuple) or len(value) != 3:
            raise ModelError("not a vector", path=where, given=shown, allowed="an array of three numbers")
        unit = self.components[component].attributes[name].unit
        numbers = []
        for entry in value:
            if entry is None:
                raise ModelError("not a vector", path=where, given=shown, allowed="an array of three numbers")
            numbers.append(number_in(entry, unit, "length", where).si)
        return (numbers[0], numbers[1], numbers[2])

    def _axis(self, component: int, name: str, default: Vector) -> Vector:
        """A direction of length 1; its unit means nothing."""
        vector = self._vector(component, name)
        if vector is None:
            return default
        size = math.sqrt(along(vector, vector))
        if not size > 1e-30:
            raise ModelError("a direction of length 0", path=f"component {self.label(component)}, {name}")
        return (vector[0] / size, vector[1] / size, vector[2] / size)


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
            if (base := components.get(over.id)) is not None:
                components[over.id] = replace(base, attributes={**base.attributes, **over.attributes})
    types: dict[str, list[int]] = {}
    for number in sorted(components):
        types.setdefault(components[number].type, []).append(number)
    by_type: dict[str, list[Relation]] = {}
    for relation in file.relations:
        by_type.setdefault(relation.type, []).append(relation)
    assemblies = [*by_type.get("assembly", ()), *by_type.get("ordered_assembly", ())]
    references = [*by_type.get("reference", ()), *by_type.get("ordered_reference", ())]
    flanks: dict[int, list[int]] = {}
    for relation in by_type.get("flank", ()):
        gear, sides = relation.part("gear"), (relation.part("left"), relation.part("right"))
        if gear is not None:
            flanks.setdefault(gear, [side for side in sides if side is not None])
    return View(
        file=file,
        components=components,
        types=types,
        assembled=_index_of(assemblies, "assembly", "part"),
        assemblies=_index_of(assemblies, "part", "assembly"),
        references=_index_of(references, "origin", "referenced"),
        flanks=flanks,
        by_type=by_type,
    )


def _index_of(relations: Iterable[Relation], key: str, value: str) -> _Index:
    """Components in one role by that in another, each once."""
    index: dict[int, dict[int, None]] = {}
    for relation in relations:
        a, b = relation.part(key), relation.part(value)
        if a is not None and b is not None:
            index.setdefault(a, {})[b] = None
    return {a: tuple(parts) for a, parts in index.items()}
