"""Which spectral lines a sweep tells: shaft lines with their sidebands, and combinations of mesh frequencies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from .excitation import Excitation
from .lattice import Point

__all__ = ["Told", "told_lines"]

# Lines told at most: a row of each for every mesh and speed has to stay a small array.
_MOST = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """Lines in the order of their frequency.

    frequency : exact [Hz at the operating speed].  label : cause, and the mesh orders it is shifted by.
    """

    frequency: tuple[Fraction, ...]
    label: tuple[str, ...]


def told_lines(lines: Excitation, stages: Sequence[str], *, orders: int, shafts: bool) -> Told:
    """Lines around as many mesh orders as leave at most 32 of them; with one tone its multiples are not among them.

    stages : (D,) name of each tone.  orders : mesh orders told at most.  shafts : whether shaft lines count.
    """
    names = ["mesh"] if len(lines.tones) == 1 else [f"{stage} mesh" for stage in stages]
    found: dict[Fraction, str] = {}
    for shell in range(orders + 1):
        more = dict(found)
        for frequency, label in _shell(lines, names, shell, shafts=shafts):
            more.setdefault(frequency, label)
        if len(more) > _MOST and shell > 0:
            break
        found = more
    ordered = sorted(found.items())
    return Told(frequency=tuple(f for f, _ in ordered), label=tuple(label for _, label in ordered))


def _shell(lines: Excitation, names: Sequence[str], shell: int, *, shafts: bool) -> Iterator[tuple[Fraction, str]]:
    """Frequency and label of everything at points with |a_1| + .. + |a_D| = shell."""
    D = len(lines.tones)
    points = [p for p in product(range(-shell, shell + 1), repeat=D) if sum(map(abs, p)) == shell]
    for point in points:
        tone = sum((a * f for a, f in zip(point, lines.tones, strict=True)), Fraction(0))
        if D > 1 and tone > 0:
            yield tone, _label("", point, names)
        for shaft in lines.shaft if shafts else ():
            if shaft.frequency + tone != 0:
                yield abs(shaft.frequency + tone), _label("; ".join(shaft.causes), point, names)


def _label(cause: str, point: Point, names: Sequence[str]) -> str:
    parts = [cause, *(f"{a:+d} {name}" for a, name in zip(point, names, strict=True) if a)]
    return " ".join(part for part in parts if part)
