"""What `compare.py` runs: every verb with reduced options, over ready drives, model files of tests, and own drives."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

__all__ = ["CASES", "DRIVES", "EXACT", "ITERATED", "Case", "Drive", "Task", "drives_of", "tasks_of"]

DRIVES = Path(__file__).parent / "drives"
EXACT, ITERATED = 1e-9, 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One way to call a verb.

    name : of the row of the table.  verb : of the package, or ``system`` for the assembled matrices.
    options : keywords, in the spelling of both checkouts, the old one where they differ.  A text that is ``{path}``,
        ``{values}``, ``{body}``, ``{torque}`` and no more stands for what the drive has of it, or a file beside it.
    tolerance : relative, of differences.  speed : the keyword that takes the relative speed of drives that are looked
        at away from the nominal one, empty if none.
    only : beginnings of the names of the drives, all where empty.  without : drives left out, which take too long.
    """

    name: str
    verb: str
    options: Mapping[str, Any] = field(default_factory=dict)
    tolerance: float = EXACT
    speed: str = ""
    only: tuple[str, ...] = ()
    without: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A model file: its name in the table, what `load` is given, its text, and places in it that options name.

    relative_speed : where it is looked at, per operating speed [1].
    """

    name: str
    source: str
    text: str
    paths: tuple[str, ...]
    body: str
    values: tuple[str, ...]
    relative_speed: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """One case of one drive."""

    case: str
    verb: str
    drive: str
    source: str
    text: str
    options: dict[str, Any]
    tolerance: float

    @property
    def name(self) -> str:
        return f"{self.case} | {self.drive}"


_SHORT = {"cycles": 2, "samples": 8}
_SPEEDS = [0.25 * point for point in range(9)]
_RELIEF = {"population": 6, "generations": 2, "samples": 8, "slices": 4}
_TIP = {"tip_relief.amount": "0..20 um", "tip_relief.length": "0.2..0.8 mm"}
_SHAPE = {"tip_relief.amount": "5..20 um", "tip_relief.length": "0.5 mm", "tip_relief.shape": ["linear", "parabolic"]}
_OWN = ("own/",)
_TWICE = ("good/encased-differential",)  # a ready drive too
_COUPLED = ("ready/encased-differential", "good/encased-differential", "own/dampers")
_LAWS = ("clearance", "exponent", "friction", 'stiffness = "contact"')  # followed by iteration in statics
_MOVING = ("own/", "ren2021", "dong2019")

CASES: tuple[Case, ...] = (
    Case(name="system", verb="system"),
    Case(name="check", verb="check"),
    Case(name="stiffness", verb="stiffness", options={"samples": 32}),
    Case(
        name="contact of a mesh",
        verb="contact",
        options={"mesh": "first", "loads": [0.5, 1.0], "samples": 8, "slices": 5},
    ),
    Case(
        name="contact corner and misalignment",
        verb="contact",
        options={
            "mesh": "first",
            "loads": [0.4, 1.2],
            "samples": 8,
            "slices": 4,
            "corner": True,
            "misalignment": "0.05 mrad",
            "torque_end_a": "left",
            "torque_end_b": "right",
        },
    ),
    Case(
        name="contact of the train",
        verb="contact",
        options={"loads": [0.5, 1.0], "samples": 3, "slices": 3},
        tolerance=ITERATED,
    ),
    Case(
        name="relief",
        verb="relief",
        options={**_RELIEF, "vary": _TIP, "loads": [1.0]},
        tolerance=ITERATED,
    ),
    Case(
        name="relief Pareto set",
        verb="relief",
        options={**_RELIEF, "vary": _SHAPE, "objectives": ["lte", "load", "force_rms"], "points": 4},
        tolerance=ITERATED,
        only=("own/", "ren2021"),
    ),
    Case(name="modes", verb="modes"),
    Case(name="modes damped", verb="modes", options={"damped": True}),
    Case(name="modes at speed", verb="modes", options={"relative_speed": 0.7}),
    Case(name="modes at speed damped", verb="modes", options={"relative_speed": 0.7, "damped": True}),
    Case(name="campbell", verb="campbell", options={"relative_speeds": _SPEEDS}),
    Case(name="campbell damped", verb="campbell", options={"relative_speeds": _SPEEDS, "damped": True}),
    Case(name="static", verb="static", options=_SHORT),
    Case(
        name="static turns",
        verb="static",
        options={"turns": 1, "of": "{body}", "samples": 12},
    ),
    Case(name="steady", verb="steady", options={"samples": 16}, speed="relative_speed"),
    Case(
        name="steady superposition",
        verb="steady",
        options={"samples": 16, "method": "superposition"},
        speed="relative_speed",
    ),
    Case(
        name="steady contact_loss",
        verb="steady",
        options={"contact_loss": True},
        tolerance=ITERATED,
        speed="relative_speed",
        without=_TWICE,
    ),
    Case(name="sharing", verb="sharing", options={"cycles": 3, "stored_cycles": 2}, speed="relative_speed"),
    Case(
        name="sharing superposition",
        verb="sharing",
        options={"cycles": 3, "method": "superposition"},
        speed="relative_speed",
    ),
    Case(name="sharing static", verb="sharing", options={**_SHORT, "method": "static"}),
    Case(name="sweep", verb="sweep", options={"points": 12}),
    Case(name="sweep between ends", verb="sweep", options={"start": "40 %", "stop": "130 %", "points": 6}),
    Case(
        name="sweep frame at operating speed",
        verb="sweep",
        options={
            "relative_speed": [0.3, 0.6, 0.8, 1.1],
            "frame_speed": "operating",
            "shaft_orders": False,
            "orders": 5,
        },
    ),
    Case(
        name="sweep contact_loss",
        verb="sweep",
        options={"start": "40 %", "stop": "130 %", "points": 5, "contact_loss": True, "unstable": "report"},
        tolerance=ITERATED,
        without=_COUPLED,
    ),
    Case(
        name="sweep contact_loss coupled stages",
        verb="sweep",
        options={
            "relative_speed": [0.7, 0.75],
            "contact_loss": True,
            "unstable": "ignore",
            "harmonics": 8,
            "shaft_orders": False,
        },
        tolerance=ITERATED,
        only=("ready/encased-differential", "own/dampers"),
    ),
    Case(
        name="sweep contact_loss replace",
        verb="sweep",
        options={"start": "60 %", "stop": "110 %", "points": 4, "contact_loss": True, "shaft_orders": False},
        tolerance=ITERATED,
        only=_OWN,
        without=_COUPLED,
    ),
    Case(name="sensitivity", verb="sensitivity", without=(*_TWICE, "own/teeth")),
    Case(
        name="sensitivity at speed",
        verb="sensitivity",
        options={"relative_speed": 0.8, "paths": "{paths}", "mode": 3},
    ),
    Case(
        name="sensitivity force",
        verb="sensitivity",
        options={"of": "force"},
        speed="relative_speed",
        without=(*_COUPLED, "own/teeth"),
    ),
    Case(
        name="sensitivity harmonic",
        verb="sensitivity",
        options={"of": "force", "harmonic": 1, "paths": "{paths}"},
        speed="relative_speed",
    ),
    Case(name="track", verb="track", options={"over": "{path}", "points": 5}),
    Case(name="modulation", verb="modulation", speed="relative_speed"),
    Case(
        name="modulation mean load",
        verb="modulation",
        options={
            "sensor": "30 deg",
            "window": "cos4",
            "mean_load": True,
            "through_planet": 0.2,
            "direction": "tangential",
        },
        speed="relative_speed",
    ),
    Case(
        name="modulation through a path",
        verb="modulation",
        options={"window": "{window}", "transfer": "{transfer}", "floor": 0.0},
        only=("own/backlash", "own/slices"),
    ),
    Case(
        name="modulation beside the housing",
        verb="modulation",
        options={"body": "housing", "radius": "200 mm", "window": "gaussian", "width": "40 deg"},
        only=("dong2019", "ready/encased-differential"),
    ),
    Case(name="stability", verb="stability", options={"points": 8}),
    Case(
        name="stability factors",
        verb="stability",
        options={
            "start": "50 %",
            "stop": "150 %",
            "points": 5,
            "variation": 1.5,
            "damping": 0.2,
            "frame_speed": "operating",
        },
    ),
    Case(
        name="stability map",
        verb="stability",
        options={"start": "50 %", "stop": "150 %", "points": 4, "over": "{path}", "values": "{values}"},
    ),
    Case(
        name="stability map of damping",
        verb="stability",
        options={"start": "50 %", "stop": "150 %", "points": 4, "over": "damping", "values": [0.1, 1.0]},
    ),
    Case(
        name="transient",
        verb="transient",
        options={"cycles": 3.0, "samples": 16},
        tolerance=ITERATED,
    ),
    Case(
        name="transient dop853",
        verb="transient",
        options={"cycles": 1.0, "samples": 16, "method": "dop853"},
        tolerance=ITERATED,
        only=_MOVING,
    ),
    Case(
        name="transient linear from rest",
        verb="transient",
        options={"cycles": 2.0, "samples": 16, "contact": "linear", "initial": "rest", "torque_step": (1.3, 2e-4)},
        tolerance=ITERATED,
    ),
    Case(
        name="transient ramps",
        verb="transient",
        options={
            "duration": 0.004,
            "samples": 16,
            "mesh_frequency": (300.0, 700.0),
            "torque_ramp": 0.002,
            "decimate": 2,
        },
        tolerance=ITERATED,
    ),
    Case(
        name="transient history",
        verb="transient",
        options={"torque": "{torque}", "samples": 16},
        tolerance=ITERATED,
        only=("own/backlash", "own/slices", "own/teeth"),
    ),
    Case(name="vary", verb="vary", options={"path_values": {"{path}": "{values}"}}),
    Case(name="audit", verb="audit", tolerance=ITERATED, only=("ready/",)),
)


CASES += (
    Case(  # a verb without a case of its own is run by the examples of its record
        name="examples of further verbs",
        verb="examples",
        options={"listed": sorted({case.verb for case in CASES})},
        tolerance=ITERATED,
        only=("ready/ren2021",),
    ),
)


def drives_of(old: Path) -> list[Drive]:
    """Ready drives and model files of the tests, both as the old checkout has them, and the own drives."""
    ready = {path for path in (old / "src").rglob("systems/*.toml") if not path.name.endswith(".audit.toml")}
    found = [_drive(path, f"ready/{path.stem}", path.stem) for path in sorted(ready)]
    for folder, kind in ((old / "tests" / "files" / "good", "good"), (DRIVES, "own")):
        found += [_drive(path, f"{kind}/{path.stem}", str(path.resolve())) for path in sorted(folder.glob("*.toml"))]
    return found


def tasks_of(drives: list[Drive], *, verbs: list[str] | None = None) -> list[Task]:
    """Every case of every drive; `verbs` : names of verbs or of cases, all where None."""
    cases = [case for case in CASES if verbs is None or case.verb in verbs or case.name in verbs]
    return [_task(case, drive) for drive in drives for case in cases if _wanted(case, drive)]


def _wanted(case: Case, drive: Drive) -> bool:
    short = drive.name.removeprefix("ready/")
    only = not case.only or drive.name.startswith(case.only) or short.startswith(case.only)
    return only and drive.name not in case.without


def _task(case: Case, drive: Drive) -> Task:
    options = _filled(dict(case.options), drive)
    if case.speed and drive.relative_speed != 1.0:
        options[case.speed] = drive.relative_speed
    followed = case.verb == "static" or case.options.get("method") == "static"
    laws = any(word in drive.text for word in _LAWS)
    return Task(
        case=case.name,
        verb=case.verb,
        drive=drive.name,
        source=drive.source,
        text=drive.text,
        options=options,
        tolerance=ITERATED if followed and laws else case.tolerance,
    )


def _filled(value: Any, drive: Drive) -> Any:
    """Options with the places of the drive put in."""
    places: dict[str, Any] = {
        "{path}": drive.paths[0],
        "{paths}": list(drive.paths),
        "{values}": list(drive.values),
        "{body}": drive.body,
        **{f"{{{name}}}": str(DRIVES / f"{name}.csv") for name in ("torque", "window", "transfer")},
    }
    if isinstance(value, str):
        return places.get(value, value)
    if isinstance(value, Mapping):
        return {_filled(key, drive): _filled(entry, drive) for key, entry in value.items()}
    return [_filled(entry, drive) for entry in value] if isinstance(value, list) else value


def _drive(path: Path, name: str, source: str) -> Drive:
    text = path.read_text(encoding="utf-8")
    document = tomllib.loads(text)
    numbers = list(_numbers(document)) or [("stages.main.sun.mass", "1 kg")]
    number, _, unit = numbers[0][1].partition(" ")
    return Drive(
        name=name,
        source=source,
        text=text,
        paths=tuple(path for path, _ in numbers[:6]),
        body=_body(document),
        values=tuple(f"{float(number) * factor:.12g} {unit}" for factor in (0.8, 1.3)),
        relative_speed=0.6 if name == "own/dampers" else 1.0,
    )


def _numbers(document: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Numbers with a unit that move natural frequencies, the telling ones first."""
    stages = document.get("stages", {})
    for keys in (("support", "radial"), ("bearing", "radial"), ("mass",), ("stiffness",), ("face_width",)):
        for stage, table in stages.items():
            gears = {**table, **{f"meshes.{mesh}": entry for mesh, entry in table.get("meshes", {}).items()}}
            for gear, entry in gears.items():
                value: Any = entry if isinstance(entry, Mapping) else {}
                for key in keys:
                    value = value.get(key, {}) if isinstance(value, Mapping) else {}
                if isinstance(value, str) and value[:1].isdigit():
                    yield ".".join(("stages", stage, gear, *keys)), value


def _body(document: Mapping[str, Any]) -> str:
    """A gear of the first stage as results name it."""
    for stage, table in document.get("stages", {}).items():
        for gear, entry in table.items():
            if isinstance(entry, Mapping) and "teeth" in entry and gear in ("sun", "wheel"):
                split = entry.get("split", table.get("split")) or "neck" in entry
                return f"{stage}/{gear}/left" if split else f"{stage}/{gear}"
    return "main/sun"
