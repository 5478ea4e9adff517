"""`help(verb)`: the real signature with plain types, a line for each keyword; checkers still see the annotations."""

from __future__ import annotations

import pydoc
import re
from inspect import Parameter, Signature, getdoc, signature
from typing import Annotated, get_args, get_origin

import pytest

import epicyclic
from epicyclic.options import Option
from epicyclic.verbs.record import described, keywords, type_words, verbs


@pytest.mark.parametrize("name", [name for name in verbs()])
def test_help_has_every_keyword_with_its_type(name: str) -> None:
    verb = getattr(epicyclic, name)
    shown = signature(verb)
    assert all(one.kind in (one.KEYWORD_ONLY, one.POSITIONAL_OR_KEYWORD) for one in shown.parameters.values())
    assert all(one.annotation is not Parameter.empty for one in shown.parameters.values())
    text = pydoc.plain(pydoc.render_doc(verb))
    for noise in ("Annotated", "Option(", "typing.", "ForwardRef", "*args", "**", "<function"):
        assert noise not in text, noise
    said = getdoc(verb) or ""
    for keyword in shown.parameters:
        assert re.search(rf"(?:^|  ){keyword} :", said, re.MULTILINE), keyword
    assert all(len(line) <= 116 for line in said.splitlines())


@pytest.mark.parametrize("name", [name for name in verbs()])
def test_help_has_units_and_defaults(name: str) -> None:
    verb = verbs()[name]
    said = " ".join((verb.run.__doc__ or "").split())
    for keyword, (default, _, option) in keywords(verb.run).items():
        assert default is signature(verb.run).parameters[keyword].default
        for unit in re.findall(r"\[[^\]]+\]", option.help):
            assert unit in said
        assert not option.default or option.default in said


def test_annotations_stay_what_checkers_read() -> None:
    kind = epicyclic.modes.__annotations__["damped"]
    origin: object = get_origin(kind)
    assert origin is Annotated
    assert get_args(kind)[0] is bool
    assert str(signature(epicyclic.modes)).endswith(
        "damped: bool = False, band: float | str | None = None) -> xr.Dataset"
    )


def test_flags_become_keywords() -> None:
    def run(source: str, *, contact_loss: bool = False) -> None:
        """Do it.

        Raises
        ------
        ModelError : it is wrong.
        """

    option = Option("With --contact-loss, not with --other.", least=1, above=0, default="chosen")
    parameter = signature(run).parameters["contact_loss"]
    text = "Do it.\n\n    Raises\n    ------\n    ModelError : no.\n    "
    shown, doc = described(signature(run), text, {"contact_loss": (parameter, bool, option)})
    assert isinstance(shown, Signature)
    assert "contact_loss : bool, above 0, 1 or more, default chosen. With `contact_loss`, not with --other." in doc
    assert doc.index("Parameters") < doc.index("contact_loss :") < doc.index("Raises")


def test_types_are_as_one_writes_them() -> None:
    assert type_words("xr.Dataset") == "xr.Dataset"
    assert type_words(float | None) == "float | None"
    assert type_words(bool) == "bool"
