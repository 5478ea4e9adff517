"""One word explained: a path of the model file, a variable, the code of a warning, a verb, a figure, or a term.

Paths come from the JSON Schema of the model file: what may stand at each, and examples out of the ready drives.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from difflib import SequenceMatcher, get_close_matches
from functools import cache
from importlib import resources
from typing import Any

from .document.deviations import FORMS
from .document.document import ready_drives
from .document.schema import KIND_BY_NAME, SIDES
from .document.tables import keyed, value_text
from .document.units import KINDS
from .document.validation import MEMBER_KEYS
from .document.writer import json_schema
from .errors import ModelError
from .results.variables import OF_KIND, VARIABLES
from .show.plot import FIGURES
from .user_input import checked
from .verbs.record import help_of, keywords, records, verbs
from .warning_codes import WARNING_CODES

_SHARING, _TOLERANCE, _RESPONSE = "sharing.md", "tolerance.md", "response.md"
_FILE, _MODES = "model-file.md", "modes.md"

WORDS: dict[str, tuple[str, str]] = {
    "K_gamma": ("mesh-load factor: the largest share of the load that one of the planets carries, per mean share; "
                "the definition mean-load", _SHARING),
    "K_v": ("dynamic factor: largest mesh force with vibration per the force at rest, at one speed", _RESPONSE),
    "cycle-peak": ("load-sharing coefficient from the peak of each mesh in one mesh cycle: 1 + the largest deviation "
                   "of a peak from the mean of the parallel meshes", _SHARING),
    "simultaneous": ("load-sharing coefficient from forces at one instant: the largest force per mean of the parallel "
                     "meshes at that instant", _SHARING),
    "record-peak": ("load-sharing coefficient from the peak of each mesh over the whole record, per mean of those "
                    "peaks", _SHARING),
    "signed-overload": ("cycle-peak without the absolute value: only meshes that carry more than their share count",
                        _SHARING),
    "worst-case": ("cycle-peak over the whole hunting period", _SHARING),
    "mean-load": ("load-sharing coefficient without mesh-frequency content: quasi-static forces at mean mesh stiffness "
                  "with the errors that stand still; this is K_gamma", _SHARING),
    "mean-load-turning": ("mean-load with the errors that turn, run-outs, at their worst phase of a revolution",
                          _SHARING),
    **{kind: (form.words, _TOLERANCE) for kind, form in FORMS.items()},
    "grade": ("tolerance by a standard: the size from ISO 1328-1 or ISO 286 (IT), read as so many standard deviations",
              _TOLERANCE),
    "rotational": ("kind of mode: all planets of a stage move alike and the central members only turn; driven by mesh "
                   "orders whose forces are in phase at all planets", _MODES),
    "translational": ("kind of mode: the central members move sideways and do not turn, in pairs at one frequency; "
                      "driven by mesh orders whose forces follow each other once round the planets", _MODES),
    "planet": ("kind of mode: only the planets move, the central members stand still; four planets or more; driven by "
               "mesh orders whose forces cancel in the central members", _MODES),
    "ring": ("kind of mode: only a ring's bending moves and no mesh is strained, so that no mesh order drives it; of N "
             "planets one of every pair of order n = jN, and for even N of n = jN + N/2", _MODES),
    "mixed": ("kind of mode: none of rotational, translational, planet and ring, as not every stage has equal, evenly "
              "spaced branches", _MODES),
    "together": ("phases of the meshes of a pair: all branches meet at the same place of the mesh cycle", _MODES),
    "in turn": ("phases of the meshes of a pair: each branch the same part of a cycle earlier or later than the one "
                "before", _MODES),
    "in opposite pairs": ("phases of the meshes of a pair: half of the branches half a cycle after the others", _MODES),
    "centrifugal": ("load m Omega^2 r_c of a planet in the frame of its carrier, which its bearing holds; counted by "
                    "steady, sweep and transient", _RESPONSE),
    "thrust": ("axial force of a helical mesh, F_n sin(beta_b); rows z of link_force hold it, and rx, ry its tilting "
               "moment", _RESPONSE),
    "axial": ("along z: rows z of supports and bearings hold the thrust of helical meshes", _RESPONSE),
    "iso6336": ("mean mesh stiffness by ISO 6336-1, method B", _FILE),
}  # fmt: skip
"""word -> (meaning, page)."""


def word_of(word: str) -> list[Explanation]:
    """What a word of a table means; its case does not count.  Empty where it is none."""
    named = [(name, *entry) for name, entry in WORDS.items() if name.casefold() == word.casefold()]
    return [Explanation(kind="word", name=name, meaning=meaning, page=page) for name, meaning, page in named[:1]]


# Words told at most where one is not known.
_NEAREST = 4


@checked
def explain(text: str) -> tuple[Explanation, ...]:
    """What a word means: unit, default, what is allowed, an example, and the page that says more.

    Parameters
    ----------
    text : a path of the model file (``stages.main.sun.support.radial``, without the stage, with ``*`` for a name, or
        its last keys), a variable of a result, a word of a table (``mean-load``, ``disc``), the code of a warning, a
        verb or a figure.

    Returns
    -------
    An explanation for each meaning: `speed` is a variable and a key of the file.

    Raises
    ------
    ModelError : nothing of that name; the nearest ones are told.
    """
    word = text.strip().strip("[]")
    found = [*_warning(word), *_verb(word), *_variable(word), *_figure(word), *word_of(word), *explained_paths(word)]
    if not found:
        near = [*mended_paths(word), *get_close_matches(word[:80], known_words(), n=_NEAREST, cutoff=0.6)]
        near = list(dict.fromkeys(near))[:_NEAREST]
        meant = f"; did you mean {' or '.join(near)}?" if near else ""
        allowed = "a path of the model file, a variable of a result, the code of a warning, a verb or a figure"
        raise ModelError(f"not known{meant}", path=text or '""', allowed=allowed)
    return tuple(found)


@cache
def known_words() -> tuple[str, ...]:
    """All codes, verbs, variables, figures, words of tables and keys of the model file."""
    figures = (name for names in FIGURES.values() for name in names)
    own = (name for _, name in OF_KIND)
    return tuple(
        dict.fromkeys([*WARNING_CODES, *map(_flat, records()), *VARIABLES, *own, *figures, *WORDS, *path_words()])
    )


def _flat(name: str) -> str:
    return name.replace("_", "-")


def _warning(word: str) -> Iterator[Explanation]:
    if entry := WARNING_CODES.get(word):
        yield Explanation(kind="warning", name=word, meaning=entry.meaning, cure=entry.cure, page=entry.page)


def _verb(word: str) -> Iterator[Explanation]:
    if verb := records().get(word.replace("-", "_")):
        shown = [entry[2].flag_of(name) for name, entry in keywords(verb.run).items()]
        yield Explanation(
            kind="verb",
            name=_flat(verb.name),
            meaning=help_of(verb).split("\n\n")[0],
            example=f"epicyclic {_flat(verb.name)} {'FILE' if verb.reads else 'ren2021'}",
            options=", ".join(flag for flag in shown if flag),
            page="verbs.md",
        )


@cache
def _kinds() -> dict[str, dict[str, list[str]]]:
    """Variable -> kind of result -> dims, as of the example results of the ready drive ren2021."""
    path = resources.files("epicyclic.results").joinpath("variable_kinds.json")
    found: dict[str, dict[str, list[str]]] = json.loads(path.read_text(encoding="utf-8"))
    return found


def _variable(word: str) -> Iterator[Explanation]:
    """One explanation for each meaning of a variable: some kinds of result have their own."""
    by_meaning: dict[tuple[str, str], list[str]] = {}
    kinds = _kinds().get(word, {})
    for kind in kinds:
        if entry := OF_KIND.get((kind, word)) or VARIABLES.get(word):
            by_meaning.setdefault(entry, []).append(kind)
    if not by_meaning and word in VARIABLES:
        by_meaning[VARIABLES[word]] = []
    for (unit, meaning), own in by_meaning.items():
        dims = dict.fromkeys(", ".join(kinds[kind]) or "none: one number" for kind in own)
        given = ", ".join(map(_flat, own)) or "models of other kinds than the ready drive ren2021"
        yield Explanation(
            kind="variable",
            name=word,
            meaning=meaning,
            unit="" if unit == "1" else unit,
            dims="; ".join(dims),
            given_by=given,
            page="variables.md",
        )


def _figure(word: str) -> Iterator[Explanation]:
    if kinds := [kind for kind, names in FIGURES.items() if word in names]:
        given = ", ".join(map(_flat, kinds))
        example = f"epicyclic {_flat(kinds[0])} ren2021 --figure {word} -o {word}.svg"
        yield Explanation(
            kind="figure",
            name=word,
            meaning=f"figure of a result of {given}, in the report and by --figure",
            example=example if kinds[0] in verbs() else "",
            given_by=given,
            page="take-away.md",
        )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Explanation:
    """One word explained; what it has not is empty.

    kind : path, variable, word, warning, verb or figure.  name : in full.  unit, default, allowed, example : of a path.
    dims, given_by : of a variable and a figure, the kinds of result that have it.  cure : of a warning.
    options : of a verb.  page : of the documentation, a file name.
    """

    kind: str
    name: str
    meaning: str
    unit: str = ""
    default: str = ""
    allowed: str = ""
    example: str = ""
    dims: str = ""
    given_by: str = ""
    cure: str = ""
    options: str = ""
    page: str = ""

    def as_dict(self) -> dict[str, str]:
        """What is known, by name."""
        return {name: value for name, value in asdict(self).items() if value}

    def rows(self) -> dict[str, str]:
        """Label -> text, in the order to read them, without kind and name."""
        texts = self.as_dict().items()
        return {name.replace("_", " "): text for name, text in texts if name not in ("kind", "name")}

    def __str__(self) -> str:
        rows = self.rows()
        width = max(map(len, rows), default=0)
        lines = (f"  {label:{width}}  {text}" for label, text in rows.items())
        return "\n".join([f"{self.name} ({self.kind})", *lines])

    __repr__ = __str__


Schema = Mapping[str, Any]
Path = tuple[str, ...]
# Bounds of a number as `Unit.describe` writes them.
_SPAN = r"above [^,]+|below [^,]+|up to [^,]+|[^,]+ or more[^,]*|[^,]+ to [^,]+"
ANY = "*"  # stands for a name of the user's
# Explanations of one word at most: a word like `radial` stands in many tables, which say the same.
_MOST = 4
# Lengths that are errors, plays and reliefs: some hundredths of a millimetre.
_SMALL = ("amount", "amplitude", "crown", "slope", "clearance", "backlash", "gap", "position", "run_out", "x", "y", "z")
# Names of tables as a person would write one in an example.
_NAMES: Mapping[Path, str] = {("stages",): "main", ("bodies",): "output", ("couplings",): "shaft", ("loads",): "weight"}
_EXAMPLES = {
    "m": '"50 mm"',
    "rad": '"20 deg"',
    "kg": '"12 kg"',
    "kg m^2": '"0.5 kg m^2"',
    "N/m": '"5e8 N/m"',
    "N/m^2": '"20 N/(mm um)"',
    "N m/rad": '"1e7 N m/rad"',
    "N s/m": '"1e4 N s/m"',
    "N m s/rad": '"1e3 N m s/rad"',
    "N m": '"800 N m"',
    "N": '"2 kN"',
    "W": '"750 kW"',
    "rad/s": '"1500 rpm"',
    "kg m": '"300 g mm"',
    "Pa": '"206 GPa"',
    "kg/m^3": '"7850 kg/m^3"',
    "N m^2": '"1e6 N m^2"',
    "1/s": '"5 1/s"',
    "s": '"2 us"',
    "m/s^2": '"[0, -9.81, 0] m/s^2"',
}


@cache
def schema() -> Schema:
    """The JSON Schema of the model file."""
    return json_schema()


@cache
def _nodes() -> Mapping[Path, Schema]:
    """Every path of a file with its schema; names of the user's are `ANY`.  A table within itself is left out."""
    found: dict[Path, Schema] = {}

    def visit(node: Schema, path: Path, above: tuple[str, ...]) -> None:
        # a member, or one of its sides
        member = len(path) >= 3 and path[0] == "stages" and set(path[3:]) <= set(SIDES)
        kind = KIND_BY_NAME.get(path[2], "") if member else ""
        for name, entry in children(node):
            if kind and name not in MEMBER_KEYS[kind]:
                continue
            own = (*path, name)
            reference = tuple(_references(entry))
            if own not in found:
                found[own] = entry
                if not set(reference) & set(above):
                    visit(entry, own, (*above, *reference))

    visit(schema(), (), ())
    return found


