"""Write the pages of docs/reference that follow from the code.

verbs.md and the stub of the package come from the options of `verbs`, variables.md from the results of their examples,
api.md from the stub, commands.md from the command line, schema.md from the JSON Schema of the model file,
warnings.md from the table of their codes.

python docs/make_pages.py          write them
python docs/make_pages.py links    list the addresses outside that pages link to
"""

from __future__ import annotations

import json
import re
import sys
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, ForwardRef, cast, get_args, get_origin
from urllib.parse import quote

import xarray as xr

from epicyclic import audit, compare
from epicyclic.options import Option
from epicyclic.verbs.record import Verb, help_of, keywords, records, verbs
from epicyclic.warning_codes import WARNING_CODES

HERE = Path(__file__).parent
_CITATION = re.compile(r"(?:\[|; )([a-z]+[0-9]{4}[a-z]?|iso[0-9]+)(?=[],;])")
DRIVE = "ren2021"
VARIANT = {"stages.main.sun.support.radial": 0}  # of the comparison whose variables are listed
HISTORY = {"time [s]": [0, 1, 2], "torque [N m]": [1, 3, 2], "speed [rpm]": [1, 1, 1]}  # of the load spectrum
KINDS = HERE.parent / "src" / "epicyclic" / "results" / "variable_kinds.json"
STUB = HERE.parent / "src" / "epicyclic" / "__init__.pyi"
HEAD = """# Verbs

Made by `python docs/make_pages.py` from the records in `src/epicyclic/questions/*/verbs.py`; not written by hand.

Every verb takes a source (the name of a ready drive, a model file, a dict, a Train or a System) and returns a Dataset;
the source of `spectrum` is a load history.
`overrides`, path -> value, go with a model file, not with a Train or System. The attribute `verb` of the Dataset is the
kind of result; [variables.md](variables.md) lists the variables of each kind. On the command line a verb is
`epicyclic VERB MODEL`, with `--set PATH=VALUE` for overrides, `--json` and `-o FILE`.
A flag is the keyword with dashes; keywords without a flag are of Python alone. A verb with `progress` calls it while it
runs.
"""

API = """# Python

Made by `python docs/make_pages.py`; not written by hand.

`import epicyclic` has these names. What the keywords of a verb mean stands in [Verbs](verbs.md), with the flag of each
on the command line; the variables of the results in [Variables](variables.md). Types are checked from outside: the
package carries `py.typed`.
"""
COMMANDS = """# Commands beside the verbs

Made by `python docs/make_pages.py` from the command line itself; not written by hand.

`epicyclic COMMAND --help` prints the same. The verbs are on [their own page](verbs.md). Exit status: 0; 2 for wrong
input or an output that cannot be written; 3 for no convergence; 4 for an audit that is contradicted; 130 when stopped;
1 for a fault of the program.
"""
REFERENCES = """# References

Made by `python docs/make_pages.py` from `src/epicyclic/references.bib`; not written by hand. The code cites an entry as
[key, eq. n]. What has no key is derived here.
"""
WARNINGS = """# Warnings

Made by `python docs/make_pages.py` from `src/epicyclic/warning_codes.py`; not written by hand.

A result that is physically doubtful says so: in its attribute `warnings`, beside its tables and in the report.
Each warning ends with its code in brackets. `epicyclic explain CODE` prints what stands here.
"""
SCHEMA = """# Keys of the model file

Made by `python docs/make_pages.py` from the JSON Schema of the model file (`epicyclic schema`); not written by hand.

[The model file](model-file.md) explains the keys with examples and units. An editor with the schema completes and
checks them while you type ([how](../how-to/editor.md)).
"""

VARIABLES = f"""# Variables of results

Made by `python docs/make_pages.py` from results of the ready drive `{DRIVE}`; not written by hand.

The kind of a result is its attribute `verb`; a verb may give two kinds. A model with slices, sensors, laws of links or
several stages adds variables; `result.NAME.attrs` has unit and meaning of each. Complex variables are split into real
and imaginary part along `part` in files.
"""


