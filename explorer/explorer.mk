# The page on which binary asteroids are explored in a browser, and its tests.

# The program has to have the version of the library.
$(VENV)/.explorer: $(VENV)/.built Cargo.lock
	rustup target add wasm32-unknown-unknown
	cargo install wasm-bindgen-cli --root $(VENV) --version "$$(sed -n '/^name = "wasm-bindgen"$$/{n;s/.*"\(.*\)"/\1/p}' Cargo.lock)"
	@touch $@

explorer: $(VENV)/.explorer  ## the page on which binary asteroids are explored in a browser, into out/explorer/
	$(BIN)/python explorer/build.py out/explorer

# It needs Chromium: CHROMIUM= is its path where it is not among the programs.
test-explorer: $(VENV)/.dev explorer  ## the tests of that page in a headless Chromium, with pictures beside it
	$(INSTALL) 'playwright>=1.50,<2'
	$(BIN)/python -m pytest -n 0 tests/explorer
