# Everything sets itself up: a fresh machine needs CPython 3.11, pip and make, nothing else.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV ?= .venv
READY = $(VENV)/.ready

.PHONY: demo test lint bench clean

demo: $(READY)  ## the two towers: from a simulated camera's pixels to ranked worlds
	$(VENV)/bin/plogic demo -o out/demo

test: $(READY)  ## all tests
	$(VENV)/bin/python -m pytest -n 2

lint: $(READY)  ## linter and type checker
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/ruff check .
	$(VENV)/bin/mypy

bench: $(READY)  ## the towers' benchmark: a table and its claims
	$(VENV)/bin/plogic bench towers

$(READY): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) out