def _references(node: Schema) -> Iterator[str]:
    """Definitions of tables that a node refers to; texts hold no keys."""
    for form in (node, *node.get("anyOf", ())):
        if "$ref" in form and schema()["$defs"][form["$ref"].rpartition("/")[2]].get("type") != "string":
            yield form["$ref"]


def forms_of(node: Schema) -> Iterator[Schema]:
    """What a node may be, references followed."""
    for form in (node, *node.get("anyOf", ())):
        if "$ref" in form:
            yield from forms_of(schema()["$defs"][form["$ref"].rpartition("/")[2]])
        else:
            yield form


def children(node: Schema) -> Iterator[tuple[str, Schema]]:
    """Keys of a table with what may stand at each, `ANY` for a name of the user's."""
    for form in forms_of(node):
        yield from form.get("properties", {}).items()
        if isinstance(form.get("additionalProperties"), dict):
            yield ANY, form["additionalProperties"]


def explained_paths(text: str) -> list[Explanation]:
    """Explanations of a path, as a file has it, without the stage, with `*` for any name, or of its last keys alone."""
    words = tuple(part for part in text.strip().split(".") if part)
    if not words:
        return []
    if words[0] == ANY:  # the name of a stage
        words = ("stages", *words)
    found = _whole(words) or _whole(("stages", ANY, *words), within=2) or _ends(words)
    seen: dict[tuple[str, str], Explanation] = {}
    for path in found:
        entry = _explanation(path, words)
        seen.setdefault((entry.meaning, entry.unit), entry)
    return list(seen.values())[:_MOST]


