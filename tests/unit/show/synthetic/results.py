"""Datasets as the analyses give them, for the made-up trains: numbers are invented, names and shapes are not."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from epicyclic.results.dataset import dataset
from epicyclic.warning_codes import coded

from .tolerances import allocation, tolerance
from .train import DIRECTIONS, REN, Gears, array, bodies, check, lin_gears, links_of, meshes, provenance

__all__ = ["REN", "Gears", "check", "dataset", "everything", "lin_gears", "modes", "sharing"]

Array = NDArray[np.float64]


def _kinds(gears: Gears) -> list[tuple[str, int]]:
    """Kind and multiplicity of each frequency, rising: as many modes as the model has degrees of freedom."""
    count = len(bodies(gears)) * len(gears.free)
    planet = [("planet", gears.planets - 3)] if gears.planets > 3 else []
    found: list[tuple[str, int]] = [("rotational", 1)]
    pattern = [("translational", 2), ("rotational", 1), *planet, ("translational", 2)]
    while sum(several for _, several in found) < count:
        found.append(pattern[(len(found) - 1) % len(pattern)])
    found[-1] = (found[-1][0], found[-1][1] - (sum(several for _, several in found) - count))
    return found


def _made_up_shape(gears: Gears, kind: str, mode: int) -> Array:
    """(body, 6): central bodies turn and slide, move sideways, or rest; planets follow by their angle."""
    draw = np.random.default_rng(mode)
    shape = np.zeros((len(bodies(gears)), 6))
    own, free = draw.uniform(-1, 1, (4, 6)), [DIRECTIONS.index(one) for one in gears.free]
    for row, body in enumerate(bodies(gears)):
        which = ["sun", "ring", "carrier", "planet"].index(body["kind"])
        wave = {"rotational": 1.0, "translational": math.cos(body["angle"] + mode)}.get(kind, (-1.0) ** body["branch"])
        shape[row, free] = own[which][free]
        if which == 3:
            shape[row] *= wave
        elif kind == "planet":
            shape[row] = 0.0
        else:
            shape[row, [0, 1] if kind == "rotational" else [2, 5]] = 0.0
            shape[row, 2] *= -1 if body["side"] == "right" else 1
    shape /= np.abs(shape).max()
    return shape


def modes(gears: Gears) -> xr.Dataset:
    """The Dataset of `modes`."""
    listed = [kind for kind in _kinds(gears) for _ in range(kind[1])]
    steps = np.repeat(np.arange(len(_kinds(gears))), [several for _, several in _kinds(gears)])
    hertz = 86.68 * steps**1.1
    names = list(
        dict.fromkeys([mesh["name"] for mesh in meshes(gears)] + [link[0] for link in links_of(gears, bodies(gears))])
    )
    shape = np.stack([_made_up_shape(gears, kind, mode) for mode, (kind, _) in enumerate(listed)], axis=-1)
    strain = np.random.default_rng(1).uniform(0, 1, (len(names), len(listed))) ** 6
    kinetic = np.square(shape).sum(axis=1)
    free = [DIRECTIONS.index(one) for one in gears.free]
    return dataset(
        {
            "frequency": ("mode", hertz),
            "mode_kind": ("mode", array(kind for kind, _ in listed)),
            "multiplicity": ("mode", np.array([several for _, several in listed])),
            "shape": (("dof", "mode"), shape[:, free].reshape(-1, len(listed))),
            "full_shape": (("body", "direction", "mode"), shape),
            "strain_energy_share": (("connection", "mode"), strain / strain.sum(axis=0)),
            "kinetic_energy_share": (("body", "mode"), kinetic / kinetic.sum(axis=0)),
            "damping_ratio": ("mode", np.full(len(hertz), 0.03)),
        },
        coords={
            "mode": np.arange(1, len(hertz) + 1),
            "dof": array(f"{body['name']}/{one}" for body in bodies(gears) for one in gears.free),
            "body": array(body["name"] for body in bodies(gears)),
            "direction": DIRECTIONS,
            "connection": array(names),
        },
        verb="modes",
        options={"damped": False},
        provenance=provenance(gears),
    )


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
        coords={"relative_speed": speed, "mode": np.arange(1, len(hertz) + 1), "stage": np.array(["main"])},
        verb="campbell",
        provenance=provenance(gears),
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
            "mean_mesh_stiffness": ("mesh", array(mesh["k"] for mesh in pairs)),
        },
        coords={"mesh": array(mesh["name"] for mesh in pairs), "mesh_phase": phase},
        verb="stiffness",
        provenance=provenance(gears),
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
        coords={"mesh": array(mesh["name"] for mesh in pairs), "time": time, "definition": array(names)},
        verb="sharing",
        options={"method": "steady", "window": f"{cycles} mesh cycles"},
        warnings=[
            coded("short-record", "load sharing is that of 23 mesh cycles, shorter than the hunting period of 22287")
        ],
        provenance=provenance(gears),
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
    bearings = [f"main/planet/{i}/bearing" for i in dict.fromkeys(mesh["branch"] for mesh in pairs)]
    bearings += ["main/sun/support", "main/ring/left/support", "main/ring/right/support"]
    radial = np.array([165e3 + 3 * rms[0]] * (len(bearings) - 3) + [0.5 * rms[0], 0.8 * rms[1], 0.8 * rms[1]])
    orders = np.stack([rms * math.sqrt(2) / order**2 for order in range(1, 13)], axis=1)
    return dataset(
        {
            "mesh_force_rms": (("mesh", "speed"), rms),
            "mesh_force_peak": (("mesh", "speed"), 48.2e3 + 1.6 * rms),
            "mesh_force_minimum": (("mesh", "speed"), 48.2e3 - 1.6 * rms),
            "dynamic_factor": (("mesh", "speed"), 1 + 1.6 * rms / 48.2e3),
            "mesh_force_order": (("mesh", "order", "speed"), orders),
            "mesh_force_line": (("mesh", "line", "speed"), 0.1 * orders[:, :2]),
            "bearing_force_peak": (("bearing", "speed"), radial),
            "bearing_force_rms": (("bearing", "speed"), 0.1 * radial),
            "status": ("speed", status),
            "harmonics": ("speed", np.full(points, 12)),
            "residual": ("speed", np.full(points, 1e-9)),
            "mesh_frequency": ("speed", hertz),
        },
        coords={
            "mesh": array(mesh["name"] for mesh in pairs),
            "speed": hertz / tone,
            "order": np.arange(1, 13),
            "line": array(["deviations.main.sun.run_out", "deviations.main.sun.run_out +1 mesh"]),
            "line_order": ("line", [0.0435, 1.0435]),
            "mesh_tone": ("mesh", np.ones(len(pairs))),
            "bearing": array(bearings),
        },
        verb="sweep",
        units={"speed": "1"},
        provenance=provenance(gears),
    )


def everything(gears: Gears) -> dict[str, xr.Dataset]:
    """All Datasets of one train; without speeds those that need none."""
    warnings = [
        coded(
            "not-assembled",
            "stages.main.planets = 3: cannot be assembled at equal spacing, (23 + 57)/3; nearest 0, 121.5, 238.5 deg",
        )
    ]
    found = {"check": check(gears, warnings=warnings), "modes": modes(gears), "stiffness": stiffness(gears)}
    if not math.isfinite(gears.sun_speed):
        return found
    found["campbell"] = campbell(gears, found["modes"])
    found["sharing"] = sharing(gears)
    found["sweep"] = sweep(gears, found["modes"])
    found["tolerance"], found["allocate"] = tolerance(), allocation()
    return found
