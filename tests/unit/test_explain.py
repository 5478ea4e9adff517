"""`explain`: paths, variables, warnings, verbs and figures, and the nearest of what is not known."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.document.deviations import FORMS
from epicyclic.document.document import read, ready_drives
from epicyclic.questions.modes.eigen import _KINDS
from epicyclic.questions.sharing.definitions import DEFINITIONS
from epicyclic.results.variables import VARIABLES
from epicyclic.show.brief_check import phasing
from epicyclic.show.plot import figure_names
from epicyclic.terms import Explanation, explained_paths, known_words
from epicyclic.verbs.record import verbs
from epicyclic.warning_codes import WARNING_CODES

ROOT = Path(__file__).parents[2]


def path_of(text: str) -> Explanation:
    (found,) = (one for one in epicyclic.explain(text) if one.kind == "path")
    return found


def test_a_path_is_told_in_full() -> None:
    found = path_of("stages.main.sun.support.radial")
    assert found.name == "stages.main.sun.support.radial"
    assert found.meaning == "stiffness along x and y alike; 0 floats, inf is rigid"
    assert found.unit == "N/m"
    assert found.allowed.startswith("0, inf, a number in N/m, N/um, kN/mm")
    assert found.example == 'stages.main.sun.support.radial = "1e9 N/m"  (ready drive ren2021)'
    assert found.page == "model-file.md"
    assert (path_of("stages.main.sun.helix_angle").default, path_of("sun.helix_angle").unit) == ("0", "rad")
    assert path_of("damping.modal").allowed.endswith("0 or more and below 1")


@pytest.mark.parametrize(("key", "member"), [("pin_radius", "planet"), ("ahead", "planet"), ("outer_diameter", "ring")])
def test_a_key_of_some_members_is_explained_at_one_of_them(key: str, member: str) -> None:
    assert epicyclic.explain(key)[0].name == f"stages.*.{member}.{key}"
    with pytest.raises(epicyclic.ModelError, match=rf"sun.{key}: not known; did you mean .*\b{key}\b"):
        epicyclic.explain(f"sun.{key}")


def test_a_side_has_the_keys_of_its_member() -> None:
    assert epicyclic.explain("planet.left.bearing")[0].name == "stages.*.planet.left.bearing"
    with pytest.raises(epicyclic.ModelError, match=r"sun.left.bearing: not known; did you mean .*planet.left.bearing"):
        epicyclic.explain("sun.left.bearing")


def test_examples_of_lengths_are_of_their_size() -> None:
    small, large = (
        path_of(f"stages.main.{key}").example for key in ("meshes.sun-planet.backlash", "planet.pin_radius")
    )
    assert small.endswith(' = "20 um"')
    assert large.endswith(' = "50 mm"')


@pytest.mark.parametrize("text", ["sun.support.radial", "*.sun.support.radial", "stages.*.sun.support.radial"])
def test_the_stage_may_be_left_out(text: str) -> None:
    own, whole = path_of(text), path_of("stages.main.sun.support.radial")
    assert own.name == "stages.*.sun.support.radial"
    assert {**own.as_dict(), "name": ""} == {**whole.as_dict(), "name": ""}


def test_names_of_ones_own_are_no_slips() -> None:
    assert path_of("planet_b.teeth").name == "stages.*.planet_b.teeth"
    assert path_of("stages.main.meshes.sun-planet.backlash").unit == "m"
    assert path_of("sun-planet.backlash").meaning == path_of("stages.main.meshes.sun-planet.backlash").meaning
    assert path_of("couplings.shaft.diameter").name == "couplings.shaft.diameter"


@pytest.mark.parametrize("drive", ready_drives())
def test_every_key_of_the_ready_drives_is_explained(drive: str) -> None:
    """Every path of the file, as it stands there, has an explanation with a meaning, and its example is of that key."""

    def paths(table: dict[str, object], above: str = "") -> list[str]:
        found = []
        for name, value in table.items():
            own = f"{above}.{name}" if above else name
            found += paths(value, own) if isinstance(value, dict) else [own]
        return found

    for path in paths(dict(read(drive).data)):
        if path.split(".")[0] in ("assumed", "tolerance"):
            continue
        found = explained_paths(path)
        assert found, path
        assert found[0].name == path
        assert len(found[0].meaning) > 3, path
        if found[0].example and not path.startswith("operation."):  # the last word is a member there
            assert found[0].example.split(" = ")[0].rpartition(".")[2] in (path.rpartition(".")[2], "from"), path


def test_examples_are_what_a_model_file_takes() -> None:
    """Each made-up example of a key of a stage's sun is taken as an override of a ready drive."""
    keys = ("support.tilt", "tip_diameter", "tilt_inertia", "face_width", "flank.crown", "support.clearance", "station")
    for key in keys:
        line = path_of(f"stages.main.sun.{key}").example
        found = re.fullmatch(r'(\S+) = "?(.*?)"?(?:  \(ready drive .*\))?', line)
        assert found is not None, line
        read("ren2021", {found[1]: found[2]})


