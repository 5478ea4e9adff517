"""Whether the mean system has a steady motion at a speed: centripetal terms may exceed the stiffness (derived here).

In the turning axes of a carrier a body of mass m loses s^2 m Omega^2 of its stiffness.  Where K + s^2 Kg is positive
definite the mean deflection is unique and nothing drives a vibration.  At the first speed where it is singular the mean
deflection has a pole, the critical speed of the whirling body; beyond it dampers that turn with the body drive it, and
only the eigenvalues tell whether others hold it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...errors import ConvergenceError
from ...questions.modes.eigen import eigen, whirl
from ...system.system import Array
from ...warning_codes import CodedText, coded
from .response import Response

__all__ = ["MEAN_UNSTABLE", "critical_speed", "instability_warnings", "require_stable_mean", "unstable_speeds"]

MEAN_UNSTABLE = "mean system unstable"
"""Status of a speed without a steady motion."""

# Growth per largest |mu| that is more than rounding of a double eigenvalue (1e-8).
_GROWTH = 1e-7
_FASTEST = 1e50


def critical_speed(ready: Response) -> tuple[float, str]:
    """Least relative speed at which K + s^2 Kg is singular beside rigid motions, inf where none; and who moves most.

    Returns
    -------
    (relative speed [1], name of a coordinate, "" where there is none).
    """
    system, shapes, centripetal = ready.system, _elastic_shapes(ready), _centripetal(ready)
    if not centripetal.any():
        return math.inf, ""
    values, vectors = np.linalg.eigh(centripetal)
    if values[0] >= 0:
        return math.inf, ""
    motion = np.abs(system.dofs.radius * (shapes @ vectors[:, 0]))
    return float(1 / math.sqrt(-values[0])), system.dofs.names[int(np.argmax(motion))]


def _elastic_shapes(ready: Response) -> Array:
    """Shapes (n, e) of the elastic modes, of unit strain energy."""
    shapes: Array = ready.modal.shapes[:, ~ready.modal.rigid]
    return shapes


def _centripetal(ready: Response) -> Array:
    """Kg of the elastic modes per their stiffness, (e, e) [1]."""
    shapes, Kg = _elastic_shapes(ready), ready.system.Kg
    result: Array = shapes.T @ ((Kg + Kg.T) / 2) @ shapes
    return result


def unstable_speeds(ready: Response, speed: Array) -> NDArray[np.bool_]:
    """Relative speeds (P,) at which a vibration of the mean system grows.

    Gyroscopic terms, all dampers and the speed of the frames count; the varying stiffness does not (`stability` has
    it).  Speeds below the critical one are not asked.
    """
    frame = ready.frame_factor(speed)
    found = np.zeros(speed.size, dtype=bool)
    # no eigenvalue is above the Frobenius norm: most trains are far from their critical speed by that alone
    fastest = float(np.max(frame, initial=0.0))
    if fastest < _FASTEST and fastest**2 * np.linalg.norm(_centripetal(ready)) < 1:
        return found
    # the square of a frame speed overflows far above any train: the response then says that it is not finite
    fast = (frame >= critical_speed(ready)[0]) & (frame < _FASTEST)
    if not np.any(fast):
        return found
    modes = eigen(ready.system)
    for value in np.unique(frame[fast]):
        mu = whirl(ready.system, relative_speed=float(value), damped=True, modes=modes).mu
        found[frame == value] = np.max(mu.real, initial=0.0) > _GROWTH * np.max(np.abs(mu), initial=0.0)
    return found


def require_stable_mean(ready: Response, speed: float) -> None:
    """Refuse a relative speed at which a vibration of the mean system grows.

    Raises
    ------
    ConvergenceError : no steady motion.
    """
    if unstable_speeds(ready, np.array([speed]))[0]:
        tone, (critical, name) = float(ready.lines.tone), critical_speed(ready)
        raise ConvergenceError(
            f"no steady motion at {tone * speed:.6g} Hz mesh frequency: the mean system is unstable, since above "
            f"{tone * critical:.6g} Hz the centripetal terms exceed the stiffness (first of {name})"
        )


def instability_warnings(ready: Response, unstable: Array) -> list[CodedText]:
    """Warning where the mean system is unstable, at relative speeds (U,)."""
    if not unstable.size:
        return []
    tone, (critical, name) = float(ready.lines.tone), critical_speed(ready)
    return [
        coded(
            "no-steady-motion",
            f"no steady motion at {unstable.size} speeds from {unstable.min() * tone:.6g} Hz mesh frequency on: the "
            f"mean system is unstable, since above {critical * tone:.6g} Hz the centripetal terms exceed the stiffness "
            f"(first of {name}); the values there are nan",
        )
    ]
