"""K_gamma as a distribution: tolerances of the drawing to quantiles, exceedance, worst samples, and what buys what."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...document.writer import model_text
from ...engine.block_store import BlockJob, hash_of, machine, run_blocks
from ...engine.plan import PIECE, Counted, SamplingPlan, piece_uniforms, require_time, sampling_plan, scramble_uniforms
from ...engine.workers import one_thread
from ...errors import ModelError
from ...limits import JUDGED_AT, KGammaLimit, k_gamma_limit, limit_columns, nearest_limit, stated_limit
from ...options import Progress
from ...results.dataset import dataset
from ...results.files import write_text
from ...statics.load_map import MEAN_LOADS
from ...statics.sample_loads import ContactMethod
from ...system.assembly import train_provenance
from ...train.resolution import load
from ...train.train import Train
from ...warning_codes import CodedText, coded
from . import ToleranceOptions
from .effects import effects_of, places, without_effect
from .statistics import CONFIDENCE, WIDTH, Array, Band, SampleTally, piece_statistics, probabilities_of
from .tolerance_map import ToleranceMap, tolerance_map

Effects = Literal["none", "shares", "all"]
Columns = dict[str, tuple[Any, Any]]

# numbers of raw samples that a Dataset may hold: 200 MB
_MOST_RAW = 25_000_000
# shortfall of a searched maximum that is said
_SHORTFALL = 1e-4
# samples beside the worst that are searched with many phases
_SEARCHED = 64
# samples from which curves with maps of their own (supports, planets) are small beside the sampling
_ALL_EFFECTS = 2**16
# share of the progress bar that the sampling takes where curves follow
_SAMPLING = 0.7
# Probabilities closer than this are one.
_ROUNDING = 1e-9
# Time of a sample of closed contact at least [s]; samples that tell how much longer links with laws take.
_SAMPLE_TIME, _TOLD = 5e-6, 4
# What all may take together [s]: a run with a store can be stopped and resumed; one without is lost when it is stopped.
_RESUMED, _LONGEST = 30 * 86_400.0, 3600.0


def tolerance(train: Train, options: ToleranceOptions, *, progress: Progress | None = None) -> xr.Dataset:
    """Distribution of the mesh-load factor of a train whose file has a table ``[tolerance]``.

    Parameters
    ----------
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : quantiles with bands, exceedance, separation, histogram, worst samples, shares and curves; kind
        ``tolerance``.

    Raises
    ------
    ModelError : a wrong model or option, no tolerance, a store of another job.
    """
    samples, seed, method, sampler = options.samples, options.seed, options.method, options.sampler
    raw, workers = options.raw, options.workers
    worst, store = (None if folder is None else Path(folder) for folder in (options.worst, options.store))
    plan = sampling_plan(samples, seed=seed, sampler=sampler)
    stated: list[float | str | None] = [stated_limit(value, "limit") for value in options.limit]
    if worst is not None:
        _make_folder(worst)  # before the work
    drawn = tolerance_map(train)
    by_limit = [pair_limits(drawn, train, value) for value in stated or [None]]
    if raw and store is None and plan.samples > _most_raw(drawn):
        raise ModelError(
            "raw samples do not fit in a result",
            path="raw",
            given=f"{plan.samples} samples",
            allowed=f"at most {_most_raw(drawn)} samples, or a store that keeps them",
        )
    _check_time(plan, drawn, method, workers=workers or 1, kept=store is not None)
    chosen = options.effects or ("all" if plan.samples >= _ALL_EFFECTS else "shares")
    job = BlockJob(
        verb="tolerance",
        identity={
            "model": dict(train.document),
            "samples": plan.samples,
            "rows": PIECE,
            "pieces": plan.pieces_of_block,
            "seed": seed,
            "sampler": sampler,
            "method": method,
            "bins": [WIDTH, "top"],
            "raw": raw,
        },
        count=plan.blocks,
        compute=partial(block_of_samples, drawn, plan, method, raw),
    )
    share = 1.0 if chosen == "none" else _SAMPLING
    with one_thread() as threads:
        blocks = run_blocks(
            job,
            store=store,
            resume=options.resume,
            workers=workers,
            scheduler=options.scheduler,
            progress=_part(progress, 0.0, share),
        )
        with closing(blocks):
            # arrays of a block have one row a piece
            pieces = (
                {name: array[i] for name, array in arrays.items()}
                for _, arrays in blocks
                for i in range(plan.pieces_of_block)
            )
            tally, rows = sampled(drawn, plan, pieces)
        further = effects_of(
            train,
            drawn,
            plan,
            chosen,
            method=method,
            probability=probabilities_of(plan.samples),
            progress=_part(progress, share, 1.0),
        )
        idle = without_effect(drawn, plan, method=method)
    columns, coords = _statistics(drawn, tally, np.unique([limit.value for limits in by_limit for limit in limits]))
    columns |= limit_columns("pair", by_limit[0])
    columns |= {**_worst_columns(train, drawn, tally, method, worst), **further.columns}
    judged = ""
    if chosen != "none":
        judged = _judged_pair(columns, coords)
        columns |= _places(columns, coords, judged)
    if reference := options.reference:
        columns["reference_k_gamma"] = ("reference", np.array(list(reference.values()), dtype=float))
        coords["reference"] = list(reference)
    if rows is not None:
        columns["k_gamma_sample"] = (("sample", "definition", "pair"), rows)
    result = dataset(
        columns,
        {**coords, **further.coords, "worst": np.arange(1, len(columns["worst_sample"][1]) + 1)},
        verb="tolerance",
        options={"samples": plan.samples, "seed": seed, "method": method, "sampler": sampler, "effects": chosen},
        provenance=train_provenance(train),
        warnings=[*drawn.warnings, *idle, *_warnings(tally, samples, float(columns["turning_shortfall"][1]))],
    )
    return result.assign_attrs(
        samples=plan.samples,
        done=tally.done,
        open=tally.open,
        failed=tally.failed,
        seed=seed,
        sampler=sampler,
        method=method,
        scrambles=plan.scrambles,
        confidence=CONFIDENCE,
        job=hash_of(job),
        machine=machine(),
        blas_threads=threads,
        left_out=json.dumps(further.left_out),
        effect_samples=further.samples,
        ranking_samples=further.ranked,
        ranked_pair=judged,
    )


def pair_limits(drawn: ToleranceMap, train: Train, stated: float | str | None) -> list[KGammaLimit]:
    """Limit of K_gamma of every pair and side, by its stage and the branches that share its load.

    stated : as of `k_gamma_limit`.
    """
    stages = [pair.split(".")[0] for pair in drawn.pair]
    return [
        k_gamma_limit(train.document, stage, len(group), stated=stated)
        for stage, group in zip(stages, drawn.group, strict=True)
    ]


def _part(progress: Progress | None, start: float, end: float) -> Progress | None:
    """Progress of one part of the work, from and to a share of the whole; counts stay those of the part."""
    if progress is None:
        return None

    def report(done: float) -> None:
        share = start + (end - start) * done
        if isinstance(done, Counted):
            counted = float.__new__(Counted, share)
            counted.done, counted.of = done.done, done.of
            share = counted
        progress(share)

    return report


def sampled(
    drawn: ToleranceMap, plan: SamplingPlan, pieces: Iterable[Mapping[str, NDArray[Any]]]
) -> tuple[SampleTally, Array | None]:
    """Statistics of all pieces, and raw K (samples, D, g) [1] where it was kept and fits in memory.

    Parameters
    ----------
    pieces : arrays of each in their order, as of `piece_of_samples`.
    """
    tally = SampleTally(plan=plan, definitions=len(MEAN_LOADS), groups=len(drawn.pair), meshes=len(drawn.mesh))
    raw: list[Array] = []
    fits = plan.samples <= _most_raw(drawn)
    for number, piece in enumerate(pieces):
        tally.add(number, piece)
        if "k" in piece and fits:
            raw.append(np.asarray(piece["k"]))
    return tally, np.concatenate(raw) if raw else None


def block_of_samples(
    drawn: ToleranceMap, plan: SamplingPlan, method: ContactMethod, raw: bool, block: int
) -> dict[str, NDArray[Any]]:
    """What the pieces of one block leave, each array with one row a piece: a function of the block's number alone."""
    first, count = block * plan.pieces_of_block, plan.pieces_of_block
    pieces = [piece_of_samples(drawn, plan, method, raw, piece) for piece in range(first, first + count)]
    return {name: np.stack([piece[name] for piece in pieces]) for name in pieces[0]}


