"""Records of the verbs: every one is exported, typed, explained, and gives the kinds of result it says."""

from __future__ import annotations

import re
from inspect import signature
from pathlib import Path
from typing import Annotated, get_origin

import pytest

import epicyclic
from epicyclic.options import Option
from epicyclic.verbs.record import Verb, keywords, records

STUB = Path(epicyclic.__file__).with_name("__init__.pyi").read_text(encoding="utf-8")
NAMES = sorted(records())


def test_every_verb_is_a_function_of_the_stub() -> None:
    homes = {name: f"epicyclic{home}" for name, home in re.findall(r"^def (\w+)\(  # (\S+)$", STUB, re.MULTILINE)}
    assert homes == {name: records()[name].run.__module__ for name in NAMES}
    assert set(NAMES) <= set(epicyclic.__all__)


def test_the_stub_has_all_names() -> None:
    exported = re.findall(r"^from \S+ import (\w+) as \1$", STUB, re.MULTILINE)
    assert sorted([*exported, *NAMES]) == sorted(epicyclic.__all__)
    for name in epicyclic.__all__:
        assert getattr(epicyclic, name) is not None


@pytest.mark.parametrize("name", NAMES)
def test_every_keyword_is_typed_and_explained(name: str) -> None:
    verb = records()[name]
    assert getattr(epicyclic, name) is verb.run
    assert verb.gives
    parameters = signature(verb.run).parameters
    assert next(iter(parameters)) == "source"
    assert all(one.kind is one.KEYWORD_ONLY for keyword, one in parameters.items() if keyword != "source")
    written = verb.run.__annotations__
    bare = {key for key in parameters if get_origin(written[key]) is not Annotated}
    assert bare <= {"source", "overrides", "progress"}
    for _, _, option in keywords(verb.run).values():
        assert option.help.endswith((".", "...", ")"))


@pytest.mark.parametrize("name", NAMES)
def test_keywords_and_flags_are_the_same_words(name: str) -> None:
    for keyword, (_, _, option) in keywords(records()[name].run).items():
        assert option.flag_of(keyword) in (None, f"--{keyword.replace('_', '-')}")


@pytest.mark.parametrize("name", NAMES)
def test_a_wrong_keyword_names_the_verb(name: str) -> None:
    with pytest.raises(TypeError, match=rf"^{name}\(\) got an unexpected keyword argument 'guess'"):
        records()[name].run("ren2021", guess=1)


def test_kinds_belong_to_one_verb() -> None:
    kinds = [kind for verb in records().values() for kind in verb.gives]
    assert len(kinds) == len(set(kinds))


@pytest.mark.parametrize("name", ["check", "stiffness", "modes", "campbell", "static", "sharing"])
def test_a_result_is_of_a_kind_the_record_says(name: str) -> None:
    assert records()[name].run("ren2021").attrs["verb"] in records()[name].gives


def test_help_shows_what_a_keyword_means() -> None:
    assert repr(Option("Solve the damped problem.")) == "'Solve the damped problem.'"
    assert "Solve the damped problem." in (epicyclic.modes.__doc__ or "")


def test_a_record_needs_its_function_and_kinds() -> None:
    with pytest.raises(TypeError):
        Verb(run=epicyclic.modes)  # type: ignore[call-arg]
