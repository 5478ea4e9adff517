"""Move and merge modules of the package by a plan, and rewrite every import of them.

    python benchmarks/move_modules.py PLAN [--room teeth] [--check]

PLAN is a TOML file:

    [modules]                                  # new module = old modules, in the order of their text
    "teeth.geometry" = ["gears.involute", "gears.geometry"]
    [docstrings]                               # first line of new modules; those of the old ones follow
    "teeth.geometry" = "Geometry of gears."
    [names]                                    # module-level names that two old modules of one new module share
    "gears.flank:_check" = "_check_flank"

Text stands as it was, but for imports, `__all__` and the docstrings of modules.  What one module imported from another
of the same new module is dropped, and so is `__all__`.  Texts of the project that name an old module behind the name of
the package, or by its file, are rewritten; other words that meant a module are found by reading.
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "epicyclic"
TEXTS = ("*.md", "*.toml", "*.py", "*.pyi", "*.bib", "*.js", "Makefile", "*.cff")
FOLDERS = ("src", "tests", "benchmarks", "docs", "examples")


class PlanError(SystemExit):
    """The plan cannot be carried out."""


@dataclass
class Plan:
    """New module -> old modules; docstrings; (old module, name) -> new name."""

    modules: dict[str, list[str]]
    docstrings: dict[str, str]
    names: dict[tuple[str, str], str]
    home: dict[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, path: Path, room: str = "") -> Plan:
        text = tomllib.loads(path.read_text(encoding="utf-8"))
        names = {tuple(key.split(":")): value for key, value in text.get("names", {}).items()}
        modules = {new: olds for new, olds in text["modules"].items() if not room or f"{new}.".startswith(f"{room}.")}
        plan = cls(modules, text.get("docstrings", {}), names)
        plan.home = {old: new for new, olds in plan.modules.items() for old in olds}
        if twice := [old for old, n in Counter(o for olds in plan.modules.values() for o in olds).items() if n > 1]:
            raise PlanError(f"in two modules: {twice}")
        if gone := [old for old in plan.home if not path_of(old).exists()]:
            raise PlanError(f"no such module: {gone}")
        return plan


def path_of(module: str) -> Path:
    """File of a module named from the package root; of a folder its `__init__`."""
    plain = PACKAGE.joinpath(*module.split(".")).with_suffix(".py")
    return (
        plain
        if plain.exists() or not (plain.with_suffix("") / "__init__.py").exists()
        else plain.with_suffix("") / "__init__.py"
    )


def module_of(path: Path) -> tuple[list[str], bool]:
    """Parts of the name of a module of the package, and whether it is a folder's `__init__`."""
    parts = list(path.relative_to(PACKAGE).with_suffix("").parts)
    return (parts[:-1], True) if parts[-1] == "__init__" else (parts, False)


def target_of(node: ast.ImportFrom, here: list[str] | None, folder: bool) -> str | None:
    """Module of the package that an import names, from the package root ('' the root itself); None of others."""
    if node.level:
        if here is None:
            return None
        base = here[: len(here) - node.level + folder]
        return ".".join([*base, *(node.module or "").split(".")]).strip(".")
    name = node.module or ""
    if name == "epicyclic" or name.startswith("epicyclic."):
        return name.removeprefix("epicyclic").lstrip(".")
    return None


def relative(target: str, here: list[str], folder: bool) -> str:
    """Import text of a module of the package seen from another one."""
    package = here if folder else here[:-1]
    parts = target.split(".") if target else []
    same = 0
    while same < min(len(package), len(parts)) and package[same] == parts[same]:
        same += 1
    return "." * (len(package) - same + 1) + ".".join(parts[same:])


@dataclass
class Edit:
    """Replacement of the text from `start` to `end`, places in the text."""

    start: int
    end: int
    text: str


