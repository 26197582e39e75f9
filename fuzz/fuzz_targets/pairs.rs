//! Hunts with the check of the tests.
#![no_main]

#[path = "../../tests/rust/fuzz_checks/pairs.rs"]
mod pairs;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pairs::check(bytes));
