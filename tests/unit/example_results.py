"""Results of the examples of the verbs, each computed once for all tests of a process; nobody changes them."""

from __future__ import annotations

from functools import cache

import xarray as xr

from epicyclic.verbs.record import verbs

DRIVE = "ren2021"
PLACES = [(verb.name, place) for verb in verbs().values() for place in range(len(verb.examples))]
"""Name of the verb and place of the example of each."""


@cache
def example_result(verb: str, place: int) -> xr.Dataset:
    """The result of an example of a verb, of `DRIVE`."""
    return verbs()[verb].run(DRIVE, **verbs()[verb].examples[place])
