"""Load-sharing definitions on made-up responses, against loops written straight from the words."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.response import SteadyOptions
from epicyclic.questions.response.measures import Periodic, ShaftLine, periodic
from epicyclic.questions.response.steady import steady
from epicyclic.questions.sharing import SharingOptions, tone_forces
from epicyclic.questions.sharing.definitions import (
    DEFINITIONS,
    cycle_forces,
    extremes,
    independent_blocks,
    line_phases,
    merge_extremes,
    periodic_waves,
    worst_case,
)
from epicyclic.questions.sharing.sharing import sharing
from epicyclic.questions.sharing.tone_forces import Method, mean_force
from epicyclic.questions.sharing.views import tables
from epicyclic.results.dataset import load_result, save_result
from epicyclic.statics import StaticOptions
from epicyclic.statics.equilibrium import compliance_of, equilibrium
from epicyclic.statics.load_map import MEAN_LOADS
from epicyclic.statics.record import excitation, parallel_meshes
from epicyclic.statics.static import static
from epicyclic.system.system import Line, System, faces

Array = NDArray[np.float64]
TONE = Fraction(273, 10)


def made_up(m: int, ratios: tuple[Fraction, ...], *, seed: int = 0, size: float = 0.05, samples: int = 16) -> Periodic:
    """A response with smooth random mesh-order and shaft parts about a mean of 1000 N."""
    rng = np.random.default_rng(seed)
    theta = np.arange(samples) / samples
    waves = np.exp(2j * np.pi * np.outer(np.arange(3), theta))

    def smooth() -> NDArray[np.complex128]:
        parts = (rng.normal(size=(m, 3)) + 1j * rng.normal(size=(m, 3))) * [1.0, 0.3, 0.1]
        return np.asarray(1000.0 * size * (parts @ waves))

    return Periodic(
        tone=TONE,
        relative_speed=1.0,
        theta=theta,
        force=1000.0 + smooth().real,
        displacement=np.zeros((1, samples)),
        lines=tuple(
            ShaftLine(frequency=ratio * TONE, causes=(), force=smooth(), displacement=np.zeros((1, samples), complex))
            for ratio in ratios
        ),
        harmonics=3,
        residual=0.0,
    )


def at(solution: Periodic, cycle: int, j: int) -> Array:
    """Force of each mesh at sample j of a cycle, by the formula of the response."""
    t = (cycle + solution.theta[j]) / float(solution.tone)
    total = solution.force[:, j].copy()
    for line in solution.lines:
        total += (line.force[:, j] * np.exp(2j * np.pi * float(line.frequency) * t)).real
    return total


def by_hand(solution: Periodic, members: list[list[int]], cycles: int) -> dict[str, Array]:
    """The definitions in plain loops."""
    record = np.array([[at(solution, c, j) for j in range(len(solution.theta))] for c in range(cycles)])
    result = {name: np.zeros(record.shape[2]) for name in DEFINITIONS if name not in MEAN_LOADS}
    for group in members:
        N = len(group)
        for i in group:
            b = []
            for c in range(cycles):
                peaks = [max(record[c, :, j]) for j in group]
                b.append(N * max(record[c, :, i]) / sum(peaks))
            result["cycle-peak"][i] = 1 + max(abs(value - 1) for value in b)
            result["signed-overload"][i] = max(b)
            flat = record.reshape(-1, record.shape[2])
            result["simultaneous"][i] = max(N * row[i] / sum(row[j] for j in group) for row in flat)
            result["record-peak"][i] = N * max(flat[:, i]) / sum(max(flat[:, j]) for j in group)
    return result


@pytest.fixture
def respond(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Let `sharing` meet a made-up response."""

    def use(solution: Periodic) -> None:
        monkeypatch.setattr(tone_forces, "periodic_by_tone", lambda system, **_: (solution,))

    return use


