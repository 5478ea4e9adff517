"""Meshes cut along the face: their sum is the whole mesh, rigid motion opens no slice, tilt loads one end."""

from __future__ import annotations

import copy
import json
import math
from typing import Any, Literal

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from tooth_oracles import contact_line_length

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.system.system import System, faces
from epicyclic.teeth.mesh_stiffness import evaluate_series
from epicyclic.train.resolution import load

Document = dict[str, Any]
PAIRS = ("sun-planet", "planet-ring")
WIDTH, MODULE, HELIX = 0.05, 0.004, math.radians(15)

BASE: Document = {
    "format": 2,
    "title": "a helical set",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": MODULE,
            "helix_angle": HELIX,
            "face_width": WIDTH,
            "sun": {"teeth": 22, "support": {"radial": 1e8, "z": 1e8}},
            "planet": {"teeth": 23, "bearing": {"radial": 2e8, "z": 3e8}},
            "ring": {"teeth": 68, "rim": 0.03, "support": {"radial": 1e9, "z": 1e9}},
            "carrier": {
                "mass": 20.0,
                "inertia": 0.2,
                "tilt_inertia": 0.1,
                "support": {"radial": 3e8, "z": 1e8},
            },
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": 100.0}, "torque": {"sun": 1000.0}},
    "deviations": {
        "sun": {"run_out": 10e-6},
        "planet": {"position": {"y": [8e-6, 0.0, 0.0]}},
        "meshes": {"sun-planet": {"profile": 3e-6}, "planet-ring": {"gap": [1e-6, 0.0, 2e-6]}},
    },
}


def document(slices: int, **changes: Any) -> Document:
    """BASE with every mesh in slices; `changes` by path of the stage, points as double underscores."""
    data = copy.deepcopy(BASE)
    main = data["stages"]["main"]
    main["meshes"] = {pair: {"slices": slices} for pair in PAIRS}
    for path, value in changes.items():
        *tables, last = path.split("__")
        here = main
        for name in tables:
            here = here.setdefault(name, {})
        here[last] = value
    return data


def tilting(data: Document, stiffness: float = 2e6) -> Document:
    """The same with tilt in every support and bearing: all six directions of every body are coordinates."""
    main = data["stages"]["main"]
    for member, key in (("sun", "support"), ("planet", "bearing"), ("ring", "support"), ("carrier", "support")):
        main[member][key]["tilt"] = stiffness
    main["ring"]["support"]["rz"] = 1e8
    return data


def assembled(data: Document) -> System:
    return epicyclic.assemble(load(data))


# the sum of the slices -----------------------------------------------------------------------------------------------

CASES: dict[str, Document] = {
    "plain": {},
    "left hand": {"sun__hand": "left"},
    "herringbone": {"herringbone": True, "gap": 0.01, "stagger": 0.5},
    "spur": {"helix_angle": 0.0},
}


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("torque", [1, -1])
@pytest.mark.parametrize("changes", CASES.values(), ids=CASES)
@pytest.mark.parametrize("count", [2, 5])
def test_slices_add_up_to_the_whole_mesh(changes: Document, count: int, torque: int, sign: int) -> None:
    def system(slices: int) -> System:
        data = document(slices, **changes)
        data["operation"]["speed"]["sun"] *= sign
        data["operation"]["torque"]["sun"] *= torque
        return assembled(data)

    whole, cut = system(1), system(count)
    face = faces(cut.meshes)
    assert face.name == whole.meshes.name
    assert (face.count == count).all()
    assert cut.meshes.name[:2] == (f"{whole.meshes.name[0]}/1", f"{whole.meshes.name[0]}/2")
    assert cut.meshes.slice == tuple(range(1, count + 1)) * len(whole.meshes.name)
    series = cut.meshes.stiffness[:, None] * cut.meshes.variation
    # rounding of sums of a dozen terms
    np.testing.assert_allclose(face.total(cut.meshes.stiffness), whole.meshes.stiffness, rtol=1e-14)
    np.testing.assert_allclose(
        face.total(series), whole.meshes.stiffness[:, None] * whole.meshes.variation, atol=1e-12 * 1e9
    )
    np.testing.assert_allclose(face.total(cut.meshes.B, axis=1) / count, whole.meshes.B, atol=1e-15)


