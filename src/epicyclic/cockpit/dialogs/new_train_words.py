"""What is typed into the wizard of a new train, as keywords of `new_train` and as values beside them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...document.tables import PlainTable
from ...document.writer import commented_text
from ...errors import ModelError
from ...train.new_train import new_train
from ...train.resolution import load
from ...train.wishes import HELD, MEMBERS

__all__ = ["BESIDE", "UNITS", "Preview", "drivers_of", "needed", "preview_of", "sets_in"]

UNITS: Mapping[str, str] = {
    "module": "mm",
    "face_width": "mm",
    "helix_angle": "deg",
    "pressure_angle": "deg",
    "speed": "rpm",
    "torque": "N m",
    "power": "kW",
    "stages.main.carrier.mass": "kg",
    "stages.main.carrier.inertia": "kg m^2",
    "stages.main.planet.bearing.radial": "N/m",
    "stages.main.sun.support.radial": "N/m",
    "stages.main.ring.support.radial": "N/m",
    "stages.main.carrier.support.radial": "N/m",
}
"""Field -> unit of a bare number typed there; a text with its unit is taken as it is."""

BESIDE: Mapping[str, str] = {
    "damping.modal": "Damping ratio of every mode",
    "stages.main.planet.bearing.radial": "Planet bearing, radial",
    "stages.main.sun.support.radial": "Sun support, radial (0 floats, inf is rigid)",
    "stages.main.ring.support.radial": "Ring support, radial",
    "stages.main.carrier.support.radial": "Carrier bearing, radial",
    "stages.main.carrier.mass": "Carrier mass, without planets",
    "stages.main.carrier.inertia": "Carrier inertia",
}
"""Path -> label of what a running model needs beside teeth and load; empty, it follows a rule."""

# one decimal comma; of three digits behind it nobody knows whether they are thousands
_COMMA = re.compile(r"^([+-]?\d+),(\d{1,2}|\d{4,})(?!\d)")
_BARE = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_SET = re.compile(r"\b\d{2,4}/\d{2,4}/\d{2,4}\b")


@dataclass(frozen=True, slots=True, kw_only=True)
class Preview:
    """What comes out of the fields as they stand.

    text : the model file.  title : of the model.  facts : what follows from the fields, in words.
    by_rule : path of `BESIDE` and size of the gears -> value that a rule has chosen.
    """

    text: str
    title: str
    facts: tuple[str, ...]
    by_rule: Mapping[str, str]


def drivers_of(kind: str, held: str) -> tuple[str, ...]:
    """Members that may drive; none of a differential, whose speeds are stated by member."""
    if kind == "differential":
        return ()
    fixed = (
        held if held in HELD.get("planetary", ()) and kind == "planetary" else "carrier" if kind == "star" else "ring"
    )
    return tuple(member for member in MEMBERS if member != fixed)


def needed(fields: Mapping[str, Any]) -> tuple[str, ...]:
    """Fields that nothing stands in for, and that are empty."""
    names = [str(fields.get("by", "teeth")), str(fields.get("load", "power"))]
    if fields.get("kind") == "differential":
        speeds = sum(bool(_typed(fields, f"speed.{member}")) for member in MEMBERS)
        names[0] = "teeth"
        return (*(name for name in names if not _typed(fields, name)), *(("speed",) if speeds < 2 else ()))
    return tuple(name for name in (*names, "speed") if not _typed(fields, name))


def preview_of(fields: Mapping[str, Any]) -> Preview:
    """The model of the fields, and what a person should know of it.

    Parameters
    ----------
    fields : keyword of `new_train`, path of `BESIDE`, ``speed.MEMBER`` and ``load_member`` of a differential -> text.
        ``by``: teeth or ratio; ``load``: power or torque.

    Raises
    ------
    ModelError : path is the field; what was given and what is allowed.
    """
    train = new_train(**_keywords(fields))
    beside = {path: _with_unit(path, text) for path in BESIDE if (text := _typed(fields, path))}
    document = _with_values(train.document, beside)
    try:
        model = load(document)
    except ModelError as error:
        raise error.at(next((path for path in beside if error.path.startswith(path)), error.path)) from None
    stage = document["stages"]["main"]
    facts = [train.comments["stages.main"], *_gears(train.comments), *train.remarks]
    operation = [text for path, text in train.comments.items() if path.startswith("operation.")]
    facts[1:1] = [f"module {stage['module']}, face width {stage['face_width']}"]
    head = ("Made by the wizard of a new train. Values under [assumed] are chosen, not given.", *train.remarks)
    return Preview(
        text=commented_text(document, head=head, comments=train.comments),
        title=model.title,
        facts=tuple(_sentence(fact) for fact in (*facts, *operation)),
        by_rule=_by_rule(train.document),
    )


def sets_in(text: str) -> tuple[str, ...]:
    """Tooth counts that a message or a remark proposes."""
    return tuple(dict.fromkeys(_SET.findall(text)))


def _typed(fields: Mapping[str, Any], name: str) -> str:
    return str(fields.get(name) or "").strip()


def _pointed(text: str) -> str:
    """A quantity with its decimal comma as a point."""
    return _COMMA.sub(r"\1.\2", text)


def _with_unit(name: str, text: str) -> str | float:
    """A text as the model file has it: a bare number with the unit of its field, a ratio as a number."""
    unit, text = UNITS.get(name), _pointed(text)
    if not _BARE.fullmatch(text):
        return text
    if unit is None:
        return float(text)
    return text if unit == "N/m" and float(text) == 0 else f"{text} {unit}"


def _number(name: str, text: str) -> float:
    try:
        return float(_pointed(text))
    except ValueError:
        raise ModelError("not a number", path=name, given=text, allowed="a number, 5.7") from None


def _keywords(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords of `new_train`. Raises ModelError."""
    kind = str(fields.get("kind", "planetary"))
    said: dict[str, Any] = {"kind": kind}
    if kind != "differential" and fields.get("by") == "ratio":
        if text := _typed(fields, "ratio"):
            said["ratio"] = _number("ratio", text)
    elif text := _typed(fields, "teeth"):
        said["teeth"] = text
    if text := _typed(fields, "planets"):
        said["planets"] = int(text) if text.isdecimal() else text
    for name in ("module", "face_width", "helix_angle", "pressure_angle"):
        if text := _typed(fields, name):
            said[name] = _with_unit(name, text)
    if text := _typed(fields, "title"):
        said["title"] = text
    load_ = "torque" if fields.get("load") == "torque" else "power"
    text = _typed(fields, load_)
    if kind == "differential":
        speeds = {m: _with_unit("speed", one) for m in MEMBERS if (one := _typed(fields, f"speed.{m}"))}
        if speeds:
            said["speed"] = speeds
        if text:
            said[load_] = {str(fields.get("load_member") or "sun"): _with_unit(load_, text)}
        return said
    if text:
        said[load_] = _with_unit(load_, text)
    if text := _typed(fields, "speed"):
        said["speed"] = _with_unit("speed", text)
    held = _typed(fields, "held")
    if kind == "planetary" and held:
        said["held"] = held
    driver = _typed(fields, "driver")
    if driver in drivers_of(kind, held):
        said["driver"] = driver
    return said


def _with_values(document: Mapping[str, Any], values: Mapping[str, object]) -> PlainTable:
    """The document with values put in, and without the reasons of those they replace."""
    changed: PlainTable = {**document, "assumed": {k: v for k, v in document["assumed"].items() if k not in values}}
    for path, value in values.items():
        *above, last = path.split(".")
        table = changed
        for key in above:
            table[key] = dict(table[key])
            table = table[key]
        table[last] = value
    return changed


def _by_rule(document: Mapping[str, Any]) -> dict[str, str]:
    found = {}
    for path in BESIDE:
        value: Any = document
        for key in path.split("."):
            value = value.get(key, {})
        if value != {}:
            found[path] = str(value)
    stage = document["stages"]["main"]
    return found | {"module": str(stage["module"]), "face_width": str(stage["face_width"])}


def _gears(comments: Mapping[str, str]) -> Sequence[str]:
    names = ("sun", "planet", "ring")
    return [f"{name}: {text}" for name in names if (text := comments.get(f"stages.main.{name}"))]


def _sentence(text: str) -> str:
    return text if text[1:2] in ("_", "") else text[0].upper() + text[1:]
