//! Reference data and comparisons.

use fullbody::error::Result;
use fullbody::gravity::{Attractor, BodyField, GravityOutput, Points};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Mat3, Vec3, rotation};
use fullbody::shape::{Body, Growth, Shape, gap_between};
use proptest::prelude::*;
use proptest::test_runner::Config;
use serde_json::Value;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::f64::consts::TAU;

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

/// Fails unless the error is within the tolerance; for errors that are not relative to one number.
#[track_caller]
pub fn within(error: f64, tolerance: f64, what: impl std::fmt::Display) {
    assert!(error <= tolerance, "{what}: error {error:.2e}, allowed {tolerance:.0e}");
}

/// The message of a refusal.
#[track_caller]
pub fn refusal<T>(result: fullbody::error::Result<T>) -> String {
    match result {
        Ok(_) => panic!("accepted"),
        Err(error) => error.to_string(),
    }
}

/// Any direction.
pub fn direction() -> impl Strategy<Value = Vec3> {
    (-1.0..1.0f64, 0.0..TAU).prop_map(|(z, angle)| {
        let s = (1.0 - z * z).sqrt();
        Vec3::new(s * angle.cos(), s * angle.sin(), z)
    })
}

/// Any attitude.
pub fn turn() -> impl Strategy<Value = Mat3> {
    (direction(), 0.0..TAU).prop_map(|(axis, angle)| rotation_about(&axis, angle))
}

/// Rodrigues' formula: the turn by an angle about a unit axis.
pub fn rotation_about(axis: &Vec3, angle: f64) -> Mat3 {
    let cross = axis.cross_matrix();
    Mat3::identity() + cross * angle.sin() + cross * cross * (1.0 - angle.cos())
}

/// Semi-axes with a ratio of at most `flattest`, in any order.
pub fn semi_axes(flattest: f64) -> impl Strategy<Value = [f64; 3]> {
    [flattest..1.0f64, flattest..1.0f64, flattest..1.0f64]
}

/// Modest numbers of cases, the same ones in every run: a failure belongs to a change, not to luck.
pub fn cases(number: u32) -> Config {
    let rng_seed = proptest::test_runner::RngSeed::Fixed(1930);
    Config { cases: number, max_shrink_iters: 50, failure_persistence: None, rng_seed, ..Config::default() }
}

/// Returns the factor by which two shapes must grow to touch.
pub fn growth(first: &Shape, second: &Shape, separation: &Vec3, a: &Mat3, b: &Mat3) -> Growth {
    let mut interrupt = InterruptCheck::never();
    fullbody::shape::growth([first, second], separation, [a, b], 0.0, &mut interrupt).unwrap()
}

/// Returns the contact function of Perram & Wertheim: the square of the factor by which two shapes must grow to touch.
pub fn contact_function(first: &Shape, second: &Shape, separation: &Vec3, a: &Mat3, b: &Mat3) -> f64 {
    growth(first, second, separation, a, b).factor.powi(2)
}

/// Returns the gap between a polyhedron and another shape, whose frames are parallel.
pub fn parallel_gap(shapes: [&Shape; 2], separation: [f64; 3]) -> f64 {
    let mut interrupt = InterruptCheck::never();
    gap_between(shapes, &separation.into(), [&Mat3::identity(); 2], 0.0, &mut interrupt).unwrap().unwrap()
}

/// A body's gravity in its own frame, at one point after the other.
pub struct FieldOf(BodyField);

impl FieldOf {
    pub fn new(body: &Body, gravitational_constant: f64) -> Self {
        let arch = VectorPath::Auto.arch().unwrap();
        Self(BodyField::new(body, gravitational_constant, arch, &mut InterruptCheck::never()).unwrap())
    }

    pub fn potential(&self, x: &Vec3) -> Result<f64> {
        let mut found = [0.0];
        self.ask(x, GravityOutput::Field(&mut found, &mut [0.0; 3])).map(|()| found[0])
    }

    pub fn field(&self, x: &Vec3) -> Result<Vec3> {
        let mut found = [0.0; 3];
        self.ask(x, GravityOutput::Field(&mut [0.0], &mut found)).map(|()| Vec3::from(found))
    }

    pub fn gradient(&self, x: &Vec3) -> Result<Mat3> {
        let mut found = [0.0; 9];
        self.ask(x, GravityOutput::Gradient(&mut found)).map(|()| Mat3::from_row_slice(&found))
    }

    fn ask(&self, x: &Vec3, output: GravityOutput<'_>) -> Result<()> {
        let attractor = Attractor { field: &self.0, position: Vec3::zeros(), rotation: Mat3::identity() };
        let points = Points { coordinates: x.as_slice(), shape: &[], first_index: 0 };
        points.gravity(&[attractor], output, VectorPath::Auto.arch().unwrap(), &mut InterruptCheck::never())
    }
}