def piece_of_samples(
    drawn: ToleranceMap, plan: SamplingPlan, method: ContactMethod, raw: bool, piece: int
) -> dict[str, NDArray[Any]]:
    """What one piece leaves: a function of its number alone; with `raw` also ``k`` (samples, D, g) [1]."""
    # samples with laws of their own are solved one by one: not those that only fill a piece up
    most = plan.together * plan.rows if drawn.plays else None
    with one_thread():
        values = drawn.evaluate(piece_uniforms(plan, piece, drawn.dimension_entry.size)[:most], method=method)
        arrays = piece_statistics(values, plan, piece)
    if raw:
        arrays["k"] = np.ascontiguousarray(values.k[: plan.together * plan.rows])
    return arrays


def _check_time(plan: SamplingPlan, drawn: ToleranceMap, method: ContactMethod, *, workers: int, kept: bool) -> None:
    """Refuse more samples than are done in an hour, or in a month where a store keeps what is done.

    Links with laws take as long as their play has it: a few samples say so.
    """
    each, longest = _SAMPLE_TIME, _RESUMED if kept else _LONGEST
    if drawn.lawful and method != "linear":
        u = piece_uniforms(plan, 0, drawn.dimension_entry.size)
        drawn.evaluate(u[:1], method=method)  # imports what the others only use
        begun = time.perf_counter()
        drawn.evaluate(u[:_TOLD], method=method)
        each = max(each, (time.perf_counter() - begun) / _TOLD)
    each /= workers
    most = f"at most {2 ** int(math.log2(max(longest / each, 1.0)))} of this train"
    require_time(
        each * plan.samples,
        longest,
        path="samples",
        given=plan.samples,
        allowed=most if kept else f"{most}, or more with a store that keeps what is done",
    )


