"""`epicyclic import`: the model file it writes, the lists it prints, and what it refuses."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.rexs.import_train import read_rexs

RUN = CliRunner()


@pytest.fixture
def file(draft: Any, tmp_path: Path) -> Path:
    path = tmp_path / "unit.rexs"
    path.write_text(draft.xml(), encoding="utf-8")
    return path


def test_the_model_file_is_the_document_with_comments(file: Path, tmp_path: Path) -> None:
    target = tmp_path / "unit.toml"
    result = RUN.invoke(app, ["import", str(file), "-o", str(target)])
    assert result.exit_code == 0, result.output
    text = target.read_text(encoding="utf-8")
    document = tomllib.loads(text)
    assert "# From the REXS file unit.rexs, of 2024-01-01" in text
    assert "[stages.main.sun]  # Sun [11]" in text
    assert "# Carrier bearing 33 [33]" in text
    assert document["assumed"] == read_rexs(file).document["assumed"]
    one, other = epicyclic.load(target), epicyclic.load(file)
    assert one.bodies == other.bodies
    assert list(map(repr, one.links)) == list(map(repr, other.links))
    assert dict(one.torques) == dict(other.torques)
    assert not any("REXS" in text for text in one.warnings)


def test_the_lists(file: Path) -> None:
    result = RUN.invoke(app, ["import", str(file)])
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert "  cylindrical_gear 11: number_of_teeth: stages.main.sun.teeth = 24" in lines
    assert any(line.startswith("Assumed, as the file does not say it (") for line in lines)
    # what planets lost alike stands in one line
    assert "  cylindrical_stage 106, 206, 306: common_face_width, rotating_angle_around_neg_u_axis: " in result.stdout


def test_json_has_every_entry(file: Path) -> None:
    result = RUN.invoke(app, ["import", str(file), "--json"])
    assert result.exit_code == 0, result.output
    said, found = json.loads(result.stdout), read_rexs(file)
    for kind in ("read", "assumed", "dropped"):
        entries = [(e["component"], e["attribute"], e["path"], e["text"]) for e in said[kind]]
        assert entries == [(e.component, e.attribute, e.path, e.text) for e in getattr(found, kind)]


def test_a_load_case(draft: Any, file: Path, tmp_path: Path) -> None:
    draft.load_cases = {2: {13: {"torque_around_u_axis": (123.0, "N m")}}}
    file.write_text(draft.xml(), encoding="utf-8")
    target = tmp_path / "unit.toml"
    result = RUN.invoke(app, ["import", str(file), "-o", str(target), "--load-case", "2"])
    assert result.exit_code == 0, result.output
    assert tomllib.loads(target.read_text(encoding="utf-8"))["operation"]["torque"] == {"sun": "123 N m"}
    assert RUN.invoke(app, ["import", str(file), "--load-case", "3"]).exit_code == 2


@pytest.mark.parametrize("content", ["", "format = 2", "<model", "{", "<!DOCTYPE model [<!ENTITY a 'b'>]><model/>"])
def test_what_is_refused_leaves_no_file(content: str, file: Path, tmp_path: Path) -> None:
    file.write_text(content, encoding="utf-8")
    target = tmp_path / "unit.toml"
    result = RUN.invoke(app, ["import", str(file), "-o", str(target)])
    assert result.exit_code == 2
    assert "error: " in result.stderr
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == [file]


def test_a_model_that_no_file_may_hold_is_refused_before_writing(draft: Any, file: Path, tmp_path: Path) -> None:
    draft.values(13)["torque_around_u_axis"] = (1e25, "N m")
    file.write_text(draft.xml(), encoding="utf-8")
    result = RUN.invoke(app, ["import", str(file), "-o", str(tmp_path / "unit.toml")])
    assert result.exit_code == 2
    assert "component 13" in result.stderr
    assert list(tmp_path.iterdir()) == [file]


def test_a_name_with_control_characters_does_not_reach_the_file(draft: Any, file: Path, tmp_path: Path) -> None:
    kind, _, values = draft.components[11]
    draft.components[11] = (kind, "Sun\u0085\u2028]\n[operation]", values)
    file.write_text(draft.xml(), encoding="utf-8")
    target = tmp_path / "unit.toml"
    assert RUN.invoke(app, ["import", str(file), "-o", str(target)]).exit_code == 0
    assert "[stages.main.sun]  # Sun ] [operation] [11]" in target.read_text(encoding="utf-8")
    epicyclic.load(target)