def verbs_page() -> str:
    """Text of verbs.md."""
    return "\n".join([HEAD, *(_section(verb) for verb in records().values())])


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


def kinds_text(page: str) -> str:
    """JSON of variables.md for `epicyclic explain`: variable -> kind of result -> dims."""
    table: dict[str, dict[str, list[str]]] = {}
    for section in page.split("\n## ")[1:]:
        kind, *lines = section.splitlines()
        for name, dims in re.findall(r"^\| `(.+?)` \| (.*?) \|", "\n".join(lines), re.MULTILINE):
            table.setdefault(name, {})[kind] = [dim for dim in dims.split(", ") if dim]
    rows = (f"{json.dumps(name)}: {json.dumps(table[name], sort_keys=True)}" for name in sorted(table))
    return "{\n" + ",\n".join(rows) + "\n}\n"


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
    rows = [_row(name, *entry) for name, entry in keywords(verb.run).items()]
    if rows:
        lines += ["| keyword | flag | type | default | meaning |", "|---|---|---|---|---|", *rows, ""]
    return "\n".join(lines)


def _row(name: str, default: Any, kind: Any, option: Option) -> str:
    cells = [f"`{name}`", _flag(name, option), f"`{_worded(kind)}`", _default(default, option), option.help]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _flag(name: str, option: Option) -> str:
    flag = option.flag_of(name)
    return "" if flag is None else f"`{flag}`"


def _default(default: Any, option: Option) -> str:
    if default is Parameter.empty:
        return "required"
    return option.default or ("" if default is None else f"`{default!r}`")


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


def api_page() -> str:
    """Text of api.md: every public name, in groups of one question each, verbs by name."""
    names = re.findall(r"^(?:from \S+ import|def) (\w+)(?: as \1$|\()", stub_text(), re.MULTILINE)
    groups: dict[str, list[str]] = {"Verbs": [], "Errors": [], "Train and system": [], "Around the verbs": []}
    for name in names:
        groups[_group_of(name)].append(name)
    lines = [API]
    for group in ("Train and system", "Verbs", "Around the verbs", "Errors"):
        lines += [f"## {group}", ""]
        for name in sorted(groups[group]) if group == "Verbs" else groups[group]:
            kind = {"Errors": "autoexception", "Train and system": "autoclass"}.get(group, "autofunction")
            kind = kind if name[0].isupper() else "autofunction"
            lines += [f"### {name}", "", "```{eval-rst}", f".. {kind}:: epicyclic.{name}", "```", ""]
    return "\n".join(lines)


def stub_text() -> str:
    """Text of the stub of the package: the names as they are, and every verb with the keywords of its options."""
    names, mark, _ = STUB.read_text(encoding="utf-8").partition("\n# Verbs\n")
    return names + mark + "".join(_stub(verb) for verb in records().values())


def _stub(verb: Verb) -> str:
    """A verb in the stub: where it is from, its typed keywords, its first sentence."""
    typed = []
    for name, parameter in signature(verb.run).parameters.items():
        default = "" if parameter.default is Parameter.empty else f" = {parameter.default!r}"
        typed += [f"{name}: {parameter.annotation!r}{default}", *(["*"] if name == "source" else [])]
    lines = "".join(f"    {one},\n" for one in typed).replace("'", '"')
    home = verb.run.__module__.removeprefix("epicyclic")
    first = help_of(verb).split("\n\n")[0].split(": ")[0].rstrip(".")
    return f'\ndef {verb.name}(  # {home}\n{lines}) -> xr.Dataset:\n    """{first}."""\n'


def _group_of(name: str) -> str:
    if name in records():
        return "Verbs"
    if name.endswith("Error"):
        return "Errors"
    return "Train and system" if name in ("load", "assemble", "Train", "System") else "Around the verbs"


