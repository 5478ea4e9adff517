"""What is told of one word."""

from __future__ import annotations

from dataclasses import asdict, dataclass

__all__ = ["Explanation"]

_LABELS = {
    "meaning": "meaning",
    "unit": "unit",
    "default": "default",
    "allowed": "allowed",
    "example": "example",
    "dims": "dims",
    "given_by": "given by",
    "cure": "cure",
    "options": "options",
    "page": "page",
}


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
        own = self.as_dict()
        return {label: own[name] for name, label in _LABELS.items() if name in own}

    def __str__(self) -> str:
        rows = self.rows()
        width = max(map(len, rows), default=0)
        lines = (f"  {label:{width}}  {text}" for label, text in rows.items())
        return "\n".join([f"{self.name} ({self.kind})", *lines])

    def __repr__(self) -> str:
        return str(self)
