"""Natural frequencies, kinds, shapes and energy shares of a train, as a labelled Dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...system.system import Array, System
from ..static.tangent import linearised
from .eigen import damping_ratios, eigen, whirl
from .energy import connections, kinetic_energy_share, strain_energy_share
from .kinds import Sorted, normalised, sort_modes

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "modal",
]

_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


def modal(system: System, *, relative_speed: float = 0.0, damped: bool = False) -> xr.Dataset:
    """Natural frequencies and modes of the mean system, all repeated roots included.

    At standstill and undamped the shapes are real; otherwise they are complex: the motion of a coordinate is
    Re(shape exp(2 pi i frequency t)), decaying with the damping ratio.  Shapes have their largest component at 1
    (torsion as u = R rz); modes of one frequency have a fixed basis, see `kinds.canonical`.  A rigid mode has
    frequency exactly 0 and no strain energy (share nan).

    Parameters
    ----------
    system : where links have laws, their tangents at the mean load stand for them (`linear.linearised`).
    relative_speed : speed per operating speed [1]; other than 0 brings in the gyroscopic and centripetal terms.
    damped : solve the damped problem.  Undamped, damping ratios are the modal projection at standstill (nan without
        damping) and nan at speed.

    Raises
    ------
    ModelError : mass or inertia missing, an unstable mean system, or no damping where it is asked for.
    """
    system = linearised(system)
    modes = eigen(system)
    if relative_speed == 0 and not damped:
        values: NDArray[np.inexact] = modes.omega_squared
        angular, growth = modes.omega, np.zeros(len(values))
        ratios = damping_ratios(system, modes)
        vectors: NDArray[np.inexact] = modes.vectors
    else:
        result = whirl(system, relative_speed=relative_speed, damped=damped, modes=modes)
        values, vectors, angular, growth = result.mu, result.vectors, result.mu.imag, result.mu.real
        ratios = _ratios(result.mu) if damped else np.full(len(angular), np.nan)
    options = {"relative_speed": float(relative_speed), "damped": bool(damped)}
    kinds = sort_modes(system, values, vectors)
    return _dataset(system, angular, ratios, kinds, np.abs(values) == 0, options, _growing(growth, angular))


def _ratios(mu: NDArray[np.complex128]) -> Array:
    """Damping ratio of complex eigenvalues, nan for rigid modes."""
    size = np.abs(mu)
    return np.where(size > 0, -mu.real / np.where(size > 0, size, 1.0), np.nan)


def _growing(growth: Array, angular: Array) -> tuple[str, ...]:
    """A warning where a mode grows; 1e-6 of the largest frequency is rounding of a defective root."""
    worst = float(np.max(growth, initial=0.0))
    if worst <= 1e-6 * float(np.max(angular, initial=0.0)):
        return ()
    return (f"a mode grows at {worst:.4g} 1/s: the train is unstable at this speed",)


def _dataset(
    system: System,
    angular: Array,
    ratios: Array,
    kinds: Sorted,
    rigid: NDArray[np.bool_],
    options: dict[str, float | bool],
    warnings: Sequence[str],
) -> xr.Dataset:
    from ...results.dataset import dataset

    dofs = system.dofs
    vectors = kinds.vectors * normalised(kinds.vectors, dofs.radius)
    radius = _body_radius(system)
    full = (dofs.expand @ vectors).reshape(len(dofs.bodies), 6, -1)
    full[:, 5] *= radius[:, None]
    result = dataset(
        {
            "frequency": ("mode", angular / (2 * np.pi)),
            "angular_frequency": ("mode", angular),
            "mode_kind": ("mode", np.array(kinds.kind, dtype=object)),
            "multiplicity": ("mode", kinds.multiplicity),
            "shape": (("dof", "mode"), vectors * dofs.radius[:, None]),
            "full_shape": (("body", "direction", "mode"), full),
            "strain_energy_share": (("connection", "mode"), strain_energy_share(system, vectors, rigid)),
            "kinetic_energy_share": (("body", "mode"), kinetic_energy_share(system, vectors)),
            "damping_ratio": ("mode", ratios),
        },
        {
            "mode": np.arange(1, len(angular) + 1),
            "dof": np.array(dofs.names, dtype=object),
            "body": np.array(dofs.bodies, dtype=object),
            "direction": np.array(_DIRECTIONS, dtype=object),
            "connection": np.array(connections(system), dtype=object),
            "reference_radius": ("body", radius),
        },
        verb="modes",
        options=options,
        provenance=system.provenance,
        warnings=(*system.warnings, *warnings),
    )
    result["reference_radius"].attrs.update({"units": "m", "long_name": "reference radius R of u = R rz"})
    result.attrs["relative_speed"] = float(options["relative_speed"])
    return result


def _body_radius(system: System) -> Array:
    """R of each body's u = R rz, (nb,) [m]; 1 where rz is not a coordinate of its own."""
    dofs = system.dofs
    own = {b: R for b, d, R in zip(dofs.body, dofs.direction, dofs.radius, strict=True) if d == "rz"}
    return np.array([own.get(body, 1.0) for body in dofs.bodies])
