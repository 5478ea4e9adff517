"""Steady response at one speed as a labelled Dataset."""

from __future__ import annotations

from collections.abc import Hashable
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...engine.cost import MOST_NUMBERS, require_memory
from ...errors import ModelError
from ...statics.record import idle_warnings, parallel_meshes
from ...statics.static import rounding_of
from ...statics.tangent import linear
from ...system.system import Array, ComplexArray, System, faces
from ...warning_codes import CodedText, coded
from .lattice import on_axis
from .measures import dynamic_factor, force_extremes, link_measures, mean, mean_square
from .periodic import TOLERANCE, checked_samples, solve_speed
from .response import Block, Response
from .superposition import superposed
from .table import with_bounds_named
from .waveform import (
    Spectrum,
    alias_free_samples,
    force_signal,
    lateral_pairs,
    link_signal,
    mesh_axis,
    motion_signal,
    tone_waveform,
    torus_waveform,
    whole_mesh_signal,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["factor_warnings", "steady", "tension_warnings"]


def steady(
    system: System,
    *,
    relative_speed: float = 1.0,
    samples: int = 64,
    method: Literal["exact", "superposition"] = "exact",
) -> xr.Dataset:
    """Steady response at one speed as a Dataset: forces and displacements over the mesh phase, harmonics, lines.

    With several mesh frequencies a mesh force over the mesh phase is its part at multiples of the mesh's own tone, a
    displacement that at multiples of the first mesh's; ``combination_force`` and ``combination_displacement`` hold
    every multiple and combination of them, and RMS, bound and minimum count them all.

    Parameters
    ----------
    relative_speed : speed per operating speed, above zero.  samples : of the mesh phase in the result.
    method : ``exact``, or ``superposition``: every frequency alone on the mean system, see `superposed`.

    Returns
    -------
    Variables and units of docs/theory/response.md: forces [N, N m], displacements [m].

    Raises
    ------
    ModelError, ConvergenceError : as of `periodic`.
    """
    from ...results.dataset import dataset

    if method not in ("exact", "superposition"):
        raise ModelError("no such method", path="method", given=method, allowed="exact, superposition")
    # complex signals of the meshes, displacements and links at all samples at once
    width = 4 * (len(system.dofs.names) + len(system.meshes.name) + len(system.links.name))
    most = f"at most {MOST_NUMBERS // width}"
    require_memory(float(checked_samples(samples)) * width, path="samples", given=samples, allowed=most)
    theta = np.arange(samples) / samples
    ready, block = solve_speed(
        system if method == "exact" else superposed(linear(system), relative_speed), relative_speed, TOLERANCE
    )
    system = ready.system
    face, axis = faces(system.meshes), mesh_axis(ready)
    rows, moved = force_signal(ready, block), motion_signal(ready, block)
    every, motion = whole_mesh_signal(rows, face), moved.orders
    force, shafts = every.orders, every.lines
    low, high = force_extremes(every, axis=axis)
    lowest = force_extremes(rows, axis=ready.lines.axis)[0] if face.cut.any() else low
    factor = dynamic_factor(high, mean(every), parallel_meshes(system.meshes), rounding_of(system))
    radius = system.dofs.radius[:, None]
    combined, labels = _combinations(ready, force, motion, relative_speed)
    result = dataset(
        {
            "mesh_force": (("mesh", "mesh_phase"), _by_mesh(ready, force, theta)[:, 0].real),
            "displacement": (("dof", "mesh_phase"), radius * tone_waveform(motion, 0, theta)[:, 0, 0].real),
            "mesh_force_harmonic": (("mesh", "harmonic"), _harmonics(ready, force, block.harmonics)),
            "displacement_harmonic": (
                ("dof", "harmonic"),
                radius * _orders(motion, 0, block.harmonics + _stiffness_harmonics(ready)),
            ),
            **combined,
            "mesh_force_rms": ("mesh", np.sqrt(mean_square(every)[:, 0])),
            "mesh_force_bound": ("mesh", high[:, 0]),
            "mesh_force_minimum": ("mesh", low[:, 0]),
            "dynamic_factor": ("mesh", factor[:, 0]),
            **_link_variables(ready, block, theta),
            **_line_variables(ready, block, shafts, theta),
            "residual": ((), block.residual[0]),
        },
        {
            "mesh": list(face.name),
            "dof": list(system.dofs.names),
            **_link_names(system),
            "mesh_phase": theta,
            "harmonic": np.arange(block.harmonics + _stiffness_harmonics(ready) + 1),
            **labels,
            "line": np.array(["; ".join(shaft.causes) for shaft in ready.lines.shaft], dtype=object),
            "mesh_frequency": float(ready.lines.tone) * relative_speed,
        },
        verb="steady",
        options={"method": method, "relative_speed": relative_speed, "samples": samples, "harmonics": block.harmonics},
        provenance=system.provenance,
        warnings=[*system.warnings, *tension_warnings(system, lowest, factor), *factor_warnings(system, factor)],
    )
    return with_bounds_named(result, len(ready.lines.tones))


def _link_variables(ready: Response, block: Block, theta: Array) -> dict[str, Any]:
    """Link forces at multiples of the first mesh frequency over theta (Nt,), and their measures over all
    frequencies.
    """
    if not ready.system.links.name:
        return {}
    links, pairs = link_signal(ready, block), lateral_pairs(ready.system)
    found = {name: values[:, 0] for name, values in link_measures(links, pairs, ready.system.links.turn).items()}
    by_bearing = {
        name: ("bearing", values) for name, values in found.items() if name.startswith("bearing") and values.size
    }
    return {
        "link_force": (("link_row", "mesh_phase"), tone_waveform(links.orders, 0, theta)[:, 0, 0].real),
        "link_force_harmonic": (
            ("link_row", "harmonic"),
            _orders(links.orders, 0, block.harmonics + _stiffness_harmonics(ready)),
        ),
        **{name: ("link_row", values) for name, values in found.items() if name.startswith("link")},
        **by_bearing,
    }


def _link_names(system: System) -> dict[Hashable, Any]:
    """Coordinates of the link rows and of the bearings."""
    links, pairs = system.links, lateral_pairs(system)
    names: dict[Hashable, Any] = {"link_row": list(links.name)} if links.name else {}
    return {**names, "bearing": [links.link[x] for x in pairs[:, 0]]} if len(pairs) else names


def tension_warnings(system: System, lowest: Array, factor: Array) -> list[CodedText]:
    """Warning where the linear model pulls on teeth that carry load, or on any where none do.

    lowest : smallest force of every mesh row at every speed, (rows, P) [N].  factor : K_v of the meshes (m, P) [1].
    """
    carried = _with_factor(system, factor) if np.isfinite(factor).any() else np.ones(len(factor), dtype=bool)
    pulled = (np.nan_to_num(lowest, nan=np.inf) < 0) & carried[faces(system.meshes).row, None]
    if not pulled.any():
        return []
    names = [name for name, row in zip(system.meshes.name, pulled, strict=True) if row.any()]
    listed = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
    points = int(pulled.any(axis=0).sum())
    where = f" at {points} of {pulled.shape[1]} speeds" if pulled.shape[1] > 1 else ""
    return [
        coded(
            "tension-in-teeth", f"tensile mesh force in the linear model{where}: the teeth of {listed} would separate"
        )
    ]


def factor_warnings(system: System, factor: Array) -> list[CodedText]:
    """A warning of the pairs of gears without a K_v (m, P) at any speed, where another pair has one."""
    loaded = _with_factor(system, factor)
    return idle_warnings(faces(system.meshes).name, loaded, "dynamic factor K_v") if loaded.any() else []


def _with_factor(system: System, factor: Array) -> NDArray[np.bool_]:
    """Meshes (m,) of pairs of gears that have a K_v (m, P) at any speed."""
    known = np.asarray(np.isfinite(factor).any(axis=1))
    loaded = np.zeros_like(known)
    for group in parallel_meshes(system.meshes):
        loaded[group] = known[group].any()
    return loaded


def _stiffness_harmonics(ready: Response) -> int:
    """Number of harmonics of the mesh stiffness."""
    return int(ready.system.meshes.variation.shape[1])


def _by_mesh(ready: Response, spectrum: Spectrum, theta: Array) -> NDArray[Any]:
    """Multiples of each mesh's own tone over its phase theta (Nt,), (m, S, Nt)."""
    return _own_tone(ready, [tone_waveform(spectrum, axis, theta)[:, 0] for axis in range(len(ready.lines.tones))])


def _orders(spectrum: Spectrum, axis: int, harmonics: int) -> ComplexArray:
    """One-sided harmonics 0..H of one tone, (rows, H + 1): value = Re sum harmonic_h exp(2 pi i h theta)."""
    own, orders = on_axis(spectrum.points, axis), spectrum.points[:, axis]
    result = np.zeros((spectrum.amplitude.shape[0], harmonics + 1), complex)
    known = own & (orders <= harmonics)
    result[:, orders[known]] = spectrum.amplitude[:, 0, 0, known]
    return result


def _harmonics(ready: Response, force: Spectrum, highest: int) -> ComplexArray:
    """Harmonics of each mesh force in its own tone, (m, H + L + 1) [N]."""
    return _own_tone(
        ready, [_orders(force, axis, highest + _stiffness_harmonics(ready)) for axis in range(len(ready.lines.tones))]
    )


def _own_tone(ready: Response, by_axis: list[NDArray[Any]]) -> NDArray[Any]:
    """Of arrays (m, ..) of every tone the rows of each mesh's own tone, (m, ..)."""
    axis = mesh_axis(ready)
    result: NDArray[Any] = np.array(by_axis)[axis, np.arange(len(axis))]
    return result


def _combinations(
    ready: Response, force: Spectrum, motion: Spectrum, speed: float
) -> tuple[dict[str, Any], dict[Hashable, Any]]:
    """Amplitudes of all lattice points kept where there are several tones: variables and coordinates."""
    tones = ready.lines.tones
    if len(tones) == 1:
        return {}, {}
    points = motion.points
    exact = [sum((a * f for a, f in zip(p, tones, strict=True)), Fraction(0)) for p in points.tolist()]
    names = ready.lines.stages(ready.system)
    labels = [" ".join(f"{a:+d} {n}" for a, n in zip(p, names, strict=True) if a) or "mean" for p in points.tolist()]
    radius = ready.system.dofs.radius[:, None]
    return {
        "combination_force": (("mesh", "combination"), force.amplitude[:, 0, 0, : len(points)]),
        "combination_displacement": (("dof", "combination"), radius * motion.amplitude[:, 0, 0]),
        "combination_frequency": ("combination", speed * np.array([float(f) for f in exact])),
    }, {"combination": np.array(labels, dtype=object)}


def _line_variables(ready: Response, block: Block, shafts: Spectrum | None, theta: Array) -> dict[str, Any]:
    """Shaft lines: envelopes over each mesh's own phase theta (Nt,), and largest amplitudes over all phases [N]."""
    m, count = len(mesh_axis(ready)), len(ready.lines.shaft)
    speed = float(block.speed[0])
    force, largest = np.zeros((m, count, theta.size), complex), np.zeros((m, count))
    if shafts is not None:
        force = _by_mesh(ready, shafts, theta)
        grid = [
            max(128 if len(ready.lines.tones) == 1 else 32, alias_free_samples(ready, H)) for H in block.truncation[:-1]
        ]
        values = np.abs(torus_waveform(shafts, grid, block.truncation[-1])[:, 0])
        largest = values.reshape(m, count, -1).max(axis=2)
    return {
        "line_force": (("mesh", "line", "mesh_phase"), force),
        "line_amplitude": (("mesh", "line"), largest),
        "line_frequency": ("line", np.array([float(shaft.frequency) * speed for shaft in ready.lines.shaft])),
    }
