//! The overlap of two ellipsoids, exact even for bodies so thin that rounding begins to matter.
//!
//! An ellipsoid extends by h(n) = |diag(a) R^T n| from its centre along a direction n. Two ellipsoids whose
//! centres are r apart touch when both are enlarged by the factor
//!
//!   g = max over n of  n.r / (h_A(n) + h_B(n)),
//!
//! so that g > 1 for separate, g = 1 for touching and g < 1 for overlapping bodies. Let A = R diag(a^2) R^T.
//! Since (h_A + h_B)^2 is the minimum over t of (1 + 1/t) (h_A^2 + t h_B^2), which is reached at t = h_A/h_B,
//! the maximum lies at n along w = (A + t B)^-1 r. Then g^2 is the contact function of Perram & Wertheim
//! (1985), J. Comput. Phys. 58, 409: F = max over s in [0, 1] of s (1-s) r^T [(1-s) A + s B]^-1 r, with t = s
//! / (1-s).
//!
//! The weight t is found by Newton's iteration for ln(h_A/h_B) - ln t = 0, whose left side falls: with q = t
//! w.B (A + t B)^-1 B w / w.B w its derivative with respect to ln t is -(1 - q) (1 + t h_B^2/h_A^2).

use super::{Placement, Shape, gap_between};
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};

/// The factor by which two bodies must grow, each about its centre, to touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Growth {
    /// The factor: above one for separate bodies, one for touching ones, below one for overlapping ones, and
    /// infinite for two points.
    pub factor: f64,
    /// A bound of the factor's relative error by the rounding of the separation and of the rotation matrices.
    ///
    /// It is 8 epsilon (|r|/g + a_A + a_B) / (h_A + h_B) with the longest semi-axes a: rounding moves the
    /// surfaces by a fraction of the longest axes, which matters relative to the extent of the bodies along
    /// their common normal. For compact bodies it is 1e-14; for discs of c/a = 1e-8 face to face, or crossed
    /// needles as thin, it is 2e-7. A second-order term is added for bodies so thin that rounding rotates the
    /// normal.
    pub uncertainty: f64,
}

impl Growth {
    /// Bodies this close to contact count as touching: rounding makes a computed contact of compact bodies
    /// this uncertain.
    const TOUCHING: f64 = 5e-14;
    /// The uncertainty near contact above which bodies are too thin to tell whether they overlap.
    const TELLING: f64 = 1e-3;

    /// Adds the rounding of the parts' positions, for two parts at this distance from each other, with this
    /// sum of their circumradii and these positions in their bodies.
    pub fn with_levers(self, distance: f64, circumradii: f64, placements: [Option<Placement>; 2]) -> Self {
        let levers: f64 = placements.iter().flatten().map(|placement| placement.position.norm()).sum();
        if levers == 0.0 || self.factor == 0.0 {
            return self;
        }
        Self {
            uncertainty: self.uncertainty * (1.0 + levers / (distance / self.factor + circumradii)),
            ..self
        }
    }

    /// Returns whether the interiors of two bodies share a point; the names are used in the error.
    ///
    /// Bodies that touch within the uncertainty do not overlap. Where the uncertainty exceeds a thousandth
    /// and leaves open whether they overlap, this is an error.
    pub fn overlap(&self, first: &str, second: &str) -> Result<bool> {
        let depth = 1.0 - self.factor;
        if self.uncertainty > Self::TELLING && depth.abs() <= self.uncertainty {
            return Err(Error::invalid(
                format!("gap between {first} and {second}"),
                format!("{:.1e} of their thickness, known to {:.1e}", -depth, self.uncertainty),
                "thicker bodies or a wider gap: these are too thin to tell whether they overlap",
            ));
        }
        Ok(depth > self.uncertainty.max(Self::TOUCHING))
    }
}

