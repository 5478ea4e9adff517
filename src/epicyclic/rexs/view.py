"""A REXS file asked by what its components are to each other, and what of it was asked: the rest is dropped.

Its numbers come in SI and in the spelling of a model file, from unit texts of any version and spelling.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal

from ..errors import ModelError
from .file import Component, Relation, RexsFile, Value

_DEG = math.pi / 180
_RPM = math.pi / 30
# kind -> unit without blanks -> factor to SI, the same unit in a model file (empty: written in SI)
_UNITS: dict[str, dict[str, tuple[float, str]]] = {
    "ratio": {"": (1.0, ""), "none": (1.0, ""), "-": (1.0, ""), "1": (1.0, ""), "%": (0.01, ""), "percent": (0.01, "")},
    "length": {
        **{"m": (1.0, "m"), "dm": (0.1, "dm"), "cm": (0.01, "cm"), "mm": (1e-3, "mm"), "km": (1e3, "km")},
        **{"mum": (1e-6, "um"), "um": (1e-6, "um"), "micron": (1e-6, "um"), "nm": (1e-9, "nm")},
        **{"in": (0.0254, "in"), "inch": (0.0254, "in"), "ft": (0.3048, "ft")},
    },
    "angle": {
        **{"rad": (1.0, "rad"), "mrad": (1e-3, "mrad")},
        **{text: (_DEG, "deg") for text in ("deg", "degree", "degrees", "\u00b0", "\u00ba", "Grad")},
        **{"arcmin": (_DEG / 60, "arcmin"), "arcsec": (_DEG / 3600, "arcsec"), "gon": (math.pi / 200, "gon")},
    },
    "speed": {
        **{text: (_RPM, "rpm") for text in ("1/min", "rpm", "min^-1", "min-1", "U/min", "rev/min", "1/Min")},
        **{text: (math.tau, "") for text in ("1/s", "s^-1", "rev/s", "U/s", "Hz")},  # revolutions, as REXS counts them
        **{"rad/s": (1.0, "rad/s"), "deg/s": (_DEG, "deg/s"), "\u00b0/s": (_DEG, "deg/s")},
    },
    "torque": {
        **{"Nm": (1.0, "N m"), "Nmm": (1e-3, "N mm"), "kNm": (1e3, "kN m"), "MNm": (1e6, "MN m"), "kNmm": (1.0, "N m")},
        "Ncm": (1e-2, "N cm"),
    },
    "power": {"W": (1.0, "W"), "kW": (1e3, "kW"), "MW": (1e6, "MW"), "PS": (735.49875, "")},
    "force": {"N": (1.0, "N"), "kN": (1e3, "kN"), "MN": (1e6, "MN")},
    "stiffness": {
        **{"N/m": (1.0, "N/m"), "kN/m": (1e3, "kN/m"), "MN/m": (1e6, "MN/m"), "GN/m": (1e9, "GN/m")},
        **{"N/mm": (1e3, "N/mm"), "kN/mm": (1e6, "kN/mm"), "MN/mm": (1e9, "MN/mm")},
        **{"N/mum": (1e6, "N/um"), "N/um": (1e6, "N/um"), "kN/mum": (1e9, "kN/um"), "kN/um": (1e9, "kN/um")},
    },
    "stiffness_per_width": {
        **{text: (1e9, "N/(mm um)") for text in ("N/(mmmum)", "N/(mmum)", "N/mm/mum", "N/mm/um", "N/(mummm)")},
        **{"N/(mumm)": (1e6, ""), "N/(mmm)": (1e3, ""), "N/m^2": (1.0, "N/m^2"), "N/mm^2": (1e6, "N/mm^2")},
        **{"kN/mm^2": (1e9, "kN/mm^2"), "MPa": (1e6, "MPa"), "GPa": (1e9, "GPa"), "Pa": (1.0, "Pa")},
    },
    "torsional_stiffness": {
        **{
            "Nmm/rad": (1e-3, ""),
            "Nm/rad": (1.0, "N m/rad"),
            "kNm/rad": (1e3, "kN m/rad"),
            "MNm/rad": (1e6, "MN m/rad"),
        },
        **{"Nm/deg": (1 / _DEG, ""), "Nm/\u00b0": (1 / _DEG, ""), "Nmm/deg": (1e-3 / _DEG, ""), "Nmm": (1e-3, "")},
        **{"Nmm/mrad": (1.0, ""), "Nm/mrad": (1e3, ""), "Nm": (1.0, "")},
    },
    "density": {
        **{"kg/dm^3": (1e3, "g/cm^3"), "g/cm^3": (1e3, "g/cm^3"), "kg/m^3": (1.0, "kg/m^3"), "t/m^3": (1e3, "t/m^3")},
        **{"kg/mm^3": (1e9, "kg/mm^3"), "kg/l": (1e3, "g/cm^3"), "kg/L": (1e3, "g/cm^3")},
    },
    "pressure": {
        **{
            "N/mm^2": (1e6, "N/mm^2"),
            "MPa": (1e6, "MPa"),
            "GPa": (1e9, "GPa"),
            "Pa": (1.0, "Pa"),
            "N/m^2": (1.0, "Pa"),
        },
        **{"kN/mm^2": (1e9, "GPa"), "bar": (1e5, "bar")},
    },
    "mass": {"kg": (1.0, "kg"), "g": (1e-3, "g"), "t": (1e3, "t"), "mg": (1e-6, "mg")},
    "inertia": {"kgm^2": (1.0, "kg m^2"), "kgmm^2": (1e-6, "kg mm^2"), "gmm^2": (1e-9, ""), "tm^2": (1e3, "")},
    "acceleration": {"m/s^2": (1.0, "m/s^2"), "mm/s^2": (1e-3, "mm/s^2")},
}
# units in SI, as a model file spells them
_SI = {
    "ratio": "", "length": "m", "angle": "rad", "speed": "rad/s", "torque": "N m", "power": "W", "force": "N",
    "stiffness": "N/m", "stiffness_per_width": "N/m^2", "torsional_stiffness": "N m/rad", "density": "kg/m^3",
    "pressure": "Pa", "mass": "kg", "inertia": "kg m^2", "acceleration": "m/s^2",
}  # fmt: skip
# nothing of a gear unit is larger in SI; "rigid" is 1e23 N/m
_LARGEST = 1e30


@dataclass(frozen=True, slots=True)
class Number:
    """A number of a REXS file.

    si : in SI.  text : as a model file writes it, in the unit of the file where that is one of a model file.
    """

    si: float
    text: str

    def __neg__(self) -> Number:
        return Number(-self.si, self.text[1:] if self.text.startswith("-") else f"-{self.text}")

    def __abs__(self) -> Number:
        return -self if self.si < 0 or self.text.startswith("-") else self


def number_of(component: Component, name: str, kind: str) -> Number | None:
    """A number of a component, in the unit that stands on the attribute; None where it is not given.

    Raises
    ------
    ModelError : no number, a unit that is unknown or of another kind; names the component and the attribute.
    """
    attribute = component.attributes.get(name)
    if attribute is None or attribute.value is None:
        return None
    value, where = attribute.value, f"component {component.id} ({component.type}), {name}"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        given = list(value) if isinstance(value, tuple) else value
        raise ModelError("not a number", path=where, given=given, allowed=f"a number in {_SI[kind] or 'no unit'}")
    factor = _UNITS[kind].get(_plain(attribute.unit))
    if factor is None:
        allowed = ", ".join(dict.fromkeys(unit for _, unit in _UNITS[kind].values() if unit)) or "none"
        raise ModelError("unit not known or of another kind", path=where, given=attribute.unit, allowed=allowed)
    si = value * factor[0]
    if not abs(si) < _LARGEST:
        raise ModelError("out of range", path=where, given=f"{value} {attribute.unit}")
    if factor[1]:
        return Number(si, f"{shown(value)} {factor[1]}")
    return Number(si, f"{shown(si)} {_SI[kind]}".strip())


def _plain(unit: str) -> str:
    """A unit in one spelling: no blanks, micro as mu, powers with ^."""
    text = "".join(unit.split()).replace("\u00b5", "mu").replace("\u03bc", "mu")
    for old, new in (("\u00b2", "^2"), ("\u00b3", "^3"), ("**", "^"), ("*", ""), ("\u00b7", ""), ("[", ""), ("]", "")):
        text = text.replace(old, new)
    return text


def shown(value: float) -> str:
    """The shortest text of a number that is read with the same bits; -0 is 0, large round ones have a power of ten."""
    number = float(value) + 0.0
    if abs(number) >= 1e6:
        return str(Decimal(repr(number)).normalize()).replace("E+", "e")
    return repr(number).removesuffix(".0")


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
