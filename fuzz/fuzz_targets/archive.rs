//! Hunts with the check of the tests.
#![no_main]

#[path = "../../tests/rust/fuzz_checks/archive.rs"]
mod archive;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| archive::check(bytes));
