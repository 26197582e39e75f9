# Wheels, the source distribution, the crate and the licences, and their tests on other systems.
# The target of `make wheel-musl`.
MUSL   ?= x86_64-unknown-linux-musl
# On Linux zig links wheels against glibc 2.17, so that they run on every distribution since then.
ifeq ($(shell uname -s),Linux)
WHEEL := --zig --compatibility manylinux2014
AUDIT  = $(BIN)/auditwheel show dist/*.whl
endif
.PHONY: wheel wheel-musl licences crate test-wheel test-lowest test-arm release

$(VENV)/.wheel: $(MATURIN)
	$(INSTALL) 'auditwheel>=6.4,<7' 'cargo-zigbuild>=0.20,<1' 'ziglang>=0.13,<1'
	@touch $@

wheel: $(VENV)/.wheel  ## the source distribution and, built from it, the wheel for this kind of machine, into dist/
	@git ls-files --others --exclude-standard | sed 's/^/not tracked by git, so not in the source distribution: /' >&2
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

licences: $(VENV)/.built  ## the licences of the crates that the extension contains, into packaging/
	cd bindings && cargo bundle-licenses --previous ../packaging/THIRD_PARTY_LICENCES.yml --format yaml \
		--output ../packaging/THIRD_PARTY_LICENCES.yml --prefer MIT

test-wheel: wheel  ## installs the wheel in an environment without Rust, and the source distribution, and runs 1999 KW4 from both
	$(BIN)/python tests/installed.py dist

crate: $(MATURIN)  ## packs the crate, and builds it from the package
	RUSTDOCFLAGS='-D warnings' cargo doc --locked --no-deps
	cargo package --locked --allow-dirty

# This needs Debian's packages qemu-user and libc6-arm64-cross.
test-arm: $(VENV)/.wheel  ## the Rust tests on 64-bit ARM, emulated by QEMU
	rustup target add aarch64-unknown-linux-gnu
	CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER='qemu-aarch64 -L /usr/aarch64-linux-gnu' \
		$(BIN)/cargo-zigbuild test --target aarch64-unknown-linux-gnu --test rust

# CONTRIBUTING.md has the steps after it, which need accounts. A version such as 0.4.0.dev0 is written and committed without the checks.
release: $(VENV)/.dev  ## write VERSION=, check everything for hours, commit and tag
	@test -z "$$(git status --porcelain)" || { echo "there are changes that are not committed" >&2; exit 1; }
	$(BIN)/python packaging/release.py $(VERSION)
	$(if $(findstring dev,$(VERSION)),,$(MAKE) licences && bash .ci/run && $(MAKE) test-wheel crate test-lowest bench fuzz)
	git commit --all --message "Version $(VERSION)"
	$(if $(findstring dev,$(VERSION)),,git tag v$(VERSION))
