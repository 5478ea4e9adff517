"""What can go wrong, as two kinds of error.

ModelError         the input is wrong: says the path in the file, what was given and what is allowed (exit status 2)
ConvergenceError   a solver did not converge (exit status 3)
"""

from __future__ import annotations

__all__ = ["ConvergenceError", "ModelError"]

_ABSENT = object()


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
        super().__init__(f"{text}; allowed: {allowed}" if allowed else text)

    def at(self, path: str) -> ModelError:
        """The same error at another path."""
        return ModelError(self.problem, path=path, given=self.given, allowed=self.allowed)


class ConvergenceError(RuntimeError):
    """A solver did not converge; the message says what to try."""


def _short(value: object) -> str:
    text = value if isinstance(value, str) else repr(value)
    text = text.replace("\n", " ")
    return text if len(text) <= 80 else text[:77] + "..."