/// Returns the factor by which two bodies must grow to touch.
///
/// `separation` runs from the first centre to the second; the matrices rotate the body frames into its frame. An
/// interruption names `time`.
///
/// # Errors
/// [`Error::Interrupted`].
pub fn growth(
    shapes: [&Shape; 2],
    separation: &Vec3,
    rotations: [&Mat3; 2],
    time: f64,
    interrupt: &mut InterruptCheck,
) -> Result<Growth> {
    let largest = separation.amax();
    if largest == 0.0 {
        return Ok(Growth { factor: 0.0, uncertainty: 0.0 });
    }
    let radii = shapes.map(Shape::circumradius);
    if let Some(gap) = gap_between(shapes, separation, rotations, time, interrupt)? {
        return Ok(shrinkage(gap, separation.norm(), radii[0] + radii[1]));
    }
    let scale = radii[0].max(radii[1]);
    if scale == 0.0 {
        return Ok(Growth { factor: f64::INFINITY, uncertainty: 0.0 });
    }
    // In units of the larger body and of the separation, no number over- or underflows.
    let separation = separation / largest;
    let bodies = [0, 1].map(|k| Axes::new(shapes[k], rotations[k], scale));
    let unit = TwoEllipsoids { bodies, direction: separation.normalize() }.growth();
    Ok(Growth { factor: unit.factor * (largest / scale * separation.norm()), ..unit })
}

/// Returns a measure like growth for two shapes of which at least one is a polyhedron. They need not be
/// convex, so that growth says little. The measure is |r| / (|r| - gap), where |r| is the separation and gap
/// the part of it that can be removed before the shapes touch; for two spheres it equals their growth.
fn shrinkage(gap: f64, distance: f64, circumradii: f64) -> Growth {
    // A shape in a concavity of another one may have a gap longer than the separation.
    let remaining = (distance - gap).max(1e-3 * distance);
    Growth {
        factor: distance / remaining,
        uncertainty: 8.0 * f64::EPSILON * (distance + circumradii) / remaining,
    }
}

/// The semi-axes of a body, in both frames.
struct Axes {
    vectors: [Vec3; 3],
    shortest: f64,
    longest: f64,
}

impl Axes {
    /// Takes a shape in units of `scale`.
    fn new(shape: &Shape, rotation: &Mat3, scale: f64) -> Self {
        // Below these ratios an axis is lost in the rounding of the body's longest one, and a body in that of
        // the other.
        const THINNEST: f64 = 1e-17;
        const SMALLEST: f64 = 1e-150;
        let thinnest = THINNEST * shape.circumradius();
        let lengths = shape.semi_axes().map(|a| (a.max(thinnest) / scale).max(SMALLEST));
        Self {
            vectors: [0, 1, 2].map(|i| rotation.column(i) * lengths[i]),
            shortest: lengths.into_iter().fold(f64::INFINITY, f64::min),
            longest: lengths.into_iter().fold(0.0, f64::max),
        }
    }
}

struct TwoEllipsoids {
    bodies: [Axes; 2],
    /// The unit vector along the separation, whose length is the unit of length.
    direction: Vec3,
}

/// The values of the search at one weight t.
struct Trial {
    /// The ratio n.r / (h_A(n) + h_B(n)), a lower bound of its maximum over n.
    growth: Growth,
    /// The difference ln(h_A/h_B) - ln t, which is zero at the solution.
    residual: f64,
    /// The derivative of the excess with respect to ln t, with the sign reversed.
    slope: f64,
}

