"""The one list of names of figures: that of every view, of every report, of `epicyclic.plot`."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import plotly.graph_objects as go
import pytest
import xarray as xr

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.show.plot import FIGURES, companions, figure_names, plot
from epicyclic.show.views import has_view, view_of
from epicyclic.verbs.record import records, verbs


def anchors(kind: str) -> set[str]:
    """Anchors of the drawings of a kind, as they stand in the functions of its view and those that they call."""
    view = view_of(kind)
    tree = ast.parse(Path(sys.modules[view.sections.__module__].__file__ or "").read_text(encoding="utf-8"))
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    todo, called = [view.sections.__name__, view.front.__name__], set[str]()
    while todo:
        name = todo.pop()
        if name in functions and name not in called:
            called.add(name)
            todo += [node.id for node in ast.walk(functions[name]) if isinstance(node, ast.Name)]
    calls = [node for name in called for node in ast.walk(functions[name]) if isinstance(node, ast.Call)]
    drawings = [call for call in calls if ast.unparse(call.func) == "Drawing"]
    return {ast.literal_eval(one.value) for call in drawings for one in call.keywords if one.arg == "anchor"}


@pytest.mark.parametrize("kind", sorted(FIGURES))
def test_the_list_is_that_of_the_views(kind: str) -> None:
    assert has_view(kind) or kind == "study"
    assert set(figure_names(kind)) == anchors(kind)
    assert len(set(figure_names(kind))) == len(figure_names(kind))


def test_every_kind_of_every_verb_has_its_names() -> None:
    kinds = {kind for verb in records().values() for kind in verb.gives}
    assert {kind for kind in kinds if has_view(kind)} <= set(FIGURES)
    assert figure_names("no kind of ours") == figure_names("study") == ("study",)
    assert set(figure_names()) == {name for kind in FIGURES for name in figure_names(kind)}


def test_companions_are_verbs() -> None:
    needed = {one for kind in FIGURES for name in figure_names(kind) for one in companions(kind, name)}
    assert needed <= set(verbs())


def drawn(name: str, *results: xr.Dataset) -> bool:
    """Whether the figure is there; a result may lack the variables of one."""
    try:
        return isinstance(plot(name, *results), go.Figure)
    except ModelError as error:
        return not error.problem.startswith("this result has nothing")


def test_every_figure_of_made_up_results_is_found_by_its_name(ren: dict[str, xr.Dataset]) -> None:
    few = {**ren, "modes": ren["modes"].isel(mode=slice(0, 4))}
    results = {str(one.attrs.get("verb", name)): one for name, one in few.items()}
    found = [
        drawn(name, result, *(results[one] for one in companions(kind, name)))
        for kind, result in results.items()
        for name in figure_names(kind)
        if result.attrs.get("verb") and set(companions(kind, name)) <= set(results)
    ]
    assert sum(found) >= 8


def test_the_figure_is_that_of_the_report() -> None:
    modes, check = epicyclic.modes("lin1999-n4"), epicyclic.check("lin1999-n4")
    titles = {name: plot(name, modes, check).layout.title.text for name in ("frequencies", "energy", "shapes", "front")}
    assert len(set(titles.values())) == 4
    with pytest.raises(ModelError, match="needs the result of check too"):
        plot("shapes", modes)
    with pytest.raises(ModelError, match="allowed: frequencies, shapes"):
        plot("nosuch", modes)
    with pytest.raises(ModelError, match="several results"):
        plot("energy", modes, modes)
    with pytest.raises(ModelError, match="no such figure"):
        plot("energy")
