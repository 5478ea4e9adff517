"""Tolerances of the drawing to distributions of the mesh-load factor: sampling, statistics, what each entry buys.

Options of its verbs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from ...limits import JUDGED_AT
from ...options import Option

SolvedContact = Annotated[
    Literal["auto", "linear", "static"],
    Option("Contact closed where it stays closed, closed always, or solved for every sample."),
]

FIGURES = {
    "allocate": ("grade-prices",),
    "tolerance": ("k-gamma", "tolerance-shares", "k-gamma-by-tolerance", "k-gamma-by-design", "worst-branches"),
}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToleranceOptions:
    """Options of the distribution of K_gamma."""

    samples: Annotated[int, Option("Number of samples, rounded up to a power of two.", least=1, most=2**40)] = 131_072
    seed: Annotated[int, Option("The same seed, the same samples.", least=0)] = 1
    limit: Annotated[
        Sequence[str] | Sequence[float],
        Option(
            "K_gamma whose exceedance is counted, or a table of limits; may be repeated, the first is the verdict's.",
            metavar="K",
            default="[limits] of the model, else IEC 61400-4",
        ),
    ] = ()
    method: SolvedContact = "auto"
    sampler: Annotated[Literal["sobol", "random"], Option("Scrambled Sobol sequences, or random numbers.")] = "sobol"
    effects: Annotated[
        Literal["none", "shares", "all"] | None,
        Option(
            "What buys what: shares of the variance, slopes and curves over spread and torque; all: over support "
            "stiffness and number of planets too.",
            default="all from 65536 samples, else shares",
        ),
    ] = None
    reference: Annotated[
        Mapping[str, float] | None,
        Option(
            "A value to compare with, of your source: NAME=1.35; may be repeated.",
            metavar="NAME=K",
            accepts=Mapping[str, float] | Sequence[str] | None,
            reads="references",
        ),
    ] = None
    worst: Annotated[
        str | Path | None, Option("Folder for model files of the worst samples.", metavar="DIR", default="none")
    ] = None
    raw: Annotated[bool, Option("Keep K_gamma of every sample.")] = False
    store: Annotated[
        str | Path | None, Option("Zarr store that keeps what is done.", metavar="DIR", default="none")
    ] = None
    resume: Annotated[bool, Option("Go on with the store of a run that was stopped.")] = False
    workers: Annotated[
        int | None, Option("Processes of a local cluster.", least=1, most=1000, default="this process")
    ] = None
    scheduler: Annotated[str | None, Option("Dask scheduler, e.g. tcp://HOST:8786.", metavar="URL", default="none")] = (
        None
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class AllocateOptions:
    """Options of the search for the cheapest grades."""

    target: Annotated[
        float | None,
        Option(
            "K_gamma that is not to be exceeded, e.g. 1.15.",
            above=1,
            most=1000,
            default="smallest limit of its stages: [limits] of the model, else IEC 61400-4",
        ),
    ] = None
    probability: Annotated[float, Option("Share of the trains that meet it.", least=0.01, most=0.999999)] = JUDGED_AT
    definition: Annotated[
        Literal["mean-load", "mean-load-turning"], Option("Mean over the hunting period, or largest while turning.")
    ] = "mean-load"
    samples: Annotated[
        int, Option("Samples on which grades are compared, rounded up to a power of two.", least=256, most=2**20)
    ] = 16_384
    seed: Annotated[int, Option("The same seed, the same samples; the next one verifies.", least=0)] = 1
    method: SolvedContact = "auto"
    fresh_samples: Annotated[
        int, Option("Samples of the run that verifies the grades found.", least=256, most=2**30)
    ] = 131_072
