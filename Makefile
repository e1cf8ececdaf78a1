# Everything happens inside the checkout: .venv holds Python, target/ what cargo builds.
# `make help` lists the targets; the text after ## is what it prints.

PYTHON ?= python3
VENV := .venv
PY := $(VENV)/bin/python
ORACLE := .venv-oracle
GRADIENTS := .venv-gradients
ROBOTS := .venv-robots
WHEELS := target/wheels
NATIVE := python/agrik_fast/_native.abi3.so

# In the continuous integration the committed Cargo.lock must be up to date.
LOCKED := $(if $(CI),--locked)
# One interpreter for cargo and maturin, or PyO3 would be compiled twice.
export PYO3_PYTHON := $(abspath $(PY))
export PIP_DISABLE_PIP_VERSION_CHECK := 1

RUST_SOURCES := $(wildcard Cargo.toml Cargo.lock) $(shell find rust -name '*.rs' -o -name Cargo.toml)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help run test lint format bench callgrind aarch64 sanitize miri wheel docs clean build oracle \
	firmware rigs rigs-full browser gradients vision-full motion-full branches branches-sample \
	damaged fuzz-arms fuzz-sample robustness rust-checks rust-lint rust-test \
	python-checks python-lint python-test

help: ## say what every target does
	@echo 'agrik_fast: `make run` and `make test` need only Rust, Python >= 3.11 and PyPI.'
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))

run: build ## solve the example targets of every robot, write and check the results
	$(PY) examples/run_all.py
	$(PY) examples/field_jobs.py
	$(PY) examples/play_line.py

# Two queues side by side, as in .ci/run: what needs the release build, and what needs none.
test: $(VENV)/.pip ## every check but the oracle: linters, types, Rust and Python tests
	$(MAKE) --jobs 2 --output-sync=line rust-checks python-checks

lint: rust-lint python-lint ## formatting, clippy, ruff, mypy and stubtest, without the tests

format: $(VENV)/.dev ## let rustfmt and ruff write the files the way `make lint` wants them
	cargo fmt --all
	$(PY) -m ruff check --fix-only --quiet .
	$(PY) -m ruff format .

bench: build $(VENV)/.dev ## criterion benches of the core, then this library beside its peers
	cargo bench $(LOCKED) -p agrik -p agrik-solids -p agrik-motion
	$(PY) benches/peers.py
	$(PY) benches/closed_forms.py
	$(PY) benches/collision.py

callgrind: build ## instructions per solve against the committed numbers (needs valgrind)
	$(PY) benches/instructions.py

# The stamps tell .ci/run that these need not run again until what they cover changes: commit them.
aarch64: ## the core's tests for aarch64 under an emulator (sets itself up on Debian as root)
	.ci/aarch64
	.ci/stamp write aarch64

sanitize: ## the core's lanes and batches under AddressSanitizer
	.ci/sanitize

miri: ## the lane types under Miri (needs a nightly toolchain with the component)
	.ci/miri
	.ci/stamp write miri

firmware: ## the boards' programs and the simulated rigs (sets itself up on Debian as root)
	.ci/firmware
	$(MAKE) -C firmware

rigs: build $(VENV)/.dev ## the tests of firmware, plant and drivers alone
	$(PY) -m pytest -m rigs

rigs-full: build $(VENV)/.dev firmware ## an hour of simulated work and faults of each rig
	PYTHONPATH=tests $(PY) tests/rigs_soak.py --minutes 60
	$(PY) -m pytest tests/drivers/test_link.py --requests 5000 --timeout 900

browser: build $(VENV)/.dev ## the viewer in Chromium (sets itself up on Debian as root)
	.ci/browser
	AGRIK_BROWSER=1 $(PY) -m pytest -m browser

vision-full: build $(VENV)/.dev ## the detector on 2,000 renders, the loop before 20 fruits, the chain, stereo to harvest
	PYTHONPATH=tests $(PY) tests/vision_renders.py --renders 2000
	PYTHONPATH=tests $(PY) tests/pointing_full.py --fruits 20
	PYTHONPATH=tests $(PY) tests/vision_chain.py --renders 100
	AGRIK_ALL_SCENES=1 $(PY) -m pytest --timeout 600 tests/vision/test_stereo_harvest.py

motion-full: build $(VENV)/.dev ## 10,000 paths before a judge of plain NumPy; the large samples of proofs
	PYTHONPATH=tests $(PY) tests/paths_full.py --paths 10000
	PYTHONPATH=tests $(PY) tests/proofs_full.py

damaged: build $(VENV)/.dev ## 2,000 damaged files: no traceback, < 500 MB, < 5 s each
	$(PY) tests/io/damaged_files.py --files 2000

fuzz-arms: build ## random arms, solvers and tasks against what is promised: 10^7 rows
	$(PY) benches/fuzz_arms.py --rows 1e7

branches: build ## all branches of 10^5 poses on thirty arms: what is missed, what is false
	$(PY) benches/branches.py --poses 100000 --starts 200 --peers 0 --check

branches-sample: build ## a hundredth of the same
	$(PY) benches/branches.py --poses 1000 --starts 2 --peers 0 --check

fuzz-sample: build ## two minutes of `fuzz-arms`
	$(PY) benches/fuzz_arms.py --minutes 2

robustness: build $(ROBOTS)/.done ## docs/robustness.md made anew, on arms that are downloaded
	$(PY) benches/robustness.py --packages $(ROBOTS)

