"""Exact linear algebra on small systems of fractions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

__all__ = ["least_norm", "null_space", "whole_solution"]

Row = list[Fraction]


def null_space(rows: Sequence[Sequence[Fraction]], order: Sequence[int]) -> dict[int, Row]:
    """Basis of the null space: vectors v (n,), rows @ v = 0, by the free unknown that is 1 in v and 0 in the others.

    rows : (m, n).  order : all n unknowns; later ones become free first.
    """
    reduced, pivots = _reduce([[row[j] for j in order] for row in rows], len(order))
    free = [j for j in range(len(order)) if j not in pivots]
    vectors: dict[int, Row] = {}
    for j in free:
        vector = [Fraction(0)] * len(order)
        vector[order[j]] = Fraction(1)
        for row, pivot in zip(reduced, pivots, strict=True):
            vector[order[pivot]] = -row[j]
        vectors[order[j]] = vector
    return vectors


def least_norm(rows: Sequence[Sequence[Fraction]], right: Sequence[Fraction]) -> Row | None:
    """Solution x (n,) of least norm of rows @ x = right, rows (m, n), right (m,); None where there is none."""
    count = len(rows[0]) if rows else 0
    reduced, pivots = _reduce([[*row, value] for row, value in zip(rows, right, strict=True)], count + 1)
    if count in pivots:
        return None
    solution = [Fraction(0)] * count
    for row, pivot in zip(reduced, pivots, strict=True):
        solution[pivot] = row[count]
    idle = list(null_space(rows, range(count)).values())
    if not idle:
        return solution
    # Take away the part along the null space: N (N^T N)^-1 N^T x.
    weights = least_norm([[_dot(u, v) for v in idle] for u in idle], [_dot(u, solution) for u in idle])
    if weights is None:  # never: N^T N of independent vectors is regular
        return None
    return [
        value - sum((w * v[j] for w, v in zip(weights, idle, strict=True)), Fraction(0))
        for j, value in enumerate(solution)
    ]


def whole_solution(rows: Sequence[Sequence[int]], count: int) -> tuple[list[Row], list[list[int]]]:
    """Solutions of rows @ x = right + whole numbers: (inverse, kernel) of rows (m, count), both exact.

    It has a solution exactly where every number of kernel @ right is whole; inverse @ right is one then, unknowns that
    may have any value being 0.  kernel (r, m) is a basis of all vectors y of whole numbers with y @ rows = 0, each with
    its last entry, positive, at a row of its own, later rows first.  It decides because such a basis maps whole numbers
    onto all whole numbers (Hermite normal form, by the algorithm of Euclid on the rows).
    """
    size = len(rows)
    tagged = [[*row, *(int(i == j) for j in range(size))] for i, row in enumerate(rows)]
    done, left = _whole_echelon(tagged, count)
    reduced, pivots = _reduce([[Fraction(value) for value in row] for row in done], count)
    inverse = [[Fraction(0)] * size for _ in range(count)]
    for row, pivot in zip(reduced, pivots, strict=True):
        inverse[pivot] = row[count:]
    backwards, _ = _whole_echelon([row[count:][::-1] for row in left], size)
    return inverse, [row[::-1] for row in backwards]


def _whole_echelon(rows: Sequence[list[int]], columns: int) -> tuple[list[list[int]], list[list[int]]]:
    """Row echelon form in the first columns by whole combinations that can be undone, and the rows that are 0 there."""
    left, done = list(rows), list[list[int]]()
    for column in range(columns):
        while some := [row for row in left if row[column]]:
            least = min(some, key=lambda row: abs(row[column]))
            left = [row if row is least else _less(row, least, row[column] // least[column]) for row in left]
            if len(some) == 1:
                done.append(least if least[column] > 0 else [-value for value in least])
                left = [row for row in left if row is not least]
    return done, left


def _less(row: list[int], other: list[int], times: int) -> list[int]:
    return [a - times * b for a, b in zip(row, other, strict=True)] if times else row


def _reduce(rows: Sequence[Row], columns: int) -> tuple[list[Row], list[int]]:
    """Reduced row echelon form without its zero rows, and its pivot columns."""
    left, done, pivots = [row for row in rows if any(row)], list[Row](), list[int]()
    for column in range(columns):
        found = next((row for row in left if row[column]), None)
        if found is None:
            continue
        left = [row for row in left if row is not found]
        pivot = [value / found[column] for value in found]
        done = [_eliminated(row, pivot, column) for row in done] + [pivot]
        left = [row for row in (_eliminated(row, pivot, column) for row in left) if any(row)]
        pivots.append(column)
    return done, pivots


def _eliminated(row: Row, pivot: Row, column: int) -> Row:
    factor = row[column]
    return [a - factor * b if b else a for a, b in zip(row, pivot, strict=True)] if factor else row


def _dot(a: Row, b: Row) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True) if x and y), Fraction(0))
