"""Which spectral lines a sweep tells: shaft lines with their sidebands, and combinations of mesh frequencies."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from .excitation import Excitation
from .lattice import Point

__all__ = ["Told", "told_lines"]

# Lines of a kind told at most: a row of each for every mesh and speed has to stay a small array.
_MOST = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """Lines in the order of their frequency.

    frequency : exact [Hz at the operating speed].  label : cause, and the mesh orders it is shifted by.
    """

    frequency: tuple[Fraction, ...]
    label: tuple[str, ...]


def told_lines(lines: Excitation, stages: Sequence[str], *, orders: int, shafts: bool) -> Told:
    """At most 32 combinations of several mesh frequencies, and at most 32 shaft lines around mesh orders.

    With one tone its multiples are no combinations.  If even the shaft lines alone are more, they are all told.
    stages : (D,) name of each tone.  orders : mesh orders told at most.  shafts : whether shaft lines count.
    """
    names = ["mesh"] if len(lines.tones) == 1 else [f"{stage} mesh" for stage in stages]
    found: dict[Fraction, str] = {}
    if len(lines.tones) > 1:
        found |= _grown(lambda shell: _combinations(lines, names, shell), range(1, orders + 1))
    if shafts:
        sides = _grown(lambda shell: _sidebands(lines, names, shell), range(orders + 1))
        found = {**sides, **found}
    ordered = sorted(found.items())
    return Told(frequency=tuple(f for f, _ in ordered), label=tuple(label for _, label in ordered))


def _grown(shell_of: Callable[[int], Iterator[tuple[Fraction, str]]], shells: Sequence[int]) -> dict[Fraction, str]:
    """Frequency -> label, shell after shell, as long as there are not too many."""
    found: dict[Fraction, str] = {}
    for shell in shells:
        more = dict(found)
        for frequency, label in shell_of(shell):
            more.setdefault(frequency, label)
        if found and len(more) > _MOST:
            break
        found = more
    return found


def _combinations(lines: Excitation, names: Sequence[str], shell: int) -> Iterator[tuple[Fraction, str]]:
    for point, tone in _shell(lines, shell):
        if tone > 0:
            yield tone, _label("", point, names)


def _sidebands(lines: Excitation, names: Sequence[str], shell: int) -> Iterator[tuple[Fraction, str]]:
    for point, tone in _shell(lines, shell):
        for shaft in lines.shaft:
            if shaft.frequency + tone != 0:
                yield abs(shaft.frequency + tone), _label("; ".join(shaft.causes), point, names)


def _shell(lines: Excitation, shell: int) -> Iterator[tuple[Point, Fraction]]:
    """Points with |a_1| + .. + |a_D| = shell, and their frequencies."""
    for point in product(range(-shell, shell + 1), repeat=len(lines.tones)):
        if sum(map(abs, point)) == shell:
            yield point, sum((a * f for a, f in zip(point, lines.tones, strict=True)), Fraction(0))


def _label(cause: str, point: Point, names: Sequence[str]) -> str:
    parts = [cause, *(f"{a:+d} {name}" for a, name in zip(point, names, strict=True) if a)]
    return " ".join(part for part in parts if part)