def test_definitions_in_plain_words(build: Any, respond: Any) -> None:
    solution = made_up(6, (Fraction(1, 5), Fraction(2, 7)))
    respond(solution)
    result = sharing(build.planar(N=3).system(), SharingOptions())
    assert result.attrs["hunting_period"] == 35
    expected = by_hand(solution, [[0, 1, 2], [3, 4, 5]], 35)
    expected["worst-case"] = expected["cycle-peak"]
    for name in expected:
        # the same sums in another order
        np.testing.assert_allclose(result.load_sharing.sel(definition=name).values, expected[name], rtol=1e-12)
        assert result.system_load_sharing.sel(definition=name).item() == pytest.approx(max(expected[name]), rel=1e-12)
    assert result.attrs["worst_case"] == "every cycle of the hunting period"
    assert json.loads(result.attrs["warnings"]) == []
    # the definitions differ here: none stands in for another
    values = result.load_sharing.values
    assert all(np.abs(values[i] - values[j]).max() > 1e-4 for i in range(4) for j in range(i))


def test_pieces_of_a_record_make_the_whole(build: Any) -> None:
    solution = made_up(6, (Fraction(1, 5), Fraction(2, 7)))
    waves, members = periodic_waves(solution), parallel_meshes(build.planar(N=3).system().meshes)
    force = cycle_forces(waves, line_phases(waves.ratios, np.arange(35)))
    whole = extremes(force, members)
    for cut in (1, 12, 30):
        for pieces in ((force[:cut], force[cut:]), (force[cut:], force[:cut])):
            joined = merge_extremes(*(extremes(piece, members) for piece in pieces))
            for name in ("ratio_high", "ratio_low", "simultaneous", "peak", "least"):
                np.testing.assert_array_equal(getattr(joined, name), getattr(whole, name))


def test_underload_counts_in_cycle_peak_only(build: Any, respond: Any) -> None:
    """One mesh at 0.4 of the mean, five at 1.12: [ren2021, eq. 22] calls the light one 1.6."""
    solution = made_up(12, ())
    share = np.array([0.4, 1.12, 1.12, 1.12, 1.12, 1.12] * 2)
    respond(replace(solution, force=1000.0 * np.tile(share[:, None], (1, 16))))
    result = sharing(build.planar(N=6).system(), SharingOptions())
    cycle, overload = (
        result.load_sharing.sel(definition="cycle-peak"),
        result.load_sharing.sel(definition="signed-overload"),
    )
    np.testing.assert_allclose(cycle.values[:2], [1.6, 1.12], rtol=1e-12)
    np.testing.assert_allclose(overload.values[:2], [0.4, 1.12], rtol=1e-12)
    assert result.system_load_sharing.sel(definition="simultaneous").item() == pytest.approx(1.12, rel=1e-12)


def test_groups_are_pairs_and_sides(build: Any) -> None:
    meshes = build.planar(N=2).system().meshes
    sided = replace(meshes, side=("left", "right", "left", "right"))
    assert [group.tolist() for group in parallel_meshes(meshes)] == [[0, 1], [2, 3]]
    assert [group.tolist() for group in parallel_meshes(sided)] == [[0], [1], [2], [3]]


def test_record_and_history(build: Any, respond: Any) -> None:
    solution = made_up(6, (Fraction(1, 23),))
    respond(solution)
    done: list[float] = []
    result = sharing(build.planar(N=3).system(), SharingOptions(cycles=10, stored_cycles=4), progress=done.append)
    assert result.sizes["time"] == 4 * 16
    assert done[-1] == 1.0
    stored = np.array([at(solution, c, j) for c in range(4) for j in range(16)]).T
    np.testing.assert_allclose(result.mesh_force.values, stored, rtol=1e-12)
    np.testing.assert_allclose(
        result.load_sharing_history.values[:3], 3 * stored[:3] / stored[:3].sum(axis=0), rtol=1e-12
    )
    np.testing.assert_allclose(result.time.values[16], 1 / float(TONE), rtol=1e-12)
    assert any("shorter than the hunting period of 23" in text for text in json.loads(result.attrs["warnings"]))
    # the worst case still is of the whole period
    whole = sharing(build.planar(N=3).system(), SharingOptions())
    np.testing.assert_allclose(result.load_sharing.values[4], whole.load_sharing.values[4], rtol=1e-12)
    assert np.all(whole.load_sharing.values[0] >= result.load_sharing.values[0])


