"""Mesh stiffness by potential energy: against ISO 6336-1 by hand, by counting pairs, and its symmetries."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from epicyclic.errors import ModelError
from epicyclic.teeth import gear_pair, geometry
from epicyclic.teeth.compliance import tooth_compliance
from epicyclic.teeth.form import GearForm
from epicyclic.teeth.gear_pair import MeshedTeeth, energy_series, interference_warnings, section_stiffness
from epicyclic.teeth.mesh_stiffness import evaluate_series

Array = NDArray[np.float64]
deg = math.radians
M = 4e-3
LOAD = 200e3  # N/m
UNIT = 1e9  # 1 N/(mm um) in N/m^2


def meshing(
    teeth: tuple[int, int],
    angle: float = 20.0,
    helix: float = 0.0,
    *,
    shifts: tuple[float, float] = (0.0, 0.0),
    internal: bool = False,
    dedendum: float = 1.25,
    shorter: float = 0.0,
) -> MeshedTeeth:
    """Two gears without backlash, hubs of half the root diameter, a rim of 3.5 modules; angles [deg]."""
    alpha, beta = deg(angle), deg(helix)
    working = geometry.working_pressure_angle(
        *teeth, alpha, beta, shift_a=shifts[0], shift_b=shifts[1], internal=internal
    )
    forms = []
    for k, (z, x) in enumerate(zip(teeth, shifts, strict=True)):
        ring = internal and k == 1
        form = GearForm(
            teeth=z,
            module=M,
            pressure_angle=alpha,
            helix_angle=beta,
            profile_shift=x,
            addendum=1.0 - shorter,
            dedendum=dedendum,
            internal=ring,
            bore=1.0,
        )
        forms.append(replace(form, bore=form.root + 3.5 * M if ring else 0.5 * form.root))
    base = [geometry.base_radius(z, M, alpha, beta) for z in teeth]
    limits = geometry.contact_limits(
        base[0],
        forms[0].tip,
        base[1],
        forms[1].tip,
        working_pressure_angle=working,
        base_pitch=geometry.base_pitch(M, alpha, beta),
        internal=internal,
    )
    a, b = (tooth_compliance(form) for form in forms)
    return MeshedTeeth(a=a, b=b, working_angle=working, limits=limits)


SPUR = meshing((20, 40))


# c' by hand in N/(mm um), ISO 6336-1 method B: q' = 0.04723 + 0.15551/z_n1 + 0.25791/z_n2 - 0.00635 x1
#   - 0.11654 x1/z_n1 - 0.00193 x2 - 0.24188 x2/z_n2 + 0.00529 x1^2 + 0.00182 x2^2, c' = 0.8 C_B cos beta/q'
BY_HAND = {
    # q' = 0.04723 + 0.0077755 + 0.00644775 = 0.06145325; C_B = 0.975; 0.8 * 0.975/0.06145325 = 12.692575
    "20/40": (SPUR, 12.692575),
    # cos^2 beta_b cos beta = 0.97337339 * 0.98480775 = 0.95858567; q' = 0.04723 + 0.00621124 + 0.00260241 - 0.003048
    # - 0.00223427 - 0.00129117 - 0.00163284 + 0.00121882 + 0.00081456 = 0.04987075; 0.8 * 0.98480775/q' = 15.79776
    "24/95 helical": (meshing((24, 95), 20.0, 10.0, shifts=(0.48, 0.669), dedendum=1.2, shorter=0.12), 15.79776),
    # ring, z_n2 endless: q' = 0.04723 + 0.15551/30 = 0.05241367; C_B = 0.975; 0.8 * 0.975/0.05241367 = 14.881616
    "30/84 ring": (meshing((30, 84), internal=True), 14.881616),
}


@pytest.mark.parametrize("name", [*BY_HAND])
def test_near_the_standard(name: str) -> None:
    mesh, single = BY_HAND[name]
    ratio = mesh.limits[1] - mesh.limits[0]
    standard = single * (0.75 * ratio + 0.25)
    transverse = energy_series(mesh, LOAD)[0] * math.cos(mesh.base_helix) / UNIT
    # The standard's own spread: its C_M = 0.8 brings theory down to what was measured, and its c' is for a solid disc.
    # Energy with a hub of half the root diameter came within 8 % for pairs alike in size and 15 % at 1:4.
    assert transverse == pytest.approx(standard, rel=0.15)
    assert 10 < transverse < 30  # steel


RING = replace(BY_HAND["30/84 ring"][0], limits=(-0.4, 0.5))  # one pair at the pitch point


@pytest.mark.parametrize("mesh", [SPUR, BY_HAND["24/95 helical"][0], RING], ids=["spur", "helical", "ring"])
def test_one_pair_is_springs_in_a_row(mesh: MeshedTeeth) -> None:
    sigma = np.array([0.0])
    radius_a, radius_b = mesh.radii(sigma)
    on_a, on_b = mesh.rolled(sigma)
    # curvature across the line of contact: Euler's, that of the transverse section times cos beta_b
    sine = math.sin(mesh.a.gear.helix_angle) * math.cos(mesh.a.gear.pressure_angle)
    line = gear_pair.line_contact(
        1 / ((1 / on_a + (-1 if mesh is RING else 1) / on_b) * math.sqrt(1 - sine**2)),
        mesh.a.depth(radius_a),
        mesh.b.depth(radius_b),
        youngs_modulus=(206e9, 206e9),
        poisson=(0.3, 0.3),
    )
    step = 1e-3 * LOAD  # du/dp by differences
    slope = (gear_pair.approach(line, np.array([LOAD + step])) - gear_pair.approach(line, np.array([LOAD - step]))) / (
        2 * step
    )
    single = 1 / (mesh.a.bending(radius_a) + mesh.b.bending(radius_b) + slope)
    np.testing.assert_allclose(section_stiffness(mesh, sigma, LOAD), single, rtol=1e-6)  # of the difference


def test_two_pairs_share_through_the_bodies() -> None:
    low, high = SPUR.limits
    sigma = np.array([low + 0.5 * (high - low - 1)])
    both = section_stiffness(SPUR, sigma, LOAD)
    # alone each: limits cut so that the other does not touch
    first = section_stiffness(replace(SPUR, limits=(low, low + 0.999)), sigma, LOAD)
    second = section_stiffness(replace(SPUR, limits=(high - 0.999, high)), sigma, LOAD)
    assert 0.75 < both / (first + second) < 0.9  # finite elements: a sixth less than the sum


def test_radii_and_curvatures_at_the_pitch_point() -> None:
    radius_a, radius_b = SPUR.radii(np.array([0.0]))
    assert radius_a[0] == pytest.approx(40e-3, rel=1e-12)
    assert radius_b[0] == pytest.approx(80e-3, rel=1e-12)
    on_a, on_b = SPUR.rolled(np.array([0.3]))
    assert on_a[0] + on_b[0] == pytest.approx(120e-3 * math.sin(deg(20)), rel=1e-12)  # the line of action
    assert SPUR.radii(np.array(SPUR.limits))[0][1] == pytest.approx(SPUR.a.gear.tip, rel=1e-12)
    ring = meshing((30, 84), internal=True)
    assert ring.radii(np.array(ring.limits))[1][0] == pytest.approx(ring.b.gear.tip, rel=1e-12)


def test_gears_may_change_places() -> None:
    turned = MeshedTeeth(
        a=SPUR.b, b=SPUR.a, working_angle=SPUR.working_angle, limits=(-SPUR.limits[1], -SPUR.limits[0])
    )
    sigma = np.linspace(-0.45, 0.55, 23)
    np.testing.assert_allclose(
        section_stiffness(turned, -sigma, LOAD), section_stiffness(SPUR, sigma, LOAD), rtol=1e-12
    )


def test_series_is_that_of_the_stiffness() -> None:
    mean, series = energy_series(SPUR, LOAD, harmonics=400)
    sigma = np.array([-0.3, 0.0, 0.05, 0.3, 0.45])  # 0.04 and more from the jumps at 0.143 and 0.778
    # a step of 0.3 leaves some 0.3/(pi^2 L d) at a distance d, 2e-3
    np.testing.assert_allclose(mean * evaluate_series(series, sigma), section_stiffness(SPUR, sigma, LOAD), rtol=3e-3)
    even = (np.arange(20000) + 0.5) / 20000
    assert section_stiffness(SPUR, even, LOAD).mean() == pytest.approx(mean, rel=1e-4)  # two steps, each to 1/20000


def test_harder_loads_make_a_stiffer_contact() -> None:
    mean = [energy_series(SPUR, load)[0] for load in (5e4, 2e5, 8e5)]
    assert mean[0] < mean[1] < mean[2]
    assert mean[2] / mean[0] < 1.15


def test_wide_contact_ratio_has_three_pairs() -> None:
    mesh = replace(SPUR, limits=(-1.1, 1.1))
    assert section_stiffness(mesh, np.array([0.05]), LOAD) > 1.2 * section_stiffness(mesh, np.array([0.5]), LOAD)


@pytest.mark.parametrize(
    ("limits", "load", "problem"),
    [((-0.4, 0.4), LOAD, "contact is lost"), ((-0.7, 0.7), 0.0, "no load"), ((-0.7, 0.7), math.nan, "no load")],
)
def test_what_cannot_be_is_named(limits: tuple[float, float], load: float, problem: str) -> None:
    with pytest.raises(ModelError, match=problem) as caught:
        energy_series(replace(SPUR, limits=limits), load, path="stages.main.meshes.sun-planet")
    assert caught.value.path in ("stages.main.meshes.sun-planet", "")  # a load comes from no place in the file


def test_tips_that_dig_into_fillets() -> None:
    # 40 teeth: the involute begins at 76.79 mm, 1.6 mm outside the base circle.
    mesh = meshing((40, 40))
    low, high = mesh.limits
    begins = mesh.a.limits[0]
    assert interference_warnings(mesh) == ()
    place = np.linspace(low - 0.6, low, 601)
    below = begins - mesh.radii(place)[0]
    slight, deep = (float(place[np.flatnonzero(below > depth * M)[-1]]) for depth in (0.03, 0.11))
    told = interference_warnings(replace(mesh, limits=(slight, high)))
    assert len(told) == 1
    assert told[0].startswith("the tips of the second gear reach 0.12")  # 0.03 modules, and the step of `place`
    with pytest.raises(ModelError, match="interfere") as caught:
        energy_series(replace(mesh, limits=(deep, high)), LOAD, path="stages.main.meshes.a-b")
    assert caught.value.path == "stages.main.meshes.a-b"


def test_tips_that_reach_past_the_base_circle() -> None:
    start = -20 * M * math.sin(deg(20)) / geometry.base_pitch(M, deg(20), 0.0) / 2  # where the line of action leaves it
    with pytest.raises(ModelError, match="interfere"):
        interference_warnings(replace(SPUR, limits=(start - 0.1, SPUR.limits[1])))
