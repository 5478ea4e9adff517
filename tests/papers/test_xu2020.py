"""Xu 2020, split herringbone planetary set: geometry, phases, corrected equations, neck, port and slide.

The rows of the source are corrected for their signs [xu2020, eq. 17-18]; supports, bearings and masses are those of the
ready drive, so that numbers hold in kind and invariants exactly.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.flanks import StiffnessOptions
from epicyclic.questions.flanks.contact_resolution import stiffness, stiffness_history
from epicyclic.questions.response.measures import periodic
from epicyclic.statics import StaticOptions
from epicyclic.statics.static import static
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load

Array = NDArray[np.float64]
Changes = dict[str, Any]

NECK = "stages.main.sun.neck.torsional_rigidity"
NECKS = (5.2e7, 4.9e7, 4.6e7, 4.3e7, 4.0e7)  # K_1 .. K_5 [N m^2]
FIXED: Changes = {"stages.main.sun.support.z": "inf", "stages.main.planet.bearing.z": "inf"}
LEFT_PORT: Changes = {"operation.torque.sun.right": None, "operation.torque.sun.left": "balance"}
SPLIT_PORT: Changes = {"operation.torque.sun": "balance"}
CLOCKWISE: Changes = {"operation.speed.carrier": "-17.3 rpm"}
RIGID: Changes = {
    f"stages.main.{member}.neck.{key}": None
    for member, keys in {
        "sun": ("torsional_rigidity", "radial", "z"),
        "planet": ("diameter", "bore"),
        "ring": ("radial", "z", "rz"),
        "carrier": ("radial", "z", "rz"),
    }.items()
    for key in keys
}
SUN_RADIUS = (
    21
    * 15e-3
    / math.cos(math.radians(8))
    / 2
    * math.cos(math.atan(math.tan(math.radians(25)) / math.cos(math.radians(8))))
)
BASE_HELIX = math.asin(math.sin(math.radians(8)) * math.cos(math.radians(25)))


def drive(*changes: Changes) -> System:
    """The ready drive with some changes."""
    return assemble(load("xu2020", {key: value for change in changes for key, value in change.items()}))


@pytest.fixture(scope="module")
def system() -> System:
    return drive()


def stiffness_matrix(system: System) -> Array:
    return np.asarray(system.K + (system.meshes.B * system.meshes.stiffness) @ system.meshes.B.T)


def vector(system: System, values: dict[str, float]) -> Array:
    """Displacement with these coordinates, all others 0."""
    assert set(values) <= set(system.dofs.names)
    return np.array([values.get(name, 0.0) for name in system.dofs.names])


def mirror(system: System) -> Array:
    """J: left and right change places, z changes its sign."""
    names = system.dofs.names
    other = {"left": "right", "right": "left"}
    J = np.zeros((len(names), len(names)))
    for i, name in enumerate(names):
        *body, side, direction = name.split("/")
        J[names.index("/".join([*body, other[side], direction])), i] = -1.0 if direction == "z" else 1.0
    return J


def sun_share(result: xr.Dataset) -> tuple[Array, Array]:
    """Force of all sun meshes, left and right, at every instant [N]."""
    names = [n for n in result["mesh"].values.tolist() if "sun-planet" in n]
    left, right = (
        result["mesh_force"].sel(mesh=[n for n in names if n.endswith(side)]).sum("mesh").values
        for side in ("left", "right")
    )
    return left, right


def left_share(*changes: Changes) -> float:
    """Part of the sun's load that its left half carries, mean of a mesh cycle."""
    left, right = sun_share(static(drive(*changes), StaticOptions(cycles=1)))
    return float(np.mean(left / (left + right)))


# Table 1 and what follows from it ------------------------------------------------------------------------------------


