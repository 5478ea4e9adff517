"""Contact sets: against their potential, against radial laws that they integrate to, and among other laws."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.statics.tangent import linear, mean_stretch
from epicyclic.system.link_laws import ContactSetLaw, Law, LawGroup, Laws, RadialLaw, stacked
from epicyclic.train.train import ContactSet, Train

Array = NDArray[np.float64]
DIRECTIONS = ("x", "y", "z", "rx", "ry")
SIZE = np.array([1e-5, 1e-5, 1e-5, 1e-3, 1e-3])  # of a motion [m, rad]


def contacts(
    count: int, *, angle: float = 0.5, exponent: float = 1.5, gap: float = 0.0, seed: int = 0
) -> ContactSetLaw:
    """A row of contacts at 30 mm, inclined; with a seed their normals, gaps and coefficients are uneven."""
    phi, rng = 2 * np.pi * np.arange(count) / count, np.random.default_rng(seed)
    uneven = 0.2 * bool(seed)
    normal = np.stack([np.cos(angle) * np.cos(phi), np.cos(angle) * np.sin(phi), np.full(count, np.sin(angle))], axis=1)
    normal += uneven * rng.normal(size=normal.shape)
    place = np.stack([0.03 * np.cos(phi), 0.03 * np.sin(phi), np.full(count, 0.01)], axis=1)
    return ContactSetLaw(
        normals=tuple(map(tuple, np.hstack([normal, np.cross(place, normal)[:, :2]]).tolist())),
        gap=tuple((gap + 1e-5 * uneven * rng.normal(size=count)).tolist()),
        coefficient=tuple((1e9 * (1 + uneven * rng.random(count))).tolist()),
        exponent=exponent,
        load=2e4,
    )


def groups(*laws: RadialLaw | ContactSetLaw) -> Laws:
    return stacked(
        [
            LawGroup(name="g", kind="bearing", rows=tuple(f"g/{d}" for d in DIRECTIONS[:r]), B=np.eye(r), law=law,
                     damping=np.zeros(r))
            for law in laws
            for r in [len(law.normals[0]) if isinstance(law, ContactSetLaw) else 2]
        ]
    )  # fmt: skip


@pytest.mark.parametrize("exponent", [10 / 9, 1.5, 2.0])
def test_force_is_the_slope_of_the_potential_and_tangent_that_of_the_force(exponent: float) -> None:
    uneven, even = contacts(17, exponent=exponent, seed=3), contacts(24, exponent=exponent, gap=2e-6)
    spline = Law(stiffness=1e8, clearance=5e-6, friction=300.0, memory=True)
    many = groups(uneven, spline, even, Law(stiffness=1e8, clearance=5e-6), uneven)
    size = np.concatenate([SIZE, SIZE[:2], SIZE, SIZE[:2], SIZE])
    rng = np.random.default_rng(2)
    delta = size * rng.normal(size=(300, size.size))
    anchor = np.where(many.row_memory, 2e-6 * rng.normal(size=delta.shape), 0.0)
    force, tangent = many.force(delta, anchor), many.tangent(delta, anchor)
    for j, unit in enumerate(np.eye(size.size)):
        step = 1e-5 * size[j] * unit
        energy = many.potential(delta + step, anchor) - many.potential(delta - step, anchor)
        np.testing.assert_allclose(
            energy.sum(axis=1) / 2e-5, force[:, j] * size[j], atol=2e-5 * np.abs(force * size).max()
        )
        rate = (many.force(delta + step, anchor) - many.force(delta - step, anchor)) / 2e-5 * size
        off = np.abs(rate - tangent[:, :, j] * size * size[j]) / np.abs(tangent * np.outer(size, size)).max()
        # a slope of p = 10 / 9 begins with a corner: instants whose contact just touches, or whose slider just slips
        assert np.quantile(off, 0.99) < 2e-4
        assert np.median(off.max(axis=1)) < 1e-6


def test_tangent_is_symmetric_and_pulls_nothing_apart() -> None:
    many = groups(contacts(30, seed=5), contacts(30))
    size = np.tile(SIZE, 2)
    delta = size * np.random.default_rng(3).normal(size=(500, 10))
    scaled = many.tangent(delta) * np.outer(size, size)
    assert np.abs(scaled - scaled.transpose(0, 2, 1)).max() <= 1e-15 * np.abs(scaled).max()
    assert np.linalg.eigvalsh(scaled).min() > -1e-14 * np.abs(scaled).max()
    assert not scaled[:, :5, 5:].any()
    # convex: forces rise with the motion, and a chord lies above the potential
    other = delta[::-1]
    assert np.all(((many.force(delta) - many.force(other)) * (delta - other)).sum(axis=1) >= 0)
    middle = many.potential((delta + other) / 2).sum(axis=1)
    assert np.all(middle <= (many.potential(delta) + many.potential(other)).sum(axis=1) / 2)


def test_many_radial_contacts_are_the_radial_law_of_their_integral() -> None:
    """F = rho^p c E / (2 pi) times the integral of cos^(p+1): that of `Law` with this coefficient."""
    n, count, c = 10 / 9, 180, 1e9 * np.cos(0.5) ** (19 / 9)
    phi = (np.arange(200_000) + 0.5) / 200_000 * np.pi - np.pi / 2
    C = c * count / 2 * np.mean(np.cos(phi) ** (n + 1))
    load = 2e4
    law = Law(stiffness=n * C ** (1 / n) * load ** ((n - 1) / n), exponent=n, load=load)
    set_of = replace(contacts(count, exponent=n), normals=tuple(v[:2] for v in contacts(count).normals))
    delta = 1e-5 * np.random.default_rng(4).normal(size=(200, 2))
    alone, radial = groups(set_of), groups(law)
    np.testing.assert_allclose(alone.force(delta), radial.force(delta), atol=1e-5 * np.abs(radial.force(delta)).max())
    largest = np.abs(radial.tangent(delta)).max()
    # slopes begin steeply, as the ninth root: one contact in 180 of them at its edge
    np.testing.assert_allclose(alone.tangent(delta), radial.tangent(delta), atol=1 / 180 * largest)
    np.testing.assert_allclose(alone.potential(delta), radial.potential(delta), rtol=1e-5)


def test_nominal_stiffness_is_that_of_contacts_equally_pressed() -> None:
    law = contacts(40, angle=0.6)
    each = 1.5 * 1e9 ** (2 / 3) * (2e4 / 40) ** (1 / 3)  # of a contact of 500 N
    radial, lever = 20 * each * np.cos(0.6) ** 2, 0.03 * np.sin(0.6) - 0.01 * np.cos(0.6)
    expected = [radial, radial, 40 * each * np.sin(0.6) ** 2, 20 * each * lever**2, 20 * each * lever**2]
    np.testing.assert_allclose(groups(law).row_stiffness, expected, rtol=1e-12)
    np.testing.assert_allclose(groups(law).row_stiffest, expected, rtol=1e-12)


def test_sizes_are_of_forces_without_moments_and_play_is_where_nothing_presses() -> None:
    many = groups(contacts(24, gap=4e-6), Law(stiffness=1e8))
    rows = np.array([3.0, 4.0, 12.0, 1e3, 1e3, 5.0, 12.0])
    assert many.rows.size(rows).tolist() == [13.0, 13.0]
    inside, pressed = np.zeros(7), np.array([0, 0, 2e-5, 0, 0, 0, 0])
    assert many.state(np.array([inside, pressed])).tolist() == [[0, 3], [3, 3]]


# --- of a train -------------------------------------------------------------------------------------------------------


def reducer(**changes: Any) -> Train:
    """A reducer whose planets sit on contacts."""
    model = {
        "format": 2,
        "title": "a reducer",
        "stages": {
            "main": {
                "planets": 3,
                "module": 4e-3,
                "helix_angle": "15 deg",
                "face_width": 0.04,
                "sun": {"teeth": 24, "support": {"radial": 2e7, "z": 1e8, "tilt": 1e5}},
                "planet": {"teeth": 24, "bearing": {"radial": 2e8, "z": 1e8, "tilt": 1e5}},
                "ring": {"teeth": 72, "rim": 0.03},
                "carrier": {"mass": 20.0, "inertia": 0.2, "tilt_inertia": 0.1},
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": 100.0}, "torque": {"sun": 500.0}},
    }
    law = contacts(36, gap=-5e-6)
    mirrored = [(x, y, -z, -rx, -ry) for x, y, z, rx, ry in law.normals]
    whole = ContactSet(
        normals=(*law.normals, *mirrored),
        gap=law.gap * 2,
        coefficient=law.coefficient * 2,
        exponent=1.5,
        load=2e4,
    )
    train = epicyclic.load(model)
    values: dict[str, Any] = {"contacts": whole, **changes}
    return replace(train, links=tuple(replace(k, **values) if k.kind == "bearing" else k for k in train.links))


def test_contacts_take_all_rows_but_rigid_ones() -> None:
    groups = epicyclic.assemble(reducer()).groups
    assert groups[0].rows == tuple(f"main/planet/1/bearing/{d}" for d in DIRECTIONS)
    stiffness = (2e8, 2e8, np.inf, 1e5, 1e5, 0.0)
    held = epicyclic.assemble(reducer(stiffness=stiffness)).groups
    assert held[0].rows == tuple(f"main/planet/1/bearing/{d}" for d in ("x", "y", "rx", "ry"))
    law, whole = held[0].law, groups[0].law
    assert isinstance(law, ContactSetLaw)
    assert isinstance(whole, ContactSetLaw)
    assert law.normals == tuple((x, y, rx, ry) for x, y, _, rx, ry in whole.normals)


def test_linearised_rows_are_the_tangent_and_carry_the_force_of_the_law() -> None:
    """Along x, y, z, rx, ry the axes sum up to the tangent and to the force; the first two are the lateral force."""
    system = epicyclic.assemble(reducer())
    tangents, rows = linear(system), system.group_rows
    stretch = mean_stretch(system)
    force, block = system.laws.force(stretch), system.laws.tangent(stretch)
    np.testing.assert_allclose(tangents.K - system.K, rows @ block @ rows.T, rtol=1e-9, atol=1e-9 * block.max())
    links, first = tangents.links, len(system.links.name)
    B, k = links.B[:, first:], links.stiffness[first:]
    added = tangents.K - system.K
    np.testing.assert_allclose((B * k) @ B.T, added, rtol=1e-9, atol=1e-9 * np.abs(added).max())
    assert np.all(k > 0)
    assert links.name[first : first + 5] == tuple(
        f"main/planet/1/bearing/{d}" for d in ("radial", "tangential", "z", "rx", "ry")
    )
    q = np.linalg.lstsq(rows.T, stretch, rcond=None)[0]
    np.testing.assert_allclose(rows.T @ q, stretch, atol=1e-15)
    along = k * (B.T @ q) + links.preload[first:]
    np.testing.assert_allclose(B @ along, rows @ force, atol=1e-9 * np.abs(rows @ force).max())
    np.testing.assert_allclose(np.hypot(along[0], along[1]), np.hypot(force[0], force[1]), rtol=1e-9)


def test_what_is_wrong_is_said() -> None:
    uneven = ContactSet(**{name: getattr(contacts(7, seed=1), name) for name in ContactSet.__dataclass_fields__})
    with pytest.raises(ModelError, match=r"stages\.main\.planet\.bearing.* not evenly spread"):
        epicyclic.assemble(reducer(contacts=uneven))
    with pytest.raises(ModelError, match=r"stages\.main\.planet\.bearing.* beside another law"):
        epicyclic.assemble(reducer(clearance=1e-5))