@pytest.mark.parametrize(
    "record",
    [
        {"cycles": 100},
        {"cycles": 100, "method": "static"},
        {"turns": 3, "of": "main/carrier", "samples": 7, "method": "static"},
    ],
)
def test_mean_least_and_most_are_of_the_whole_record(record: dict[str, Any]) -> None:
    system = epicyclic.assemble(epicyclic.load("ren2021"))
    few, every = (sharing(system, SharingOptions(**record, stored_cycles=count)) for count in (1, 100))
    force, unit = every.mesh_force, "mesh cycles" if "cycles" in record else "turns of main/carrier"
    count = record.get("cycles", 3)
    assert few.sizes["time"] * count == every.sizes["time"]
    assert (few.mesh_force.max("time") < force.max("time")).any()
    np.testing.assert_allclose(few.mesh_force_peak, force.max("time"), rtol=1e-12)
    np.testing.assert_allclose(few.mesh_force_minimum, force.min("time"), rtol=1e-12)
    # of a short record the mean load is known better than its mean
    np.testing.assert_allclose(few.mesh_force_mean, force.mean("time"), rtol=0.1)
    printed = {table.title: table.columns for table in tables(few)}
    columns = printed["Mesh forces along the tooth normal, over the whole record"]
    assert columns["most [N]"] == few.mesh_force_peak.values.tolist()
    titles = [table.title for table in tables(few.drop_vars("mesh_force_peak"))]
    assert f"Mesh forces along the tooth normal, the first 1 of {count} {unit}" in titles


def test_bound_is_above_all_and_nearly_met(build: Any, respond: Any) -> None:
    solution = made_up(6, (Fraction(1, 23), Fraction(1, 17)), samples=32)
    respond(solution)
    result = sharing(build.planar(N=3).system(), SharingOptions(stored_cycles=23 * 17))
    highest = result.mesh_force.max("time").values
    bound = result.mesh_force_bound.values
    assert np.all(highest <= bound * (1 + 1e-12))
    # phases are discrete: each line misses its crest by 1 - cos(pi/z) < 1.8 % at most, and there are two
    reach = sum(np.abs(line.force).max(axis=1) for line in solution.lines)
    assert np.all(bound - highest <= (1 - math.cos(math.pi / 17)) * reach)


def test_tension_is_called_invalid(build: Any, respond: Any) -> None:
    respond(made_up(6, (Fraction(1, 5),), size=0.8, seed=2))
    result = sharing(build.planar(N=3).system(), SharingOptions())
    assert result.contact_lost.values.any()
    assert any("linear model invalid" in text for text in json.loads(result.attrs["warnings"]))


def test_worst_case_by_grid_equals_exhaustion(build: Any) -> None:
    ratios = (Fraction(1, 23), Fraction(2, 23), Fraction(1, 17), Fraction(1, 57))
    waves = periodic_waves(made_up(6, ratios, samples=8))
    members = parallel_meshes(build.planar(N=3).system().meshes)
    all_values, every = worst_case(lambda p: cycle_forces(waves, p), ratios, members, meshes=6, points=22287)
    assert every
    found, every = worst_case(lambda p: cycle_forces(waves, p), ratios, members, meshes=6, points=1500)
    assert not every
    assert np.all(found <= all_values * (1 + 1e-12))  # visits only phases that occur
    # a pattern search on a smooth function of three phases from the best of 1500 points: at most a step short
    np.testing.assert_allclose(found, all_values, atol=1e-4)