def _most_raw(drawn: ToleranceMap) -> int:
    """Raw samples that a Dataset may hold."""
    return _MOST_RAW // (len(MEAN_LOADS) * len(drawn.pair))


def _statistics(drawn: ToleranceMap, tally: SampleTally, limit: Array) -> tuple[Columns, dict[Any, Any]]:
    """Variables of the samples and their coordinates."""
    probability = probabilities_of(tally.plan.samples)
    groups = len(drawn.pair)
    bands, above, apart = tally.quantile_bands(probability), tally.exceedance(limit), tally.separation()
    mean, spread = tally.mean_and_deviation()
    edges, counts = tally.histogram()
    columns: Columns = {
        "k_gamma_mean": (("definition", "pair"), mean[:, :-1]),
        "k_gamma_std": (("definition", "pair"), spread[:, :-1]),
        "system_k_gamma_mean": ("definition", mean[:, -1]),
        "system_k_gamma_std": ("definition", spread[:, -1]),
        "histogram": (("definition", "pair", "bin"), counts[:, :-1]),
        "system_histogram": (("definition", "bin"), counts[:, -1]),
        "bin_low": ("bin", edges[:-1]),
        "bin_high": ("bin", edges[1:]),
        "bin_edge": ("edge", edges),
    }
    for name, quantile, exceeded, separated in zip(("", "_low", "_high"), bands, above, apart, strict=True):
        columns |= {
            f"k_gamma_quantile{name}": (("definition", "pair", "probability"), quantile[:, :groups]),
            f"system_k_gamma_quantile{name}": (("definition", "probability"), quantile[:, groups]),
            f"load_sharing_quantile{name}": (("definition", "mesh", "probability"), quantile[:, groups + 1 :]),
            f"exceedance{name}": (("definition", "pair", "limit"), exceeded[:, :-1]),
            f"system_exceedance{name}": (("definition", "limit"), exceeded[:, -1]),
            f"separation_probability{name}": ("mesh", separated[:-1]),
            f"system_separation_probability{name}": ((), separated[-1]),
        }
    coords = {
        "definition": list(MEAN_LOADS),
        "pair": list(drawn.pair),
        "mesh": list(drawn.mesh),
        "probability": probability,
        "limit": limit,
    }
    return columns, coords


def _judged(coords: Mapping[Any, Any]) -> int:
    """Place of the probability at which K_gamma is held against its limit, or the next one that the samples tell."""
    return int(np.flatnonzero(np.asarray(coords["probability"]) <= JUDGED_AT + _ROUNDING)[-1])


def _judged_pair(columns: Columns, coords: Mapping[Any, Any]) -> str:
    """Pair that is nearest to its limit; "" where all have one limit, against which the train is held."""
    limits = columns["k_gamma_limit"][1]
    if len(set(limits)) == 1:
        return ""
    nearest = nearest_limit(columns["k_gamma_quantile"][1][0, :, _judged(coords)].tolist(), limits)
    return "" if nearest is None else str(coords["pair"][nearest])


def _places(columns: Columns, coords: Mapping[Any, Any], pair: str) -> Columns:
    """Places of the tolerances by what a tenth less of each takes off K_gamma that is held against its limit."""
    name, at = ("tenth_less", (coords["pair"].index(pair),)) if pair else ("system_tenth_less", ())
    first, last = places(Band(*(columns[name + end][1][0, *at, _judged(coords)] for end in ("", "_low", "_high"))))
    return {"tenth_less_place": ("tolerance", first), "tenth_less_last_place": ("tolerance", last)}


