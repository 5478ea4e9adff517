"""A script of somebody who uses the installed package; checked by mypy --strict and pyright, and run."""

import xarray as xr

import epicyclic


def lowest(model: str) -> float:
    """Lowest frequency [Hz] that is not zero."""
    train: epicyclic.Train = epicyclic.load(model)
    modes: xr.Dataset = epicyclic.modes(epicyclic.assemble(train), damped=False)
    frequency = modes["frequency"].values
    return float(frequency[frequency > 1].min())


def wrong() -> None:
    """Each line below is an error of types, which a checker must see."""
    epicyclic.modes("ren2021", damped="yes")  # ERROR
    epicyclic.sweep("ren2021", frame_speed="guess")  # ERROR
    epicyclic.modes("ren2021", nosuch=1)  # ERROR
    print(epicyclic.nosuch)  # ERROR


if __name__ == "__main__":
    print(f"{lowest('lin1999-n4'):.4f}", epicyclic.__version__)
