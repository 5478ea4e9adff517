"""Dong 2019, power-split star drive with stepped stars: figures and invariants of the corrected equations.

Two routes that share no code with the package stand beside it.  One is the source's own: torques of the meshes from
torque balance, equal angular deformation of all branches, and balance of the floating members, eqs. (1)-(7) and
(20)-(29), with the factors and signs put right.  The other is the closed map of branch forces, one compliance for each
circular harmonic of the errors.  [dong2019]
"""

from __future__ import annotations

import itertools
import json
import math
import time
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import epicyclic
from epicyclic.audits.audit_file import read_audit
from epicyclic.statics import StaticOptions
from epicyclic.statics.record import Record, record_of
from epicyclic.statics.static import static
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load
from epicyclic.train.train import Train

Array = NDArray[np.float64]
Table = dict[str, Any]

# Table 1 and section 4
N = 5
TEETH_S, TEETH_1, TEETH_2, TEETH_R = 24, 22, 31, 99
K_SP, K_PR, K_W, K_R = 8.6e9, 9.3e9, 1.78e7, 9.31e6
SPEED = 6800 / 60 * math.tau
TORQUE = 220e3 / SPEED
UM = 1e-6


def transverse_angle(helix: float) -> float:
    """Working transverse pressure angle [rad]; helix [deg]."""
    return math.atan(math.tan(math.radians(20)) / math.cos(math.radians(helix)))


def base_radius(teeth: int, module: float, helix: float) -> float:
    """From the normal module [m]; helix [deg]."""
    return teeth * module / 2 / math.cos(math.radians(helix)) * math.cos(transverse_angle(helix))


ALPHA_1, ALPHA_2 = transverse_angle(10), transverse_angle(12)
R_S, R_1 = base_radius(TEETH_S, 2.75e-3, 10), base_radius(TEETH_1, 2.75e-3, 10)
R_2, R_R = base_radius(TEETH_2, 2e-3, 12), base_radius(TEETH_R, 2e-3, 12)
PHI = math.tau / N * np.arange(N)
# force of the sun on star I, and of the ring on star II, eq. (23)
A = np.exp(1j * (math.pi / 2 - ALPHA_1 + PHI))
B = np.exp(1j * (math.pi / 2 + ALPHA_2 + PHI))
RHO = R_1 / R_2
C = 1 / K_SP + RHO**2 / K_PR
W_S = SPEED
W_P = -SPEED * TEETH_S / TEETH_1
W_R = W_P * TEETH_2 / TEETH_R


def along(direction: NDArray[np.complex128], vector: Any) -> Array:
    """Scalar product of plane vectors written as complex numbers."""
    return np.asarray((direction.conj() * vector).real)


def k1(sun: float = K_W, ring: float = K_R) -> float:
    """Stiffness against an error of the first harmonic: supports and meshes in series [N/m]."""
    return 1 / (C + (N / 2) / sun + (N / 2) * RHO**2 / ring)


def share(error: float, stiffness: float, torque: float = TORQUE) -> float:
    """J - 1 of one error."""
    return stiffness * error / (torque / (N * R_S))


def compatibility(g1: Array, g2: Array, torque: float = TORQUE, sun: float = K_W, ring: float = K_R) -> Array:
    """J (T, N) by the source's route; g1, g2 (T, N) openings of both meshes [m].

    Unknown: sun torques T_i, places of sun and ring.  Angles of deformation, eq. (7): of the sun against star I
    T_i / (K r_s^2) + opening / r_s, of star II against the ring the same with r_2 and T_i r_1 / r_s, carried to the sun
    with r_1 / r_s, eqs. (3) and (4) put right; a float x takes a . x off the opening.
    """
    angle = np.zeros((N, N + 4))
    angle[:, :N] = np.eye(N) * (1 / (K_SP * R_S**2) + (R_1 / R_S) ** 2 / (K_PR * R_2**2))
    angle[:, N : N + 2] = -np.stack([A.real, A.imag], axis=1) / R_S
    angle[:, N + 2 :] = -(R_1 / R_S) * np.stack([B.real, B.imag], axis=1) / R_2
    matrix, right = np.zeros((N + 4, N + 4)), np.zeros((len(g1), N + 4))
    opened = g1 / R_S + (R_1 / R_S) * g2 / R_2
    matrix[: N - 1], right[:, : N - 1] = angle[0] - angle[1:], opened[:, 1:] - opened[:, :1]
    matrix[N - 1, :N], right[:, N - 1] = 1.0, torque
    for row, directions, radius, support in ((N, A / R_S, N, sun), (N + 2, B / R_S * RHO, N + 2, ring)):
        matrix[row, :N], matrix[row + 1, :N] = directions.real, directions.imag
        matrix[row, radius] = matrix[row + 1, radius + 1] = support
    found = np.linalg.solve(matrix, right.T).T
    return np.asarray(found[:, :N] / (torque / N))


