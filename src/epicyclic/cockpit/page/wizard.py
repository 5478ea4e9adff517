"""A new train without a model file: one page of fields, what comes out of them, and a model that runs."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from nicegui import ui

from ...document.tables import merge, value_at
from ...document.writer import commented_text
from ...errors import ModelError
from ...options import option_fields
from ...train import NewTrainOptions
from ...train.layouts import tables_of
from ...train.new_train import HELD, KINDS, MEMBERS, new_train
from ...train.resolution import load
from ..processes.session import Session
from ..state.state import from_text
from .controls import Later, plain_button, refused, safe_name, sentence, show_model, window


class _Field(NamedTuple):
    """A field: unit of a bare number, None of words; what stands in it while it is empty; what it begins with."""

    label: str
    unit: str | None = None
    example: str = ""
    first: str = ""


# a text with its unit is taken as it is
_FIELDS: Mapping[str, _Field] = {
    "kind": _Field("Kind", first="planetary"),
    "planets": _Field("Planets", first="3"),
    "by": _Field("Gears", first="teeth"),
    "teeth": _Field("Teeth sun/planet/ring", example="e.g. 21/39/99"),
    "ratio": _Field("Ratio, input to output", "", "e.g. 5.7"),
    "module": _Field("Normal module", "mm", "by load"),
    "helix_angle": _Field("Helix angle", "deg", "0 deg"),
    "face_width": _Field("Face width", "mm", "by load"),
    "pressure_angle": _Field("Normal pressure angle", "deg", "20 deg"),
    "held": _Field("Held member"),
    "driver": _Field("Driving member"),
    "speed": _Field("Speed", "rpm", "e.g. 1000 rpm"),
    **{f"speed.{member}": _Field(f"Speed of the {member}", "rpm") for member in MEMBERS},
    "load": _Field("Load", first="power"),
    "power": _Field("Power", "kW", "e.g. 750 kW"),
    "torque": _Field("Torque", "N m", "e.g. 7.2 kN m"),
    "load_member": _Field("Load of the", first="sun"),
    "title": _Field("Title"),
    "damping.modal": _Field("Damping ratio of every mode", ""),
    "stages.main.planet.bearing.radial": _Field("Planet bearing, radial", "N/m"),
    "stages.main.sun.support.radial": _Field("Sun support, radial (0 floats, inf is rigid)", "N/m"),
    "stages.main.ring.support.radial": _Field("Ring support, radial", "N/m"),
    "stages.main.carrier.support.radial": _Field("Carrier bearing, radial", "N/m"),
    "stages.main.carrier.mass": _Field("Carrier mass, without planets", "kg"),
    "stages.main.carrier.inertia": _Field("Carrier inertia", "kg m^2"),
}
BESIDE = tuple(path for path in _FIELDS if path.startswith(("damping.", "stages.")))
"""Paths of what a running model needs beside teeth and load; empty, it follows a rule."""

# one decimal comma; of three digits behind it nobody knows whether they are thousands
_COMMA = re.compile(r"^([+-]?\d+),(\d{1,2}|\d{4,})(?!\d)")
_BARE = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_SET = re.compile(r"\b\d{2,4}/\d{2,4}/\d{2,4}\b")


class Preview(NamedTuple):
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
    sides = HELD.get(kind, ())
    fixed = held if held in sides else next(iter(sides), "")
    return tuple(member for member in MEMBERS if member != fixed) if sides else ()


def shown(fields: Mapping[str, Any]) -> dict[str, bool]:
    """Whether each of the fields that depend on others is shown; what stands in one that is not does not count."""
    several, by_ratio, torque = (
        fields.get(name) == word for name, word in (("kind", "differential"), ("by", "ratio"), ("load", "torque"))
    )
    return {
        "held": fields.get("kind", "planetary") == "planetary",
        "teeth": several or not by_ratio,
        "ratio": not several and by_ratio,
        "power": not torque,
        "torque": torque,
        "load_member": several,
        **dict.fromkeys(("driver", "by", "speed"), not several),
        **{f"speed.{member}": several for member in MEMBERS},
    }


def needed(fields: Mapping[str, Any]) -> tuple[str, ...]:
    """Fields that nothing stands in for, and that are empty."""
    visible = shown(fields)
    names = ("teeth", "ratio", "power", "torque", "speed")
    empty = [name for name in names if visible[name] and not _typed(fields, name)]
    few = not visible["speed"] and sum(bool(_typed(fields, f"speed.{member}")) for member in MEMBERS) < 2
    return (*empty, *["speed"] * few)


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
    assumed = {path: why for path, why in train.document["assumed"].items() if path not in beside}
    document = merge({**train.document, "assumed": assumed}, tables_of(beside))
    try:
        model = load(document)
    except ModelError as error:
        raise error.at(next((path for path in beside if error.path.startswith(path)), error.path)) from None
    stage, comments = document["stages"]["main"], train.comments
    facts = [comments["stages.main"], f"module {stage['module']}, face width {stage['face_width']}"]
    for gear in ("sun", "planet", "ring"):
        if teeth := comments.get(f"stages.main.{gear}"):
            facts.append(f"{gear}: {teeth}")
    facts += [*train.remarks, *(text for path, text in comments.items() if path.startswith("operation."))]
    rules = {path: value_at(train.document, path.split(".")) for path in BESIDE}
    by_rule = {path: str(value) for path, value in rules.items() if value is not None}
    head = ("Made by the wizard of a new train. Values under [assumed] are chosen, not given.", *train.remarks)
    return Preview(
        text=commented_text(document, head=head, comments=comments),
        title=model.title,
        # a symbol, as z_1, stays small
        facts=tuple(fact if fact[1:2] in ("_", "") else fact[0].upper() + fact[1:] for fact in facts),
        by_rule=by_rule | {key: str(train.document["stages"]["main"][key]) for key in ("module", "face_width")},
    )


def sets_in(text: str) -> tuple[str, ...]:
    """Tooth counts that a message or a remark proposes."""
    return tuple(dict.fromkeys(_SET.findall(text)))


def _typed(fields: Mapping[str, Any], name: str) -> str:
    return str(fields.get(name) or "").strip()


def _with_unit(name: str, text: str) -> str | float:
    """A text as the model file has it: a bare number with the unit of its field, a ratio as a number."""
    unit = _FIELDS[name].unit
    if unit is None:
        return text
    text = _COMMA.sub(r"\1.\2", text)
    if not _BARE.fullmatch(text):
        return text
    if not unit:
        return float(text)
    return text if unit == "N/m" and float(text) == 0 else f"{text} {unit}"


def _keywords(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords of `new_train`, of the fields that are shown."""
    visible, known = shown(fields), option_fields(NewTrainOptions)
    keywords: dict[str, Any] = {
        name: _with_unit(name, text)
        for name in _FIELDS
        if name in known and visible.get(name, True) and (text := _typed(fields, name))
    }
    if keywords.get("driver") not in drivers_of(keywords.get("kind", "planetary"), _typed(fields, "held")):
        keywords.pop("driver", None)
    if visible["load_member"]:  # a differential names its members
        member = str(fields.get("load_member") or "sun")
        keywords |= {name: {member: keywords[name]} for name in ("power", "torque") if name in keywords}
        speeds = {m: _with_unit("speed", text) for m in MEMBERS if (text := _typed(fields, f"speed.{m}"))}
        keywords |= {"speed": speeds} if speeds else {}
    return keywords


