//! For two bodies of any shape in any pose the methods agree or return an error of convergence, momentum and
//! angular momentum are conserved, and no result is NaN.

use fullbody::error::{Error, Result};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Mat3, Vec3, rotation};
use fullbody::mutual::{Interaction, Method, Pair, PartGravity, Pose};
use fullbody::shape::{Shape, growth};
use std::sync::Arc;

/// The largest difference of two methods with a tolerance of 1e-14, relative to the force, and for a torque
/// relative to the force times the largest semi-axis of its body.
const AGREEMENT: f64 = 3e-14;
/// The largest relative difference of the energies. The number of nodes is chosen for force and torques, not
/// for the energy; next to contact the surface rule sums tens of thousands of terms.
const ENERGY: f64 = 3e-13;

/// Reads numbers from 0 to 1 from bytes; after the last byte they are zero.
struct Numbers<'a>(std::slice::Iter<'a, u8>);

impl Numbers<'_> {
    fn byte(&mut self) -> u8 {
        self.0.next().copied().unwrap_or_default()
    }

    fn unit(&mut self) -> f64 {
        let three = [self.byte(), self.byte(), self.byte()].map(u32::from);
        f64::from(three[0] << 16 | three[1] << 8 | three[2]) / f64::from(0x00ff_ffff)
    }

    /// Returns any rotation.
    fn turn(&mut self) -> Mat3 {
        let q: [f64; 4] = std::array::from_fn(|_| 2.0 * self.unit() - 1.0);
        let is_nonzero = q.iter().map(|x| x * x).sum::<f64>() > 1e-6;
        if is_nonzero { rotation::matrix(rotation::normalised(q)) } else { Mat3::identity() }
    }

    /// Returns a point, a sphere, or an ellipsoid with a ratio of the axes of 1e-7 or more.
    fn shape(&mut self, size: f64) -> Shape {
        let thin = |x: f64| size * 10f64.powf(-7.0 * x * x);
        let axes = match self.byte() % 8 {
            0 => return Shape::Point,
            1 => [size; 3],
            2 => [size, size, thin(self.unit())],
            3 => {
                let width = thin(self.unit());
                [width, size, width]
            }
            _ => [thin(self.unit()), thin(self.unit()), size],
        };
        Shape::ellipsoid(axes).expect("an ellipsoid")
    }
}

/// Checks all methods for the two bodies and the pose that the bytes describe.
pub fn check(bytes: &[u8]) {
    let mut input = Numbers(bytes.iter());
    let size = 10f64.powf(-6.0 * input.unit());
    let shapes = [input.shape(1.0), input.shape(size)];
    let [first, second] = [input.turn(), input.turn()];
    let direction = input.turn() * Vec3::x();
    let gap = 10f64.powf(9.0 * input.unit() - 3.0);
    let growth = match &shapes {
        [Shape::Point, Shape::Point] => 1.0,
        [a, b] => {
            let mut interrupt = InterruptCheck::never();
            growth([a, b], &direction, [&first, &second], 0.0, &mut interrupt).expect("no hook").factor
        }
    };
    let separation = direction * ((1.0 + gap) / growth);
    let pose = Pose { separation, rotation_first: first, rotation_second: second };
    let back = Pose { separation: -separation, rotation_first: second, rotation_second: first };
    let radii = shapes.each_ref().map(Shape::circumradius);
    let distance = separation.norm();
    // Only for sharp rims and tips near each other may a method not converge.
    let near = distance < 2.0 * radii[0].max(radii[1]);
    let what = format!("{shapes:?} {pose:?}");

    let focal = evaluate([&shapes[0], &shapes[1]], Method::Focal, &pose);
    for method in [Method::Focal, Method::Surface, Method::Multipole(16), Method::Point] {
        let outcome = evaluate([&shapes[0], &shapes[1]], method, &pose);
        let Ok((f, energy)) = &outcome else {
            refused(&outcome, near, &what);
            continue;
        };
        let mut numbers = f.force_on_first.iter().chain(&f.torque_first).chain(&f.torque_second);
        assert!(energy.is_finite() && numbers.all(|x| x.is_finite()), "{method} {f:?} {energy} {what}");
        // Where the circumscribed spheres are near each other, the series does not converge.
        if matches!(method, Method::Multipole(_)) && distance < 2.0 * (radii[0] + radii[1]) {
            continue;
        }
        assert!(*energy < 0.0, "{method} {energy} {what}");
        // M_A + M_B + r x F_B = 0, where the last term is a difference of two large numbers.
        let torques = first * f.torque_first + second * f.torque_second;
        let residual = (torques - separation.cross(&f.force_on_first)).norm();
        let arm = distance * f.force_on_first.norm();
        assert!(residual <= AGREEMENT * arm, "{method} balance {:e} {what}", residual / arm);
        // With the bodies exchanged the force is opposite and the torques are exchanged.
        match evaluate([&shapes[1], &shapes[0]], method, &back) {
            Ok((mut swapped, swapped_energy)) => {
                swapped.force_on_first = -swapped.force_on_first;
                std::mem::swap(&mut swapped.torque_first, &mut swapped.torque_second);
                agree((f, *energy), (&swapped, swapped_energy), radii, &format!("{method} swapped {what}"));
            }
            other => refused(&other, near, &what),
        }
        let comparable = match method {
            Method::Surface => true,
            // The truncation error of the series is of the order (a / r)^18.
            Method::Multipole(_) => distance > 30.0 * (radii[0] + radii[1]),
            _ => false,
        };
        if let (true, Ok((expected, expected_energy))) = (comparable, &focal) {
            agree((f, *energy), (expected, *expected_energy), radii, &format!("{method} {what}"));
        }
    }
}

/// Returns force, torques and energy of two bodies at a tolerance of 1e-14.
fn evaluate(shapes: [&Shape; 2], method: Method, pose: &Pose) -> Result<(Interaction, f64)> {
    let store = Arc::default();
    let [a, b] = [PartGravity::new("A", shapes[0], &store), PartGravity::new("B", shapes[1], &store)];
    let mut pair = Pair::new(a, b, method, 1e-14, None, VectorPath::Auto.arch().expect("a path"));
    pair.prepare(pose, 0.0, &mut InterruptCheck::never())?;
    Ok((pair.interaction(pose), pair.potential_energy(pose)))
}

/// Asserts that an outcome is the error of a method that does not converge, for bodies near each other.
#[track_caller]
fn refused<T: std::fmt::Debug>(outcome: &Result<T>, near: bool, what: &str) {
    assert!(near && matches!(outcome, Err(Error::NotConverged { .. })), "{outcome:?} {what}");
}

/// Asserts that two results agree; the comparisons are written so that NaN fails.
#[track_caller]
fn agree(actual: (&Interaction, f64), expected: (&Interaction, f64), radii: [f64; 2], what: &str) {
    let ((f, energy), (g, expected_energy)) = (actual, expected);
    let force = g.force_on_first.norm();
    for (quantity, difference, scale) in [
        ("force", f.force_on_first - g.force_on_first, force),
        ("torque on A", f.torque_first - g.torque_first, force * radii[0]),
        ("torque on B", f.torque_second - g.torque_second, force * radii[1]),
    ] {
        let difference = difference.norm();
        assert!(difference <= AGREEMENT * scale, "{quantity} {:e} {what}", difference / scale);
    }
    let difference = (energy / expected_energy - 1.0).abs();
    assert!(difference <= ENERGY, "energy {energy:e} {expected_energy:e} {what}");
}