class Source:
    """One file with its tree and places of its nodes."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.text = path.read_text(encoding="utf-8")
        self.tree = ast.parse(self.text)
        self.starts = [0]
        for line in self.text.encode().splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.bytes = self.text.encode()

    def span(self, node: ast.AST) -> tuple[int, int]:
        return self.starts[node.lineno - 1] + node.col_offset, self.starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]

    def applied(self, edits: list[Edit]) -> str:
        out, place = [], 0
        for edit in sorted(edits, key=lambda one: one.start):
            if edit.start < place:
                raise PlanError(f"{self.path}: edits overlap")
            out += [self.bytes[place : edit.start].decode(), edit.text]
            place = edit.end
        return "".join([*out, self.bytes[place:].decode()])


def bound_names(tree: ast.Module) -> dict[str, str]:
    """Module-level name -> what binds it: a definition, or ``module:name`` of an import as written."""
    bound: dict[str, str] = {}
    for node in top_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            bound[node.name] = "def"
        elif isinstance(node, ast.Import | ast.ImportFrom):
            continue
        elif isinstance(
            node,
            ast.Assign | ast.AnnAssign | ast.AugAssign | ast.For | ast.With,
        ):
            for name in ast.walk(node):
                if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store):
                    bound[name.id] = "value"
    bound.pop("__all__", None)
    return bound


def top_nodes(tree: ast.Module) -> Iterator[ast.stmt]:
    """Nodes at the top of a module, those under `if` and `try` too."""
    todo = list(tree.body)
    while todo:
        node = todo.pop(0)
        yield node
        if isinstance(node, ast.If | ast.Try):
            for part in ("body", "orelse", "finalbody"):
                todo += getattr(node, part, [])
            for handler in getattr(node, "handlers", []):
                todo += handler.body


def local_names(tree: ast.Module) -> set[str]:
    """Names that some function of a module binds for itself."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            arguments = node.args
            found |= {a.arg for a in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]}
            found |= {a.arg for a in (arguments.vararg, arguments.kwarg) if a}
            for inner in ast.walk(node):
                if isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Store):
                    found.add(inner.id)
                elif isinstance(inner, ast.ImportFrom):
                    found |= {alias.asname or alias.name for alias in inner.names}
    return found


def import_text(target: str, aliases: list[ast.alias], indent: str) -> str:
    names = [a.name + (f" as {a.asname}" if a.asname else "") for a in aliases]
    if len(names) == 1:
        return f"from {target} import {names[0]}"
    return f"from {target} import ({', '.join(names)})"