# [s] after the last key until what comes out is worked out anew
_PAUSE = 0.25


def new_button(session: Session) -> Callable[[], None]:
    """A button that opens the wizard, and what opens it from another place of the page.

    What was typed stays there until a train is made of it.
    """
    wizard = _Wizard(session)
    plain_button("New", wizard.open, icon="add").props('aria-label="New train"')
    return wizard.open


class _Wizard:
    """The window; it is built when it is first opened, and keeps what was typed."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.slot = ui.element("div").classes("hidden")
        self.window: ui.dialog | None = None
        self.fields: dict[str, Any] = {}
        self.later = Later(self.slot, self._show)
        self.insists = False  # create was pressed: what is missing is an error now
        self.ready: Preview | None = None

    def open(self) -> None:
        if self.window is None:
            with self.slot:
                self._build()
        assert self.window is not None
        self.window.open()

    # fields -----------------------------------------------------------------------------------------------------------

    def _build(self) -> None:
        with window("New train", width=1000, stays=True) as self.window:
            with ui.row().classes("w-full no-wrap items-start q-col-gutter-md"):
                with ui.column().classes("q-gutter-none").style("flex: 3; min-width: 0"):
                    with ui.row().classes("w-full items-start"):
                        self._choice("kind", {kind: kind for kind in KINDS})
                        self._text("planets")
                        self._choice("held", {})
                        self._choice("driver", {})
                    with ui.row().classes("w-full items-start"):
                        self._choice("by", {"teeth": "by their teeth", "ratio": "from a ratio"})
                        self._text("teeth")
                        self._text("ratio")
                    self.proposals = ui.row().classes("w-full items-center q-gutter-xs")
                    with ui.row().classes("w-full items-start"):
                        for name in ("module", "face_width", "helix_angle", "pressure_angle"):
                            self._text(name)
                    with ui.row().classes("w-full items-start"):
                        self._text("speed")
                        for member in MEMBERS:
                            self._text(f"speed.{member}")
                        self._choice("load", {"power": "power", "torque": "torque"})
                        self._choice("load_member", {member: member for member in MEMBERS})
                        self._text("power")
                        self._text("torque")
                    self._text("title").classes("w-full").style("flex: none")
                    words = "Damping, bearings, carrier: by rules unless said here"
                    with ui.expansion(words).classes("w-full").props("dense"), ui.grid(columns=2).classes("w-full"):
                        for path in BESIDE:
                            self._text(path)
                with ui.column().classes("q-gutter-none").style("flex: 2; min-width: 280px"):
                    ui.label("What comes out").classes("text-subtitle2")
                    self.facts = ui.column().classes("w-full q-gutter-xs").props('aria-live="polite"')
                    self.message = ui.label("").classes("text-negative").props('role="alert"')
                    ui.label("A preselection to begin with: no strength rating.").classes("text-caption")
            with ui.row().classes("w-full justify-end items-center"):
                self.status = ui.label("").classes("col text-caption").props('role="status" aria-live="polite"')
                plain_button("Start over", self._clear)
                self.create = plain_button("Create", self._create, main=True)
        self._rearrange()

    def _text(self, name: str) -> ui.input:
        label, unit, example, first = _FIELDS[name]
        field = ui.input(f"{label} [{unit}]" if unit else label, value=first, placeholder=example, on_change=self._ask)
        field.props("dense stack-label hide-bottom-space autocomplete=off spellcheck=false").mark(f"new-{name}")
        field.style("flex: 1 1 7rem; min-width: 7rem")
        field.on("keydown.enter", self._create)
        self.fields[name] = field
        return field

    def _choice(self, name: str, options: dict[str, str]) -> None:
        label, _, _, first = _FIELDS[name]
        field = ui.select(options, value=first or None, label=label, on_change=self._rearrange)
        field.props("dense options-dense stack-label hide-bottom-space").style("min-width: 8rem").mark(f"new-{name}")
        self.fields[name] = field

    def _values(self) -> dict[str, Any]:
        """What stands in the fields."""
        return {name: field.value for name, field in self.fields.items()}

    def _rearrange(self) -> None:
        """Show the fields that the kind and the choices ask for; those hidden keep what was typed."""
        if not self.fields.keys() >= _FIELDS.keys():  # while they are built
            return
        values = self._values()
        kind = str(values["kind"])
        visible = shown(values)
        self._offer("held", HELD[kind] if visible["held"] else ())
        self._offer("driver", drivers_of(kind, str(values["held"] or "")))
        for name, is_shown in visible.items():
            self.fields[name].set_visibility(is_shown)
        member = values["load_member"] if visible["load_member"] else self.fields["driver"].value
        for name in ("speed", "power", "torque"):
            self.fields[name].props["label"] = f"{_FIELDS[name].label} of the {member} [{_FIELDS[name].unit}]"
        self._ask()

    def _offer(self, name: str, members: tuple[str, ...]) -> None:
        """Options of a choice of members; what was chosen stays where it may."""
        field = self.fields[name]
        if list(field.options) != list(members):
            chosen = field.value if field.value in members else next(iter(members), None)
            field.set_options(dict(zip(members, members, strict=True)), value=chosen)

    # what comes out ---------------------------------------------------------------------------------------------------

    def _ask(self) -> None:
        """Work out what comes out, a moment after the last key."""
        self.ready = None
        self.later.ask(_PAUSE)

    async def _show(self) -> None:
        """Show what comes out of the fields; it is ready where a train does."""
        fields = self._values()
        missing = needed(fields)
        if missing and not self.insists:
            self._mark(None)
            self.status.set_text(f"Still needed: {', '.join(missing)}")
            return
        preview: Preview | ModelError
        try:
            preview = await asyncio.to_thread(preview_of, fields)
        except ModelError as error:
            preview = error
        if self.slot.is_deleted or self._values() != fields:
            return
        if isinstance(preview, ModelError):
            self._mark(preview)
            self.status.set_text("")
            return
        self._mark(None)
        self.ready = preview
        self.status.set_text("Ready: a model that runs")
        self.facts.clear()
        with self.facts:
            for fact in preview.facts:
                ui.label(fact)
        self._propose(sets_in(" ".join(preview.facts)))
        for name, value in preview.by_rule.items():
            self.fields[name].props["placeholder"] = value
            self.fields[name].update()

    def _mark(self, error: ModelError | None) -> None:
        """Put the message beside the field that it is of, and take it from all others."""
        field_of_error = None if error is None else self._field_of(error.path)
        for name, field in self.fields.items():
            if isinstance(field, ui.input):
                of_field = error is not None and name == field_of_error
                field.error = sentence(error.problem, error.allowed) if error is not None and of_field else None
        self.facts.style("opacity: 0.4" if error is not None else "opacity: 1")  # of the fields as they were
        marked = self.fields.get(field_of_error or "")
        beside = isinstance(marked, ui.input) and marked.visible
        self.message.set_text("" if error is None or beside else str(error))
        if error is not None:
            self._propose(sets_in(error.allowed))

    def _field_of(self, path: str) -> str | None:
        """The field of a path: its own, that of its key, or that of the table that the path is in."""
        name = next((name for name in (path, path.rpartition(".")[2]) if name in self.fields), path)
        if name == "speed" and self.fields["kind"].value == "differential":
            return "speed.sun"
        if name in self.fields:
            return name
        table = name.rpartition(".")[0]
        return next((path for path in BESIDE if table and path.rpartition(".")[0] == table), None)

    def _propose(self, sets: tuple[str, ...]) -> None:
        """Buttons that take other tooth counts."""
        typed = str(self.fields["teeth"].value or "").strip()
        self.proposals.clear()
        with self.proposals:
            for teeth in sets:
                if teeth == typed:
                    continue

                def take(teeth: str = teeth) -> None:
                    self.fields["by"].set_value("teeth")
                    self.fields["teeth"].set_value(teeth)

                plain_button(teeth, take).tooltip("Take these teeth")

    # end --------------------------------------------------------------------------------------------------------------

    async def _create(self) -> None:
        """Open the model of the fields; the window stays, with all that was typed, where there is none."""
        self.insists = True
        self.ready = None
        self.later.drop()
        self.create.props("loading")
        try:
            await self._show()
            if self.ready is None:
                return
            state = from_text(safe_name(self.ready.title, ".toml"), self.ready.text)
        except ModelError as error:
            return refused(error)
        finally:
            self.create.props(remove="loading")
        assert self.window is not None
        self.window.close()
        show_model(self.session, state, self.slot, unsaved=True)
        ui.notify(
            "A new train. What its drawing does not say yet is assumed; save keeps it.",
            timeout=5000,
            position="bottom-left",
        )

    def _clear(self) -> None:
        """Empty fields again."""
        self.insists = False
        for name, field in self.fields.items():
            if name not in ("held", "driver"):
                field.set_value(_FIELDS[name].first)
        self.facts.clear()
        self.proposals.clear()