impl TwoEllipsoids {
    fn growth(&self) -> Growth {
        /// The largest number of trials; as many halvings reduce the widest bracket to the last digit.
        const MAX_TRIALS: usize = 60;
        /// The relative accuracy of t that suffices. The factor is flat at its maximum, so that half the
        /// digits of t give all digits of the factor.
        const ENOUGH: f64 = 1e-8;
        let [a, b] = &self.bodies;
        // The weight t = h_A/h_B lies between these bounds, whatever the sizes.
        let (mut low, mut high) = ((a.shortest / b.longest).ln(), (a.longest / b.shortest).ln());
        let along = |body: &Axes| body.vectors.iter().map(|v| v.dot(&self.direction).powi(2)).sum::<f64>();
        let mut u = (0.5 * (along(a) / along(b)).ln()).clamp(low, high);
        let mut best = Growth { factor: 0.0, uncertainty: 0.0 };
        for _ in 0..MAX_TRIALS {
            let trial = self.trial(u);
            if trial.growth.factor > best.factor {
                best = trial.growth;
            }
            let bound = if trial.residual > 0.0 { &mut low } else { &mut high };
            *bound = u;
            // A derivative without a correct digit leads out of the bracket.
            let newton = u + trial.residual / trial.slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - u).abs() <= ENOUGH {
                break;
            }
            u = next;
        }
        best
    }

    /// Returns the direction n and its factor for the weight t = e^u.
    ///
    /// In the sum A + t B the square of a thin disc's short axis would be lost beside that of a long one. But
    /// A + t B = K^T K, where the rows of K = [diag(a) R_A^T; sqrt(t) diag(b) R_B^T] are the semi-axes. They
    /// are expressed in a frame whose first vector lies along the longest row, and the second along the
    /// longest remainder of the other rows; then each column is divided by its largest entry. Three of the
    /// rows now form a triangle with ones on its diagonal, and no entry is above one, so that det K^T K >= 1:
    /// the product may be formed and inverted.
    fn trial(&self, u: f64) -> Trial {
        let root = (0.5 * u).exp();
        let [a, b, c] = self.bodies[0].vectors;
        let [d, e, f] = self.bodies[1].vectors.map(|axis| axis * root);
        let rows = [a, b, c, d, e, f];
        let x = longest(rows).normalize();
        let y = longest(rows.map(|row| row - x * x.dot(&row))).normalize();
        // The projection is removed twice: after the first time, rounding leaves a part of the first vector
        // in the remainder of a nearly parallel row.
        let y = (y - x * x.dot(&y)).normalize();
        let frame = Mat3::from_columns(&[x, y, x.cross(&y)]).transpose();
        let rows = rows.map(|row| frame * row);
        let size = rows.iter().fold(Vec3::zeros(), |size, row| size.sup(&row.abs()));
        let rows = rows.map(|row| row.component_div(&size));
        let (first, second) = rows.split_at(3);
        let product = rows.iter().fold(Mat3::zeros(), |sum, row| sum + row * row.transpose());
        let [p, q, r] = [0, 1, 2].map(|k| product.column(k).into_owned());
        let cofactors = Mat3::from_columns(&[q.cross(&r), r.cross(&p), p.cross(&q)]);
        let inverse = cofactors / p.dot(&q.cross(&r));

        let separation = (frame * self.direction).component_div(&size);
        let length = separation.amax();
        let separation = separation / length;
        let w = inverse * separation;
        let along = |rows: &[Vec3]| rows.iter().map(|row| row.dot(&w).powi(2)).sum::<f64>().sqrt();
        let (h_first, h_second_times_root) = (along(first), along(second));
        let sum = h_first + h_second_times_root / root;
        let factor = length * (separation.dot(&w) / sum);
        let thickness = sum / w.component_div(&size).norm();
        let [reach, shortest] = [|body: &Axes| body.longest, |body: &Axes| body.shortest]
            .map(|length| self.bodies.iter().map(length).sum::<f64>());
        let moved = 8.0 * f64::EPSILON * (1.0 / factor + reach);
        // A displacement d of the centres adds d^T (A + t B)^-1 d t / (1 + t) to F. For bodies thinner than
        // their rounding the frame's third vector is not even defined.
        let thinnest = if moved < shortest {
            size.z * ((1.0 + root.powi(-2)) / inverse[(2, 2)]).sqrt()
        } else {
            shortest
        };
        let uncertainty = moved / thickness + 0.5 * (moved / thinnest).powi(2);

        let weighted = inverse * second.iter().fold(Vec3::zeros(), |sum, row| sum + row * row.dot(&w));
        let shared = first.iter().map(|row| row.dot(&w) * row.dot(&weighted)).sum::<f64>();
        Trial {
            growth: Growth { factor, uncertainty },
            residual: (h_first / h_second_times_root).ln() - 0.5 * u,
            slope: shared * (h_first.powi(-2) + h_second_times_root.powi(-2)),
        }
    }
}

fn longest(rows: [Vec3; 6]) -> Vec3 {
    let longer = |a: Vec3, b: Vec3| if b.norm_squared() > a.norm_squared() { b } else { a };
    rows.into_iter().fold(Vec3::zeros(), longer)
}
