"""One word explained: a path of the model file, a variable, the code of a warning, a verb, a figure, or a term."""

from __future__ import annotations

import json
from difflib import get_close_matches
from functools import cache
from importlib import resources

from ..errors import ModelError
from ..results.variables import OF_KIND, VARIABLES
from ..show.plot import FIGURES
from ..user_input import checked
from ..verbs.record import help_of, keywords, verbs
from ..warning_codes import WARNING_CODES
from .file_paths import Explanation, explained_paths, mended_paths, path_words

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
    "normal": ("distribution of a tolerance: mean, standard deviation", _TOLERANCE),
    "uniform": ("distribution of a tolerance: every value between two ends alike", _TOLERANCE),
    "truncated": ("normal distribution cut at two ends: mean, standard deviation, low, high", _TOLERANCE),
    "triangular": ("distribution of a tolerance: low, most frequent value, high", _TOLERANCE),
    "rayleigh": ("length of a vector across the axis whose two components are normal with this standard deviation; "
                 "its phase is uniform", _TOLERANCE),
    "disc": ("vector across the axis, every point within a circle of this diameter alike: a position tolerance of a "
             "drawing", _TOLERANCE),
    "grade": ("tolerance by a standard: the size from ISO 1328-1 or ISO 286 (IT), read as so many standard deviations",
              _TOLERANCE),
    "rotational": ("kind of mode: all planets of a stage move alike and the central members only turn; driven by mesh "
                   "orders whose forces are in phase at all planets", _MODES),
    "translational": ("kind of mode: the central members move sideways and do not turn, in pairs at one frequency; "
                      "driven by mesh orders whose forces follow each other once round the planets", _MODES),
    "planet": ("kind of mode: only the planets move, the central members stand still; four planets or more; driven by "
               "mesh orders whose forces cancel in the central members", _MODES),
    "mixed": ("kind of mode: none of rotational, translational and planet, as not every stage has equal, evenly spaced "
              "branches", _MODES),
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
    known = {name.casefold(): name for name in WORDS}
    name = known.get(word.casefold())
    if name is None:
        return []
    meaning, page = WORDS[name]
    return [Explanation(kind="word", name=name, meaning=meaning, page=page)]


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
        dict.fromkeys([*WARNING_CODES, *map(_flat, verbs()), *VARIABLES, *own, *figures, *WORDS, *path_words()])
    )


def _flat(name: str) -> str:
    return name.replace("_", "-")


def _warning(word: str) -> list[Explanation]:
    entry = WARNING_CODES.get(word)
    if entry is None:
        return []
    return [Explanation(kind="warning", name=word, meaning=entry.meaning, cure=entry.cure, page=entry.page)]


def _verb(word: str) -> list[Explanation]:
    verb = verbs().get(word.replace("-", "_"))
    if verb is None:
        return []
    shown = [entry[2].flag_of(name) for name, entry in keywords(verb.run).items()]
    return [
        Explanation(
            kind="verb",
            name=_flat(verb.name),
            meaning=help_of(verb).split("\n\n")[0],
            example=f"epicyclic {_flat(verb.name)} ren2021",
            options=", ".join(flag for flag in shown if flag),
            page="verbs.md",
        )
    ]


@cache
def _kinds() -> dict[str, dict[str, list[str]]]:
    """Variable -> kind of result -> dims, as of the example results of the ready drive ren2021."""
    path = resources.files("epicyclic.results").joinpath("variable_kinds.json")
    found: dict[str, dict[str, list[str]]] = json.loads(path.read_text(encoding="utf-8"))
    return found


def _variable(word: str) -> list[Explanation]:
    """One explanation for each meaning of a variable: some kinds of result have their own."""
    by_meaning: dict[tuple[str, str], list[str]] = {}
    kinds = _kinds().get(word, {})
    for kind in kinds:
        entry = OF_KIND.get((kind, word)) or VARIABLES.get(word)
        if entry is not None:
            by_meaning.setdefault(entry, []).append(kind)
    if not by_meaning and word in VARIABLES:
        by_meaning[VARIABLES[word]] = []
    found = []
    for (unit, meaning), own in by_meaning.items():
        dims = dict.fromkeys(", ".join(kinds[kind]) or "none: one number" for kind in own)
        given = ", ".join(map(_flat, own)) or "models of other kinds than the ready drive ren2021"
        found.append(
            Explanation(
                kind="variable",
                name=word,
                meaning=meaning,
                unit="" if unit == "1" else unit,
                dims="; ".join(dims),
                given_by=given,
                page="variables.md",
            )
        )
    return found


def _figure(word: str) -> list[Explanation]:
    kinds = [kind for kind, names in FIGURES.items() if word in names]
    if not kinds:
        return []
    verb = _flat(kinds[0])
    meaning = f"figure of a result of {', '.join(map(_flat, kinds))}, in the report and by --figure"
    example = f"epicyclic {verb} ren2021 --figure {word} -o {word}.svg"
    return [
        Explanation(
            kind="figure",
            name=word,
            meaning=meaning,
            example=example if verb.replace("-", "_") in verbs() else "",
            given_by=", ".join(map(_flat, kinds)),
            page="take-away.md",
        )
    ]