def _whole(words: Path, *, within: int = 0) -> list[Path]:
    """Paths that the words name from the root on, those with fewest names of the user's first.

    within : words that were put before what was typed; what was typed must then hold a key of its own.
    """
    matches = [path for path in _ending(words[-1]) if len(path) == len(words) and all(map(_fits, path, words))]
    good = [path for path in matches if not _mistyped(path, words) and (not within or path[-1] != ANY)]
    least = min((path.count(ANY) for path in good), default=0)
    return [path for path in good if path.count(ANY) == least]


@cache
def _by_last() -> Mapping[str, tuple[Path, ...]]:
    """Paths by their last word."""
    found: dict[str, list[Path]] = {}
    for path in _nodes():
        found.setdefault(path[-1], []).append(path)
    return {word: tuple(paths) for word, paths in found.items()}


def _ending(word: str) -> tuple[Path, ...]:
    """Paths whose last word fits."""
    return tuple(_nodes()) if word == ANY else (*_by_last().get(word, ()), *_by_last()[ANY])


def _fits(own: str, word: str) -> bool:
    return own in (word, ANY) or word == ANY


def _mistyped(path: Path, words: Path) -> bool:
    """Whether a word that would be a name is rather a key with a slip: `radail` beside `radial`."""
    names = [(place, word) for place, word in enumerate(words) if path[place] == ANY and word != ANY]
    near = [(word, get_close_matches(word, _keys(path[:place]), n=1, cutoff=0.8)) for place, word in names]
    # planet_b is a second planet, planet the key itself
    return any(keys and (word == keys[0] or not word.startswith(keys[0])) for word, keys in near)