def test_geometry_masses_and_torque() -> None:
    result = epicyclic.check("xu2020")
    # 15 mm x 58 / (2 cos 8 deg), both meshes (58 = 21 + 37 = 95 - 37), to the printed digits
    assert float(result.centre_distance[0]) == pytest.approx(439.275e-3, abs=5e-7)
    mass = result.mass
    expected = {"main/sun/left": 127.9, "main/sun/right": 127.9, "main/planet/3/left": 276.3, "main/ring/right": 823.8}
    for body, value in expected.items():
        assert float(mass.sel(body=body)) == pytest.approx(value, abs=0.05)
    assert float(result.torque.sel(body="main/sun/right")) == pytest.approx(-149.9e3, abs=50)
    train = load("xu2020")
    torque = train.kinematics.torque or {}
    assert torque["main.carrier"] == pytest.approx(1.5e6 / (17.3 * math.pi / 30), rel=1e-9)
    assert torque["main.sun"] == pytest.approx(-torque["main.carrier"] * 21 / 116, rel=1e-12)
    assert train.torques == pytest.approx(
        {
            "main/sun/right": torque["main.sun"],
            **dict.fromkeys(("main/carrier/left", "main/carrier/right"), torque["main.carrier"] / 2),
        }
    )
    assert train.kinematics.mesh_frequency == {"main": Fraction(95) * Fraction(173, 600)}


def test_contact_and_overlap_ratio() -> None:
    meshes = {mesh.name: mesh for mesh in load("xu2020").meshes}
    sun, ring = meshes["main/sun-planet/1/left"], meshes["main/planet-ring/1/left"]
    assert (sun.contact_ratio, ring.contact_ratio) == pytest.approx((1.441, 1.602), abs=6e-4)
    assert sun.overlap_ratio == pytest.approx(175 * math.sin(math.radians(8)) / (math.pi * 15), rel=1e-12)
    assert math.degrees(sun.base_helix) == pytest.approx(7.246, abs=5e-4)


def test_assembly_number() -> None:
    """(21 + 95)/4 = 29: four planets go in, three do not."""
    assert Fraction(21 + 95, 4) == 29
    assert load("xu2020").warnings == ()
    assert "cannot be assembled" in " ".join(load("xu2020", {"stages.main.planets": 3}).warnings)


def test_coordinates(system: System) -> None:
    """8 (N + 3), whatever N."""
    assert len(system.dofs.names) == 56
    assert set(system.dofs.direction) == {"x", "y", "z", "rz"}
    assert len(drive({"stages.main.planets": 2}).dofs.names) == 40


def leads(changes: Changes, side: str = "left") -> list[Fraction | float]:
    found = {mesh.name: mesh.lead for mesh in load("xu2020", changes).meshes}
    return [found[f"main/sun-planet/{i}/{side}"] for i in (1, 2, 3, 4)]


def test_phase_leads_turn_with_the_sun() -> None:
    forward = [Fraction(0), Fraction(3, 4), Fraction(1, 2), Fraction(1, 4)]
    assert leads({}) == forward  # the sun turns ccw relative to the carrier
    assert leads(CLOCKWISE) == [forward[0], *forward[:0:-1]]
    assert leads({}, "right") == forward
    assert leads({"stages.main.stagger": 0.125}, "right") == [(lead + Fraction(1, 8)) % 1 for lead in forward]


def test_stagger_shifts_the_right_half_in_time_only() -> None:
    """The phase mechanism: k_R(t) = k_L(t + lambda T); its largest value stays [xu2020, eq. 11-14]."""
    result = stiffness(load("xu2020", {"stages.main.stagger": 0.125}), StiffnessOptions(samples=256))["mesh_stiffness"]
    left, right = (result.sel(mesh=f"main/sun-planet/2/{side}").values for side in ("left", "right"))
    assert right == pytest.approx(np.roll(left, -32), rel=1e-12)
    # the phase that the twist gives: z_s phi / (2 pi) with phi = T l / (G I_p), all of the torque through the neck
    lag = 21 * 149.9e3 * 0.225 / 4.0e7 / (2 * math.pi)
    mesh = next(m for m in load("xu2020").meshes if m.name == "main/sun-planet/1/right")
    phase = np.arange(4096) / 4096
    base, turned = stiffness_history(mesh, phase), stiffness_history(mesh, phase + lag)
    assert lag == pytest.approx(0.0028, abs=5e-5)
    # published: -11.23 % in the largest value
    assert abs(turned.max() / base.max() - 1) < 1e-4
    assert np.abs(turned / base - 1).max() < 0.01