def test_a_given_series_is_that_of_the_whole_mesh() -> None:
    cosine = {"variation": {"cosine": [0.1, 0.05], "sine": [0.02]}}
    whole, cut = (assembled(document(n, **{"meshes__sun-planet": {"slices": n, **cosine}})).meshes for n in (1, 4))
    face = faces(cut)
    given = np.array([pair.endswith("sun-planet") for pair in cut.pair])
    np.testing.assert_allclose(cut.variation[given], whole.variation[face.row][given], atol=1e-15)
    assert np.abs(whole.variation[0]).max() > 0.05


@pytest.mark.parametrize(("speed", "torque"), [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_each_slice_has_the_contact_lines_of_its_own_place(speed: int, torque: int) -> None:
    """Counting the tooth pairs in contact on a narrow gear at zeta, where a helix theta = h zeta tan(beta)/r has turned
    the tooth, gives the stiffness of the slice at every instant but near the steps that 12 orders do not hold."""
    count, data = 3, document(3)
    data["operation"]["speed"]["sun"] *= speed
    data["operation"]["torque"]["sun"] *= torque
    train = load(data)
    assert (train.meshes[0].flank, train.meshes[0].sense) == (torque, torque * speed)
    shares = []
    for mesh in (train.meshes[0], train.meshes[-1]):
        hand_a = mesh.hand
        teeth = next(b.gear.teeth for b in train.bodies if b.name == mesh.a and b.gear)
        radius = teeth * MODULE / math.cos(HELIX) / 2
        limits = _limits(mesh.contact_ratio, mesh.overlap_ratio, mesh.variation)
        phase = np.arange(400) / 400
        for number, piece in enumerate(mesh.slices):
            zeta = WIDTH * ((number + 0.5) / count - 0.5)
            assert piece.station == pytest.approx(mesh.station + zeta, abs=1e-15)
            turned = hand_a * zeta * math.tan(HELIX) / radius
            # gear A stands further by this angle: with d = +1 the contact has moved on, with d = -1 it lags
            sigma = mesh.sense * (phase + float(mesh.lead)) + mesh.flank * teeth * turned / math.tau
            lines = contact_line_length(sigma, limits, mesh.overlap_ratio / count)
            counted = lines / (limits[1] - limits[0])
            series = evaluate_series(piece.variation, mesh.sense * (phase + float(piece.lead)))
            shares.append(float(np.mean(np.abs(series - counted))))
    # what 12 orders leave of ramps as narrow as a slice: a percent or two of the mean; a wrong sign or place gives 0.2
    assert max(shares) < 0.02


def _limits(contact_ratio: float, overlap: float, variation: NDArray[np.complex128]) -> tuple[float, float]:
    """Limits of contact from the contact ratio and the phase of the first order of the whole mesh."""
    centre = -float(np.angle(variation[0] / np.sinc(contact_ratio) / np.sinc(overlap))) / math.tau
    return centre - contact_ratio / 2, centre + contact_ratio / 2


@pytest.mark.parametrize("verb", ["modes", "static", "sharing", "steady", "sweep"])
def test_without_tilt_slices_change_nothing(verb: str) -> None:
    """Where nothing tilts, the slices of a mesh move alike: forces, shares, frequencies are those of the whole mesh."""
    changes: Document = {"herringbone": True, "gap": 0.01}
    every: dict[str, Document] = {"sweep": {"relative_speed": [0.4, 1.0]}, "static": {"cycles": 3}}
    whole, cut = (_result(verb, document(n, **changes), every.get(verb, {})) for n in (1, 3))
    assert list(whole.variables) == [name for name in cut.variables if name not in SLICED]
    for name, expected in whole.variables.items():
        if expected.dtype.kind in "fc" and expected.dims:
            scale = float(np.nanmax(np.abs(expected.values), initial=0.0))
            # the solvers' tolerance on forces; what is zero in the whole is rounding in the sum
            np.testing.assert_allclose(
                cut[name].values, expected.values, rtol=1e-6, atol=1e-7 * scale, err_msg=str(name)
            )
        elif expected.dtype.kind != "f":
            assert (cut[name].values == expected.values).all(), name


SLICED = ("mesh_slice", "slice_force", "slice_contact_lost", "face_load_factor")


def _result(verb: str, data: Document, options: Document) -> xr.Dataset:
    data["damping"] = {"mesh": 0.05}
    data["stages"]["main"]["meshes"]["sun-planet"]["damping"] = 300.0
    result: xr.Dataset = getattr(epicyclic, verb)(data, **options)
    return result


def test_static_gives_the_load_along_the_face() -> None:
    result = epicyclic.static(tilting(document(4)), cycles=2)
    names = [str(name) for name in result.mesh_slice.values]
    assert names[:4] == [f"main/sun-planet/1/{j}" for j in (1, 2, 3, 4)]
    force = result.slice_force.values.reshape(6, 4, -1)
    np.testing.assert_allclose(force.sum(axis=1), result.mesh_force.values, rtol=1e-12)
    mean = force.mean(axis=2)
    np.testing.assert_allclose(result.face_load_factor.values, 4 * mean.max(axis=1) / mean.sum(axis=1), rtol=1e-12)
    assert result.face_load_factor.values.min() > 1.005


@pytest.mark.parametrize("method", ["static", "steady"])
def test_a_slice_that_opens_is_contact_lost_although_its_mesh_presses(method: Literal["static", "steady"]) -> None:
    data = document(4, planet__bearing={"radial": 2e8, "z": 3e8, "tilt": 1e3})
    result = epicyclic.sharing(data, method=method, cycles=20)
    assert result.mesh_force.values.min() > 0
    assert result.contact_lost.values.all()
    if method == "steady":
        steady = epicyclic.steady(data)
        assert steady.mesh_force_minimum.values.min() > 0
        assert any("main/sun-planet/1/1" in text for text in warnings_of(steady))
        sweep = epicyclic.sweep(data, relative_speed=[1.0])
        assert any("main/sun-planet/1/1" in text for text in warnings_of(sweep))
    else:
        static = epicyclic.static(data, cycles=2)
        assert static.mesh_force.values.min() > 0
        lost = static.slice_contact_lost.values.reshape(6, 4)
        assert lost.any(axis=1).all()
        assert not lost.all(axis=1).any()
        assert static.contact_lost.values.all()
        assert static.slice_force.values.min() == 0.0


def warnings_of(result: xr.Dataset) -> list[str]:
    return list(json.loads(result.attrs["warnings"]))


def test_slices_need_a_face_width() -> None:
    data = document(3)
    del data["stages"]["main"]["face_width"]
    for pair in PAIRS:
        data["stages"]["main"]["meshes"][pair] |= {"stiffness": 1e9}
    with pytest.raises(ModelError, match=r"stages\.main\.face_width.*slices of a mesh need it"):
        load(data)


# rigid motion --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("changes", CASES.values(), ids=CASES)
@pytest.mark.parametrize("torque", [1, -1])
def test_rigid_motion_opens_no_slice(changes: Document, torque: int) -> None:
    """Three translations and three rotations of the whole train leave every gap as it is."""
    data = tilting(document(4, **changes))
    data["operation"]["torque"]["sun"] *= torque
    train = load(data)
    system = epicyclic.assemble(train)
    assert system.dofs.expand.shape[0] == system.dofs.expand.shape[1]  # nothing is slaved
    motion = np.zeros((6, len(train.bodies), 6))
    for i, body in enumerate(train.bodies):
        c, s = math.cos(body.angle), math.sin(body.angle)
        own = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        centre = np.array([*body.centre, body.station])
        for axis, unit in enumerate(np.eye(3)):
            motion[axis, i, :3] = own @ unit
            motion[3 + axis, i, :3], motion[3 + axis, i, 3:] = own @ np.cross(unit, centre), own @ unit
    gap = motion.reshape(6, -1) @ system.dofs.expand @ system.meshes.B
    # rounding of unit motions at radii below 1 m
    assert np.abs(gap).max() < 1e-15
    assert np.abs(system.meshes.B).max() > 0.1


# tilt ----------------------------------------------------------------------------------------------------------------


def loads_along_the_face(data: Document, pair: str) -> NDArray[np.float64]:
    """Mean slice forces (mesh, slice) per mean of their mesh."""
    result = epicyclic.static(data, cycles=1)
    picked = [str(name).split("/")[1] == pair for name in result.mesh_slice.values]
    meshes = sum(str(name).split("/")[1] == pair for name in result.mesh.values)
    force = result.slice_force.values[picked].mean(axis=1).reshape(meshes, -1)
    return np.asarray(force / force.mean(axis=1, keepdims=True))


def even(data: Document) -> Document:
    """Without deviations, and with a stiffness that does not vary."""
    del data["deviations"]
    for pair in PAIRS:
        data["stages"]["main"]["meshes"][pair]["variation"] = "none"
    return data


@pytest.mark.parametrize(("hand", "torque"), [("right", 1), ("left", 1), ("right", -1), ("left", -1)])
def test_overturning_couple_of_a_helical_planet(hand: str, torque: int) -> None:
    """By hand, axes of the planet, h and d of the sun: the sun pushes the planet by -h d sin(beta_b) f along z at -r x,
    the ring by +h d sin(beta_b) f at +r x; the couple about y is -h d sin(beta_b) f (r + r'), the pin yields by an
    angle of its sign, and the place zeta moves by angle * zeta along x: for h d = +1 towards the sun on the right."""
    data = even(document(5, sun__hand=hand, planet__bearing={"radial": 2e8, "z": 3e8, "tilt": 1e6}))
    data["operation"]["torque"]["sun"] *= torque
    sign = torque * (1 if hand == "right" else -1)
    for pair, towards in zip(PAIRS, (sign, -sign), strict=True):
        loads = loads_along_the_face(data, pair)
        slope = np.diff(loads, axis=1)
        assert (towards * slope > 0.01).all(), pair
        # a straight tilt of equal springs: the load rises by equal steps (rounding of the equilibrium)
        np.testing.assert_allclose(slope, slope.mean(), rtol=1e-6)


def test_a_herringbone_planet_does_not_overturn() -> None:
    tilts: Document = {"radial": 2e8, "z": 3e8, "tilt": 1e6}
    for pair in PAIRS:
        loads = loads_along_the_face(even(document(5, herringbone=True, gap=0.01, planet__bearing=tilts)), pair)
        # rounding of the equilibrium
        np.testing.assert_allclose(loads, 1.0, atol=1e-9)
        single = loads_along_the_face(even(document(5, planet__bearing=tilts)), pair)
        assert np.abs(single - 1).max() > 0.02


def test_overturning_angle_is_couple_over_stiffness() -> None:
    """With soft slices against a stiff pin the feedback of the teeth is small: the slope of the gap along the face is
    cos(beta_b) sin(alpha) times couple over tilt stiffness."""
    k_tilt, k_mesh = 1e7, 1e7
    data = even(document(5, planet__bearing={"radial": 2e8, "z": 3e8, "tilt": k_tilt}))
    for pair in PAIRS:
        data["stages"]["main"]["meshes"][pair]["stiffness"] = k_mesh
    train = load(data)
    mesh = train.meshes[0]
    force = 1000.0 / 3 / (mesh.radius_a * math.cos(mesh.pressure_angle) * math.cos(mesh.base_helix))
    arms = mesh.radius_b + next(m.radius_a for m in train.meshes if m.pair.endswith("planet-ring"))
    angle = force * math.sin(mesh.base_helix) * arms / k_tilt
    closing = math.cos(mesh.base_helix) * math.sin(mesh.pressure_angle) * angle * WIDTH * 4 / 5
    result = epicyclic.static(data, cycles=1)
    first = result.slice_force.values[:5].mean(axis=1)
    # the teeth resist with k b^2/12 sin^2(alpha), about 1e2 N m/rad against 1e7
    assert (first[-1] - first[0]) / (k_mesh / 5) == pytest.approx(closing, rel=1e-3)
