"""The verbs tolerance and allocate."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from ...errors import ModelError
from ...limits import JUDGED_AT
from ...verbs.record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Overrides, Source


@bounded
def tolerance(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    samples: Annotated[int, Option("Number of samples, rounded up to a power of two.", least=1, most=2**40)] = 131_072,
    seed: Annotated[int, Option("The same seed, the same samples.", least=0)] = 1,
    limit: Annotated[
        Sequence[str] | Sequence[float],
        Option(
            "K_gamma whose exceedance is counted, or a table of limits; may be repeated, the first is the verdict's.",
            metavar="K",
            default="[limits] of the model, else IEC 61400-4",
        ),
    ] = (),
    method: Annotated[
        Literal["auto", "linear", "static"],
        Option("Contact closed where it stays closed, closed always, or solved for every sample."),
    ] = "auto",
    sampler: Annotated[Literal["sobol", "random"], Option("Scrambled Sobol sequences, or random numbers.")] = "sobol",
    effects: Annotated[
        Literal["none", "shares", "all"] | None,
        Option(
            "What buys what: shares of the variance, slopes and curves over spread and torque; all: over support "
            "stiffness and number of planets too.",
            default="all from 65536 samples, else shares",
        ),
    ] = None,
    reference: Annotated[
        Mapping[str, float] | Sequence[str],
        Option("A value to compare with, of your source: NAME=1.35; may be repeated.", metavar="NAME=K"),
    ] = (),
    worst: Annotated[
        str | Path | None, Option("Folder for model files of the worst samples.", metavar="DIR", default="none")
    ] = None,
    raw: Annotated[bool, Option("Keep K_gamma of every sample.")] = False,
    store: Annotated[
        str | Path | None, Option("Zarr store that keeps what is done.", metavar="DIR", default="none")
    ] = None,
    resume: Annotated[bool, Option("Go on with the store of a run that was stopped.")] = False,
    workers: Annotated[
        int | None, Option("Processes of a local cluster.", least=1, most=1000, default="this process")
    ] = None,
    scheduler: Annotated[
        str | None, Option("Dask scheduler, e.g. tcp://HOST:8786.", metavar="URL", default="none")
    ] = None,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """The mesh-load factor K_gamma as a distribution, from the tolerances of the drawing.

    The model states them in its table [tolerance]. Quantiles come with 95 % bands. With --store, Ctrl-C keeps what is
    done, and --resume goes on to the same bits, whatever the workers.

    Raises
    ------
    ModelError : the model or an option is wrong; no tolerance; a store of another job; no scheduler.
    """
    from .tolerance import tolerance as run

    return run(
        source,
        overrides=overrides,
        samples=samples,
        seed=seed,
        limits=limit,
        method=method,
        sampler=sampler,
        effects=effects,
        reference=_named(reference),
        worst=None if worst is None else Path(worst),
        raw=raw,
        store=None if store is None else Path(store),
        resume=resume,
        workers=workers,
        scheduler=scheduler,
        progress=progress,
    )


def _named(reference: Mapping[str, float] | Sequence[str]) -> dict[str, float]:
    """Name -> value of references.

    Raises
    ------
    ModelError : one is no ``NAME=K``, or K is no number above 0.
    """
    if not isinstance(reference, Mapping):
        pairs = [str(text).rpartition("=") for text in reference]
        for text, (name, equals, _) in zip(reference, pairs, strict=True):
            if not equals or not name.strip():
                raise ModelError("not a value with a name", path="reference", given=text, allowed="NAME=1.35")
        reference = {name.strip(): value for name, _, value in pairs}  # type: ignore[misc]
    values = {}
    for name, value in reference.items():
        try:
            values[str(name)] = number = float(value)
        except (TypeError, ValueError):
            raise ModelError("not a number", path="reference", given=value, allowed="a load factor, 1.15") from None
        if not 0 < number < float("inf"):
            raise ModelError("out of range", path="reference", given=number, allowed="above 0")
    return values


@bounded
def allocate(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    target: Annotated[
        float | None,
        Option(
            "K_gamma that is not to be exceeded, e.g. 1.15.",
            above=1,
            most=1000,
            default="smallest limit of its stages: [limits] of the model, else IEC 61400-4",
        ),
    ] = None,
    probability: Annotated[float, Option("Share of the trains that meet it.", least=0.01, most=0.999999)] = JUDGED_AT,
    definition: Annotated[
        Literal["mean-load", "mean-load-turning"], Option("Mean over the hunting period, or largest while turning.")
    ] = "mean-load",
    samples: Annotated[
        int, Option("Samples on which grades are compared, rounded up to a power of two.", least=256, most=2**20)
    ] = 16_384,
    seed: Annotated[int, Option("The same seed, the same samples; the next one verifies.", least=0)] = 1,
    method: Annotated[
        Literal["auto", "linear", "static"],
        Option("Contact closed where it stays closed, closed always, or solved for every sample."),
    ] = "auto",
    fresh_samples: Annotated[
        int, Option("Samples of the run that verifies the grades found.", least=256, most=2**30)
    ] = 131_072,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """The cheapest grades of the drawing that keep K_gamma below a target in a share of the trains.

    The model has prices of grades in [tolerance.cost]. With -o MODEL.toml the model is written with the grades found.

    Raises
    ------
    ModelError : the model or an option is wrong; no prices; a target that no grades reach.
    """
    from .allocation import allocate as run

    return run(
        source,
        overrides=overrides,
        target=target,
        probability=probability,
        definition=definition,
        samples=samples,
        seed=seed,
        method=method,
        fresh_samples=fresh_samples,
        progress=progress,
    )


def _model_text(result: "xr.Dataset") -> str:
    """The model with the grades found, as a model file."""
    from .allocation import allocated_model

    return allocated_model(result)


VERBS = (
    Verb(
        run=tolerance,
        gives=("tolerance",),
        examples=({"samples": 256, "effects": "all", "raw": True, "reference": ("table=1.25",)},),
        drawing=True,
        in_report=65,
    ),
    Verb(
        run=allocate,
        gives=("allocate",),
        examples=({"target": 1.5, "samples": 1024, "fresh_samples": 1024},),
        drawing=True,
        model_text=_model_text,
    ),
)