wheel: $(VENV)/.build ## the wheel for this platform, in target/wheels
	rm -rf $(WHEELS)
	$(PY) -m maturin build --release $(LOCKED) --interpreter $(PY) --out $(WHEELS)

docs: build $(VENV)/.docs ## the documentation as HTML in docs/_build/html; a warning or a dead link is an error
	$(PY) -m sphinx -W --keep-going --quiet -b html docs docs/_build/html
	$(PY) tools/check_site.py docs/_build/html
	@echo 'docs/_build/html/index.html'

clean: ## remove what the other targets made, the environments included
	cargo clean
	rm -rf firmware/build .venv .venv-* dist docs/_build docs/_generated docs/tutorials examples/results benches/results
	rm -rf .mypy_cache .pytest_cache .ruff_cache .hypothesis
	rm -f python/agrik_fast/_native*.so
	find python tests examples benches docs tools -name __pycache__ -prune -exec rm -rf {} +

build: $(NATIVE) ## the release extension, installed into .venv (quick when nothing changed)

# The wheel holds what cargo compiled for `build`: making it takes seconds.
oracle: build wheel $(ORACLE)/.done ## compare with Pinocchio (URDFs of real robots), EAIK (branches), coal (distances); heavy downloads, own environment
	$(ORACLE)/bin/python -m pip uninstall --quiet --yes agrik_fast
	$(ORACLE)/bin/python -m pip install --quiet $(WHEELS)/*.whl
	$(ORACLE)/bin/python -m pytest tests/oracle

gradients: build wheel $(GRADIENTS)/.done ## tensors and gradients of torch and JAX, poses of spatialmath; heavy downloads, own environment
	$(GRADIENTS)/bin/python -m pip uninstall --quiet --yes agrik_fast
	$(GRADIENTS)/bin/python -m pip install --quiet $(WHEELS)/*.whl
	$(GRADIENTS)/bin/python -m pytest tests/gradients

# ---- the parts of `make test` ----------------------------------------------------------------

rust-checks:
	$(MAKE) rust-lint
	$(MAKE) rust-test

python-checks:
	$(MAKE) python-lint
	$(MAKE) python-test

# PyO3 asks an interpreter for its version, so the environment comes first.
rust-lint: $(VENV)/.pip
	cargo fmt --all --check
	cargo clippy $(LOCKED) --workspace --all-targets -- -D warnings

# agrik-py is an extension module: its tests are the Python ones.
rust-test: $(VENV)/.pip
	if cargo nextest --version >/dev/null 2>&1; \
	then cargo nextest run $(LOCKED) --workspace --exclude agrik-py; \
	else cargo test $(LOCKED) --workspace --exclude agrik-py --tests; fi
	cargo test $(LOCKED) --doc -p agrik-compute -p agrik -p agrik-solids -p agrik-motion

python-lint: build $(VENV)/.dev
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	$(PY) -m mypy.stubtest --concise agrik_fast._native

# MARK='not rigs' leaves out what `make rigs` does.
python-test: build $(VENV)/.dev
	$(PY) -m pytest $(if $(MARK),-m '$(MARK)')
	@command -v avr-gcc >/dev/null || \
		echo "NOT CHECKED: firmware and rigs, for want of an AVR compiler (see make firmware)"
	@command -v chromedriver >/dev/null || \
		echo "NOT CHECKED: the viewer in a browser, for want of Chromium (see make browser)"
	@echo "... NOT CHECKED: agrik_fast.torch and agrik_fast.jax, which make gradients tries"

# ---- environments: a stamp file for each, so that a second call is quick ------------------------

$(VENV)/.pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed; name one: make PYTHON=python3.12")'
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install --quiet --upgrade pip
	@touch $@

$(VENV)/.build: pyproject.toml $(VENV)/.pip
	$(PY) -m pip install --quiet --group build
	@touch $@

$(VENV)/.dev: pyproject.toml $(VENV)/.pip
	$(PY) -m pip install --quiet --group test --group lint
	@touch $@

$(VENV)/.docs: pyproject.toml $(VENV)/.pip
	$(PY) -m pip install --quiet --group docs
	@touch $@

$(NATIVE): $(RUST_SOURCES) pyproject.toml $(VENV)/.build
	@touch $(VENV)/.begun
	VIRTUAL_ENV=$(abspath $(VENV)) $(PY) -m maturin develop --release $(LOCKED) --extras parquet,drivers
# What changes while it is built is newer.
	@touch -r $(VENV)/.begun $@

$(ROBOTS)/.done: pyproject.toml
	$(PYTHON) -m venv $(ROBOTS)
	$(ROBOTS)/bin/python -m pip install --quiet --upgrade pip
	$(ROBOTS)/bin/python -m pip install --quiet --no-deps --group oracle-data
	@touch $@

$(GRADIENTS)/.done: pyproject.toml
	$(PYTHON) -m venv $(GRADIENTS)
	$(GRADIENTS)/bin/python -m pip install --quiet --upgrade pip
	$(GRADIENTS)/bin/python -m pip install --quiet --group gradients
	@touch $@

# Pinocchio pins libraries of its own; the two robot packages are wanted for their files alone.
$(ORACLE)/.done: pyproject.toml
	$(PYTHON) -m venv $(ORACLE)
	$(ORACLE)/bin/python -m pip install --quiet --upgrade pip
	$(ORACLE)/bin/python -m pip install --quiet --group oracle
	$(ORACLE)/bin/python -m pip install --quiet --no-deps --group oracle-data
	@touch $@
