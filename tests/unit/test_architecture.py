"""The import arrows of docs/design.md, read from the source: who may import whom, no cycles, private names."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path

from tests.unit.package_source import PACKAGE, SOURCES, nodes_of, tree_of

ROOT = Path(__file__).parents[2]
MODULES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path for path in SOURCES if path.name != "__main__.py"
}
PYTHON = sorted([*SOURCES, *(ROOT / "tests").rglob("*.py"), *(ROOT / "examples").glob("*.py")])
# the table of rooms in docs/design.md: room -> the rooms it may import, at the top of a file or inside a function
DESIGN = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
# a room is a folder, or modules of one name in several: `questions/*/views`
ROWS = re.findall(r"^\| ((?:`[\w/*]+`(?:, )?)+) \|.*\|([^|]*)\|$", DESIGN, re.MULTILINE)
ALLOWED = {
    room.removesuffix("/"): set(re.findall(r"`([\w/*]+)`", arrows))
    for rooms, arrows in ROWS
    for room in re.findall(r"`([^`]+)`", rooms)
}
QUESTIONS = {room for room in ALLOWED if re.fullmatch(r"questions/\w+", room)}
for arrows in ALLOWED.values():
    arrows |= QUESTIONS if "questions" in arrows else set()
# rooms that are given a System, never a drawing
OF_A_SYSTEM = {"statics", *(room for room in QUESTIONS if not ALLOWED[room] & {"train", "document", "teeth"})}
# those may be imported everywhere
COMMON = set(re.findall(r"`(\w+)`", re.findall(r"^(`errors`.*) may be imported everywhere\.", DESIGN, re.MULTILINE)[0]))


def room_of(module: str) -> str:
    """The room that says most of where a module stands: a module of its own, folder of a question, folder."""
    path = module.removesuffix(".__init__").replace(".", "/")
    rooms = [room for room in ALLOWED if fnmatchcase(path, room) or fnmatchcase(path, f"{room}/*")]
    return max(rooms, key=lambda room: room.count("/"), default=path)


@cache
def imports(path: Path, module: str, *, top_level: bool = False) -> set[str]:
    """Modules of the package that a file imports, written from the package root; also those inside functions."""
    here = module.split(".") if path.name != "__init__.py" else [*module.split(".")[:-1], "__init__"]
    found: set[str] = set()
    for node in _at_import(tree_of(path)) if top_level else nodes_of(path):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = here[: len(here) - node.level]
            target = [*base, *(node.module.split(".") if node.module else [])]
            names = [".".join([*target, alias.name]) for alias in node.names]
            found |= {name if name in MODULES or f"{name}.__init__" in MODULES else ".".join(target) for name in names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module or ""} if (node.module or "").split(".")[0] == "epicyclic" else set()
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name.split(".")[0] == "epicyclic"}
    return {name for name in found if name}


def _at_import(tree: ast.AST) -> list[ast.AST]:
    """The nodes of what runs at import: no function bodies, nothing under TYPE_CHECKING."""
    nodes: list[ast.AST] = []
    for child in ast.iter_child_nodes(tree):
        typing_only = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
        if not typing_only and not isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            nodes += [child, *_at_import(child)]
    return nodes


def violations(module: str, imported: set[str]) -> set[str]:
    room = room_of(module)
    return {name for name in imported if room_of(name) not in ALLOWED[room] | COMMON | {room}}


def each(wrong: Callable[[str], set[str]], modules: Iterable[str] = MODULES) -> dict[str, set[str]]:
    """Module -> what is wrong with it, of those that have something."""
    return {module: found for module in modules if (found := wrong(module))}


def test_imports_follow_the_arrows() -> None:
    rooms = {room_of(name) for name in MODULES if name != "__init__"}
    assert rooms <= ALLOWED.keys(), "a new room: say in docs/design.md what it may import"
    inside = [name for name in MODULES if name != "__init__"]
    assert each(lambda module: violations(module, imports(MODULES[module], module)), inside) == {}


def beyond_the_system(module: str) -> set[str]:
    """What a module reaches through its imports and theirs, of rooms that know a Train or its teeth."""
    reached, todo = set[str](), [module]
    while todo:
        here = todo.pop()
        todo += [name for name in imports(MODULES[here], here) if name in MODULES and name not in reached]
        reached |= imports(MODULES[here], here)
    return {name for name in reached if room_of(name) not in OF_A_SYSTEM | {"engine", "system", "results"} | COMMON}


def test_an_analysis_knows_no_drawing() -> None:
    assert {"questions/response", "questions/contact_loss", "questions/sharing"} <= OF_A_SYSTEM
    assert each(beyond_the_system, [name for name in MODULES if room_of(name) in OF_A_SYSTEM]) == {}
    assert "train.train" in beyond_the_system("system.assembly")


def test_arrows_are_seen_to_fail() -> None:
    assert violations("questions.modes.modal", {"teeth.geometry"}) == {"teeth.geometry"}
    # an analysis knows no verb and no view, a view no analysis
    for above in ("questions.modes.verbs", "questions.modes.views", "statics.verbs", "verbs.record", "show.views"):
        assert violations("questions.modes.modal", {above}) == {above}
        assert violations("statics.static", {above}) == {above}
    assert violations("questions.modes.verbs", {"questions.modes.modal", "show.views"}) == {"show.views"}
    assert violations("questions.modes.views", {"questions.modes.modal", "show.tables"}) == {"questions.modes.modal"}
    assert violations("system.rows", {"epicyclic.train"}) == {"epicyclic.train"}  # the package root from inside


def drawn_with(path: Path, module: str) -> set[str]:
    """Libraries that draw which a module imports though its room may not import `show`."""
    nodes = [node for node in nodes_of(path) if isinstance(node, ast.Import | ast.ImportFrom)]
    names = {(getattr(node, "module", "") or alias.name).split(".")[0] for node in nodes for alias in node.names}
    room = room_of(module)
    return set() if room == "show" or "show" in ALLOWED[room] else names & {"plotly", "rich"}


def test_only_what_shows_results_draws(tmp_path: Path) -> None:
    inside = [name for name in MODULES if name != "__init__"]
    assert each(lambda module: drawn_with(MODULES[module], module), inside) == {}
    (tmp_path / "m.py").write_text("import rich\ndef f():\n    import plotly.graph_objects as go\n")
    assert drawn_with(tmp_path / "m.py", "questions.modes.modal") == {"plotly", "rich"}
    assert drawn_with(tmp_path / "m.py", "questions.modes.views") == set()


@cache
def imported_names(path: Path, module: str) -> set[tuple[str, str]]:
    """(module, name) of every name that a file imports out of a module of the package, inside functions too."""
    here = module.split(".") if path.name != "__init__.py" else [*module.split(".")[:-1], "__init__"]
    found: set[tuple[str, str]] = set()
    for node in nodes_of(path):
        if isinstance(node, ast.ImportFrom) and node.level:
            target = ".".join([*here[: len(here) - node.level], *(node.module or "").split(".")]).strip(".")
            found |= {
                (target, alias.name) for alias in node.names if f"{target}.{alias.name}".strip(".") not in MODULES
            }
    return found


def from_elsewhere(module: str) -> set[str]:
    """Names that a module imports from another one that does not define them."""
    return {
        f"{target}: {name}"
        for target, name in imported_names(MODULES[module], module)
        if target in MODULES and name not in defined_names(tree_of(MODULES[target]))
    }


def test_names_are_imported_from_where_they_are_defined() -> None:
    assert each(from_elsewhere) == {}


def private_of_others(module: str) -> set[str]:
    """A leading underscore is private: such names that a module imports, or asks another module for."""
    path = MODULES[module]
    named = {name for _, name in imported_names(path, module) if name.startswith("_") and not name.endswith("__")}
    modules = {target.split(".")[-1] for target in imports(path, module) if target in MODULES}
    asked = {
        ast.unparse(node)
        for node in nodes_of(path)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules
        if node.attr.startswith("_") and not node.attr.startswith("__")
    }
    return named | asked


def test_private_names_stay_in_their_module() -> None:
    assert each(private_of_others) == {}


def test_only_the_package_root_lists_its_names() -> None:
    assert [name for name, path in MODULES.items() if "\n__all__ = " in path.read_text(encoding="utf-8")] == [
        "__init__"
    ]


def test_the_number_that_is_followed_meets_functions_that_are_there() -> None:
    table = DESIGN.partition("## One number followed")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (`.*?`) \| (`.*?`) \|", table, re.MULTILINE)
    assert len(rows) > 10
    for files, names in rows:
        text = "".join((PACKAGE / name).read_text(encoding="utf-8") for name in re.findall("`(.*?)`", files))
        for name in re.findall("`(.*?)`", names):
            assert re.search(rf"\b(def|class) {name.split('.')[-1]}\b", text), f"{name} of {files}"


@cache
def defined_names(tree: ast.Module) -> set[str]:
    """Names that a module defines or assigns at its top."""
    found: set[str] = set()
    for node in _at_import(tree):
        if isinstance(node, ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return found | {node.name for node in tree.body if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)}


def test_a_re_export_and_a_private_name_are_seen(tmp_path: Path) -> None:
    assert defined_names(ast.parse("from .flank import Flank\nA = 1\ndef f(): pass")) == {"A", "f"}
    (tmp_path / "m.py").write_text("from ..teeth.flank import _depth, Flank\n")
    assert imported_names(tmp_path / "m.py", "system.m") == {("teeth.flank", "_depth"), ("teeth.flank", "Flank")}


def test_the_rooms_have_no_cycle() -> None:
    order: list[str] = []
    while len(order) < len(ALLOWED):
        ready = [room for room in ALLOWED if room not in order and ALLOWED[room] <= set(order)]
        assert ready, f"a cycle among {set(ALLOWED) - set(order)}"
        order += ready


def test_no_cycle_at_import() -> None:
    graph = {
        name.removesuffix(".__init__"): {
            target.removesuffix(".__init__") for target in imports(path, name, top_level=True)
        }
        for name, path in MODULES.items()
    }
    done: set[str] = set()
    while graph.keys() - done:
        ready = {name for name in graph.keys() - done if not (graph[name] & graph.keys()) - done - {name}}
        assert ready, f"modules that import each other: {sorted(graph.keys() - done)}"
        done |= ready


def test_one_name_is_one_class() -> None:
    homes: dict[str, list[str]] = {}
    for module, path in MODULES.items():
        for node in tree_of(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                homes.setdefault(node.name, []).append(module)
    assert {name: found for name, found in homes.items() if len(found) > 1} == {}


def test_the_package_exports_what_it_lists() -> None:
    import epicyclic

    for name in epicyclic.__all__:
        assert getattr(epicyclic, name) is not None
    assert set(epicyclic.__all__) <= set(dir(epicyclic))


def test_no_module_under_the_package_hides_a_public_function() -> None:
    """Importing a module sets its name in its package: one directly under the root must not be a public name."""
    import epicyclic

    assert {name.split(".")[0] for name in MODULES} & set(epicyclic.__all__) == set()


def test_sources_cited_are_in_the_bibliography() -> None:
    keys = set(re.findall(r"^@\w+\{(\w+),", (PACKAGE / "references.bib").read_text(encoding="utf-8"), re.MULTILINE))
    cited = {
        f"{path.name}: {key}"
        for path in PYTHON
        for key in re.findall(
            r"\[((?:[a-z]+(?:19|20)\d\d[a-z]?)|iso\d+)(?:[,;][^\]\n]*)?\]", path.read_text(encoding="utf-8")
        )
        if key not in keys
    }
    assert cited == set()
    assert {"lin1999", "kahraman1994", "ren2021", "iso6336", "iso21771"} <= keys


def prints(module: str) -> set[str]:
    calls = [node for node in nodes_of(MODULES[module]) if isinstance(node, ast.Call)]
    return {f"line {node.lineno}" for node in calls if isinstance(node.func, ast.Name) and node.func.id == "print"}


def test_nothing_prints() -> None:
    assert each(prints) == {}


# Functions of NumPy that came with 2.0 or later (its list of the array API and `trapezoid`); the floor is 1.26.
SINCE_NUMPY_2 = {
    *("acos", "acosh", "asin", "asinh", "astype", "atan", "atan2", "atanh", "bitwise_count", "concat", "isdtype"),
    *("cumulative_prod", "cumulative_sum", "matrix_transpose", "matvec", "permute_dims", "pow", "trapezoid"),
    *("unique_all", "unique_counts", "unique_inverse", "unique_values", "unstack", "vecdot", "vecmat"),
}


def of_numpy(path: Path) -> set[str]:
    return {
        node.attr
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "np"
    }


def test_numpy_is_no_newer_than_the_floor() -> None:
    assert '"numpy>=1.26"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    named = re.compile(rf"\bnp\s*\.\s*({'|'.join(SINCE_NUMPY_2)})\b")
    asking = [path for path in PYTHON if named.search(path.read_text(encoding="utf-8"))]  # it may be a word in a text
    newer = {str(path.relative_to(ROOT)): of_numpy(path) & SINCE_NUMPY_2 for path in asking}
    assert {path: names for path, names in newer.items() if names} == {}


def test_package_data_is_declared() -> None:
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    globs = project["tool"]["setuptools"]["package-data"]["epicyclic"]
    declared = {path for pattern in globs for path in PACKAGE.glob(pattern)}
    data = {
        path
        for path in PACKAGE.rglob("*")
        if path.is_file() and path.suffix != ".py" and "__pycache__" not in path.parts
    }
    assert data == declared