@cache
def _keys(path: Path) -> tuple[str, ...]:
    """Keys of the table at a path."""
    n = len(path)
    return tuple(own[n] for own in _nodes() if len(own) == n + 1 and own[:n] == path and own[n] != ANY)


def _ends(words: Path) -> list[Path]:
    """Paths that end with the words, shortest first."""
    n = len(words)
    keys = _by_last()
    # a first word may be a name of the user's, unless it is a key with a slip
    near = get_close_matches(words[0], keys, n=1, cutoff=0.75)
    named = n > 1 and words[0] != ANY and ("-" in words[0] or not near)
    long = [path for path in _ending(words[-1]) if len(path) >= n and ANY not in path[len(path) - n + named :]]
    found = [path for path in long if all(map(_fits, path[-n:], words))]
    return sorted(found, key=lambda path: (path.count(ANY), len(path)))


def mended_paths(text: str) -> list[str]:
    """Paths as they were typed, with one mistyped key put right, the nearest first."""
    words = tuple(part for part in text.strip().split(".") if part)
    found: dict[str, float] = {}
    for before in ((), ("stages", ANY)):
        whole = (*before, *words)
        for path in _nodes():
            if len(path) != len(whole):
                continue
            wrong = [i for i, (own, word) in enumerate(zip(path, whole, strict=True)) if not _fits(own, word)]
            if len(wrong) == 1 and (near := SequenceMatcher(None, path[wrong[0]], whole[wrong[0]]).ratio()) >= 0.7:
                mended = [own if i in wrong else word for i, (own, word) in enumerate(zip(path, whole, strict=True))]
                if explained_paths(".".join(mended)):
                    found.setdefault(".".join(mended[len(before) :]), near)
    return sorted(found, key=lambda path: -found[path])


