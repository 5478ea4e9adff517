"""A REXS file as plain data, and what of it has a place in a model.

The data are components with attributes, the relations between them, load cases.  File names are asked of every model,
before any module that reads XML is imported.  The values are the same from XML and from JSON: texts, arrays and
matrices in Base64.  Numbers come in SI and in the spelling of a model file, from units of any version and spelling.

What has a place in a model is said once for both ways: attributes of components, relations, words, units.  The import
finds the kind of quantity of an attribute here, its key in the table that the component becomes, and how it is spelled
there.  The export walks the rows of a type, takes each value of the part of the train that is written, and finds its
unit here.  An attribute that is more than one number of a part (places, the hand of a gear, profile shifts that follow,
what a joint holds) has its row too; what becomes of it is code of the one way or the other.
"""

from __future__ import annotations

import base64
import binascii
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from operator import attrgetter
from pathlib import Path
from typing import Literal, NamedTuple

from ..errors import ModelError

# Names and texts: longer ones say nothing that a model file could carry.
MAX_TEXT = 2_000
HEADINGS = {
    "read": "Read from the file",
    "assumed": "Assumed, as the file does not say it",
    "dropped": "Dropped, as the model has no place for it",
}
"""List of an import -> what stands above it."""
SUFFIXES = (".rexs", ".rexsj", ".rexsz", ".rexs.xml", ".rexs.json", ".rexs.zip")  # of XML, JSON and a zip, twice


def is_rexs_name(name: str | Path) -> bool:
    """Whether a file is a REXS file by its name."""
    return str(name).lower().endswith(SUFFIXES)


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


# values ---------------------------------------------------------------------------------------------------------------

# what XML and JSON may hold and a model file may not: control characters, and halves of surrogate pairs
_UNSAFE = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]+")
_INTEGER = re.compile(r"[+-]?[0-9]{1,18}")
_FLOAT = re.compile(r"[+-]?(?:[0-9]{1,400}(?:\.[0-9]{0,400})?|\.[0-9]{1,400})(?:[eE][+-]?[0-9]{1,6})?")
# attributes that are names even where a name is all digits: a material 1.6580 is not 1.658
_NAMES = re.compile(r"(?:^|_)(?:name|designation|manufacturer|description|comment|remark|number_of_drawing)(?:_|$)")
_CODES = ("float64", "float32", "int32")  # of arrays


def plain_text(text: str) -> str:
    """A text without control characters, on one line, of bounded length."""
    return _UNSAFE.sub(" ", text).strip()[:MAX_TEXT]


def text_value(text: str, attribute: str) -> Value:
    """Value of the text of an attribute; None where it is blank.

    In XML every value is a text, so that a text which reads as a number or truth value is one.  A number that is not
    finite stays a text: nothing computes with it by accident.
    """
    stripped = plain_text(text)
    if not stripped:
        return None
    if _NAMES.search(attribute):
        return stripped
    if stripped in ("true", "false"):
        return stripped == "true"
    if _INTEGER.fullmatch(stripped):
        return int(stripped)
    if _FLOAT.fullmatch(stripped) and math.isfinite(number := float(stripped)):
        return number
    return stripped


def scalar(value: object, attribute: str) -> Value:
    """Value of a scalar of JSON: texts as in XML, numbers too large for a float as texts.

    Raises
    ------
    ModelError : a list or table where a scalar stands.
    """
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return text_value(value, attribute)
    if isinstance(value, int):
        return value if abs(value) < 10**18 else _finite(float(value) if abs(value) < 10**300 else math.inf)
    if isinstance(value, float):
        return _finite(value)
    raise ModelError("a list or table where one value stands", path=attribute, given=type(value).__name__)


def _finite(number: float) -> Value:
    """A number, or its text where it is infinite or nan."""
    return number if math.isfinite(number) else repr(number)


