"""Datasets of `tolerance` and `allocate` from the closed form of equal planets about a floating sun.

Loads 1 - (I - D D+) e with rows D = [1, cos psi, sin psi] and gaps e in units of F0 / k, one column of gaps an entry.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .train import array

__all__ = ["allocation", "tolerance"]

Array = NDArray[np.float64]
PATHS = ("deviations.main.planet.position.y", "deviations.main.planet.run_out", "deviations.main.planet.tooth_gap")
SPREADS = (0.18, 0.10, 0.05)  # [F0 / k]
PER_MICRON = 0.012  # [F0 / k per um]
PROBABILITY = (0.5, 0.9, 0.95, 0.99, 0.999)
SCALES = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)
DEFINITIONS = ("mean-load", "mean-load-turning")


def _draws(planets: int, samples: int = 4096) -> Array:
    """Loads that a gap of spread 1 of each entry adds, (entry, sample, planet)."""
    angle = 2 * np.pi * np.arange(planets) / planets
    rows = np.column_stack([np.ones(planets), np.cos(angle), np.sin(angle)])
    gaps = np.random.default_rng(7).standard_normal((len(PATHS), samples, planets))
    return np.asarray(gaps @ (rows @ np.linalg.pinv(rows) - np.eye(planets)))


def _factors(draws: Array, spreads: Array | tuple[float, ...]) -> Array:
    """Load of every planet (sample, planet)."""
    return np.asarray(1 + np.tensordot(np.asarray(spreads), draws, 1))


def _quantiles(draws: Array, spreads: Array | tuple[float, ...]) -> Array:
    return np.asarray(np.quantile(_factors(draws, spreads).max(axis=1), PROBABILITY))


def tolerance(planets: int = 5) -> xr.Dataset:
    """The Dataset of `tolerance`."""
    draws = _draws(planets)
    loads = _factors(draws, SPREADS)
    factors = loads.max(axis=1)
    quantile = _quantiles(draws, SPREADS)
    both = np.stack([quantile, 1 + 1.3 * (quantile - 1)])
    edges = np.linspace(1.0, 1.8, 401)
    counts = np.histogram(factors, edges)[0]
    worst = np.argsort(-factors)[:5]
    names = array(f"main/{pair}/{i + 1}" for pair in ("sun-planet", "ring-planet") for i in range(planets))
    by_mesh = np.quantile(loads, PROBABILITY, axis=0).T
    limits = np.array([1.15, 1.35])
    share = (factors[:, None] > limits).mean(axis=0)
    first, total = np.array([0.52, 0.16, 0.04]), np.array([0.76, 0.33, 0.12])
    slope = np.stack([_slopes(draws, quantile)] * 2)[:, None].repeat(2, axis=1)
    tenth = -0.1 * slope * np.array(SPREADS) / PER_MICRON * 1e-6
    variables = {
        "k_gamma_quantile": (("definition", "pair", "probability"), both[:, None].repeat(2, axis=1)),
        "system_k_gamma_quantile": (("definition", "probability"), both),
        "system_k_gamma_quantile_low": (("definition", "probability"), 1 + 0.98 * (both - 1)),
        "system_k_gamma_quantile_high": (("definition", "probability"), 1 + 1.02 * (both - 1)),
        "load_sharing_quantile": (("definition", "mesh", "probability"), np.stack([np.tile(by_mesh, (2, 1))] * 2)),
        "k_gamma_mean": (("definition", "pair"), np.full((2, 2), factors.mean())),
        "k_gamma_std": (("definition", "pair"), np.full((2, 2), factors.std())),
        "exceedance": (("definition", "pair", "limit"), np.broadcast_to(share, (2, 2, 2)).copy()),
        "separation_probability": ("mesh", np.tile((loads <= 0).mean(axis=0), 2)),
        "system_histogram": (("definition", "bin"), np.stack([counts, np.roll(counts, 15)])),
        "bin_edge": ("edge", edges),
        "system_exceedance": (("definition", "limit"), np.stack([share, share])),
        "system_separation_probability": ((), float((loads <= 0).any(axis=1).mean())),
        "worst_k_gamma": ("worst", factors[worst]),
        "worst_load_sharing": (("worst", "mesh"), np.tile(loads[worst], (1, 2))),
        "worst_overrides": ("worst", array("{}" for _ in worst)),
        **_with_bands("sobol_first", np.broadcast_to(first, (2, 2, 3)), ("definition", "pair", "tolerance"), 0.03),
        **_with_bands("sobol_total", np.broadcast_to(total, (2, 2, 3)), ("definition", "pair", "tolerance"), 0.02),
        **_with_bands("tenth_less", tenth, ("definition", "pair", "probability", "tolerance"), 1e-4),
        **_with_bands("system_tenth_less", tenth[:, 0], ("definition", "probability", "tolerance"), 1e-4),
        "tenth_less_place": ("tolerance", np.array([1, 2, 3])),
        "tenth_less_last_place": ("tolerance", np.array([1, 2, 3])),
        "quantile_slope": (("definition", "pair", "probability", "tolerance"), slope),
        "tolerance_unit": ("tolerance", array(["m"] * len(PATHS))),
        "tolerance_deviation": ("tolerance", np.array(SPREADS) / PER_MICRON * 1e-6),
        **_curves(draws),
    }
    coords = {
        "definition": array(DEFINITIONS),
        "pair": array(("main.meshes.sun-planet", "main.meshes.ring-planet")),
        "mesh": names,
        "probability": np.array(PROBABILITY),
        "limit": limits,
        "tolerance": array(PATHS),
        "scale": np.array(SCALES),
        "torque_scale": np.array(SCALES),
        "support": array(["stages.main.sun.support.radial"]),
        "support_scale": np.array([1e-2, 1e-1, 1.0, 10.0, 100.0]),
        "planets": np.arange(3, 8),
        "worst": np.arange(1, 6),
    }
    attrs = {
        **{"verb": "tolerance", "title": "Five planets", "warnings": "[]", "options": "{}", "samples": 4096},
        **{"done": 4096, "open": 3, "failed": 0, "seed": 1, "sampler": "sobol"},
        **{"ranked_pair": "", "ranking_samples": 4096},
    }
    return xr.Dataset(variables, coords, attrs)


def _with_bands(
    name: str, value: Array, over: tuple[str, ...], half: float
) -> dict[str, tuple[tuple[str, ...], Array]]:
    """An estimate and the ends of its band."""
    return {f"{name}{end}": (over, value + sign * half) for end, sign in (("", 0), ("_low", -1), ("_high", 1))}


def _slopes(draws: Array, quantile: Array) -> Array:
    """Change of the quantiles per spread of each entry (probability, entry) [1/m]."""
    step = 0.01
    moved = [_quantiles(draws, tuple(np.array(SPREADS) + step * (np.arange(3) == i))) for i in range(3)]
    return np.asarray((np.array(moved).T - quantile[:, None]) / step * PER_MICRON * 1e6)


def _curves(draws: Array) -> dict[str, tuple[tuple[str, ...], Array]]:
    spreads = np.array(SPREADS)
    pick = [0, 2, 3]
    scaled = [[spreads * np.where(np.arange(3) == i, s, 1) for s in SCALES] for i in range(3)]
    every = [_quantiles(_draws(n), SPREADS)[pick] if n > 3 else np.ones(3) for n in range(3, 8)]
    supports = [
        1 + (0.2 + 0.8 * x / (1 + x)) * (_quantiles(draws, SPREADS)[pick] - 1) for x in 10.0 ** np.arange(-2, 3)
    ]
    made = {
        "k_gamma_by_scale": (
            ("tolerance", "scale", "probability"),
            np.array([[_quantiles(draws, one) for one in row] for row in scaled]),
        ),
        "k_gamma_by_torque": (
            ("torque_scale", "probability"),
            np.array([_quantiles(draws, spreads / s) for s in SCALES]),
        ),
        "k_gamma_by_support": (("support", "support_scale", "probability"), _spread_out(np.array(supports))[None]),
        "support_stiffness": (("support", "support_scale"), 1e7 * 10.0 ** np.arange(-2, 3)[None]),
        "k_gamma_by_planets": (("planets", "probability"), _spread_out(np.array(every))),
    }
    return made


def _spread_out(values: Array) -> Array:
    """Curves of three probabilities among the five, nan elsewhere (x, probability)."""
    found = np.full((len(values), len(PROBABILITY)), np.nan)
    found[:, [0, 2, 3]] = values
    return found


def allocation() -> xr.Dataset:
    """The Dataset of `allocate`."""
    texts = ["normal(0, 6 um)", "rayleigh(10 um)", "normal(0, 4 um)"]
    finer, coarser = ["normal(0, 3 um)", "rayleigh(5 um)", ""], ["normal(0, 12 um)", "", "normal(0, 8 um)"]
    variables = {
        "drawn_grade": ("tolerance", array(["normal(0, 15 um)", "rayleigh(8 um)", "normal(0, 4 um)"])),
        "grade": ("tolerance", array(texts)),
        "price": ("tolerance", np.array([40.0, 12.0, 30.0])),
        "finer_grade": ("tolerance", array(finer)),
        "extra_cost": ("tolerance", np.array([60.0, 18.0, np.nan])),
        "finer_k_gamma": ("tolerance", np.array([1.098, 1.139, np.nan])),
        "coarser_grade": ("tolerance", array(coarser)),
        "saving": ("tolerance", np.array([22.0, np.nan, 14.0])),
        "coarser_k_gamma": ("tolerance", np.array([1.221, np.nan, 1.163])),
        "total_price": ((), np.array(82.0)),
        "price_bound": ((), np.array(82.0)),
        "target": ((), np.array(1.15)),
        "found_k_gamma": ((), np.array(1.147)),
        "drawn_grade_price": ("tolerance", np.array([np.nan, 9.0, 30.0])),
        "drawn_price": ((), np.array(np.nan)),
        "drawn_k_gamma": ((), np.array(1.262)),
        "reached_k_gamma": ((), np.array(1.1472)),
        "reached_k_gamma_low": ((), np.array(1.1466)),
        "reached_k_gamma_high": ((), np.array(1.1478)),
        "front_price": ("front", np.array([50.0, 64.0, 82.0, 120.0, 170.0])),
        "front_k_gamma": ("front", np.array([1.31, 1.22, 1.147, 1.11, 1.07])),
    }
    attrs = {
        **{"verb": "allocate", "title": "Five planets", "warnings": "[]", "options": "{}", "proof": "samples"},
        **{"linear": 1, "probability": 0.99, "definition": "mean-load", "samples": 16384, "seed": 1},
        **{"fresh_samples": 131072, "fresh_seed": 2, "tried": 612},
    }
    return xr.Dataset(variables, {"tolerance": array(PATHS)}, attrs)
