# On a machine with Python >= 3.11, a Rust toolchain and make:
#   make kw4     one year of 1999 KW4 beside the paper's numbers
#   make test    all tests, Rust and Python
#   make docs    the documentation, with every example run
VENV   ?= .venv
BIN    := $(VENV)/bin
PYTHON ?= python3
REPORT ?= out/reproduce
# What the hunt for faults has, and its parts, each of which gets its share of it.
FUZZ_MINUTES ?= 60
FUZZ_PARTS   := fuzz-python fuzz-archive fuzz-pairs
FUZZ_SHARE    = $(shell expr $(FUZZ_MINUTES) / $(words $(FUZZ_PARTS)))
RUST   := Cargo.toml Cargo.lock $(shell find src -name '*.rs')
# Of the report, which draws and measures with all of the package.
SOURCES := $(shell find python/fullbody reproduction -type f -not -name '*.so' -not -path '*/__pycache__/*')
# The extension links against this interpreter's ABI.
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
export PATH := $(CURDIR)/$(BIN):$(PATH)
export VIRTUAL_ENV := $(CURDIR)/$(VENV)

.DEFAULT_GOAL := help
.PHONY: help kw4 film reproduce fission dimorphos test test-rust test-python check fmt docs bench fuzz $(FUZZ_PARTS) mutants clean

help:  ## this list
	@grep -E '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

$(BIN)/maturin:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip 'maturin>=1.9,<2'

$(VENV)/.built: $(BIN)/maturin pyproject.toml $(RUST)
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable '.[all]'
	@touch $@

$(VENV)/.dev: $(VENV)/.built
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable '.[dev]'
	@touch $@

$(VENV)/.docs: $(VENV)/.built
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable '.[docs]'
	@touch $@

kw4: $(VENV)/.built  ## one year of 1999 KW4 beside the paper's numbers, into out/kw4/
	$(BIN)/python -m fullbody kw4 --out out/kw4

test: test-rust test-python  ## all tests

test-rust:
	cargo test --no-default-features

test-python: $(VENV)/.dev
	$(BIN)/python -m pytest -n auto

check: $(VENV)/.dev  ## formats, lints, types, stubs
	cargo fmt --check
	cargo clippy --no-default-features --all-targets -- -D warnings
	cargo clippy --features python -- -D warnings
	$(BIN)/ruff format --check python reproduction tests benches fuzz
	$(BIN)/ruff check python reproduction tests benches fuzz
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest fullbody._core

fmt:  ## formats everything
	cargo fmt
	$(BIN)/ruff format python reproduction tests benches fuzz
	$(BIN)/ruff check --fix python reproduction tests benches fuzz

docs: $(VENV)/.docs $(REPORT)/numbers.json  ## the documentation, into out/docs/; warnings are errors, examples are run
	FULLBODY_REPORT=$(REPORT) $(BIN)/python -m sphinx -E -W --keep-going -d out/doctrees docs out/docs

film: $(VENV)/.built  ## the film at the head of the README, into docs/didymos.gif
	$(BIN)/python docs/film.py

reproduce: $(REPORT)/numbers.json  ## the whole paper run again, into out/reproduce/

$(REPORT)/numbers.json: $(VENV)/.docs $(SOURCES)
	$(BIN)/python -m reproduction.ho2021 --out $(REPORT)

fission: $(VENV)/.built  ## rotational fission, 19,980 runs after Ho et al. (2022), into out/fission/; goes on where it was cut short
	$(BIN)/python -m reproduction.ho2022 --out out/fission

dimorphos: $(VENV)/.built  ## Dimorphos' attitude over its axes after Agrusa et al. (2021), into out/dimorphos/; the same
	$(BIN)/python -m reproduction.agrusa2021 --out out/dimorphos

bench: $(VENV)/.dev  ## speed: criterion, the table beside numpy and scipy, instruction counts, work and precision, round-off, import, forces from outside, polyhedra, derivatives; collisions missed; a sweep killed twenty times
	cargo bench --no-default-features --bench interaction
	$(BIN)/python benches/table.py
	$(BIN)/python benches/instructions.py
	$(BIN)/python benches/work_precision.py
	$(BIN)/python benches/brouwer.py
	$(BIN)/python benches/import_time.py
	$(BIN)/python benches/forces.py
	$(BIN)/python benches/polyhedra.py
	$(BIN)/python benches/derivatives.py
	$(BIN)/python benches/head_on.py
	$(BIN)/python benches/ensemble.py
	$(BIN)/python benches/killed.py

fuzz: $(FUZZ_PARTS)  ## wrong input at every door, for an hour or FUZZ_MINUTES=; faults go to out/fuzz/

fuzz-python: $(VENV)/.dev
	PYTHONPATH=fuzz $(BIN)/python -m doors --minutes $(FUZZ_SHARE)

# There is no unsafe code to sanitize, and without it a stable toolchain does.
fuzz-archive fuzz-pairs: fuzz-%:
	mkdir -p out/fuzz/$*
	cargo fuzz run --sanitizer none $* out/fuzz/$* fuzz/corpus/$* -- \
		-max_total_time=$$((60 * $(FUZZ_SHARE))) -timeout=60 -max_len=4096 -artifact_prefix=out/fuzz/$*-

mutants:  ## changes to the Rust code that no Rust test notices, for a folder or file of src/: ROOM=dynamics
	@test -n "$(ROOM)" -a -e "src/$(ROOM)" || { echo "no src/$(ROOM); say which part of src/, as in: make mutants ROOM=dynamics" >&2; exit 1; }
	cargo mutants --file "src/$(ROOM:/=)$(if $(filter %.rs,$(ROOM)),,/**)" --output out $(MUTANTS)

clean:  ## removes what was built
	rm -rf target fuzz/target $(VENV) out dist docs/_extra docs/notebooks
	find python reproduction tests -name '__pycache__' -prune -exec rm -rf {} +
	rm -f python/fullbody/*.so
