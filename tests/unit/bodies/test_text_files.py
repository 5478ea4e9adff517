"""Matrices in text: NASTRAN punch in its three fields, Abaqus .mtx, CalculiX, and files of nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest
from scipy import sparse

from epicyclic.bodies.files import Source, read_body
from epicyclic.bodies.joined_body import Interface, reduced
from epicyclic.bodies.reduced_body import BodyFacts, Matrix, ReducedBody
from epicyclic.errors import ModelError

Checked = tuple[ReducedBody, BodyFacts]
Card = Callable[..., str]


def small(name: str, *fields: object) -> str:
    """A card in fields of 8."""
    texts = [
        f"{one:.2e}".replace("e", "").replace("+0", "+").replace("-0", "-") if isinstance(one, float) else str(one)
        for one in fields
    ]
    rows = [texts[i : i + 8] for i in range(0, len(texts), 8)]
    return "\n".join(f"{name if not i else '+':<8}" + "".join(f"{one:>8}" for one in row) for i, row in enumerate(rows))


def large(name: str, *fields: object) -> str:
    """A card in fields of 16, with D for the exponent; a negative number fills its field."""
    texts = [f"{one:.9e}".replace("e", "D") if isinstance(one, float) else str(one) for one in fields]
    rows = [texts[i : i + 4] for i in range(0, len(texts), 4)]
    return "\n".join(
        f"{name + '*' if not i else '*':<8}" + "".join(f"{one:>16}" for one in row) for i, row in enumerate(rows)
    )


def free(name: str, *fields: object) -> str:
    """A card with commas, all digits."""
    texts = [repr(one) if isinstance(one, float) else str(one) for one in fields]
    rows = [texts[i : i + 8] for i in range(0, len(texts), 8)]
    return "\n".join(",".join([name if not i else "+", *row]) for i, row in enumerate(rows))


def punched(body: ReducedBody, card: Card, *, form: int = 6, component: int = 0) -> str:
    """DMIG of the lower triangle, or of all, GRID and SPOINT cards of a body; modes are scalar points from 9001.

    component : of the scalar points, which some write as 1.
    """
    modal = body.modal
    node = np.where(modal, 9000 + body.dof_node, body.dof_node).tolist()
    direction = np.where(modal, component, body.dof_dir).tolist()
    lines = ["$ a comment", "BEGIN BULK"]
    for name, matrix in (("KAAX", body.K), ("MAAX", body.M), ("K4AX", body.M), ("PAX", body.K[:, :1])):
        dense = matrix.toarray() if sparse.issparse(matrix) else matrix
        lines.append(card("DMIG", name, 0, form if name != "PAX" else 9, 2, 0, "", "", len(node)))
        for column, values in enumerate(dense.T):
            terms = [row for row in np.flatnonzero(values) if form == 1 or row >= column or name == "PAX"]
            cells = [one for row in terms for one in (node[row], direction[row], float(values[row]), "")]
            lines += [card("DMIG", name, node[column], direction[column], "", *cells)] if cells else []
    lines += [
        card("GRID", one, "", *map(float, xyz), "")
        for one, xyz in zip(body.node_id, body.node_xyz.tolist(), strict=True)
    ]
    if modal.any():
        lines.append(card("SPOINT", 9001, "THRU", 9000 + int(modal.sum())))
    return "\n".join([*lines, "PARAM,AUTOSPC,NO", "ENDDATA", ""])


def off(found: Matrix, want: Matrix) -> float:
    return float(abs(found - want).max() / abs(want).max())


@pytest.mark.parametrize(("card", "digits"), [(large, 1e-9), (free, 0.0)])
@pytest.mark.parametrize("form", [6, 1])
def test_a_nastran_punch(tmp_path: Path, few: Checked, card: Card, digits: float, form: int) -> None:
    body, facts = few
    file, text = tmp_path / "ring.pch", punched(body, card, form=form)
    first = text.index("\n", text.index("\n", text.index("MAAX") + 200)) + 1  # in the middle of a card
    file.write_text(f"{text[:first]}$ a comment\n{text[first:]}")
    found, again = read_body(file, units="kg m s")
    assert off(found.K, body.K) <= digits
    assert off(found.M, body.M) <= digits
    assert off(found.node_xyz, body.node_xyz) <= digits
    assert found.node_id.tolist() == body.node_id.tolist()
    assert again.frequencies == pytest.approx(facts.frequencies, rel=1e-6)
    assert again.remarks == ()


@pytest.mark.parametrize("component", [0, 1])
def test_modes_of_a_punch_are_scalar_points(tmp_path: Path, few: Checked, component: int) -> None:
    thirds = [Interface(name=str(i), nodes=tuple(range(8 * i + 1, 8 * i + 5))) for i in range(4)]
    body, _ = reduced(few[0], thirds, 5, "few")
    file = tmp_path / "ring.bdf"
    file.write_text(punched(body, free, component=component))
    found, _ = read_body(file, units="kg m s")
    assert found.dof_dir.tolist() == body.dof_dir.tolist()
    assert found.modal.sum() == 5
    assert off(found.K, body.K) < 1e-12
    assert isinstance(found.K, np.ndarray)  # dense, as a reduced body is


def test_small_fields_have_too_few_digits_and_say_so(tmp_path: Path, few: Checked) -> None:
    file = tmp_path / "ring.pch"
    file.write_text(punched(few[0], small))
    with pytest.raises(ModelError, match=r"K: (a rigid motion meets|has .* negative)"):
        read_body(file, units="kg m s")


def test_a_large_card_of_one_line_has_zeros_behind(tmp_path: Path, few: Checked) -> None:
    file = tmp_path / "ring.pch"
    file.write_text(punched(few[0], free) + "GRID*                900\nGRID,901\nGRID*,902\n")
    assert read_body(file, units="kg m s")[1].remarks == ()


def triangle(matrix: Matrix) -> Iterable[tuple[int, int, float]]:
    upper = sparse.triu(matrix).tocoo()
    return zip(upper.row.tolist(), upper.col.tolist(), upper.data.tolist(), strict=True)


def abaqus(body: ReducedBody, folder: Path) -> dict[str, str | Path]:
    """Files of *MATRIX OUTPUT and the input file, which has more nodes than the matrices."""
    places = [f"{n}, {x!r}, {y!r}, {z!r}" for n, (x, y, z) in zip(body.node_id, body.node_xyz.tolist(), strict=True)]
    files = {name: folder / f"ring_{name}.mtx" for name in ("stiffness", "mass")}
    for name, matrix in (("stiffness", body.K), ("mass", body.M)):
        lines = [
            f"{body.dof_node[i]},{body.dof_dir[i]}, {body.dof_node[j]},{body.dof_dir[j]},  {value!r}"
            for i, j, value in triangle(matrix)
        ]
        files[name].write_text("** written by Abaqus\n" + "\n".join(lines))
    nodes = folder / "ring.inp"
    nodes.write_text("\n".join(["*HEADING", " a ring", "*Node, nset=ALL", *places, "900, 1., 2.", "*ELEMENT", "1, 2"]))
    return {**files, "nodes": nodes}


def test_abaqus_matrices(tmp_path: Path, few: Checked) -> None:
    body, facts = few
    files = abaqus(body, tmp_path)
    found, again = read_body(files, units="kg m s")
    assert off(found.K, body.K) == 0
    assert off(found.M, body.M) == 0
    assert again.mass == facts.mass
    with pytest.raises(ModelError, match=r"ring_stiffness.mtx: mass: .* 1000 times, a wrong unit .tonnes"):
        read_body(files, units="t mm s", mass=facts.mass)
    damped, _ = read_body({**files, "damping": files["mass"]}, units="kg m s")
    assert off(damped.C, body.M) == 0
    plain = tmp_path / "nodes.txt"
    plain.write_text("\n".join(f"{n} {x!r} {y!r} {z!r}" for n, (x, y, z) in enumerate(body.node_xyz.tolist(), 1)))
    assert np.array_equal(read_body({**files, "nodes": plain}, units="kg m s")[0].node_xyz, body.node_xyz)
    grid = tmp_path / "nodes.bdf"
    grid.write_text(punched(body, free))
    assert np.array_equal(read_body({**files, "nodes": grid}, units="kg m s")[0].node_xyz, body.node_xyz)
    mixed = {"stiffness": grid, "mass": grid, "nodes": files["nodes"]}
    assert off(read_body(mixed, units="kg m s")[0].K, body.K) == 0
    for name, key in (("KAAX", "stiffness"), ("MAAX", "mass")):
        own = [line for line in punched(body, large).replace(name, "SUPE").splitlines()]
        start = next(i for i, line in enumerate(own) if "SUPE" in line)
        end = next(i for i in range(start, len(own)) if own[i][:4] == "DMIG" and "SUPE" not in own[i])
        (tmp_path / f"{key}.dmig").write_text("\n".join(own[start:end]))
    alone: Source = {**{key: tmp_path / f"{key}.dmig" for key in ("stiffness", "mass")}, "nodes": grid}
    assert off(read_body(alone, units="kg m s")[0].M, body.M) < 1e-9  # the only matrix of a file, whatever its name


def calculix(body: ReducedBody, folder: Path) -> Path:
    """Files of SOLVER=MATRIXSTORAGE beside the input file."""
    abaqus(body, folder)
    for suffix, matrix in ((".sti", body.K), (".mas", body.M)):
        lines = [f"{i + 1} {j + 1} {value!r}" for i, j, value in triangle(matrix)]
        (folder / f"ring{suffix}").write_text("\n".join(lines) + "\n")
    dofs = [f"{n}.{d}" for n, d in zip(body.dof_node, body.dof_dir, strict=True)]
    (folder / "ring.dof").write_text("\n".join(dofs) + "\n")
    return folder / "ring.sti"


def test_calculix_matrices(tmp_path: Path, few: Checked) -> None:
    body, _ = few
    found, _ = read_body(calculix(body, tmp_path), units="kg m s")
    assert off(found.K, body.K) == 0
    assert found.dof_node.tolist() == body.dof_node.tolist()  # node 10 is not node 1


def rewritten(old: str, new: str, name: str = "ring.inp") -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))

    return change


def added(name: str, text: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        with (folder / name).open("a") as file:
            file.write(f"\n{text}\n")

    return change


def unlinked(name: str) -> Callable[[Path], None]:
    return lambda folder: (folder / name).unlink()


WRONG: list[tuple[str, Callable[[Path], None], str]] = [
    ("ring.sti", unlinked("ring.mas"), r"body = .*: cannot be read: No such file"),
    ("ring.sti", rewritten("\n32, ", "\n320, "), r"ring.sti: K = 32: a node without place"),
    ("ring.sti", rewritten("\n32, ", "\n31, "), r"ring.inp: line 35 = 31: a node twice"),
    ("ring.sti", rewritten("*Node, nset=ALL", "*Node, System=C"), r"ring.inp: line 3 = .*: axes of its own"),
    ("ring.sti", added("ring.inp", "*TRANSFORM, NSET=ALL"), r"ring.inp: line .*: axes of its own"),
    ("ring.sti", rewritten("*HEADING", "*INSTANCE"), r"ring.inp: line 2 =  a ring: a moved instance"),
    ("ring.sti", rewritten("\n32, ", "\nx32, "), r"line 35 = x32: no number of a node"),
    ("ring.sti", rewritten("1.1", "1", "ring.dof"), r"ring.dof: rows = 1: no place of a row; allowed: node.direction"),
    ("ring.sti", added("ring.sti", "97 97 1.0"), r"ring.sti: rows: no row or column; allowed: 1 to 96"),
    ("ring.sti", added("ring.sti", "1.5 97 1.0"), r"ring.sti: rows: no row or column"),
    ("ring.sti", added("ring.sti", "1 1 1.0"), r"ring.sti: K: a term twice"),
    ("ring.sti", added("ring.mas", "1 2"), r"ring.mas: lines: not such a table"),
    ("ring.sti", added("ring.mas", "1 2 x"), r"ring.mas: lines: not such a table"),
    ("table", added("ring_mass.mtx", "1,9, 1,1, 2.0"), r"M: no node and direction; allowed: .*1 to 6"),
    ("table", added("ring_mass.mtx", "2,1, 1,1, 2.0"), r"M: not symmetric"),
    ("ring.pch", rewritten("DMIG,KAAX,0,6", "DMIG,KAAX,0,9", "ring.pch"), r"ring.pch: K: no such matrix"),
    ("ring.pch", rewritten("DMIG,KAAX,0,6,2", "DMIG,KAAX,0,6,4", "ring.pch"), r"line 3, DMIG = type 4: a complex"),
    ("ring.pch", rewritten("DMIG,KAAX,0,6", "DMIG,KBBX,0,6", "ring.pch"), r"line 4, DMIG = KAAX: a column before"),
    ("ring.pch", rewritten("DMIG,MAAX,0,6", "DMIG,K2,0,6,2\nDMIG,MAAX,0,6", "ring.pch"), r"K = KAAX, K2: several"),
    ("ring.pch", rewritten("GRID,1,,", "GRID,1,7,", "ring.pch"), r"GRID = 7: another coordinate system"),
    ("ring.pch", rewritten("GRID,1,,0.", "GRID,1,,O.", "ring.pch"), r"GRID = O.*: no number"),
]


@pytest.mark.parametrize(("name", "change", "words"), WRONG)
def test_what_is_refused(tmp_path: Path, few: Checked, name: str, change: Callable[[Path], None], words: str) -> None:
    calculix(few[0], tmp_path)
    (tmp_path / "ring.pch").write_text(punched(few[0], free))
    change(tmp_path)
    files = {"stiffness": "ring_stiffness.mtx", "mass": "ring_mass.mtx", "nodes": "ring.inp"}
    source: Source = {key: tmp_path / one for key, one in files.items()} if name == "table" else tmp_path / name
    with pytest.raises(ModelError, match=words):
        read_body(source, units="kg m s")


def test_what_a_table_needs(tmp_path: Path, few: Checked) -> None:
    files = abaqus(few[0], tmp_path)
    with pytest.raises(ModelError, match=r'elastic.units: missing, and never guessed; allowed: "kg m s", "t mm s"'):
        read_body(files, path="elastic")
    with pytest.raises(ModelError, match=r"units = kg mm ms: not known"):
        read_body(files, units="kg mm ms", path="elastic")
    with pytest.raises(ModelError, match=r"elastic.mass: missing"):
        read_body({key: one for key, one in files.items() if key != "mass"}, units="kg m s", path="elastic")
    with pytest.raises(ModelError, match=r"elastic.loads: unknown key; allowed: stiffness, mass, damping, nodes"):
        read_body({**files, "loads": "x"}, units="kg m s", path="elastic")
