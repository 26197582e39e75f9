#!/usr/bin/env python3
"""The linker of the extension module for browsers: cargo calls it as it would call Emscripten's ``emcc``.

A module that is all Rust takes the C library and Python from the program that loads it, so that the linker that comes
with Rust does, and Emscripten is not needed.
"""

import subprocess
import sys
from pathlib import Path


def main(arguments: list[str]) -> int:
    """Link the objects that are named, and nothing else of what Emscripten is told."""
    told = [line for argument in arguments for line in (listed(argument) if argument[0] == "@" else [argument])]
    objects = [argument for argument in told if argument.endswith((".o", ".rlib", ".a"))]
    output = told[told.index("-o") + 1]
    options = ["--experimental-pic", "-shared", "--no-entry", "--gc-sections", "--strip-debug", "--no-export-dynamic"]
    options += ["--unresolved-symbols=import-dynamic", "--export=PyInit__core"]
    return subprocess.call([linker(), "-flavor", "wasm", *options, "-o", output, *objects])


def listed(argument: str) -> list[str]:
    """The arguments in a file that stands for them."""
    return [line.strip().strip('"') for line in Path(argument[1:]).read_text().splitlines()]


def linker() -> str:
    """Rust's own."""
    sysroot = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=True).stdout
    (found,) = Path(sysroot.strip()).glob("lib/rustlib/*/bin/rust-lld*")
    return str(found)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
