"""Tabulated flanks in motion: compiled steps against the laws, against straight tables, against an adaptive method."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.transient import integrators
from epicyclic.questions.transient.equation import Motion, constant, from_modal, highest_rate, motion, program, to_modal
from epicyclic.questions.transient.integrators import adaptive_states, at_equilibrium, at_rest, integrate
from epicyclic.questions.transient.transient import flank_force
from epicyclic.system.flank_laws import FlankAt, LawRows, LinearLaw, TabulatedLaw
from epicyclic.system.link_laws import Law
from epicyclic.system.system import System

Array = NDArray[np.float64]
RAMP = program([0.0, 0.004, 0.004, 0.02], [0.4, 0.6, 0.6, 1.1], [[0.0], [0.3], [-0.2], [0.0]])
LOADS = np.array([[200.0, 0.0, -100.0]])
FORCE = np.concatenate([[0.0], np.geomspace(2.0, 300.0, 9)])


def curved(rows: int, *, far: bool = False) -> TabulatedLaw:
    """Flanks that stiffen with the load and touch late in a part of the cycle."""
    phase = 2 * np.pi * np.arange(12)[:, None] / 12
    soft = 1 + 0.3 * np.cos(phase) + 0.1 * np.sin(2 * phase)
    gap = 2e-6 * (1 - np.cos(phase + 0.4)) + soft * (FORCE / 1e6 + 4e-6 * np.log1p(FORCE / 20))
    slope = 1 / (soft * (1e-6 + 4e-6 / (20 + FORCE)))
    sense = -np.ones(rows) if far else np.array([1.0, -1.0] * rows)[:rows]
    lead = np.array([0.13, 0.71, 0.4])[:rows]
    return TabulatedLaw(
        tone=np.zeros(rows, np.int64),
        lead=lead,
        sense=sense,
        force=FORCE,
        gap=gap,
        slope=slope,
        load=np.full(len(lead), np.nan),
    )


def with_laws(system: System, near: tuple[LawRows, ...], far: tuple[LawRows, ...] = ()) -> System:
    behind = system.far_flanks
    return replace(system, meshes=replace(system.meshes, laws=near), far=replace(behind, laws=far))


def tabulated(made: Any, **options: Any) -> System:
    """Both loaded flanks and the second far one by tables, the first far one linear."""
    near = (LawRows(law=curved(2), rows=np.arange(2)),)
    return with_laws(made.rich(**options), near, (LawRows(law=curved(1, far=True), rows=np.array([1])),))


def both(monkeypatch: pytest.MonkeyPatch, run: Any) -> tuple[Any, Any]:
    pytest.importorskip("numba")
    compiled = run()
    with monkeypatch.context() as patch:
        patch.setattr(integrators, "numba_available", lambda: False)
        return compiled, run()


def test_compiled_law_is_the_law(made: Any) -> None:
    """Every cell, first touch and beyond the end, on loaded and far flanks."""
    pytest.importorskip("numba")
    from epicyclic.questions.transient import compiled

    moving = motion(tabulated(made))
    N, rng = moving.numbers, np.random.default_rng(3)
    turned = rng.uniform(-0.03, 0.03, 60)
    at = moving.flanks.at(turned[:, None] * N.tones)
    end = at.parts[0][0].kinks.max() + 1.2 * curved(1).gap.max()
    gaps = rng.uniform(-2e-6, end, (200, 60, 4))
    known, _ = at.evaluate(gaps)
    touch = at.touch
    phase: Any = compiled._phase
    law: Any = compiled._tabulated
    for f in (0, 1, 3):
        assert N.flank.table[f] >= 0
        for i, tau in enumerate(turned):
            x, row = phase(N.flank, N.tone, N.tones, f, tau)
            found = [law(N.flank, f, x, row, gap) for gap in gaps[:, i, f]]
            # 1e-16 of the gap over the width of a cell
            np.testing.assert_allclose(
                [force for force, _ in found], known[:, i, f], rtol=1e-12, atol=1e-12 * FORCE[-1]
            )
            assert [pressed for _, pressed in found] == (gaps[:, i, f] > touch[i, f]).tolist()
    mine = known[..., [0, 1, 3]]
    assert (mine == 0).any()
    assert (mine > FORCE[-1]).any()
    for low, high in pairwise(FORCE):
        assert ((mine > low) & (mine < high)).any()


@pytest.mark.parametrize("given", [constant(0.8), RAMP], ids=["constant", "ramp"])
@pytest.mark.parametrize("groups", [False, True])
def test_compiled_steps_equal_numpy(made: Any, monkeypatch: pytest.MonkeyPatch, given: Any, groups: bool) -> None:
    moving = motion(tabulated(made, groups=groups, load=60.0), program=given, loads=LOADS[: given.level.shape[1]])
    assert moving.compiled
    fast, slow = both(monkeypatch, lambda: integrate(moving, at_rest(moving), stop=0.01, steps=100, keep=5)[0])
    # the same steps with sums in another order: rounding, grown over 100 steps
    np.testing.assert_allclose(fast, slow, rtol=1e-9, atol=1e-11 * np.abs(slow).max())
    force = flank_force(moving, np.linspace(0, 0.01, 21), fast)
    assert (force[:2] > 0).any(axis=1).all()
    assert (force[:2] == 0).any(axis=1).all()


def test_a_straight_table_is_the_linear_law(made: Any) -> None:
    """Without variation, a table of one straight line at every phase."""
    plain = made.rich(swing=0.0, load=60.0)
    stiffness = plain.meshes.stiffness
    laws = tuple(
        LawRows(
            law=replace(curved(1), gap=np.tile(FORCE / k, (12, 1)), slope=np.full((12, FORCE.size), k)),
            rows=np.array([i]),
        )
        for i, k in enumerate(stiffness)
    )
    table = with_laws(plain, laws, laws)
    found, known = (
        integrate(motion(system, program=RAMP, loads=LOADS), np.zeros((2, 3)), stop=0.02, steps=2000, keep=20)[0]
        for system in (table, plain)
    )
    # rounding, grown over 2000 steps and where teeth meet
    np.testing.assert_allclose(found[:, 0], known[:, 0], rtol=1e-8, atol=1e-10 * np.abs(known[:, 0]).max())
    np.testing.assert_allclose(found, known, rtol=1e-8, atol=1e-10 * np.abs(known).max())
    assert (flank_force(motion(plain), np.zeros(len(known)), known) == 0).any()


def test_fixed_steps_meet_an_adaptive_method(made: Any) -> None:
    moving = motion(tabulated(made, load=60.0), program=constant(0.8))
    times, start = np.linspace(0, 0.02, 21), at_equilibrium(moving)
    fixed = integrate(moving, start, stop=0.02, steps=20_000, keep=1000)[0]
    begin = to_modal(moving, start)
    states, _ = adaptive_states(moving, begin, times, method="dop853")
    found = from_modal(moving, states)
    size = np.abs(fixed).max(axis=(0, 2))[:, None]
    assert np.abs(found - fixed[1:]).max() < np.inf
    # steps across first touch and from knot to knot of the table, where its second derivative jumps
    np.testing.assert_allclose(found / size, fixed[1:] / size, atol=2e-6)
    tangent = motion(with_laws(tabulated(made, load=60.0), (), ()), program=constant(0.8))
    linear = integrate(tangent, start, stop=0.02, steps=20_000, keep=1000)[0]
    assert np.abs((linear - fixed) / size).max() > 0.05  # the tangent in place of the table is seen


def test_the_damper_acts_where_the_law_presses(made: Any) -> None:
    """Between zero gap and first touch a flank has neither force nor damper."""
    system = tabulated(made)
    moving = motion(system, program=constant(0.8))
    rate = np.array([0.1, -0.2, 0.3])
    for scale in (1e-6, 1e-4):
        q = scale * np.array([1.0, 0.2, 0.1])
        still, moves = (flank_force(moving, np.zeros(1), np.stack([q, v])[None])[:, 0] for v in (np.zeros(3), rate))
        assert np.array_equal(still > 0, moves - still != 0)
        gap = moving.rows[:, :4].T @ q
        if scale == 1e-6:
            assert (gap[:2] > 0).any()
            assert not (still > 0).any()
        else:
            assert (still[:2] > 0).any()


def test_steps_follow_the_stiffest_tangent(made: Any) -> None:
    linear, table = motion(made.rich()), motion(tabulated(made))
    law = table.flanks.laws[-1].law
    phases = np.arange(50)[:, None] / 50 * np.ones(len(table.numbers.tones))
    gaps = np.linspace(0, 1.2 * curved(1).gap.max(), 2000)[:, None, None] + law.at(phases).touch
    sampled = law.at(phases).evaluate(gaps)[1].max()
    assert 0.97 * law.stiffest.max() < sampled <= law.stiffest.max() * (1 + 1e-3)
    double = replace(curved(2), force=2 * FORCE, slope=2 * curved(2).slope)
    stiffer = motion(with_laws(made.rich(), (LawRows(law=double, rows=np.arange(2)),)))
    assert highest_rate(stiffer) > 1.1 * highest_rate(table)
    assert highest_rate(linear) > 0


@pytest.mark.parametrize("groups", [False, True])
def test_equilibrium_with_tables_and_far_flanks(made: Any, groups: bool) -> None:
    system = tabulated(made, groups=groups, swing=0.0)
    for force in (system.force, -system.force):
        still = replace(system, lines=(), force=force)
        # one phase: a cycle takes longer than the run
        moving = motion(still, program=constant(0.9))
        slow = motion(still, program=program([0.0, 1.0], [0.0, 0.0]))
        start = at_equilibrium(slow)
        states = integrate(slow, start, stop=0.05, steps=2000, keep=100)[0]
        np.testing.assert_allclose(states[:, 0], np.tile(start[0], (21, 1)), rtol=1e-8, atol=1e-12)
        pressed = flank_force(slow, np.zeros(1), start[None])[:, 0] > 0
        assert pressed.any()
        assert np.isfinite(at_equilibrium(moving)).all()


@pytest.mark.parametrize("contact", ["linear"])
def test_the_linear_model_has_the_tangents(made: Any, contact: Any) -> None:
    system = tabulated(made)
    plain = with_laws(system, (), ())
    found, known = (
        integrate(motion(each, contact=contact), np.zeros((2, 3)), stop=0.01, steps=200)[0] for each in (system, plain)
    )
    np.testing.assert_array_equal(found, known)


@pytest.mark.parametrize("swing", [2.5])
def test_a_truncated_series_stays_above_its_floor(made: Any, monkeypatch: pytest.MonkeyPatch, swing: float) -> None:
    moving = motion(made.rich(swing=swing), program=constant(0.8))
    fast, slow = both(monkeypatch, lambda: integrate(moving, at_rest(moving), stop=0.01, steps=400, keep=20)[0])
    np.testing.assert_allclose(fast, slow, rtol=1e-9, atol=1e-11 * np.abs(slow).max())
    assert (flank_force(moving, np.linspace(0, 0.01, 21), fast) >= 0).all() or system_damped(moving)
    k = moving.flanks.at(np.linspace(0, 1, 99)[:, None]).evaluate(np.full((99, 4), 1e-3))[1]
    assert k.min() == pytest.approx(1e-6 * moving.numbers.flank.mean.min(), rel=0.5)


def system_damped(moving: Motion) -> bool:
    """Whether a damper may pull while a flank is closed."""
    return bool(moving.numbers.drag.any())


@dataclass(frozen=True)
class Cubic:
    """A law made up here, known to NumPy alone: force c <delta>^3."""

    factor: float
    count: int

    @property
    def stiffest(self) -> Array:
        return np.full(self.count, 3 * self.factor * 1e-8)

    @property
    def end(self) -> Array:
        return np.full(self.count, np.inf)

    @property
    def load(self) -> Array:
        return np.full(self.count, np.nan)

    def rows(self, chosen: Any) -> Cubic:
        return Cubic(self.factor, len(np.arange(self.count)[chosen]))

    def at(self, phases: Array) -> FlankAt:
        return CubicAt(self.factor, np.zeros((len(phases), self.count)))

    def lower(self) -> LinearLaw | None:
        return None


@dataclass(frozen=True)
class CubicAt:
    """`Cubic` at some phases."""

    factor: float
    touch: Array

    @property
    def kinks(self) -> Array:
        return self.touch[..., None]

    def instants(self, chosen: Any) -> CubicAt:
        return CubicAt(self.factor, self.touch[chosen])

    def rows(self, chosen: Any) -> CubicAt:
        return CubicAt(self.factor, self.touch[:, chosen])

    def evaluate(self, delta: Array) -> tuple[Array, Array]:
        closed = np.maximum(delta, 0.0)
        return self.factor * closed**3, 3 * self.factor * closed**2

    def energy(self, delta: Array) -> Array:
        return np.asarray(self.factor * np.maximum(delta, 0.0) ** 4 / 4)

    def constant(self, low: Array, high: Array) -> NDArray[np.bool_]:
        return np.asarray(high <= 0)


def test_a_law_without_compiled_form_says_so(made: Any) -> None:
    """A mass on <delta>^3: f = F at rest, and a free vibration of the known energy about it."""
    factor, force = 1e12, 10.0
    plain = made.mass(force=force)
    system = replace(plain, meshes=replace(plain.meshes, laws=(LawRows(law=Cubic(factor, 1), rows=np.array([0])),)))
    moving = motion(system)
    assert not moving.compiled
    assert "main/a-b" not in moving.warnings[0]
    assert moving.warnings == (
        "a-b: a law without a compiled form: integrated with NumPy, some 30 times slower [slow-law]",
    )
    start = at_equilibrium(moving)
    assert start[0, 0] == pytest.approx((force / factor) ** (1 / 3), rel=1e-10)
    states = integrate(moving, start + np.array([[1e-4], [0.0]]), stop=0.02, steps=2000, keep=20)[0]
    x, v = states[:, 0, 0], states[:, 1, 0]
    energy = v**2 / 2 + factor * np.maximum(x, 0) ** 4 / 4 - force * x
    assert np.ptp(energy) < 1e-6 * np.ptp(v**2 / 2)


def test_forces_beyond_the_end_are_said() -> None:
    options = {f"stages.main.meshes.{pair}.stiffness": "contact" for pair in ("sun-planet", "planet-ring")}
    plain = epicyclic.transient("ren2021", overrides=options, cycles=2, samples=8)
    assert not [text for text in json.loads(plain.attrs["warnings"]) if "the last force of its table" in text]
    far = epicyclic.transient("ren2021", overrides=options, cycles=2, samples=8, torque_step=(4.0, 0.0))
    said = [text for text in json.loads(far.attrs["warnings"]) if "times the last force of its table" in text]
    assert len(said) == 2
    linear = epicyclic.transient(
        "ren2021", overrides=options, cycles=2, samples=8, torque_step=(4.0, 0.0), contact="linear"
    )
    assert not [text for text in json.loads(linear.attrs["warnings"]) if "last force of its table" in text]


@dataclass(frozen=True, slots=True, kw_only=True)
class Unlowered(Law):
    """The law of a link under a name that no compiled step knows."""

    def lower(self) -> Any:
        return None


def test_a_link_law_without_compiled_form_says_so(made: Any) -> None:
    """The same numbers by NumPy, and a warning."""
    known = made.rich(groups=True, load=60.0)
    other = replace(
        known,
        groups=tuple(
            replace(
                group,
                law=Unlowered(**{field.name: getattr(group.law, field.name) for field in fields(Law)}),
            )
            for group in known.groups
        ),
    )
    moving = motion(other)
    assert not moving.compiled
    assert moving.warnings[0].startswith("main/")
    assert "integrated with NumPy" in moving.warnings[0]
    fast, slow = (integrate(motion(each), np.zeros((2, 3)), stop=0.002, steps=80)[0] for each in (known, other))
    np.testing.assert_allclose(fast, slow, rtol=1e-9, atol=1e-11 * np.abs(slow).max())
