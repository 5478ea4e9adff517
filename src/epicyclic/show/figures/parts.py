"""Bodies of a train as a drawing needs them, read from the Dataset of `check`, stages set side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from .series import numbers, texts
from .teeth import Mating, ToothForm, rotations, tooth_form

__all__ = ["Part", "faces", "matings", "one_per_place", "parts", "stages", "title_of", "turns"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One body; lengths [m], angles [rad], speed [rpm], torque [N m]; nan where the model says nothing.

    x, y : centre in frame axes.  offset : what the drawing adds to x so that stages stand side by side.
    angle : polar angle of its own x axis.  outer : outer radius as drawn.  reach : R of u = R rz.
    width : of one helix.  hand : of the left helix.
    """

    name: str
    member: str
    kind: str
    stage: str
    branch: int
    side: str
    carried_by: str
    x: float
    y: float
    station: float
    angle: float
    outer: float
    reach: float
    speed: float
    mass: float
    torque: float = math.nan
    form: ToothForm | None = None
    width: float = math.nan
    gap: float = 0.0
    herringbone: bool = False
    helix_angle: float = 0.0
    hand: int = 0
    offset: float = 0.0

    @property
    def short(self) -> str:
        """``main/planet/2/left`` -> ``planet 2``."""
        word = self.member.split(".")[-1]
        return f"{word} {self.branch}" if self.branch else word

    @property
    def place(self) -> str:
        """What it is drawn with: its stage; a body without teeth that carries nothing stands by itself."""
        return self.name if self.kind == "body" and self.form is None else self.stage

    @property
    def radius(self) -> float:
        """Distance of its centre from the axis of the stage [m]."""
        return math.hypot(self.x, self.y)


def parts(check: xr.Dataset) -> list[Part]:
    """Every body of the train, in order, stages side by side."""
    return _side_by_side(_resolved(_bodies(check)))


def stages(found: Sequence[Part]) -> list[str]:
    """Stages that have gears, in order."""
    return list(dict.fromkeys(part.stage for part in found if part.form is not None))


def one_per_place(found: Sequence[Part]) -> list[Part]:
    """Bodies without those that lie behind an equal one in a front view (the right half of a split member)."""
    seen: dict[tuple[str, str, int], Part] = {}
    for part in found:
        seen.setdefault((part.stage, part.member, part.branch), part)
    return list(seen.values())


def faces(part: Part) -> list[tuple[float, float, int]]:
    """Axial extent of each helix of a gear and its hand: (from, to, hand), stations [m]."""
    half = part.width / 2
    if not part.herringbone:
        return [(part.station - half, part.station + half, part.hand)]
    middle = (part.width + part.gap) / 2
    left, right = part.station - middle, part.station + middle
    return [(left - half, left + half, part.hand), (right - half, right + half, -part.hand)]


def title_of(check: xr.Dataset) -> str:
    """Title of the train."""
    return str(check.attrs.get("title", ""))


def matings(check: xr.Dataset) -> list[Mating]:
    """Every mesh of the train, with the place of its contact at time zero."""
    if "gear_a" not in check.variables:
        return []
    columns = [numbers(check, name, "mesh") for name in ("mesh_direction", "working_pressure_angle", "flank")]
    leads, senses = np.nan_to_num(numbers(check, "phase_lead", "mesh")), _senses(check)
    rows = zip(texts(check, "gear_a"), texts(check, "gear_b"), *columns, leads, senses, strict=True)
    return [
        Mating(a=a, b=b, direction=float(e), pressure_angle=float(alpha), flank=int(d), sigma=float(sense * lead))
        for a, b, e, alpha, d, lead, sense in rows
    ]


def turns(check: xr.Dataset, found: Sequence[Part]) -> dict[str, float]:
    """Polar angle of one tooth centre of every gear at time zero."""
    return rotations({part.name: part.form for part in found if part.form is not None}, matings(check))


def _senses(check: xr.Dataset) -> list[int]:
    """+1 where the first gear of a mesh drives in its frame, else -1; +1 without speeds."""
    speed = dict(zip(texts(check, "body"), numbers(check, "speed", "body"), strict=True))
    frames = zip(texts(check, "body_stage", "body"), texts(check, "kind", "body"), speed.values(), strict=True)
    carrier = {stage: value for stage, kind, value in frames if kind == "carrier"}
    flanks = numbers(check, "flank", "mesh")
    found = []
    for a, stage, d in zip(texts(check, "gear_a"), texts(check, "mesh_stage", "mesh"), flanks, strict=True):
        found.append(-1 if d * (speed.get(a, math.nan) - carrier.get(stage, 0.0)) < 0 else 1)
    return found


