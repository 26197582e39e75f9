# On a machine with Python >= 3.11, a Rust toolchain and make:
#   make kw4     one year of 1999 KW4 beside the paper's numbers
#   make test    all tests, Rust and Python
#   make docs    the documentation, with every example run
VENV   ?= .venv
BIN    := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
PYTHON ?= python3
MATURIN := $(BIN)/maturin$(if $(filter Windows_NT,$(OS)),.exe)
# The studies of `make study`, each with its module in reproduction/ and its results in out/.
STUDIES := ho2021:ho2021 kw4:ho2021.kw4_year millennia:ho2021.millennia fission:ho2022 dimorphos:agrusa2021 \
	binaries:binaries kalliope:kalliope hertha:hertha kw4_radar:kw4_radar hera:hera2026 hera-full:hera2026
MODULE_OF_STUDY = $(patsubst $(S):%,%,$(filter $(S):%,$(STUDIES)))
BENCHES := table instructions work_precision brouwer splitting import_time forces gravity photometry polyhedra derivatives \
	fitting flight head_on ensemble killed harmonic peers radar shapes coverage peers_inversion
RUST   := Cargo.toml Cargo.lock bindings/Cargo.toml $(shell find src bindings/src -type f)
# Folders with Python code, and the settings of the tests.
PYTHONS := conftest.py python reproduction tests benches fuzz explorer packaging
# The extension links against this interpreter's ABI.
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
# Windows separates folders in PATH by a semicolon.
export PATH := $(CURDIR)/$(BIN)$(if $(findstring ;,$(PATH)),;,:)$(PATH)
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
# The extension is built with the versions of Cargo.lock, or not at all.
export MATURIN_PEP517_ARGS := --locked
# Uv installs in seconds what takes pip a minute. It would take the extension from its cache although it has been removed.
INSTALL := $(BIN)/uv pip install --quiet --reinstall-package fullbody
# Bytecode is written, since tests start many interpreters that reuse it.
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n auto
COVERAGE := $(BIN)/python -m coverage

.DEFAULT_GOAL := help
.PHONY: help kw4 study quick test test-rust test-python test-reproduction coverage explorer test-explorer lint check fmt address docs notebooks film bench mutants clean

help:  ## this list
	@grep -hE '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 20

$(MATURIN):
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet 'maturin>=1.9,<2' 'uv>=0.8,<1'

$(VENV)/.built: $(MATURIN) pyproject.toml $(RUST)
	$(INSTALL) --no-build-isolation --editable '.[all]'
	@touch $@

$(VENV)/.dev $(VENV)/.docs: $(VENV)/.%: $(VENV)/.built
	$(INSTALL) --no-build-isolation --editable '.[$*]'
	@touch $@

kw4: $(VENV)/.built  ## one year of 1999 KW4 beside the paper's numbers, into out/kw4/
	$(BIN)/python -m reproduction.ho2021.kw4_year --out out/kw4

# `hera` is a small version of `hera-full`; see reproduction/README.md, also for the time that each takes.
study: $(VENV)/.docs  ## a study with its report, into out/; S= is one of those that reproduction/README.md lists, as S=hera
	@test -n "$(MODULE_OF_STUDY)" || { echo "no study '$(S)'; S= is one of: $(foreach s,$(STUDIES),$(firstword $(subst :, ,$s)))" >&2; exit 1; }
	$(if $(filter %-full,$(S)),HERA_WHOLE=1) $(BIN)/python -m reproduction.$(MODULE_OF_STUDY) --out out/$(S)

test: test-rust test-python  ## all tests

# They run what the extension has been built from. `cargo test` alone builds it with checks of overflow, and in parts.
test-rust:
	cargo test --locked --release --workspace

test-python: $(VENV)/.dev
	$(PYTEST)

test-reproduction: $(VENV)/.dev  ## the tests of the studies in reproduction/
	$(PYTEST) reproduction/tests

coverage: $(VENV)/.dev  ## the lines of the package that no test executes, as a table and as pages in out/coverage/
	mkdir -p out/coverage && $(COVERAGE) erase
	$(COVERAGE) run -m pytest -n auto tests/python python/fullbody
	$(COVERAGE) combine --quiet && $(COVERAGE) html --quiet && $(COVERAGE) report

lint: $(VENV)/.dev  ## formats, lints and types of Python, formats of Rust: the checks of each commit
	cargo fmt --check
	$(BIN)/ruff format --check $(PYTHONS)
	$(BIN)/ruff check $(PYTHONS)
	$(BIN)/mypy

quick: $(VENV)/.dev  ## a first check within a minute: lints, the rules of the package, and the tests in TESTS=
	$(BIN)/ruff check $(PYTHONS)
	$(PYTEST) -q tests/python/package/test_layers.py tests/python/package/test_import.py tests/python/package/test_objects.py $(TESTS)

check: lint  ## lint, and the lints of Rust and the stubs
	cargo clippy --locked --workspace --all-targets -- -D warnings
	cargo clippy --locked --no-default-features -- -D warnings
	rustup target add wasm32-unknown-unknown
	cargo check --locked --package fullbody-web --target wasm32-unknown-unknown
	$(BIN)/python -m mypy.stubtest fullbody._core

fmt:  ## formats everything
	cargo fmt
	$(BIN)/ruff format $(PYTHONS)
	$(BIN)/ruff check --fix $(PYTHONS)

address:  ## the address of the source in pyproject.toml, written into the README and the citation
	$(PYTHON) packaging/address.py

# Numbers of studies that have run (S=ho2021, S=binaries) are shown; the pages of the others say so.
docs: $(VENV)/.docs  ## the documentation, into out/docs/, in some minutes; warnings are errors, examples are run
	@echo "Rust's documentation (a minute), then all pages with their examples (three to five minutes on two cores), into out/docs/."
	cargo doc --locked --no-deps
	rm -rf out/docs/_modules  # Sphinx does not write a listing again whose source is older
	$(BIN)/python -m sphinx -E -W --keep-going -d out/doctrees docs out/docs
	$(BIN)/python docs/links.py out/docs

notebooks: $(VENV)/.dev  ## execute the notebooks and store their outputs; NOTEBOOKS= names some of them
	$(BIN)/python docs/notebooks.py $(NOTEBOOKS)

film: $(VENV)/.built  ## the film at the head of the README, into docs/didymos.gif
	$(BIN)/python docs/film.py

bench: $(VENV)/.dev  ## all measurements of speed and accuracy in benches/
	cargo bench --manifest-path benches/criterion/Cargo.toml
	set -e; for name in $(BENCHES); do $(BIN)/python benches/$$name.py; done

mutants:  ## changes to the Rust code that no Rust test detects, for a module or file of src/: MODULE=dynamics
	@test -n "$(MODULE)" -a -e "src/$(MODULE)" || { echo "no src/$(MODULE); name a module or file of src/, as in: make mutants MODULE=dynamics" >&2; exit 1; }
	cargo mutants --file "src/$(MODULE:/=)$(if $(filter %.rs,$(MODULE)),,/**)" --output out $(MUTANTS)

clean:  ## removes everything that was built
	rm -rf target fuzz/target benches/criterion/target $(VENV) out dist docs/_extra docs/notebooks docs/reference/pages
	find python reproduction tests -name '__pycache__' -prune -exec rm -rf {} +
	rm -f python/fullbody/*.so

include packaging/packaging.mk explorer/explorer.mk fuzz/fuzz.mk
