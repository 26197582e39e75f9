//! The first overlap of two parts of two bodies on a piece of the continuous solution.
//!
//! Intervals of the piece are proved to be free of overlap, one after the other, each as long as possible
//! (conservative advancement). In an interval a plane between the bodies rotates with the line of their
//! centres. Its gaps to the bodies at the interval's ends and middle give a parabola, and bounds of the third
//! derivatives of the polynomials limit how far the gap can differ from it. Where the parabola minus that
//! difference is positive the bodies are apart, so that no dip is too short to be seen. Otherwise the
//! interval is halved, until there is an overlap in its middle or it is too short for one.
//!
//! A polyhedron and another body need not have a separating plane. For them the gap in the middle is compared with the
//! largest distance that any point can move.

use crate::dynamics::{AttitudeChart, Layout};
use crate::error::Result;
use crate::integrate::{Segment, root};
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3, rotation};
use crate::shape::{Growth, Part, Placement, Shape, gap_between, growth, normal, support};
use nalgebra::Rotation3;

/// Half of the shortest interval, as a fraction of the piece. Between two times this close to each other even
/// the tips of needles penetrate each other by less than rounding.
const SHORTEST: f64 = 1.0 / (1_u64 << 34) as f64;

/// The overlap, relative to the bodies' sizes, that counts as touching. It is half of the tolerance in
/// [`growth`], which refers to the square of a size.
const TOUCHING: f64 = 5e-14;

/// The units of work of an interval.
const WORK: u64 = 100;