def closed_map(g1: Array, g2: Array, torque: float = TORQUE) -> Array:
    """J (T, N) by circular harmonics of e = g1 + rho g2: none, 1/k1, c for harmonics 0, 1, 2."""
    spectrum = np.fft.fft(g1 + RHO * g2, axis=-1)
    stiffness = np.array([0, k1(), 1 / C, 1 / C, k1()])
    force = np.fft.ifft(-stiffness * spectrum, axis=-1).real
    return np.asarray(1 + force / (torque / (N * R_S)))


def one_sided(e: Array, torque: float = TORQUE, sun: float = K_W, ring: float = K_R) -> Array:
    """J (N,) of branches that only push: the branch forces of least energy, over every set of open branches."""
    Q = C * np.eye(N)
    for directions, support in ((A, sun), (RHO * B, ring)):
        Q += (np.outer(directions, directions.conj()).real) / support
    valid = []
    for closed in (np.array(s) for size in range(1, N + 1) for s in itertools.combinations(range(N), size)):
        matrix = np.zeros((closed.size + 1, closed.size + 1))
        matrix[:-1, :-1], matrix[:-1, -1], matrix[-1, :-1] = Q[np.ix_(closed, closed)], -1, 1
        found = np.linalg.solve(matrix, [*-e[closed], torque / R_S])
        force = np.zeros(N)
        force[closed] = found[:-1]
        lifts = Q @ force + e - found[-1]
        if np.all(force >= 0) and np.all(np.delete(lifts, closed) >= -1e-15):  # rounding of 6 um
            valid.append(force)
    assert len(valid) == 1
    return valid[0] / (torque / (N * R_S))


# the drive -----------------------------------------------------------------------------------------------------------


def drive(deviations: Table | None = None, **changes: Any) -> System:
    """The ready drive with other deviations, and changes by path ('__' for points)."""
    overrides: Table = {"deviations": None, **{f"deviations.{k}": v for k, v in (deviations or {}).items()}}
    return assemble(load("dong2019", overrides | {path.replace("__", "."): value for path, value in changes.items()}))


def supports(sun: Any = K_W, ring: Any = K_R) -> Table:
    return {"stages__main__sun__support__radial": sun, "stages__main__ring__support__radial": ring}


def torque_of(value: float) -> Table:
    return {"operation__torque__sun": value}


def shares(result: xr.Dataset) -> Array:
    """N F_i / sum F of sun meshes and of ring meshes, (2, N, T)."""
    force = result["mesh_force"].values.reshape(2, N, -1)
    ratio: Array = N * force / force.sum(axis=1, keepdims=True)
    return ratio


def common_period(system: System, samples: int = 16) -> Record:
    """The record over which everything repeats, counted in turns of the sun."""
    return record_of(system, cycles=None, turns=None, of="main/sun", samples=samples, most=10**6)


def J(system: System, cycles: int = 1, samples: int = 1) -> Array:
    """Shares of the sun meshes (N, T) after checking what holds for every state of the drive."""
    result = static(system, StaticOptions(cycles=cycles, samples=samples))
    both, force = shares(result), result["mesh_force"].values
    assert np.min(force) >= 0
    # each star passes on what it gets, T_pr = T_sp r_1 / r_s, normal force times cos beta_b times base radius
    star = system.meshes.cos_base_helix[:, None] * force * np.repeat([R_1, R_2], N)[:, None]
    np.testing.assert_allclose(star[:N], star[N:], atol=1e-9 * star.max())  # rounding of mesh by support stiffness
    np.testing.assert_allclose(star[:N].sum(axis=0), TORQUE_IN(system) * R_1 / R_S, rtol=1e-9)
    np.testing.assert_allclose(both[0], both[1], atol=1e-9)
    np.testing.assert_allclose(both[0].sum(axis=0), N, rtol=1e-12)
    return np.asarray(both[0])


