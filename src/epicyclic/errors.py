"""What can go wrong, as two kinds of error.

ModelError         the input is wrong: says the path in the file, what was given and what is allowed (exit status 2)
ConvergenceError   a solver did not converge (exit status 3)
"""

from __future__ import annotations

import re

_ABSENT = object()
# Characters of a word and of a text that a message shows: a file may have keys of a megabyte.
_WORD, _TEXT = 200, 6000


class ModelError(ValueError):
    """The input is wrong.

    Parameters
    ----------
    problem : what is wrong, in words.
    path : where, as a path in the model file, e.g. ``stages.main.sun.teeth``.
    given : what was given there.
    allowed : what may stand there.
    """

    def __init__(self, problem: str, *, path: str = "", given: object = _ABSENT, allowed: str = "") -> None:
        self.problem, self.path, self.given, self.allowed = problem, path, given, allowed
        where = path if given is _ABSENT else f"{path} = {_short(given)}"
        text = f"{where}: {problem}" if where else problem
        super().__init__(_cut(f"{text}; allowed: {allowed}" if allowed else text))

    def at(self, path: str) -> ModelError:
        """The same error at another path."""
        return ModelError(self.problem, path=path, given=self.given, allowed=self.allowed)


class ConvergenceError(RuntimeError):
    """A solver did not converge; the message says what to try."""


def _short(value: object) -> str:
    text = value if isinstance(value, str) else repr(value)
    text = text.replace("\n", " ")
    return text if len(text) <= 80 else text[:77] + "..."


def _cut(text: str) -> str:
    """A text without the middle of each long word, and without its own middle where it is long still."""
    text = re.sub(rf"\S{{{_WORD},}}", lambda word: _middle_left_out(word[0], _WORD), text)
    return _middle_left_out(text, _TEXT)


def _middle_left_out(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most // 2]}...{text[-most // 2 :]}"


def needs_turning() -> ModelError:
    """What to say of a locked train to a question that asks for speeds."""
    return ModelError(
        "the train is locked: no member turns, and this needs one that does",
        path="operation.held",
        allowed="fewer held members, and the speed of one that turns",
    )


def in_mm(length: float, digits: int = 6) -> str:
    """A length [m] as a message has it."""
    return f"{1e3 * length:.{digits}g} mm"
