"""Exact linear algebra on small systems of fractions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

__all__ = ["least_norm", "null_space"]

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
