"""Yue 2014, meshed double planets: the three ready drives against the corrected energies and their closed forms.

The source's own natural frequencies follow from no reading of its equations; what is compared here are the energies of
eq. 2 and 6 with the errors of print corrected, written out a second time below, and chains of masses and springs into
which symmetry cuts them.  [yue2014]
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.questions.modes.eigen import eigen
from epicyclic.questions.modes.modal import modal
from epicyclic.system.assembly import assemble
from epicyclic.system.system import System
from epicyclic.train.resolution import load
from epicyclic.warning_codes import code_of

Array = NDArray[np.float64]
Changes = dict[str, Any]

CASES = {"i": "carrier", "ii": "ring", "iii": "sun"}
TEETH: Changes = {f"stages.main.{gear}.base_radius": None for gear in ("sun", "p", "d", "ring")}
FREE: Changes = {"operation.held": []}
# Roots of well separated symmetric eigenproblems of order 20: rounding.
ROOTS = 1e-10


# the energies of the source, written out -----------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Paper:
    """Table 1, in SI; the coordinates are x_s, y_s, th_s, th_r, th_c, th_p1 .., th_d1 .., planet angles absolute."""

    N: int = 3
    Rs: float = 0.0580
    Rp: float = 0.0345
    Rd: float = 0.0363
    Rr: float = 0.1396
    Rpc: float = 0.102
    Rdc: float = 0.114
    Js: float = 0.00388
    Jp: float = 0.00114
    Jd: float = 0.00132
    Jr: float = 0.724
    Jc: float = 0.104
    ms: float = 2.0
    mp: float = 1.8
    md: float = 1.8
    ksp: float = 21e6
    kpd: float = 21e6
    kdr: float = 21e6
    kz: float = 3.2e6

    @property
    def alpha(self) -> float:
        """Angle at which the sun pushes p."""
        return math.acos((self.Rs + self.Rp) / self.Rpc)


def potential(q: Array, w: Paper, *, phased: bool = True, sign: float = 1.0, projected: float = 1.0) -> float:
    """Eq. 5 to 7.  As printed: phased False (no branch angle in the sun's float), sign -1, projected cos 25 deg."""
    x, y, s, r, c = q[:5]
    p, d = q[5 : 5 + w.N] - c, q[5 + w.N :] - c  # relative to the carrier, as the source counts them
    phi = 2 * math.pi * np.arange(w.N) / w.N
    # branch j stands at the polar angle -pi/2 - phi_j for the source, at +phi_j for the drive
    angle = w.alpha + (-math.pi / 2 - phi if phased else np.zeros(w.N))
    sp = s * w.Rs - projected * c * w.Rs + p * w.Rp + x * np.cos(angle) - y * np.sin(angle)
    pd = p * w.Rp + sign * d * w.Rd
    dr = projected * c * w.Rr + d * w.Rd - r * w.Rr
    meshes = w.ksp * sp @ sp + w.kpd * pd @ pd + w.kdr * dr @ dr
    return 0.5 * float(meshes + w.kz * (x * x + y * y))


def kinetic(v: Array, w: Paper) -> float:
    """Eq. 2 to 4."""
    x, y, s, r, c = v[:5]
    p, d = v[5 : 5 + w.N], v[5 + w.N :]
    carrier = w.Jc + w.N * (w.mp * w.Rpc**2 + w.md * w.Rdc**2)
    turning = w.Js * s * s + w.Jr * r * r + carrier * c * c + w.Jp * p @ p + w.Jd * d @ d
    return 0.5 * float(turning + w.ms * (x * x + y * y))


def hessian(energy: Callable[[Array], float], n: int) -> Array:
    """Second derivatives of a quadratic form by second differences, exact but for rounding."""
    unit = np.eye(n)
    single = [energy(e) for e in unit]
    return np.array([[energy(unit[i] + unit[j]) - single[i] - single[j] for j in range(n)] for i in range(n)])


def names(planets: int) -> list[str]:
    central = ["sun/x", "sun/y", "sun/rz", "ring/rz", "carrier/rz"]
    return [f"main/{name}" for name in [*central, *(f"{g}/{i + 1}/rz" for g in "pd" for i in range(planets))]]


def matrices(system: System, planets: int) -> tuple[Array, Array]:
    """M and K in the order of the energies above."""
    at = [system.dofs.names.index(name) for name in names(planets)]
    return system.M[np.ix_(at, at)], system.mean_stiffness[np.ix_(at, at)]


def system_of(case: str = "i", changes: Changes | None = None) -> System:
    return assemble(load(f"yue2014-{case}", changes or None))


def omega(system: System) -> Array:
    """Natural angular frequencies [rad/s]."""
    return eigen(system).omega


def chain(masses: list[float], springs: list[float], grounds: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Natural angular frequencies of masses in a row [rad/s]: springs between them, and to the ground at both ends."""
    n = len(masses)
    K = np.diag([grounds[0]] + [0.0] * (n - 2) + [grounds[1]])
    for i, k in enumerate(springs):
        K[i : i + 2, i : i + 2] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    squared: Array = scipy.linalg.eigh(K, np.diag(masses), eigvals_only=True)
    return np.sqrt(np.maximum(squared, 0.0))


def overall_chain(w: Paper) -> Array:
    """All branches alike, carrier held, without the rigid motion."""
    ends = w.Js / (w.N * w.Rs**2), w.Jr / (w.N * w.Rr**2)
    masses = [ends[0], w.Jp / w.Rp**2, w.Jd / w.Rd**2, ends[1]]
    return chain(masses, [w.ksp, w.kpd, w.kdr])[1:]


def double_chain(w: Paper) -> Array:
    """The sun floats, central members do not turn; N >= 3."""
    masses = [2 * w.ms / w.N, w.Jp / w.Rp**2, w.Jd / w.Rd**2]
    return chain(masses, [w.ksp, w.kpd], (2 * w.kz / w.N, w.kdr))


def planet_chain(w: Paper) -> Array:
    """Central members at rest; N - 3 fold."""
    return chain([w.Jp / w.Rp**2, w.Jd / w.Rd**2], [w.kpd], (w.ksp, w.kdr))


# matrices ------------------------------------------------------------------------------------------------------------


def test_matrices_are_second_derivatives_of_the_energies() -> None:
    w = Paper()
    M, K = matrices(system_of(changes=FREE), 3)
    n = len(M)
    T, V = hessian(lambda v: kinetic(v, w), n), hessian(lambda q: potential(q, w), n)
    # rounding of sums of three terms, in units of the largest entry
    assert np.abs(K - V).max() < 1e-14 * np.abs(V).max()
    assert np.abs(M - T).max() < 1e-14 * np.abs(T).max()
    assert np.abs(M - M.T).max() < 1e-15 * np.abs(M).max()
    assert np.abs(K - K.T).max() < 1e-15 * np.abs(K).max()


def test_dampers_stand_where_the_springs_do() -> None:
    system = system_of(changes=FREE)
    at = [system.dofs.names.index(name) for name in names(3)]
    C = (system.C + (system.meshes.B * system.meshes.damping) @ system.meshes.B.T)[np.ix_(at, at)]
    w = Paper(ksp=1000.0, kpd=1000.0, kdr=1000.0, kz=100.0)
    expected = hessian(lambda q: potential(q, w), len(C))
    assert np.abs(C - expected).max() < 1e-14 * np.abs(expected).max()  # rounding, as above


@pytest.mark.parametrize("case", CASES)
def test_matrices_of_a_case_are_those_without_the_held_member(case: str) -> None:
    system, free = system_of(case), system_of(case, FREE)
    kept = [name for name in free.dofs.names if name != f"main/{CASES[case]}/rz"]
    assert list(system.dofs.names) == kept
    assert len(kept) == 10
    at = [free.dofs.names.index(name) for name in kept]
    for held, whole in ((system.M, free.M), (system.mean_stiffness, free.mean_stiffness)):
        # rounding of sums of three terms, in units of the largest entry
        assert np.abs(held - whole[np.ix_(at, at)]).max() < 1e-14 * np.abs(held).max()


def test_turning_as_a_whole_stresses_nothing() -> None:
    K = matrices(system_of(changes=FREE), 3)[1]
    whole = np.array([0.0, 0.0, *np.ones(9)])
    assert np.abs(K @ whole).max() < 1e-14 * np.abs(K).max()  # rounding


def test_running_stresses_nothing() -> None:
    """The second neutral motion goes by tooth counts, where the base radii do."""
    K = matrices(system_of(changes=FREE | TEETH), 3)[1]
    running = np.array([0.0, 0.0, 1 / 32, 1 / 77, 0.0, *[-1 / 19] * 3, *[1 / 20] * 3])
    assert np.abs(K @ running).max() < 1e-14 * np.abs(K).max()  # rounding


@pytest.mark.parametrize("held", [(), ("carrier",), ("ring",), ("sun",)])
def test_zero_modes(held: tuple[str, ...]) -> None:
    system = system_of(changes={"operation.held": list(held)})
    assert int((eigen(system).omega_squared == 0).sum()) == 2 - len(held)
    assert len(system.dofs.names) == 11 - len(held)


def test_what_is_printed_contradicts_itself() -> None:
    """The three errors of eq. 6, each by what it does."""
    w = Paper()
    n = 5 + 2 * w.N
    whole = np.array([0.0, 0.0, *np.ones(n - 2)])
    projected = hessian(lambda q: potential(q, w, projected=math.cos(math.radians(25))), n)
    assert np.abs(projected @ whole).max() == pytest.approx(1.2e5, rel=0.05)  # two digits; it must be 0
    reversed_ring = hessian(lambda q: potential(q, w, sign=-1.0), n)
    for matrix, sense in ((reversed_ring, -1), (hessian(lambda q: potential(q, w), n), 1)):
        running = scipy.linalg.null_space(np.delete(np.delete(matrix, 4, 0), 4, 1), rcond=1e-12)[:, 0]
        assert running[3] / running[2] == pytest.approx(sense * w.Rs / w.Rr, rel=1e-9)  # rounding of a null space
    at = [0, 1, 2, 3, *range(5, n)]
    literal = hessian(lambda q: potential(q, w, phased=False), n)[np.ix_(at, at)]
    mass = hessian(lambda v: kinetic(v, w), n)[np.ix_(at, at)]
    found = np.sqrt(np.maximum(scipy.linalg.eigh(literal, mass, eigvals_only=True), 0.0))
    alone = math.sqrt(w.kz / w.ms)
    assert alone == pytest.approx(1264.9, abs=0.05)  # the digits given
    assert np.isclose(found, alone, rtol=ROOTS).sum() == 1
    assert planet_chain(w) == pytest.approx([4629, 8022], abs=0.5)  # the digits given
    for value in planet_chain(w):  # the pairs of planets leave the sun where it is
        assert np.isclose(found, value, rtol=ROOTS).sum() == 2
    assert len(np.unique(found[1:].round(3))) == 7  # without the neutral motion


# natural frequencies -------------------------------------------------------------------------------------------------

SIMPLE = {  # [rad/s], case I with two decimals, II and III rounded
    "i": ([2703.99, 6781.67, 9422.98], 5e-3),
    "ii": ([3031, 6802, 9569], 0.5),
    "iii": ([970, 5255, 8096], 0.5),
}
DOUBLE = [2134.78, 5514.14, 8256.20]
BY_TEETH = [2701.26, 6775.27, 9414.74], [2133.43, 5508.79, 8244.17]


@pytest.mark.parametrize("case", CASES)
def test_natural_frequencies(case: str) -> None:
    """One neutral motion, three simple and three double roots, the double ones the same in all cases."""
    result = modal(system_of(case))
    angular = result["angular_frequency"].values
    kind, count = result["mode_kind"].values, result["multiplicity"].values
    simple, tolerance = SIMPLE[case]
    assert angular[0] == 0.0
    assert angular[(kind == "rotational") & (angular > 0)] == pytest.approx(simple, abs=tolerance)
    assert angular[kind == "translational"] == pytest.approx(np.repeat(DOUBLE, 2), abs=5e-3)  # two decimals
    assert count.tolist() == np.where(kind == "translational", 2, 1).tolist()
    assert angular[kind == "translational"] == pytest.approx(np.repeat(double_chain(Paper()), 2), rel=ROOTS)


@pytest.mark.parametrize("case", CASES)
def test_natural_frequencies_by_the_energies(case: str) -> None:
    w, kept = Paper(), [k for k in range(11) if k != {"carrier": 4, "ring": 3, "sun": 2}[CASES[case]]]
    M = hessian(lambda v: kinetic(v, w), 11)[np.ix_(kept, kept)]
    K = hessian(lambda q: potential(q, w), 11)[np.ix_(kept, kept)]
    expected = np.sqrt(np.maximum(scipy.linalg.eigh(K, M, eigvals_only=True), 0.0))
    # a root of 0 is the square root of rounding, 1e-8 of the largest
    assert omega(system_of(case)) == pytest.approx(expected, rel=ROOTS, abs=1e-7 * expected[-1])


def test_case_i_is_a_chain() -> None:
    found = omega(system_of("i"))
    expected = np.sort([*overall_chain(Paper()), *np.repeat(double_chain(Paper()), 2)])
    assert found[1:] == pytest.approx(expected, rel=ROOTS)


def test_the_printed_common_frequencies_cannot_follow() -> None:
    """Roots interlace: two masses between grounds part the second and third common value, whatever holds the sun."""
    w = Paper()
    low, high = planet_chain(w)
    for seed in range(20):
        mass, stiffness = 10 ** np.random.default_rng(seed).uniform((-2, 4), (2, 9))
        first, second, third = double_chain(dataclasses.replace(w, ms=mass, kz=stiffness))
        assert first < low * (1 + ROOTS)
        assert low * (1 - ROOTS) < second < high * (1 + ROOTS)
        assert third > high * (1 - ROOTS)
    assert high > 8000 > 6559  # the third one that is printed; as Hz the second one is above `high`
    assert 2 * math.pi * 6456 > high
    # no common factor of all radii or inertias that a reading gives mends it: 1/2 diameters, 0.91 and 1.10 cos 25 deg
    assert (6456 / high, 6559 / high) == pytest.approx((0.805, 0.818), abs=5e-4)


def test_base_radii_by_teeth() -> None:
    result = modal(system_of("i", TEETH))
    angular, kind = result["angular_frequency"].values[1:], result["mode_kind"].values[1:]
    assert angular[kind == "rotational"] == pytest.approx(BY_TEETH[0], abs=5e-3)  # two decimals
    assert angular[kind == "translational"] == pytest.approx(np.repeat(BY_TEETH[1], 2), abs=5e-3)


def test_where_d_stands_changes_no_frequency() -> None:
    for case in CASES:
        behind = system_of(case, {"stages.main.d.ahead": False})
        assert omega(behind) == pytest.approx(omega(system_of(case)), rel=ROOTS, abs=1e-3)  # the rigid mode is 0


@pytest.mark.parametrize("case", CASES)
def test_strain_energy_is_kinetic_energy(case: str) -> None:
    """Summed over the connections, and over the bodies with all six coordinates: two routes past K and M."""
    system = system_of(case)
    modes = eigen(system)
    gaps, links = system.meshes.B.T @ modes.vectors, system.links.B.T @ modes.vectors
    strain = system.meshes.stiffness @ gaps**2 + system.links.stiffness @ links**2
    full = (system.dofs.expand @ modes.vectors).reshape(len(system.dofs.bodies), 6, -1)
    mass = np.nan_to_num(system.body_mass)  # of ring and carrier no mass is printed: they do not translate
    motion = modes.omega_squared * np.einsum("bd,bdm->m", mass, full**2)
    assert strain == pytest.approx(motion, rel=1e-10, abs=1e-6)  # omega^2 reaches 1e8; the rigid mode has none
    assert np.all(strain[1:] > 1e5)  # all but the neutral motion, far above rounding


@pytest.mark.parametrize("case", CASES)
def test_two_kinds_of_modes(case: str) -> None:
    """Overall: branches alike, the sun stays.  Planet (double): central members do not turn, the sun floats."""
    result = modal(system_of(case)).isel(mode=slice(1, None))
    overall, double = result["mode_kind"] == "rotational", result["mode_kind"] == "translational"
    shape = result["full_shape"]
    # rounding of eigenvectors of well separated roots, shapes have their largest component at 1
    assert float(abs(shape.sel(body="main/sun", direction=["x", "y"]).where(overall, drop=True)).max()) < 1e-9
    for gear in "pd":
        alike = shape.sel(body=[f"main/{gear}/{i}" for i in (1, 2, 3)], direction="rz").where(overall, drop=True)
        assert float(abs(alike - alike.isel(body=0)).max()) < 1e-9
        around = shape.sel(body=[f"main/{gear}/{i}" for i in (1, 2, 3)], direction="rz").where(double, drop=True)
        assert float(abs(around.sum("body")).max()) < 1e-9
    central = ["main/sun", "main/ring", "main/carrier"]
    assert float(abs(shape.sel(body=central, direction="rz").where(double, drop=True)).max()) < 1e-9
    floats = abs(shape.sel(body="main/sun", direction=["x", "y"]).where(double, drop=True)).max("direction")
    assert float(floats.min()) > 0.01


def test_damping_moves_the_roots_little() -> None:
    """The printed dampers cannot be what parts the printed frequencies from the computed ones."""
    for case in CASES:
        free, damped = modal(system_of(case)), modal(system_of(case), damped=True)
        fall = 1 - damped["frequency"].values[1:] / free["frequency"].values[1:]
        assert fall.min() > 0
        assert fall.max() < 0.0265  # 2.6 %
        assert float(free["damping_ratio"].max()) < 0.2285


# any parameters ------------------------------------------------------------------------------------------------------


def anything(seed: int, planets: int) -> tuple[Changes, Paper]:
    """A random drive as overrides, and as numbers of the energies; base radii off the teeth's, as printed ones are."""
    draw = np.random.default_rng(seed)
    zs, zp, zd = (int(z) for z in draw.integers((20, 15, 15), (45, 25, 25)))
    zr = zs + zp + zd + int(draw.integers(2, zp + zd - 2))  # the three axes make a triangle
    module, angle = 1e-3 * draw.uniform(2, 6), math.radians(draw.uniform(18, 27))
    Rs, Rp, Rd, Rr = (0.5 * z * module * math.cos(angle) * draw.uniform(0.998, 1.002) for z in (zs, zp, zd, zr))
    some = {key: float(10 ** draw.uniform(-0.5, 0.5)) for key in ("Js", "Jp", "Jd", "Jr", "Jc", "ms", "mp", "md")}
    some |= {key: 2e7 * float(10 ** draw.uniform(-0.5, 0.5)) for key in ("ksp", "kpd", "kdr", "kz")}
    for name, R in (("Js", Rs), ("Jp", Rp), ("Jd", Rd), ("Jr", Rr), ("Jc", Rr)):
        some[name] *= R**2
    axes = {"Rpc": 0.5 * (zs + zp) * module, "Rdc": 0.5 * (zr - zd) * module}
    w = Paper(N=planets, Rs=Rs, Rp=Rp, Rd=Rd, Rr=Rr, **axes, **some)
    stage: Changes = {"planets": planets, "module": module, "pressure_angle": angle}
    stage |= {"sun.teeth": zs, "p.teeth": zp, "d.teeth": zd, "ring.teeth": zr}
    stage |= {"sun.mass": w.ms, "p.mass": w.mp, "d.mass": w.md, "sun.support.radial": w.kz, "carrier.inertia": w.Jc}
    stage |= {f"{gear}.inertia": J for gear, J in (("sun", w.Js), ("p", w.Jp), ("d", w.Jd), ("ring", w.Jr))}
    stage |= {f"meshes.{m}.stiffness": k for m, k in (("sun-p", w.ksp), ("p-d", w.kpd), ("d-ring", w.kdr))}
    stage |= {f"{gear}.base_radius": R for gear, R in (("sun", Rs), ("p", Rp), ("d", Rd), ("ring", Rr))}
    return {f"stages.main.{path}": value for path, value in stage.items()}, w


@pytest.mark.parametrize("planets", [2, 3, 4, 5, 6])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_any_parameters(seed: int, planets: int) -> None:
    changes, w = anything(seed, planets)
    M, K = matrices(system_of("i", changes | FREE), planets)
    n = 5 + 2 * planets
    V = hessian(lambda q: potential(q, w), n)
    T = hessian(lambda v: kinetic(v, w), n)
    # rounding of sums of up to six terms, in units of the largest entry
    assert np.abs(K - V).max() < 1e-13 * np.abs(V).max()
    assert np.abs(M - T).max() < 1e-13 * np.abs(T).max()
    whole = np.array([0.0, 0.0, *np.ones(n - 2)])
    assert np.abs(K @ whole).max() < 1e-13 * np.abs(K).max()
    squared = scipy.linalg.eigh(K, M, eigvals_only=True)
    assert int((squared < 1e-10 * squared[-1]).sum()) == 2  # neutral to rounding; real drives' softest is above 1e-6


@pytest.mark.parametrize("planets", [2, 3, 4, 5, 6])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_any_parameters_fall_into_chains(seed: int, planets: int) -> None:
    changes, w = anything(seed, planets)
    found = omega(system_of("i", changes))[1:]
    if planets == 2:  # two branches hold the sun along one line only; across it, it is alone
        masses = [w.ms / 2, w.Jp / w.Rp**2, w.Jd / w.Rd**2]
        other = [math.sqrt(w.kz / w.ms), *chain(masses, [w.ksp, w.kpd], (w.kz / 2, w.kdr))]
    else:
        other = [*np.repeat(double_chain(w), 2), *np.repeat(planet_chain(w), planets - 3)]
    assert found == pytest.approx(np.sort([*overall_chain(w), *other]), rel=ROOTS)
    for held in ("ring", "sun"):
        others = omega(system_of("i", changes | {"operation.held": [held]}))
        assert all(np.isclose(others, value, rtol=ROOTS).any() for value in other)


# under load ----------------------------------------------------------------------------------------------------------


LOADED: Changes = {
    "operation.torque.sun": "100 N m",
    "operation.speed.sun": "1000 rpm",
    "damping": {"modal": 0.03},
}


@pytest.mark.parametrize("case", CASES)
def test_a_load_balances_on_the_radii_of_the_teeth(case: str) -> None:
    """Every free motion stretches no tooth, and the torque through d and the ring is that of the teeth."""
    operation: Changes = {"operation.torque.carrier" if case == "iii" else "operation.torque.sun": "100 N m"}
    loaded, bare = load(f"yue2014-{case}", operation), load(f"yue2014-{case}")
    assert [code for text in loaded.warnings if "base" in (code := code_of(text) or "")] == ["base-radius-scaled"]
    assert not any("base" in (code_of(text) or "") for text in bare.warnings)
    told = next(text for text in loaded.warnings if code_of(text) == "base-radius-scaled")
    assert "p 34.5 to 34.4397 mm" in told
    for name, z in (("sun", 32), ("p", 19), ("d", 20), ("ring", 77)):
        bodies = [body for body in loaded.bodies if body.member == f"main.{name}"]
        assert all(body.gear is not None for body in bodies)
        radius = z * 2e-3 * math.cos(math.radians(25))
        assert [b.gear.base_radius for b in bodies if b.gear] == pytest.approx([radius] * len(bodies), rel=1e-15)
    system = assemble(loaded)
    ratio = {member: float(next(iter(turns.values()))) for member, turns in loaded.kinematics.ratio.items()}
    member = {body.name: body.member for body in loaded.bodies}
    turning = [name.rpartition("/") for name in system.dofs.names]
    motion = np.array([ratio[member[body] or ""] if axis == "rz" else 0.0 for body, _, axis in turning])
    rows = system.meshes.B
    assert np.max(np.abs(motion @ rows)) < 1e-14 * np.max(np.abs(motion) @ np.abs(rows))  # rounding
    stated = assemble(load(f"yue2014-{case}"))
    assert np.max(np.abs(motion @ stated.meshes.B)) > 1e-4 * np.max(np.abs(motion) @ np.abs(rows))


def test_radii_further_off_than_rounding_are_kept_and_named() -> None:
    """Radii of sun and ring of Lin and Parker fit no teeth: kept, and a load that they do not balance is refused."""
    train = load("lin1999-n4", {**LOADED, "operation.held": ["ring"]})
    named = [str(text) for text in train.warnings if code_of(text) == "base-radius-far"]
    assert [text.split(".base_radius")[0] for text in named] == [f"stages.main.{gear}" for gear in ("sun", "ring")]
    assert [b.gear.base_radius for b in train.bodies if b.gear and b.member == "main.sun"] == [0.03871]
    for verb in (epicyclic.steady, epicyclic.static, epicyclic.sharing, epicyclic.sweep, epicyclic.transient):
        with pytest.raises(ModelError, match=r"do(es)? not balance .* stages.main.sun.base_radius = 38.71 mm is far"):
            verb(train)
    with pytest.raises(ModelError, match=r"does not balance .* stages.main.sun.base_radius = 38.71 mm is far"):
        epicyclic.sharing(train, method="static")
