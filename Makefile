# `make demo` and `make test` work in a fresh clone. The environment is made once; a stamp file remembers that.
# Python 3.11 or newer; another interpreter: make PYTHON=python3.12 test

PYTHON ?= python3
VENV ?= .venv
# Windows has the programs of an environment in another folder.
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
# Processes for the tests, one a core of a small machine.
WORKERS ?= 2

# Small matrices: a second BLAS thread costs more than it brings, and two test processes would fight over the cores.
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1
export MKL_NUM_THREADS ?= 1

.DEFAULT_GOAL := help
.PHONY: help install demo app screenshots test test-long slow coverage benchmarks format format-check lint types docs docs-check tutorial lowest newest wheel integrations picture paper clean

help:  ## Show this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 14

$(BIN)/activate:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or newer is needed; try: make PYTHON=python3.12 ..." >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed-test: pyproject.toml | $(BIN)/activate
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(BIN)/activate
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@ $(VENV)/.installed-test

install: $(VENV)/.installed-test  ## Make the environment and install the package into it

demo: $(VENV)/.installed-test  ## Solve the shipped cases: tables here, results and pictures in demo-results/
	$(BIN)/flatpunch demo --output demo-results

app: $(VENV)/.installed-test  ## Open the page in the browser
	$(BIN)/flatpunch app

test: $(VENV)/.installed-test  ## Run the tests, but for those that take longer than a second
	$(BIN)/python -m pytest -n $(WORKERS)

test-long: $(VENV)/.installed-test  ## Run the tests that take longer than a second
	$(BIN)/python -m pytest -n $(WORKERS) -m 'long and not slow'

slow: $(VENV)/.installed-test  ## Run the large validations too
	$(BIN)/python -m pytest -m 'slow or not slow'

coverage: $(VENV)/.installed-dev  ## Run the tests and print which share of the package they execute
	$(BIN)/python -m pytest -n $(WORKERS) -m 'not slow' --cov --cov-report=term:skip-covered

benchmarks: $(VENV)/.installed-test  ## Measure the speed targets; the times of this version are kept in benchmarks/results
	@mkdir -p benchmarks/results
	$(BIN)/python -m pytest benchmarks --benchmark-enable --benchmark-columns=min,median,rounds \
		--benchmark-json=benchmarks/results/$$($(BIN)/python -c 'import flatpunch; print(flatpunch.__version__)').json

format: $(VENV)/.installed-dev  ## Bring the code into shape
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

format-check: $(VENV)/.installed-dev
	$(BIN)/ruff format --check .

lint: $(VENV)/.installed-dev  ## Look for mistakes in the code and in the workflows
	$(BIN)/ruff check .
	$(BIN)/zizmor --offline --pedantic --quiet .github
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.dependabot .github/dependabot.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.readthedocs .readthedocs.yaml

types: $(VENV)/.installed-dev  ## Check the types
	$(BIN)/mypy

docs: $(VENV)/.installed-dev  ## Build the documentation: docs/_build/html/index.html
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet docs docs/_build/html -d docs/_build/doctrees

docs-check: $(VENV)/.installed-test  ## Run the examples in README and docs, and follow their links
	$(BIN)/python -m pytest -q -m 'not slow' tests/test_readme.py

# Environments beside the usual one are made by uv, which resolves to the lowest versions too.
UV := $(BIN)/uv
OTHER := .environments

lowest: $(VENV)/.installed-dev  ## Test a part with the oldest versions of the dependencies that pyproject.toml allows
	$(UV) venv --quiet --clear --python $(BIN)/python $(OTHER)/lowest
	$(UV) pip install --quiet --python $(OTHER)/lowest --resolution lowest-direct --only-binary :all: --no-binary flatpunch '.[test]'
	$(OTHER)/lowest/bin/python -m pytest -q -n $(WORKERS) -m 'not slow' -W ignore::DeprecationWarning \
		tests/files tests/media tests/reference tests/plots tests/contact/test_indent_input.py tests/adhesion/test_jkr_closed_forms.py

newest: $(VENV)/.installed-dev  ## Test with the newest versions of the dependencies, those before their release included
	$(UV) venv --quiet --clear --python $(BIN)/python $(OTHER)/newest
	$(UV) pip install --quiet --python $(OTHER)/newest --prerelease allow --no-binary flatpunch '.[test]'
	$(OTHER)/newest/bin/python -m pytest -q -n $(WORKERS) -m 'not slow'