def test_contact_lines() -> None:
    """L(sigma) by cutting every line with the field of contact: mean eps_a b / cos b_b, variation that of the drive."""
    for name, mesh in {m.name: m for m in load("xu2020").meshes if m.branch == 1 and m.side == "left"}.items():
        width, overlap, ratio = 0.175, mesh.overlap_ratio, mesh.contact_ratio
        z = (np.arange(4000) + 0.5) / 4000  # places across the face, in face widths
        # distance of the pitch point from the beginning of contact, in base pitches
        a, b = (21, 37) if "sun" in name else (37, 95)
        start = -beginning(a, b, internal=b == 95)
        sigma = np.arange(64) / 64
        place = sigma[:, None] + start + (z - 0.5) * overlap  # distance from the beginning of contact
        teeth = np.floor(place) - np.ceil(place - ratio) + 1
        length = teeth.mean(axis=1) * width / math.cos(BASE_HELIX)
        # 4000 slices, each right to one line of 1/4000 of the width
        assert length.mean() == pytest.approx(ratio * width / math.cos(BASE_HELIX), rel=1e-3)
        series = 1 + (np.exp(2j * np.pi * np.outer(sigma, np.arange(1, mesh.variation.size + 1))) @ mesh.variation).real
        # a series cut after so many harmonics rounds the corners
        assert np.abs(series - length / length.mean()).max() < 5e-3
        # in the carrier's frame the ring drives the planet and the planet the sun: contact begins at the tip of the
        # driven first gear and runs down, sigma = -t
        assert stiffness_history(mesh, -sigma) == pytest.approx(mesh.stiffness * series, rel=1e-12)


def test_stiffness_over_time_is_the_assembled_one(system: System) -> None:
    phase, order = np.arange(32) / 32, np.arange(1, system.meshes.variation.shape[1] + 1)
    wave = np.exp(2j * np.pi * np.outer(order, phase))
    now = system.meshes.stiffness[:, None] * (1 + (system.meshes.variation @ wave).real)
    meshes = {mesh.name: mesh for mesh in load("xu2020").meshes}
    for name, values in zip(system.meshes.name, now, strict=True):
        assert values == pytest.approx(stiffness_history(meshes[name], phase), rel=1e-12)


def beginning(teeth_a: int, teeth_b: int, *, internal: bool) -> float:
    """sigma where contact begins: at the tip of b [base pitches]."""
    transverse = math.atan(math.tan(math.radians(25)) / math.cos(math.radians(8)))
    module = 15e-3 / math.cos(math.radians(8))
    pitch = math.pi * module * math.cos(transverse)
    base = teeth_b * module / 2 * math.cos(transverse)
    tip = teeth_b * module / 2 + (-15e-3 if internal else 15e-3)
    depth = math.sqrt(tip**2 - base**2) - base * math.tan(transverse)
    return (depth if internal else -depth) / pitch


# matrices ------------------------------------------------------------------------------------------------------------


