"""Phases against closed formulas and against teeth set down as curves and counted on the base tangent."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import epicyclic
from epicyclic.teeth.geometry import Phase, driver_tooth, mate_tooth, shift_term
from epicyclic.train.phasing import StagePhases, ToothedGear, ToothMesh, stage_leads

TEETH = st.integers(12, 130)
SIGN = st.sampled_from([1, -1])
SOLVED = 1e-9  # [pitches] the crossing is solved to 1e-15 m on pitches of 1e-2 m; angles times 130 teeth
NORMAL, TRANSVERSE, MODULE = math.radians(20.0), math.radians(21.88), 0.004


def off(value: float) -> float:
    """Distance from the nearest whole number."""
    return math.remainder(value, 1.0)


# ---------------------------------------------------------------- closed formulas


@st.composite
def spacings(draw: st.DrawFn) -> tuple[Fraction, ...]:
    count = draw(st.integers(1, 6))
    if draw(st.booleans()):
        return tuple(Fraction(i, count) for i in range(count))
    return (Fraction(0), *(Fraction(draw(st.integers(1, 719)), 720) for _ in range(count - 1)))


def stage(
    teeth: tuple[int, int, int],
    angles: tuple[Fraction, ...],
    flank: int,
    sense: int,
    *,
    shifts: tuple[float, float, float] = (0.0, 0.0, 0.0),
    working: tuple[float, float] = (TRANSVERSE, TRANSVERSE),
) -> StagePhases:
    gears = (
        ToothedGear(name="sun", teeth=teeth[0], central=True, profile_shift=shifts[0]),
        ToothedGear(name="planet", teeth=teeth[1], profile_shift=shifts[1]),
        ToothedGear(name="ring", teeth=teeth[2], central=True, internal=True, profile_shift=shifts[2]),
    )
    meshes = tuple(
        ToothMesh(
            pair=pair,
            a=a,
            b=b,
            directions=angles,
            flank=d,
            normal_angle=NORMAL,
            transverse_angle=TRANSVERSE,
            working_angle=alpha,
        )
        for pair, a, b, d, alpha in (
            ("sp", "sun", "planet", flank, working[0]),
            ("pr", "planet", "ring", -flank, working[1]),
        )
    )
    return stage_leads(gears, meshes, sense=sense)


@given(TEETH, TEETH, TEETH, spacings(), SIGN, SIGN)
@settings(max_examples=150, deadline=None)
def test_closed_formulas_without_shift_hold_exactly(
    zs: int, zp: int, zr: int, angles: tuple[Fraction, ...], d: int, g: int
) -> None:
    found = stage((zs, zp, zr), angles, d, g)
    between = Fraction(1 - zp, 2)
    assert found.lead["sp"] == tuple(-g * zs * psi % 1 for psi in angles)
    assert found.lead["pr"] == tuple((d * g * between + g * zr * psi) % 1 for psi in angles)
    assert found.assembles == all((zs + zr) * psi % 1 == 0 for psi in angles)
    assert all((a + d * (zs + zr) * psi) % 1 == 0 for a, psi in zip(found.mismatch, angles, strict=True))
    nearest = [Fraction(angle) for angle in found.nearest_angles if angle is not None]
    assert len(nearest) == len(angles)
    assert all((zs + zr) * angle % 1 == 0 for angle in nearest)
    assert all(abs(n - psi) <= Fraction(1, 2 * (zs + zr)) for n, psi in zip(nearest, angles, strict=True))


def involute(angle: float) -> float:
    return math.tan(angle) - angle


@given(TEETH, TEETH, TEETH, spacings(), SIGN, SIGN, st.floats(-0.5, 0.9), st.floats(0.3, 0.5), st.floats(0.3, 0.5))
@settings(max_examples=100, deadline=None)
def test_closed_formulas_with_shift(
    zs: int, zp: int, zr: int, angles: tuple[Fraction, ...], d: int, g: int, x: float, alpha_sp: float, alpha_pr: float
) -> None:
    found = stage((zs, zp, zr), angles, d, g, shifts=(0.2, x, -0.1), working=(alpha_sp, alpha_pr))
    between = (1 - zp) / 2 + (2 * x * math.tan(NORMAL) + zp * involute(TRANSVERSE)) / math.pi
    between -= zp * (involute(alpha_sp) + involute(alpha_pr)) / math.tau
    assert found.lead["sp"] == tuple(-g * zs * psi % 1 for psi in angles)  # rational with shift too
    for lead, psi in zip(found.lead["pr"], angles, strict=True):
        # Rounding of phases of order 1e2.
        assert off(float(lead) - d * g * between - float(g * zr * psi)) == pytest.approx(0.0, abs=1e-12)
    assert all((a + d * (zs + zr) * psi) % 1 == 0 for a, psi in zip(found.mismatch, angles, strict=True))


# ---------------------------------------------------------------- teeth as curves


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    """A gear set down as curves: the string that unwinds from the base circle, tooth thickness from the cutter."""

    teeth: int
    shift: float
    internal: bool = False

    @property
    def reference(self) -> float:
        return MODULE * self.teeth / math.cos(TRANSVERSE) * math.cos(NORMAL)  # any transverse module will do

    @property
    def base(self) -> float:
        return self.reference * math.cos(TRANSVERSE)

    def half_tooth(self, string: float) -> float:
        """Half tooth angle where the unwound angle is `string`, from pi/2 + 2 x tan alpha_n on the reference circle."""
        at_reference = math.sqrt((self.reference / self.base) ** 2 - 1)
        wound = (string - math.atan(string)) - (at_reference - math.atan(at_reference))
        half = (math.pi / 2 + 2 * self.shift * math.tan(NORMAL)) / self.teeth
        return half + wound if self.internal else half - wound

    def flank_point(self, tooth: float, side: int, string: float) -> complex:
        """Point of the flank on one side of the tooth centred at `tooth` [rad], gear centre at 0 [m]."""
        radius = self.base * math.sqrt(1 + string**2)
        return cmath.rect(radius, tooth + side * self.half_tooth(string))


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """A on the origin, B on the line of centres in direction `direction` [rad]; d the flank."""

    a: Wheel
    b: Wheel
    direction: float
    d: int
    working: float

    @property
    def centre(self) -> complex:
        """Centre of B."""
        radii = (self.b.base * (-1 if self.b.internal else 1) + self.a.base) / math.cos(self.working)
        return cmath.rect(radii, self.direction)

    @property
    def pitch_point(self) -> complex:
        return cmath.rect(self.a.base / math.cos(self.working), self.direction)

    @property
    def line(self) -> complex:
        """Unit vector of the line of action, sin alpha e + d cos alpha t."""
        e = cmath.rect(1.0, self.direction)
        return math.sin(self.working) * e + self.d * math.cos(self.working) * e * 1j

    def place_on(self, curve: Callable[[float], complex], base: float) -> float:
        """Where a flank crosses the base tangent, from the pitch point, in base pitches."""

        def beside(string: float) -> float:
            return ((curve(string) - self.pitch_point) / self.line).imag

        start = math.tan(self.working)
        low, high = start - 0.3, start + 0.3
        string = brentq(beside, max(low, 0.02), high, xtol=1e-15, rtol=1e-14)
        along = ((curve(string) - self.pitch_point) / self.line).real
        return along / (math.tau * self.a.base / self.a.teeth)

    def place_of_a(self, tooth: float) -> float:
        return self.place_on(lambda s: self.a.flank_point(self.near_a(tooth), self.d, s), self.a.base)

    def place_of_b(self, tooth: float) -> float:
        side = -self.d if self.b.internal else self.d
        return self.place_on(lambda s: self.centre + self.b.flank_point(self.near_b(tooth), side, s), self.b.base)

    def near_a(self, tooth: float) -> float:
        """The tooth of A whose flank is next to the pitch point, when one of them is centred at `tooth`."""
        aim = self.direction - self.d * self.a.half_tooth(math.tan(self.working))
        return aim + math.remainder(tooth - aim, math.tau / self.a.teeth)

    def near_b(self, tooth: float) -> float:
        side = -self.d if self.b.internal else self.d
        aim = self.direction + (0.0 if self.b.internal else math.pi)
        aim -= side * self.b.half_tooth(math.tan(self.working))
        return aim + math.remainder(tooth - aim, math.tau / self.b.teeth)


@st.composite
def pairs(draw: st.DrawFn) -> Pair:
    internal = draw(st.booleans())
    a = Wheel(teeth=draw(st.integers(18, 50)), shift=draw(st.floats(-0.4, 0.6)))
    teeth = draw(st.integers(70, 130)) if internal else draw(st.integers(18, 60))
    b = Wheel(teeth=teeth, shift=draw(st.floats(-0.4, 0.6)), internal=internal)
    direction, d = draw(st.floats(-math.pi, math.pi)), draw(SIGN)
    return Pair(a=a, b=b, direction=direction, d=d, working=draw(st.floats(0.36, 0.46)))


def term(wheel: Wheel, working: float) -> float:
    return shift_term(
        teeth=wheel.teeth,
        profile_shift=wheel.shift,
        normal_angle=NORMAL,
        transverse_angle=TRANSVERSE,
        working_angle=working,
        internal=wheel.internal,
    )


@given(pairs(), st.floats(0, 1))
@settings(max_examples=150, deadline=None)
def test_place_of_the_contact_is_where_the_flank_crosses_the_base_tangent(pair: Pair, turn: float) -> None:
    tooth, direction = math.tau * turn, Phase.of(pair.direction / math.tau)
    sigma, shift = Phase.of(pair.place_of_a(tooth)), term(pair.a, pair.working)
    phase = driver_tooth(sigma, direction, teeth=pair.a.teeth, flank=pair.d, shift=shift)
    assert off(float(phase.value) - pair.a.teeth * turn) == pytest.approx(0.0, abs=SOLVED)


@given(pairs(), st.floats(-0.5, 0.5))
@settings(max_examples=150, deadline=None)
def test_the_mate_touches_in_the_same_place(pair: Pair, sigma: float) -> None:
    direction = Phase.of(pair.direction / math.tau)
    shift, internal = term(pair.b, pair.working), pair.b.internal
    phase = mate_tooth(Phase.of(sigma), direction, teeth=pair.b.teeth, flank=pair.d, shift=shift, internal=internal)
    tooth = math.tau * float(phase.value) / pair.b.teeth
    assert off(pair.place_of_b(tooth) - sigma) == pytest.approx(0.0, abs=SOLVED)


@given(pairs(), st.floats(0, 1), SIGN)
@settings(max_examples=60, deadline=None)
def test_the_contact_runs_in_the_sense_d_times_the_turn_of_a(pair: Pair, turn: float, sense: int) -> None:
    step = 0.1 * sense  # a tenth of a mesh cycle
    before = pair.place_of_a(math.tau * turn)
    after = pair.place_of_a(math.tau * (turn + step / pair.a.teeth))
    assert off(after - before - pair.d * sense * 0.1) == pytest.approx(0.0, abs=SOLVED)


# ---------------------------------------------------------------- a whole stage, counted


@given(
    st.tuples(st.integers(18, 40), st.integers(18, 40), st.integers(80, 120)),
    spacings(),
    SIGN,
    SIGN,
    st.tuples(st.floats(-0.3, 0.5), st.floats(-0.3, 0.5), st.floats(-0.3, 0.3)),
    st.tuples(st.floats(0.36, 0.44), st.floats(0.36, 0.44)),
    st.floats(0, 3),
)
@settings(max_examples=60, deadline=None)
def test_counted_teeth_of_a_stage_follow_the_leads(
    teeth: tuple[int, int, int],
    angles: tuple[Fraction, ...],
    d: int,
    g: int,
    shifts: tuple[float, float, float],
    working: tuple[float, float],
    time: float,
) -> None:
    """Set sun, planet 1 and ring down flank on flank, turn them, count the place of every contact with a central gear.

    sigma(t) = D (f t + gamma) must hold in each branch: for the sun's flanks and for the ring's.
    """
    assume(abs(working[0] - working[1]) > 1e-6)
    found = stage(teeth, angles, d, g, shifts=shifts, working=working)
    sun, planet = (Wheel(teeth=z, shift=x) for z, x in zip(teeth[:2], shifts[:2], strict=True))
    ring = Wheel(teeth=teeth[2], shift=shifts[2], internal=True)

    def inner(psi: float) -> Pair:
        return Pair(a=sun, b=planet, direction=psi, d=d, working=working[0])

    def outer(psi: float) -> Pair:
        return Pair(a=planet, b=ring, direction=psi, d=-d, working=working[1])

    # Time zero: flank of the sun through the pitch point of branch 1, planet 1 against it, ring against planet 1.
    at_sun = -d * sun.half_tooth(math.tan(working[0]))
    at_planet = math.pi - d * planet.half_tooth(math.tan(working[0]))
    assert off(inner(0.0).place_of_b(at_planet)) == pytest.approx(0.0, abs=SOLVED)
    met = outer(0.0).place_of_a(at_planet)
    at_ring = brentq(
        lambda turn: off(outer(0.0).place_of_b(turn) - met), *bracket(outer(0.0), met, teeth[2]), xtol=1e-15, rtol=1e-14
    )
    turned = [g * math.tau * time / z for z in teeth]  # sun with g, planets and ring against it
    for i, psi in enumerate(angles):
        sigma_sun = inner(math.tau * float(psi)).place_of_a(at_sun + turned[0])
        sigma_ring = outer(math.tau * float(psi)).place_of_b(at_ring - turned[2])
        for pair, counted in (("sp", sigma_sun), ("pr", sigma_ring)):
            expected = found.sense[pair] * (time + float(found.lead[pair][i]))
            assert off(counted - expected) == pytest.approx(0.0, abs=2 * SOLVED)  # at_ring is solved as well


def bracket(pair: Pair, met: float, teeth: int) -> tuple[float, float]:
    """Angles of a ring tooth a little before and behind the one whose contact is at `met`."""
    start = off(pair.place_of_b(0.0) - met)
    centre = pair.d * -start * math.tau / teeth
    return centre - 0.1 / teeth, centre + 0.1 / teeth


@pytest.mark.parametrize("held", ["ring", "carrier"])
@pytest.mark.parametrize("station", [15.0, -5.0])
def test_a_helical_mesh_apart_along_the_axis_has_the_lead_of_the_slice_there(held: str, station: float) -> None:
    """The teeth of one helix: a narrow ring meets the planet where a slice of a wide one does."""

    def train(ring: dict[str, object], slices: int) -> epicyclic.Train:
        return epicyclic.load(
            {
                "format": 2,
                "title": "helical",
                "stages": {
                    "main": {
                        "planets": 3,
                        "module": "4 mm",
                        "helix_angle": "17 deg",
                        "face_width": "40 mm",
                        "sun": {"teeth": 22},
                        "planet": {"teeth": 23},
                        "ring": {"teeth": 68, "rim": "30 mm", **ring},
                        "carrier": {"mass": "20 kg", "inertia": "0.2 kg m^2"},
                        "meshes": {"planet-ring": {"slices": slices}},
                    }
                },
                "operation": {"held": [held], "speed": {"sun": "100 rad/s"}, "torque": {"sun": "1 kN m"}},
            }
        )

    wide = train({}, 4)
    narrow = train({"face_width": "10 mm", "station": f"{station} mm"}, 1)
    for cut, whole in zip(wide.meshes, narrow.meshes, strict=True):
        if cut.pair.endswith("sun-planet"):
            assert whole.lead == cut.lead
            continue
        (piece,) = (piece for piece in cut.slices if abs(piece.station - station / 1e3) < 1e-9)
        assert whole.station == pytest.approx(piece.station)
        assert off(float(whole.lead) - float(piece.lead)) == pytest.approx(0.0, abs=1e-12)
        # a quarter of the face is not a whole axial pitch
        assert abs(off(float(whole.lead) - float(cut.lead))) > 0.05