def _bodies(check: xr.Dataset) -> list[Part]:
    gears = _gears(check)
    words = [texts(check, name, "body") for name in ("body", "member", "kind", "body_stage", "side", "carried_by")]
    asked = ("branch", "centre_x", "centre_y", "station", "axes_angle", "outer_radius", "speed", "mass", "torque")
    values = [numbers(check, name, "body").tolist() for name in asked]
    found = []
    for name, member, kind, stage, side, carrier, *rest in zip(*words, *values, strict=True):
        branch, x, y, station, angle, outer, speed, mass, torque = rest
        body = Part(
            name=name,
            member=member or name,
            kind=kind,
            stage=stage,
            branch=int(branch) if np.isfinite(branch) else 0,
            side=side,
            carried_by=carrier,
            x=x,
            y=y,
            station=station,
            angle=angle,
            outer=outer,
            reach=outer,
            speed=speed,
            mass=mass,
            torque=torque,
        )
        found.append(_toothed(body, gears[name]) if name in gears else body)
    return found


def _gears(check: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Values of every gear by variable; plain ones, for `check.sel` takes a millisecond a gear."""
    if "gear" not in check.dims:
        return {}
    columns = {str(name): one.values for name, one in check.variables.items() if one.dims == ("gear",)}
    return {str(name): {key: own[i] for key, own in columns.items()} for i, name in enumerate(check["gear"].values)}


def _toothed(body: Part, row: Mapping[str, Any]) -> Part:
    def value(name: str, default: float = math.nan) -> float:
        return float(row[name]) if name in row else default

    form = tooth_form(
        teeth=int(row["teeth"]),
        internal=bool(row["internal"]) if "internal" in row else False,
        base_radius=value("base_radius"),
        reference_radius=value("reference_radius"),
        tip_radius=value("tip_radius"),
        root_radius=value("root_radius"),
        profile_shift=value("profile_shift", 0.0),
        pressure_angle=value("pressure_angle"),
    )
    hand = value("hand", 0.0)
    return replace(
        body,
        form=form,
        reach=form.base_radius,
        outer=_outer(form, body.outer),
        width=value("face_width"),
        gap=float(np.nan_to_num(value("gap", 0.0))),
        herringbone=bool(row["herringbone"]) if "herringbone" in row else False,
        helix_angle=float(np.nan_to_num(value("helix_angle", 0.0))),
        hand=int(hand) if np.isfinite(hand) else 0,
    )


def _outer(form: ToothForm, given: float) -> float:
    if not form.internal:
        return form.tip_radius
    rim = form.root_radius + 2 * abs(form.root_radius - form.tip_radius) / 2.25
    return given if given > 1.01 * form.root_radius else rim


def _resolved(found: list[Part]) -> list[Part]:
    """Carriers get the pin radius as R and a size that holds their pins; widths not given a drawn one."""
    widths = [part.width for part in found if np.isfinite(part.width)]
    radii = [part.form.reference_radius for part in found if part.form is not None and not part.form.internal]
    drawn = max(widths) if widths else 0.5 * min(radii, default=1.0)
    gears = [part.radius + part.outer for part in found if part.form is not None]
    largest = max(gears or [part.outer for part in found if np.isfinite(part.outer)], default=1.0)
    result = []
    for part in found:
        pins = [other for other in found if other.carried_by == part.name]
        reach = pins[0].radius if pins else part.reach
        sizes = [pin.radius + 0.35 * (pin.form.reference_radius if pin.form else 0.1 * pin.radius) for pin in pins]
        outer = max(sizes) if sizes else part.outer
        result.append(
            replace(
                part,
                # the size of a plain body is that of an equal disc, so at most a bystander's
                outer=min(outer, 0.4 * largest if part.form is None and not pins else outer)
                if np.isfinite(outer)
                else 0.2 * largest,
                reach=reach if np.isfinite(reach) and reach > 0 else 1.0,
                width=part.width if np.isfinite(part.width) else drawn,
            )
        )
    return result


def _side_by_side(found: list[Part]) -> list[Part]:
    start, offsets = 0.0, dict[str, float]()
    for place in dict.fromkeys(part.place for part in found):
        half = max(part.radius + part.outer for part in found if part.place == place)
        offsets[place] = start + half if offsets else 0.0
        start = offsets[place] + 1.25 * half
    return [replace(part, offset=offsets[part.place]) for part in found]