def test_rows_are_the_corrected_equations() -> None:
    """Eq. 17 and 18, corrected, in the carrier's axes and for a driving carrier that turns clockwise, left helix left.

    d_s = [(y_s - y_n) cos psi - (x_s - x_n) sin psi + u_s + u_n] cos b + sigma (z_s - z_n) sin b, psi = ang - alpha
    d_r = [(y_r - y_n) cos psi - (x_r - x_n) sin psi + u_r - u_n] cos b + sigma (z_n - z_r) sin b, psi = ang + alpha
    """
    system = drive(CLOCKWISE)
    alpha = math.atan(math.tan(math.radians(25)) / math.cos(math.radians(8)))
    cos, sin = math.cos(BASE_HELIX), math.sin(BASE_HELIX)
    for column, name in enumerate(system.meshes.name):
        _, pair, branch, side = name.split("/")
        angle, sigma = (int(branch) - 1) * math.pi / 2, 1.0 if side == "left" else -1.0
        ring = pair == "planet-ring"
        psi = angle + alpha if ring else angle - alpha
        wheel, planet = f"main/{'ring' if ring else 'sun'}/{side}", f"main/planet/{branch}/{side}"
        radius = {wheel: SUN_RADIUS * (95 / 21 if ring else 1), planet: SUN_RADIUS * 37 / 21}
        x, y = -math.sin(psi) * cos, math.cos(psi) * cos  # of the wheel; of the planet the negative, in its own axes
        row = {
            f"{wheel}/x": x,
            f"{wheel}/y": y,
            f"{wheel}/z": (-sigma if ring else sigma) * sin,
            f"{wheel}/rz": radius[wheel] * cos,
            f"{planet}/x": -(x * math.cos(angle) + y * math.sin(angle)),
            f"{planet}/y": -(y * math.cos(angle) - x * math.sin(angle)),
            f"{planet}/z": (sigma if ring else -sigma) * sin,
            f"{planet}/rz": (-radius[planet] if ring else radius[planet]) * cos,
        }
        assert system.meshes.B[:, column] == pytest.approx(vector(system, row), abs=1e-14)


def test_stiffness_is_symmetric_with_one_rigid_motion(system: System) -> None:
    K = stiffness_matrix(system)
    # rows of equal entries are summed in another order on the other side of the diagonal
    assert np.abs(K - K.T).max() < 1e-15 * np.abs(K).max()
    scaled = np.linalg.eigvalsh(K / np.sqrt(np.outer(np.diag(K), np.diag(K))))
    assert (np.abs(scaled) < 1e-9).sum() == 1  # soft supports are 1e-2 of a mesh


def motions(system: System) -> dict[str, Array]:
    """Motions without mesh strain: rigid translations and rotation, gearing, screws of a planet half."""
    found: dict[str, dict[str, float]] = {"x": {}, "y": {}, "z": {}, "turn": {}, "gearing": {}}
    pin = 15e-3 * 58 / math.cos(math.radians(8)) / 2
    planet = SUN_RADIUS * 37 / 21
    for body, direction, name in zip(system.dofs.body, system.dofs.direction, system.dofs.names, strict=True):
        angle = (int(body.split("/")[2]) - 1) * math.pi / 2 if "planet" in body else 0.0
        if direction == "x":
            found["x"][name], found["y"][name] = math.cos(angle), math.sin(angle)
        elif direction == "y":
            found["x"][name], found["y"][name] = -math.sin(angle), math.cos(angle)
            if "planet" in body:
                found["turn"][name] = found["gearing"][name] = pin
        elif direction == "z":
            found["z"][name] = 1.0
        else:
            found["turn"][name] = 1.0
            # ring at rest, carrier 1: the sun 1 + z_r/z_s, a planet 1 - z_r/z_p
            member = body.split("/")[1]
            found["gearing"][name] = {"carrier": 1.0, "sun": 1 + 95 / 21, "planet": 1 - 95 / 37, "ring": 0.0}[member]
    for side, sigma in (("left", 1.0), ("right", -1.0)):
        # u = sigma z tan b: the left half of the sun is left-hand
        found[f"screw {side}"] = {
            f"main/planet/2/{side}/z": 1.0,
            f"main/planet/2/{side}/rz": sigma * math.tan(BASE_HELIX) / planet,
        }
    return {name: vector(system, motion) for name, motion in found.items()}


def test_motions_without_mesh_strain(system: System) -> None:
    for name, motion in motions(system).items():
        assert np.abs(system.meshes.B.T @ motion).max() < 1e-14 * np.abs(motion).max(), name
    pins = np.array(["bearing" in link or "neck" in link for link in system.links.link])
    gearing = motions(system)["gearing"]
    assert np.abs(system.links.B[:, pins].T @ gearing).max() < 1e-14 * np.abs(gearing).max()


