# Invalid input for all functions that take input from outside; see README.md.
# The time of `make fuzz` in minutes, and its parts, which share it equally.
FUZZ_MINUTES ?= 60
FUZZ_PARTS   := fuzz-python fuzz-archive fuzz-pairs
FUZZ_SHARE    = $(shell expr $(FUZZ_MINUTES) / $(words $(FUZZ_PARTS)))
.PHONY: fuzz $(FUZZ_PARTS)

fuzz: $(FUZZ_PARTS)  ## invalid input for every target, for an hour or FUZZ_MINUTES=; faults go to out/fuzz/

fuzz-python: $(VENV)/.dev
	PYTHONPATH=fuzz $(BIN)/python -m targets --minutes $(FUZZ_SHARE)

# Without a sanitizer, for which there is no unsafe code, a stable toolchain suffices.
fuzz-archive fuzz-pairs: fuzz-%:
	mkdir -p out/fuzz/$*
	cargo fuzz run --sanitizer none $* out/fuzz/$* fuzz/corpus/$* -- \
		-max_total_time=$$((60 * $(FUZZ_SHARE))) -timeout=60 -max_len=4096 -artifact_prefix=out/fuzz/$*-
