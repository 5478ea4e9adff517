"""Codes of warnings: every text of a warning is made by `coded`, every code is explained and used."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path

import pytest
import xarray as xr
from tests.unit.package_source import PACKAGE, SOURCES, nodes_of, tree_of

import epicyclic
from epicyclic.document.document import drive_titles
from epicyclic.warning_codes import WARNING_CODES, code_of, coded, placed

ROOT = Path(__file__).parents[2]
HOME = PACKAGE / "warning_codes.py"
# what hands warnings on: a function or attribute of such a name holds coded texts, which mypy carries from there on
CARRIERS = re.compile(r"(^|_)warnings$|^warn$")


def calls(name: str) -> list[tuple[Path, ast.Call]]:
    """Calls of a function of this name in the package."""
    return [
        (path, node)
        for path in SOURCES
        for node in nodes_of(path)
        if isinstance(node, ast.Call) and (getattr(node.func, "attr", "") or getattr(node.func, "id", "")) == name
    ]


def uncoded(tree: ast.AST) -> list[str]:
    """Declarations that let a text without a code into the warnings of a result.

    Every list of warnings must be declared as of `CodedText`: parameters, fields and return values of the names of
    `CARRIERS`.  The type checker does the rest, because only `coded` and `placed` make a `CodedText`.
    """
    found = []
    for node in ast.walk(tree):
        declared: list[tuple[str, ast.expr | None]] = []
        if isinstance(node, ast.FunctionDef):
            declared.append((node.name, node.returns))
            declared += [(a.arg, a.annotation) for a in (*node.args.args, *node.args.kwonlyargs)]
            if node.name == "warn":
                declared[0] = ("", None)
                declared += [("warnings", a.annotation) for a in node.args.args if a.arg != "self"]
        elif isinstance(node, ast.AnnAssign):
            declared.append((ast.unparse(node.target).rsplit(".", 1)[-1], node.annotation))
        line = getattr(node, "lineno", 0)
        for name, annotation in declared:
            if CARRIERS.search(name) and (annotation is None or "CodedText" not in ast.unparse(annotation)):
                found.append(f"{name}, line {line}")
    return found


def test_lists_of_warnings_hold_coded_texts_alone() -> None:
    """Rooms below the views: there a list of warnings is made, above it is printed."""
    made = [path for path in SOURCES if path.relative_to(PACKAGE).parts[0] not in ("show", "cli")]
    assert {path.name: names for path in made if (names := uncoded(tree_of(path)))} == {}


def test_a_list_of_plain_texts_is_seen() -> None:
    assert uncoded(ast.parse("def some_warnings(x) -> list[str]: ...")) == ["some_warnings, line 1"]
    assert uncoded(ast.parse("def dataset(*, warnings: Sequence[str] = ()) -> None: ..."))
    assert uncoded(ast.parse("class A:\n    warnings: tuple[str, ...] = ()"))
    assert uncoded(ast.parse("class A:\n    def warn(self, text: str) -> None: ..."))


def test_only_coded_and_placed_make_a_coded_text() -> None:
    """A cast, a call of the type or an ignored complaint would lead round the type checker."""
    assert {path for path, _ in calls("CodedText")} == {HOME}
    casts = [(path, ast.unparse(call)) for path, call in calls("cast") if "CodedText" in ast.unparse(call)]
    assert casts == []
    for path in SOURCES:
        for line in path.read_text(encoding="utf-8").splitlines():
            assert not ("type: ignore" in line and re.search(r"warn|CodedText|coded\(", line)), (path, line)


def test_every_code_is_known_and_used() -> None:
    """Codes stand as literals, so that the table and the calls can be compared; one is handed on as `code`."""
    used = set()
    for path, call in calls("coded"):
        if path == HOME:
            continue
        if isinstance(call.args[0], ast.Name):
            assert path.name in ("resolution.py", "train.py")
            assert call.args[0].id == "code"
            continue
        used.add(ast.literal_eval(call.args[0]))
    used |= {ast.literal_eval(call.args[0]) for _, call in calls("tell_overlap")}
    assert used == set(WARNING_CODES)


@pytest.mark.parametrize("code", list(WARNING_CODES))
def test_every_code_is_explained(code: str) -> None:
    entry = WARNING_CODES[code]
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", code)
    for text in (entry.meaning, entry.cure):
        assert text[0].isupper() or text.split()[0].startswith(("sweep", "static"))
        assert text.endswith(".")
        assert "  " not in text
    assert entry.meaning != entry.cure
    assert len(list((ROOT / "docs").rglob(entry.page))) == 1, entry.page


def test_a_text_gets_a_known_code_alone() -> None:
    text = coded("contact-lost", "mesh force falls to zero")
    assert text == "mesh force falls to zero [contact-lost]"
    assert placed("at 2 of 3 points", text) == "at 2 of 3 points: mesh force falls to zero [contact-lost]"
    assert code_of(text) == "contact-lost"
    assert (code_of("mesh force"), code_of("a [nonsense]"), code_of("[contact-lost] first")) == (None, None, None)
    with pytest.raises(KeyError):
        coded("nonsense", "a text")


def warnings_of(result: xr.Dataset) -> list[str]:
    return [str(text) for text in json.loads(result.attrs["warnings"])]


@pytest.mark.parametrize("drive", list(drive_titles()))
def test_warnings_of_the_ready_drives_have_codes(drive: str) -> None:
    train = epicyclic.load(drive)
    said = warnings_of(epicyclic.check(train))
    try:
        system = epicyclic.assemble(train)
        for run in (epicyclic.modes, epicyclic.sharing, lambda s: epicyclic.sweep(s, points=3)):
            said += warnings_of(run(system))
    except (epicyclic.ModelError, epicyclic.ConvergenceError):
        pass  # what a drive does not say (loads, damping) is told by `check`
    assert [text for text in said if code_of(text) is None] == []
