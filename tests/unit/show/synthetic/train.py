"""Two planetary trains, made without the engine: what stands in them, and the Dataset of `check`.

`ren()` is a herringbone train of three planets with a left and a right ring that also moves axially; `lin(n)` a planar
spur train of n planets.  All numbers of the analyses are made up, their names and shapes are not.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from epicyclic.results.dataset import dataset
from epicyclic.warning_codes import CodedText

Array = NDArray[np.float64]
DIRECTIONS = ["x", "y", "z", "rx", "ry", "rz"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Gears:
    """A planetary stage: teeth, module [m], angles [rad], masses [kg], inertias as mass at base radius [kg]."""

    title: str
    planets: int
    teeth: Mapping[str, int]
    module: float
    helix: float
    width: float
    gap: float
    herringbone: bool
    mass: Mapping[str, float]
    inertia: Mapping[str, float]
    support: Mapping[str, float]
    twist: Mapping[str, float]
    bearing: float
    mesh: tuple[float, float]
    sun_speed: float
    sun_torque: float
    free: tuple[str, ...]

    @property
    def transverse(self) -> float:
        return math.atan(math.tan(math.radians(20)) / math.cos(self.helix))

    @property
    def radius(self) -> dict[str, float]:
        return {name: z * self.module / math.cos(self.helix) / 2 for name, z in self.teeth.items()}

    @property
    def pin_radius(self) -> float:
        return self.radius["sun"] + self.radius["planet"]


REN = Gears(
    title="Herringbone planetary train, 100 kN m (Ren 2021)",
    planets=3,
    teeth={"sun": 23, "planet": 17, "ring": 57},
    module=0.032,
    helix=math.radians(25),
    width=0.17,
    gap=0.02,
    herringbone=True,
    mass={"sun": 750, "planet": 525, "ring": 450, "carrier": 5091},
    inertia={"sun": 663, "planet": 420, "ring": 546, "carrier": 5724},
    support={"sun": 1e9, "ring": 1e10, "carrier": 1e9},
    twist={"ring": 1e10},
    bearing=1e9,
    mesh=(2.85e9, 3.85e9),
    sun_speed=100.0,
    sun_torque=1e5,
    free=("x", "y", "z", "rz"),
)


def lin_gears(planets: int, *, turning: bool = False) -> Gears:
    """A planar spur train near that of Lin and Parker, with a speed and a torque where `turning`."""
    return Gears(
        title=f"Planar planetary train, {planets} planets (Lin & Parker 1999)",
        planets=planets,
        teeth={"sun": 27, "planet": 35, "ring": 97},
        module=0.003,
        helix=0.0,
        width=0.025,
        gap=0.0,
        herringbone=False,
        mass={"sun": 0.4, "planet": 0.66, "ring": 2.35, "carrier": 5.43},
        inertia={"sun": 0.39, "planet": 0.61, "ring": 3.0, "carrier": 6.29},
        support={"sun": 1e8, "ring": 1e8, "carrier": 1e8},
        twist={"ring": 1e9},
        bearing=1e8,
        mesh=(5e8, 5e8),
        sun_speed=500.0 if turning else math.nan,
        sun_torque=1000.0 if turning else math.nan,
        free=("x", "y", "rz"),
    )


def bodies(gears: Gears) -> list[dict[str, Any]]:
    """One record a body."""
    rings = ["left", "right"] if gears.herringbone else [""]
    half = (gears.width + gears.gap) / 2
    ws = gears.sun_speed
    wc = ws * gears.teeth["sun"] / (gears.teeth["sun"] + gears.teeth["ring"])
    wp = wc - (ws - wc) * gears.teeth["sun"] / gears.teeth["planet"]
    ts = gears.sun_torque
    tr = ts * gears.teeth["ring"] / gears.teeth["sun"]
    found = [_body("sun", 0, "", 0.0, ws, ts)]
    found += [
        _body("ring", 0, side, {"left": -half, "right": half}.get(side, 0.0), 0.0 * ws, tr / len(rings))
        for side in rings
    ]
    found += [_body("carrier", 0, "", 0.0, wc, -ts - tr)]
    for branch in range(1, gears.planets + 1):
        psi = 2 * math.pi * (branch - 1) / gears.planets
        place = {"x": gears.pin_radius * math.cos(psi), "y": gears.pin_radius * math.sin(psi), "angle": psi}
        found.append({**_body("planet", branch, "", 0.0, wp, 0.0), **place})
    return found


def _body(kind: str, branch: int, side: str, station: float, speed: float, torque: float) -> dict[str, Any]:
    name = "/".join(word for word in ("main", kind, str(branch) if branch else "", side) if word)
    here = {"x": 0.0, "y": 0.0, "angle": 0.0, "station": station}
    return {"name": name, "kind": kind, "branch": branch, "side": side, "speed": speed, "torque": torque, **here}


def meshes(gears: Gears) -> list[dict[str, Any]]:
    """One record a mesh, with its phases as CONVENTIONS give them for a sun that drives counter-clockwise."""
    sides = ["left", "right"] if gears.herringbone else [""]
    found = []
    for pair, k in zip(("sun-planet", "planet-ring"), gears.mesh, strict=True):
        for branch in range(1, gears.planets + 1):
            psi = 2 * math.pi * (branch - 1) / gears.planets
            for side in sides:
                inner = pair == "sun-planet"
                sun_ring = (1 - gears.teeth["planet"]) / 2
                turns = psi / (2 * math.pi)
                lead = -gears.teeth["sun"] * turns if inner else sun_ring + gears.teeth["ring"] * turns
                suffix = f"/{side}" if side else ""
                ring = f"main/ring{suffix}" if gears.herringbone else "main/ring"
                a, b = ("main/sun", f"main/planet/{branch}") if inner else (f"main/planet/{branch}", ring)
                found.append(
                    {
                        "name": f"main/{pair}/{branch}{suffix}",
                        "pair": pair,
                        "branch": branch,
                        "side": side,
                        "a": a,
                        "b": b,
                        "psi": psi,
                        "flank": 1 if inner else -1,
                        "lead": round(lead % 1.0, 9) % 1.0,
                        "k": k,
                    }
                )
    return found


def array(values: Iterable[Any]) -> NDArray[Any]:
    return np.array(list(values))


def _columns(dim: str, records: Sequence[Mapping[str, Any]], **picks: Any) -> dict[str, tuple[str, NDArray[Any]]]:
    """One variable a keyword: the key of a record, or a function of it."""
    return {
        name: (dim, array(pick(one) if callable(pick) else one[pick] for one in records))
        for name, pick in picks.items()
    }


def _body_columns(gears: Gears) -> dict[str, tuple[str, NDArray[Any]]]:
    outer = {"sun": 12.5, "planet": 9.5, "ring": 32.0, "carrier": 25.0}
    return _columns(
        "body",
        bodies(gears),
        **{key: key for key in ("kind", "branch", "side", "speed", "torque", "station")},
        **{"centre_x": "x", "centre_y": "y", "axes_angle": "angle"},
        member=lambda body: f"main.{body['kind']}",
        body_stage=lambda _: "main",
        carried_by=lambda body: "main/carrier" if body["branch"] else "",
        power=lambda body: body["torque"] * body["speed"] * math.pi / 30,
        mass=lambda body: gears.mass[body["kind"]],
        inertia=lambda body: gears.inertia[body["kind"]],
        outer_radius=lambda body: outer[body["kind"]] * gears.module,
    )


def _gear_columns(gears: Gears, toothed: list[dict[str, Any]]) -> dict[str, tuple[str, NDArray[Any]]]:
    radius, inward = gears.radius, {"sun": 1, "planet": 1, "ring": -1}
    hand = {"sun": -1, "planet": 1, "ring": 1}
    return _columns(
        "gear",
        toothed,
        teeth=lambda body: gears.teeth[body["kind"]],
        internal=lambda body: body["kind"] == "ring",
        herringbone=lambda body: gears.herringbone and body["kind"] != "ring",
        base_radius=lambda body: radius[body["kind"]] * math.cos(gears.transverse),
        reference_radius=lambda body: radius[body["kind"]],
        tip_radius=lambda body: radius[body["kind"]] + inward[body["kind"]] * gears.module,
        root_radius=lambda body: radius[body["kind"]] - 1.25 * inward[body["kind"]] * gears.module,
        face_width=lambda _: gears.width,
        gap=lambda _: gears.gap,
        helix_angle=lambda _: gears.helix,
        hand=lambda body: hand[body["kind"]] * bool(gears.helix) * (-1 if body["side"] == "right" else 1),
        profile_shift=lambda _: 0.0,
        module=lambda _: gears.module,
        pressure_angle=lambda _: math.radians(20),
    )


def _mesh_columns(gears: Gears) -> dict[str, tuple[str, NDArray[Any]]]:
    return _columns(
        "mesh",
        meshes(gears),
        **{"phase_lead": "lead", "flank": "flank", "gear_a": "a", "gear_b": "b", "mesh_branch": "branch"},
        **{"mesh_side": "side", "mesh_direction": "psi", "mean_mesh_stiffness": "k"},
        contact_ratio=lambda mesh: 1.372 if mesh["pair"] == "sun-planet" else 1.614,
        overlap_ratio=lambda _: 0.715 if gears.helix else 0.0,
        working_pressure_angle=lambda _: gears.transverse,
        mesh_stage=lambda _: "main",
        mesh_pair=lambda mesh: f"stages.main.meshes.{mesh['pair']}",
    )


def _lines(gears: Gears, tone: float) -> list[tuple[str, float]]:
    """Mesh frequency and the speed of every member [Hz]."""
    if not math.isfinite(tone):
        return []
    speeds = {body["kind"]: abs(body["speed"]) / 60 for body in bodies(gears)}
    return [("main mesh", tone), *[(f"main.{kind} turning", hertz) for kind, hertz in speeds.items() if hertz]]


def check(gears: Gears, *, warnings: Sequence[CodedText] = ()) -> xr.Dataset:
    """The Dataset of `check`."""
    own = bodies(gears)
    toothed, links = [body for body in own if body["kind"] != "carrier"], links_of(gears, own)
    tone = gears.teeth["ring"] * next(body["speed"] for body in own if body["kind"] == "carrier") / 60
    lines = _lines(gears, tone)
    made = dataset(
        {
            **_body_columns(gears),
            **_gear_columns(gears, toothed),
            **_mesh_columns(gears),
            "mesh_frequency": ("stage", np.array([tone])),
            "planets": ("stage", np.array([gears.planets])),
            "hunting_period": ("stage", np.array([float(math.lcm(*gears.teeth.values()))])),
            "centre_distance": ("stage", np.array([gears.pin_radius])),
            "link_first": ("link", array(link[1] for link in links)),
            "link_second": ("link", array(link[2] for link in links)),
            "link_stiffness": (("link", "direction"), np.array([link[3] for link in links])),
            "order_frequency": ("order_name", np.array([hertz for _, hertz in lines])),
            "order": ("order_name", np.array([hertz / tone for _, hertz in lines])),
        },
        coords={
            "body": array(body["name"] for body in own),
            "gear": array(body["name"] for body in toothed),
            "mesh": array(mesh["name"] for mesh in meshes(gears)),
            "stage": np.array(["main"]),
            "link": array(link[0] for link in links),
            "direction": DIRECTIONS,
            "order_name": np.array([name for name, _ in lines], dtype=str),
        },
        verb="check",
        warnings=warnings,
        provenance=provenance(gears),
    )
    values = [["stages.main.module", 0.032, "m", "assumed"], ["stages.main.sun.teeth", 23, "", "given"]]
    return made.assign_attrs(values=json.dumps(values))


def provenance(gears: Gears) -> dict[str, str]:
    return {
        "title": gears.title,
        "doi": "10.1155/2021/5511817",
        "model": '{"format": 2, "title": "made up", "stages": {"main": {"planets": 3}}}',
        "assumed": '{"damping.modal": "not printed", "stages.main.module": "mass and J/r^2 fit; ISO 54 series"}',
    }


def links_of(gears: Gears, own: list[dict[str, Any]]) -> list[tuple[str, str, str, list[float]]]:
    found = []
    axial = "z" in gears.free
    for body in own:
        name, kind = body["name"], body["kind"]
        k = gears.bearing if body["branch"] else gears.support[kind]
        twist = gears.twist.get(kind, 0.0) * (gears.radius.get(kind, 1.0)) ** 2
        values = [k, k, k if axial else math.inf, math.inf, math.inf, twist]
        if body["branch"]:
            found.append((f"{name}/bearing", "main/carrier", name, [*values[:5], 0.0]))
        else:
            found.append((f"{name}/support", name, "", values))
    return found
