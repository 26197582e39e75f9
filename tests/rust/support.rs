//! Reference data and comparisons.

use fullbody::math::{Mat3, Vec3, rotation};
use serde_json::Value;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, counting for every thread.
struct Counting;

// SAFETY: hands everything to the system's allocator unchanged; the counter is const and has no destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations that this thread has made so far.
pub fn allocations() -> u64 {
    ALLOCATIONS.with(Cell::get)
}

/// A file of `tests/data`.
pub fn data(name: &str) -> Value {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A number, or a number kept as text for its digits.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

pub fn triple(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| number(&value[i]))
}

pub fn attitude(value: &Value) -> Mat3 {
    rotation::tait_bryan_matrix(triple(value))
}

/// Largest difference of two vectors in units of the expected one's length.
pub fn relative(actual: &Vec3, expected: &Vec3) -> f64 {
    (actual - expected).norm() / expected.norm()
}

/// Fails unless `actual` is within `tolerance` of `expected`, relative to its size.
#[track_caller]
pub fn close(actual: f64, expected: f64, tolerance: f64) {
    let error = ((actual - expected) / expected).abs();
    assert!(
        error <= tolerance,
        "{actual:e} differs from {expected:e} by {error:.2e}, allowed {tolerance:.0e}"
    );
}

#[track_caller]
pub fn close_vector(actual: &Vec3, expected: &Vec3, tolerance: f64) {
    let error = relative(actual, expected);
    assert!(
        error <= tolerance,
        "{actual:?} differs from {expected:?} by {error:.2e}, allowed {tolerance:.0e}"
    );
}
