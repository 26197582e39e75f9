# On a machine with Python >= 3.11, a Rust toolchain and make:
#   make kw4     one year of 1999 KW4 beside the paper's numbers
#   make test    all tests, Rust and Python
#   make docs    the documentation, with every example run
VENV   ?= .venv
BIN    := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
PYTHON ?= python3
# The target of `make wheel-musl`.
MUSL   ?= x86_64-unknown-linux-musl
MATURIN := $(BIN)/maturin$(if $(filter Windows_NT,$(OS)),.exe)
REPORT ?= out/reproduce
# What the hunt for faults has, and its parts, each of which gets its share of it.
FUZZ_MINUTES ?= 60
FUZZ_PARTS   := fuzz-python fuzz-archive fuzz-pairs
FUZZ_SHARE    = $(shell expr $(FUZZ_MINUTES) / $(words $(FUZZ_PARTS)))
RUST   := Cargo.toml Cargo.lock $(shell find src -name '*.rs')
# Of the report, which draws and measures with all of the package.
SOURCES := $(shell find python/fullbody reproduction -type f -not -name '*.so' -not -path '*/__pycache__/*')
# Folders with Python code.
PYTHONS := python reproduction tests benches fuzz browser
# On Linux wheels are linked by zig against glibc 2.17, so that every distribution since takes them.
ifeq ($(shell uname -s),Linux)
WHEEL := --zig --compatibility manylinux2014
AUDIT  = $(BIN)/auditwheel show dist/*.whl
endif
# The extension links against this interpreter's ABI.
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
# Windows joins its folders by another sign.
export PATH := $(CURDIR)/$(BIN)$(if $(findstring ;,$(PATH)),;,:)$(PATH)
export VIRTUAL_ENV := $(CURDIR)/$(VENV)

.DEFAULT_GOAL := help
.PHONY: help kw4 film reproduce millennia fission dimorphos hera hera-full test test-rust test-arm test-python test-lowest test-wheel wheel wheel-musl licences browser crate lint check \
	fmt docs bench fuzz \
	$(FUZZ_PARTS) mutants clean

help:  ## this list
	@grep -E '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

$(MATURIN):
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip 'maturin>=1.9,<2'

$(VENV)/.built: $(MATURIN) pyproject.toml $(RUST)
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable '.[all]'
	@touch $@

$(VENV)/.dev: $(VENV)/.built
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable '.[dev]'
	@touch $@

$(VENV)/.docs: $(VENV)/.built
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable '.[docs]'
	@touch $@

$(VENV)/.wheel: $(MATURIN)
	$(BIN)/python -m pip install --quiet 'auditwheel>=6.4,<7' 'cargo-zigbuild>=0.20,<1' 'ziglang>=0.13,<1'
	@touch $@

kw4: $(VENV)/.built  ## one year of 1999 KW4 beside the paper's numbers, into out/kw4/
	$(BIN)/python -m fullbody kw4 --out out/kw4

test: test-rust test-python  ## all tests

test-rust:
	cargo test --locked --no-default-features

# Of Debian: qemu-user and libc6-arm64-cross.
test-arm: $(VENV)/.wheel  ## the Rust tests as 64-bit ARM runs them, by QEMU
	rustup target add aarch64-unknown-linux-gnu
	CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER='qemu-aarch64 -L /usr/aarch64-linux-gnu' \
		$(BIN)/cargo-zigbuild test --no-default-features --target aarch64-unknown-linux-gnu --test rust

# Tests start many interpreters, which read what the first of them has compiled.
test-python: $(VENV)/.dev
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n auto

wheel: $(VENV)/.wheel  ## the source distribution and, built from it, the wheel for this kind of machine, into dist/
	rm -rf dist
	$(BIN)/maturin build --release --locked --sdist --out dist $(WHEEL)
	$(AUDIT)

wheel-musl: $(VENV)/.wheel  ## a wheel for Linux systems with musl, as Alpine, into dist/; MUSL= names Rust's target
	rm -rf dist
	$(BIN)/maturin build --release --locked --out dist --zig --compatibility musllinux_1_2 --target $(MUSL)

# uv is the resolver that knows how to take the lowest versions.
test-lowest:  ## the Python tests with the lowest supported versions of all dependencies, in out/lowest/
	$(PYTHON) -m venv --clear out/lowest
	out/lowest/bin/python -m pip install --quiet 'uv>=0.8,<1'
	out/lowest/bin/uv pip install --python out/lowest/bin/python --quiet --resolution lowest-direct --editable '.[test]'
	out/lowest/bin/python -m pytest -n auto

licences: $(VENV)/.built  ## the licences of the crates that the extension contains, into THIRD_PARTY_LICENCES.yml
	cargo bundle-licenses --features python --previous THIRD_PARTY_LICENCES.yml --format yaml --output THIRD_PARTY_LICENCES.yml --prefer MIT

test-wheel: wheel  ## installs the wheel where no Rust is, and the source distribution, and runs 1999 KW4 from both
	$(BIN)/python tests/installed.py dist

browser: $(VENV)/.built  ## a page on which 1999 KW4 runs in the browser, into out/browser/
	rustup target add wasm32-unknown-emscripten
	$(BIN)/python browser/build.py out/browser

crate: $(MATURIN)  ## packs the crate, and builds it from what was packed
	RUSTDOCFLAGS='-D warnings' cargo doc --no-deps --no-default-features
	cargo package --allow-dirty

lint: $(VENV)/.dev  ## formats, lints and types of Python, formats of Rust: what each commit has to pass
	cargo fmt --check
	$(BIN)/ruff format --check $(PYTHONS)
	$(BIN)/ruff check $(PYTHONS)
	$(BIN)/mypy

check: lint  ## lint, and the lints of Rust and the stubs
	cargo clippy --locked --no-default-features --all-targets -- -D warnings
	cargo clippy --locked --features python -- -D warnings
	$(BIN)/python -m mypy.stubtest fullbody._core

fmt:  ## formats everything
	cargo fmt
	$(BIN)/ruff format $(PYTHONS)
	$(BIN)/ruff check --fix $(PYTHONS)

docs: $(VENV)/.docs $(REPORT)/numbers.json  ## the documentation, into out/docs/; warnings are errors, examples are run
	cargo doc --locked --no-deps --no-default-features
	FULLBODY_REPORT=$(REPORT) $(BIN)/python -m sphinx -E -W --keep-going -d out/doctrees docs out/docs

film: $(VENV)/.built  ## the film at the head of the README, into docs/didymos.gif
	$(BIN)/python docs/film.py

reproduce: $(REPORT)/numbers.json  ## the whole paper run again, into out/reproduce/

$(REPORT)/numbers.json: $(VENV)/.docs $(SOURCES)
	$(BIN)/python -m reproduction.ho2021 --out $(REPORT)

millennia: $(VENV)/.built  ## ten thousand years of 1999 KW4 by the symplectic splitting, into out/millennia/; goes on where it was cut short
	$(BIN)/python -m fullbody millennia --out out/millennia

fission: $(VENV)/.built  ## rotational fission, 19,980 runs after Ho et al. (2022), into out/fission/; goes on where it was cut short
	$(BIN)/python -m reproduction.ho2022 --out out/fission

dimorphos: $(VENV)/.built  ## Dimorphos' attitude over its axes after Agrusa et al. (2021), into out/dimorphos/; the same
	$(BIN)/python -m reproduction.agrusa2021 --out out/dimorphos

# HERA_MEMBERS= sets the number of members, HERA_DASK=local runs them on workers of dask.
hera: $(VENV)/.built  ## what Hera should find at Didymos, 24 members from DART to its arrival, into out/hera/; the same
	$(BIN)/python -m reproduction.hera2026 --out out/hera

hera-full: $(VENV)/.built  ## the same with 2,000 members, hours; continues what `make hera` has begun
	HERA_MEMBERS=$(or $(HERA_MEMBERS),2000) $(BIN)/python -m reproduction.hera2026 --out out/hera

bench: $(VENV)/.dev  ## speed: criterion, the table beside numpy and scipy, instruction counts, work and precision, round-off, the splitting, import, external forces, gravity at many points, polyhedra, flights, derivatives, fits; collisions missed; a sweep killed twenty times
	cargo bench --manifest-path benches/criterion/Cargo.toml
	$(BIN)/python benches/table.py
	$(BIN)/python benches/instructions.py
	$(BIN)/python benches/work_precision.py
	$(BIN)/python benches/brouwer.py
	$(BIN)/python benches/splitting.py
	$(BIN)/python benches/import_time.py
	$(BIN)/python benches/forces.py
	$(BIN)/python benches/gravity.py
	$(BIN)/python benches/photometry.py
	$(BIN)/python benches/polyhedra.py
	$(BIN)/python benches/derivatives.py
	$(BIN)/python benches/fitting.py
	$(BIN)/python benches/flight.py --million
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

mutants:  ## changes to the Rust code that no Rust test notices, for a module or file of src/: MODULE=dynamics
	@test -n "$(MODULE)" -a -e "src/$(MODULE)" || { echo "no src/$(MODULE); name a module or file of src/, as in: make mutants MODULE=dynamics" >&2; exit 1; }
	cargo mutants --file "src/$(MODULE:/=)$(if $(filter %.rs,$(MODULE)),,/**)" --output out $(MUTANTS)

clean:  ## removes what was built
	rm -rf target fuzz/target benches/criterion/target $(VENV) out dist docs/_extra docs/notebooks
	find python reproduction tests -name '__pycache__' -prune -exec rm -rf {} +
	rm -f python/fullbody/*.so