def TORQUE_IN(system: System) -> float:
    return float(system.force[system.dofs.names.index("main/sun/rz")])


def amplitude(um: float = 6.0, phase: Any = 0.0, start: str = "own") -> Table:
    """A vector error; phase [deg], one or five."""
    degrees = f"{np.asarray(phase, float).tolist()} deg"
    return {"amplitude": um * UM, "phase": degrees, "from": start}


@pytest.fixture(scope="module")
def train() -> Train:
    return load("dong2019")


@pytest.fixture(scope="module")
def system(train: Train) -> System:
    return assemble(train)


# kinematics and assembly ---------------------------------------------------------------------------------------------


def test_ratio_torque_and_common_period(train: Train, system: System) -> None:
    speed, torque = train.kinematics.speed, train.kinematics.torque
    assert speed is not None
    assert torque is not None
    assert speed["main.ring"] / speed["main.sun"] == Fraction(-124, 363)
    assert round(363 / 124, 4) == 2.9274
    assert torque["main.sun"] == pytest.approx(TORQUE, rel=1e-12)
    assert torque["main.ring"] == pytest.approx(904.42, abs=5e-3)  # to the digits compared
    record = common_period(system)
    assert (record.count, record.period, record.name) == (363, 363, "turns of main/sun")
    assert float(epicyclic.check("dong2019").hunting_period.sel(stage="main")) == 363 * TEETH_S
    stars = drive({"sun.run_out": "6 um", "star1.run_out": "6 um"})
    assert common_period(stars).period == 11


def test_frequencies_of_the_errors(system: System) -> None:
    turning = [abs(w) / math.tau for w in (W_R, W_S, W_P)]
    assert [float(line.frequency) for line in system.lines] == pytest.approx([0.0, *turning], rel=1e-12)


def test_radii_and_warnings(train: Train) -> None:
    radii = {body.member: body.gear.base_radius for body in train.bodies if body.gear is not None}
    assert list(radii.values()) == pytest.approx([R_S, R_R, R_1, R_2], rel=1e-14)
    texts = " ".join(train.warnings)
    for told in ("64.2257 mm", "69.5192 mm", "identical shafts of star2", "218 N/(mm um)", "236 N/(mm um)"):
        assert told in texts


def test_each_shaft_has_a_clocking_of_its_own(train: Train) -> None:
    """(24 31 + 99 22)/5 = 2922/5 is not whole: no one clocking fits; fitted ones do, 0.1 deg beside does not."""
    assert Fraction(TEETH_S * TEETH_2 + TEETH_R * TEETH_1, N) == Fraction(2922, 5)
    fitted = next(value.value for value in train.values if value.path == "stages.main.star2.clocking")
    assert isinstance(fitted, list)
    assert len({round(angle, 9) for angle in fitted}) == N
    off = [angle + math.radians(0.1) * (i == 3) for i, angle in enumerate(fitted)]
    for clocking, fits in ((fitted, True), (fitted[0], False), (off, False)):
        warnings = load("dong2019", {"stages.main.star2.clocking": clocking}).warnings
        assert any("cannot be assembled" in text for text in warnings) != fits
    # what the shafts differ by is the same whichever tooth is counted from: multiples of 2922/5 pitch of both gears
    step = Fraction(1, TEETH_1 * TEETH_2)
    between = [(angle - fitted[0]) / math.tau / float(step) for angle in fitted]
    assert sorted(round(5 * x % 5, 6) for x in between) == [0, 1, 2, 3, 4]


# published numbers ---------------------------------------------------------------------------------------------------


def test_compliances() -> None:
    printed = [float(f"{k:.2e}") for k in (k1(), k1(sun=math.inf), k1(ring=math.inf), 1 / C)]
    assert printed == [2.54e6, 3.95e6, 7.11e6, 4.60e9]


@pytest.mark.parametrize(("torque", "printed"), [(200, 1.012), (245, 1.010), (285, 1.008), (325, 1.007), (370, 1.006)])
def test_fig_19(torque: float, printed: float) -> None:
    """One 6 um error on the sun's side, elastic supports, torque read as the input's."""
    found = J(drive({"sun.run_out": "6 um"}, **torque_of(torque)), cycles=24, samples=5).max()
    assert round(found, 3) == printed
    # 120 instants a turn, 5 of which share one place: cos(pi/120)
    assert found - 1 == pytest.approx(share(6 * UM, k1(), torque), rel=4e-4)