def decoded(code: object, text: object, shape: tuple[object, object] | None, attribute: str) -> Value:
    """Numbers of an array or matrix in Base64, little-endian.

    Parameters
    ----------
    code : ``float64``, ``float32`` or ``int32``.  text : the Base64.
    shape : of a matrix its rows and columns, each None where not given: it is square then.  None for an array.
    attribute : its id, for an error.

    Raises
    ------
    ModelError : another code, no Base64, a number of bytes that does not fit.
    """
    allowed = f"code {', '.join(_CODES)} with Base64 text"
    if not isinstance(code, str) or code not in _CODES:
        raise ModelError("an array in an unknown code", path=attribute, given=code, allowed=allowed)
    if not isinstance(text, str):
        raise ModelError("no Base64 text", path=attribute, given=text, allowed=allowed)
    try:
        raw = base64.b64decode("".join(text.split()), validate=True)
    except (binascii.Error, ValueError):
        raise ModelError("no Base64", path=attribute, given=text[:40], allowed=allowed) from None
    import numpy as np  # few files have arrays

    if len(raw) % (size := np.dtype(code).itemsize):
        problem = f"{len(raw)} bytes are no whole number of values of {code}"
        raise ModelError(problem, path=attribute, allowed=f"a multiple of {size} bytes")
    numbers = np.frombuffer(raw, np.dtype(code).newbyteorder("<")).tolist()
    values = tuple(_finite(n) if isinstance(n, float) else n for n in numbers)
    return values if shape is None else _matrix(values, shape, attribute)


def _matrix(values: Sequence[Value], shape: tuple[object, object], attribute: str) -> Value:
    """Values in rows. Raises ModelError where they do not fill them."""
    rows, columns = (_whole(size) for size in shape)
    if rows is None and columns is None:
        rows = columns = math.isqrt(len(values))
    rows = len(values) // max(columns or 1, 1) if rows is None else rows
    columns = len(values) // max(rows, 1) if columns is None else columns
    # rows without columns would fit no values, a thousand million of them too
    if min(rows, columns) < 0 or max(rows, columns) > len(values) or rows * columns != len(values):
        problem = f"{len(values)} values do not fill the matrix"
        raise ModelError(problem, path=attribute, given=list(shape), allowed="rows and columns that fit")
    return tuple(tuple(values[row * columns : (row + 1) * columns]) for row in range(rows))


def _whole(size: object) -> int | None:
    """A count of rows or columns, written as number or text; None where it is not given."""
    if size is None:
        return None
    if isinstance(size, str) and _INTEGER.fullmatch(size.strip()):
        return int(size)
    return size if isinstance(size, int) and not isinstance(size, bool) else -1


# numbers with units ---------------------------------------------------------------------------------------------------

_DEG = math.pi / 180


def _units(
    spelled: Mapping[str, float], like: Mapping[str, str] | None = None, in_si: Mapping[str, float] | None = None
) -> dict[str, tuple[float, str]]:
    """Units of a kind: text without blanks -> factor to SI, the same unit in a model file (empty: written in SI).

    spelled : as a model file does, micro as ``um``.  like : other texts of these.  in_si : those a model file has not.
    """
    units = {text.replace(" ", "").replace("um", mu): (f, text) for text, f in spelled.items() for mu in ("mum", "um")}
    units |= {text: units[same.replace(" ", "")] for text, same in (like or {}).items()}
    return units | {text: (factor, "") for text, factor in (in_si or {}).items()}