def test_worst_case_of_tied_lines() -> None:
    """Tooth numbers with a common factor: no phase moves alone, neighbours along one line are far along the others."""
    ratios = [Fraction(1, 21), Fraction(2, 39), Fraction(4, 99)]
    turns = np.array([[0.02, 0.29, 0.61], [0.37, 0.66, 0.12], [0.71, 0.93, 0.44]])

    def source(phases: Array) -> Array:
        """Forces of three meshes, with sharp peaks."""
        waves = np.cos(2 * np.pi * (phases[:, None, :] + turns)) * [0.03, 0.02, 0.025]
        found: Array = (1 + waves.sum(axis=2) + 4 * waves.prod(axis=2) / 0.025**2)[:, :, None]
        return found

    members = [np.arange(3)]
    exact, every = worst_case(source, ratios, members, meshes=3, points=9009)
    assert every
    for points, least in ((64, 0.92), (512, 0.99)):
        found, every = worst_case(source, ratios, members, meshes=3, points=points)
        assert not every
        assert np.all(found <= exact)
        assert np.all(found - 1 >= least * (exact - 1))


def test_worst_case_with_huge_periods(build: Any) -> None:
    """Two speeds without a common measure worth naming: the grid still answers, below the two-line bound."""
    ratios = (Fraction(10**12 + 39, 10**13 + 37), Fraction(1, 17))
    waves = periodic_waves(made_up(6, ratios, samples=8))
    members = parallel_meshes(build.planar(N=3).system().meshes)
    found, every = worst_case(lambda p: cycle_forces(waves, p), ratios, members, meshes=6, points=400)
    random = np.random.default_rng(0).random((4000, 2))
    peaks = cycle_forces(waves, random).max(axis=2)
    b = 3 * peaks[:, :3] / peaks[:, :3].sum(axis=1, keepdims=True)
    assert not every
    # random phases come close to the largest value and the search must not be behind them by more than a little
    assert np.all(found[:3] >= 1 + np.abs(b - 1).max(axis=0) - 2e-3)


def test_blocks_follow_common_factors() -> None:
    ratios = [Fraction(1, 21), Fraction(1, 33), Fraction(1, 23), Fraction(2, 7), Fraction(5)]
    assert sorted(sorted(part) for part in independent_blocks(ratios)) == [[0, 1, 3], [2]]


def loaded(build: Any, *, zeta: float | None = None, seed: int = 0, torque: float = 300.0, N: int = 3) -> System:
    """A planar set with errors at three shaft lines and a varying stiffness."""
    system: System = build.planar(N=N).system()
    m, rng = 2 * N, np.random.default_rng(seed)
    free = compliance_of(system).free[:, 0]
    force = np.zeros(len(system.force))
    force[2], force[8] = torque, -torque * free[2] / free[8]
    lines = tuple(
        Line(
            frequency=TONE * ratio,
            gap=np.asarray(1e-6 * (rng.normal(size=m) + 1j * rng.normal(size=m)), complex),
            link_gap=np.zeros(len(system.links.name), complex),
            force=np.zeros((3, len(force)), complex),
        )
        for ratio in (Fraction(0), Fraction(1, 7), Fraction(1, 5), Fraction(1))
    )
    variation = 0.1 * np.exp(2j * np.pi * rng.random(size=(m, 1)))
    meshes = replace(system.meshes, variation=variation)
    return replace(system, force=force, lines=lines, tones=(TONE,), meshes=meshes, zeta=zeta)


@pytest.mark.parametrize("torque", [300.0, 2.0])
def test_static_sharing_is_static(build: Any, torque: float) -> None:
    """Wave form and open instants together equal the equilibrium solved instant by instant."""
    system = loaded(build, torque=torque)
    result = sharing(system, SharingOptions(method="static", samples=16))
    whole = static(system, StaticOptions(samples=16))
    force = whole.mesh_force.values
    assert result.contact_lost.values.any() == (torque < 100)
    # two ways of solving, condition 1e4
    np.testing.assert_allclose(result.mesh_force.values, force, atol=1e-8 * force.max())
    np.testing.assert_array_equal(result.contact_lost.values, whole.contact_lost.values)
    peaks = force.reshape(6, 35, 16).max(axis=2)[:3]
    expected = 1 + np.abs(3 * peaks / peaks.sum(axis=0) - 1).max(axis=1)
    np.testing.assert_allclose(result.load_sharing.values[0, :3], expected, rtol=1e-8)