def test_mirror(system: System) -> None:
    """J K J = K, and so for masses and the terms of the turning frame."""
    J = mirror(system)
    for matrix in (stiffness_matrix(system), system.M, system.G, system.Kg):
        assert np.abs(matrix).max() > 0
        # stations of left and right halves are rounded apart
        assert np.abs(J @ matrix @ J - matrix).max() < 1e-14 * np.abs(matrix).max()
    one_sided = drive({"stages.main.sun.left.support.radial": "2e8 N/m"})
    assert np.abs(J @ one_sided.K @ J - one_sided.K).max() == pytest.approx(1e8, rel=1e-6)


# the neck ------------------------------------------------------------------------------------------------------------


def parts(system: System) -> tuple[Array, Array]:
    """Natural frequencies [rad/s] of the mirror-symmetric and of the antisymmetric motions."""
    J, K = mirror(system), stiffness_matrix(system)
    found = []
    for sign in (1.0, -1.0):
        U, s, _ = np.linalg.svd((np.eye(len(J)) + sign * J) / 2)
        U = U[:, s > 0.5]
        found.append(np.sqrt(np.abs(scipy.linalg.eigvalsh(U.T @ K @ U, U.T @ system.M @ U))))
    return found[0], found[1]


def test_torsional_neck_acts_on_antisymmetric_modes_only(system: System) -> None:
    thin = drive({NECK: NECKS[-1]})
    (even, odd), (even_thin, odd_thin) = parts(system), parts(thin)
    assert len(even) == len(odd) == 28
    assert even[1:] == pytest.approx(even_thin[1:], rel=1e-12)  # the first is the rigid rotation
    assert np.abs(odd / odd_thin - 1).max() > 0.01


def test_mirror_symmetric_response_does_not_know_the_neck() -> None:
    """Load split between the halves, equal sides, no stagger: the same response for every K_j."""
    thick, thin = (periodic(drive(SPLIT_PORT, {NECK: K}), relative_speed=20.0) for K in (NECKS[0], NECKS[-1]))
    dynamic = np.abs(thick.force - thick.force.mean(axis=1, keepdims=True)).max()
    assert dynamic > 1e3
    # rounding of sums that the neck is in, 1e-13 on most machines: it is in no equation of what moves
    assert np.abs(thick.force - thin.force).max() < 1e-12 * np.abs(thick.force).max()
    staggered = [
        periodic(drive(SPLIT_PORT, {NECK: K, "stages.main.stagger": 0.25}), relative_speed=20.0) for K in NECKS[::4]
    ]
    assert np.abs(staggered[0].force - staggered[1].force).max() > 1e-4 * np.abs(thick.force).max()


@pytest.mark.parametrize("K", NECKS)
def test_a_floating_sun_shares_evenly_and_twists(K: float) -> None:
    """sum F_z = 0 makes the halves carry the same, whatever the neck; phi = T l / (G I_p) of half the torque."""
    result = static(drive({NECK: K}), StaticOptions(cycles=1))
    left, right = sun_share(result)
    # a free sun leaves the solver's tolerance
    assert left == pytest.approx(right, rel=1e-10)
    torque = 1.5e6 / (17.3 * math.pi / 30) * 21 / 116
    twist = result["link_deflection"].sel(link_row="main/sun/neck/rz").values
    assert result["link_force"].sel(link_row="main/sun/neck/rz").values == pytest.approx(torque / 2, rel=1e-9)
    assert twist == pytest.approx(torque / 2 * 0.225 / K, rel=1e-9)
    shape = result["displacement"]
    turned = [shape.sel(dof=f"main/sun/{side}/rz").values / SUN_RADIUS for side in ("left", "right")]
    assert turned[0] - turned[1] == pytest.approx(twist, rel=1e-9)
    slide = shape.sel(dof="main/sun/left/z").values
    # the twist is taken up by a slide: both halves see u cos b = -+ z sin b, planets and pins give way a little
    assert np.all(np.abs(slide) > 0.9 * twist * SUN_RADIUS / 2 / math.tan(BASE_HELIX))


