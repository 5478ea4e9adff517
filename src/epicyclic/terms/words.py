"""Words that are no path, variable or code: coefficients, definitions of load sharing, distributions."""

from __future__ import annotations

from .explanation import Explanation

__all__ = ["WORDS", "word_of"]

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