def _warnings(tally: SampleTally, asked: int, shortfall: float) -> list[CodedText]:
    """Samples that were rounded up or failed, and what the search for the largest load while turning leaves.

    shortfall : of that search where contact opens [1]; nothing is said of less than 1e-4.
    """
    plan, messages = tally.plan, []
    if plan.samples != asked:
        text = f"{asked} samples rounded up to {plan.samples}, {plan.scrambles} scrambles of {plan.rows}"
        messages.append(coded("points-rounded", text))
    if tally.failed:
        text = (
            f"{tally.failed} of {tally.done} samples have no solution, or no load of the nominal sense to share "
            "(a torque drawn at zero or beyond, a stiffness below zero or too far from others for "
            "double precision, a clearance that its link cannot have), and count nowhere"
        )
        messages.append(coded("points-failed", text))
    if shortfall >= _SHORTFALL:
        text = (
            f"the largest load while turning of {tally.open} samples whose contact opens is searched for and may "
            f"be low: by up to {100 * shortfall:.2g} % in those that were searched with four times as many slow "
            "phases"
        )
        messages.append(coded("turning-searched", text))
    return messages


# worst samples --------------------------------------------------------------------------------------------------------


def _worst_columns(
    train: Train, drawn: ToleranceMap, tally: SampleTally, method: ContactMethod, folder: Path | None
) -> Columns:
    """Variables of the worst samples, and how far their search falls short; model files of them in a folder."""
    plan, d = tally.plan, drawn.dimension_entry.size
    value, number = tally.worst()
    rows = [scramble_uniforms(plan, sample // plan.rows, d)[sample % plan.rows] for sample in number.tolist()]
    u = np.array(rows).reshape(-1, d)
    overrides = [drawn.overrides(row) for row in u]
    if folder is not None:
        _write_worst(folder, train, overrides, value, number)
    texts = [json.dumps(changes, default=str) for changes in overrides]
    return {
        "worst_k_gamma": ("worst", value),
        "worst_sample": ("worst", number),
        "worst_overrides": ("worst", np.array(texts, dtype=object)),
        "worst_load_sharing": (("worst", "mesh"), drawn.evaluate(u, method=method).load[:, 0]),
        "turning_shortfall": ((), _shortfall(drawn, plan, u, method)),
    }


def _shortfall(drawn: ToleranceMap, plan: SamplingPlan, worst: Array, method: ContactMethod) -> float:
    """Share by which K_gamma while turning of open samples rises with many slow phases [1]; worst : (n, d) of them.

    0 where links follow laws, which are asked at the same phases.
    """
    if drawn.lawful:
        return 0.0
    u = np.concatenate([worst, piece_uniforms(plan, 0, worst.shape[1])[:_SEARCHED]])
    values = drawn.evaluate(u, method=method)
    if not values.open.any():
        return 0.0
    dense = drawn.evaluate(u[values.open], method=method, dense=True).k[:, 1]
    return max(0.0, float(np.nanmax(dense / values.k[values.open, 1], initial=1.0)) - 1.0)


def _write_worst(
    folder: Path, train: Train, samples: Sequence[Mapping[str, object]], value: Array, number: NDArray[np.int64]
) -> None:
    """Write each sample as a model file ``worst-01.toml``, ``worst-02.toml``, ... that gives its value by itself.

    The worst is the first.  The files have no tolerances: what was drawn stands in the place of the nominal numbers,
    without reasons why those were assumed.

    Parameters
    ----------
    folder : of `_make_folder`.  samples : overrides of each.  value : K_gamma of the samples [1].  number : of them.

    Raises
    ------
    ModelError : a file cannot be written.
    """
    document = {name: table for name, table in train.document.items() if name not in ("tolerance", "assumed")}
    reasons = train.document.get("assumed", {})
    assert isinstance(reasons, Mapping)
    for place, (changes, k, sample) in enumerate(zip(samples, value.tolist(), number.tolist(), strict=True), start=1):
        drawn = [f"{path}." for path in (*changes, "tolerance")]
        kept = {
            path: reason
            for path, reason in reasons.items()
            if not any(f"{path}.".startswith(other) or other.startswith(f"{path}.") for other in drawn)
        }
        title = f"{train.title}, sample {sample}, K_gamma {k:.9g}"
        sample_train = load({**document, "assumed": kept} if kept else document, {**changes, "title": title})
        write_text(folder / f"worst-{place:02d}.toml", model_text(sample_train.document))


def _make_folder(folder: Path) -> None:
    """Make a folder where it is not there.

    Raises
    ------
    ModelError : it cannot be made, or something lies there, of which nothing is overwritten.
    """
    try:
        folder.mkdir(exist_ok=True)
        there = sorted(path.name for path in folder.iterdir())
    except OSError as error:
        problem = f"cannot be written: {error.strerror or error}"
        raise ModelError(problem, path="worst", given=str(folder), allowed="a folder") from error
    if there:
        problem = f"the folder is not empty ({there[0]})"
        raise ModelError(problem, path="worst", given=str(folder), allowed="a new or empty folder")
