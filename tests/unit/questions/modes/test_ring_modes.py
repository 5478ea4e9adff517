"""Modes of a ring that bends: those in which teeth stand still, and how its shapes are drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.unit.elastic_ring_set import ring_set

import epicyclic
from epicyclic.bodies.elastic_body import elastic_ring
from epicyclic.cockpit.computing.speed_view import ModeView, mode_view
from epicyclic.cockpit.state.frames import body_labels, like_modes, mode_shapes
from epicyclic.show.charts import mode_shapes as figure
from epicyclic.show.series import ring_deflection
from epicyclic.train.train import Train


def ring_of(train: Train) -> int:
    return [body.name for body in train.bodies].index("main/ring")


@pytest.mark.parametrize(
    ("planets", "orders"), [(3, (3, 6, 9, 12)), (4, (2, 4, 6, 8, 10, 12)), (5, (5, 10)), (6, (3, 6, 9, 12))]
)
def test_modes_of_the_ring_alone_are_one_of_each_pair_that_the_planets_leave(
    planets: int, orders: tuple[int, ...]
) -> None:
    """Of N planets n = jN and, for even N, n = jN + N/2 have a wave with its nodes at all meshes."""
    train = ring_set(planets)
    modes = epicyclic.modes(train)
    alone = modes.sel(mode=modes.mode_kind == "ring")
    ring = train.bodies[ring_of(train)].elastic
    assert ring is not None
    # n (n^2 - 1)/sqrt(n^2 + 1) sqrt(EI/(rho A R^4)) of the free ring
    root = np.sqrt(ring.bending / (ring.line_mass * ring.radius**4)) / (2 * np.pi)
    free = [n * (n**2 - 1) / np.sqrt(n**2 + 1) * root for n in orders]
    np.testing.assert_allclose(alone.frequency.values, free, rtol=1e-9)
    assert set(alone.multiplicity.values.tolist()) == {1}
    # nothing but the ring has energy, and no mesh any
    np.testing.assert_allclose(alone.kinetic_energy_share.sel(body="main/ring").values, 1.0, rtol=1e-9)
    np.testing.assert_allclose(alone.strain_energy_share.sel(connection="main/ring/elastic").values, 1.0, rtol=1e-9)
    others = modes.sel(mode=modes.mode_kind != "ring").isel(mode=slice(1, None))
    meshes = [name for name in modes.connection.values if "planet" in name and "bearing" not in name]
    assert others.strain_energy_share.sel(connection=meshes).sum("connection").min() > 1e-6


def test_a_rotating_frame_couples_both_waves_of_an_order() -> None:
    turning = epicyclic.load(
        "wind-stage", {"stages.main.ring.elastic": True, "stages.main.ring.support.radial": "1e9 N/m"}
    )
    assert "ring" in epicyclic.modes(turning).mode_kind
    assert "ring" not in epicyclic.modes(turning, relative_speed=1.0).mode_kind


@pytest.mark.parametrize("stretches", [False, True])
def test_the_centre_line_moves_as_the_shape_of_the_body_says(stretches: bool) -> None:
    train = ring_set(4, stretches=stretches)
    ring = train.bodies[ring_of(train)].elastic
    assert ring is not None
    body, angle = elastic_ring(ring), np.linspace(0, 6, 17)
    out = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    moved = body.shape(ring.radius * out)[:, :3]
    wanted = [np.einsum("pa,pae->pe", way, moved) for way in (out, along)]
    np.testing.assert_allclose(ring_deflection(body.names, angle), wanted, atol=1e-12)


def test_the_figure_draws_the_bent_ring() -> None:
    """Of the mode of two nodal diameters the radius goes by cos 2 (psi - psi_0), forth and back."""
    train = ring_set(4)
    modes = epicyclic.modes(train)
    place = int(np.flatnonzero(modes.mode_kind.values == "ring")[0])
    drawn = figure.mode_shapes(epicyclic.check(train), modes)
    kinds = [trace.name for trace in drawn.data[: len(drawn.frames[0].data)]]
    rest, bent = drawn.data[kinds.index("ring")], _frame(drawn, f"{place}.0").data[kinds.index("ring")]
    still, moved = (np.array([*one.x[:97]], float) + 1j * np.array([*one.y[:97]], float) for one in (rest, bent))
    radial = ((moved - still) * np.exp(-1j * np.angle(still))).real
    two = 2 * np.mean(radial[:96] * np.exp(-2j * np.angle(still[:96])))
    assert abs(two) > 5  # [mm]
    np.testing.assert_allclose(radial, (two * np.exp(2j * np.angle(still))).real, atol=0.15)  # of 0.1 mm
    planet = kinds.index("planet")
    np.testing.assert_array_equal(_frame(drawn, f"{place}.0").data[planet].x, drawn.data[planet].x)


def _frame(drawn: Any, name: str) -> Any:
    return next(frame for frame in drawn.frames if frame.name == name)


def view_of(train: Train) -> ModeView:
    return mode_view(train, epicyclic.assemble(train), body_labels(train))


def test_the_page_says_what_bends_and_draws_it_as_large_as_any_motion() -> None:
    view = view_of(ring_set(4))
    place = view.kind.index("ring")
    assert (view.label[place], view.body[place]) == ("ring bends", "ring")
    assert np.abs(view.shape[place]).max() < 1e-6
    (values,) = view.bent[[place]]
    moved = ring_deflection([name.rpartition("/")[2] for name in view.bends], np.linspace(0, 2 * np.pi, 721)) @ values
    assert np.hypot(*moved).max() == pytest.approx(1.0, rel=1e-2)


def test_a_mode_of_the_ring_is_followed_through_other_orders() -> None:
    """A thicker rim may have fewer orders: its modes keep their likes, and a mode that it has no more has none."""
    many, few = (view_of(train) for train in (ring_set(4), ring_set(4, orders=8)))
    before, after = (
        mode_shapes(
            [], [{"index": int(n), "frequency": f} for n, f in zip(v.number, v.frequency, strict=True)], vars_of(v)
        )
        for v in (many, few)
    )
    like = like_modes(before, after)
    rings = [int(n) for n, kind in zip(many.number, many.kind, strict=True) if kind == "ring"]
    found = [like[n][0] for n in rings]
    assert found == [int(n) for n, kind in zip(few.number, few.kind, strict=True) if kind == "ring"] + [None, None]


def vars_of(view: ModeView) -> dict[str, object]:
    return {name: getattr(view, name) for name in ("shape", "mass", "bends", "bent", "bent_mass")}


def test_a_ring_that_alone_can_move_and_strains_teeth_is_of_the_other_kinds() -> None:
    held: dict[str, object] = {
        f"stages.main.{member}.{seat}": {"radial": "inf", "rz": "inf"}
        for member, seat in (("sun", "support"), ("carrier", "support"), ("ring", "support"), ("planet", "bearing"))
    }
    train = ring_set(4)
    document = {name: table for name, table in train.document.items() if name != "assumed"}
    modes = epicyclic.modes(epicyclic.load(document, held))
    np.testing.assert_allclose(modes.kinetic_energy_share.sel(body="main/ring"), 1.0, rtol=1e-12)
    # one of each pair n = 2, 4, .. is free of the teeth, and no other is
    still = modes.strain_energy_share.sel(connection="main/ring/elastic") > 1 - 1e-9
    np.testing.assert_array_equal(modes.mode_kind == "ring", still)
    assert int(still.sum()) == 6 < modes.sizes["mode"] == 22
