"""Static equilibrium with laws of flanks: far flanks, tables, laws of several slopes; sharing of them."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.sharing import SharingOptions
from epicyclic.questions.sharing.definitions import known_mean_loads, labelled
from epicyclic.questions.sharing.sharing import sharing
from epicyclic.questions.sharing.tone_forces import forces_of_equilibria
from epicyclic.statics import StaticOptions
from epicyclic.statics.equilibrium import compliance_of, equilibrium
from epicyclic.statics.record import Record, excitation, record_of
from epicyclic.statics.static import held_train, settled, static
from epicyclic.system.flank_laws import LawRows, LinearAt, TabulatedLaw
from epicyclic.system.gaps import FlanksAt, flanks
from epicyclic.system.link_laws import Law, LawGroup, stacked
from epicyclic.system.system import FarFlanks, Line, System

Array = NDArray[np.float64]
TORQUE, BACKLASH, TONE = 300.0, 4e-5, Fraction(60)
K = 5e8


def still(system: System, gap: Array, far: Array, frequency: Fraction = Fraction(0)) -> Line:
    return Line(
        frequency=frequency,
        gap=np.asarray(gap, complex),
        link_gap=np.zeros(len(system.links.name), complex),
        force=np.zeros((3, len(system.force)), complex),
        far_gap=np.asarray(far, complex),
    )


def balanced_torque(system: System, torque: float) -> System:
    """Torque on the sun, balanced at the carrier along the free motion."""
    free = compliance_of(system).free[:, 0]
    force = np.zeros(len(system.M))
    force[2], force[8] = torque, -torque * free[2] / free[8]
    return replace(system, force=force)


def mirrored(B: Array) -> Array:
    """Rows of the other flank of spur meshes: all but the radial part of the normal changes sign."""
    result = -B
    radial = np.arange(len(B)) >= 9
    result[radial & (np.arange(len(B)) % 3 == 0)] *= -1
    return result


def with_backlash(build: Any, *, N: int = 4, torque: float = TORQUE, variation: float = 0.0, **more: Any) -> System:
    """A planar set on stiff central bodies, planets on springs; every mesh has a far flank with errors of its own."""
    system: System = build.planar(N=N, lateral=(1e12, 1e12, 1e12, 2e8), **more).system()
    m = 2 * N
    rng = np.random.default_rng(4)
    series = variation * np.exp(2j * np.pi * rng.random((2, m, 2)))
    meshes = replace(system.meshes, backlash=np.full(m, BACKLASH), variation=series[0])
    far = FarFlanks(mesh=np.arange(m), B=mirrored(system.meshes.B), variation=series[1])
    system = replace(system, meshes=meshes, far=far, tones=(TONE,))
    lines = tuple(
        still(system, 5e-6 * rng.normal(size=m), 5e-6 * rng.normal(size=m), f) for f in (Fraction(0), Fraction(20))
    )
    return balanced_torque(replace(system, lines=lines), torque)


def seen_from_behind(system: System) -> System:
    """The train whose loaded flanks are the far ones of another, with its backlash as an error; no far flanks."""
    far = system.far_flanks
    meshes = replace(
        system.meshes,
        B=far.B,
        variation=far.variation,
        stiffness=system.meshes.stiffness[far.mesh],
        laws=far.laws,
        backlash=np.full(far.mesh.size, np.inf),
    )
    lines = [replace(line, gap=line.far_gap, far_gap=np.zeros(0, complex)) for line in system.lines]
    opened = still(system, np.full(far.mesh.size, BACKLASH), np.zeros(0))
    return replace(system, meshes=meshes, far=None, lines=(*lines, opened))


def table_of(system: System, rows: Any, *, bend: float = 0.6, seed: int = 0) -> TabulatedLaw:
    """A stiffening table for some mesh rows, with a phase of each."""
    rng = np.random.default_rng(seed)
    force = np.array([0.0, 300.0, 1500.0, 4000.0, 9000.0])
    sigma = np.arange(10) / 10
    gap = 2e-6 * np.sin(2 * np.pi * sigma)[:, None] + 1.8e-5 * (force / force[-1]) ** bend
    secant = np.diff(force) / np.diff(gap, axis=1)
    slope = np.hstack([secant[:, :1], (secant[:, :-1] + secant[:, 1:]) / 2, secant[:, -1:]])
    rows = np.asarray(rows)
    return TabulatedLaw(
        tone=system.meshes.tone[rows],
        lead=rng.random(rows.size),
        sense=np.ones(rows.size),
        force=force,
        gap=gap,
        slope=slope,
        load=np.full(rows.size, np.nan),
    )


# far flanks -----------------------------------------------------------------------------------------------------------


def pair(build: Any, *, load: float, spring: float, error: tuple[float, float]) -> System:
    """One gear that turns against a fixed one: one coordinate u along the line of action, spring to the housing."""
    system: System = build.planar(N=1).system()
    T = np.zeros((len(system.M), 1))
    T[2] = 1.0
    small: System = build.reduced(system, T, ("main/sun/rz",), np.ones(1))
    meshes = replace(
        small.meshes,
        name=("main/sun-planet/1",),
        pair=small.meshes.pair[:1],
        stage=("main",),
        branch=(1,),
        side=("",),
        B=np.ones((1, 1)),
        stiffness=np.array([K]),
        variation=np.zeros((1, 0), complex),
        tone=np.zeros(1, np.int64),
        damping=np.zeros(1),
        backlash=np.array([BACKLASH]),
        cos_base_helix=np.ones(1),
    )
    far = FarFlanks(mesh=np.zeros(1, np.int64), B=-np.ones((1, 1)), variation=np.zeros((1, 0), complex))
    small = replace(small, meshes=meshes, far=far, K=np.array([[spring]]), force=np.array([load]), symmetries=())
    return replace(small, lines=(still(small, np.array([error[0]]), np.array([error[1]])),))


@pytest.mark.parametrize("spring", [0.0, 3e7])
@pytest.mark.parametrize("load", [2000.0, 100.0, -100.0, -3000.0])
def test_a_pair_pushed_onto_its_other_flank(build: Any, load: float, spring: float) -> None:
    """k <u - e> - k <-u - e_far - b> + s u = F, solved by cases."""
    e, e_far = 3e-6, -5e-6
    result = static(pair(build, load=load, spring=spring, error=(e, e_far)), StaticOptions(samples=1))
    on_loaded = (load + K * e) / (K + spring)
    on_far = (load - K * (e_far + BACKLASH)) / (K + spring)
    cases = [(u, f) for u, f in ((on_loaded, K * (on_loaded - e)), (on_far, K * (on_far + e_far + BACKLASH)))]
    u, force = cases[0] if cases[0][1] > 0 else cases[1]
    if cases[0][1] <= 0 <= cases[1][1]:
        u, force = load / spring, 0.0
    assert result.mesh_force.item() == pytest.approx(force, rel=1e-9, abs=1e-9)
    assert result.displacement.item() == pytest.approx(u, rel=1e-9)
    # a load of 100 N against a spring of 3e7 N/m moves 3.3 um: the teeth touch only where the error lets them
    assert result.far_share.item() == (force < 0)
    assert result.contact_lost.item() == (force <= 0)
    assert result.mesh_contact.item() == (force != 0)
    said = " ".join(json.loads(result.attrs["warnings"]))
    assert ("far flank" in said) == (force < 0)
    assert ("meshes open" in said) == (force == 0)


@pytest.mark.parametrize("tables", [False, True])
def test_a_train_under_reversed_torque_is_that_seen_from_behind(build: Any, tables: bool) -> None:
    """Two ways to one state: far flanks of a train, and a train whose loaded flanks they are, open by the backlash."""
    system = with_backlash(build, torque=-TORQUE, variation=0.1)
    if tables:
        ring = np.arange(4, 8)
        behind = LawRows(law=table_of(system, ring, seed=3), rows=ring)
        loaded = LawRows(law=table_of(system, ring), rows=ring)
        assert system.far is not None
        system = replace(
            system,
            meshes=replace(system.meshes, laws=(loaded,)),
            far=replace(system.far, laws=(behind,)),
        )
    reversed_ = static(system, StaticOptions(samples=7))
    other = static(seen_from_behind(system), StaticOptions(samples=7))
    assert other.mesh_force.values.min() > 0
    np.testing.assert_allclose(reversed_.mesh_force, -other.mesh_force, rtol=1e-8)
    np.testing.assert_allclose(reversed_.displacement, other.displacement, rtol=1e-6, atol=1e-13)
    assert reversed_.far_share.values.tolist() == [1.0] * 8
    assert reversed_.mesh_contact.values.all()
    assert reversed_.contact_lost.values.all()
    with pytest.raises(ModelError, match="apart"):
        static(replace(system, far=None), StaticOptions(samples=7))
    shared, behind_ = (
        sharing(s, SharingOptions(method="static", samples=7)) for s in (system, seen_from_behind(system))
    )
    np.testing.assert_allclose(shared.load_sharing, behind_.load_sharing, rtol=1e-8)
    np.testing.assert_allclose(shared.mesh_force, -behind_.mesh_force, rtol=1e-8)
    # forces over the record have the sign of those over time, whichever flank carries
    np.testing.assert_allclose(shared.mesh_force_mean, shared.mesh_force.mean("time"), rtol=1e-12)
    np.testing.assert_array_equal(shared.mesh_force_peak, shared.mesh_force.max("time"))
    np.testing.assert_array_equal(shared.mesh_force_minimum, shared.mesh_force.min("time"))
    assert "far flank" in json.loads(shared.attrs["warnings"])[-1]


def one_pushed_back(build: Any, error: float = 2e-4) -> System:
    """Planet 1 is so far ahead on its pin that it meets the far flank of a mesh; the others carry."""
    system = with_backlash(build, variation=0.1)
    gap = np.zeros(8)
    gap[0] = error  # the loaded flank of sun mesh 1 lacks material, its far flank has too much
    return replace(system, lines=(*system.lines, still(system, gap, -gap)))


def sharing_of_record(system: System, record: Record, stored: int | None = None) -> xr.Dataset:
    """Load sharing over a record whose instants are solved one by one, whatever the train."""
    forces = forces_of_equilibria(system, record, stored)
    return labelled(system, forces, known_mean_loads(system), method="static", relative_speed=1.0, limit=None)


def test_what_far_flanks_change_is_an_equilibrium_of_all_forces(build: Any) -> None:
    """Balance of every coordinate with forces asked from the laws at the displacements, both flanks at once."""
    system = one_pushed_back(build)
    train = held_train(system)
    here = excitation(system, TONE, np.arange(21), 7)
    state = settled(train, here)
    pressing = state.far_force.max(axis=1) > 0
    assert pressing.any()
    given = flanks(system)
    delta = state.displacement @ given.B - np.hstack([here.gap, here.far_gap])
    force, _ = given.at(here.phases).evaluate(delta)
    np.testing.assert_allclose(np.hstack([state.mesh_force, state.far_force]), force, atol=1e-6 * np.abs(force).max())
    balance = state.displacement @ system.K + force @ given.B.T - here.force
    assert np.abs(balance).max() < 1e-6 * np.abs(here.force).max()
    net = static(system, StaticOptions(samples=7))
    row = state.mesh_force.copy()
    row -= state.far_force
    np.testing.assert_allclose(net.mesh_force, row.T, rtol=1e-12)
    assert 0 < net.far_share.values[0] <= 1
    assert (net.mesh_force.values[0] < 0).mean() == net.far_share.values[0]
    np.testing.assert_array_equal(net.open_share, 1 - net.mesh_contact.mean("time"))
    # the record of sharing is the same one
    window = record_of(system, cycles=3, turns=None, of=None, samples=7, most=1000, slow=True)
    record, again = (
        sharing_of_record(system, window),
        static(system, StaticOptions(cycles=3, samples=7)),
    )
    for name in ("open_share", "far_share", "contact_lost"):
        np.testing.assert_array_equal(record[name], again[name])


def test_far_flanks_that_never_press_change_nothing_but_rounding(build: Any) -> None:
    system = with_backlash(build, variation=0.1)
    without = replace(system, far=None)
    pairs = [
        (static(s, StaticOptions(samples=8)), sharing(s, SharingOptions(method="static", samples=8)))
        for s in (system, without)
    ]
    for ours, plain in zip(*pairs, strict=True):
        for name in plain.variables:
            values = plain[name].values
            if values.dtype.kind == "f":
                size = 1e-12 * np.abs(values).max(initial=0.0)
                np.testing.assert_allclose(ours[name].values, values, rtol=0, atol=size)
            else:
                np.testing.assert_array_equal(ours[name].values, values)
    assert static(system, StaticOptions(samples=8)).far_share.values.max() == 0
    assert "far_share" not in static(without, StaticOptions(samples=8))


def test_both_ways_through_sharing_agree_where_far_flanks_press(build: Any) -> None:
    """Linear in the lines while loaded flanks press alone, or every instant for itself."""
    system = one_pushed_back(build)
    by_lines = sharing(system, SharingOptions(method="static", samples=8))
    window = record_of(system, cycles=None, turns=None, of=None, samples=8, most=1000)
    by_record = sharing_of_record(system, window)
    np.testing.assert_allclose(by_lines.load_sharing, by_record.load_sharing, rtol=1e-7)
    plain = static(system, StaticOptions(samples=8))
    np.testing.assert_allclose(by_lines.mesh_force, plain.mesh_force, rtol=1e-7, atol=1e-6)
    assert by_lines.mesh_force.values.min() < 0
    assert by_lines.contact_lost.values[0]
    # a branch that pushes back makes the others carry more than all of the load
    F = plain.mesh_force.values[:4]
    assert by_lines.load_sharing.sel(definition="simultaneous").values[:4] == pytest.approx(
        np.max(4 * F / F.sum(axis=0), axis=1), rel=1e-7
    )
    assert any("far flank" in text for text in json.loads(by_lines.attrs["warnings"]))


def test_a_tight_mesh_presses_on_both_flanks(build: Any) -> None:
    """Errors that take more than the backlash: both flanks press although every loaded flank does."""
    system = with_backlash(build, variation=0.05)
    tight = np.zeros(8)
    tight[[1, 5]] = -3e-5
    system = replace(system, lines=(*system.lines, still(system, tight, tight)))
    result = static(system, StaticOptions(samples=8))
    assert result.far_share.values[[1, 5]].max() > 0
    assert not result.contact_lost.values[1] or not result.contact_lost.values[5]
    shared = sharing(system, SharingOptions(method="static", samples=8))
    np.testing.assert_allclose(shared.mesh_force, result.mesh_force, rtol=1e-7, atol=1e-6)
    assert np.isnan(shared.mesh_force_bound.values).all()


def test_far_flanks_stop_a_float_that_loaded_flanks_leave_free(build: Any) -> None:
    """One gear between two flanks with a radial float: wedged in by a load that the loaded flank alone cannot hold."""
    a = np.radians(20)
    base = pair(build, load=0.0, spring=0.0, error=(0.0, 0.0))
    two = build.planar(N=1).system()
    T = np.zeros((len(two.M), 2))
    T[0, 0] = T[2, 1] = 1.0
    small: System = build.reduced(two, T, ("main/sun/x", "main/sun/rz"), np.ones(2))
    loaded, behind = np.array([[np.sin(a)], [np.cos(a)]]), np.array([[np.sin(a)], [-np.cos(a)]])
    far = replace(base.far_flanks, B=behind)
    system = replace(
        small,
        meshes=replace(base.meshes, B=loaded),
        links=replace(small.links, stiffness=np.zeros_like(small.links.stiffness)),
        far=far,
        K=np.zeros((2, 2)),
        symmetries=(),
        lines=(),
    )
    push, turn = 1000.0, 50.0
    result = static(replace(system, force=np.array([push, turn])), StaticOptions(samples=1))
    # f1 sin a + f2 sin a = push, f1 cos a - f2 cos a = turn
    difference = turn / np.cos(a)
    assert result.mesh_force.item() == pytest.approx(difference, rel=1e-9)
    f2 = (push / np.sin(a) - difference) / 2
    assert np.sin(a) * result.displacement.values[0, 0] - np.cos(a) * result.displacement.values[1, 0] == pytest.approx(
        f2 / K + BACKLASH, rel=1e-9
    )
    assert result.far_share.item() == 1
    assert not result.contact_lost.item()


# tables and other laws ------------------------------------------------------------------------------------------------


def test_a_straight_table_in_static_is_the_linear_law(build: Any) -> None:
    system = one_pushed_back(build)
    assert system.far is not None
    plain = replace(
        system,
        meshes=replace(system.meshes, variation=np.zeros((8, 0), complex)),
        far=replace(system.far, variation=np.zeros((8, 0), complex)),
    )
    force = np.array([0.0, 100.0, 700.0, 3000.0])
    every = np.arange(8)
    law = replace(
        table_of(system, every), force=force, gap=np.tile(force / K, (6, 1)), slope=np.full((6, force.size), K)
    )
    laws = (LawRows(law=law.rows(every[::2]), rows=every[::2]), LawRows(law=law.rows(every[1::2]), rows=every[1::2]))
    assert plain.far is not None
    straight = replace(plain, meshes=replace(plain.meshes, laws=laws), far=replace(plain.far, laws=laws))
    ours, theirs = (static(s, StaticOptions(cycles=3, samples=7)) for s in (straight, plain))
    np.testing.assert_allclose(ours.mesh_force, theirs.mesh_force, rtol=1e-9, atol=1e-7)
    assert theirs.mesh_force.values.min() < 0
    np.testing.assert_allclose(ours.displacement, theirs.displacement, rtol=1e-7, atol=1e-14)


def lawful(build: Any) -> System:
    """Sun meshes of branches 1, 3 and of 2, 4 follow two tables, interleaved; ring meshes are linear."""
    system = with_backlash(build, variation=0.1)
    first = LawRows(law=table_of(system, [0, 2]), rows=np.array([0, 2]))
    second = LawRows(law=table_of(system, [3, 1], bend=0.8, seed=1), rows=np.array([3, 1]))
    return replace(system, far=None, meshes=replace(system.meshes, laws=(first, second)))


def test_tables_of_two_pairs_interleaved(build: Any) -> None:
    system = lawful(build)
    result = static(system, StaticOptions(samples=8))
    q = result.displacement.values.T / system.dofs.radius
    index = np.arange(len(q))
    here = excitation(system, TONE, index, 8)
    delta = q @ system.meshes.B - here.gap
    phases = (index / 8 % 1)[:, None]
    for part in system.meshes.laws:
        force, _ = part.law.at(phases).evaluate(delta[:, part.rows])
        np.testing.assert_allclose(result.mesh_force.values[part.rows].T, force, rtol=1e-6)
    np.testing.assert_allclose(result.mesh_force.values[4:].T, here.stiffness[:, 4:] * delta[:, 4:], rtol=1e-6)
    tangent = static(replace(system, meshes=replace(system.meshes, laws=())), StaticOptions(samples=8))
    assert np.abs(result.mesh_force - tangent.mesh_force).max() > 0.01 * tangent.mesh_force.max()


def test_sharing_by_static_follows_tables(build: Any) -> None:
    """The method that calls itself static takes no tangent: its forces are those of `static`."""
    system = lawful(build)
    shared = sharing(system, SharingOptions(method="static"))
    assert shared.attrs["samples"] == 32  # four branches: a multiple of them
    assert shared.attrs["worst_case"] == "every cycle of the common period"
    plain = static(system, StaticOptions(samples=32))
    np.testing.assert_array_equal(shared.mesh_force, plain.mesh_force)
    tangent = sharing(replace(system, meshes=replace(system.meshes, laws=())), SharingOptions(method="static"))
    assert np.abs(shared.load_sharing - tangent.load_sharing).max() > 1e-3
    constant = replace(system, meshes=replace(system.meshes, variation=np.zeros((8, 0), complex)))
    # a table varies with the mesh cycle although the series of its tangent may not
    assert "mesh cycles" in sharing(constant, SharingOptions(method="static")).attrs["record"]
    turning = replace(constant, lines=system.lines[:1], body_turns=(Fraction(7), *(Fraction(0),) * 6))
    for laws, period in ((system.meshes.laws, 7), ((), 1)):
        varying = replace(turning, meshes=replace(constant.meshes, laws=laws))
        assert record_of(varying, cycles=None, turns=None, of="main/sun", samples=1, most=100).period == period


def test_forces_behind_the_end_of_a_table_are_said(build: Any) -> None:
    system = lawful(build)
    heavy = replace(system, force=8 * system.force)
    for result in (static(heavy, StaticOptions(samples=4)), sharing(heavy, SharingOptions(method="static", samples=4))):
        (text,) = [text for text in json.loads(result.attrs["warnings"]) if "last force of its table" in text]
        assert "sun-planet" in text
    assert not any("table" in text for text in json.loads(static(system, StaticOptions(samples=4)).attrs["warnings"]))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Slopes:
    """Force that rises with k up to a corner and with `after` k behind it: two kinks a row."""

    k: Array
    corner: Array
    after: float

    @property
    def touch(self) -> Array:
        return np.zeros_like(self.k)

    @property
    def kinks(self) -> Array:
        return np.stack([self.touch, self.corner], axis=-1)

    def instants(self, chosen: Any) -> Slopes:
        return replace(self, k=self.k[chosen], corner=self.corner[chosen])

    def rows(self, chosen: Any) -> Slopes:
        return replace(self, k=self.k[:, chosen], corner=self.corner[:, chosen])

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        behind = delta > self.corner
        force = self.k * (np.clip(delta, 0, self.corner) + self.after * np.where(behind, delta - self.corner, 0.0))
        return force, np.where(delta > 0, self.k * np.where(behind, self.after, 1.0), 0.0)

    def energy(self, delta: Array) -> Array:
        front = np.clip(delta, 0, self.corner)
        behind = np.maximum(delta - self.corner, 0.0)
        return np.asarray(self.k * (front**2 / 2 + behind * front + self.after * behind**2 / 2))

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        spans = ((low[:, None] < self.kinks) & (self.kinks < high[:, None])).any(axis=(0, 2))
        return np.asarray(~spans)


@pytest.mark.parametrize("after", [50.0, 0.02])
def test_laws_of_several_kinks_find_the_least_energy_from_any_start(build: Any, after: float) -> None:
    """Rows with two kinks and rows with one, side by side; one answer from every start, and it is the minimum."""
    rng = np.random.default_rng(6)
    worst = 0
    for _ in range(30):
        N = int(rng.integers(3, 7))
        soft = 10 ** rng.uniform(6, 9, size=4)
        system = balanced_torque(build.planar(N=N, lateral=tuple(soft)).system(), TORQUE)
        gap = rng.normal(size=(4, 2 * N)) * 10 ** rng.uniform(-6, -4)
        flexible, k = compliance_of(system), np.full((4, 2 * N), K)
        rows = rng.permutation(2 * N)
        corner = 10 ** rng.uniform(-6, -4.5, size=(4, N))
        two = Slopes(k=k[:, :N], corner=corner, after=after)
        law = FlanksAt(parts=((two, rows[:N]), (LinearAt(stiffness=k[:, N:]), rows[N:])), count=2 * N)
        assert np.isnan(law.kinks).any()
        start = rng.normal(size=gap.shape) * 10 ** rng.uniform(-6, -4)
        force = np.tile(system.force, (4, 1))
        plain = equilibrium(flexible, stiffness=k, gap=gap, force=force, flanks=law)
        found = equilibrium(flexible, stiffness=k, gap=gap, force=force, flanks=law, start=start)
        worst = max(worst, int(plain.iterations.max()), int(found.iterations.max()))
        scale = np.abs(plain.mesh_force).max()
        np.testing.assert_allclose(found.mesh_force, plain.mesh_force, atol=1e-7 * scale)
        delta = plain.displacement @ system.meshes.B - gap
        np.testing.assert_allclose(law.evaluate(delta)[0], plain.mesh_force, atol=1e-6 * scale)
        slope = plain.displacement @ system.K - force + plain.mesh_force @ system.meshes.B.T
        assert np.abs(slope).max() < 1e-7 * np.abs(force).max()
    assert worst <= 16


def test_a_load_that_no_flank_holds_still_raises(build: Any) -> None:
    """Driven apart without backlash, and with far flanks that look the same way as the loaded ones."""
    system = with_backlash(build, torque=-TORQUE)
    with pytest.raises(ModelError, match="apart"):
        static(replace(system, far=None), StaticOptions(samples=2))
    assert system.far is not None
    useless = replace(system, far=replace(system.far, B=system.meshes.B.copy()))
    with pytest.raises(ModelError, match="apart"):
        static(useless, StaticOptions(samples=2))


def test_laws_of_links_and_far_flanks_together(build: Any) -> None:
    """The condensed problem with both kinds of rows: balance of every coordinate."""
    system = one_pushed_back(build)
    rows = [i for i, name in enumerate(system.links.name) if name.startswith("main/planet/1/bearing")]
    B = system.links.B[:, rows]
    group = LawGroup(
        name="main/planet/1/bearing",
        kind="bearing",
        rows=("x", "y"),
        B=B,
        law=Law(stiffness=2e8, clearance=5e-6),
        damping=np.zeros(2),
    )
    lines = tuple(replace(line, group_gap=np.zeros(2, complex)) for line in system.lines)
    left = np.where(np.isin(np.arange(len(system.links.name)), rows), 0.0, system.links.stiffness)
    links = replace(system.links, stiffness=left)
    system = replace(system, K=(links.B * left) @ links.B.T, links=links, groups=(group,), lines=lines)
    here = excitation(system, TONE, np.arange(21), 7)
    state = settled(held_train(system), here)
    assert state.far_force.max() > 0
    given = flanks(system)
    balance = state.displacement @ system.K - here.force + state.group_force @ B.T
    balance += np.hstack([state.mesh_force, state.far_force]) @ given.B.T
    assert np.abs(balance).max() < 1e-6 * np.abs(here.force).max()
    np.testing.assert_allclose(
        state.group_force, stacked((group,)).force(state.displacement @ B), atol=1e-6 * np.abs(state.group_force).max()
    )
    np.testing.assert_allclose(state.approach[:, :-2], state.displacement @ given.B, atol=1e-12)


@pytest.mark.parametrize("backlash", ["9.2 um", None])
def test_the_zero_of_each_sense_is_half_the_documented_play_away(backlash: str | None) -> None:
    """A set turned back by a small torque: its sun moves by the backlash of both meshes over its base radius."""
    data = epicyclic.planetary(teeth="18/27/72", planets=3, module="0.5 mm", torque=4.0, speed="500 rpm")
    mesh = {} if backlash is None else {"backlash": backlash}
    data["stages"]["main"]["meshes"] = {"sun-planet": mesh, "planet-ring": mesh}
    system = epicyclic.assemble(epicyclic.load(data))
    warnings = json.loads(static(system, StaticOptions(samples=1)).attrs["warnings"])
    said = [text for text in warnings if "zero-at-loaded-flank" in text]
    assert len(said) == (backlash is not None)
    if backlash is None:
        return
    assert "main.meshes.sun-planet 9.2 µm, main.meshes.planet-ring 9.2 µm" in said[0]

    def moved(factor: float) -> Array:
        """From one sense of the torque to the other (n,), both meshes linear."""
        ends = [replace(system, lines=(), force=sense * factor * system.force) for sense in (1, -1)]
        first, second = (static(end, StaticOptions(samples=1)).displacement.values[:, 0] for end in ends)
        return np.asarray((first - second) / system.dofs.radius)

    play = 2 * moved(1e-3) - moved(2e-3)
    sun, carrier = (system.dofs.names.index(f"main/{member}/rz") for member in ("sun", "carrier"))
    free = compliance_of(system).free[:, 0]
    beside_carrier = play[sun] - play[carrier] * free[sun] / free[carrier]
    assert beside_carrier == pytest.approx(2 * 9.2e-6 / (4.5e-3 * np.cos(np.radians(20))), rel=1e-7)
