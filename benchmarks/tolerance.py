"""Tolerances at scale: time, memory and bytes of K_gamma as a distribution, against solving one sample at a time.

    python benchmarks/tolerance.py [--quick]

CPU seconds of one thread in a fresh process, all of the study but imports and reading the model; memory is its largest
resident set.  One at a time: the model file of one sample is read, assembled and solved by `sharing`, method static.
Bands: width of the 95 % band of the 95 % quantile of four planets round a floating sun, over the number of samples.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import table
from floating_sun import FloatingSun
from scipy.special import ndtri

import epicyclic
from epicyclic.engine.plan import Sampler, piece_uniforms, sampling_plan
from epicyclic.questions.tolerance.statistics import Band, SampleTally, piece_statistics

DRIVES = ("ren2021", "wind-five")
FEW = 2**13


def rows(quick: bool) -> list[table.Row]:
    """Both drives, large and small, then bands and store."""
    many = 2**17 if quick else 2**20
    found: list[table.Row] = []
    for name in DRIVES:
        large, small = _run("--study", name, str(many)), _run("--study", name, str(FEW))
        alone = _run("--alone", name, "5" if quick else "20")
        megabytes, ratio = large["megabytes"], alone["seconds"] / (large["seconds"] / many)
        found += [
            (f"{name}, {many} samples", f"{large['seconds']:.2f} s", "", f"{many / large['seconds']:.3g} samples/s"),
            table.judged("  memory", f"{megabytes:.0f} MB", "<= 1024 MB", megabytes <= 1024),
            table.judged("  one at a time / a sample of these", f"{ratio:.0f}", ">= 1000", ratio >= 1000),
            table.judged("  error against these", f"{alone['error']:.1e}", "<= 1e-08", alone["error"] <= 1e-8),
            table.judged(
                f"  {FEW} samples, shares and curves", f"{small['seconds']:.2f} s", "<= 1 s", small["seconds"] <= 1
            ),
        ]
    found += _band_rows(quick)
    stored = _run("--stored", DRIVES[0], str(2**16))
    found += [(f"{DRIVES[0]}, bytes a sample in a store", f"{stored['bytes']:.1f}", "", "")]
    return found


def _band_rows(quick: bool) -> list[table.Row]:
    sizes = [2**m for m in range(10, 17 if quick else 21, 2)]
    found = []
    for sampler in ("sobol", "random"):
        bands = [bands_of(size, sampler) for size in sizes]
        widths = [np.mean([band.high - band.low for band in one]) for one in bands]
        exponent = float(np.polyfit(np.log(sizes), np.log(widths), 1)[0])
        true = 1 + 0.5 * ndtri(0.975)
        held = np.mean([band.low <= true <= band.high for one in bands for band in one])
        met = -0.75 <= exponent <= -0.45
        text = f"2^10 .. 2^{int(np.log2(sizes[-1]))}"
        found += [
            table.judged(f"width of bands, {sampler}, {text}, exponent", f"{exponent:.2f}", "-0.75 .. -0.45", met),
            (f"  {len(bands) * len(bands[0])} bands of 95 % that hold the closed form", f"{held:.0%}", "", ""),
        ]
    return found


def bands_of(samples: int, sampler: Sampler, draws: int = 4) -> list[Band]:
    """Bands of the 95 % quantile of several draws of four Gaussian pins, sigma k / F0 = 1."""
    found, drawn = [], FloatingSun(4)
    for seed in range(draws):
        plan = sampling_plan(samples, seed=seed, sampler=sampler)
        tally = SampleTally(plan=plan, definitions=2, groups=1, meshes=4)
        for piece in range(plan.pieces):
            tally.add(piece, piece_statistics(drawn.evaluate(piece_uniforms(plan, piece, 4)), plan, piece))
        band = tally.quantile_bands(np.array([0.95]))
        found.append(Band(**{end: getattr(band, end)[0, 0, 0] for end in ("value", "low", "high")}))
    return found


def _run(*arguments: str) -> dict[str, float]:
    """What a fresh process measures."""
    command = [sys.executable, __file__, *arguments]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    result: dict[str, float] = json.loads(text)
    return result


def _study(name: str, samples: int) -> dict[str, float]:
    from scipy.stats import qmc  # noqa: F401, an import

    import epicyclic.questions.tolerance.tolerance as _warm  # noqa: F401, its imports are not timed

    train = epicyclic.load(name)
    clock = time.process_time()
    epicyclic.tolerance(train, samples=samples)
    took = time.process_time() - clock
    return {"seconds": took, "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}


def _alone(name: str, count: int) -> dict[str, float]:
    """Seconds of one sample solved by itself, and its largest error in K."""
    found = epicyclic.tolerance(name, samples=2**10, effects="none")
    changes = [json.loads(text) for text in found.worst_overrides.values.tolist()][:count]
    clock = time.process_time()
    values = [
        float(
            epicyclic.sharing(
                epicyclic.load(name, overrides={**one, "tolerance": None, "assumed": None}),
                method="static",
                cycles=1,
                samples=2,
            ).system_load_sharing.sel(definition="mean-load")
        )
        for one in changes
    ]
    took = (time.process_time() - clock) / len(changes)
    return {"seconds": took, "error": float(np.abs(np.array(values) - found.worst_k_gamma.values[:count]).max())}


def _stored(name: str, samples: int) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "store"
        epicyclic.tolerance(name, samples=samples, effects="none", store=store)
        size = sum(file.stat().st_size for file in store.rglob("*") if file.is_file())
    return {"bytes": size / samples}


def main() -> int:
    """Print the rows; exit status 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="an eighth of the samples")
    for kind in ("study", "alone", "stored"):
        parser.add_argument(f"--{kind}", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    for kind, measure in (("study", _study), ("alone", _alone), ("stored", _stored)):
        if wanted := getattr(given, kind):
            print(json.dumps(measure(wanted[0], int(wanted[1]))))
            return 0
    found = rows(given.quick)
    table.show(found)
    return int(bool(table.missed(found)))


if __name__ == "__main__":
    sys.exit(main())
