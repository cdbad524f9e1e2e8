# Two commands: `make reproduce` and `make test`. Each sets itself up. `make help` lists the others.
#
#   PYTHON=python3.12   the interpreter to build .venv with (default: the first that is >= 3.11)
#   ARGS='...'          passed on to relightlab, pytest or the benchmark
#   JOBS=2              test processes
#
# Every path below is relative, so that the checkout may live under a name with spaces.

PYTHON ?=
ARGS ?=
JOBS ?= 2
UV ?= uv

BIN = .venv/bin
# Written last: an interrupted set-up leaves no stamp, and is thrown away by the next one.
READY = .venv/.ready
PAGE = studies/page/dist/index.html

# One thread for linear algebra in each process: the work is already spread over processes, and
# two BLAS threads in each of two processes were ten times slower.
export OPENBLAS_NUM_THREADS = 1
export OMP_NUM_THREADS = 1
export MKL_NUM_THREADS = 1
export NUMBA_NUM_THREADS = 1

CANDIDATES = $(if $(PYTHON),"$(PYTHON)",python3 python3.13 python3.12 python3.11)
SUITABLE = import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))
WORKING = import sys, pip; sys.exit(sys.version_info < (3, 11))
PIP = $(BIN)/python -m pip --disable-pip-version-check --no-input --quiet

.PHONY: reproduce test gate lint types bench setup clean help constraints hooks
.DEFAULT_GOAL = help

reproduce: setup ## build the models, print Table 1 and write the page
	$(BIN)/relightlab reproduce $(ARGS)

# --dist loadfile: the tests of one file share what their module builds.
test: lint types ## lint, types, then every test and doctest; the last lines count what was skipped
	$(BIN)/python -m pytest -n $(JOBS) --dist loadfile $(ARGS)

lint: setup ## formatting and lint rules
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

types: setup ## the type checker, strictly, on the packages
	$(BIN)/python -m mypy

gate: setup ## hold the results of every variant to their record
	$(BIN)/relightlab gate check $(ARGS)

bench: setup ## time of each stage, in factorisations of the same grid
	$(BIN)/python -m evaluation.benchmark $(ARGS)

setup: $(READY) $(PAGE) ## create or update .venv from the pinned versions, and the studies' page

# A whole environment is updated in place; anything else is made again from nothing.
$(READY): constraints.txt pyproject.toml
	@if [ -f $(READY) ] && $(BIN)/python -c '$(WORKING)' 2>/dev/null; then \
	  rm -f $(READY); \
	else \
	  rm -rf .venv; \
	  for python in $(CANDIDATES); do \
	    if "$$python" -c '$(SUITABLE)' 2>/dev/null; then found=$$python; break; fi; \
	  done; \
	  if [ -z "$${found:-}" ]; then \
	    echo 'Python 3.11 or newer with its venv module is needed, and none of' $(CANDIDATES) \
	      'is one: install it, or name it with PYTHON=...' >&2; \
	    exit 1; \
	  fi; \
	  "$$found" -m venv .venv; \
	fi
	@echo 'Installing the pinned packages into .venv (about a minute, 1.1 GB)'
	@$(PIP) install --require-hashes -r constraints.txt
	@$(PIP) install --no-deps --no-build-isolation -e .
	@$(PIP) check
	@touch $(READY)

# Only the studies need it: without npm's registry, everything else works, and the next set-up
# tries again.
$(PAGE): $(READY) studies/page_build.py $(wildcard studies/page/*.*)
	@$(BIN)/python -m studies.page_build || echo 'Set-up goes on without the page.' >&2

hooks: setup ## run the checks of .pre-commit-config.yaml before each commit
	$(BIN)/pre-commit install

# See CONTRIBUTING.md. One version for all Pythons where there is one, so that results agree.
constraints: ## pin every dependency again, with hashes (needs uv)
	printf 'setuptools\nwheel\n' | $(UV) pip compile --no-config --quiet --upgrade --universal \
	  --python-version 3.11 --fork-strategy fewest --generate-hashes --all-extras --no-header \
	  --no-annotate --no-emit-index-url --no-emit-find-links -o constraints.txt pyproject.toml -

clean: ## remove the environment, caches and builds; results stay
	rm -rf .venv .mypy_cache .pytest_cache .ruff_cache .hypothesis build dist *.egg-info
	rm -rf studies/page/dist
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

help: ## this list
	@sed -n 's/^\([a-z]*\):.*## /\1|/p' Makefile | while IFS='|' read -r name what; do \
	  printf 'make %-12s %s\n' "$$name" "$$what"; \
	done
