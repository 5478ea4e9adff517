"""Inertia of bodies in a frame that turns: gyroscopic, centrifugal and Coriolis terms, body by body.

All matrices are of the unreduced coordinates, six a body in its own axes, order x y z rx ry rz.  The terms are those of
docs/conventions.md, Inertia in a turning frame; for x, y and rz they agree with [lin1999].
"""

from __future__ import annotations

import numpy as np

from .system import Array

X, Y, Z, RX, RY, RZ = range(6)


def mass_diagonal(mass: Array, inertia: Array, tilt: Array) -> Array:
    """Mass [kg] and moments of inertia [kg m^2] of every coordinate, (nb, 6), from mass, inertia and tilt (nb,)."""
    return np.stack([mass, mass, mass, tilt, tilt, inertia], axis=1)


def gyroscopic_matrix(mass: Array, inertia: Array, tilt: Array, frame_speed: Array, spin: Array) -> Array:
    """Coriolis and gyroscopic terms G of every body.

    G[x,y] = -2 m Omega, G[y,x] = +2 m Omega; G[rx,ry] = I_p w - 2 I_d Omega, G[ry,rx] = -(same).

    Parameters
    ----------
    mass [kg], inertia (about z), tilt (about a diameter) [kg m^2] : (nb,).
    frame_speed, spin : (nb,) Omega of the frame and absolute speed w of the body [rad/s].

    Returns
    -------
    (6 nb, 6 nb) [kg/s, kg m^2/s].
    """
    G = np.zeros((6 * mass.size, 6 * mass.size))
    base = 6 * np.arange(mass.size)
    coriolis = 2.0 * mass * frame_speed
    G[base + X, base + Y], G[base + Y, base + X] = -coriolis, coriolis
    tilting = inertia * spin - 2.0 * tilt * frame_speed
    G[base + RX, base + RY], G[base + RY, base + RX] = tilting, -tilting
    return G


def centrifugal_stiffness(mass: Array, inertia: Array, tilt: Array, frame_speed: Array, spin: Array) -> Array:
    """Centrifugal and gyroscopic stiffness of every body on its own, (6 nb, 6 nb) [N/m, N m/rad].

    K[x,x] = K[y,y] = -m Omega^2;  K[rx,rx] = K[ry,ry] = I_p w Omega - I_d Omega^2.  Arguments (nb,) as of
    `gyroscopic_matrix`.
    """
    diagonal = np.zeros((mass.size, 6))
    diagonal[:, X] = diagonal[:, Y] = -mass * frame_speed**2
    diagonal[:, RX] = diagonal[:, RY] = (inertia * spin - tilt * frame_speed) * frame_speed
    return np.diag(diagonal.ravel())


def euler_matrix(mass: Array, inertia: Array, tilt: Array, frame_speed: Array, spin: Array) -> Array:
    """Stiffness-like Euler terms of every body while all speeds change, per relative acceleration s'.

    E[x,y] = -m Omega', E[y,x] = +m Omega'; E[rx,ry] = I_p w' - I_d Omega', E[ry,rx] = -(same), with the accelerations
    Omega' = s' Omega, w' = s' w at s' = 1.  These are half the Coriolis terms in x and y, but not in the tilts: the
    moment that accelerates a body has the axis of the frame and not that of the tilted body.  Arguments (nb,) as of
    `gyroscopic_matrix`.

    Returns
    -------
    (6 nb, 6 nb) [kg/s, kg m^2/s]: s' E q is a term of the left side.
    """
    E = np.zeros((6 * mass.size, 6 * mass.size))
    base = 6 * np.arange(mass.size)
    across = mass * frame_speed
    E[base + X, base + Y], E[base + Y, base + X] = -across, across
    tilting = inertia * spin - tilt * frame_speed
    E[base + RX, base + RY], E[base + RY, base + RX] = tilting, -tilting
    return E


def spin_up_load(mass: Array, inertia: Array, frame_speed: Array, spin: Array, centre: Array) -> Array:
    """Inertial load of the nominal motion on every coordinate per relative acceleration s', (6 nb,) [N s, N m s].

    -I_p w' on rz, and -m Omega' z x r_c on a body whose centre is off the axis: -m r_c Omega' on its y.  The other
    arguments (nb,) as of `gyroscopic_matrix`.

    Parameters
    ----------
    centre : (nb, 2) place of each body's centre in its own axes [m].
    """
    load = np.zeros((mass.size, 6))
    load[:, RZ] = -inertia * spin
    load[:, X], load[:, Y] = mass * frame_speed * centre[:, 1], -mass * frame_speed * centre[:, 0]
    return load.ravel()


def carried_stiffness(K: Array, *, body: int, carrier: int, angle: float, preload: float, radius: float) -> None:
    """Add to K the geometric stiffness of the centrifugal preload of a carried body, in place.

    V = m Omega^2 / 2 [2 u_c (y - y_c) - u_c^2 + 2 w_c (z - z_c) - w_c^2] with u_c = r_c rz_c, w_c = -r_c ry_c, the
    motion of the carrier in the axes of the branch; with it a rigid rotation of the set is neutral.  Derived here.

    Parameters
    ----------
    K : (6 nb, 6 nb).  body, carrier : indices of the bodies.
    angle : of the branch axes in the carrier's axes [rad].  preload : m Omega^2 [kg/s^2].  radius : pin radius r_c [m].
    """
    c, s = np.cos(angle), np.sin(angle)
    b, g = 6 * body, 6 * carrier
    index = np.array([b + Y, b + Z, g + X, g + Y, g + Z, g + RX, g + RY, g + RZ])
    y_rel = np.array([1.0, 0.0, s, -c, 0.0, 0.0, 0.0, 0.0])
    z_rel = np.array([0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    u_c = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, radius])
    w_c = -radius * np.array([0.0, 0.0, 0.0, 0.0, 0.0, -s, c, 0.0])
    hessian = np.outer(u_c, y_rel) + np.outer(y_rel, u_c) - np.outer(u_c, u_c)
    hessian += np.outer(w_c, z_rel) + np.outer(z_rel, w_c) - np.outer(w_c, w_c)
    K[np.ix_(index, index)] += preload * hessian
