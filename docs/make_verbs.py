"""Write docs/verbs.md: every verb with its keywords, flags and kinds of result, from the records in `epicyclic/verbs`.

python docs/make_verbs.py
"""

from __future__ import annotations

import re
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, ForwardRef, get_args, get_origin

from epicyclic.verbs.record import Option, Verb, help_of, keywords, verbs

PAGE = Path(__file__).with_name("verbs.md")
HEAD = """# Verbs

Made by `python docs/make_verbs.py` from the records in `src/epicyclic/verbs`; not written by hand.

Every verb takes a source (the name of a ready drive, a model file, a dict, a Train or a System) and `overrides`, and
returns a Dataset. Its attribute `verb` is the kind of result; [design.md](design.md) lists the variables of each kind.
On the command line a verb is `epicyclic VERB MODEL`, with `--set PATH=VALUE` for overrides, `--json` and `-o FILE`.
Keywords without a flag are of Python alone; a verb with `progress` calls it while it runs.
"""


def page() -> str:
    """Text of the page."""
    return "\n".join([HEAD, *(_section(verb) for verb in verbs().values())])


def _section(verb: Verb) -> str:
    drawing = "; needs the drawing: a System will not do" if verb.drawing else ""
    report = "; part of `epicyclic report`" if verb.in_report else ""
    progress = "; has `progress`" if "progress" in signature(verb.run).parameters else ""
    lines = [f"## {verb.name.replace('_', '-')}", "", help_of(verb), ""]
    lines += [f"`epicyclic.{verb.name}`; gives {_coded(verb.gives)}{drawing}{report}{progress}.", ""]
    rows = [_row(name, *entry) for name, entry in keywords(verb.run).items() if not entry[2].hidden]
    if rows:
        lines += ["| keyword | flag | type | default | meaning |", "|---|---|---|---|---|", *rows, ""]
    return "\n".join(lines)


def _row(name: str, parameter: Parameter, kind: Any, option: Option) -> str:
    cells = [f"`{name}`", _flag(name, option), f"`{_worded(kind)}`", _default(parameter, option), option.help]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _flag(name: str, option: Option) -> str:
    flag = option.flag_of(name)
    return "" if flag is None else f"`{flag}`"


def _default(parameter: Parameter, option: Option) -> str:
    if parameter.default is Parameter.empty:
        return "required"
    return option.default or ("" if parameter.default is None else f"`{parameter.default!r}`")


def _worded(kind: Any) -> str:
    """A type as one writes it, without modules and without None."""
    if isinstance(kind, ForwardRef):
        text = kind.__forward_arg__
    else:
        text = str(kind) if get_origin(kind) or get_args(kind) else kind.__name__
    text = re.sub(r"\b(typing|collections\.abc|pathlib|types)\.", "", text)
    return re.sub(r" \| None$", "", text).replace("NoneType", "None")


def _coded(names: tuple[str, ...]) -> str:
    return " or ".join(f"`{name}`" for name in names)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
