"""A new train: from teeth or ratio, load and speed to a whole document, with what follows from it as comments.

`epicyclic.planetary`, `star` and `differential`: a train in Python from the words of a drawing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from ..arguments import checked
from ..document.writer import commented_text, quantity_text
from ..errors import ModelError
from ..teeth.geometry import overlap_ratio
from .preselection import (
    FEWEST,
    LOAD_FIGURE,
    Blank,
    GearSize,
    ToothCounts,
    assembles,
    beside,
    least_gap,
    most_planets,
    nearest_counts,
    neighbour_gap,
    ratio_of,
    shifts_of,
    size_of,
)
from .resolution import load
from .train import Train
from .wishes import MEMBERS, Number, Wishes, read_wishes


@checked
def planetary(
    *,
    teeth: str | Sequence[int] | None = None,
    ratio: float | None = None,
    planets: int = 3,
    speed: Number | None = None,
    torque: Number | None = None,
    power: Number | None = None,
    module: Number | None = None,
    face_width: Number | None = None,
    helix_angle: Number | None = None,
    pressure_angle: Number | None = None,
    held: Literal["ring", "sun"] = "ring",
    driver: Literal["sun", "ring", "carrier"] | None = None,
    title: str | None = None,
) -> dict[str, Any]:
    """A planetary set, its carrier turning: a model document, which `load` and every verb take as a source.

    Quantities are texts with a unit, ``"10 mm"``, or floats in SI.  What is not given is chosen, and listed with its
    reason under ``assumed``; what is given stays.

    Parameters
    ----------
    teeth : sun, planet and ring, ``(21, 39, 99)`` or ``"21/39/99"``; else they are searched for from the ratio.
    ratio : speed of sun per carrier with the ring held, of ring per carrier with the sun held [1]; within 2 %.
    planets : number, equally spaced.
    speed, torque, power : of the driving member, two of the three [rad/s, N m, W].
    module, face_width : normal module and face width [m]; else a preselection from the torque, no strength rating.
    helix_angle, pressure_angle : at the reference circle, normal; [rad], 0 and 20 deg unless given.
    held : the member that does not turn.
    driver : the member that drives; unless given the sun, with the sun held the ring.

    Raises
    ------
    ModelError : a keyword that is missing or contradicts another, teeth that do not assemble (with the nearest that
        do), planets without room.
    """
    given = dict(locals())
    return dict(new_train(kind="planetary", **given).document)


@checked
def star(
    *,
    teeth: str | Sequence[int] | None = None,
    ratio: float | None = None,
    planets: int = 3,
    speed: Number | None = None,
    torque: Number | None = None,
    power: Number | None = None,
    module: Number | None = None,
    face_width: Number | None = None,
    helix_angle: Number | None = None,
    pressure_angle: Number | None = None,
    driver: Literal["sun", "ring"] | None = None,
    title: str | None = None,
) -> dict[str, Any]:
    """A star set, its carrier held: a model document, which `load` and every verb take as a source.

    Keywords, units and errors as of `planetary`; ratio : size of the speed of the sun per ring [1], of either sign.
    """
    given = dict(locals())
    return dict(new_train(kind="star", **given).document)


@checked
def differential(
    *,
    teeth: str | Sequence[int],
    speed: Mapping[str, Number],
    torque: Mapping[str, Number] | None = None,
    power: Mapping[str, Number] | None = None,
    planets: int = 3,
    module: Number | None = None,
    face_width: Number | None = None,
    helix_angle: Number | None = None,
    pressure_angle: Number | None = None,
    title: str | None = None,
) -> dict[str, Any]:
    """A differential set, no member held: a model document, which `load` and every verb take as a source.

    Keywords, units and errors as of `planetary`, but members are named: speed : of two of sun, ring and carrier
    [rad/s], ``{"sun": "1000 rpm", "carrier": "100 rpm"}``; torque or power : of one of them [N m, W].
    """
    given = dict(locals())
    return dict(new_train(kind="differential", **given).document)


_NORMAL_ANGLE = math.radians(20)  # the file format's default
_UNDERCUT = 12  # fewer teeth no profile shift saves from undercut or a pointed tip


@dataclass(frozen=True, slots=True, kw_only=True)
class NewTrain:
    """A new train.

    document : what `load` takes, reasons of all that was chosen under ``assumed``.
    comments : what follows from it, by path.  remarks : what a person should know of the choice.
    """

    document: Mapping[str, Any]
    comments: Mapping[str, str]
    remarks: tuple[str, ...]

    def text(self, head: tuple[str, ...] = ()) -> str:
        """The commented model file; head : lines of comment ahead of all."""
        return commented_text(self.document, head=(*head, *self.remarks), comments=self.comments)


def new_train(**keywords: Any) -> NewTrain:
    """A train from the keywords of `wishes.read_wishes`.

    Raises
    ------
    ModelError : what contradicts, cannot be assembled or does not fit; names the keyword.
    """
    wishes = read_wishes(**keywords)
    _check_counts(wishes)
    size = size_of(
        wishes.counts,
        wishes.planets,
        wishes.load.sun_torque,
        wishes.helix_angle,
        module=wishes.module,
        width=wishes.face_width,
    )
    blank = Blank(
        counts=wishes.counts,
        planets=wishes.planets,
        module=size.module,
        face_width=size.face_width,
        helix_angle=wishes.helix_angle,
        pressure_angle=wishes.pressure_angle or _NORMAL_ANGLE,
        held=wishes.held,
    )
    document = _document(wishes, blank, size)
    return NewTrain(
        document=document,
        comments=_comments(wishes, load(document)),
        remarks=_remarks(wishes, blank, size),
    )


def _check_counts(wishes: Wishes) -> None:
    """Raise ModelError for teeth that do not assemble, have no room, or cannot be cut."""
    counts, planets = wishes.counts, wishes.planets
    if min(counts.sun, counts.planet) < _UNDERCUT:
        raise ModelError("too few teeth", path="teeth", given=str(counts), allowed=f"{_UNDERCUT} or more on each gear")
    least = least_gap(wishes.module)
    if neighbour_gap(counts, planets, wishes.helix_angle) < least:
        most = most_planets(counts, wishes.helix_angle, wishes.module)
        raise ModelError(
            f"the tips of neighbouring planets of {counts} come nearer than one module",
            path="planets",
            given=planets,
            allowed=f"at most {most} with these teeth",
        )
    if not assembles(counts, planets):
        near = nearest_counts(counts, planets, helix_angle=wishes.helix_angle, module=wishes.module)
        fitting = [n for n in range(2, planets + 4) if assembles(counts, n) and n != planets]
        fitting = [n for n in fitting if neighbour_gap(counts, n, wishes.helix_angle) >= least]
        ways = [" or ".join(map(str, near))] if near else []
        ways += [f"these teeth with {' or '.join(map(str, fitting))} planets"] if fitting else []
        raise ModelError(
            f"{planets} equally spaced planets cannot be assembled, the teeth do not meet",
            path="teeth",
            given=str(counts),
            allowed="; ".join(ways) or "other teeth",
        )


# the document ---------------------------------------------------------------------------------------------------------


def _document(wishes: Wishes, blank: Blank, size: GearSize) -> dict[str, Any]:
    """The whole document, reasons of what was chosen under `assumed`."""
    tables, reasons = beside(blank)
    texts, load_ = wishes.texts, wishes.load
    figure = f"preselection, no strength rating: K = {size.load_figure / 1e6:.2g} N/mm^2, at most {LOAD_FIGURE / 1e6:g}"
    chosen = {}
    if "module" not in texts:
        chosen["stages.main.module"] = f"{figure}; series I of ISO 54"
    if "face_width" not in texts:
        chosen["stages.main.face_width"] = (
            "0.8 of the sun's diameter" if "module" not in texts else f"{figure}; 0.8 d_s"
        )
    common: dict[str, Any] = {
        "planets": wishes.planets,
        "module": texts.get("module", quantity_text(size.module, "length")),
    }
    common |= {key: texts[key] for key in ("pressure_angle", "helix_angle") if key in texts}
    common["face_width"] = texts.get("face_width", quantity_text(size.face_width, "length"))
    stage = tables["stages"]["main"]
    teeth = {"sun": blank.counts.sun, "planet": blank.counts.planet, "ring": blank.counts.ring}
    members = {m: ({"teeth": teeth[m]} if m in teeth else {}) | stage[m] for m in (*teeth, "carrier")}
    operation: dict[str, Any] = {} if wishes.held is None else {"held": [wishes.held]}
    for path, values in (("speed", load_.speed), ("torque", load_.torque), ("power", load_.power)):
        if values:
            operation[path] = dict(values)
    chosen |= {f"operation.{path}.{load_.driver}": reason for path, reason in load_.derived.items()}
    return {
        "format": 2,
        "title": wishes.title,
        "damping": tables["damping"],
        "stages": {"main": common | members},
        "operation": operation,
        "deviations": tables["deviations"],
        "tolerance": tables["tolerance"],
        "assumed": chosen | reasons,
    }


# what follows ---------------------------------------------------------------------------------------------------------


def _comments(wishes: Wishes, train: Train) -> dict[str, str]:
    """Derived values by the path they stand at."""
    mesh = {m.pair.rpartition(".")[2]: m for m in train.meshes}
    gears = {b.member.rpartition(".")[2]: b.gear for b in train.bodies if b.gear is not None}
    first = mesh["sun-planet"]
    centre = first.radius_a + first.radius_b
    of_stage = [f"centre distance {_mm(centre)}"]
    if wishes.held is not None:
        a, b = {"ring": ("sun", "carrier"), "sun": ("ring", "carrier"), "carrier": ("sun", "ring")}[wishes.held]
        of_stage.insert(0, f"ratio {ratio_of(wishes.counts, wishes.held):.5g}, {a} to {b}")
    if (rate := (train.kinematics.mesh_frequency or {}).get("main")) is not None:
        of_stage.append(f"mesh frequency {float(rate):.6g} Hz")
    overlap = ""
    if wishes.helix_angle and not math.isnan(first.overlap_ratio):
        overlap = f", overlap {first.overlap_ratio:.2f}"
    comments = {
        "stages.main": "; ".join(of_stage),
        "stages.main.carrier": f"pins on a circle of {_mm(centre)} radius",
        # "contact" takes seconds of computing, and a train without relief does not need it
        "stages.main.face_width": 'of each gear; tip relief would count with meshes.*.stiffness = "contact"',
        "operation": "without weights; gravity = true counts them",
        "deviations": "what manufacturing leaves over",
        "tolerance": "what the drawing allows, from one train to the next",
        "assumed": "chosen, not given: every value here wants yours",
    }
    contact = {
        "sun": f"contact ratio with a planet {first.contact_ratio:.2f}{overlap}",
        "ring": f"contact ratio with a planet {mesh['planet-ring'].contact_ratio:.2f}{overlap}",
    }
    for member, gear in gears.items():
        said = f"reference diameter {_mm(2 * gear.reference_radius)}"
        comments[f"stages.main.{member}"] = "; ".join(filter(None, (said, contact.get(member, ""))))
    return comments | _operation_comments(wishes, train)


def _operation_comments(wishes: Wishes, train: Train) -> dict[str, str]:
    """Speeds, torques and power of the members that the operation does not state."""
    motion, load_ = train.kinematics, wishes.load
    comments: dict[str, str] = {}
    if motion.speed:
        others = [m for m in (*MEMBERS, "planet") if m not in load_.speed and m != wishes.held]
        speeds = {m: motion.speed.get(f"main.{m}") for m in others}
        said = [f"{m} {float(speed):.6g} rpm" for m, speed in speeds.items() if speed is not None]
        comments[f"operation.speed.{list(load_.speed)[-1]}"] = ", ".join(said)
    if motion.torque:
        stated = [*load_.torque, *load_.power]
        said = [
            f"{m} {quantity_text(float(f'{moment:.5g}'), 'torque')}"
            for m in MEMBERS
            if m not in load_.torque and (moment := motion.torque.get(f"main.{m}"))
        ]
        driven = (motion.power or {}).get(f"main.{load_.driver}") if load_.torque else None
        said += [f"power {quantity_text(float(f'{driven:.5g}'), 'power')}"] if driven else []
        where = f"operation.{'torque' if load_.torque else 'power'}.{stated[0]}"
        comments[where] = f"{', '.join(said)}; counter-clockwise positive"
    return comments


def _remarks(wishes: Wishes, blank: Blank, size: GearSize) -> tuple[str, ...]:
    """What a person should know of what was chosen."""
    counts, planets = blank.counts, blank.planets
    said = []
    if wishes.ratio is not None and wishes.others:
        assert wishes.held is not None
        said.append(
            f"Teeth {_with_ratio(counts, wishes)}; "
            f"as well: {', '.join(_with_ratio(other, wishes) for other in wishes.others)}."
        )
    if "module" not in wishes.texts or "face_width" not in wishes.texts:
        said.append(
            f"Module and face width: preselection by K = {size.load_figure / 1e6:.2g} N/mm^2, no strength rating."
        )
    elif size.load_figure > LOAD_FIGURE:
        said.append(f"K = {size.load_figure / 1e6:.2g} N/mm^2 is above 4: rate the strength of these gears.")
    said += [_phasing_words(counts.sun, planets)] if planets > 2 else []
    low = [m for m, z in (("sun", counts.sun), ("planet", counts.planet)) if z < FEWEST]
    if low and not shifts_of(blank):
        said.append(f"The {' and the '.join(low)} may be undercut: fewer than {FEWEST} teeth and no profile shift.")
    if wishes.helix_angle and overlap_ratio(size.face_width, wishes.helix_angle, size.module) < 1:
        said.append("The overlap ratio is below 1: not at every moment does a whole helix carry.")
    return tuple(said)


def _phasing_words(sun: int, planets: int) -> str:
    """What the meshes with the sun do together at the mesh frequency: the sum over exp(2 pi i z_s k/N) [parker2004]."""
    if sun % planets == 0:
        return "z_s/N is whole: at the mesh frequency the planets pull at the sun alike, torque adds up, forces cancel."
    if (sun + 1) % planets == 0 or (sun - 1) % planets == 0:
        return "z_s/N is not whole: at the mesh frequency torque on the sun cancels, forces across its axis add up."
    return "z_s/N is not whole: at the mesh frequency torque on the sun cancels, and so do forces across its axis."


def _with_ratio(counts: ToothCounts, wishes: Wishes) -> str:
    """``21/39/99 (5.714)``."""
    assert wishes.held is not None
    return f"{counts} ({ratio_of(counts, wishes.held):.5g})"


def _mm(length: float) -> str:
    return f"{length * 1e3:.6g} mm"
