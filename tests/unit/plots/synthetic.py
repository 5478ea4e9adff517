"""Datasets as the analyses give them, for two planetary trains, made here without the analyses.

`ren()` is a herringbone train of three planets with a left and a right ring that also moves axially; `lin(n)` a planar
spur train of n planets.  Modes come from a small model of their own; histories and responses are made up.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import xarray as xr
from numpy.typing import NDArray

from epicyclic.results import dataset

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


def _column(records: Sequence[Mapping[str, Any]], key: str) -> Array:
    return np.array([float(record[key]) for record in records])


def _text(values: Sequence[str]) -> NDArray[np.str_]:
    return np.array(list(values), dtype=str)


def check(gears: Gears, *, warnings: Sequence[str] = ()) -> xr.Dataset:
    """The Dataset of `check`."""
    own, pairs = bodies(gears), meshes(gears)
    toothed = [body for body in own if body["kind"] != "carrier"]
    radius = gears.radius
    module = gears.module
    tip = {"sun": radius["sun"] + module, "planet": radius["planet"] + module, "ring": radius["ring"] - module}
    root = {name: value + (1.25 if name == "ring" else -1.25) * module for name, value in radius.items()}
    outer = {**tip, "ring": root["ring"] + 2 * module, "carrier": gears.pin_radius + 0.4 * radius["planet"]}
    wc = own[[body["kind"] for body in own].index("carrier")]["speed"]
    tone = gears.teeth["ring"] * wc / 60
    links = _links(gears, own)
    hands = {"sun": -1, "planet": 1, "ring": 1}
    speeds = [
        (body["kind"], abs(body["speed"]) / 60) for body in own if body["branch"] in (0, 1) and body["side"] != "right"
    ]
    lines = [("main mesh", tone), *[(f"main.{kind} turning", hertz) for kind, hertz in speeds if hertz > 0]]
    lines += [
        (f"main.{kind} in the carrier's frame", abs(hertz * 60 - wc) / 60)
        for kind, hertz in speeds
        if kind != "carrier"
    ]
    lines = lines if math.isfinite(tone) else []
    power = [body["torque"] * body["speed"] * math.pi / 30 for body in own]
    made = dataset(
        {
            "kind": ("body", _text([body["kind"] for body in own])),
            "member": ("body", _text([f"main.{body['kind']}" for body in own])),
            "body_stage": ("body", _text(["main"] * len(own))),
            "branch": ("body", np.array([body["branch"] for body in own])),
            "side": ("body", _text([body["side"] for body in own])),
            "carried_by": ("body", _text(["main/carrier" if body["branch"] else "" for body in own])),
            "speed": ("body", _column(own, "speed")),
            "torque": ("body", _column(own, "torque")),
            "power": ("body", np.array(power)),
            "centre_x": ("body", _column(own, "x")),
            "centre_y": ("body", _column(own, "y")),
            "station": ("body", _column(own, "station")),
            "axes_angle": ("body", _column(own, "angle")),
            "mass": ("body", np.array([gears.mass[body["kind"]] for body in own])),
            "inertia": ("body", np.array([gears.inertia[body["kind"]] for body in own])),
            "outer_radius": ("body", np.array([outer[body["kind"]] for body in own])),
            "teeth": ("gear", np.array([gears.teeth[body["kind"]] for body in toothed])),
            "internal": ("gear", np.array([body["kind"] == "ring" for body in toothed])),
            "herringbone": ("gear", np.array([gears.herringbone and body["kind"] != "ring" for body in toothed])),
            "base_radius": ("gear", np.array([radius[b["kind"]] * math.cos(gears.transverse) for b in toothed])),
            "tip_radius": ("gear", np.array([tip[body["kind"]] for body in toothed])),
            "root_radius": ("gear", np.array([root[body["kind"]] for body in toothed])),
            "reference_radius": ("gear", np.array([radius[body["kind"]] for body in toothed])),
            "face_width": ("gear", np.full(len(toothed), gears.width)),
            "gap": ("gear", np.full(len(toothed), gears.gap)),
            "helix_angle": ("gear", np.full(len(toothed), gears.helix)),
            "hand": (
                "gear",
                np.array([hands[b["kind"]] * bool(gears.helix) * (-1 if b["side"] == "right" else 1) for b in toothed]),
            ),
            "profile_shift": ("gear", np.zeros(len(toothed))),
            "module": ("gear", np.full(len(toothed), gears.module)),
            "pressure_angle": ("gear", np.full(len(toothed), math.radians(20))),
            "phase_lead": ("mesh", _column(pairs, "lead")),
            "contact_ratio": ("mesh", np.array([1.372 if mesh["pair"] == "sun-planet" else 1.614 for mesh in pairs])),
            "overlap_ratio": ("mesh", np.full(len(pairs), 0.715 if gears.helix else 0.0)),
            "working_pressure_angle": ("mesh", np.full(len(pairs), gears.transverse)),
            "mean_mesh_stiffness": ("mesh", _column(pairs, "k")),
            "flank": ("mesh", np.array([mesh["flank"] for mesh in pairs])),
            "gear_a": ("mesh", _text([mesh["a"] for mesh in pairs])),
            "gear_b": ("mesh", _text([mesh["b"] for mesh in pairs])),
            "mesh_stage": ("mesh", _text(["main"] * len(pairs))),
            "mesh_branch": ("mesh", np.array([mesh["branch"] for mesh in pairs])),
            "mesh_side": ("mesh", _text([mesh["side"] for mesh in pairs])),
            "mesh_pair": ("mesh", _text([f"stages.main.meshes.{mesh['pair']}" for mesh in pairs])),
            "mesh_direction": ("mesh", _column(pairs, "psi")),
            "mesh_frequency": ("stage", np.array([tone])),
            "planets": ("stage", np.array([gears.planets])),
            "hunting_period": ("stage", np.array([float(math.lcm(*gears.teeth.values()))])),
            "centre_distance": ("stage", np.array([gears.pin_radius])),
            "link_first": ("link", _text([link[1] for link in links])),
            "link_second": ("link", _text([link[2] for link in links])),
            "link_stiffness": (("link", "direction"), np.array([link[3] for link in links])),
            "order_frequency": ("order_name", np.array([hertz for _, hertz in lines])),
            "order": ("order_name", np.array([hertz / tone for _, hertz in lines])),
        },
        coords={
            "body": _text([body["name"] for body in own]),
            "gear": _text([body["name"] for body in toothed]),
            "mesh": _text([mesh["name"] for mesh in pairs]),
            "stage": _text(["main"]),
            "link": _text([link[0] for link in links]),
            "direction": DIRECTIONS,
            "order_name": _text([name for name, _ in lines]),
        },
        verb="check",
        warnings=warnings,
        provenance=_provenance(gears),
    )
    return made.assign_attrs(
        values='[["stages.main.module", 0.032, "m", "assumed"], ["stages.main.sun.teeth", 23, "", "given"]]'
    )


def _provenance(gears: Gears) -> dict[str, str]:
    return {
        "title": gears.title,
        "doi": "10.1155/2021/5511817",
        "model": '{"format": 1, "title": "made up", "stages": {"main": {"planets": 3}}}',
        "assumed": '{"damping.modal": "not printed", "stages.main.module": "mass and J/r^2 fit; ISO 54 series"}',
    }


def _links(gears: Gears, own: list[dict[str, Any]]) -> list[tuple[str, str, str, list[float]]]:
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


def rows(gears: Gears) -> tuple[Array, Array, Array, list[str]]:
    """Mass (n,), rows B (n, p), stiffness (p,) and names (p,) of the model, all six coordinates of each body."""
    own = bodies(gears)
    place = {body["name"]: 6 * at for at, body in enumerate(own)}
    alpha, helix = gears.transverse, math.asin(math.sin(gears.helix) * math.cos(math.radians(20)))
    base = {name: value * math.cos(alpha) for name, value in gears.radius.items()}
    mass = np.zeros(6 * len(own))
    columns, stiffness, names = [], [], []
    for body in own:
        kind, at = body["kind"], place[body["name"]]
        reach = base.get(kind, gears.pin_radius)
        mass[at : at + 6] = [gears.mass[kind]] * 3 + [0.0, 0.0, gears.inertia[kind] * reach**2]
    for mesh in meshes(gears):
        n, a, b = _normal(mesh, alpha, helix), mesh["a"], mesh["b"]
        column = np.zeros(len(mass))
        kind_a, kind_b = a.split("/")[1], b.split("/")[1]
        for name, kind, sign in ((a, kind_a, 1.0), (b, kind_b, -1.0)):
            angle = own[place[name] // 6]["angle"]
            turn = np.array([math.cos(angle), math.sin(angle)])
            local = [n[0] * turn[0] + n[1] * turn[1], -n[0] * turn[1] + n[1] * turn[0], n[2]]
            spin = (
                mesh["flank"]
                * base[kind]
                * math.cos(helix)
                * (-1 if kind == kind_b and mesh["pair"] == "sun-planet" else 1)
            )
            column[place[name] : place[name] + 6] = sign * np.array([*local, 0.0, 0.0, spin])
        columns.append(column)
        stiffness.append(mesh["k"])
        names.append(mesh["name"])
    for link, first, second, values in _links(gears, own):
        for direction in (0, 1, 2, 5):
            k = values[direction]
            if k in (0.0, math.inf):
                continue
            columns.append(_link_row(len(mass), place, own, (first, second), direction, gears.pin_radius))
            stiffness.append(k)
            names.append(link)
    return mass, np.array(columns).T, np.array(stiffness), names


def _normal(mesh: Mapping[str, Any], alpha: float, helix: float) -> Array:
    psi, d = mesh["psi"], mesh["flank"]
    e, t = np.array([math.cos(psi), math.sin(psi)]), np.array([-math.sin(psi), math.cos(psi)])
    hand = (-1 if mesh["pair"] == "sun-planet" else 1) * (-1 if mesh["side"] == "right" else 1)
    across = math.cos(helix) * (math.sin(alpha) * e + d * math.cos(alpha) * t)
    return np.array([*across, -hand * d * math.sin(helix)])


def _link_row(
    size: int, place: Mapping[str, int], own: list[dict[str, Any]], ends: tuple[str, str], direction: int, pin: float
) -> Array:
    row = np.zeros(size)
    first, second = ends
    row[place[first] + direction] = 1.0
    if second:
        angle = own[place[second] // 6]["angle"]
        if direction < 2:
            unit = (
                np.array([math.cos(angle), math.sin(angle)])
                if direction == 0
                else np.array([-math.sin(angle), math.cos(angle)])
            )
            row[place[first] : place[first] + 2] = unit
            row[place[first] + 5] = pin if direction == 1 else 0.0
        row[place[second] + direction] = -1.0
    return row


def modes(gears: Gears) -> xr.Dataset:
    """The Dataset of `modes`, from the model above."""
    mass, B, k, names = rows(gears)
    own = bodies(gears)
    free = np.array([6 * at + DIRECTIONS.index(d) for at in range(len(own)) for d in gears.free])
    square, vectors = scipy.linalg.eigh((B[free] * k) @ B[free].T, np.diag(mass[free]))
    hertz = np.sqrt(np.abs(square)) / (2 * math.pi)
    hertz[hertz < 1e-3 * hertz[-1]] = np.where(
        hertz[hertz < 1e-3 * hertz[-1]] < 0.01, 0.0, hertz[hertz < 1e-3 * hertz[-1]]
    )
    full = np.zeros((len(mass), len(free)))
    full[free] = vectors
    strain = k[:, None] * (B.T @ full) ** 2
    kinetic = (mass[:, None] * full**2).reshape(len(own), 6, -1).sum(axis=1)
    base = {name: value * math.cos(gears.transverse) for name, value in gears.radius.items()}
    reach = np.ones((len(own), 6))
    reach[:, 5] = [base.get(body["kind"], gears.pin_radius) for body in own]
    shape = full.reshape(len(own), 6, -1) * reach[:, :, None]
    shape /= np.abs(shape).max(axis=(0, 1))
    links = list(dict.fromkeys(names))
    share = np.array([strain[[at for at, name in enumerate(names) if name == one]].sum(axis=0) for one in links])
    counts = [int(np.isclose(hertz, value, rtol=1e-5, atol=1e-3).sum()) for value in hertz]
    kinds = [{1: "rotational", 2: "translational"}.get(count, "planet") for count in counts]
    return dataset(
        {
            "frequency": ("mode", hertz),
            "angular_frequency": ("mode", 2 * math.pi * hertz),
            "mode_kind": ("mode", _text(kinds)),
            "multiplicity": ("mode", np.array(counts)),
            "shape": (("dof", "mode"), shape.reshape(len(mass), -1)[free]),
            "full_shape": (("body", "direction", "mode"), shape),
            "strain_energy_share": (("connection", "mode"), share / np.maximum(share.sum(axis=0), 1e-30)),
            "kinetic_energy_share": (("body", "mode"), kinetic / kinetic.sum(axis=0)),
            "damping_ratio": ("mode", np.full(len(hertz), 0.03)),
        },
        coords={
            "mode": np.arange(1, len(hertz) + 1),
            "dof": _text([f"{own[at // 6]['name']}/{DIRECTIONS[at % 6]}" for at in free]),
            "body": _text([body["name"] for body in own]),
            "direction": DIRECTIONS,
            "connection": _text(links),
        },
        verb="modes",
        options={"damped": False},
        provenance=_provenance(gears),
    ).assign_attrs(relative_speed=0.0)


def campbell(gears: Gears, found: xr.Dataset, tone: float = 27.3125) -> xr.Dataset:
    """A Campbell Dataset: double modes split with speed."""
    speed = np.linspace(0, 12, 49)
    hertz = found["frequency"].values
    split = np.where(found["multiplicity"].values == 2, 1.2, 0.0) * (-1.0) ** np.arange(len(hertz))
    return dataset(
        {
            "whirl_frequency": (("relative_speed", "mode"), hertz + speed[:, None] * split),
            "mesh_frequency": (("stage", "relative_speed"), tone * speed[None, :]),
        },
        coords={"relative_speed": speed, "mode": np.arange(1, len(hertz) + 1), "stage": _text(["main"])},
        verb="modes",
        provenance=_provenance(gears),
    )


def stiffness(gears: Gears) -> xr.Dataset:
    """Trapezoid-like stiffness of every mesh, shifted by its phase lead."""
    pairs = meshes(gears)
    phase = np.arange(256) / 256
    values = []
    for mesh in pairs:
        wave = sum(math.sin(1.2 * n) / n * np.cos(2 * math.pi * n * (phase + mesh["lead"])) for n in range(1, 8))
        values.append(mesh["k"] * (1 + 0.06 * wave))
    return dataset(
        {
            "mesh_stiffness": (("mesh", "mesh_phase"), np.array(values)),
            "mean_mesh_stiffness": ("mesh", _column(pairs, "k")),
        },
        coords={"mesh": _text([mesh["name"] for mesh in pairs]), "mesh_phase": phase},
        verb="stiffness",
        provenance=_provenance(gears),
    )


def sharing(gears: Gears, *, cycles: int = 23, tone: float = 27.3125) -> xr.Dataset:
    """Load-sharing histories like those of eccentric gears."""
    pairs = meshes(gears)
    time = np.arange(cycles * 64) / (64 * tone)
    theta = time * tone
    ratio = np.array(
        [
            1
            + 0.05 * np.cos(2 * math.pi * theta / 23 - mesh["psi"])
            + 0.02 * np.cos(2 * math.pi * theta / 17 + mesh["psi"])
            + 0.008 * np.cos(2 * math.pi * (theta + mesh["lead"]))
            for mesh in pairs
        ]
    )
    force = 48.2e3 * ratio
    names = ["peak_per_cycle", "simultaneous", "record_peak", "overload", "hunting_worst"]
    peak = ratio.max(axis=1)
    table = np.array([peak * factor for factor in (0.995, 1.0, 1.002, 0.998, 1.03)])
    return dataset(
        {
            "load_sharing": (("definition", "mesh"), table),
            "system_load_sharing": ("definition", table.max(axis=1)),
            "load_sharing_history": (("mesh", "time"), ratio),
            "mesh_force": (("mesh", "time"), force),
            "contact_lost": ("mesh", np.zeros(len(pairs), dtype=bool)),
            "mesh_force_bound": ("mesh", force.max(axis=1) * 1.05),
        },
        coords={"mesh": _text([mesh["name"] for mesh in pairs]), "time": time, "definition": _text(names)},
        verb="sharing",
        options={"method": "steady", "window": f"{cycles} mesh cycles"},
        warnings=["load sharing is that of 23 mesh cycles, the record is shorter than the hunting period of 22287"],
        provenance=_provenance(gears),
    )


def sweep(gears: Gears, found: xr.Dataset, *, tone: float = 27.3125, points: int = 200) -> xr.Dataset:
    """Resonance curves through the natural frequencies."""
    pairs = meshes(gears)
    hertz = np.linspace(20, 600, points)
    natural = found["frequency"].values[found["frequency"].values > 1]
    rms = np.zeros((len(pairs), points))
    for at, mesh in enumerate(pairs):
        for mode, value in enumerate(natural):
            r = hertz / value
            share = 0.3 + 0.7 * math.cos(mode + mesh["branch"] * (found["multiplicity"].values[mode + 1] > 1)) ** 2
            rms[at] += 900 * share / np.sqrt((1 - r**2) ** 2 + (0.06 * r) ** 2) / (1 + mode)
    status = np.full(points, "ok", dtype="<U20")
    status[120] = "not converged"
    rms[:, 120] = np.nan
    return dataset(
        {
            "mesh_force_rms": (("mesh", "speed"), rms),
            "mesh_force_peak": (("mesh", "speed"), 48.2e3 + 1.6 * rms),
            "mesh_force_minimum": (("mesh", "speed"), 48.2e3 - 1.6 * rms),
            "status": ("speed", status),
            "harmonics": ("speed", np.full(points, 12)),
            "residual": ("speed", np.full(points, 1e-9)),
            "mesh_frequency": ("speed", hertz),
        },
        coords={"mesh": _text([mesh["name"] for mesh in pairs]), "speed": hertz / tone},
        verb="sweep",
        units={"speed": "1"},
        provenance=_provenance(gears),
    )


def everything(gears: Gears) -> dict[str, xr.Dataset]:
    """All Datasets of one train; without speeds those that need none."""
    warnings = [
        "stages.main.planets = 3: cannot be assembled at equal spacing, (23 + 57)/3; nearest 0, 121.5, 238.5 deg"
    ]
    found = {"check": check(gears, warnings=warnings), "modes": modes(gears), "stiffness": stiffness(gears)}
    if not math.isfinite(gears.sun_speed):
        return found
    found["campbell"] = campbell(gears, found["modes"])
    found["sharing"] = sharing(gears)
    found["sweep"] = sweep(gears, found["modes"])
    return found
