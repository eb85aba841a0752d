# Every target begins with the virtual environment; nothing of it is asked for by hand.
PYTHON ?= python3.11
VENV := .venv
PY := $(VENV)/bin/python
MODULE := samp_blender

.PHONY: venv test test-ui pictures demo bench evaluate package lint format matrix

venv: $(VENV)/ready
	@$(PY) .ci/check_system.py

# bpy and torch are pinned: a looser torch pulls a CUDA build of several gigabytes.
$(VENV)/ready: requirements.txt pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "Python 3.11 is needed: install it, or name it with PYTHON=..." >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install -q --disable-pip-version-check torch==2.13.0
	$(PY) -m pip install -q --disable-pip-version-check -r requirements.txt
	$(PY) -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

test: venv lint
	$(PY) -m pytest

# A real Blender with a window: make test-ui BLENDER=/path/to/blender. ROOT=FOLDER is the root of another system that
# has Blender, Xvfb, xdotool and ImageMagick (tests/ui/debian.sh makes one).
BLENDER ?= blender
SHOTS ?= cache/shots

test-ui: venv
	$(PY) -m $(MODULE).release.build --kinds bare --output cache/ui
	ROOT="$(ROOT)" BLENDER="$(BLENDER)" tests/ui/run.sh cache/ui/*.zip $(SHOTS)

# Puts pictures of the last test-ui into the documentation.
pictures: venv
	$(PY) docs/update_pictures.py $(SHOTS)

lint: venv
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .

format: venv
	$(VENV)/bin/ruff check --fix .
	$(VENV)/bin/ruff format .

# Leaves demo/demo.blend, a contact sheet of each take and a short film.
demo: venv
	$(PY) demo/make_demo.py

# On the machine at hand: the scene, the rollout, a bake and the whole click.
bench: venv
	$(PY) -m $(MODULE).benchmarks.scene
	$(PY) -m $(MODULE).benchmarks.rollout
	$(PY) -m $(MODULE).benchmarks.click
	$(PY) -m $(MODULE).benchmarks.large
	$(PY) -m $(MODULE).benchmarks.refine

# The papers' measures, on furniture that no training has seen.
evaluate: venv
	$(PY) -m $(MODULE).training.samp.goal_net.evaluate
	$(PY) -m $(MODULE).training.evaluate

# The zips that an artist installs: with wheels for each platform, without torch, and without any wheels.
package: venv
	rm -f dist/*.zip
	$(PY) -m $(MODULE).release.build --output dist

# The tests that meet Blender, on its older versions; torch and the rest are those of the one environment.
BLENDERS := 4.5.15 4.2.23
MATRIX_TESTS ?= tests

matrix: $(BLENDERS:%=matrix-%)

.PRECIOUS: .venv-%/ready
.venv-%/ready: $(VENV)/ready
	$(PYTHON) -m venv .venv-$*
	.venv-$*/bin/python -m pip install -q --disable-pip-version-check --no-deps bpy==$*
	echo "import site; site.addsitedir('$(CURDIR)/$(VENV)/lib/python3.11/site-packages')" > .venv-$*/lib/python3.11/site-packages/shared.pth
	touch $@

matrix-%: .venv-%/ready
	PYTHONPATH=tests/support:tests/support/faults:tests/support/blender .venv-$*/bin/python -m pytest -p ends_at_once $(MATRIX_TESTS)
