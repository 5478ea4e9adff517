"""The documentation: links lead somewhere, its code runs, its model files load, its commands exist."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import re
import shlex
import tomllib
from collections.abc import Callable, Iterator
from functools import wraps
from pathlib import Path
from types import ModuleType

import pytest
from tests.unit.example_results import DRIVE, PLACES, example_result
from typer.main import get_group

import epicyclic
from epicyclic.cli.main import app
from epicyclic.verbs.record import records, verbs

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def identifier(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=identifier)
def test_links_lead_somewhere(page: Path) -> None:
    targets = re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
    missing = [t for t in targets if not t.startswith("https://") and not (page.parent / t.split("#")[0]).exists()]
    assert missing == []


@pytest.mark.parametrize("page", PAGES, ids=identifier)
def test_model_files_load(page: Path) -> None:
    whole = [text for text in map(tomllib.loads, blocks(page, "toml")) if "stages" in text and "operation" in text]
    assert len(whole) == 1 or identifier(page) != "docs/reference/model-file.md"
    for document in whole:
        speed = epicyclic.check(document).speed
        stated = document["operation"].get("speed", {"sun": "0 rpm"})  # without a speed a train that is locked
        member = next((name for name in ("carrier", "wheel") if name in stated), "sun")
        given = float(stated.get(member, "1500 rpm").removesuffix(" rpm"))
        body = next(body for body in speed.body.values if body.endswith(f"/{member}"))
        assert float(speed.sel(body=body)) == pytest.approx(given, rel=1e-12)  # through rad/s and back


@pytest.mark.parametrize("page", ["docs/reference/model-file.md"])
def test_the_example_is_a_good_gearbox(page: str) -> None:
    (document,) = (text for text in map(tomllib.loads, blocks(ROOT / page, "toml")) if "stages" in text)
    found = {
        "check": epicyclic.check(document),
        "sharing": epicyclic.sharing(document),
        "steady": epicyclic.steady(document),
        "contact": epicyclic.contact(document, mesh="sun-planet", samples=8, slices=4),
        "contact of the train": epicyclic.contact(document, samples=4, slices=4, cycles=30, loads=(1.0,)),
    }
    said = {verb: json.loads(result.attrs["warnings"]) for verb, result in found.items()}
    # its stiffness by ISO 6336 ignores the relief, as the comment beside the relief says
    assert any("flank-without-effect" in text for text in said["steady"])
    others = {verb: [text for text in texts if "flank-without-effect" not in text] for verb, texts in said.items()}
    assert others == {verb: [] for verb in found}
    sharing = found["sharing"].system_load_sharing.values
    assert ((sharing > 1) & (sharing < 1.2)).all()


def test_readme_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (code,) = blocks(ROOT / "README.md", "python")
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(code, "README.md", "exec"), {})
    assert "cycle-peak" in printed.getvalue()
    assert epicyclic.load_result(tmp_path / "sharing.nc").attrs["verb"] == "sharing"


def commands() -> list[list[str]]:
    lines = [line for page in PAGES for block in blocks(page, "sh") for line in block.splitlines()]
    split = [shlex.split(line, comments=True) for line in lines]
    return [words[1 : words.index(">") if ">" in words else None] for words in split if words[:1] == ["epicyclic"]]


def test_there_are_commands() -> None:
    assert len(commands()) >= 7


CHECKED = {name.replace("_", "-") for name in verbs()} | {"report", "audit", "study"}  # others run, in test_docs_run


def recorded(command: Callable[..., None], seen: list[str]) -> Callable[..., None]:
    """The command with its options, which says its name and does nothing."""

    @wraps(command)
    def record(**_: object) -> None:
        seen.append(command.__name__)

    return record


@pytest.fixture(scope="module")
def parsed() -> Iterator[Callable[[list[str]], list[str]]]:
    """The names of what a command line asks for, which is not done."""
    seen: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        for entry in app.registered_commands:
            if entry.callback is not None and entry.callback.__name__ in ("report", "audit", "study"):
                patch.setattr(entry, "callback", recorded(entry.callback, seen))
        program = get_group(app)
    with pytest.MonkeyPatch.context() as patch:
        for module in ("command", "main"):
            patch.setattr(f"epicyclic.cli.{module}.run_verb", lambda verb, *_, **__: seen.append(verb.name))

        def names(words: list[str]) -> list[str]:
            seen.clear()
            with pytest.raises(SystemExit) as stop:
                program(words)
            assert stop.value.code == 0
            return list(seen)

        yield names


@pytest.mark.parametrize("words", [one for one in commands() if one[0] in CHECKED], ids=" ".join)
def test_commands_parse(words: list[str], parsed: Callable[[list[str]], list[str]]) -> None:
    assert parsed(words) == [words[0].replace("-", "_")]


def load_pages() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_pages", ROOT / "docs" / "make_pages.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


PAGES_MADE = load_pages()


@pytest.mark.parametrize("name", sorted(PAGES_MADE.PAGES))
def test_pages_are_what_the_code_says(name: str) -> None:
    page = (ROOT / "docs" / "reference" / f"{name}.md").read_text(encoding="utf-8")
    assert page == PAGES_MADE.PAGES[name](), "run python docs/make_pages.py"


def listed_rows(kind: str) -> set[str]:
    """Rows that docs/reference/variables.md has of a kind of result."""
    text = (ROOT / "docs" / "reference" / "variables.md").read_text(encoding="utf-8")
    return set(text.partition(f"## {kind}\n")[2].partition("\n## ")[0].splitlines()[3:])


def test_the_page_has_the_variables_of_every_example() -> None:
    made = [(verb.name, options) for verb, options in PAGES_MADE.examples()]
    assert made == [(verb, dict(verbs()[verb].examples[place])) for verb, place in PLACES]
    assert PAGES_MADE.DRIVE == DRIVE


@pytest.mark.parametrize(("verb", "place"), PLACES)
def test_results_have_the_variables_of_the_page(verb: str, place: int) -> None:
    result = example_result(verb, place)
    kind = str(result.attrs["verb"])
    assert kind in verbs()[verb].gives
    rows = {PAGES_MADE.variable_row(str(name), result[name]) for name in result.variables}
    assert rows <= listed_rows(kind), "run python docs/make_pages.py"


def test_explain_knows_the_variables_of_the_page() -> None:
    page = (ROOT / "docs" / "reference" / "variables.md").read_text(encoding="utf-8")
    assert PAGES_MADE.KINDS.read_text(encoding="utf-8") == PAGES_MADE.kinds_text(page), "run python docs/make_pages.py"


def test_every_kind_of_result_is_on_the_page() -> None:
    kinds = {kind for verb in records().values() for kind in verb.gives}
    text = (ROOT / "docs" / "reference" / "variables.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^## (\w+)$", text, re.MULTILINE)) == kinds | {"audit", "compare"}


def test_make_targets_exist() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    rules = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"\bmake (demo|test|bench|figures|clean)\b", text)) <= set(rules)


def test_sources_of_equations_are_references() -> None:
    text = (ROOT / "docs" / "theory" / "sources.md").read_text(encoding="utf-8")
    rows = [line.split(" | ")[-1] for line in text.splitlines() if line.startswith("| ") and "source |" not in line]
    known = re.findall(r"^## (\w+)$", (ROOT / "docs" / "theory" / "references.md").read_text("utf-8"), re.MULTILINE)
    named = [re.findall(r"\[([a-z]+[0-9]+[a-z]?)[,\]]", row) for row in rows]
    assert all(keys or "derived here" in row for row, keys in zip(rows, named, strict=True))
    assert {key for keys in named for key in keys} <= set(known)


def test_external_links_can_be_listed() -> None:
    listed = PAGES_MADE.external_links()
    assert "https://keepachangelog.com/en/1.1.0/" in listed
    assert all(link.startswith("https://") for link in listed)