def test_fig_16_both_floating(system: System) -> None:
    found = J(drive({"sun.run_out": "6 um"}), cycles=24, samples=5).max()
    assert f"{found:.4f}" == "1.0078"


def test_fig_16_with_the_supports_exchanged() -> None:
    """1.008 and 1.023 of Fig. 16 and all of Fig. 19, by the series formula too; 1.058 needs other supports."""
    cases: tuple[tuple[Any, float, float], ...] = ((K_R, K_R, 1.008), ("inf", math.inf, 1.023))
    for given, sun, printed in cases:
        found = J(drive({"sun.run_out": "6 um"}, **supports(given, K_W)), cycles=24, samples=5).max()
        assert round(found, 3) == printed
        assert found - 1 == pytest.approx(share(6 * UM, k1(sun, K_W), TORQUE), rel=4e-4)
    for torque, printed in ((200, 1.012), (245, 1.010), (285, 1.008), (325, 1.007), (370, 1.006)):
        assert round(1 + share(6 * UM, k1(K_R, K_W), torque), 3) == printed
    # 1/k1 of both afloat, sun fixed, both fixed but for one factor; their differences are the supports
    both, fixed, neither = (np.array([printed - 1 - 0.0005, printed - 1 + 0.0005]) for printed in (1.008, 1.023, 1.058))
    ratio = [(1 / x - 1 / y) / (1 / y - 1 / z) for x in both for y in fixed for z in neither]  # monotone in each
    assert [round(float(bound), 1) for bound in (min(ratio), max(ratio))] == [2.7, 3.6]
    assert [round(k / RHO**2, 2) for k in (K_R / K_W, K_W / K_R)] == [0.56, 2.03]


@pytest.mark.parametrize(
    ("sun", "ring"), [(K_W, K_R), ("inf", K_R), (K_W, "inf"), (1e5, K_R), (3e8, 2e7), ("inf", "inf")]
)
@pytest.mark.parametrize("cause", ["sun.position", "ring.position", "star1.position", "star1.run_out", "star2.run_out"])
def test_series_of_supports(sun: Any, ring: Any, cause: str) -> None:
    """1/k1 = c + (N/2)/K_s + (N/2) rho^2/K_r, wherever the error is; behind star II it weighs rho."""
    stiff = k1(*(math.inf if value == "inf" else value for value in (sun, ring)))
    torque = 1e4  # both rigid, 1/k1 = c: closed for the 6 um only when heavily loaded
    system = drive(
        {cause: amplitude(1e-3 if stiff > 1e9 else 6, start="stage")}, **supports(sun, ring), **torque_of(torque)
    )
    size = (1e-9 if stiff > 1e9 else 6 * UM) * share(1.0, stiff, torque)
    both = {"star1.position": A + RHO * B, "ring.position": -RHO * B, "star2.run_out": RHO * B}
    e = along(both.get(cause, A if cause.startswith("star") else -A), 1.0)
    # 1e-6: rounding of 1e9 N/m meshes against a nanometre
    np.testing.assert_allclose(J(system)[:, 0] - 1, -size * e, atol=1e-6 * size)


def as_printed(time_: Array) -> tuple[Array, Array]:
    """Openings of both meshes by eqs. (8)-(19), (24), (25) as printed in sign and phase; lengths summed.

    The printed length adds to the deformation, so an opening is minus it; what is the same for every star drops out.
    """
    b, t = math.radians(0.25), time_[:, None]
    sun = np.sin(W_S * t + b + ALPHA_1 - PHI) * 2 + np.sin(b + ALPHA_1 - PHI)
    ring = np.sin(W_R * t + b - ALPHA_2 - PHI) * 2 + np.sin(b - ALPHA_2 - PHI)
    return -6 * UM * sun, 6 * UM * ring