def commands_page() -> str:
    """Text of commands.md: the commands that are no verbs, and the options that every verb has."""
    from typer.main import get_command

    from epicyclic.cli.main import app

    root = cast(Any, get_command(app))
    own = {
        name: one for name, one in root.commands.items() if name.replace("-", "_") not in records() and not one.hidden
    }
    common = _options_table(root.commands["modes"], only=_common(root))
    common = [
        re.sub(r"may be repeated: [\w, -]+\.", "may be repeated; the help of a verb names its own.", row)
        for row in common
    ]
    lines = [COMMANDS, "## Options of every verb", "", *common, ""]
    for name, one in sorted(own.items()):
        lines += [f"## {name}", "", _sentence(one.help), "", f"`epicyclic {_usage(name, one)}`", ""]
        lines += [*_options_table(one), ""]
    return "\n".join(lines)


def _common(root: Any) -> set[str]:
    """Options that all verbs have."""
    found = [{one.name for one in root.commands[name.replace("_", "-")].params} for name in records()]
    return set.intersection(*found)


def _usage(name: str, command: Any) -> str:
    places = [one for one in command.params if one.param_type_name == "argument"]
    words = [(one.metavar or one.name.upper()).strip("{}[]") for one in places]
    marked = [word if one.required else f"[{word}]" for word, one in zip(words, places, strict=True)]
    return " ".join(
        [name, *(f"{word} ..." if one.nargs == -1 else word for word, one in zip(marked, places, strict=True))]
    )


def _options_table(command: Any, only: set[str] | None = None) -> list[str]:
    rows = []
    for one in command.params:
        shown = only is None or one.name in only
        if shown and not getattr(one, "hidden", False):
            flags = ", ".join(f"`{flag}`" for flag in (*one.opts, *one.secondary_opts))
            words = flags if one.param_type_name == "option" else f"`{(one.metavar or one.name.upper()).strip('{}[]')}`"
            rows.append(f"| {words} | {_sentence(getattr(one, 'help', '') or '')} |".replace("[", "\\["))
    return ["| option | meaning |", "|---|---|", *rows] if rows else []