def test_slow_steady_is_static(build: Any) -> None:
    """At a thousandth of the speed, 0.03 Hz against 700 Hz, nothing vibrates."""
    system = loaded(build, zeta=0.03)
    slow = sharing(system, SharingOptions(method="steady", relative_speed=1e-3, samples=16))
    still = sharing(system, SharingOptions(method="static", samples=16))
    # damping force over stiffness: 2 zeta f/f_1 ~ 1e-6 of the 0.1 variation; solver tolerance 1e-8
    np.testing.assert_allclose(slow.load_sharing.values, still.load_sharing.values, atol=1e-5)


def test_floating_sun_of_three_shares_equally(build: Any) -> None:
    system: System = build.planar(N=3, lateral=(0.0, 1e8, 1e8, 1e8)).system()
    columns = [0, 1, 2, 11, 14, 17]
    small: System = build.reduced(
        system,
        np.eye(len(system.M))[:, columns],
        tuple(system.dofs.names[i] for i in columns),
        system.dofs.radius[columns],
    )
    force = np.zeros(6)
    force[2] = 300.0
    rng = np.random.default_rng(4)
    line = Line(
        frequency=Fraction(1, 23),
        gap=1e-6 * np.exp(2j * np.pi * rng.random(6)),
        link_gap=np.zeros(len(small.links.name), complex),
        force=np.zeros((3, 6), complex),
    )
    result = sharing(replace(small, force=force, lines=(line,), tones=(Fraction(1),)), SharingOptions(method="static"))
    np.testing.assert_allclose(result.load_sharing.values, 1.0, atol=1e-10)  # linear solves


def test_hunting_period_takes_little_time(build: Any, respond: Any) -> None:
    """ren2021's 22287 cycles of 12 meshes with 64 samples, as one record."""
    import time

    respond(made_up(12, (Fraction(1, 23), Fraction(1, 17), Fraction(1, 57)), samples=64))
    start = time.process_time()
    result = sharing(build.planar(N=6).system(), SharingOptions())
    assert result.attrs["cycles"] == 22287
    assert time.process_time() - start < 10  # 0.4 s measured


def test_result_survives_a_file(build: Any, respond: Any, tmp_path: Any) -> None:
    pytest.importorskip("h5py", reason="h5netcdf writes through h5py")
    respond(made_up(6, (Fraction(1, 5),)))
    result = sharing(build.planar(N=3).system(), SharingOptions())
    reopened = load_result(save_result(result, tmp_path / "sharing.nc"))
    assert reopened.identical(result)


def test_bad_input(build: Any) -> None:
    system = loaded(build)
    with pytest.raises(ModelError, match="no such method"):
        sharing(system, SharingOptions(method="guess"))  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="cycles"):
        epicyclic.sharing(system, method="static", cycles=0)
    with pytest.raises(ModelError, match="relative_speed"):
        sharing(system, SharingOptions(method="static", relative_speed=-1.0))
    with pytest.raises(ModelError, match="needs a load"):
        sharing(replace(system, force=0 * system.force, lines=()), SharingOptions(method="static"))


def test_line_phases_stay_exact_late_in_the_record() -> None:
    late = np.array([10**9 + 7], dtype=np.int64)
    expected = float(Fraction(3, 23) * (10**9 + 7) % 1)
    np.testing.assert_allclose(line_phases([Fraction(3, 23)], late), [[expected]], rtol=1e-15)