def test_fig_6_needs_the_printed_sign_of_the_ring() -> None:
    """1.036 with eqs. (14), (15), (19) as printed, where errors of the ring have the wrong sign; 1.044 put right."""
    wrong = static(assemble(load("dong2019", PRINTED_SIGN)), StaticOptions(turns=363, of="main/sun", samples=16))
    shared = shares(wrong)[0]
    np.testing.assert_allclose(shared.T, closed_map(*as_printed(wrong["time"].values)), atol=1e-9)
    assert round(shared.max(), 4) == 1.0359
    # printed: 1.023 1.036 1.028 1.030 1.025
    assert [round(float(x), 3) for x in sorted(shared.max(axis=1))] == [1.026, 1.026, 1.032, 1.032, 1.036]
    right = shares(static(assemble(load("dong2019")), StaticOptions(turns=363, of="main/sun", samples=16)))[0]
    assert round(right.max(), 3) == 1.044
    placed = {"sun.position": amplitude(phase=0.25), "ring.position": amplitude(phase=0.25)}
    assert round(J(drive(placed)).max(), 4) == 1.0137
    placed["ring.position"] = amplitude(phase=180.25)
    assert round(J(drive(placed)).max(), 4) == 1.0053


def test_lost_star() -> None:
    """A star that is 6 um short carries nothing; with supports soft against meshes the others share (5 -+ sqrt 5)/4."""
    low, high = (5 - 5**0.5) / 4, (5 + 5**0.5) / 4
    assert (round(low, 6), round(high, 6)) == (0.690983, 1.809017)
    for gap, torque, support in ((6, TORQUE, 1e4), (60, 50.0, 1e4), (6, TORQUE, 0.0)):
        short = {"meshes.sun-star1.gap": f"[0, 0, 0, {gap}, 0] um"}
        found = J(drive(short, **supports(support, support), **torque_of(torque)))[:, 0]
        np.testing.assert_allclose(found, [low, low, high, 0, high], atol=1e-5)
    found = J(drive({"meshes.sun-star1.gap": "[0, 0, 0, 6, 0] um"}))[:, 0]
    assert [round(float(x), 4) for x in found] == [0.6916, 0.6916, 1.8084, 0, 1.8084]
    soft = {
        f"stages__main__meshes__{pair}__stiffness": k / 10 for pair, k in (("sun-star1", K_SP), ("star2-ring", K_PR))
    }
    found = J(drive({"meshes.sun-star1.gap": "[0, 0, 0, 6, 0] um"}, **soft, **torque_of(100)))[:, 0]
    assert [round(float(x), 4) for x in found] == [0.6971, 0.6971, 1.8029, 0, 1.8029]


@pytest.mark.parametrize(("softer", "printed"), [(1, 1735), (10, 174)])
def test_torque_that_closes_a_short_star(softer: int, printed: float) -> None:
    """1735 and 174 N m: J_4 = 0 where 2/5 (k1 + 1/c) e = F0."""
    c = C * softer
    first = 1 / (c + (N / 2) / K_W + (N / 2) * RHO**2 / K_R)
    limit = N * R_S * 0.4 * (first + 1 / c) * 6 * UM
    assert round(limit) == printed
    normal = 6 * float(drive().meshes.cos_base_helix[0])  # a gap is given along the tooth normal
    stiffness = {"sun-star1": K_SP / softer, "star2-ring": K_PR / softer}
    soft = {f"stages__main__meshes__{pair}__stiffness": k for pair, k in stiffness.items()}
    short = {"meshes.sun-star1.gap": f"[0, 0, 0, {normal}, 0] um"}
    above, below = (J(drive(short, **soft, **torque_of(limit * x)))[3, 0] for x in (1.001, 0.999))
    assert above == pytest.approx(0.001, rel=2e-3)  # J_4 = 1 - limit / T
    assert below == 0


def test_random_places_of_the_errors_of_the_stars() -> None:
    """With the printed mesh stiffness star errors that point anywhere separate teeth; softer teeth share."""
    rng = np.random.default_rng(2019)
    worst = {1: 0.0, 10: 0.0, 100: 0.0, 1000: 0.0}
    for _ in range(4):
        errors = {
            f"star{k}.{cause}": amplitude(phase=rng.uniform(0, 360, N).round(3))
            for k, cause in ((1, "position"), (1, "run_out"), (1, "bearing_run_out"), (2, "run_out"))
        }
        for softer in worst:
            stiffness = {"sun-star1": K_SP / softer, "star2-ring": K_PR / softer}
            soft = {f"stages__main__meshes__{pair}__stiffness": k for pair, k in stiffness.items()}
            worst[softer] = max(worst[softer], float(J(drive(errors, **soft), cycles=264).max()))
    assert 2.2 < worst[1] < 2.4  # 2.3
    assert 2.2 < worst[10] < 2.4  # the same
    # 1.23 and 1.04 in one draw; over ten draws 1.29 to 1.52 and 1.03 to 1.06
    assert 1.2 < worst[100] < 1.6
    assert 1.02 < worst[1000] < 1.07


