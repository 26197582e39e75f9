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
BINARIES ?= out/binaries
# The time of `make fuzz` in minutes, and its parts, which share it equally.
FUZZ_MINUTES ?= 60
FUZZ_PARTS   := fuzz-python fuzz-archive fuzz-pairs
FUZZ_SHARE    = $(shell expr $(FUZZ_MINUTES) / $(words $(FUZZ_PARTS)))
RUST   := Cargo.toml Cargo.lock bindings/Cargo.toml $(shell find src bindings/src -name '*.rs')
# The files on which the report depends, which uses the whole package for its figures and numbers.
SOURCES := $(shell find python/fullbody reproduction -type f -not -name '*.so' -not -path '*/__pycache__/*')
OBSERVATIONS := $(shell find tests/data/observations -name '*.csv')
# Folders with Python code, and the settings of the tests.
PYTHONS := conftest.py python reproduction tests benches fuzz browser
# On Linux zig links wheels against glibc 2.17, so that they run on every distribution since then.
ifeq ($(shell uname -s),Linux)
WHEEL := --zig --compatibility manylinux2014
AUDIT  = $(BIN)/auditwheel show dist/*.whl
endif
# The extension links against this interpreter's ABI.
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
# Windows separates folders in PATH by a semicolon.
export PATH := $(CURDIR)/$(BIN)$(if $(findstring ;,$(PATH)),;,:)$(PATH)
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
# The extension is built with the versions of Cargo.lock, or not at all.
export MATURIN_PEP517_ARGS := --locked
# Uv installs in seconds what takes pip a minute. It would take the extension from its cache although it has been removed.
INSTALL := $(BIN)/uv pip install --quiet --reinstall-package fullbody
EDITABLE := $(INSTALL) --no-build-isolation --editable

.DEFAULT_GOAL := help
.PHONY: help kw4 notebooks film reproduce millennia fission dimorphos binaries hera hera-full test test-rust test-arm test-python test-reproduction test-lowest test-wheel wheel wheel-musl licences browser crate lint check \
	fmt docs bench fuzz \
	$(FUZZ_PARTS) mutants clean

help:  ## this list
	@grep -E '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

$(MATURIN):
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet 'maturin>=1.9,<2' 'uv>=0.8,<1'

$(VENV)/.built: $(MATURIN) pyproject.toml $(RUST)
	$(EDITABLE) '.[all]'
	@touch $@

$(VENV)/.dev: $(VENV)/.built
	$(EDITABLE) '.[dev]'
	@touch $@

$(VENV)/.docs: $(VENV)/.built
	$(EDITABLE) '.[docs]'
	@touch $@

$(VENV)/.wheel: $(MATURIN)
	$(INSTALL) 'auditwheel>=6.4,<7' 'cargo-zigbuild>=0.20,<1' 'ziglang>=0.13,<1'
	@touch $@

kw4: $(VENV)/.built  ## one year of 1999 KW4 beside the paper's numbers, into out/kw4/
	$(BIN)/python -m reproduction.ho2021.kw4_year --out out/kw4

test: test-rust test-python  ## all tests

# They run what the extension has been built from. `cargo test` alone builds it with checks of overflow, and in parts.
test-rust:
	cargo test --locked --release --workspace

# This needs Debian's packages qemu-user and libc6-arm64-cross.
test-arm: $(VENV)/.wheel  ## the Rust tests on 64-bit ARM, emulated by QEMU
	rustup target add aarch64-unknown-linux-gnu
	CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER='qemu-aarch64 -L /usr/aarch64-linux-gnu' \
		$(BIN)/cargo-zigbuild test --target aarch64-unknown-linux-gnu --test rust

# Bytecode is written, since tests start many interpreters that reuse it.
test-python: $(VENV)/.dev
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n auto

test-reproduction: $(VENV)/.dev  ## the tests of the studies in reproduction/
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n auto reproduction/tests

wheel: $(VENV)/.wheel  ## the source distribution and, built from it, the wheel for this kind of machine, into dist/
	rm -rf dist
	$(BIN)/maturin build --release --locked --sdist --out dist $(WHEEL)
	$(AUDIT)

wheel-musl: $(VENV)/.wheel  ## a wheel for Linux systems with musl, such as Alpine, into dist/; MUSL= is the name of Rust's target
	rm -rf dist
	$(BIN)/maturin build --release --locked --out dist --zig --compatibility musllinux_1_2 --target $(MUSL)

test-lowest: $(MATURIN)  ## the Python tests with the lowest supported versions of all dependencies, in out/lowest/
	$(PYTHON) -m venv --clear out/lowest
	$(INSTALL) --python out/lowest/bin/python --resolution lowest-direct --editable '.[test]'
	VIRTUAL_ENV=$(CURDIR)/out/lowest out/lowest/bin/python -m pytest -n auto

licences: $(VENV)/.built  ## the licences of the crates that the extension contains, into THIRD_PARTY_LICENCES.yml
	cd bindings && cargo bundle-licenses --previous ../THIRD_PARTY_LICENCES.yml --format yaml --output ../THIRD_PARTY_LICENCES.yml --prefer MIT

test-wheel: wheel  ## installs the wheel in an environment without Rust, and the source distribution, and runs 1999 KW4 from both
	$(BIN)/python tests/installed.py dist

browser: $(VENV)/.built  ## a page on which 1999 KW4 runs in the browser, into out/browser/
	rustup target add wasm32-unknown-emscripten
	$(BIN)/python browser/build.py out/browser

crate: $(MATURIN)  ## packs the crate, and builds it from the package
	RUSTDOCFLAGS='-D warnings' cargo doc --locked --no-deps
	cargo package --locked --allow-dirty

lint: $(VENV)/.dev  ## formats, lints and types of Python, formats of Rust: the checks of each commit
	cargo fmt --check
	$(BIN)/ruff format --check $(PYTHONS)
	$(BIN)/ruff check $(PYTHONS)
	$(BIN)/mypy

check: lint  ## lint, and the lints of Rust and the stubs
	cargo clippy --locked --workspace --all-targets -- -D warnings
	$(BIN)/python -m mypy.stubtest fullbody._core

fmt:  ## formats everything
	cargo fmt
	$(BIN)/ruff format $(PYTHONS)
	$(BIN)/ruff check --fix $(PYTHONS)

docs: $(VENV)/.docs $(REPORT)/numbers.json $(BINARIES)/numbers.json  ## the documentation, into out/docs/; warnings are errors, examples are run
	cargo doc --locked --no-deps
	FULLBODY_REPORT=$(REPORT) FULLBODY_BINARIES=$(BINARIES) $(BIN)/python -m sphinx -E -W --keep-going -d out/doctrees docs out/docs

notebooks: $(VENV)/.dev  ## execute the notebooks and store their outputs; NOTEBOOKS= names some of them
	$(BIN)/python docs/notebooks.py $(NOTEBOOKS)

film: $(VENV)/.built  ## the film at the head of the README, into docs/didymos.gif
	$(BIN)/python docs/film.py

reproduce: $(REPORT)/numbers.json  ## the reproduction of the whole paper, into out/reproduce/

$(REPORT)/numbers.json: $(VENV)/.docs $(SOURCES)
	$(BIN)/python -m reproduction.ho2021 --out $(REPORT)

millennia: $(VENV)/.built  ## ten thousand years of 1999 KW4 by the symplectic splitting, into out/millennia/; resumes after an interruption
	$(BIN)/python -m reproduction.ho2021.millennia --out out/millennia

fission: $(VENV)/.built  ## rotational fission, 19,980 runs after Ho et al. (2022), into out/fission/; resumes after an interruption
	$(BIN)/python -m reproduction.ho2022 --out out/fission

dimorphos: $(VENV)/.built  ## Dimorphos' attitude over its axes after Agrusa et al. (2021), into out/dimorphos/; resumes after an interruption
	$(BIN)/python -m reproduction.agrusa2021 --out out/dimorphos

binaries: $(BINARIES)/numbers.json  ## the astrometry of 27 binaries beyond Neptune, Eris, Lempo and Haumea fitted again, into out/binaries/

$(BINARIES)/numbers.json: $(VENV)/.built $(SOURCES) $(OBSERVATIONS)
	$(BIN)/python -m reproduction.binaries --out $(BINARIES)

# HERA_MEMBERS= sets the number of members, HERA_DASK=local runs them on workers of dask.
hera: $(VENV)/.built  ## what Hera should find at Didymos, 40 members from DART to its survey, into out/hera/; resumes after an interruption
	$(BIN)/python -m reproduction.hera2026 --out out/hera

hera-full: $(VENV)/.built  ## the same as on the page of the documentation, half an hour of processor time, into out/hera-full/
	HERA_WHOLE=1 $(BIN)/python -m reproduction.hera2026 --out out/hera-full

bench: $(VENV)/.dev  ## measurements: criterion, the table beside numpy and scipy, instruction counts, work and precision, round-off, the splitting, import, external forces, gravity at many points, polyhedra, flights, derivatives, fits; collisions missed; a sweep killed twenty times
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

fuzz: $(FUZZ_PARTS)  ## invalid input for every door, for an hour or FUZZ_MINUTES=; faults go to out/fuzz/

fuzz-python: $(VENV)/.dev
	PYTHONPATH=fuzz $(BIN)/python -m doors --minutes $(FUZZ_SHARE)

# Without a sanitizer, for which there is no unsafe code, a stable toolchain suffices.
fuzz-archive fuzz-pairs: fuzz-%:
	mkdir -p out/fuzz/$*
	cargo fuzz run --sanitizer none $* out/fuzz/$* fuzz/corpus/$* -- \
		-max_total_time=$$((60 * $(FUZZ_SHARE))) -timeout=60 -max_len=4096 -artifact_prefix=out/fuzz/$*-

mutants:  ## changes to the Rust code that no Rust test detects, for a module or file of src/: MODULE=dynamics
	@test -n "$(MODULE)" -a -e "src/$(MODULE)" || { echo "no src/$(MODULE); name a module or file of src/, as in: make mutants MODULE=dynamics" >&2; exit 1; }
	cargo mutants --file "src/$(MODULE:/=)$(if $(filter %.rs,$(MODULE)),,/**)" --output out $(MUTANTS)

clean:  ## removes everything that was built
	rm -rf target fuzz/target benches/criterion/target $(VENV) out dist docs/_extra docs/notebooks
	find python reproduction tests -name '__pycache__' -prune -exec rm -rf {} +
	rm -f python/fullbody/*.so
