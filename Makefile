# DriveGen in two commands: `make run` makes everything, `make test` checks everything. Needs Python 3.11 or 3.12.
PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/.installed

.PHONY: run test tests lint style types tables bench fuzz clean lock help
.DEFAULT_GOAL := help

help:            ## this list
	@sed -n 's/^\([a-z]*\):.*## /\1\t/p' Makefile

run: $(INSTALLED)        ## logs -> scenarios -> tables, recordings and a report; a second run recomputes nothing
	@$(BIN)/python -m flows experiment

# Types take one processor two minutes from nothing: tests need not wait for them.
test: style      ## lint, types, import contracts, all tests (the pipeline with a tiny profile)
	@$(MAKE) --no-print-directory -j 2 types tests

tests: $(INSTALLED)
	@$(BIN)/pytest -n 2 --dist loadscope --no-loadscope-reorder

lint: style types        ## the part of `make test` that needs no running

style: $(INSTALLED)
	@$(BIN)/ruff check --quiet
	@$(BIN)/ruff format --check --quiet

# On a busy machine mypy's workers may not be there in time, which is exit code 2: then one process does it all.
types: $(INSTALLED)
	@$(BIN)/mypy || { [ $$? -eq 2 ] && $(BIN)/mypy --num-workers 0; }
	@$(BIN)/lint-imports --no-logo

tables: $(INSTALLED)     ## the published tables: every data set, several seeds, pooled into reports/published; PART=quality, maps (single pieces), drivers, corner, rates
	@$(BIN)/python -m flows tables --part $(or $(PART),quality)

bench: $(INSTALLED)      ## speed, each row beside its reference; fails if a row misses its target
	@$(BIN)/drivegen bench

fuzz: $(INSTALLED)       ## nightly: 10 000 mutated descriptions, specifications, edits, files and replies; `make test` takes a few of each
	@DRIVEGEN_FUZZ=450 $(BIN)/pytest -n 2 tests/maps tests/words

clean:           ## remove what the pipeline made; DVC's cache stays, so `make run` brings it back
	@find data reports -mindepth 1 -maxdepth 1 -not -name raw -not -name versions -not -name published -not -name README.md -exec rm -rf {} + 2>/dev/null || true
	@rm -rf .drivegen .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache

lock: $(INSTALLED)       ## write the versions that are installed now into constraints.txt
	@$(BIN)/pip freeze --exclude-editable --disable-pip-version-check 2>/dev/null | sed 's/+cpu$$//' > constraints.txt

# Python keeps what it compiles, whatever the environment says: else each process compiles anew what it imports, for half a minute.
unexport PYTHONDONTWRITEBYTECODE

# pip's warnings are many and of no use; its words are shown only if it fails. Python's own pip is old and takes twice as long. pip
# would compile every file of every package, of which a quarter is ever imported.
$(INSTALLED): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(0 if (3, 11) <= v < (3, 13) else f"DriveGen needs Python 3.11 or 3.12, {sys.executable} is {v[0]}.{v[1]}: try `make PYTHON=python3.12 run`")'
	@echo "Installing pinned dependencies into .venv (some 2 minutes the first time) ..."
	@$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --upgrade pip > .venv/install.log 2>&1 || true
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt -e '.[test]' >> .venv/install.log 2>&1 \
		|| { cat .venv/install.log >&2; exit 1; }
	@touch $@