def test_bearings_even_out_run_outs_that_point_anywhere() -> None:
    """Sixty draws of the directions of five run-outs: 1.006 to 1.031 on bearings of 3e7 N/m; of ten 2.24 on rigid ones.

    On rigid stars no direction matters: every draw says the same.
    """
    found: dict[str, list[float]] = {"inf": [], "3e7 N/m": []}
    rng = np.random.default_rng(2019)
    for draw in range(60):
        errors = {"star1.run_out": amplitude(phase=rng.uniform(0, 360, N).round(3))}
        for bearing, values in found.items():
            if bearing == "inf" and draw >= 10:
                continue
            system = drive(errors, stages__main__star1__bearing__radial=bearing)
            values.append(float(shares(static(system, StaticOptions(turns=11, of="main/sun", samples=24)))[0].max()))
    assert all(f"{value:.2f}" in ("2.24", "2.25") for value in found["inf"])
    soft = found["3e7 N/m"]
    assert (round(min(soft), 3), round(max(soft), 3)) == (1.006, 1.031)


def test_fig_16_by_the_errors_of_the_sun() -> None:
    """Three errors of 6 um that add up to 18 um, supports as printed: 1.023 as k1 has it; the ring rigid 1.065."""
    errors = {"sun.position": amplitude(phase=0.25), "sun.run_out": amplitude(phase=0.25)}
    errors["sun.bearing_run_out"] = amplitude(phase=180.25)
    for ring, printed in ((K_R, 1.023), (math.inf, 1.065)):
        system = drive(errors, **supports(ring="inf" if math.isinf(ring) else ring))
        found = float(shares(static(system, StaticOptions(turns=1, of="main/sun", samples=80)))[0].max())
        # a standing error of 6 um and a turning one of 12: the star nearest the standing one is at most 36 deg off
        most, least = (1 + share(size * UM, k1(ring=ring)) for size in (18, 12 + 6 * math.cos(math.pi / N)))
        assert least < found < most
        assert round(found, 3) == printed


# spline --------------------------------------------------------------------------------------------------------------

PRINTED_SIGN: Table = {
    "deviations.ring.position.phase": "180.25 deg",
    "deviations.ring.run_out.phase": "180.25 deg",
    "deviations.ring.bearing_run_out.phase": "0.25 deg",
}
SLIP = 63.9  # N, fitted: it gives the printed 1.013 of Fig. 15


def spline(clearance: float, torque: float | None = None, **friction: Any) -> xr.Dataset:
    """The drive as for Fig. 6 (printed sign), its spline with a clearance [um], over the common period."""
    path = "stages.main.sun.support"
    changes = {f"{path}.clearance": f"{clearance} um", f"{path}.friction": friction or {"force": SLIP}}
    load_ = {} if torque is None else {"operation.torque.sun": torque}
    return epicyclic.static("dong2019", overrides=PRINTED_SIGN | changes | load_, turns=363, of="main/sun", samples=16)


def float_force(R: Array, clearance: float, friction: float) -> Array:
    """Eq. (27) with S_1 = F_m / K_w, which makes it continuous [N]."""
    first = friction / K_W
    return np.minimum(K_W * R, friction) + K_W * np.maximum(R - first - clearance, 0)


def spline_closed(g1: Array, g2: Array, clearance: float, friction: float) -> Array:
    """J (T, N) in closed form: c0 R + g(R) = c0 |E| for the first harmonic E of the errors, by bisection."""
    c0 = (N / 2) / (C + (N / 2) * RHO**2 / K_R)
    error = (g1 + RHO * g2) @ A * (2 / N)
    low, high = np.zeros(len(error)), np.abs(error)
    for _ in range(200):
        R = (low + high) / 2
        above = c0 * R + float_force(R, clearance, friction) > c0 * np.abs(error)
        low, high = np.where(above, low, R), np.where(above, R, high)
    size = 2 * float_force(R, clearance, friction) / (TORQUE / R_S)
    return np.asarray(1 - size[:, None] * along(A, (error / np.abs(error))[:, None]))


