"""`[tolerance.correlation]`: entries whose own draws are not independent, as a Gaussian copula of normal ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from .schema import Names, nearest
from .shorthand import one_path
from .tables import PlainTable
from .tolerances import Tolerance

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

# smallest eigenvalue that counts as positive: rounding of a matrix of ones is 1e-15, and a direction with a thousandth
# of a deviation (1e-6 of a variance) is a dependence, to be stated by one entry instead of two
_LEAST_EIGENVALUE = 1e-6
_FORM = '"PATH" = { "OTHER PATH" = 0.5 }, numbers between -1 and 1'


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Correlations:
    """Correlation of own draws.  paths : (m,) of the entries.  matrix : (m, m), positive definite, 1 on the diagonal.

    count : draws of each entry; the first of one belongs to the first of the others, and so on (planet by planet).
    """

    paths: tuple[str, ...]
    matrix: NDArray[np.float64]
    count: int

    def applied(self, u: NDArray[np.float64], first: Mapping[str, int]) -> NDArray[np.float64]:
        """Return uniform numbers, those of the correlated entries replaced by correlated ones.

        u : (S, d) independent, in (0, 1).  first : column of the first own draw of each path.  The uniform numbers
        become normal ones, these are mixed by the Cholesky factor of the matrix, and become uniform again.
        """
        import numpy as np
        from scipy.special import ndtr, ndtri

        mixed = np.array(u, float)
        factor = np.linalg.cholesky(self.matrix)
        for planet in range(self.count):
            columns = [first[path] + planet for path in self.paths]
            mixed[:, columns] = ndtr(ndtri(mixed[:, columns]) @ factor.T)
        return mixed


def read_correlations(table: object, entries: Mapping[str, Tolerance], names: Names) -> tuple[Correlations, ...]:
    """Return the correlated groups of `[tolerance.correlation]`, each of entries that hang together.

    entries : of `[tolerance]` by path.  Raises ModelError for a path without tolerance, for a distribution other than
    normal, for entries of differing numbers of draws, and for correlations that are not positive definite.
    """
    where = "tolerance.correlation"
    if not isinstance(table, dict):
        raise ModelError("not a table", path=where, given=repr(table), allowed=_FORM)
    pairs = _pairs(table, entries, names)
    groups: list[list[str]] = []
    for pair in pairs:
        joined = [group for group in groups if set(group) & set(pair)]
        merged = list(dict.fromkeys([path for group in joined for path in group] + list(pair)))
        groups = [group for group in groups if group not in joined] + [merged]
    return tuple(_group(group, pairs, entries) for group in groups)


def _pairs(table: PlainTable, entries: Mapping[str, Tolerance], names: Names) -> dict[tuple[str, str], float]:
    """Return the correlation of each pair of paths. Raises ModelError."""
    pairs: dict[tuple[str, str], float] = {}
    for first, inner in table.items():
        where = f"tolerance.correlation.{first}"
        if not isinstance(inner, dict) or not inner:
            raise ModelError("not a table of correlations", path=where, given=repr(inner), allowed=_FORM)
        for text, value in inner.items():
            second = one_path(text, names, f"{where}.{text[:80]}")
            _check_pair(first, second, value, entries)
            if {(first, second), (second, first)} & set(pairs):
                raise ModelError("given twice", path=f"{where}.{second}", given=value, allowed="one of the two")
            pairs[first, second] = float(value)
    return pairs


def _check_pair(first: str, second: str, value: Any, entries: Mapping[str, Tolerance]) -> None:
    """Raise ModelError for one correlation that is none."""

    def wrong(problem: str, allowed: str) -> ModelError:
        return ModelError(problem, path=f"tolerance.correlation.{first}.{second}", given=value, allowed=allowed)

    for path in (first, second):
        if path not in entries:
            raise wrong(f"no tolerance at {path}{nearest(path, entries)}", f"two of {', '.join(entries)}")
        own = entries[path].own
        if own is None or own.kind != "normal":
            raise wrong(f"the own draw of {path} is not normal", "normal distributions and grades of numbers")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not -1 < value < 1:
        raise wrong("not a correlation", "a number between -1 and 1")
    if first == second:
        raise wrong("of an entry with itself", "two entries")
    counts = [entries[path].count for path in (first, second)]
    if counts[0] != counts[1]:
        raise wrong(f"entries of {counts[0]} and {counts[1]} draws", "entries with the same number of draws")


def _group(paths: list[str], pairs: Mapping[tuple[str, str], float], entries: Mapping[str, Tolerance]) -> Correlations:
    """Return the correlations of one group. Raises ModelError where they are not positive definite."""
    import numpy as np

    matrix = np.eye(len(paths))
    for (first, second), value in pairs.items():
        if first in paths:
            i, j = paths.index(first), paths.index(second)
            matrix[i, j] = matrix[j, i] = value
    if (least := float(np.linalg.eigvalsh(matrix)[0])) < _LEAST_EIGENVALUE:
        given = ", ".join(f"{value:g}" for pair, value in pairs.items() if pair[0] in paths)
        problem = f"the correlations of {', '.join(paths)} are not positive definite (least eigenvalue {least:.3g})"
        allowed = "correlations that some set of random numbers can have; smaller ones"
        raise ModelError(problem, path=f"tolerance.correlation.{paths[0]}", given=given, allowed=allowed)
    return Correlations(paths=tuple(paths), matrix=matrix, count=entries[paths[0]].count)
