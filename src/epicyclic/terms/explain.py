"""One word explained: a path of the model file, a variable, the code of a warning, a verb or a figure."""

from __future__ import annotations

import json
from difflib import get_close_matches
from functools import cache
from importlib import resources

from ..arguments import checked
from ..errors import ModelError
from ..results.variables import OF_KIND, VARIABLES
from ..show.plot import FIGURES
from ..verbs.record import help_of, keywords, verbs
from ..warning_codes import WARNING_CODES
from .explanation import Explanation
from .file_paths import explained_paths, mended_paths, path_words
from .words import WORDS, word_of

__all__ = ["explain", "known_words"]

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