def path_words() -> tuple[str, ...]:
    """Keys of all tables, and two of them joined: what a mistyped word is compared with."""
    words = dict.fromkeys(name for path in _nodes() for name in path if name != ANY)
    pairs = dict.fromkeys(".".join(path[-2:]) for path in _nodes() if len(path) > 1 and ANY not in path[-2:])
    members = ("sun", "planet", "ring", "carrier")
    longer = dict.fromkeys(".".join(path[2:]) for path in _nodes() if len(path) > 3 and path[2] in members)
    return (*words, *pairs, *(path for path in longer if ANY not in path))


# explanation of one path ---------------------------------------------------------------------------------------------


def _explanation(path: Path, words: Path) -> Explanation:
    node = _nodes()[path]
    of_table = (form["description"] for form in forms_of(node) if "description" in form)
    meaning, default, unit, span = _described(str(node.get("description") or next(of_table, "")))
    name, above = _filled(path, words), path[:-1]
    while not meaning and above:  # a value by names of the user's: what its table is
        meaning, above = _described(str(_nodes()[above].get("description", "")))[0], above[:-1]
    allowed = ", ".join(dict.fromkeys(words for form in forms_of(node) for words in _form_words(form)))
    return Explanation(
        kind="path",
        name=name,
        meaning=meaning,
        unit=unit,
        default=default,
        allowed=allowed + (f"; {span}" if span else ""),
        example=_example(path, name, node, unit),
        page="tolerance.md" if path[0] == "tolerance" else "model-file.md",
    )


