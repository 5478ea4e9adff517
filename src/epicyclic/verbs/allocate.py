"""The verb allocate."""

from typing import TYPE_CHECKING, Annotated, Literal

from .record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source


@bounded
def allocate(
    source: "Source",
    *,
    target: Annotated[float, Option("K_gamma that is not to be exceeded, e.g. 1.15.", above=1, most=1000)],
    overrides: "Overrides | None" = None,
    probability: Annotated[float, Option("Share of the trains that meet it.", least=0.01, most=0.999999)] = 0.99,
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
    from ..questions.tolerance.allocation import allocate as run

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
    from ..questions.tolerance.allocation import allocated_model

    return allocated_model(result)


VERB = Verb(
    run=allocate,
    gives=("allocate",),
    examples=({"target": 1.5, "samples": 1024, "fresh_samples": 1024},),
    drawing=True,
    model_text=_model_text,
)
