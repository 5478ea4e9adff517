"""Rows of a train's coordinates for what is measured: its transmission errors, and the signals of its sensors.

Transmission errors are by rotation, by approach, and from shaft to shaft.

Lag of what is driven is positive, as of loaded tooth contact (docs/theory/transmission-error.md):

rotation : r_ba theta_a +- r_bb theta_b of a mesh, its gears seen from the carrier, by rotation alone [m]; the dynamic
    transmission error of the literature [yue2014].
approach : B^T q / cos beta_b of a mesh, its moving centres counted, along the line of action in the transverse plane
    [m].
shaft : sum i_r theta_r - theta_p of a shaft p by the rotations of the shafts r that drive it, in its own sense [rad].

A rigid motion of the whole train makes none of them.  Derived here.

Sensors are Fourier series in the angle of their material.

The displacement of a point of a body at the polar angle psi, along the radial, tangential and axial directions there,
is a periodic function of psi; at psi = angle + phi it is that of a point of the material which turns against the frame.

strain : (d_t' + d_r) / r along psi, of what bends; of a curved beam whose sections stay plane that is
    (v' + w + (r - R) phi') / r, curvature and stretch.
acceleration : of d seen from axes that turn with the material at w: d_r'' - 2 w d_t' - w^2 d_r,
    d_t'' + 2 w d_r' - w^2 d_t, d_z'', and a_0 . (theta x e): the sensor turns by theta in the acceleration a_0 of the
    nominal motion, -w^2 r outward and -Omega^2 r_c at the centre.  a_0 itself is left out, and what it changes by while
    the speed changes.
force : k d of a bolt, which stands in the housing.

Derived here; no published source.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from ..train.sensors import DIRECTIONS
from ..train.train import Sensor, Train, bodies_named, driving_member
from .link_rows import body_rows
from .structure import Structure, own_centres
from .system import NEGLIGIBLE, Array, ComplexArray, ErrorRows, SensorRows


def error_rows(train: Train, structure: Structure, T: Array) -> ErrorRows:
    """Rows of all transmission errors; T : (6 nb, n) expansion of the coordinates."""
    names = list(dict.fromkeys(row.whole for row in structure.meshes))
    rotation, approach = np.zeros((2, len(names), len(T)))
    for row, gap in zip(structure.meshes, structure.mesh, strict=True):
        mesh, whole = row.mesh, names.index(row.whole)
        along = gap / np.cos(mesh.base_helix) / max(1, len(mesh.slices))
        approach[whole] += along
        ends = [structure.index[mesh.a], structure.index[mesh.b]]
        turns = [6 * end + 5 for end in ends]
        rotation[whole, turns] += along[turns]
        for carrier in {train.bodies[end].carried_by for end in ends} - {None}:
            rotation[whole, 6 * structure.index[str(carrier)] + 5] -= along[turns].sum()
    shafts, turn = _shaft_rows(train)
    shaft = np.zeros((len(shafts), len(T)))
    for row_of, weights in zip(shaft, shafts.values(), strict=True):
        for name, weight in weights.items():
            turns = [6 * structure.index[body.name] + 5 for body in bodies_named(name, train.bodies)]
            row_of[turns] += weight / len(turns)
    return ErrorRows(
        mesh=tuple(names), shaft=tuple(shafts), turn=turn, B=(np.concatenate([rotation, approach, shaft]) @ T).T
    )


def _shaft_rows(train: Train) -> tuple[dict[str, dict[str, float]], dict[str, Fraction]]:
    """Weights of the rotations of shafts in every shaft-to-shaft error, and the speed of all shafts [rev/s].

    Of one freedom every shaft is seen from that which drives, of several from the freedoms.
    """
    kinematics = train.kinematics
    if kinematics.locked:
        return {}, {}
    named = [*kinematics.freedoms, *kinematics.stated, *kinematics.reacting]
    moving = [name for name in dict.fromkeys(named) if any(kinematics.ratio.get(name, {}).values())]
    shafts = [name for name in moving if name not in kinematics.held]
    speed = kinematics.speed or {}
    turn = {name: Fraction(speed.get(name, 0)) / 60 for name in shafts}
    motion, sources = kinematics.ratio, kinematics.freedoms
    driver = driving_member(train)
    if len(sources) == 1 and driver in shafts:
        of_driver = motion[str(driver)][sources[0]]
        motion = {name: {str(driver): motion[name][sources[0]] / of_driver} for name in shafts}
        sources = (str(driver),)
    weights: dict[str, dict[str, float]] = {}
    for name in filter(lambda shaft: shaft not in sources, shafts):
        forward = turn[name] or sum(motion[name].values())
        sense = -1 if forward < 0 else 1
        driven = {source: float(sense * motion[name][source]) for source in sources if motion[name][source]}
        weights[f"{name} by {', '.join(driven)}"] = {**driven, name: -float(sense)}
    return weights, turn


# sensors --------------------------------------------------------------------------------------------------------------


def sensor_rows(train: Train, structure: Structure, T: Array) -> SensorRows:
    """Rows of all sensors; T : (N, n) expansion of the coordinates."""
    sensors = train.sensors
    if not sensors:
        return SensorRows()
    index, links = structure.index, [row for row in structure.links if not row.law]
    angle, turn = np.array([sensor.angle for sensor in sensors]), [Fraction(0)] * len(sensors)
    series = [_series(train, structure, sensor) @ T for sensor in sensors]
    rows = np.zeros((len(sensors), 3, max(one.shape[1] for one in series), T.shape[1]), complex)
    mesh, link = np.zeros((len(sensors), len(structure.meshes))), np.zeros((len(sensors), len(links)))
    for i, (sensor, own) in enumerate(zip(sensors, series, strict=True)):
        if sensor.link and sensor.kind == "torque":
            link[i] = [row.link.name == sensor.link and row.direction == 5 for row in links]
            continue
        body = index[sensor.bodies[0]]
        angle[i] += train.bodies[body].angle
        if sensor.kind == "torque":
            mesh[i] = structure.mesh @ _turned_member(train, structure, sensor)
        elif turn_of := (structure.spin_turn[body] if sensor.kind != "force" else 0) - structure.frame_turn[body]:
            turn[i], rows[i, :, : own.shape[1]] = turn_of, own
        else:  # the series has one value
            rows[i, :, 0] = own.sum(axis=1).real
    return SensorRows(
        name=tuple(sensor.name for sensor in sensors),
        kind=tuple(sensor.kind for sensor in sensors),
        bodies=tuple(sensor.bodies for sensor in sensors),
        direction=tuple(sensor.direction if sensor.kind in ("acceleration", "force") else "" for sensor in sensors),
        angle=angle,
        turn=tuple(turn),
        rows=rows[:, :, : int(np.flatnonzero(rows.any(axis=(0, 1, 3)))[-1]) + 1 if rows.any() else 1],
        mesh=mesh,
        link=link,
    )


def _turned_member(train: Train, structure: Structure, sensor: Sensor) -> Array:
    """Motion (N,) by which a member, and what it carries, turns about its axis by 1 rad."""
    motion = np.zeros(structure.size)
    for i, (body, centre) in enumerate(zip(train.bodies, own_centres(train), strict=True)):
        if body.name in sensor.bodies or body.carried_by in sensor.bodies:
            motion[6 * i + 5] = 1.0
        if body.carried_by in sensor.bodies:
            motion[[6 * i, 6 * i + 1]] = -centre[1], centre[0]
    return motion


def _series(train: Train, structure: Structure, sensor: Sensor) -> ComplexArray:
    """Coefficients (3, K + 1, N) of exp(i k phi) in the rows of a sensor, real parts of their sum counting."""
    own = np.zeros((3, 1, structure.size), complex)
    if sensor.kind == "torque":
        return own
    i = structure.index[sensor.bodies[0]]
    if sensor.kind == "angle":
        own[0, 0, 6 * i + 5] = 1.0
        return own
    body = train.bodies[i]
    top = 1 + (0 if body.elastic is None else body.elastic.orders)  # 1 of a vector fixed in the frame
    psi = 2 * np.pi * np.arange(2 * top + 1) / (2 * top + 1)
    moved, turned = _point_rows(structure, len(train.bodies), i, sensor, psi)
    if sensor.kind == "strain":
        moved[:, :, : 6 * len(train.bodies)] = 0.0  # a rigid motion has none
        wave = _one_sided(moved, top)
        order = 1j * np.arange(top + 1)[:, None]
        parts = np.stack([(order * wave[1] + wave[0]) / sensor.radius, *np.zeros((2, *wave[0].shape))])
    elif sensor.kind == "force":
        wave = _one_sided(moved[DIRECTIONS.index(sensor.direction)], top)
        parts = sensor.stiffness * np.stack([wave, *np.zeros((2, *wave.shape))])
    else:
        w, centre = structure.spin[i], structure.frame_speed[i] ** 2 * own_centres(train)[i]
        c, s = np.cos(psi)[:, None], np.sin(psi)[:, None]
        a_r = -(w**2) * sensor.radius - (c * centre[0] + s * centre[1])
        a_t = s * centre[0] - c * centre[1]
        (d_r, d_t, d_z), (t_r, t_t, t_z) = moved, turned
        of_direction = {
            "radial": (-(w**2) * d_r + a_t * t_z, -2 * w * d_t, d_r),
            "tangential": (-(w**2) * d_t - a_r * t_z, 2 * w * d_r, d_t),
            "axial": (a_r * t_t - a_t * t_r, 0 * d_z, d_z),
        }
        parts = _one_sided(np.stack(of_direction[sensor.direction]), top)
    return np.asarray(parts * np.exp(1j * sensor.angle * np.arange(top + 1))[:, None])


def _point_rows(structure: Structure, bodies: int, i: int, sensor: Sensor, psi: Array) -> Array:
    """Displacement and rotation (2, 3, J, N) of points of a body at polar angles (J,), radial, tangential and axial."""
    c, s, none = np.cos(psi), np.sin(psi), np.zeros_like(psi)
    axes = np.array([[c, s, none], [-s, c, none], [none, none, none + 1.0]]).transpose(0, 2, 1)  # (3, J, 3)
    points = np.tile(np.stack([sensor.radius * c, sensor.radius * s, none + sensor.z], axis=1), (6, 1))
    normals, rotation = np.tile(axes.reshape(-1, 3), (2, 1)), np.repeat([False, True], 3 * len(psi))
    rows = body_rows(np.full(len(points), i), normals, points, np.zeros(bodies), structure.elastic, rotation)
    return rows.reshape(2, 3, len(psi), -1)


def _one_sided(values: Array, top: int) -> ComplexArray:
    """Coefficients (.., top + 1, N) of values (.., J, N) over a turn, J = 2 top + 1; those of rounding are 0."""
    wave = np.fft.rfft(values, axis=-2)[..., : top + 1, :] / values.shape[-2]
    wave[..., 1:, :] *= 2.0
    wave[np.abs(wave) <= NEGLIGIBLE * np.abs(values).max(initial=0.0)] = 0.0
    return np.asarray(wave)