def test_every_warning_is_explained() -> None:
    for code, entry in WARNING_CODES.items():
        (found,) = (one for one in epicyclic.explain(code) if one.kind == "warning")
        assert (found.meaning, found.cure, found.page) == (entry.meaning, entry.cure, entry.page)
    assert epicyclic.explain("[contact-lost]") == epicyclic.explain("contact-lost")


def test_every_variable_is_explained() -> None:
    for name in VARIABLES:
        found = [one for one in epicyclic.explain(name) if one.kind == "variable"]
        assert found, name
        assert all(one.meaning and one.given_by and one.page == "variables.md" for one in found), name


def test_a_variable_names_its_dims_and_verbs() -> None:
    (found,) = (one for one in epicyclic.explain("mesh_force_peak") if "sharing" in one.given_by)
    assert found.unit == "N"
    assert "mesh" in found.dims
    result = epicyclic.sharing("ren2021", cycles=2)
    assert result.mesh_force_peak.dims == ("mesh",)
    absolute, relative = (one for one in epicyclic.explain("speed") if one.kind == "variable")
    assert (absolute.unit, relative.unit) == ("rpm", "")


def test_verbs_and_figures_are_explained() -> None:
    for name in verbs():
        assert any(one.kind == "verb" for one in epicyclic.explain(name.replace("_", "-")))
    for name in figure_names():
        assert any(one.kind == "figure" for one in epicyclic.explain(name))
    pages = {one.page for name in ("modes", "frequencies") for one in epicyclic.explain(name)}
    assert "verbs.md" in pages


def test_words_of_tables_are_explained() -> None:
    leads = ([0, 0, 0], [0, 1 / 3, 2 / 3], [0, 0.5, 0, 0.5])
    phases = [phasing(one).partition(",")[0] for one in leads]
    for word in (*DEFINITIONS, *FORMS, "K_v", "k_gamma", *_KINDS, "mixed", *phases):
        found = epicyclic.explain(word)
        assert [one.name.casefold() for one in found if one.kind == "word"] == [word.casefold()]


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("contact-lots", "contact-lost"),
        ("frequencyy", "frequency"),
        ("stages.main.sun.support.radail", "stages.main.sun.support.radial"),
        ("sun.supporrt.radial", "sun.support.radial"),
        ("supporrt.radial", "support.radial"),
        ("sharng", "sharing"),
        ("backlsh", "backlash"),
        ("waterfal", "waterfall"),
    ],
)
def test_the_nearest_of_all_kinds_is_told(word: str, meant: str) -> None:
    with pytest.raises(epicyclic.ModelError, match=f"did you mean .*{re.escape(meant)}"):
        epicyclic.explain(word)


@pytest.mark.parametrize("word", ["", ".", "...", "qqqqq", "*", "a.b.c.d.e.f.g", "x" * 3000, "\n", "stages.main"])
def test_odd_words_are_no_fault(word: str) -> None:
    try:
        found = epicyclic.explain(word)
    except epicyclic.ModelError as error:
        assert "not known" in str(error)  # noqa: PT017
    else:
        assert all(one.meaning for one in found)


def test_the_command_tells_the_same() -> None:
    run = CliRunner()
    text = run.invoke(app, ["explain", "sun.support.radial"], env={"COLUMNS": "200"})
    assert text.exit_code == 0
    own = path_of("sun.support.radial")
    assert all(part in text.output for part in (own.name, own.meaning, own.example, own.page))
    told = run.invoke(app, ["explain", "backlash", "--json"])
    assert json.loads(told.output) == [one.as_dict() for one in epicyclic.explain("backlash")]
    wrong = run.invoke(app, ["explain", "frequencyy"])
    assert wrong.exit_code == 2
    assert "did you mean" in wrong.output


def test_known_words_are_not_doubled() -> None:
    words = known_words()
    assert len(set(words)) == len(words)


def test_pages_are_there() -> None:
    pages = {
        one.page
        for word in ("modes", "sun.mass", "tolerance", "frequency", "frequencies")
        for one in epicyclic.explain(word)
    }
    there = {path.name for path in (ROOT / "docs").rglob("*.md")} | {"take-away.md"}  # that page comes with the figures
    assert pages <= there