class Rewriter:
    """Imports of one file, rewritten to the new homes."""

    def __init__(self, plan: Plan, source: Source, here: list[str] | None, folder: bool, new: str | None) -> None:
        self.plan, self.source, self.here, self.folder, self.new = plan, source, here, folder, new
        self.old = ".".join(here) if here is not None else None
        self.renamed: dict[str, str] = {}  # name of a module as the file binds it -> its new name
        self.inlined: set[str] = set()  # names of modules that are this very module now
        self.notes: list[str] = []

    def new_text(self, target: str) -> str:
        """Import text of a new module as this file must write it."""
        if self.here is None:
            return f"epicyclic.{target}" if target else "epicyclic"
        here = self.new.split(".") if self.new else self.here
        return relative(target, here, self.folder and self.new is None)

    def statement(self, node: ast.ImportFrom, indent: str) -> str | None:
        """New text of an import, '' where it is dropped; None where it stays."""
        target = target_of(node, self.here, self.folder)
        if target is None:
            return None
        groups: dict[str, list[ast.alias]] = defaultdict(list)
        for alias in node.names:
            full = f"{target}.{alias.name}".strip(".")
            if full in self.plan.home:  # a module is imported by its name
                new = self.plan.home[full]
                room, _, last = new.rpartition(".")
                local = alias.asname or alias.name
                if new == self.new:
                    self.inlined.add(local)
                    continue
                if alias.asname is None and last != alias.name:
                    self.renamed[local] = last
                groups[room].append(ast.alias(last, alias.asname))
            elif target in self.plan.home:
                new = self.plan.home[target]
                name = self.plan.names.get((target, alias.name), alias.name)
                known = alias.asname or (alias.name if name != alias.name else None)
                if new == self.new:
                    if known and known != name:
                        self.notes.append(f"{self.source.path}:{node.lineno}: {name} was {known} here")
                    continue
                stub = self.source.path.suffix == ".pyi"  # there `as` says that the name is given on
                groups[new].append(ast.alias(name, known if known != name or stub else None))
            else:
                groups[target].append(alias)
        if not groups and node.names:
            return ""
        stays = list(groups) == [target] and groups[target] == node.names
        if stays and self.new_text(target) == "." * node.level + (node.module or ""):
            return None
        return f"\n{indent}".join(import_text(self.new_text(g), a, indent) for g, a in groups.items())

    def edits(self, *, skip: set[ast.AST] = frozenset()) -> list[Edit]:  # type: ignore[assignment]
        source, out = self.source, []
        for node in ast.walk(source.tree):
            if isinstance(node, ast.ImportFrom) and node not in skip:
                start, end = source.span(node)
                line = source.bytes[source.starts[node.lineno - 1] : start].decode()
                indent = line if not line.strip() else ""
                text = self.statement(node, indent)
                if text is None:
                    continue
                if text == "":
                    start = source.starts[node.lineno - 1] if not line.strip() else start
                    end = source.starts[node.end_lineno or node.lineno] if not line.strip() else end
                    out.append(Edit(start, end, "" if not self.only_statement(node) else f"{line}pass\n"))
                elif text != source.bytes[start:end].decode():
                    out.append(Edit(start, end, text))
            elif isinstance(node, ast.Import):
                for alias in node.names:
                    if alias.name.startswith("epicyclic."):
                        full = alias.name.removeprefix("epicyclic.")
                        if full in self.plan.home:
                            start, end = source.span(alias)
                            name = f"epicyclic.{self.plan.home[full]}"
                            out.append(Edit(start, end, name + (f" as {alias.asname}" if alias.asname else "")))
                            if not alias.asname:
                                self.notes.append(f"{source.path}:{node.lineno}: import {alias.name} without a name")
        taken = {n.id for n in ast.walk(source.tree) if isinstance(n, ast.Name)} | {
            a.arg for a in ast.walk(source.tree) if isinstance(a, ast.arg)
        }
        for old, new in list(self.renamed.items()):
            if new in taken:
                self.notes.append(f"{source.path}: module {old} is {new} now, a name taken here: by hand")
        for node in ast.walk(source.tree):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in self.inlined:
                start, _ = source.span(node)
                _, end = source.span(node)
                out.append(Edit(start, end, node.attr))
            elif isinstance(node, ast.Name) and node.id in self.renamed:
                out.append(Edit(*source.span(node), self.renamed[node.id]))
        return out

    def only_statement(self, node: ast.AST) -> bool:
        for parent in ast.walk(self.source.tree):
            for part in ("body", "orelse", "finalbody"):
                if getattr(parent, part, None) == [node]:
                    return True
        return False


def rename_edits(source: Source, module: str, plan: Plan) -> list[Edit]:
    """Uses of module-level names that the plan renames, in their own module."""
    names = {name: new for (home, name), new in plan.names.items() if home == module}
    if clash := names.keys() & local_names(source.tree):
        raise PlanError(f"{module}: {clash} are bound inside functions too")
    out = []
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Name) and node.id in names:
            out.append(Edit(*source.span(node), names[node.id]))
        elif isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name in names:
            start, _ = source.span(node)
            place = source.bytes.index(node.name.encode(), start)
            out.append(Edit(place, place + len(node.name), names[node.name]))
    return out