def _sentence(text: str) -> str:
    """Text of a help in one line, ready for a cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")


def schema_page() -> str:
    """Text of schema.md: tables and keys of the model file, from its JSON Schema."""
    from epicyclic.document.writer import json_schema

    schema = json_schema()
    tables = {"The file": schema} | {
        name: one for name, one in sorted(schema["$defs"].items()) if "properties" in one or "enum" in one
    }
    lines = [SCHEMA]
    for name, one in tables.items():
        lines += [f"## {name}", ""]
        if one.get("description"):
            lines += [_schema_words(one), ""]
        if "properties" in one:
            lines += ["| key | takes | meaning |", "|---|---|---|"]
            lines += [
                f"| `{key}` | {_takes(entry)} | {_schema_words(entry)} |" for key, entry in one["properties"].items()
            ]
            lines.append("")
        else:
            lines += ["One of " + ", ".join(f"`{value}`" for value in one["enum"]) + ".", ""]
    return "\n".join(lines)


def _schema_words(entry: dict[str, Any]) -> str:
    return _sentence(str(entry.get("description", "")))


def _takes(entry: dict[str, Any]) -> str:
    """What a key takes: a kind of value, a choice, or a table of its own."""
    found: list[str] = []
    for one in (entry, *entry.get("anyOf", ()), *entry.get("oneOf", ())):
        if "$ref" in one:
            found.append(one["$ref"].rpartition("/")[2])
        if "enum" in one:
            found += [f"`{value}`" for value in one["enum"]]
        if "const" in one:
            found.append(f"`{one['const']}`")
        if isinstance(one.get("type"), str) and one["type"] != "null":
            inner = one.get("items") or one.get("additionalProperties")
            of = f" of {_takes(inner)}" if isinstance(inner, dict) and inner else ""
            found.append(f"{ {'object': 'table', 'array': 'list'}.get(one['type'], one['type']) }{of}")
    return ", ".join(dict.fromkeys(found)).replace("|", "\\|") or "any"


def warnings_page() -> str:
    """Text of warnings.md: every code with its meaning, what cures it, and the page that says more."""
    pages = {page.name: page.relative_to(HERE).as_posix() for page in sorted(HERE.rglob("*.md"))}
    lines = [WARNINGS]
    for code, entry in sorted(WARNING_CODES.items()):
        lines += [f"## {code}", "", f"{entry.meaning}", "", f"*Cure*: {entry.cure}", ""]
        if entry.page in pages:
            lines += [f"More: [{entry.page.removesuffix('.md')}](../{pages[entry.page]})", ""]
    return "\n".join(lines)


def references_page() -> str:
    """Text of references.md: every entry of references.bib, and the modules that cite it."""
    package = HERE.parent / "src" / "epicyclic"
    cited: dict[str, list[str]] = {}
    for module in sorted(package.rglob("*.py")):
        for key in dict.fromkeys(_CITATION.findall(module.read_text("utf-8"))):
            cited.setdefault(key, []).append(module.relative_to(package).as_posix())
    lines = [REFERENCES]
    for entry in re.split(r"^@\w+", (package / "references.bib").read_text("utf-8"), flags=re.MULTILINE)[1:]:
        key = entry.partition(",")[0].strip("{ ")
        lines += [f"## {key}", "", _reference(entry), ""]
        if key in cited:
            lines += ["Cited in " + ", ".join(f"`{name}`" for name in cited[key]) + ".", ""]
    return "\n".join(lines)


def _reference(entry: str) -> str:
    """One entry of references.bib in a line."""
    pairs = re.findall(r"(\w+)\s*=\s*\{((?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*)\}", entry)
    field = {name: " ".join(re.sub(r"\\(.)\{?(\w?)\}?", _letter, text).split()) for name, text in pairs}
    field = {name: re.sub(r"[{}]", "", text).replace("--", "-") for name, text in field.items()}
    authors = field.get("author", field.get("institution", "")).replace(" and ", "; ")
    where = field.get("journal") or field.get("booktitle") or field.get("publisher") or field.get("school") or ""
    number = " ".join(filter(None, (field.get("volume"), f"({field['number']})" if "number" in field else "")))
    parts = [authors, f"*{field.get('title', '')}*", where, number, field.get("pages"), field.get("year")]
    text = ", ".join(part for part in parts if part) + "."
    address = quote(field.get("doi", ""), safe="/")  # some have brackets
    return f"{text} [doi:{field['doi']}](https://doi.org/{address})" if address else text


def _letter(found: re.Match[str]) -> str:
    """A letter with its accent, or what a backslash protects."""
    accents = {'"': "\u0308", "'": "\u0301", "`": "\u0300", "c": "\u0327", "o": ""}
    if found[1] == "o":
        return "ø"
    accent = accents.get(found[1])
    return unicodedata.normalize("NFC", found[2] + accent) if accent is not None else found[1] + found[2]


def external_links() -> list[str]:
    """Addresses outside that the pages link to; none is fetched."""
    pages = [HERE.parent / "README.md", HERE.parent / "CHANGELOG.md", *sorted(HERE.rglob("*.md"))]
    texts = [page.read_text(encoding="utf-8") for page in pages if "_build" not in page.parts]
    return sorted({link for text in texts for link in re.findall(r"\]\((https?://[^)\s]+)\)", text.replace("\n", ""))})


PAGES: Mapping[str, Callable[[], str]] = {
    "verbs": verbs_page,
    "api": api_page,
    "commands": commands_page,
    "schema": schema_page,
    "warnings": warnings_page,
    "../theory/references": references_page,
}
"""Name of every page that needs no computation -> its text."""


if __name__ == "__main__":
    if sys.argv[1:] == ["links"]:
        print(*external_links(), sep="\n")
        raise SystemExit
    STUB.write_text(stub_text(), encoding="utf-8")
    for name, text in PAGES.items():
        (HERE / "reference" / f"{name}.md").write_text(text(), encoding="utf-8")
    found = [verb.run(DRIVE, **options) for verb, options in examples()]
    found += [audit(DRIVE), compare(DRIVE, variants=[VARIANT]), compare(found[0], found[0])]
    found.append(records()["spectrum"].run(HISTORY))
    page = variables_page(found)
    (HERE / "reference" / "variables.md").write_text(page, encoding="utf-8")
    KINDS.write_text(kinds_text(page), encoding="utf-8")
