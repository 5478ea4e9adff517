"""Native files of a body: what they hold, their units, and what is refused or said."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reduced_ring
from scipy import sparse
from scipy.io import savemat

from epicyclic.bodies.files import native_body, native_bytes, read_body
from epicyclic.bodies.joined_body import Interface, axisymmetric, reduced, turning_with_frame
from epicyclic.bodies.reduced_body import Array, BodyFacts, ReducedBody, checked
from epicyclic.errors import ModelError

Checked = tuple[ReducedBody, BodyFacts]
Content = dict[str, Any]
NAMES = [name for name in ReducedBody.__slots__ if name not in ("units", "source")]


def content_of(raw: bytes) -> Content:
    with np.load(io.BytesIO(raw), allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def written(folder: Path, content: Mapping[str, Any], suffix: str = ".npz") -> Path:
    file = folder / f"body{suffix}"
    if suffix == ".mat":
        savemat(file, dict(content))
    else:
        np.savez(file, **content)
    return file


def bits(value: Any) -> Any:
    if sparse.issparse(value):
        return [bits(part) for part in (value.data, value.indices, value.indptr)]
    return value.tobytes() if isinstance(value, np.ndarray) else value


@pytest.fixture(scope="module")
def spiders(bricks: Checked) -> Checked:
    """The ring of bricks at three points with rotations, and eight modes."""
    body, _ = bricks
    points = [Interface(name=f"{i}", nodes=tuple(range(40 * i + 1, 40 * i + 9))) for i in range(3)]
    return checked(reduced(turning_with_frame(body, "bricks"), points, 8, "bricks")[0], "bricks")


@pytest.fixture(scope="module")
def plain(spiders: Checked) -> Content:
    """Arrays of the native file of `spiders`."""
    return content_of(native_bytes(spiders[0]))


def test_the_native_file_keeps_every_bit(bricks: Checked, spiders: Checked, kept: Checked) -> None:
    whole = bricks[0]
    pattern = axisymmetric(whole, 32, 12, (1, 2, 3, 4), "bricks")
    for body in (kept[0], spiders[0], whole, replace(pattern, mass=2.0, centre=np.zeros(3), inertia=np.eye(3))):
        again = native_body(native_bytes(body), "body")
        for name in NAMES:
            assert bits(getattr(again, name)) == bits(getattr(body, name)), name
    assert spiders[0].G1 is not None
    assert spiders[0].KG1 is not None
    assert content_of(native_bytes(whole)).keys() >= {"K_data", "K_indices", "K_indptr"}
    assert native_body(native_bytes(kept[0]), "body").source == kept[0].source


def test_matlab_has_the_same_names(tmp_path: Path, plain: Content, bricks: Checked) -> None:
    body, facts = read_body(written(tmp_path, plain, ".mat"))
    for name in ("M", "K", "G1", "node_xyz", "node_id", "dof_node", "dof_dir"):
        assert np.array_equal(getattr(body, name), getattr(native_body(native_bytes(body), "x"), name))
        assert np.array_equal(getattr(body, name), plain[name])
    whole = content_of(native_bytes(bricks[0]))
    assert bits(read_body(written(tmp_path, whole, ".mat"))[0].K) == bits(bricks[0].K)
    whole = {name: value for name, value in whole.items() if name[:2] not in ("M_", "K_")}
    again, more = read_body(written(tmp_path, whole | {"M": bricks[0].M, "K": bricks[0].K}, ".mat"))
    assert sparse.issparse(again.K)
    assert abs(again.K - bricks[0].K).max() == 0
    with pytest.raises(ModelError, match="K: no real numbers"):
        read_body(written(tmp_path, whole | {"M": bricks[0].M, "K": bricks[0].K * 1j}, ".mat"))
    assert more.mass == pytest.approx(facts.mass, rel=1e-9)


def test_a_damaged_matlab_file_is_refused(tmp_path: Path, plain: Content) -> None:
    whole = written(tmp_path, plain, ".mat").read_bytes()
    file = tmp_path / "damaged.mat"
    for damaged in (whole[: len(whole) // 2], whole[:100], whole[:124] + b"\0\2IM" + whole[128:]):
        file.write_bytes(damaged)
        with pytest.raises(ModelError, match=r"damaged.mat: cannot be read"):
            read_body(file)


def test_a_compressed_matlab_file(tmp_path: Path, plain: Content) -> None:
    savemat(tmp_path / "small.mat", plain, do_compression=True)
    assert np.array_equal(read_body(tmp_path / "small.mat")[0].K, plain["K"])


def in_tonnes(plain: Content) -> Content:
    """The same body in t, mm, s, its modes of mass 1 t mm^2."""
    size = np.select([plain["dof_dir"] == 0, plain["dof_dir"] < 4], [1e-3**0.5, 1e-3], 1.0)  # in SI, of 1 in the file
    found = {name: plain[name] * np.outer(size, size) / 1e-3 for name in ("M", "K", "G1", "KG1")}
    return plain | found | {"node_xyz": 1e3 * plain["node_xyz"], "units": "t mm s"}


def test_units_of_a_file(tmp_path: Path, plain: Content, spiders: Checked) -> None:
    tonnes = in_tonnes(plain)
    translation = np.flatnonzero(plain["dof_dir"] == 1)[0]
    assert tonnes["M"][translation, translation] == pytest.approx(plain["M"][translation, translation] / 1e3)  # t
    assert tonnes["K"][translation, translation] == pytest.approx(plain["K"][translation, translation] / 1e3)  # N/mm
    rotation = np.flatnonzero(plain["dof_dir"] == 4)[0]
    assert tonnes["K"][rotation, rotation] == pytest.approx(1e3 * plain["K"][rotation, rotation])  # N mm
    body, facts = read_body(written(tmp_path, tonnes))
    assert body.units == "t mm s"
    for name in ("M", "K", "G1", "KG1", "node_xyz"):
        want = getattr(spiders[0], name)
        assert np.abs(getattr(body, name) - want).max() < 1e-12 * np.abs(want).max(), name
    assert facts.mass == pytest.approx(spiders[1].mass, rel=1e-9)
    assert facts.inertia == pytest.approx(spiders[1].inertia, rel=1e-6, abs=1e-12)


def test_expected_mass_in_the_units_of_the_file(tmp_path: Path, plain: Content, spiders: Checked) -> None:
    mass, inertia = spiders[1].mass, spiders[1].inertia
    tonnes = in_tonnes(plain) | {"mass": mass / 1e3, "centre": [0.0, 0.0, 0.0], "inertia": 1e3 * inertia}
    assert read_body(written(tmp_path, tonnes))[1].remarks == ()
    said = read_body(written(tmp_path, plain | {"mass": mass * (1 + 5e-5)}))[1].remarks
    assert len(said) == 1
    assert "mass: the matrices have" in said[0]
    assert "off by 5e-05" in said[0]


@pytest.mark.parametrize(
    ("expected", "words"),
    [
        ({"mass": 1e3}, "mass: .*0.001 times, a wrong unit .tonnes against kilograms"),
        ({"mass": 1e-9}, r"mass: .*1e\+09 times, a wrong unit .volumes in mm"),
        ({"mass": 1e-12}, r"1e\+12 times, a wrong unit .*tonnes"),
        ({"mass": 1.01}, "mass: .*off by 0.0099"),
        ({"inertia": 1e-6}, r"inertia: .*1e\+06 times, a wrong unit .areas"),
        ({"centre": [0.0, 0.01, 0.0]}, "centre: .*off by"),
    ],
)
def test_wrong_masses_are_refused(
    tmp_path: Path, plain: Content, spiders: Checked, expected: Content, words: str
) -> None:
    own = {"mass": spiders[1].mass, "inertia": spiders[1].inertia}
    given = {name: factor * own[name] if name in own else factor for name, factor in expected.items()}
    with pytest.raises(ModelError, match=words) as refused:
        read_body(written(tmp_path, plain | given))
    assert "wrong unit" in str(refused.value) or "wrong unit" not in words
    assert str(refused.value).startswith(str(tmp_path / "body.npz"))


def changed(name: str, change: Callable[[Any], Any]) -> Callable[[Content], Content]:
    return lambda content: content | {name: change(np.array(content[name]))}


def entry(row: int, column: int, value: float) -> Callable[[Array], Array]:
    def put(matrix: Array) -> Array:
        matrix[row, column] += value * np.abs(matrix).max()
        return matrix

    return put


MODAL = np.arange(26) > 17


def coupled(matrix: Array) -> Array:
    return matrix + 1e6 * (np.eye(26, k=3) + np.eye(26, k=-3)) * np.outer(MODAL, MODAL)


def grounded(matrix: Array) -> Array:
    matrix[1, 1] += 1e6
    return matrix


def without(*names: str) -> Callable[[Content], Content]:
    return lambda content: {name: value for name, value in content.items() if name not in names}


def mechanism(content: Content) -> Content:
    """One more mass that nothing holds."""
    more = {name: np.pad(content[name], ((0, 1), (0, 1))) for name in ("M", "K", "G1", "KG1")}
    more["M"][-1, -1], more["K"][-1, -1] = 1.0, 1e-3
    return (
        content | more | {"dof_node": np.append(content["dof_node"], 99), "dof_dir": np.append(content["dof_dir"], 0)}
    )


def places_in_mm(content: Content) -> Content:
    return content | {"node_xyz": 1e3 * content["node_xyz"]}


WRONG: list[tuple[str, Callable[[Content], Content], str]] = [
    ("no units", without("units"), 'units.*never guessed; allowed: "kg m s", "t mm s"'),
    ("other units", lambda c: c | {"units": "lb in s"}, "units = lb in s: not known"),
    ("no format", without("format"), "format: not the format"),
    ("format 2", lambda c: c | {"format": 2}, "format: not the format of a body; allowed: 1"),
    ("unknown name", lambda c: c | {"stiffness": np.eye(3)}, "stiffness: unknown name; allowed: C, C_data"),
    ("no K", without("K"), "K: missing"),
    ("no nodes", without("node_xyz"), "node_xyz: missing"),
    ("complex", lambda c: c | {"K": c["K"] + 1j}, "K: no real numbers"),
    ("pickled", lambda c: c | {"K": np.array([{"a": 1}], object)}, "cannot be read: Object arrays"),
    ("shape of M", lambda c: c | {"M": c["M"][:-1]}, r"M = \(25, 26\): of another shape; allowed: \(26, 26\)"),
    ("half a node", changed("dof_node", lambda one: one + 0.5), "dof_node: no whole numbers"),
    ("nan", changed("K", entry(2, 2, np.nan)), "K: not finite"),
    ("infinite place", changed("node_xyz", lambda one: np.where(one == one.max(), np.inf, one)), "node_xyz: not"),
    ("a node twice", changed("node_id", lambda one: one * 0 + 1), "node_id: a node twice"),
    ("unknown node", changed("node_id", lambda one: one + 1), "dof_node = 1: an unknown node"),
    ("a coordinate twice", changed("dof_dir", lambda one: np.where(one == 2, 1, one)), r"dof_node = \(1, 1\): a co"),
    ("direction 7", changed("dof_dir", lambda one: np.where(one == 2, 7, one)), "dof_dir = 7: no direction"),
    ("unsymmetric K", changed("K", entry(0, 1, 1e-6)), "K: not symmetric: off by .*; allowed: 1e-09"),
    ("unsymmetric M", changed("M", entry(0, 1, 1e-6)), "M: not symmetric"),
    ("symmetric G1", changed("G1", entry(0, 0, 1e-6)), "G1: not antisymmetric"),
    ("negative K", changed("K", lambda one: -one), "K: has .* negative eigenvalues"),
    ("negative M", changed("M", entry(0, 0, -1.0)), "M: has 1 negative eigenvalues"),
    ("a mode of mass 2", changed("M", lambda one: one + np.diag(np.arange(26) == 20)), "M = mode 3: modes are not of"),
    ("coupled modes", changed("K", coupled), "K = mode .: modes are coupled"),
    ("grounded", changed("K", grounded), "K: a rigid motion meets stiffness.*5 motions meet none: .* grounded"),
    ("mechanism", mechanism, "K: 7 motions without stiffness: a mechanism; allowed: the six of a rigid body"),
    ("places in mm", places_in_mm, "node_xyz: a rigid motion meets.* none with places 0.001 times as large"),
    ("mirrored places", changed("node_xyz", lambda one: one * [-1, 1, 1]), "node_xyz: .*places or directions"),
    ("no mass", changed("M", lambda one: one * np.outer(MODAL, MODAL)), "M = 0 kg: a rigid motion"),
]


@pytest.mark.parametrize(("change", "words"), [one[1:] for one in WRONG], ids=[one[0] for one in WRONG])
def test_what_is_refused(tmp_path: Path, plain: Content, change: Callable[[Content], Content], words: str) -> None:
    with pytest.raises(ModelError) as refused:
        read_body(written(tmp_path, change(plain)), path="stages.main.ring.elastic.file")
    assert re.search(words, str(refused.value)), str(refused.value)
    assert str(refused.value).startswith(str(tmp_path / "body.npz"))


def test_sparse_matrices_are_refused_too(tmp_path: Path, bricks: Checked) -> None:
    plain = content_of(native_bytes(bricks[0]))
    held = bricks[0].K.tolil()
    held[5, 5] *= 1.5
    held = sparse.csr_array(held)
    negative = (bricks[0].K - 0.1 * sparse.diags_array(bricks[0].K.diagonal())).tocsr()
    for change, words in (
        ({"K_data": plain["K_data"][:-1]}, "K: no sparse matrix"),
        ({"K_indices": plain["K_indices"] + 384}, "K: no sparse matrix"),
        ({"K_indptr": np.where(np.arange(385) % 384, 10**6, 0)}, "K: no sparse matrix: index pointers go back"),
        ({"K_indices": np.zeros_like(plain["K_indices"])}, "K: has an entry twice"),
        ({"K_data": held.data, "K_indices": held.indices, "K_indptr": held.indptr}, "K: a rigid motion meets"),
        ({"K_data": negative.data, "K_indices": negative.indices, "K_indptr": negative.indptr}, "K: has .* negative"),
    ):
        with pytest.raises(ModelError, match=words):
            read_body(written(tmp_path, plain | change))
    del plain["K_indptr"]
    with pytest.raises(ModelError, match="K: no sparse matrix"):
        read_body(written(tmp_path, plain))


def test_damaged_files_are_refused(tmp_path: Path, kept: Checked) -> None:
    raw = native_bytes(kept[0])
    file = tmp_path / "ring.npz"
    for damaged in (b"", b"PK", raw[: len(raw) // 2], raw[:100] + b"\0" * 400 + raw[500:], b"MATLAB 5.0" + b"\0" * 200):
        file.write_bytes(damaged)
        with pytest.raises(ModelError, match=r"ring.npz"):
            read_body(file)
    for name, words in (("none.npz", "cannot be read: No such file"), ("ring.op2", "no file of a body")):
        with pytest.raises(ModelError, match=f"elastic.file = .*: {words}"):
            read_body(tmp_path / name, path="elastic.file")
    with pytest.raises(ModelError, match=r"elastic.file.units = t mm s: not the units of the file; allowed: kg m s"):
        read_body(reduced_ring.KEPT, units="t mm s", path="elastic.file")
