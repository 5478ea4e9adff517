"""Wheel and sdist: licence, data, console script, types seen from outside; the oldest dependencies."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
# no module: its errors of types are meant
CONSUMER = ROOT / "tests" / "files" / "consumer.txt"
# what the code reads beside its modules
DATA = ("py.typed", "__init__.pyi", "references.bib", "show/report.css", "systems/ren2021.toml")


def ran(*arguments: str | Path, **options: object) -> subprocess.CompletedProcess[str]:
    """What a command gives, in an environment that does not lead to the checkout."""
    clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "MYPYPATH")}
    return subprocess.run(arguments, capture_output=True, text=True, check=False, env=clean, **options)  # type: ignore[call-overload, no-any-return]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The wheel and the sdist that it is built from."""
    folder = tmp_path_factory.mktemp("built")
    source = tmp_path_factory.mktemp("source") / "epicyclic"
    files = ran("git", "-C", ROOT, "ls-files", "--cached", "--others", "--exclude-standard").stdout.splitlines()
    if not files:
        pytest.skip("needs the checkout, to build from its files alone")
    for name in files:
        if not (ROOT / name).is_file():
            continue
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_bytes((ROOT / name).read_bytes())
    own = tuple(map(int, version("setuptools").split(".")[:2])) >= (77, 1)
    made = ran(sys.executable, "-m", "build", *(["--no-isolation"] if own else []), "--outdir", folder, source)
    if made.returncode and not own:
        pytest.skip("needs setuptools 77.1 or an index to take it from")
    assert made.returncode == 0, made.stdout[-2000:] + made.stderr[-2000:]
    (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return wheel, sdist


@pytest.fixture(scope="module")
def installed(built: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Python of an environment of the wheel alone; it takes the dependencies from this one."""
    home = tmp_path_factory.mktemp("environment")
    venv.create(home)
    python = home / "bin" / "python"
    done = ran(
        *(sys.executable, "-m", "pip", "--python", python, "install"),
        *("--quiet", "--no-deps", "--no-index", "--no-compile", built[0]),
    )
    assert done.returncode == 0, done.stderr
    (site,) = home.glob("lib/python*/site-packages")
    (site / "dependencies.pth").write_text(f"{sysconfig.get_paths()['purelib']}\n", encoding="utf-8")
    return python


def test_the_wheel_has_licence_and_data(built: tuple[Path, Path]) -> None:
    with zipfile.ZipFile(built[0]) as wheel:
        names = wheel.namelist()
        (meta,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        head = wheel.read(meta).decode("utf-8").splitlines()
        (licence,) = (name for name in names if name.endswith(".dist-info/licenses/LICENSE"))
        assert wheel.read(licence) == (ROOT / "LICENSE").read_bytes()
    assert "License-Expression: BSD-3-Clause" in head
    assert "License-File: LICENSE" in head
    assert not any("License ::" in line for line in head)
    for name in DATA:
        assert f"epicyclic/{name}" in names
    # every file beside the modules comes along, and nothing else does
    beside = {
        f"epicyclic/{path.relative_to(ROOT / 'src' / 'epicyclic').as_posix()}"
        for path in (ROOT / "src" / "epicyclic").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and path.suffix not in (".nbi", ".nbc")
    }
    assert {name for name in names if not name.split("/")[0].endswith(".dist-info")} == beside


def test_the_tests_run_from_the_sdist(built: tuple[Path, Path], tmp_path: Path) -> None:
    """It holds every file of the checkout but those of version control and of continuous integration."""
    with tarfile.open(built[1]) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
        sdist.extractall(tmp_path, filter="data")
    files = ran("git", "-C", ROOT, "ls-files").stdout.splitlines()
    apart = (".ci/", ".git", ".pre-commit-config.yaml")
    assert {name for name in files if not name.startswith(apart)} - names == set()
    (folder,) = tmp_path.iterdir()
    tests = ("tests/unit/train/test_rational.py", "tests/physics/test_rows.py")
    own = ("-p", "no:cacheprovider", "-o", "pythonpath=src . benchmarks")
    done = ran(sys.executable, "-m", "pytest", "-q", *own, *tests, cwd=folder)
    assert done.returncode == 0, done.stdout[-2000:]


def test_the_conda_recipe_is_that_of_the_project() -> None:
    """Parsed and rendered as conda packages are; dependencies, version and command are those of pyproject.toml."""
    rattler_build = pytest.importorskip("rattler_build", reason="needs py-rattler-build, to render the conda recipe")
    (rendered,) = rattler_build.Stage0Recipe.from_file(ROOT / "recipe" / "recipe.yaml").render()
    recipe, project = rendered.recipe.to_dict(), PROJECT["project"]
    assert (recipe["package"]["name"], recipe["package"]["version"]) == (project["name"], project["version"])

    def spaced(dependencies: list[str]) -> set[str]:
        return {re.sub(r"(?<=\w)(?=[<>=])", " ", one) for one in dependencies}

    assert set(recipe["requirements"]["run"]) == spaced(
        [f"python{project['requires-python']}", *project["dependencies"]]
    )
    optional = [one for extra in ("fast", "app", "scale") for one in project["optional-dependencies"][extra]]
    assert set(recipe["requirements"]["run_constraints"]) == spaced(optional)
    entry = [f"{name} = {target}" for name, target in project["scripts"].items()]
    text = (ROOT / "recipe" / "recipe.yaml").read_text("utf-8")
    assert all(f"- {line}\n" in text for line in entry)


def test_the_installed_package_runs(installed: Path, tmp_path: Path) -> None:
    where = ran(installed, "-c", "import epicyclic; print(epicyclic.__file__)", cwd=tmp_path).stdout
    assert str(installed.parents[1]) in where
    script = installed.with_name("epicyclic")
    assert ran(script, "--version", cwd=tmp_path).stdout.split() == ["epicyclic", PROJECT["project"]["version"]]
    shown = ran(script, "check", "ren2021", cwd=tmp_path)
    assert shown.returncode == 0, shown.stderr
    assert "Ratio main.sun to main.carrier 3.47826" in shown.stdout
    page = ran(script, "schema", cwd=tmp_path)
    assert page.stdout.startswith("{")


def test_the_consumer_runs(installed: Path, tmp_path: Path) -> None:
    done = ran(installed, consumer(tmp_path), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lowest, number = done.stdout.split()
    # Lin and Parker 1999, planar set of four planets, to their digits
    assert float(lowest) == pytest.approx(727.0, abs=1.0)
    assert number == PROJECT["project"]["version"]


def consumer(folder: Path) -> Path:
    """The script, where it leads to no checkout."""
    target = folder / "consumer.py"
    target.write_text(CONSUMER.read_text("utf-8"), encoding="utf-8")
    return target


def wrong_lines() -> set[int]:
    lines = CONSUMER.read_text("utf-8").splitlines()
    return {place for place, line in enumerate(lines, start=1) if line.endswith("# ERROR")}


# What xarray and pandas take where it is there, as in an environment of development: no type of the package is theirs.
BESIDE = """
[mypy]
[mypy-dask.*,distributed.*,markdown_it.*,matplotlib.*,zarr.*]
follow_imports = skip
follow_imports_for_stubs = true
"""


def test_mypy_sees_the_types_from_outside(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "mypy.ini").write_text(BESIDE, encoding="utf-8")
    options = ("--strict", "--python-executable", str(installed), "--cache-dir", os.devnull)
    done = ran(sys.executable, "-m", "mypy", *options, "--follow-imports=silent", consumer(tmp_path), cwd=tmp_path)
    found = {int(line) for line in re.findall(r"consumer\.py:(\d+): error", done.stdout)}
    assert found == wrong_lines(), done.stdout + done.stderr


def test_pyright_sees_the_types_from_outside(installed: Path, tmp_path: Path) -> None:
    try:
        ready = ran(sys.executable, "-m", "pyright", "--version", timeout=120).returncode == 0
    except subprocess.TimeoutExpired:
        ready = False
    if not ready:
        pytest.skip("pyright cannot fetch its own runtime here")
    done = ran(sys.executable, "-m", "pyright", "--pythonpath", installed, consumer(tmp_path), cwd=tmp_path)
    found = {int(line) for line in re.findall(r"consumer\.py:(\d+):\d+ - error", done.stdout)}
    assert found == wrong_lines(), done.stdout + done.stderr


def test_the_oldest_versions_are_the_lower_bounds() -> None:
    lower = {
        re.split(r"[><=]", text)[0]: text.split(">=")[1].split(",")[0] for text in PROJECT["project"]["dependencies"]
    }
    lines = (ROOT / "constraints-oldest.txt").read_text("utf-8").splitlines()
    assert dict(line.split("==") for line in lines if not line.startswith("#")) == lower


def test_the_citation_says_what_the_project_says() -> None:
    lines = (ROOT / "CITATION.cff").read_text("utf-8").splitlines()
    said = dict(line.split(": ", 1) for line in lines if re.match(r"[a-z-]+: \S", line))
    project = PROJECT["project"]
    assert said["cff-version"] == "1.2.0"
    assert said["title"] == project["name"]
    assert said["version"] == project["version"]
    assert said["license"] == project["license"] == "BSD-3-Clause"
    assert f'  - name: "{project["authors"][0]["name"]}"' in lines
    assert "The epicyclic authors" in (ROOT / "LICENSE").read_text("utf-8")
    dated = rf"^## \[{re.escape(project['version'])}\] - \d{{4}}-\d\d-\d\d$"
    assert re.search(dated, (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
