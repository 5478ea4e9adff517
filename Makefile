# Two commands on a bare machine with Python 3.11 or newer and make:
#   make demo    analyse the ready drive ren2021, write epicyclic-report.html, print the key figures
#   make test    lint, type-check and test
# They keep their own environment in .venv, built again only when pyproject.toml changes.

VENV   := .venv
BIN    := $(VENV)/bin
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
            $$p -c 'import sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && echo $$p && break; done)
REPORT := epicyclic-report.html

# Processes that tests start load the package's bytecode, as those of a user do.
export PYTHONDONTWRITEBYTECODE :=

OLDEST := $(addprefix tests/unit/,test_results.py test_cli_help.py show/test_terminal.py verbs/test_help.py document system)

# Numbers of every room; what a kernel's rounding once moved comes first.
KERNEL       := Prescott
KERNEL_TESTS := $(addprefix tests/,papers/test_dong2019.py papers/test_yue2014.py $(addprefix unit/, \
                  statics/test_static.py statics/test_static_flanks.py questions/modes/test_modal.py \
                  questions/response/test_resonances.py questions/tolerance/test_tolerance_map.py \
                  questions/studies/test_compare_trains.py questions/flanks/test_contact_resolution.py \
                  questions/studies/test_stability_map.py test_ties.py) \
                  physics/test_star_drive.py physics/test_three_routes.py physics/test_floating.py physics/test_no_load.py)

.PHONY: demo test lint types pytest quick kernel oldest bench figures docs clean help
.DEFAULT_GOAL := help

help:
	@sed -n '1,/^$$/s/^# \{0,1\}//p' Makefile
	@echo "also: make quick, make kernel KERNEL=Haswell, make oldest, make docs, make bench, make figures, make clean"

demo: $(VENV)/.installed
	$(BIN)/epicyclic report ren2021 -o $(REPORT)

test: lint types pytest

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell

types: $(VENV)/.installed-dev
	$(BIN)/mypy --explicit-package-bases src tests examples benchmarks

# The process that has the tests of the page waits for the browser: one more than cores, up to four.
PROCESSES = $(shell $(BIN)/python -c "import os; print(min(4, os.cpu_count() + 1))")
pytest: $(VENV)/.installed-dev
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q -rs -n $(PROCESSES) --dist loadfile --no-loadscope-reorder --durations=10

# From the drawing to the equation, and the arrows between the rooms.
QUICK := $(addprefix tests/unit/,test_architecture.py document train teeth system statics) tests/physics
quick: lint
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q -n auto --maxprocesses 4 -m "not slow and not browser" $(QUICK)

# Numerical tests under one BLAS kernel; NoAVX2 : of NumPy 2.4 without its wide vectors too.
kernel: $(VENV)/.installed-dev
	$(BIN)/python tests/under_kernel.py $(KERNEL) -q -n auto --maxprocesses 4 $(KERNEL_TESTS)

bench: $(VENV)/.installed-dev
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/bench.py

figures: $(VENV)/.installed-dev
	mkdir -p figures
	for example in examples/*.py; do $(BIN)/python $$example figures || exit 1; done
	OPENBLAS_NUM_THREADS=1 $(BIN)/python docs/papers/make.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python docs/learn/make.py
	OPENBLAS_NUM_THREADS=1 $(BIN)/python docs/learn/draw_gallery.py

# A plain installation with the oldest versions that pyproject.toml allows, in an environment of its own.
oldest:
	$(PYTHON) -m venv --clear .venv-oldest
	.venv-oldest/bin/python -m pip install --quiet --disable-pip-version-check -c constraints-oldest.txt . pytest hypothesis
	OPENBLAS_NUM_THREADS=1 .venv-oldest/bin/python -m pytest -q -p no:cacheprovider $(OLDEST)

docs: $(VENV)/.installed-dev
	$(BIN)/python -m sphinx -q -W --keep-going -n -b html docs docs/_build/html
	@echo open docs/_build/html/index.html

clean:
	rm -rf $(VENV) .venv-oldest docs/_build build dist src/*.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis figures $(REPORT)
	find src tests examples benchmarks -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

$(VENV)/.created:
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer with the venv module is needed (Debian: apt install python3-venv); or say PYTHON=..."; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	touch $@

$(VENV)/.installed: pyproject.toml | $(VENV)/.created
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	touch $@

$(VENV)/.installed-dev: pyproject.toml | $(VENV)/.created
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev$(EXTRA)]'
	touch $(VENV)/.installed $@