/// A part of one body and a part of another on a piece.
pub(super) struct Encounter<'a> {
    piece: &'a Segment,
    layout: Layout,
    bodies: [usize; 2],
    shapes: [&'a Shape; 2],
    /// The positions and rotations of the parts in their bodies; `None` for a part that is at the origin.
    placements: [Option<Placement>; 2],
    names: [&'a str; 2],
    /// Bounds of the first three derivatives with respect to the fraction of the piece, of the separation of
    /// the bodies and of the numbers of each attitude.
    separation: [f64; 3],
    attitudes: [[f64; 3]; 2],
    /// The parameter of the last plane that was found.
    balance: f64,
}

/// The result of the test of an interval.
enum Verdict {
    /// There is no overlap in the interval.
    Clear,
    /// There is no overlap in its middle.
    Apart,
    Unknown,
}

impl<'a> Encounter<'a> {
    pub fn new(
        piece: &'a Segment,
        layout: Layout,
        bodies: [usize; 2],
        parts: [&'a Part; 2],
        names: [&'a str; 2],
    ) -> Self {
        let [first, second] = bodies.map(|body| piece.derivative_bounds(layout.position(body), 3));
        let width = layout.chart.width();
        let attitude = |body| match layout.chart {
            AttitudeChart::Quaternion => piece.derivative_bounds(layout.attitude(body), width),
            // The rate of an angle is that of a rotation about an axis, and three of them add up at most.
            AttitudeChart::TaitBryan => (0..width).fold([0.0; 3], |sum, c| {
                let rates = piece.derivative_bounds(layout.attitude(body) + c, 1);
                [0, 1, 2].map(|k| sum[k] + rates[k])
            }),
        };
        Self {
            piece,
            layout,
            bodies,
            shapes: parts.map(|part| &part.shape),
            placements: parts.map(|part| part.placement),
            names,
            separation: [0, 1, 2].map(|k| first[k] + second[k]),
            attitudes: bodies.map(attitude),
            balance: 0.0,
        }
    }

    /// Returns the fraction of the piece, before `until`, at which the parts first touch and then overlap.
    pub fn first(&mut self, until: f64, interrupt: &mut InterruptCheck) -> Result<Option<f64>> {
        let (mut clear, mut end, mut inside) = (0.0, until, false);
        let mut half = 0.5 * until;
        while end - clear > if inside { SHORTEST } else { 0.0 } {
            interrupt.charge(WORK, self.piece.start())?;
            let remaining = 0.5 * (end - clear);
            half = half.min(remaining);
            let middle = clear + half;
            let verdict = self.verdict(middle, half, interrupt)?;
            let overlap = matches!(verdict, Verdict::Unknown) && self.overlap(middle, interrupt)?;
            if overlap {
                (end, inside) = (middle, true);
                half *= 0.5;
            } else if matches!(verdict, Verdict::Clear) || half <= SHORTEST {
                clear = if half < remaining { middle + half } else { end };
                half *= 2.0;
            } else {
                half *= 0.5;
            }
        }
        if inside { self.touch(clear, end, interrupt).map(Some) } else { Ok(None) }
    }

    /// Returns where the surfaces touch before the overlap at `end`; there is no overlap up to `clear`.
    fn touch(&self, clear: f64, end: f64, interrupt: &mut InterruptCheck) -> Result<f64> {
        let mut depth = |theta: f64| Ok(self.growth(theta, interrupt)?.factor - 1.0);
        let (mut start, mut back) = (clear, SHORTEST);
        // Overlap within rounding counts as clear.
        while start > 0.0 && depth(start)? <= 0.0 {
            start = (end - back).clamp(0.0, start);
            back *= 2.0;
        }
        let (first, last) = (depth(start)?, depth(end)?);
        if first <= 0.0 || last >= 0.0 {
            return Ok(start);
        }
        root(depth, (start, first), (end, last))
    }

    /// Returns the factor by which the parts must grow to touch.
    fn growth(&self, theta: f64, interrupt: &mut InterruptCheck) -> Result<Growth> {
        let basis = self.piece.basis(theta);
        let separation = self.separation(&basis);
        let [first, second] = [0, 1].map(|part| self.rotation(part, &basis).0);
        let growth = growth(self.shapes, &separation, [&first, &second], self.piece.start(), interrupt)?;
        let circumradii = self.shapes.map(Shape::circumradius).iter().sum();
        Ok(growth.with_levers(separation.norm(), circumradii, self.placements))
    }

    /// Returns whether the parts overlap.
    fn overlap(&self, theta: f64, interrupt: &mut InterruptCheck) -> Result<bool> {
        self.growth(theta, interrupt)?.overlap(self.names[0], self.names[1])
    }

    /// Returns the vector from the first part's centre to the second's.
    fn separation(&self, basis: &Basis) -> Vec3 {
        let [first, second] = self.bodies.map(|body| self.layout.position(body));
        let mut separation = Vec3::from(
            [0, 1, 2].map(|c| self.piece.number(basis, second + c) - self.piece.number(basis, first + c)),
        );
        for (which, sign) in [(0, -1.0), (1, 1.0)] {
            if let Some(placement) = &self.placements[which] {
                separation += self.body_rotation(which, basis).0 * placement.position * sign;
            }
        }
        separation
    }

    /// Returns the rotation of one of the parts, and the length of the quaternion of its body.
    fn rotation(&self, which: usize, basis: &Basis) -> (Mat3, f64) {
        let (rotation, length) = self.body_rotation(which, basis);
        (self.placements[which].map_or(rotation, |placement| rotation * placement.rotation), length)
    }

    /// Returns the rotation of one of the bodies, and the length of its quaternion.
    fn body_rotation(&self, which: usize, basis: &Basis) -> (Mat3, f64) {
        let index = self.layout.attitude(self.bodies[which]);
        let number = |c: usize| self.piece.number(basis, index + c);
        match self.layout.chart {
            AttitudeChart::Quaternion => {
                let q = [0, 1, 2, 3].map(number);
                (rotation::matrix(q), q.iter().map(|x| x * x).sum::<f64>().sqrt())
            }
            AttitudeChart::TaitBryan => (rotation::tait_bryan_matrix([0, 1, 2].map(number)), 1.0),
        }
    }

    /// Tests the interval of this half length about its middle.
    fn verdict(&mut self, middle: f64, half: f64, interrupt: &mut InterruptCheck) -> Result<Verdict> {
        /// The largest value of x (x^2 - 1) / 6 between 0 and 1: the error of the parabola through three
        /// points of a cubic.
        const PARABOLA_ERROR: f64 = 0.064_150_029_909_958_42;
        let bases = [middle - half, middle, middle + half].map(|theta| self.piece.basis(theta));
        let r = bases.each_ref().map(|basis| self.separation(basis));
        let distance = r[1].norm();
        if distance == 0.0 {
            return Ok(Verdict::Unknown);
        }
        let rotation_vector = r[1].cross(&(r[2] - r[0])) / (2.0 * half * distance * distance);
        let along = Rotation3::new(rotation_vector * half);
        let following = |n: Vec3| [along.inverse_transform_vector(&n), n, along * n];
        let w = rotation_vector.norm();
        let Some([v, a, j]) = self.separation_bounds(&bases[1], half) else { return Ok(Verdict::Unknown) };
        let cubic = j + 3.0 * w * (a + w * v) + w * w * w * (distance + v * half);
        let least = |gap: [f64; 3], cubic: f64| parabola(gap) - PARABOLA_ERROR * cubic * half * half * half;

        // The circumscribed spheres are tried first.
        let radii = self.shapes[0].circumradius() + self.shapes[1].circumradius();
        let n = following(r[1] / distance);
        let gap = [0, 1, 2].map(|k| n[k].dot(&r[k]) - radii);
        let faceted = self.shapes.iter().any(|shape| matches!(shape, Shape::Polyhedron(_)));
        let spherical = !faceted && self.shapes.iter().all(|shape| focal_square(shape) == 0.0);
        if least(gap, cubic) >= if spherical { -TOUCHING * radii } else { 0.0 } {
            return Ok(Verdict::Clear);
        }
        let undecided = |gap: f64| if gap > 0.0 { Verdict::Apart } else { Verdict::Unknown };
        if spherical {
            return Ok(undecided(gap[1]));
        }

        if faceted {
            return self.between_faces(&bases[1], &r[1], v, half, interrupt);
        }

        let rotations = bases.each_ref().map(|basis| [0, 1].map(|which| self.rotation(which, basis)));
        let [(first, _), (second, _)] = &rotations[1];
        let Some(n) = normal(self.shapes, [first, second], &r[1], &mut self.balance) else {
            return Ok(Verdict::Unknown);
        };
        let n = following(n);
        let mut gap = [0, 1, 2].map(|k| n[k].dot(&r[k]));
        let (mut cubic, mut sizes) = (cubic, 0.0);
        for which in [0, 1] {
            let shape = self.shapes[which];
            let h = support(shape, &rotations[1][which].0, &n[1]);
            sizes += h;
            if focal_square(shape) == 0.0 {
                gap.iter_mut().for_each(|gap| *gap -= h);
                continue;
            }
            for k in [0, 1, 2] {
                // This expression is no less than the support function, and its square has no sharp bends.
                let other = support(shape, &rotations[k][which].0, &n[k]);
                gap[k] -= 0.5 * (other * other / h + h);
            }
            let Some([p1, p2, p3]) = self.rotation_bounds(which, rotations[1][which].1, half) else {
                return Ok(undecided(gap[1]));
            };
            // The normal in the body's frame rotates with both; h^2 is c^2 plus the square of a vector no
            // longer than the focal axis.
            let (u1, u2) = (p1 + w, p2 + w * (2.0 * p1 + w));
            let u3 = p3 + w * (3.0 * p2 + w * (3.0 * p1 + w));
            cubic += focal_square(shape) * (u3 + 3.0 * u1 * u2) / h;
        }
        Ok(if least(gap, cubic) >= -TOUCHING * sizes { Verdict::Clear } else { undecided(gap[1]) })
    }

    /// Decides for shapes of which one is a polyhedron: the interval is clear if no point can move, in half
    /// of it, by as much as the gap in its middle.
    fn between_faces(
        &self,
        middle: &Basis,
        separation: &Vec3,
        speed: f64,
        half: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<Verdict> {
        let [(first, first_length), (second, second_length)] = [0, 1].map(|k| self.rotation(k, middle));
        let gap = gap_between(self.shapes, separation, [&first, &second], self.piece.start(), interrupt)?;
        let Some(gap) = gap.filter(|gap| *gap > 0.0) else { return Ok(Verdict::Unknown) };
        let rotation_bounds =
            [self.rotation_bounds(0, first_length, half), self.rotation_bounds(1, second_length, half)];
        let [Some([first, ..]), Some([second, ..])] = rotation_bounds else { return Ok(Verdict::Apart) };
        let [a, b] = self.shapes.map(Shape::circumradius);
        Ok(if half * (speed + a * first + b * second) < gap { Verdict::Clear } else { Verdict::Apart })
    }

    /// Returns bounds of the first three derivatives of the separation of the parts, which rotate about the
    /// centres of their bodies.
    fn separation_bounds(&self, middle: &Basis, half: f64) -> Option<[f64; 3]> {
        let mut bounds = self.separation;
        for which in [0, 1] {
            if let Some(placement) = &self.placements[which] {
                let rotation_bounds =
                    self.rotation_bounds(which, self.body_rotation(which, middle).1, half)?;
                let arm = placement.position.norm();
                (0..3).for_each(|k| bounds[k] += arm * rotation_bounds[k]);
            }
        }
        Some(bounds)
    }

    /// Returns bounds of the first three derivatives of a vector that rotates with one of the bodies; `None`
    /// where its quaternion comes near to zero.
    ///
    /// With k_n the bounds of the derivatives of the quaternion over its length, the angular velocity is
    /// below 2 k_1, and its first two derivatives are below 2 k_2 + 4 k_1^2 and 2 k_3 + 14 k_1 k_2 + 20
    /// k_1^3.
    fn rotation_bounds(&self, which: usize, length: f64, half: f64) -> Option<[f64; 3]> {
        let rates = self.attitudes[which];
        let [w, dw, ddw] = match self.layout.chart {
            AttitudeChart::TaitBryan => rates,
            AttitudeChart::Quaternion => {
                let shortest = length - rates[0] * half;
                if shortest < 0.5 {
                    return None;
                }
                let [k1, k2, k3] = rates.map(|rate| rate / shortest);
                [2.0 * k1, 2.0 * k2 + 4.0 * k1 * k1, 2.0 * k3 + 14.0 * k1 * k2 + 20.0 * k1 * k1 * k1]
            }
        };
        Some([w, w * w + dw, w * w * w + 3.0 * w * dw + ddw])
    }
}

type Basis = [f64; crate::integrate::MAX_TERMS];

/// Returns the square of the larger semi-axis of the focal ellipse.
fn focal_square(shape: &Shape) -> f64 {
    let axes = Vec3::from(shape.semi_axes());
    (axes.max() - axes.min()) * (axes.max() + axes.min())
}

/// Returns the least value between -1 and 1 of the parabola with these values at -1, 0 and 1.
fn parabola([left, middle, right]: [f64; 3]) -> f64 {
    let (curvature, slope) = (0.5 * (left + right) - middle, 0.5 * (right - left));
    if curvature > 0.0 && slope.abs() < 2.0 * curvature {
        middle - 0.25 * slope * slope / curvature
    } else {
        left.min(right)
    }
}