@pytest.mark.parametrize("clearance", [0, 2, 10, 50])
def test_spline_in_closed_form(clearance: float) -> None:
    result = spline(clearance)
    expected = spline_closed(*as_printed(result["time"].values), clearance * UM, SLIP)
    np.testing.assert_allclose(shares(result)[0].T, expected, atol=1e-8)


def test_fig_15_by_a_fitted_friction_force() -> None:
    """1.036 without clearance, 1.013 with enough of it: 18 um for the fitted force; 0.1 T over 20 mm never slips."""
    found = [round(float(shares(spline(clearance)).max()), 4) for clearance in (0, 16, 18, 20, 50)]
    assert found[0] == 1.0359
    assert found[1] > 1.013
    assert found[2:] == [1.013] * 3
    # S_1 of the spline, and where the largest error no longer reaches the end of the clearance
    c0 = (N / 2) / (C + (N / 2) * RHO**2 / K_R)
    error = share(1.0, k1())  # J - 1 per metre
    assert 16e-6 < 0.03588 / error - SLIP / c0 - SLIP / K_W < 18e-6
    held = spline(20, coefficient=0.1, radius=0.02)
    assert round(float(shares(held).max()), 4) == 1.0359
    assert set(held["group_state"].values.ravel().tolist()) == {"stick"}


def test_plateau_of_a_friction_that_follows_the_torque() -> None:
    coefficient = SLIP * 0.02 / TORQUE
    found = [shares(spline(50, T, coefficient=coefficient, radius=0.02)).max() for T in (200.0, TORQUE, 400.0)]
    np.testing.assert_allclose(found, found[1], rtol=1e-9)


def test_coulomb_friction_has_a_history() -> None:
    """Real friction opposes the motion, (27) the place: the largest share is the same, the shares in time are not."""
    holonomic, coulomb = (spline(20, force=SLIP, law=law) for law in ("holonomic", "coulomb"))
    assert "warm-up" in coulomb.attrs["history"]
    assert [json.loads(r.attrs["laws"])["main/sun/support"]["kind"] for r in (holonomic, coulomb)] == [
        "holonomic spline",
        "coulomb spline",
    ]
    first, second = shares(holonomic)[0], shares(coulomb)[0]
    assert round(first.max(), 4) == round(second.max(), 4) == 1.013
    assert round(float(np.abs(first - second).max()), 3) == 0.023


def test_verdicts() -> None:
    audit = read_audit("dong2019").audit
    said = {(row.place, row.verdict) for row in audit.rows}
    theory = [
        row.verdict for row in audit.rows if row.quantity.endswith("N m") and row.place == "Fig. 19 and section 6"
    ]
    assert theory[:5] == ["under a reading"] * 5
    for column, verdict in (("A_s", "under a reading"), ("A_pI", "under a reading")):
        assert (f"Table 2, {column}", verdict) in said
    for column in ("A_pII", "A_r"):
        assert {verdict for place, verdict in said if place == f"Table 2, {column}"} == {"not reproducible"}
    fig16 = {row.published: row.verdict for row in audit.rows if row.place == "Fig. 16"}
    assert fig16 == {1.008: "under a reading", 1.023: "under a reading", 1.058: "not reproducible"}
    assert audit.resolved("spline-20").fitted == ("stages.main.sun.support.friction",)


# two routes ----------------------------------------------------------------------------------------------------------


def everything(rng: np.random.Generator) -> tuple[Table, Table]:
    """Errors of every member, any phases; small at the stars, so that teeth stay closed: file table, and vectors."""
    phase = {name: rng.uniform(0, 360, N if name.startswith("star") else None) for name in FEATURES}
    size = {name: 0.002 if name.startswith("star") else 6.0 for name in FEATURES}
    table = {name: amplitude(size[name], np.round(phase[name], 6)) for name in FEATURES}
    vectors = {name: size[name] * UM * np.exp(1j * np.radians(np.round(phase[name], 6))) for name in FEATURES}
    return table, vectors


# speed and sign of the displacement of the gear's centre; an eccentric journal moves the gear the other way
FEATURES = {
    "sun.position": (0.0, 1),
    "sun.run_out": (W_S, 1),
    "sun.bearing_run_out": (W_S, -1),
    "star1.position": (0.0, 1),
    "star1.run_out": (W_P, 1),
    "star1.bearing_run_out": (W_P, -1),
    "star2.run_out": (W_P, 1),
    "ring.position": (0.0, 1),
    "ring.run_out": (W_R, 1),
    "ring.bearing_run_out": (W_R, -1),
}


