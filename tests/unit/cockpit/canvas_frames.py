"""Frames for the panes, of which the drawing alone is computed: a planetary set, its modes, a sweep, sharing, jobs."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from epicyclic import load
from epicyclic.cockpit.computing.train_view import train_head
from epicyclic.cockpit.state.frames import body_labels, mesh_labels

Numbers = NDArray[np.float64]


def packed(rev: int, kind: str, head: Mapping[str, Any], arrays: Mapping[str, Numbers]) -> bytes:
    """A frame as it travels, written here a second time from its definition."""
    table, numbers, offset = [], b"", 0
    for name, array in arrays.items():
        table.append([name, list(array.shape), offset])
        numbers += array.astype("<f4").tobytes()
        offset += array.size
    text = json.dumps({"rev": rev, "kind": kind, "head": head, "arrays": table}).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<I", len(text)) + text + numbers


@cache
def _drawn(planets: int) -> Mapping[str, Any]:
    turning = {"operation.speed.sun": "1000 rpm", "stages.main.sun.support.radial": 0, "stages.main.module": "10 mm"}
    numbers = (21, 39, 99) if planets < 5 else (51, 24, 99)  # five larger ones would collide
    teeth = {f"stages.main.{name}.teeth": z for name, z in zip(("sun", "planet", "ring"), numbers, strict=True)}
    model = load(
        "industrial-stage", {**turning, **teeth, "stages.main.planets": planets, "deviations.planet.position.y": 0}
    )
    return train_head(model, body_labels(model), mesh_labels(model))


def train(planets: int = 3, *, title: str = "a planetary set") -> dict[str, Any]:
    """Bodies, meshes and display lists of a planetary set of module 10, its ring held and its sun floating [mm]."""
    return {**_drawn(planets), "title": title}


def live(
    rev: int,
    *,
    scale: float = 1.0,
    planets: int = 3,
    seed: int = 1,
    title: str = "a planetary set",
    resonance: Mapping[str, Any] | None = None,
) -> bytes:
    """A frame of the live set; `scale` multiplies the forces of the sweep, `resonance` is in the answer on it."""
    drawn = train(planets, title=title)
    rng = np.random.default_rng(seed)
    count, bodies = len(drawn["meshes"]), len(drawn["bodies"])
    load = 1 + 0.12 * rng.standard_normal(count)
    frequency = np.sort(rng.uniform(90, 2400, 14))
    shape = rng.uniform(-1, 1, (14, bodies, 6)) * rng.choice([0.02, 1], (14, bodies, 1))
    shape /= np.abs(shape).max(axis=(1, 2), keepdims=True)
    modes = [
        {
            "index": i,
            "frequency": float(f),
            "label": f"planets 1-{planets} rotate against the sun",
            "body": "",
            "met_by": "",
        }
        for i, f in enumerate(frequency)
    ]
    return packed(
        rev,
        "live",
        {
            "train": drawn,
            "answers": [{"key": "resonance", **(resonance or {})}],
            "modes": modes,
            "sweep": sweep_head(drawn, 120, scale)[0],
            "sharing": sharing_head(drawn, "at rest", load),
        },
        {
            "meshes/load": load,
            "modes/frequency": frequency,
            "modes/shape": shape,
            **sweep_head(drawn, 120, scale)[1],
            "sharing/coefficient": load,
            "sharing/twin": 1 + (load - 1) / 4,
        },
    )


def sweep_head(drawn: Mapping[str, Any], points: int, scale: float) -> tuple[dict[str, Any], dict[str, Numbers]]:
    """A sweep of so many speeds with five peaks."""
    x = np.linspace(50, 1600, points)
    centres, heights = np.array([180, 420, 520, 760, 1230.0]), np.array([90, 140, 60, 210, 120.0])
    rise = [
        70
        + 0.8 * i
        + sum(h * (1 - 0.07 * i) / (1 + ((x - c) / 24) ** 2) for h, c in zip(heights, centres, strict=True))
        for i in range(len(drawn["meshes"]))
    ]
    y = scale * np.array(rise)
    y[0, 3] = np.nan
    curves = [{"label": mesh["label"], "mesh": i, "strong": i < 4} for i, mesh in enumerate(drawn["meshes"])]
    names = [
        "sun moves, planet 2",
        "planets 1-3 rotate",
        "ring moves",
        "sun against carrier, all planets",
        "planets swing",
    ]
    peaks = [
        {"x": float(c), "y": float(scale * (h + 74)), "label": name, "mode": i, "count": 1}
        for i, (c, h, name) in enumerate(zip(centres, heights, names, strict=True))
    ]
    head = {
        "x_label": "speed of the sun [rpm]",
        "y_label": "largest mesh force [kN]",
        "operating": 1000.0,
        "stage": "mesh orders",
    }
    return {**head, "curves": curves, "peaks": peaks, "range": [50, 1600], "to_relative": 1e-3}, {
        "sweep/x": x,
        "sweep/y": y,
    }


def sharing_head(drawn: Mapping[str, Any], stage: str, load: Numbers) -> dict[str, Any]:
    """The head of load sharing."""
    rows = [
        {"label": mesh["label"], "mesh": i, "pair": mesh["name"].split("/")[1]}
        for i, mesh in enumerate(drawn["meshes"])
    ]
    twin = {"label": "with a floating sun", "k_gamma": float(1 + (load.max() - 1) / 4)}
    return {
        "definition": "mean load",
        "stage": stage,
        "rows": rows,
        "k_gamma": float(load.max()),
        "cycles": 1287,
        "twin": twin,
    }


def full(rev: int, *, planets: int = 3, seed: int = 1) -> list[bytes]:
    """The frames after a slider is let go: sweep, sharing and errors."""
    drawn = train(planets)
    rng = np.random.default_rng(seed)
    load = 1 + 0.12 * rng.standard_normal(len(drawn["meshes"]))
    cycle = np.arange(256)
    period = load[:, None] * (1 + 0.06 * np.sin(2 * np.pi * cycle / 64 + np.arange(load.size)[:, None]))
    head, arrays = sweep_head(drawn, 60, 1.0)
    names = [
        "pin of planet 1, 20 um",
        "run-out of the sun, 18 um",
        "run-out of planet 2, 22 um",
        "run-out of the ring, 50 um",
    ]
    share = np.array([46.0, 31.0, 14.0, 9.0])
    rows = [{"label": name, "path": "deviations", "share": float(one)} for name, one in zip(names, share, strict=True)]
    sharing = {"sharing/coefficient": load, "sharing/twin": 1 + (load - 1) / 4, "sharing/over_period": period}
    return [
        packed(rev, "sweep", {"sweep": {**head, "stage": "with shaft orders"}}, arrays),
        packed(rev, "sharing", {"sharing": sharing_head(drawn, "whole", load)}, sharing),
        packed(rev, "errors", {"errors": {"rows": rows, "of": "mean-load K_gamma"}}, {"errors/share": share}),
    ]


def job(rev: int, name: str, *, answers: Sequence[Mapping[str, Any]] = ()) -> bytes:
    """A frame of a job: lines for ``contact``, bars for every other name; with the answers that it has found."""
    plain = {"name": name, "title": "Transmission error under load", "text": "", "apply": None, "apply_label": ""}
    found = {"answers": list(answers)} if answers else {}
    if name == "contact":
        x = np.linspace(0, 1, 64)
        curves = [{"label": label, "strong": True} for label in ("as it is", "with tip relief")]
        lines = {"x_label": "mesh cycle [1]", "y_label": "transmission error [um]", "curves": curves}
        y = np.array([12 + 3 * np.sin(2 * np.pi * x), 11 + 0.8 * np.sin(2 * np.pi * x)])
        return packed(rev, "job", {"job": {**plain, "lines": lines}, **found}, {"job/x": x, "job/y": y})
    bars = {"x_label": "share of the variance [%]", "rows": [f"pin of planet {i + 1}" for i in range(5)], "line": 20.0}
    return packed(rev, "job", {"job": {**plain, "bars": bars}, **found}, {"job/bar": np.array([38, 25, 17, 12, 8.0])})