def _filled(path: Path, words: Path) -> str:
    """The path with the names that were typed in place of those of the user's."""
    typed = (ANY,) * (len(path) - len(words)) + words
    return ".".join(word if own == ANY and word != ANY else own for own, word in zip(path, typed, strict=True))


def _described(text: str) -> tuple[str, str, str, str]:
    """Meaning, default, unit and bounds out of a description: `meaning; default D: quantity [unit]`."""
    quantities = "|".join(re.escape(kind.name) for kind in KINDS.values())
    found = re.search(rf"(?:^|: )((?:{quantities}) \[.*)$", text)
    head = text[: found.start()] if found else text
    unit = ", ".join(dict.fromkeys(re.findall(r"\[(.+?)\]", found[1]))) if found else ""
    span = re.search(rf"\], ({_SPAN})", found[1]) if found else None
    parts = " ".join(head.split()).split("; ")
    default = next((part.removeprefix("default ") for part in parts if part.startswith("default ")), "")
    meaning = "; ".join(part for part in parts if not part.startswith("default "))
    return meaning, default, "" if unit == "1" else unit, span[1] if span else ""


def _form_words(form: Schema) -> Iterator[str]:
    """What may stand there, in words."""
    kind, text = form.get("type"), str(form.get("description", ""))
    if "enum" in form:
        yield from ("0" if word == 0 else f'"{word}"' for word in form["enum"])
    elif "const" in form:
        yield str(form["const"])
    elif "properties" in form:
        keys = list(form["properties"])
        yield f"a table of {', '.join(keys[:8])}{', ...' if len(keys) > 8 else ''}"
    elif kind == "boolean":
        yield "true, false"
    elif kind == "string" and "pattern" in form:
        spelled, what = text.partition(", ")[2], "a list" if text.startswith("a list") else "a number"
        yield f"{what} in {spelled}" if spelled else "a number" if text == "number" else text
    elif kind in ("integer", "number"):
        low, high = form.get("minimum"), form.get("maximum")
        span = f", {low} to {high}" if high is not None else f", {low} or more" if low is not None else ""
        inf = low is not None and low > 1e300
        yield "inf" if inf else f"{'a whole number' if kind == 'integer' else 'a number'}{span}"
    elif kind in ("string", "array"):
        yield "a text" if kind == "string" else "a list"


def _example(path: Path, name: str, node: Schema, unit: str) -> str:
    """A line of a model file: out of a ready drive where one has the key, else made up from the unit."""
    for own, value, drive in _written():
        if len(own) == len(path) and all(map(_fits, path, own)):
            text = value_text(value)
            if isinstance(value, list) and len(value) > 4:
                text = f"{value_text(value[:4])[:-1]}, ...]"
            return f"{'.'.join(own)} = {text}  (ready drive {drive})"
    shown = ".".join(_NAMES.get(path[:i], "NAME") if word == ANY else word for i, word in enumerate(name.split(".")))
    first = unit.split(", ")[0]
    words = [word for form in forms_of(node) if form.get("type") == "string" for word in form.get("enum", ())]
    value = f'"{words[0]}"' if words else _EXAMPLES.get(first, "")
    if first == "m" and path[-1] in _SMALL:
        value = '"20 um"'
    if not value and any(form.get("type") == "boolean" for form in forms_of(node)):
        value = "true"
    return f"{shown} = {value}" if value else ""


@cache
def _written() -> tuple[tuple[Path, object, str], ...]:
    """Path, value and drive of all that the ready drives state, as it is written."""
    folder = resources.files("epicyclic.systems")
    drives = ("ren2021", *(name for name in ready_drives() if name != "ren2021"))
    files = {name: tomllib.loads(folder.joinpath(f"{name}.toml").read_text(encoding="utf-8")) for name in drives}
    return tuple((path, value, name) for name, file in files.items() for path, value in keyed(file))
