"""Ishikawa's tooth: his formula worked by hand, against quadrature, and as a stiffness of a mesh."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.system.tooth_pairs import pair_of
from epicyclic.teeth.compliance import ToothCompliance
from epicyclic.teeth.gear_pair import IshikawaTooth, MeshedTeeth, ishikawa_stiffness, ishikawa_tooth

# s_F 8, s_K 4, h_r 2, h 9 mm: h_i = (9 8 - 2 4)/(8 - 4) = 16 mm
TOOTH = IshikawaTooth(
    thickness=8e-3, tip_thickness=4e-3, rectangle=2e-3, height=9e-3, youngs_modulus=200e9, poisson=0.3
)


def meshed(mesh: str = "main/p-d/1", drive: str = "yue2014-i", overrides: Any = None) -> MeshedTeeth:
    train = epicyclic.load(drive, overrides=overrides)
    pair = pair_of(train, next(one for one in train.meshes if one.name == mesh))
    a, b = pair.tooth_a, pair.tooth_b
    assert isinstance(a, ToothCompliance)
    assert isinstance(b, ToothCompliance)
    return MeshedTeeth(a=a, b=b, working_angle=pair.plane.pressure_angle, limits=pair.plane.limits)


def test_by_hand() -> None:
    # h_x = 6 mm, w = 0: u = (16 - 6)/(16 - 2) = 5/7, ln u = -0.3364722
    # rectangle 12/(E 512) [6 2 4 + 8/3] = 12/(E 512) 50.66667 = 1.187500/E
    # trapezoid 6/(E 512) 2744 [5/7 23/7 + 0.6729445 - 3] = 32.15625 [2.3469388 + 0.6729445 - 3]/E = 0.639371/E
    # shear 2.6/(E 8) [2 + 14 0.3364722] = 0.325 6.7106111/E = 2.1809486/E
    # root 24 36/(pi E 64) = 4.2971835/E
    found = TOOTH.parts(6e-3, 0.0)
    assert TOOTH.apex == pytest.approx(16e-3, rel=1e-12)
    for part, worked in (("rectangle", 1.1875), ("trapezoid", 0.639371), ("shear", 2.1809486), ("root", 4.2971835)):
        assert float(getattr(found, part)) * 200e9 == pytest.approx(worked, rel=2e-6)


@pytest.mark.parametrize("height", [1.5e-3, 2e-3, 4e-3, 8.5e-3])
@pytest.mark.parametrize("angle", [0.0, 0.5])
def test_by_quadrature(height: float, angle: float) -> None:
    # the beam of that shape in plane stress: bending and shear (factor 1) over the height up to the load
    def thick(y: float) -> float:
        return 8e-3 if y <= 2e-3 else 8e-3 * (16e-3 - y) / 14e-3

    E, G, across = 200e9, 200e9 / 2.6, math.cos(angle) ** 2
    marks = [point for point in (2e-3,) if point < height]
    bent = quad(lambda y: 12 * (height - y) ** 2 / thick(y) ** 3 / E, 0, height, points=marks)[0]
    sheared = quad(lambda y: 1 / (G * thick(y)), 0, height, points=marks)[0]
    found = TOOTH.parts(height, angle)
    assert float(found.rectangle + found.trapezoid) == pytest.approx(across * bent, rel=1e-9)
    assert float(found.shear) == pytest.approx(across * sheared, rel=1e-9)


def test_pair_of_the_source() -> None:
    # an independent computation of the p-d pair of yue2014 (19/20, m 4, 25 deg): 24.2 N/(mm um) of one pair with the
    # tilt of the root, 42.2 without; its fillets are not stated
    mesh = meshed()
    whole = float(ishikawa_stiffness(mesh, [0.0])[0])
    assert whole / 1e9 == pytest.approx(24.2, rel=0.01)
    tilt = 0.0
    for tooth, radius in zip((mesh.a, mesh.b), mesh.radii(np.zeros(1)), strict=True):
        psi, gamma = tooth.outline.flank_angle(radius)
        height = tooth.height - (tooth.outline.tip - radius * np.cos(psi))
        tilt += float(ishikawa_tooth(tooth).parts(height, gamma).root[0])
    assert 1 / (1 / whole - tilt) / 1e9 == pytest.approx(42.2, rel=0.02)
    # two pairs are springs side by side
    sigma = mesh.limits[0] + 0.1
    both = float(ishikawa_stiffness(mesh, [sigma])[0])
    assert 1.4 * whole < both < 2 * whole


def test_the_height_of_the_load_is_that_of_the_touching_point_of_the_flank() -> None:
    """At the pitch point of 19/20 teeth, m 4, 25 deg, no shift: R = 2 z mm, half angle pi/2z, w = 25 deg - pi/2z."""
    mesh = meshed()
    whole = 2 / math.pi * sum((1 - tooth.gear.poisson**2) / tooth.gear.youngs_modulus for tooth in (mesh.a, mesh.b))
    for tooth, teeth in ((mesh.a, 19), (mesh.b, 20)):
        half = math.pi / (2 * teeth)
        height = 2e-3 * teeth * math.cos(half) - (tooth.outline.tip - tooth.height)
        whole += float(ishikawa_tooth(tooth).parts(height, math.radians(25) - half).whole)
    assert float(ishikawa_stiffness(mesh, [0.0])[0]) == pytest.approx(1 / whole, rel=1e-9)


def test_as_a_stiffness_of_the_file() -> None:
    key = "stages.main.meshes.p-d.stiffness"
    train = epicyclic.load("yue2014-i", overrides={key: "ishikawa"})
    mesh = next(one for one in train.meshes if one.name == "main/p-d/1")
    sigma = (np.arange(4096) + 0.5) / 4096
    section = ishikawa_stiffness(meshed(), sigma)
    assert mesh.stiffness == pytest.approx(section.mean() * 10e-3, rel=1e-3)
    order = np.arange(1, len(mesh.variation) + 1)
    series = 2 * (np.exp(-2j * np.pi * np.outer(order, sigma)) @ section) / len(sigma) / section.mean()
    np.testing.assert_allclose(mesh.variation, series, atol=2e-3)
    result = epicyclic.stiffness("yue2014-i", overrides={key: "ishikawa"})
    assert float(result.mean_mesh_stiffness.sel(mesh="main/p-d/1")) == mesh.stiffness
    # no load in it, and no bodies
    bored = epicyclic.load("yue2014-i", overrides={key: "ishikawa", "stages.main.p.bore": "50 mm"})
    assert next(one for one in bored.meshes if one.name == "main/p-d/1").stiffness == pytest.approx(mesh.stiffness)


def test_mean_of_one_method_and_variation_of_another() -> None:
    where = "stages.main.meshes.p-d"
    one = epicyclic.load("yue2014-i", overrides={f"{where}.stiffness": "ishikawa", f"{where}.variation": "energy"})
    other = epicyclic.load("yue2014-i", overrides={f"{where}.stiffness": "energy", f"{where}.variation": "ishikawa"})
    own = epicyclic.load("yue2014-i", overrides={f"{where}.stiffness": "ishikawa"})
    energy = epicyclic.load("yue2014-i", overrides={f"{where}.stiffness": "energy"})
    a, b, c, d = (next(m for m in train.meshes if m.name == "main/p-d/1") for train in (one, other, own, energy))
    assert (a.stiffness, b.stiffness) == (c.stiffness, d.stiffness)
    np.testing.assert_array_equal(a.variation, d.variation)
    np.testing.assert_array_equal(b.variation, c.variation)


def test_helical_and_ring_teeth() -> None:
    train = epicyclic.load(
        "ren2021",
        overrides={f"stages.main.meshes.{pair}.stiffness": "ishikawa" for pair in ("sun-planet", "planet-ring")},
    )
    energy = epicyclic.load(
        "ren2021",
        overrides={f"stages.main.meshes.{pair}.stiffness": "energy" for pair in ("sun-planet", "planet-ring")},
    )
    for one, other in zip(train.meshes, energy.meshes, strict=True):
        # stiffer: bodies do not couple its pairs, and its tooth ends at the root
        assert 0.95 < one.stiffness / other.stiffness < 1.9


def test_unknown_words_are_named() -> None:
    with pytest.raises(ModelError, match="ishikawa"):
        epicyclic.load("yue2014-i", overrides={"stages.main.meshes.p-d.stiffness": "isikawa"})
