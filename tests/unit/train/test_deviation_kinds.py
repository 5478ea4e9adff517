"""Kinds of deviation: one field of the schema and one function each, and everything else follows."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, get_args

import pytest

from epicyclic.document.deviations import MemberDeviationsTable, MeshDeviationsTable, bare_keys
from epicyclic.document.document import read
from epicyclic.document.schema_fields import Unit, metadata_of
from epicyclic.document.units import KINDS
from epicyclic.document.writer import json_schema
from epicyclic.errors import ModelError
from epicyclic.train.deviations import MEMBER_KINDS, MESH_KINDS
from epicyclic.train.resolution import load

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "model-file.md"
VALUES: dict[str, Any] = {
    "pitch": [1e-6, *[0.0] * 17],
    "tilt": "1e-4 rad",
    "unbalance": "3 g mm",
    "errors": {"mine": {"turns_with": "sun", "amplitude": "3 um"}},
}  # else a length


def value_of(kind: str) -> Any:
    return VALUES.get(kind, "3 um")


def member_path(kind: str) -> str:
    return f"deviations.{'sun' if kind == 'pitch' else 'planet'}.{kind}"


def test_every_kind_of_the_schema_is_resolved() -> None:
    assert set(MEMBER_KINDS) == set(MemberDeviationsTable.model_fields)
    assert set(MESH_KINDS) == set(MeshDeviationsTable.model_fields)


@pytest.mark.parametrize("kind", MemberDeviationsTable.model_fields)
def test_a_kind_of_member_acts_under_its_own_path(kind: str) -> None:
    path = f"deviations.main.planet.{kind}"
    teeth = load("ren2021").bodies[-1].gear
    assert teeth is not None
    value = [1e-6, *[0.0] * (teeth.teeth - 1)] if kind == "pitch" else value_of(kind)
    train = load("ren2021", {"deviations": None, f"deviations.planet.{kind}": value})
    found: list[Any] = [*train.displacements, *train.mesh_errors, *train.loads]
    assert found
    assert {item.path for item in found} == {path}
    assert {item.cause for item in found if hasattr(item, "cause")} <= {kind}


@pytest.mark.parametrize("kind", MeshDeviationsTable.model_fields)
def test_a_kind_of_mesh_acts_under_its_own_path(kind: str) -> None:
    path = f"deviations.main.meshes.sun-planet.{kind}"
    train = load("ren2021", {"deviations": None, f"deviations.meshes.sun-planet.{kind}": value_of(kind)})
    assert {error.path for error in train.mesh_errors} == {f"{path}.mine" if kind == "errors" else path}
    assert {error.cause for error in train.mesh_errors} == {kind}


@pytest.mark.parametrize("table", [MemberDeviationsTable, MeshDeviationsTable])
def test_a_bare_value_is_the_long_form(table: Any) -> None:
    where = "planet" if table is MemberDeviationsTable else "meshes.sun-planet"
    for kind, key in bare_keys(table).items():
        bare = read("ren2021", {"deviations": None, f"deviations.{where}.{kind}": value_of(kind)})
        long = read("ren2021", {"deviations": None, f"deviations.{where}.{kind}": {key: value_of(kind)}})
        assert bare.model == long.model
        assert bare.data == long.data


def test_the_schema_takes_every_kind() -> None:
    tables = json_schema()["$defs"]
    assert set(tables["MemberDeviations"]["properties"]) == {*MemberDeviationsTable.model_fields, "left", "right"}
    assert set(tables["MeshDeviations"]["properties"]) == {*MeshDeviationsTable.model_fields, "left", "right"}


def test_an_unknown_kind_names_the_known_ones() -> None:
    with pytest.raises(ModelError) as error:
        load("ren2021", {"deviations.sun.zzz": "3 um"})
    assert all(kind in str(error.value) for kind in MemberDeviationsTable.model_fields)
    with pytest.raises(ModelError) as error:
        load("ren2021", {"deviations.meshes.sun-planet.zzz": "3 um"})
    assert all(kind in str(error.value) for kind in MeshDeviationsTable.model_fields)


def rows_of(table: Any, head: str) -> list[str]:
    """Rows of the page: path in the file, SI unit, description."""
    found = []
    for name, field in table.model_fields.items():
        form = next((a for a in get_args(field.annotation) if hasattr(a, "bare")), None)
        number = field if form is None else form.model_fields[form.bare]
        units = [KINDS[m.kinds.split()[0]].unit for m in metadata_of(number) if isinstance(m, Unit)]
        own = ".NAME" if name == "errors" else ""
        unit = units[0] if units else re.search(r"\[(.*?)\]", field.description)[1]  # type: ignore[index]
        found.append(f"| `{head}.{name}{own}` | {unit} | {field.description} |")
    return found


def test_the_page_lists_every_kind() -> None:
    """Put what the message shows into the table of docs/reference/model-file.md."""
    rows = [
        *rows_of(MemberDeviationsTable, "deviations.M"),
        *rows_of(MeshDeviationsTable, "deviations.meshes.A-B"),
    ]
    found = re.findall(r"^\| `deviations\..*$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert found == rows, "\n" + "\n".join(rows)
