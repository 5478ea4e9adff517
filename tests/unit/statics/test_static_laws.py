"""Static equilibrium, records and linearisation with play, rolling elements and splines."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.sharing import SharingOptions
from epicyclic.questions.sharing.definitions import known_mean_loads, labelled, train_coefficient
from epicyclic.questions.sharing.sharing import sharing
from epicyclic.questions.sharing.tone_forces import cycle_starts, forces_of_equilibria, record_extremes
from epicyclic.results.dataset import load_result, save_result
from epicyclic.statics import StaticOptions
from epicyclic.statics.equilibrium import compliance_of, equilibrium
from epicyclic.statics.record import Record, excitation, parallel_meshes, record_of
from epicyclic.statics.static import held_train, quasi_static, static
from epicyclic.statics.tangent import linear
from epicyclic.system.link_laws import Law, LawGroup
from epicyclic.system.system import Line, LinkRows, System

Array = NDArray[np.float64]
TORQUE = 300.0


def with_laws(system: System, laws: dict[str, Law]) -> System:
    """The system with the x and y rows of some links taken out of K and put into groups."""
    links, groups = system.links, []
    kept = np.ones(len(links.name), dtype=bool)
    for name, one in laws.items():
        rows = [i for i, row in enumerate(links.name) if row in (f"{name}/x", f"{name}/y")]
        B = links.B[:, rows]
        kept[rows] = False
        named = tuple(links.name[i] for i in rows)
        groups.append(LawGroup(name=name, kind="support", rows=named, B=B, law=one, damping=np.zeros(2)))
    left = LinkRows(
        name=tuple(np.array(links.name)[kept]),
        link=tuple(np.array(links.link)[kept]),
        B=links.B[:, kept],
        stiffness=links.stiffness[kept],
        damping=links.damping[kept],
    )
    K = (left.B * left.stiffness) @ left.B.T
    return replace(system, K=K, links=left, groups=tuple(groups))


def loaded(system: System, torque: float = TORQUE) -> System:
    """Torque on the sun, balanced at the carrier along the free motion."""
    free = compliance_of(system).free[:, 0]
    force = np.zeros(len(system.M))
    force[2], force[8] = torque, -torque * free[2] / free[8]
    return replace(system, force=force)


def random_case(build: Any, rng: np.random.Generator, *, pins: bool) -> tuple[System, Array]:
    N = int(rng.integers(3, 8))
    soft = 10 ** rng.uniform(6, 9, size=4)
    names = ["main/sun/support", *(f"main/planet/{i + 1}/bearing" for i in range(N) if pins)]

    def some(name: str) -> Law:
        k = float(soft[0] if "sun" in name else soft[3])
        clearance = float(rng.choice([0, 2e-6, 1e-5, 5e-5]))
        return [
            Law(stiffness=k, clearance=clearance, friction=float(10 ** rng.uniform(0, 3)) * ("sun" in name)),
            Law(stiffness=k, clearance=clearance),
            Law(stiffness=k, clearance=clearance, exponent=10 / 9, load=1000.0),
        ][int(rng.integers(0, 3))]

    system = loaded(with_laws(build.planar(N=N, lateral=tuple(soft)).system(), {name: some(name) for name in names}))
    rows = 2 * N + 2 * len(names)
    return system, np.asarray(rng.normal(size=(4, rows)) * 10 ** rng.uniform(-6, -4))


@pytest.mark.parametrize(("pins", "usual"), [(False, 10), (True, 20)])
def test_least_energy_from_any_start(build: Any, pins: bool, usual: int) -> None:
    """40 cases, four errors each: one answer from every start, and it is the minimum.

    Rolling elements have no stiffness at first touch, where Newton steps gain a digit each: those take most steps,
    15 to 17 by the rounding that lets a full step stand or not.
    """
    rng = np.random.default_rng(3)
    default, anywhere, smooth = 0, 0, 0
    for _ in range(40):
        system, gap = random_case(build, rng, pins=pins)
        flexible, laws, m = compliance_of(system), system.laws, len(system.meshes.name)
        k = system.meshes.stiffness * rng.uniform(0.7, 1.3, size=(4, m))
        force = np.tile(system.force, (4, 1))
        start = rng.normal(size=gap.shape) * 10 ** rng.uniform(-6, -4)
        plain = equilibrium(flexible, stiffness=k, gap=gap, force=force, laws=laws)
        found = equilibrium(flexible, stiffness=k, gap=gap, force=force, laws=laws, start=start)
        default, anywhere = max(default, int(plain.iterations.max())), max(anywhere, int(found.iterations.max()))
        if all(getattr(group.law, "exponent", 1) == 1 for group in system.groups):
            smooth = max(smooth, int(found.iterations.max()))
        scale = np.abs(plain.mesh_force).max()
        # 1e-10 of the largest term k w, which exceeds the forces where supports are soft
        np.testing.assert_allclose(found.mesh_force, plain.mesh_force, atol=1e-7 * scale)
        # the energy is convex: equilibrium and the laws at that place prove the minimum
        slope = plain.displacement @ system.K - force + plain.mesh_force @ system.meshes.B.T
        slope += plain.group_force @ system.group_rows.T
        assert np.abs(slope).max() < 1e-7 * np.abs(force).max()
        stretch = plain.displacement @ system.group_rows - gap[:, m:]
        np.testing.assert_allclose(plain.group_force, laws.force(stretch), atol=1e-6 * scale)
    assert default <= usual
    assert smooth <= 15
    assert anywhere <= 30


def test_a_law_that_is_linear_is_the_link(build: Any) -> None:
    plain = loaded(build.planar(N=4).system())
    lawful = with_laws(plain, {"main/sun/support": Law(stiffness=1e8), "main/planet/2/bearing": Law(stiffness=1e8)})
    rng = np.random.default_rng(1)
    line = Line(
        frequency=Fraction(0),
        gap=np.asarray(1e-5 * rng.normal(size=8), complex),
        link_gap=np.zeros(0, complex),
        force=np.zeros((3, len(plain.force)), complex),
    )
    both = [
        static(
            replace(s, lines=(replace(line, link_gap=np.zeros(len(s.links.name), complex)),)), StaticOptions(samples=1)
        )
        for s in (plain, lawful)
    ]
    np.testing.assert_allclose(both[1].mesh_force, both[0].mesh_force, rtol=1e-9)  # two dense solves
    np.testing.assert_allclose(both[1].displacement, both[0].displacement, rtol=1e-7, atol=1e-15)


# linear analyses -----------------------------------------------------------------------------------------------------

LAWS = {
    "main/sun/support": Law(stiffness=5e7, clearance=2e-6, friction=2000.0),
    "main/planet/1/bearing": Law(stiffness=1e8, clearance=1e-5),
    "main/planet/2/bearing": Law(stiffness=1e8, clearance=1e-5, exponent=10 / 9, load=1000.0),
    "main/planet/3/bearing": Law(stiffness=1e8, clearance=4e-6, friction=100.0, memory=True),
}


def shifted(system: System, gap: Array, group_gap: Array) -> System:
    """With constant errors."""
    still = Line(
        frequency=Fraction(0),
        gap=gap.astype(complex),
        link_gap=np.zeros(len(system.links.name), complex),
        force=np.zeros((3, len(system.force)), complex),
        group_gap=group_gap.astype(complex),
    )
    return replace(system, lines=(still,))


def test_linearised_has_the_tangent_and_the_mean_of_the_laws(build: Any) -> None:
    rng = np.random.default_rng(2)
    radial = {name: replace(one, memory=False) for name, one in LAWS.items()}
    system = loaded(with_laws(build.planar(N=3).system(), radial), 800.0)
    gap, group_gap = 4e-6 * rng.normal(size=6), 4e-6 * rng.normal(size=8)
    system = shifted(system, gap, group_gap)
    tangents = linear(system)
    here, there = static(system, StaticOptions(samples=1)), static(tangents, StaticOptions(samples=1))
    still_there, still_here = held(there, system), held(here, system)
    np.testing.assert_allclose(still_there, still_here, atol=1e-9 * np.abs(still_here).max())
    # a small step of the errors: both answer alike, to the curvature of the laws
    step, group_step = 1e-10 * rng.normal(size=6), 1e-10 * rng.normal(size=8)
    moved = shifted(system, gap + step, group_gap + group_step)
    still = tangents.lines[0]
    force = still.force.copy()
    tangent = system.laws.tangent(static_stretch(system))
    force[0] += system.group_rows @ (tangent @ group_step)
    shifted_line = replace(still, gap=still.gap + step, force=force)
    first = held(static(moved, StaticOptions(samples=1)), system) - still_here
    second = held(static(replace(tangents, lines=(shifted_line,)), StaticOptions(samples=1)), system) - still_there
    np.testing.assert_allclose(second, first, atol=2e-4 * float(np.abs(first).max()))
    # the tangent of play differs along the load and across it, that of a link alike in x and y has no axes of its own
    assert tangents.links.name[-2:] == ("main/planet/3/bearing/radial", "main/planet/3/bearing/tangential")


def held(result: Any, system: System) -> Array:
    """Displacement (n,) without the turning of the train, of which each system leaves its own part."""
    free = compliance_of(system).free * system.dofs.radius[:, None]
    values = result.displacement.values[:, 0]
    return np.asarray(values - free @ np.linalg.lstsq(free, values, rcond=None)[0])


def static_stretch(system: System) -> Array:
    flexible = compliance_of(system)
    line = system.lines[0]
    gap = np.concatenate([line.gap, line.group_gap]).real
    state = equilibrium(
        flexible,
        stiffness=system.meshes.stiffness[None],
        gap=gap[None],
        force=system.force[None],
        laws=system.laws,
    )
    return np.asarray(state.group_stretch[0])


def test_linear_analyses_say_which_stiffness_they_take(build: Any) -> None:
    plain = build.planar(N=3).system()
    system = loaded(with_laws(plain, LAWS), 800.0)
    said = json.loads(epicyclic.modes(system).attrs["warnings"])
    assert [text.split(": ")[1] for text in said] == list(LAWS)
    sun, pin, rolling, spline = said
    assert "sticking at the mean load, stiffness along it 5e+07 N/m, across 5e+07 N/m" in sun
    assert "play pressed at the mean load, stiffness along it 1e+08 N/m" in pin
    assert "rolling elements with play" in rolling
    assert "sticks in small vibration, stiffness 1e+08 N/m" in spline
    assert abs(static_stretch(shifted(system, np.zeros(6), np.zeros(8)))[-1]) > 5e-6  # though under load it has slipped
    np.testing.assert_allclose(linear(system).links.stiffness[-2:], 1e8, rtol=1e-12)
    idle = replace(system, force=0 * system.force)
    assert any("inside its clearance" in text for text in json.loads(epicyclic.modes(idle).attrs["warnings"]))
    for result in (
        epicyclic.campbell(replace(system, tones=(Fraction(100),)), relative_speeds=[0.0]),
        epicyclic.steady(replace(system, tones=(Fraction(100),), zeta=0.03)),
        epicyclic.sweep(replace(system, tones=(Fraction(100),), zeta=0.03), points=2),
        sharing(replace(system, tones=(Fraction(100),), zeta=0.03), SharingOptions()),
    ):
        assert sum("linearised" in text for text in json.loads(result.attrs["warnings"])) == 4
    assert linear(plain) is plain


def test_modes_of_a_law_are_those_of_its_tangent(build: Any) -> None:
    """Pins with play that all bear alike: k along the load, F/delta across it, put in as links by hand."""
    play, torque = 1e-5, 800.0
    plain = build.planar(N=3).system()
    lawful = loaded(
        with_laws(plain, {f"main/planet/{i}/bearing": Law(stiffness=1e8, clearance=play) for i in (1, 2, 3)}), torque
    )
    result = epicyclic.modes(lawful)
    state = static(lawful, StaticOptions(samples=1))
    force, stretch = state.group_force.values[:, 0], state.group_stretch.values[:, 0]
    names = plain.links.name
    stiffness = plain.links.stiffness.copy()
    for i in range(3):
        x, y = (names.index(f"main/planet/{i + 1}/bearing/{d}") for d in "xy")
        stiffness[x], stiffness[y] = force[i] / stretch[i], 1e8  # a pin is pushed tangentially
    B = plain.links.B
    expected = epicyclic.modes(replace(plain, K=(B * stiffness) @ B.T))
    # the mesh forces push a pin along y but for rounding
    np.testing.assert_allclose(result.frequency[1:], expected.frequency[1:], rtol=1e-7)
    assert result.mode_kind.values.tolist() == expected.mode_kind.values.tolist()


# records -------------------------------------------------------------------------------------------------------------


def turning(build: Any, laws: dict[str, Law], *, seed: int = 0, size: float = 5e-6) -> System:
    """A set with two slow lines, mesh frequency 60 Hz, bodies that turn."""
    rng = np.random.default_rng(seed)
    system = loaded(with_laws(build.planar(N=3).system(), laws), 800.0)
    n, p, R = len(system.force), len(system.links.name), system.group_rows.shape[1]

    def line(frequency: Fraction) -> Line:
        def gap(count: int) -> NDArray[np.complex128]:
            return np.asarray(size * (rng.normal(size=count) + 1j * rng.normal(size=count)), complex)

        return Line(
            frequency=frequency, gap=gap(6), link_gap=0 * gap(p), force=np.zeros((3, n), complex), group_gap=gap(R)
        )

    turns = (Fraction(5), Fraction(0), Fraction(3), *(Fraction(4),) * 3)
    return replace(system, tones=(Fraction(60),), lines=(line(Fraction(4)), line(Fraction(5))), body_turns=turns)


def test_history_in_parts_is_that_of_one_long_walk(build: Any) -> None:
    laws = {"main/sun/support": Law(stiffness=1e8, clearance=4e-6, friction=120.0, memory=True)}
    system = turning(build, laws)
    record = record_of(system, cycles=None, turns=2, of="main.sun", samples=20, most=100)
    flexible, many = compliance_of(system), system.laws
    slider, expected, states = np.zeros(2), [], set()
    for i in range(-record.instants, record.instants):
        here = excitation(system, record.unit, np.array([i], dtype=np.int64), record.samples)
        state = equilibrium(
            flexible, stiffness=here.stiffness, gap=here.gap, force=here.force, laws=many, anchor=slider[None]
        )
        states.add(int(many.state(state.group_stretch, slider[None])[0, 0]))
        slider = many.slide(state.group_stretch, slider[None])[0]
        expected.append(state.mesh_force[0])
    assert states == {1, 2, 3}  # stick, slip and stop all occur
    found = np.concatenate([piece.state.mesh_force for piece in quasi_static(held_train(system), record)])
    # sliders of adjoining parts agree to 1e-8 of the friction force
    np.testing.assert_allclose(found, expected[record.instants :], atol=1e-6)
    assert (
        "warm-up over 2 turns of main.sun"
        in static(system, StaticOptions(turns=2, of="main.sun", samples=20)).attrs["history"]
    )


def test_record_in_turns_of_a_body(build: Any) -> None:
    system = turning(build, {})
    record = record_of(system, cycles=None, turns=None, of="main/sun", samples=8, most=10**6)
    assert (record.unit, record.count, record.period) == (
        Fraction(5),
        5,
        5,
    )  # lines of 4 and 5 Hz in turns of 5 Hz: a second
    short = record_of(system, cycles=None, turns=2, of="main/sun", samples=8, most=10)
    least, most = np.array([2.0, 3.0]), np.array([2.0, 3.5])
    assert short.warnings(least, most) == [
        "record of 2 turns of main/sun is shorter than the common period of 5; --turns takes more of it [short-record]"
    ]
    assert short.warnings(least, least) == []  # what stands still has its extremes in any record
    np.testing.assert_array_equal(record.index, np.arange(5 * 8))
    apart = replace(record, count=2, spread=True)  # of five turns the first and the fourth
    assert apart.index.tolist() == [*range(8), *range(24, 32)]
    slow = record_of(system, cycles=None, turns=None, of=None, samples=8, most=10**6, slow=True)
    assert (slow.unit, slow.period) == (Fraction(5), 5)
    result = static(system, StaticOptions(turns=5, of="main/sun", samples=24))
    cycles = static(system, StaticOptions(cycles=60, samples=2))  # the same instants, counted in mesh cycles
    np.testing.assert_allclose(result.time, cycles.time, rtol=1e-14)
    np.testing.assert_allclose(result.mesh_force, cycles.mesh_force, rtol=1e-9)
    assert json.loads(result.attrs["options"]) == {"turns of main/sun": 5, "samples": 24}


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"turns": 3}, "of: turns are counted of a body that turns"),
        ({"turns": 3, "of": "main/ring"}, "main/sun, main/carrier"),
        ({"turns": 3, "of": "main/sun", "cycles": 2}, "one length"),
        ({"turns": 0, "of": "main/sun"}, "turns = 0"),
    ],
)
def test_bad_records(build: Any, options: dict[str, Any], word: str) -> None:
    with pytest.raises(ModelError, match=word):
        epicyclic.static(turning(build, {}), **options)
    with pytest.raises(ModelError, match=word):
        epicyclic.sharing(turning(build, {}), method="static", **options)
    with pytest.raises(ModelError, match=word if options["turns"] == 0 else "static"):
        epicyclic.sharing(replace(turning(build, {}), zeta=0.03), **options)


def sharing_of_record(system: System, record: Record, stored: int | None = None) -> xr.Dataset:
    """Load sharing over a record whose instants are solved one by one, whatever the train."""
    forces = forces_of_equilibria(system, record, stored)
    return labelled(system, forces, known_mean_loads(system), method="static", relative_speed=1.0, limit=None)


def test_two_ways_to_the_same_sharing(build: Any) -> None:
    """A record of equilibria gives what the superposed lines give, mesh cycle by mesh cycle, with varying stiffness."""
    system = turning(build, {}, size=1e-5)
    variation = 0.2 * np.exp(2j * np.pi * np.random.default_rng(7).random(size=(6, 2)))
    system = replace(system, meshes=replace(system.meshes, variation=variation))
    known = sharing(system, SharingOptions(method="static", cycles=60, samples=16))
    record = record_of(system, cycles=60, turns=None, of=None, samples=16, most=1)
    found = sharing_of_record(system, record)
    for name in ("load_sharing", "system_load_sharing", "load_sharing_history", "mesh_force"):
        # equilibria stop at 1e-10 of the forces
        np.testing.assert_allclose(found[name], known[name], rtol=1e-7)
    assert found.contact_lost.values.tolist() == known.contact_lost.values.tolist()
    window = sharing_of_record(system, replace(record, count=10), stored=3)
    assert np.isnan(window.load_sharing.sel(definition="worst-case")).all()
    assert np.isnan(window.system_load_sharing.sel(definition="worst-case"))
    assert window.sizes["time"] == 48
    assert any("shorter than the common period" in t or "hunting" in t for t in json.loads(window.attrs["warnings"]))


def test_sharing_with_several_mesh_frequencies(build: Any) -> None:
    """Two sets that do not touch share as each alone, each counted in its own mesh cycles."""
    one, two = turning(build, {}, seed=1, size=2e-5), turning(build, {}, seed=2, size=2e-5)
    pair = tuple(name.replace("main", "second") for name in two.meshes.pair)
    both = build.side_by_side(one, replace(two, meshes=replace(two.meshes, pair=pair)))
    lines = tuple(
        replace(
            a,
            gap=np.concatenate([a.gap, b.gap]),
            link_gap=np.concatenate([a.link_gap, b.link_gap]),
            force=np.hstack([a.force, b.force]),
        )
        for a, b in zip(one.lines, two.lines, strict=True)
    )
    tone = np.repeat([0, 1], 6)
    both = replace(
        both,
        tones=(Fraction(60), Fraction(45)),
        lines=lines,
        force=np.concatenate([one.force, two.force]),
        meshes=replace(both.meshes, tone=tone),
    )
    result = sharing(
        both, SharingOptions(method="static", cycles=60, samples=48)
    )  # a second, in cycles of each set's own
    two = replace(two, tones=(Fraction(45),))
    alone = [
        sharing(one, SharingOptions(method="static", cycles=60, samples=48)),
        sharing(two, SharingOptions(method="static", cycles=45, samples=48)),
    ]
    for i, each in enumerate(alone):
        part = result.load_sharing.values[:, 6 * i : 6 * i + 6]
        np.testing.assert_allclose(part, each.load_sharing.values, rtol=1e-7)  # equilibria


def test_cycles_of_a_record_are_counted_exactly(build: Any) -> None:
    system = turning(build, {})
    record = Record(unit=Fraction(7), name="turns", count=3, samples=5, period=1)
    starts = cycle_starts(system, np.array([0]), record)
    by_hand = [int(Fraction(i, 5) / 7 * 60) for i in range(15)]
    assert starts.tolist() == [0] + [i for i in range(1, 15) if by_hand[i] != by_hand[i - 1]]
    force = np.abs(np.random.default_rng(0).normal(size=(15, 6))) + 1
    tally = record_extremes(force, parallel_meshes(system.meshes), [starts, starts])
    for group in parallel_meshes(system.meshes):
        peaks = np.array([force[np.array(by_hand) == c][:, group].max(axis=0) for c in dict.fromkeys(by_hand)])
        b = 3 * peaks / peaks.sum(axis=1, keepdims=True)
        np.testing.assert_allclose(tally.ratio_high[group], b.max(axis=0), rtol=1e-15)
        np.testing.assert_allclose(tally.ratio_low[group], b.min(axis=0), rtol=1e-15)
    assert np.isnan(train_coefficient(np.array([[np.nan, np.nan], [1.0, np.nan]]))).tolist() == [True, False]


def test_states_are_saved_and_read(build: Any, tmp_path: Path) -> None:
    result = static(turning(build, LAWS), StaticOptions(cycles=2, samples=8))
    assert set(result.group_state.values.ravel()) <= {"play", "stick", "slip", "stop"}
    assert result.group_force.sizes == {"group": 4, "time": 16}
    again = load_result(save_result(result, tmp_path / "static.nc"))
    assert again.identical(result)
    shared = sharing(turning(build, LAWS), SharingOptions(method="static", cycles=2, samples=8, stored_cycles=1))
    assert shared.group_state.sizes == {"group": 4, "time": 8}
    assert shared.mesh_contact.dtype == bool
    assert set(json.loads(shared.attrs["laws"])) == set(LAWS)


def test_positions_without_any_support_are_said(build: Any) -> None:
    """Sun and ring free, carrier rigid: sharing is unique, the place of the sun is not, and the result says so."""
    system = build.planar(N=5, lateral=(0.0, 0.0, 1e8, 1e8), torsion=(0.0, 0.0, 0.0)).system()
    pins = {f"main/planet/{i + 1}/bearing": Law(stiffness=1e8, clearance=1e-6 * i) for i in range(5)}
    free = compliance_of(system).free
    force = np.zeros(len(system.force))
    force[2] = 800.0
    force[[5, 8]] = np.linalg.lstsq(free[[5, 8]].T, -free.T @ force, rcond=None)[0]
    result = static(replace(with_laws(system, pins), force=force), StaticOptions(samples=1))
    assert any("not unique" in text for text in json.loads(result.attrs["warnings"]))
    np.testing.assert_allclose(result.mesh_force.values[:5].sum(), 800.0 / (0.07742 / 2), rtol=1e-9)