_UNITS = {
    "ratio": _units({}, in_si={"": 1.0, "none": 1.0, "-": 1.0, "1": 1.0, "%": 0.01, "percent": 0.01}),
    "time": _units({"s": 1.0, "min": 60.0, "h": 3600.0}),
    "length": _units(
        {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 1e-3, "km": 1e3, "um": 1e-6, "nm": 1e-9, "in": 0.0254, "ft": 0.3048},
        like={"micron": "um", "inch": "in"},
    ),
    "angle": _units(
        {"rad": 1.0, "mrad": 1e-3, "deg": _DEG, "arcmin": _DEG / 60, "arcsec": _DEG / 3600, "gon": math.pi / 200},
        like=dict.fromkeys(("degree", "degrees", "\u00b0", "\u00ba", "Grad"), "deg"),
    ),
    "speed": _units(
        {"rpm": math.pi / 30, "rad/s": 1.0, "deg/s": _DEG},
        like={
            **dict.fromkeys(("1/min", "min^-1", "min-1", "U/min", "rev/min", "1/Min"), "rpm"),
            "\u00b0/s": "deg/s",
        },
        in_si=dict.fromkeys(("1/s", "s^-1", "rev/s", "U/s", "Hz"), math.tau),  # revolutions, as REXS counts them
    ),
    "torque": _units({"N m": 1.0, "N mm": 1e-3, "kN m": 1e3, "MN m": 1e6, "N cm": 1e-2}, like={"kNmm": "N m"}),
    "power": _units({"W": 1.0, "kW": 1e3, "MW": 1e6}, in_si={"PS": 735.49875}),
    "force": _units({"N": 1.0, "kN": 1e3, "MN": 1e6}),
    "stiffness": _units(
        {
            **{"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "GN/m": 1e9, "N/mm": 1e3, "kN/mm": 1e6, "MN/mm": 1e9},
            **{"N/um": 1e6, "kN/um": 1e9},
        }
    ),
    "stiffness_per_width": _units(
        {
            **{"N/(mm um)": 1e9, "N/m^2": 1.0, "N/mm^2": 1e6, "kN/mm^2": 1e9},
            **{"MPa": 1e6, "GPa": 1e9, "Pa": 1.0},
        },
        like=dict.fromkeys(("N/mm/mum", "N/mm/um", "N/(mummm)"), "N/(mm um)"),
        in_si={"N/(mumm)": 1e6, "N/(mmm)": 1e3},
    ),
    "torsional_stiffness": _units(
        {"N m/rad": 1.0, "kN m/rad": 1e3, "MN m/rad": 1e6},
        in_si={
            **{"Nmm/rad": 1e-3, "Nm/deg": 1 / _DEG, "Nm/\u00b0": 1 / _DEG, "Nmm/deg": 1e-3 / _DEG, "Nmm": 1e-3},
            **{"Nmm/mrad": 1.0, "Nm/mrad": 1e3, "Nm": 1.0},
        },
    ),
    "density": _units(
        {"g/cm^3": 1e3, "kg/m^3": 1.0, "t/m^3": 1e3, "kg/mm^3": 1e9},
        like=dict.fromkeys(("kg/dm^3", "kg/l", "kg/L"), "g/cm^3"),
    ),
    "pressure": _units(
        {"N/mm^2": 1e6, "MPa": 1e6, "GPa": 1e9, "Pa": 1.0, "bar": 1e5}, like={"N/m^2": "Pa", "kN/mm^2": "GPa"}
    ),
    "mass": _units({"kg": 1.0, "g": 1e-3, "t": 1e3, "mg": 1e-6}),
    "inertia": _units({"kg m^2": 1.0, "kg mm^2": 1e-6}, in_si={"gmm^2": 1e-9, "tm^2": 1e3}),
    "acceleration": _units({"m/s^2": 1.0, "mm/s^2": 1e-3}),
}
# units in SI, as a model file spells them
_SI = {kind: next(text for scale, text in units.values() if scale == 1.0) for kind, units in _UNITS.items()}
# nothing of a gear unit is larger in SI; "rigid" is 1e23 N/m
_LARGEST = 1e30
QUANTITIES = {
    **{"none": "ratio", "mm": "length", "mum": "length", "deg": "angle", "1 / min": "speed", "kW": "power"},
    **{"N m": "torque", "N / m": "stiffness", "N mm / rad": "torsional_stiffness", "N / mm^2": "pressure"},
    **{"N / (mm mum)": "stiffness_per_width", "kg / dm^3": "density", "kg": "mass", "kg m^2": "inertia"},
    **{"m / s^2": "acceleration", "h": "time", "%": "ratio"},
}
"""Unit of version 1.7 -> kind of quantity."""
# kinds that a train counts in the unit of the file: their numbers are written as they are
_AS_THEY_ARE = ("ratio", "speed", "torque", "mass", "inertia", "acceleration")
# what programs write for rigid, and every reader takes for it [N/m, N mm/rad]
_RIGID = 1e20


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
    return number_in(attribute.value, attribute.unit, kind, f"component {component.id} ({component.type}), {name}")


def number_in(value: Value, unit: str, kind: str, where: str) -> Number:
    """A value in a unit as a number. Raises ModelError as of `number_of`, with the place `where`."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        shown_value = list(value) if isinstance(value, tuple) else value
        raise ModelError("not a number", path=where, given=shown_value, allowed=f"a number in {_SI[kind] or 'no unit'}")
    # one spelling: no blanks, micro as mu, powers with ^
    plain = "".join(unit.split()).replace("\u00b5", "mu").replace("\u03bc", "mu")
    for old, new in (("\u00b2", "^2"), ("\u00b3", "^3"), ("**", "^"), ("*", ""), ("\u00b7", ""), ("[", ""), ("]", "")):
        plain = plain.replace(old, new)
    if plain not in _UNITS[kind]:
        allowed = ", ".join(dict.fromkeys(text for _, text in _UNITS[kind].values() if text)) or "none"
        raise ModelError("unit not known or of another kind", path=where, given=unit, allowed=allowed)
    factor, text = _UNITS[kind][plain]
    si = value * factor
    if not abs(si) < _LARGEST:
        raise ModelError("out of range", path=where, given=f"{value} {unit}")
    return Number(si, f"{shown(value)} {text}" if text else f"{shown(si)} {_SI[kind]}".strip())


def in_unit(value: float, unit: str) -> float:
    """A value of a train in a unit of version 1.7, infinite as programs write rigid."""
    kind = QUANTITIES[unit]
    if kind in _AS_THEY_ARE and unit != "%":
        return value
    if math.isinf(value) and kind in ("stiffness", "torsional_stiffness"):
        return _RIGID
    return shortest(value / _UNITS[kind]["".join(unit.split())][0])


def shortest(value: float) -> float:
    """A number without the digits that a division alone leaves.

    Fifteen digits are taken where they say the same number within two units in the last place: 380, not
    380.00000000000006; any other number keeps all of its digits.
    """
    number = value + 0.0
    if not math.isfinite(number):
        return number
    short = float(f"{number:.15g}")
    return short if abs(short - number) <= 2 * math.ulp(number) else number


def shown(value: float) -> str:
    """The shortest text of a number that is read with the same bits; -0 is 0, large round ones have a power of ten."""
    number = float(value) + 0.0
    if abs(number) >= 1e6:
        return str(Decimal(repr(number)).normalize()).replace("E+", "e")
    return repr(number).removesuffix(".0")


# what has a place in a model ------------------------------------------------------------------------------------------


class RexsRow(NamedTuple):
    """An attribute.

    type : of the component that has it, of several alike the one that is written; ``place``, ``on_shaft`` of all that
    stand somewhere.  id : of the standard.  unit : of version 1.7, which is written; what is read has its own.
    key : in the table of a model file that the component becomes; empty where it is more than this value.
    of : the value in SI in the part of the train that is written, ``gear.tip_radius``, and how many times; empty where
    the export computes it, or does not write it.
    magnitude : read without its sign; an angle of 0 is none.  form : of its value.
    default : in SI, where the model does not state it.  note : what is assumed where it is read.
    """

    type: str
    id: str
    unit: str = "none"
    key: str = ""
    of: str = ""
    times: float = 1
    magnitude: bool = False
    form: Literal["scalar", "array", "word", "component"] = "scalar"
    default: float = 0.0
    note: str = ""

    def entry(self, number: Number | None) -> object:
        """What a number becomes in a model file: its text, of a ratio the number; None where it is not given."""
        if number is None or (self.magnitude and self.unit == "deg" and not number.si):
            return None
        if self.unit == "none":
            return number.si
        return abs(number).text if self.magnitude else number.text


HELIX = "helix_angle_reference_diameter"
CASE_NAME = "custom_load_case_name"  # the standard has no names of load cases, and leaves `custom_` to the user
_ROWS = (
    RexsRow("place", "reference_component_for_position", form="component"),
    RexsRow("place", "support_vector", "mm", form="array"),
    RexsRow("place", "u_axis_vector", "mm", form="array"),
    RexsRow("place", "w_axis_vector", "mm", form="array"),
    RexsRow("on_shaft", "u_coordinate_on_shaft", "mm"),
    RexsRow("gear_unit", "number_of_gears"),
    RexsRow("gear_unit", "gear_shift_index"),
    RexsRow("gear_unit", "account_for_gravity"),
    RexsRow("gear_unit", "gravitational_acceleration", "m / s^2"),
    *(RexsRow("gear_unit", f"direction_vector_gravity_{axis}") for axis in "uvw"),
    # of a load case; those of versions 1.0 to 1.2 behind those of 1.3 and later
    *(RexsRow("gear_unit", name, "h", "duration") for name in ("operating_time", "load_duration")),
    *(RexsRow("gear_unit", f"{name}_fraction", "%", "share") for name in ("operating_time", "load_duration")),
    RexsRow("gear_unit", CASE_NAME),
    RexsRow("shaft", "rotational_speed", "1 / min"),
    RexsRow("shaft", "defines_speed"),
    RexsRow("shaft_section", "length", "mm"),
    *(
        RexsRow("shaft_section", f"{side}_diameter_{end}", "mm")
        for side in ("outer", "inner")
        for end in ("begin", "end")
    ),
    *(RexsRow("side_plate", f"{side}_diameter", "mm") for side in ("outer", "inner")),
    RexsRow("additional_mass", "mass", "kg", of="mass"),
    RexsRow("additional_mass", "moment_of_inertia_u_axis", "kg m^2", of="polar"),
    *(RexsRow("additional_mass", f"moment_of_inertia_{axis}_axis", "kg m^2", of="tilt") for axis in "vw"),
    RexsRow("external_load", "torque_around_u_axis", "N m"),
    RexsRow("external_load", "power", "kW"),
    RexsRow("external_load", "transmits_torque"),
    RexsRow("external_load", "defines_torque"),
    RexsRow("coupling", "radial_stiffness", "N / m", "radial"),
    RexsRow("coupling", "axial_stiffness", "N / m", "z"),
    RexsRow("coupling", "bending_stiffness", "N mm / rad", "tilt"),
    RexsRow("coupling", "rotational_stiffness", "N mm / rad", "rz"),
    RexsRow("coupling", "is_engaged", form="array"),
    RexsRow("coupling", "u_coordinate_on_shaft_inner_side", "mm"),
    RexsRow("concept_bearing", "radial_force_absorption"),
    RexsRow("concept_bearing", "axial_force_absorption", form="word"),
    *(RexsRow("concept_bearing", f"operating_point_stiffness_f_{axis}_d_{axis}", "N / m", "radial") for axis in "vw"),
    RexsRow("cylindrical_gear", "number_of_teeth", "none", "teeth", "gear.teeth", magnitude=True),
    RexsRow("cylindrical_gear", "normal_module", "mm", "module", "gear.module"),
    RexsRow("cylindrical_gear", HELIX, "deg", "helix_angle", "helix", magnitude=True),
    RexsRow("cylindrical_gear", "face_width", "mm", "face_width", "gear.face_width"),
    RexsRow("cylindrical_gear", "tip_diameter", "mm", "tip_diameter", "gear.tip_radius", 2, magnitude=True),
    RexsRow("cylindrical_gear", "root_diameter", "mm", "root_diameter", "gear.root_radius", 2, magnitude=True),
    RexsRow("cylindrical_gear", "transverse_module", "mm"),
    RexsRow("cylindrical_gear", "addendum_coefficient_basic_profile", "none", "addendum"),
    RexsRow("cylindrical_gear_flank", "normal_pressure_angle", "deg", "pressure_angle", "pressure_angle"),
    RexsRow("cylindrical_gear_flank", "addendum_modification_coefficient", "none", "profile_shift", "profile_shift"),
    RexsRow("cylindrical_gear_flank", "profile_shift_coefficient", "none", "profile_shift"),
    RexsRow("tip_relief", "tip_relief_depth", "mum", "amount", "amount"),
    RexsRow("tip_relief", "tip_relief_amount", "mum", "amount"),
    RexsRow("tip_relief", "tip_relief_datum_diameter", "mm"),
    RexsRow("tip_relief", "shape_of_relief", "none", "shape", "shape", form="word"),
    RexsRow("root_relief", "root_relief_depth", "mum", "amount"),
    RexsRow("root_relief", "root_relief_amount", "mum", "amount"),
    RexsRow("root_relief", "root_relief_datum_diameter", "mm"),
    *(
        RexsRow("helix_crowning", f"helix_crowning_amount_{end}_face", "mum", of="crown")
        for end in ("datum", "non_datum")
    ),
    RexsRow("helix_slope", "datum_face_orientation", form="word"),
    RexsRow("rack_shaped_tool", "addendum_coefficient_reference_profile", "none", "dedendum"),
    RexsRow("rack_shaped_tool", "tip_radius_factor", "none", "tip_rounding"),
    RexsRow("material", "density", "kg / dm^3", "density", default=7850.0),
    RexsRow("material", "elastic_modulus", "N / mm^2", "youngs_modulus", default=206e9),
    RexsRow("material", "poisson_ratio", "none", "poisson_ratio", default=0.3),
    RexsRow("cylindrical_stage", "center_distance", "mm", "centre_distance"),
    RexsRow("cylindrical_stage", "rotating_angle_around_neg_u_axis", "deg"),
    RexsRow("cylindrical_stage", "working_transverse_pressure_angle", "deg", of="pressure_angle"),
    RexsRow("cylindrical_stage", "transverse_contact_ratio", of="contact_ratio"),
    RexsRow("cylindrical_stage", "overlap_ratio", of="overlap_ratio"),
    RexsRow("cylindrical_stage", "common_face_width", "mm", of="width"),
    # of the stiffnesses the first that is given counts, the first of all is written
    RexsRow("cylindrical_stage", "mean_mesh_stiffness_for_transverse_load_iso_6336_2019", "N / (mm mum)", "stiffness"),
    RexsRow(
        "cylindrical_stage",
        "mesh_stiffness_for_load_distribution_along_face_width",
        "N / (mm mum)",
        "stiffness",
        note="a value for the load along the face: taken as the mean",
    ),
    *(RexsRow("cylindrical_stage", f"{end}_normal_backlash", "mm", of="backlash") for end in ("minimum", "maximum")),
    RexsRow("cylindrical_stage", "mesh_load_factor_iso_6336_2019"),
    RexsRow("cylindrical_stage", "dynamic_factor_iso_6336_2019"),
    RexsRow("cylindrical_stage", "face_load_factor_contact_stress_iso_6336_2019"),
    RexsRow("cylindrical_stage", "transverse_load_factor_contact_stress_iso_6336_2019"),
    RexsRow("cylindrical_stage_gear_data", "is_driving_gear"),
    RexsRow("cylindrical_stage_gear_data", "torque", "N m"),
    RexsRow("cylindrical_stage_gear_data", "number_of_load_cycles"),
)


def rows_of(kind: str, key: str = "") -> list[RexsRow]:
    """Rows of a type of components; those of one key of a model file where it is given."""
    return [row for row in _ROWS if row.type == kind and key in ("", row.key)]


ROW = {row.id: row for row in _ROWS}
"""Id of an attribute -> its row; an id is the same in every type."""
BEARINGS = (
    "concept_bearing",
    "rolling_bearing_with_catalog_geometry",
    "rolling_bearing_with_detailed_geometry",
    "slide_bearing",
    "hydrodynamic_radial_plain_bearing",
)
PLACE = [row.id for row in rows_of("place")]
ARRAYS, WORDS, REFERENCES = ([row.id for row in _ROWS if row.form == form] for form in ("array", "word", "component"))
# what the gears of a stage mostly share: it stands with the stage then
SHARED = ("module", "helix_angle", "face_width", "pressure_angle")
RELIEF_SHAPES = {"linear": "linear", "parabolic": "parabolic", "quadratic": "parabolic"}

RELATIONS = {
    "assembly": ("assembly", "part"),
    "reference": ("origin", "referenced"),
    **dict.fromkeys(
        ("planet_shaft", "planet_pin", "planet_carrier_shaft", "central_shaft"), ("planetary_stage", "shaft")
    ),
    "side": ("assembly", "inner_part", "outer_part"),
    "stage": ("stage", "gear_1", "gear_2"),
    "stage_gear_data": ("stage", "gear", "stage_gear_data"),
    "flank": ("gear", "left", "right"),
    "manufacturing_step": ("workpiece", "tool"),
}
"""Type of a relation -> roles of its parts, in the order in which they are written."""

_DROPPED = {
    ("lubricant",): "no lubricant in the model",
    ("material",): "strength and heat are not computed",
    ("shaft", "shaft_section"): "read as mass; shaft_sections of a member makes its shaft bend",
    ("side_plate",): "plates do not bend in the model",
    ("gear_casing",): "the casing is rigid",
    ("cylindrical_stage",): "load capacity, tolerances and results are not carried",
    ("cylindrical_gear", "ring_gear"): (
        "no place in the model: places follow from the centres and faces; no load capacity or results"
    ),
    ("coupling", "switchable_coupling"): "inside a member, or rigid",
    ("external_load",): "follows from the operation",
    ("stage_gear_data", "cylindrical_stage_gear_data"): "results of a mesh are not carried",
    ("flank_geometry", "cylindrical_gear_flank"): "allowances and chamfers are not carried",
    ("rack_shaped_tool", "cutter_wheel_tool"): "of tools, height and rounding of the tip are carried",
    ("cylindrical_gear_manufacturing_settings",): "allowances are not carried",
    ("profile_crowning",): "the model has tip and root relief, no profile crowning",
    ("helix_slope",): "its sense against the loaded flank is not known",
    ("rolling_element",): "bearings are springs in the model",
}


def reason_dropped(kind: str) -> str:
    """Why the attributes of a type of components that are not asked for are dropped."""
    if "bearing" in kind:
        return "clearance, size, misalignment and results of bearings are not carried"
    return next((reason for kinds, reason in _DROPPED.items() if kind in kinds), "no place in the model file")


def values_of(kind: str, part: object, given: Mapping[str, Value] | None = None) -> dict[str, Value]:
    """Values of a component in SI by id, in the order of its rows: those given, and what a part of a train has."""
    values = {}
    for row in rows_of(kind):
        if given and row.id in given:
            values[row.id] = given[row.id]
        elif row.of:
            value = attrgetter(row.of)(part)
            if isinstance(value, str):
                values[row.id] = value
            elif value is not None and math.isfinite(value):
                values[row.id] = row.times * value
    return values