def openings(vectors: Table, time_: Array) -> tuple[Array, Array]:
    """g1 = a . (e_1 - e_s), g2 = b . (e_2 - e_r), eqs. (8)-(25) put right, (T, N) [m]."""
    first, second = np.zeros((len(time_), N)), np.zeros((len(time_), N))
    for name, (speed, sign) in FEATURES.items():
        star = name.startswith("star")
        own = np.exp(1j * PHI) if star else 1.0
        centre = sign * vectors[name] * np.exp(1j * speed * time_[:, None]) * own
        if name.startswith(("sun", "star1")):
            first += along(A, centre) * (1 if star else -1)
        if name.startswith(("ring", "star2")) or name in ("star1.position", "star1.bearing_run_out"):
            second += along(B, centre) * (1 if star else -1)
    return first, second


def test_network_is_compatibility_and_closed_map() -> None:
    rng = np.random.default_rng(1)
    for _ in range(3):
        table, vectors = everything(rng)
        result = static(drive(table), StaticOptions(cycles=240, samples=3))
        found = shares(result)[0].T
        assert found.min() > 0.9
        g1, g2 = openings(vectors, result["time"].values)
        np.testing.assert_allclose(found, compatibility(g1, g2), atol=1e-9)
        np.testing.assert_allclose(found, closed_map(g1, g2), atol=1e-9)


def test_network_is_the_one_sided_minimum() -> None:
    """Any gaps, any teeth open: the branch forces of least energy, of which there is one set."""
    rng = np.random.default_rng(7)
    lost = 0
    for _ in range(20):
        gap = rng.uniform(0, 10, (2, N)).round(4)
        torque = float(10 ** rng.uniform(1.5, 3.5))
        table = {"meshes.sun-star1.gap": f"{gap[0].tolist()} um", "meshes.star2-ring.gap": f"{gap[1].tolist()} um"}
        found = J(drive(table, **torque_of(torque)))[:, 0]
        # gaps stand along the tooth normal, e in the transverse plane
        normal = drive().meshes.cos_base_helix[[0, N]]
        expected = one_sided((gap[0] / normal[0] + RHO * gap[1] / normal[1]) * UM, torque)
        np.testing.assert_allclose(found, expected, atol=1e-8)
        lost += int(np.sum(found == 0))
    assert lost > 10


# twist and speed ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shaft", [{"rz": "2e4 N m/rad"}, {"diameter": "20 mm", "length": "60 mm"}])
def test_twist_of_the_shafts(shaft: Table) -> None:
    """A shaft in torsion adds r_1^2 / k_t to the compliance of every branch; the other directions are kept rigid."""
    # G J/l of the shaft
    stiff = 2e4 if "rz" in shaft else 206e9 / 2.6 * math.pi * 0.02**4 / 32 / 0.06
    table = shaft | ({} if "rz" in shaft else dict.fromkeys(("x", "y", "z", "rx", "ry"), "inf"))
    gap = np.array([0, 3, 1, 0, 2])
    system = drive({"meshes.sun-star1.gap": f"{gap.tolist()} um"}, stages__main__star2__shaft=table)
    e = gap * UM / system.meshes.cos_base_helix[0]
    spectrum = np.fft.fft(e)
    c = C + R_1**2 / stiff
    first = 1 / (1 / k1() + R_1**2 / stiff)
    expected = 1 - np.fft.ifft(np.array([0, first, 1 / c, 1 / c, first]) * spectrum).real / (TORQUE / (N * R_S))
    np.testing.assert_allclose(J(system)[:, 0], expected, atol=1e-9)


def test_full_common_period_is_quick(system: System, capsys: pytest.CaptureFixture[str], slowness: float) -> None:
    static(system, StaticOptions(cycles=1))  # imports
    start = time.perf_counter()
    found = static(system, StaticOptions(turns=363, of="main/sun", samples=16))
    took = time.perf_counter() - start
    with capsys.disabled():
        print(f"\ndong2019: {found.sizes['time']} instants of 363 sun turns in {took:.2f} s")
    assert found.sizes["time"] == 363 * 16
    assert took < 2.0 * slowness
    assert not any("shorter" in text for text in json.loads(found.attrs["warnings"]))