def two_tones(build: Any, *, swing: float, N: int = 4) -> System:
    """Sun meshes at the tone, ring meshes at 3/7 of it; errors of both and of a shaft."""
    base = loaded(build, zeta=0.03, N=N, torque=300.0)
    meshes, m = base.meshes, 2 * N
    late, rng = np.arange(m) >= N, np.random.default_rng(4)
    lines = [
        replace(base.lines[0], frequency=TONE * ratio, gap=np.where(where, 1e-6 * rng.normal(size=m), 0) + 0j)
        for ratio, where in ((Fraction(1), ~late), (Fraction(3, 7), late), (Fraction(1, 14), ~late | late))
    ]
    return replace(
        base,
        tones=(TONE * 3 / 7, TONE),
        meshes=replace(meshes, tone=np.where(late, 0, 1), variation=swing * np.exp(1j * rng.normal(size=(m, 2)))),
        lines=tuple(sorted(lines, key=lambda line: line.frequency)),
    )


def in_cycles(force: Callable[[Array], Array], tone: Fraction, cycles: int, samples: int) -> Array:
    """Forces (cycles, m, samples) at the instants of a tone's cycles."""
    index = np.arange(cycles * samples)
    return force(index / samples / float(tone)).reshape(-1, cycles, samples).transpose(1, 0, 2)


@pytest.mark.parametrize("method", ["steady", "static"])
@pytest.mark.parametrize("swing", [0.0, 0.1])
def test_each_mesh_counts_in_cycles_of_its_own_frequency(build: Any, method: Method, swing: float) -> None:
    system = two_tones(build, swing=swing)
    result = sharing(system, SharingOptions(method=method, samples=64))
    assert result.attrs["cycles"] == result.attrs["hunting_period"] == 14

    def steady_force(times: Array) -> Array:
        found = periodic(system, samples=256)
        orders = np.fft.fftfreq(256, 1 / 256)
        turning = np.exp(2j * np.pi * np.outer(orders, times * float(found.tone)))
        total = np.fft.fft(found.force) / 256 @ turning
        for line in found.lines:
            carrier = np.exp(2j * np.pi * float(line.frequency) * times)
            total = total.real + (np.fft.fft(line.force) / 256 @ turning * carrier).real
        return np.asarray(total.real)

    def static_force(times: Array) -> Array:
        index = np.rint(times * float(TONE) * 64 * 3).astype(np.int64)
        here = excitation(system, TONE, index, 64 * 3)
        flexible = compliance_of(system)
        return equilibrium(flexible, stiffness=here.stiffness, gap=here.gap, force=here.force).mesh_force.T

    force = steady_force if method == "steady" else static_force
    for tone, group, cycles in ((TONE, slice(0, 4), 14), (TONE * 3 / 7, slice(4, 8), 6)):
        expected = extremes(in_cycles(force, tone, cycles, 64)[:, group], [np.arange(4)])
        values = result.load_sharing.values[:, group]
        # both solutions drop 1e-6 of the dynamic part at most
        np.testing.assert_allclose(values[1], expected.simultaneous, rtol=1e-6)
        np.testing.assert_allclose(values[3], expected.ratio_high, rtol=1e-6)
        departure = np.maximum(expected.ratio_high - 1, 1 - expected.ratio_low)
        np.testing.assert_allclose(values[0] - 1, departure, atol=1e-6)
        assert np.all(values[4] >= values[0] - 1e-12)
    bound = result.mesh_force_bound.values
    if method == "steady" or swing == 0:
        assert np.all(bound >= result.mesh_force.max("time").values * (1 - 1e-9))
    else:
        assert np.isnan(bound).all()