def header_nodes(tree: ast.Module) -> list[ast.stmt]:
    """Docstring, imports at the top, `TYPE_CHECKING` blocks of imports alone, `__all__`."""
    out = []
    for place, node in enumerate(tree.body):
        doc = place == 0 and isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        typing = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        listed = isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
        if doc or listed or isinstance(node, ast.Import | ast.ImportFrom) or typing:
            out.append(node)
    return out


def merged(plan: Plan, new: str) -> tuple[str, list[str]]:
    """Text of a new module, and notes."""
    olds = plan.modules[new]
    imports: list[str] = []
    typing: list[str] = []
    bodies: list[str] = []
    notes: list[str] = []
    docstring, lost = "", []
    homes: dict[str, str] = {}
    foreign: dict[str, str] = {}
    alike: set[str] = set()
    same: set[str] = set()
    for old in olds:
        source = Source(path_of(old))
        here, folder = module_of(source.path)
        rewriter = Rewriter(plan, source, here, folder, new)
        edits = rewriter.edits() + rename_edits(source, old, plan)
        cut = []
        for node in source.tree.body:  # an assignment that stands in a module before, word for word
            if isinstance(node, ast.Assign) and (text := ast.unparse(node)) in alike:
                cut.append((source.starts[node.lineno - 1], source.starts[node.end_lineno or node.lineno]))
                same |= {n.id for t in node.targets for n in ast.walk(t) if isinstance(n, ast.Name)}
            elif isinstance(node, ast.Assign):
                alike.add(text)
        for name in bound_names(source.tree):
            name = plan.names.get((old, name), name)
            if name in homes and name not in same:
                notes.append(f"{new}: {name} stands in {homes[name]} and {old}")
            homes[name] = old
        for name, origin in imported_names(source, rewriter, edits).items():
            if foreign.setdefault(name, origin) != origin:
                notes.append(f"{new}: {name} is imported from {foreign[name]} and {origin}")
        for node in header_nodes(source.tree):
            start, end = source.starts[node.lineno - 1], source.starts[node.end_lineno or node.lineno]
            if isinstance(node, ast.Expr):
                text = ast.get_docstring(source.tree, clean=False) or ""
                docstring = docstring or text
                lost += [text] if text != docstring else []
            elif isinstance(node, ast.If):
                inner = [e for e in edits if start <= e.start < end]
                whole = cut_text(source, start, end, inner)
                typing.append(whole.split("\n", 1)[1])
            elif isinstance(node, ast.Import | ast.ImportFrom):
                inner = [e for e in edits if start <= e.start < end]
                imports.append(cut_text(source, start, end, inner))
            cut.append((start, end))
        body = [e for e in edits if not any(a <= e.start < b for a, b in cut)]
        text = source.applied([*body, *(Edit(a, b, "") for a, b in set(cut))]).strip("\n")
        if text:
            bodies.append(text)
        notes += rewriter.notes
    notes += [
        f"{new}: {name} is defined here and imported from {foreign[name]}" for name in homes.keys() & foreign.keys()
    ]
    parts = [plan.docstrings[new]] if new in plan.docstrings else []
    doc = "\n\n".join([*parts, docstring.strip(), *(text.strip() for text in lost)])
    doc += "\n" if "\n" in doc else ""
    head = f'"""{doc}"""\n\n'
    if any("TYPE_CHECKING" in text for text in imports) and typing:
        block = "if TYPE_CHECKING:\n" + "".join(typing)
    else:
        block = ""
    future = "from __future__ import annotations\n"
    ordered = [i for i in imports if i != future]
    text = (
        head
        + (future + "\n" if future in imports else "")
        + "".join(dict.fromkeys(ordered))
        + "\n"
        + block
        + "\n"
        + "\n\n\n".join(bodies)
        + "\n"
    )
    if len(olds) > 1 and 0 < sum(future == i for i in imports) < sum(bool(b) for b in bodies):
        notes.append(f"{new}: {future.strip()} in some of its modules alone")
    return text, notes


