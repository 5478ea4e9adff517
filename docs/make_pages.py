"""Write the pages that follow from the records in `epicyclic/verbs`: verbs.md from their signatures, variables.md from
the results of their examples.

python docs/make_pages.py
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, ForwardRef, get_args, get_origin

import xarray as xr

from epicyclic import audit
from epicyclic.verbs.record import Option, Verb, help_of, keywords, verbs

HERE = Path(__file__).parent
DRIVE = "ren2021"
HEAD = """# Verbs

Made by `python docs/make_pages.py` from the records in `src/epicyclic/verbs`; not written by hand.

Every verb takes a source (the name of a ready drive, a model file, a dict, a Train or a System) and returns a Dataset.
`overrides`, path -> value, go with a model file, not with a Train or System. The attribute `verb` of the Dataset is the
kind of result; [variables.md](variables.md) lists the variables of each kind. On the command line a verb is
`epicyclic VERB MODEL`, with `--set PATH=VALUE` for overrides, `--json` and `-o FILE`.
A flag is the keyword with dashes; keywords without a flag are of Python alone. A verb with `progress` calls it while it
runs.
"""


VARIABLES = f"""# Variables of results

Made by `python docs/make_pages.py` from results of the ready drive `{DRIVE}`; not written by hand.

The kind of a result is its attribute `verb`; a verb may give two kinds. A model with slices, laws of links or several
stages adds variables; `result.NAME.attrs` has unit and meaning of each. Complex variables are split into real and
imaginary part along `part` in files.
"""


def verbs_page() -> str:
    """Text of verbs.md."""
    return "\n".join([HEAD, *(_section(verb) for verb in verbs().values())])


def examples() -> list[tuple[Verb, dict[str, Any]]]:
    """Every verb with the keywords of each of its examples."""
    return [(verb, dict(options)) for verb in verbs().values() for options in verb.examples]


def variables_page(results: Iterable[xr.Dataset]) -> str:
    """Text of variables.md: dims, unit and meaning of every variable of some results, by kind."""
    rows: dict[str, list[str]] = {}
    for result in results:
        rows.setdefault(str(result.attrs["verb"]), []).extend(
            variable_row(str(name), result[name]) for name in result.variables
        )
    head = ["| variable | dims | unit | meaning |", "|---|---|---|---|"]
    sections = ["\n".join([f"## {kind}", "", *head, *dict.fromkeys(rows[kind]), ""]) for kind in sorted(rows)]
    return "\n".join([VARIABLES, *sections])


def variable_row(name: str, variable: xr.DataArray) -> str:
    """Row of a variable in variables.md; dims alone for a coordinate that counts or names."""
    words = [str(variable.attrs.get(key, "")) for key in ("units", "long_name")]
    return f"| `{name}` | {', '.join(map(str, variable.dims))} | {' | '.join(words)} |"


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
    (HERE / "reference" / "verbs.md").write_text(verbs_page(), encoding="utf-8")
    found = [verb.run(DRIVE, **options) for verb, options in examples()]
    (HERE / "reference" / "variables.md").write_text(variables_page([*found, audit(DRIVE)]), encoding="utf-8")