wheel: $(VENV)/.installed-dev  ## Build sdist and wheel, follow README in an environment without extras, and run the sdist's own tests there
	$(UV) build --quiet --clear --out-dir $(OTHER)/dist
	test $$(cat $(OTHER)/dist/*.whl | wc -c) -lt 5000000
	$(UV) venv --quiet --clear --python $(BIN)/python $(OTHER)/wheel
	$(UV) pip install --quiet --python $(OTHER)/wheel $(OTHER)/dist/*.whl
	$(OTHER)/wheel/bin/python scripts/follow_page.py README.md
	cd $(OTHER)/wheel && bin/flatpunch demo --output demo-results > demo.txt && tail -3 demo.txt
	rm -rf $(OTHER)/sdist && mkdir $(OTHER)/sdist && tar -xzf $(OTHER)/dist/*.tar.gz -C $(OTHER)/sdist --strip-components 1
	$(UV) pip install --quiet --python $(OTHER)/wheel pytest pytest-benchmark hypothesis
	cd $(OTHER)/sdist && ../wheel/bin/python -m pytest -q -m 'not slow' tests/test_lazy_import.py tests/adhesion/test_jkr_closed_forms.py \
		tests/files/test_cite.py tests/fits/test_unloading.py

tutorial: $(VENV)/.installed-dev  ## Follow tutorial and pages literally, in an environment made as the tutorial says
	$(UV) venv --quiet --clear --python $(BIN)/python $(OTHER)/tutorial
	$(UV) pip install --quiet --python $(OTHER)/tutorial .
	$(OTHER)/tutorial/bin/python scripts/follow_page.py docs/tutorial.md docs/questions.md docs/fitting.md docs/stresses.md

# slippy takes no newer Python, and its test is left out where there is none.
PYTHON39 ?= $(firstword $(wildcard $(HOME)/.pyenv/versions/3.9.*/bin/python3.9) python3.9)

integrations: $(VENV)/.installed-dev  ## Test with the programs that there are plug-ins for and with pyvista, in environments of their own
	$(UV) venv --quiet --clear --python $(BIN)/python $(OTHER)/integrations
	$(UV) pip install --quiet --python $(OTHER)/integrations '.[test,topography,vtk]' nanite ContactMechanics==1.8.3 tamaas==2.9.0 \
		micromechanics==1.3.5
	! $(PYTHON39) --version || { $(UV) venv --quiet --clear --python $(PYTHON39) $(OTHER)/slippy && \
		$(UV) pip install --quiet --python $(OTHER)/slippy slippy==0.5.2; }
	FLATPUNCH_SLIPPY=$$(ls $(CURDIR)/$(OTHER)/slippy/bin/python 2>/dev/null) $(OTHER)/integrations/bin/python -m pytest -q -n 0 -m 'not slow' \
		tests/plugins tests/indenters/test_height_maps.py tests/files/test_vtk.py tests/files/test_maps.py \
		-k "not test_readme or docs/plugins" tests/test_readme.py

picture: $(VENV)/.installed-test  ## Draw the pictures of README and docs again
	$(BIN)/python docs/examples/papers/plot_thin_layer_corrections.py docs/images/thin_layer_corrections.png
	$(BIN)/flatpunch solve examples/afm_pyramid_on_gel.toml --plot docs/images/afm_pyramid_on_gel.png
	$(BIN)/flatpunch fit examples/fit/thin_gel.csv examples/fit/thin_gel.toml --drift docs/images/thin_gel_drift.png
	$(BIN)/flatpunch sweep examples/afm_pyramid_on_gel.toml --vary layers.0.thickness=0.2um:5um:12:log \
		--vary "indenter.half_opening_angle=15deg,25deg,35deg" --plot docs/images/sweep_thickness_angle.png

paper: $(VENV)/.installed-test  ## Compute the figures of the paper: tables and pictures in paper-figures/
	PYTHONPATH=examples $(BIN)/python -m paper --output paper-figures

screenshots: $(VENV)/.installed-test  ## Take the pictures of the page for the docs again; needs Chromium
	FLATPUNCH_SCREENSHOTS=docs/images $(BIN)/python -m pytest -q -n 0 -m 'not slow' tests/app/test_browser.py

clean:  ## Remove what was made, the environment included
	rm -rf docs/_build docs/gallery docs/generated
	rm -rf $(VENV) $(OTHER) build dist demo-results paper-figures .mypy_cache .ruff_cache .pytest_cache .benchmarks .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
