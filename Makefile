# Everything sets itself up: a fresh machine needs CPython 3.11 to 3.14 with venv, and make, nothing else.
# PYTHON=... takes a certain one, VENV=... puts the environment elsewhere.
VENV ?= .venv
COMPAT ?= .compat
COUNT ?= 20000
GUIDED ?= 2000
RUNS ?= 10000
PYTHONS = python3.13 python3.12 python3.11 python3 python3.14
# A name may be there and not run (pyenv's are), or be of another version, or lack what makes environments (Debian's python3-venv).
FITS = import ensurepip, sys, venv; sys.exit(sys.implementation.name != "cpython" or not (3, 11) <= sys.version_info[:2] <= (3, 14))
# What the shell finds a Python with.
FIND = python="$(PYTHON)"; \
    for name in $(PYTHONS); do \
        if [ -z "$$python" ] && "$$name" -c '$(FITS)' >/dev/null 2>&1; then python="$$name"; fi; \
    done; \
    if [ -z "$$python" ]; then \
        echo "make: no CPython 3.11 to 3.14 with its venv was found: install one (Debian: python3-venv), or say PYTHON=..." >&2; \
        exit 1; \
    fi
QUICK = tests/test_*.py tests/base tests/measures tests/inference tests/facts tests/geometry

# Tests start many Pythons: what is imported is compiled once, though the environment may say otherwise.
test quick compat-%: export PYTHONDONTWRITEBYTECODE =

.PHONY: demo test quick lint bench fuzz compat compat-lowest compat-newest clean ready

demo: ready  ## the two towers: from a simulated camera's pixels to ranked worlds
	"$(VENV)/bin/plogic" demo -o out/demo

test: ready  ## all tests
	"$(VENV)/bin/python" -m pytest -n 2 --dist worksteal

quick: lint  ## linter, types, and the tests that render and learn nothing: two minutes
	"$(VENV)/bin/python" -m pytest -n 2 --dist worksteal $(QUICK)

lint: ready  ## linter and type checker
	"$(VENV)/bin/ruff" format --check .
	"$(VENV)/bin/ruff" check .
	"$(VENV)/bin/mypy"

bench: ready  ## the towers' benchmark: a table and its claims
	"$(VENV)/bin/plogic" bench towers

fuzz: ready  ## hostile inputs of every kind: GUIDED and COUNT of each through the readers, RUNS of the commands, and programs
	-"$(VENV)/bin/python" -m pip install --quiet --disable-pip-version-check --editable '.[fuzz]'
	"$(VENV)/bin/python" -m benchmarks.fuzz.guided --count $(GUIDED)
	"$(VENV)/bin/python" -m benchmarks.fuzz.bench --count $(COUNT)
	PATH="$(abspath $(VENV))/bin:$$PATH" "$(VENV)/bin/python" -m benchmarks.fuzz.console --count $(RUNS)
	"$(VENV)/bin/python" -m benchmarks.fuzz.hostile

compat: compat-lowest compat-newest  ## the quick tests with the lowest, and with the newest versions that pyproject.toml admits

compat-lowest: RESOLUTION = lowest-direct
compat-newest: RESOLUTION = highest
compat-lowest compat-newest: compat-%:
	@$(FIND); \
	venv="$(COMPAT)/$*-$$("$$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')"; \
	set -ex; \
	if [ ! "$$venv/.ready" -nt pyproject.toml ]; then \
	    "$$python" -m venv --clear "$$venv"; \
	    "$$venv/bin/python" -m pip install --quiet --disable-pip-version-check uv; \
	    "$$venv/bin/uv" pip install --quiet --compile-bytecode --python "$$venv/bin/python" --resolution $(RESOLUTION) -r pyproject.toml --extra dev; \
	    "$$venv/bin/uv" pip install --quiet --python "$$venv/bin/python" --no-deps --editable .; \
	    touch "$$venv/.ready"; \
	fi; \
	"$$venv/bin/python" -m pytest -n 2 --dist worksteal $(QUICK)

ready:
	@if [ ! "$(VENV)/.ready" -nt pyproject.toml ]; then \
	    $(FIND); \
	    set -ex; \
	    "$$python" -m venv "$(VENV)"; \
	    "$(VENV)/bin/python" -m pip install --quiet --disable-pip-version-check --editable '.[dev]'; \
	    touch "$(VENV)/.ready"; \
	fi

clean:
	rm -rf "$(VENV)" "$(COMPAT)" out