def test_a_short_record_is_as_long_for_every_stage(build: Any) -> None:
    """Seven cycles of the first meshes are three of the others."""
    system = two_tones(build, swing=0.0)
    seven, whole = (sharing(system, SharingOptions(method="static", samples=64, cycles=count)) for count in (7, 14))
    slow = replace(
        system,
        meshes=replace(system.meshes, tone=np.zeros(8, np.int64)),
        tones=(TONE * 3 / 7,),
    )
    three = sharing(slow, SharingOptions(method="static", samples=64, cycles=3))
    np.testing.assert_allclose(seven.load_sharing.values[:4, 4:], three.load_sharing.values[:4, 4:], rtol=1e-9)
    assert np.abs(whole.load_sharing.values[:4, 4:] - three.load_sharing.values[:4, 4:]).max() > 1e-6


def test_superposition_shares_like_the_full_solution_where_nothing_varies(build: Any) -> None:
    system = two_tones(build, swing=0.0)
    full, plain = (
        sharing(system, SharingOptions(samples=32)),
        sharing(system, SharingOptions(method="superposition", samples=32)),
    )
    np.testing.assert_allclose(plain.load_sharing, full.load_sharing, rtol=1e-9)
    assert plain.attrs["method"] == "superposition"
    varying = two_tones(build, swing=0.1)
    full, plain = (
        sharing(varying, SharingOptions(samples=32)),
        sharing(varying, SharingOptions(method="superposition", samples=32)),
    )
    apart = np.abs(plain.load_sharing - full.load_sharing).max()
    assert 1e-5 < apart < 0.1 * np.abs(full.load_sharing - 1).max()


@pytest.mark.parametrize("method", ["steady", "superposition"])
def test_the_bound_of_two_mesh_frequencies_is_that_of_the_steady_state(build: Any, method: Method) -> None:
    system = two_tones(build, swing=0.1)
    found = sharing(system, SharingOptions(method=method, cycles=7 * 19))
    exact = steady(system, SteadyOptions(method="exact" if method == "steady" else "superposition"))
    np.testing.assert_allclose(found.mesh_force_bound, exact.mesh_force_bound, rtol=1e-9)
    # harmonics of the other mesh frequency have tied phases: their sum is above what any phases make
    np.testing.assert_array_less(found.mesh_force_peak, found.mesh_force_bound * (1 + 1e-3))


def test_a_bound_that_is_not_known_says_why(build: Any) -> None:
    def told(system: System, **options: Any) -> list[str]:
        warnings = json.loads(sharing(system, SharingOptions(method="static", cycles=14, **options)).attrs["warnings"])
        return [one.split("not known: ")[1] for one in warnings if one.startswith("mesh_force_bound")]

    assert told(two_tones(build, swing=0.0)) == []
    several = "the stiffness follows several mesh frequencies, and each instant is solved by itself"
    assert told(two_tones(build, swing=0.1)) == [f"{several} [force-bound-unknown]"]
    single = two_tones(build, swing=0.1)
    # only the sun meshes' stiffness varies: the ring meshes, of the other frequency, have no bound
    still = np.where((single.meshes.tone == 1)[:, None], single.meshes.variation, 0)
    mixed = replace(single, meshes=replace(single.meshes, variation=still))
    (reason,) = told(mixed)
    rings = [name for name, tone in zip(mixed.meshes.name, mixed.meshes.tone, strict=True) if tone == 0]
    assert reason == f"{several} ({', '.join(rings)}) [force-bound-unknown]"
    (parted,) = told(replace(two_tones(build, swing=0.0), force=0.01 * single.force))
    assert parted.startswith("teeth part")


def test_the_mean_of_a_static_record_of_two_tones_is_that_of_its_instants(build: Any) -> None:
    """Stiffness that follows several tones moves it from the force at the mean stiffness."""
    system = two_tones(build, swing=0.3)
    found = sharing(system, SharingOptions(method="static", cycles=21, stored_cycles=21))
    # the instants of the other tone's cycles are others
    np.testing.assert_allclose(found.mesh_force_mean, found.mesh_force.mean("time"), rtol=3e-5)
    still = faces(system.meshes).total(mean_force(system))
    assert np.abs(found.mesh_force_mean.values / still - 1).max() > 3e-4