def imported_names(source: Source, rewriter: Rewriter, edits: list[Edit]) -> dict[str, str]:
    """Name that an import binds anywhere in a module -> where it comes from; but for those dropped."""
    plan, found = rewriter.plan, {}
    for node in ast.walk(source.tree):
        if isinstance(node, ast.ImportFrom):
            target = target_of(node, rewriter.here, rewriter.folder)
            for alias in node.names:
                full = f"{target}.{alias.name}".strip(".")
                home = plan.home.get(full) or plan.home.get(target or "")
                if target is not None and home == rewriter.new:
                    continue
                name = alias.asname or alias.name
                if full in plan.home and alias.asname is None:
                    name = plan.home[full].rpartition(".")[2]
                found[name] = full if target is not None else f"{node.module}.{alias.name}"
        elif isinstance(node, ast.Import):
            for alias in node.names:
                found[alias.asname or alias.name.split(".")[0]] = (
                    alias.name.split(".")[0] if not alias.asname else alias.name
                )
    return found


def cut_text(source: Source, start: int, end: int, edits: list[Edit]) -> str:
    out, place = [], start
    for edit in sorted(edits, key=lambda one: one.start):
        out += [source.bytes[place : edit.start].decode(), edit.text]
        place = edit.end
    return "".join([*out, source.bytes[place:end].decode()])


def files() -> list[Path]:
    """Every Python file and stub of the project."""
    return sorted(p for folder in FOLDERS for kind in ("*.py", "*.pyi") for p in (ROOT / folder).rglob(kind))


def reworded(plan: Plan, text: str) -> str:
    """Texts that name old modules behind the package's name or as files."""
    for old, new in sorted(plan.home.items(), key=lambda pair: -len(pair[0])):
        text = re.sub(rf"\bepicyclic\.{re.escape(old)}\b(?!\.?\w*\()", f"epicyclic.{new}", text)
        slashed, moved = old.replace(".", "/"), new.replace(".", "/")
        text = re.sub(rf"(?<![\w/]){re.escape(slashed)}\.py\b", f"{moved}.py", text)
        text = text.replace(f"src/epicyclic/{slashed}.py", f"src/epicyclic/{moved}.py")
    return text


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan", type=Path)
    parser.add_argument("--room", default="", help="new modules below this name alone")
    parser.add_argument("--check", action="store_true", help="name the conflicts, write nothing")
    given = parser.parse_args()
    plan = Plan.read(given.plan, given.room)
    written: dict[Path, str] = {}
    notes: list[str] = []
    for new in plan.modules:
        text, found = merged(plan, new)
        notes += found
        written[PACKAGE.joinpath(*new.split(".")).with_suffix(".py")] = text
    gone = {path_of(old) for old in plan.home}
    for path in files():
        if path in gone:
            continue
        source = Source(path)
        inside = path.is_relative_to(PACKAGE)
        here, folder = module_of(path) if inside else (None, False)
        rewriter = Rewriter(plan, source, here, folder, None)
        edits = rewriter.edits()
        notes += rewriter.notes
        if edits:
            written[path] = source.applied(edits)
    for note in notes:
        print(note)
    if given.check:
        return int(bool(notes))
    for new, olds in plan.modules.items():
        target = PACKAGE.joinpath(*new.split(".")).with_suffix(".py")
        target.parent.mkdir(parents=True, exist_ok=True)
        longest = max(olds, key=lambda old: path_of(old).stat().st_size)
        if path_of(longest) != target:
            subprocess.run(["git", "mv", "-f", path_of(longest), target], check=True, cwd=ROOT)
        for old in olds:
            if path_of(old).exists() and path_of(old) != target:
                subprocess.run(["git", "rm", "-q", "-f", path_of(old)], check=True, cwd=ROOT)
    for path, text in written.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    for kind in TEXTS:
        for path in [*ROOT.glob(kind), *(p for f in FOLDERS for p in (ROOT / f).rglob(kind))]:
            before = path.read_text(encoding="utf-8")
            after = reworded(plan, before)
            if after != before:
                path.write_text(after, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
