# Every target creates the virtual environment if it is missing; no manual setup is needed.
PYTHON ?= python3.11
VENV := .venv
PY := $(VENV)/bin/python
MODULE := samp_blender

.PHONY: venv test test-ui pictures film demo bench evaluate package lint format matrix

venv: $(VENV)/ready
	@$(PY) .ci/check_system.py

# bpy and torch are pinned: an unpinned torch would pull in a CUDA build of several gigabytes.
$(VENV)/ready: requirements.txt pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "Python 3.11 is required: install it, or set PYTHON to its path." >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install -q --disable-pip-version-check torch==2.13.0
	$(PY) -m pip install -q --disable-pip-version-check -r requirements.txt
	$(PY) -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

# Two processes, each with whole files: what the tests of a file share is made once.
JOBS ?= 2

test: venv lint
	$(PY) -m pytest -n $(JOBS) --dist loadfile

# Test the sidebar in a real Blender with a window: make test-ui BLENDER=/path/to/blender. ROOT=FOLDER names the root
# of another system with Blender, Xvfb, xdotool and ImageMagick (created by tests/ui/debian.sh).
BLENDER ?= blender
SHOTS ?= cache/shots

test-ui: venv
	$(PY) -m $(MODULE).release.build --kinds bare --output cache/ui
	ROOT="$(ROOT)" BLENDER="$(BLENDER)" tests/ui/run.sh cache/ui/*.zip $(SHOTS)

# Copy screenshots of the last test-ui into the documentation.
pictures: venv
	$(PY) docs/update_pictures.py $(SHOTS)

# Render docs/images/sit.gif from a take of the demo.
film: venv
	$(PY) docs/update_film.py

lint: venv
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .

format: venv
	$(VENV)/bin/ruff check --fix .
	$(VENV)/bin/ruff format .

# Write demo/demo.blend, a contact sheet of each take and a short film.
demo: venv
	$(PY) demo/make_demo.py

# Time scene analysis, the rollout, clicks, large scenes and refinement on this machine.
bench: venv
	$(PY) -m $(MODULE).benchmarks.scene
	$(PY) -m $(MODULE).benchmarks.rollout
	$(PY) -m $(MODULE).benchmarks.click
	$(PY) -m $(MODULE).benchmarks.large
	$(PY) -m $(MODULE).benchmarks.place
	$(PY) -m $(MODULE).benchmarks.follow
	$(PY) -m $(MODULE).benchmarks.refine

# Compute the papers' measures on held-out furniture.
evaluate: venv
	$(PY) -m $(MODULE).training.samp.goal_net.evaluate
	$(PY) -m $(MODULE).training.evaluate

# Build the zips to install in Blender: full for each platform, light (without torch) and bare (without wheels).
package: venv
	rm -f dist/*.zip
	$(PY) -m $(MODULE).release.build --output dist

# Run the tests with older versions of bpy; all other packages come from the main environment.
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
