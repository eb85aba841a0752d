# Every target begins with the virtual environment; nothing of it is asked for by hand.
PYTHON ?= python3.11
VENV := .venv
PY := $(VENV)/bin/python
MODULE := samp_blender

.PHONY: venv test demo bench evaluate package lint format

venv: $(VENV)/ready

# bpy and torch are pinned: a looser torch pulls a CUDA build of several gigabytes.
$(VENV)/ready: requirements.txt pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install -q --disable-pip-version-check torch==2.13.0
	$(PY) -m pip install -q --disable-pip-version-check -r requirements.txt
	$(PY) -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

test: venv lint
	$(PY) -m pytest

lint: venv
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .

format: venv
	$(VENV)/bin/ruff check --fix .
	$(VENV)/bin/ruff format .