def test_a_soft_or_rigid_neck_does_not_unload_a_half_of_a_floating_sun() -> None:
    for change in ({"stages.main.sun.neck.radial": 1e7}, {"stages.main.sun.neck.z": 1e9}, RIGID):
        assert left_share(change) == pytest.approx(0.5, abs=1e-10)


def test_held_axially_the_half_at_the_port_carries_more() -> None:
    """The left share falls with the neck's stiffness: the source has it rise."""
    shares = [left_share(FIXED, {NECK: K}) for K in NECKS]
    assert np.all(np.diff(shares) < 0)
    # tooth contact gives .326 -> .293; springs in place of it .343 -> .313
    assert shares[0] == pytest.approx(0.326, abs=0.025)
    assert shares[-1] == pytest.approx(0.293, abs=0.025)
    assert shares[0] - shares[-1] == pytest.approx(0.033, abs=0.005)
    # port on the other side: the mirror image
    assert left_share(FIXED, LEFT_PORT, {NECK: NECKS[-1]}) == pytest.approx(1 - shares[-1], abs=1e-6)
    assert left_share(FIXED, SPLIT_PORT, {NECK: NECKS[-1]}) == pytest.approx(0.5, abs=1e-6)


def test_the_port_may_be_a_coupling() -> None:
    shaft = {
        "bodies.output": {"inertia": "10 kg m^2"},
        "couplings.shaft": {"between": ["main.sun.right", "output"], "diameter": "280 mm", "length": "432.5 mm"},
        "operation.torque.sun.right": None,
        "operation.torque.output": "balance",
    }
    system = drive(FIXED, shaft)
    assert len(system.dofs.names) == 56 + 1 - 2 - 8  # with what is held axially
    joined, plain = static(system, StaticOptions(cycles=1)), static(drive(FIXED), StaticOptions(cycles=1))
    assert joined["mesh_force"].values == pytest.approx(plain["mesh_force"].values, rel=1e-9)
    carried = joined["link_force"].sel(link_row="shaft/rz").values
    assert carried == pytest.approx(149.9e3, abs=50)
    neck = [result["link_force"].sel(link_row="main/sun/neck/rz").values for result in (joined, plain)]
    assert neck[0] == pytest.approx(neck[1], rel=1e-9)


def test_slide() -> None:
    """Nothing where the sun floats; where it is held, a gap z sin b on one side and its opposite on the other."""
    slide = {"deviations.sun.position.z": "20 um"}
    assert "no support or bearing holds main.sun in z" in load("xu2020", slide).warnings[0]
    floating = [static(drive(change), StaticOptions(cycles=1))["mesh_force"].values for change in (slide, {})]
    assert floating[0] == pytest.approx(floating[1], rel=1e-12)
    gap = 20e-6 * math.sin(BASE_HELIX)
    gaps = {f"deviations.meshes.sun-planet.{side}.gap": s * gap for side, s in (("left", 1), ("right", -1))}
    slid, opened = (
        static(drive(FIXED, change), StaticOptions(cycles=1))["mesh_force"].values for change in (slide, gaps)
    )
    assert slid == pytest.approx(opened, rel=1e-8)
    # to the right: the left side is relieved, as the source says
    assert left_share(FIXED, slide) < left_share(FIXED) - 0.01
    # 1 mm would be 126 um a side: a helix falls open
    result = static(drive(FIXED, {"deviations.sun.position.z": "1 mm"}), StaticOptions(cycles=1))
    lost = [name for name, open_ in zip(result["mesh"].values, result["contact_lost"].values, strict=True) if open_]
    assert {name for name in lost if "sun-planet" in name} == {f"main/sun-planet/{i}/left" for i in (1, 2, 3, 4)}


def test_what_the_source_leaves_open_is_marked_assumed() -> None:
    train = load("xu2020")
    marked = {value.path for value in train.values if value.origin == "assumed"}
    assert {"damping.modal", "stages.main.sun.neck.z", "stages.main.carrier.mass"} <= marked
    printed = {"stages.main.sun.teeth", "stages.main.sun.neck.torsional_rigidity", "stages.main.planet.face_width"}
    assert not printed & set(train.assumed)
