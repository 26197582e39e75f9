//! The harmonic moments of a shape, with their sizes in each degree.
//!
//! The moments are the means of the solid harmonics of [`crate::math::harmonics`] over the body, in units of
//! the radius R of a sphere that contains the sources of its exterior field: a polyhedron, or the focal
//! ellipse of an ellipsoid. The root mu_l of the sum of their squares in a degree does not change where the
//! body is rotated, and is at most one.

use crate::error::{Error, Result, require_positive};
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::math::exchange::displacement_derivatives;
use crate::math::harmonics::{WeightedHarmonics, count, index, moved, scale_degrees};
use crate::math::lanes::BLOCK;
use crate::shape::{Body, Ellipsoid, InputCoefficients, Shape, StokesCoefficients};
use gauss_quad::GaussLegendre;
use pulp::Arch;
use std::f64::consts::PI;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// The moments of a shape up to a degree.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    /// The moments, in the order of [`index`].
    pub values: Arc<Vec<f64>>,
    /// The sizes mu_l of the degrees.
    pub sizes: Vec<f64>,
    /// The radius R.
    pub radius: f64,
    /// The circumscribed radius, to which torques are relative.
    pub circumradius: f64,
    /// An upper bound of mu_l for all degrees above: an estimate from the last degrees of a body, and zero
    /// for a point, a sphere and Stokes coefficients, which are all there is.
    pub tail: f64,
    shape: Shape,
}

/// The number of degrees from whose largest moments those of higher degrees are estimated: two of them may
/// vanish by symmetry, and the sizes of the others vary.
const ENVELOPE: usize = 6;

impl Moments {
    /// Computes the moments of a shape up to a degree.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn new(shape: &Shape, degree: usize, arch: Arch, interrupt: &mut InterruptCheck) -> Result<Self> {
        let values = match shape {
            Shape::Polyhedron(polyhedron) => polyhedron.harmonic_moments(degree, arch, interrupt)?,
            Shape::Stokes(stokes) => stokes.moments().clone(),
            Shape::Ellipsoid(ellipsoid) if !is_sphere(ellipsoid) => {
                Arc::new(ellipsoid_moments(ellipsoid, degree, arch))
            }
            _ => Arc::new(vec![1.0]),
        };
        let (sizes, envelope) = sizes_and_tail(&values);
        let tail = if matches!(shape, Shape::Stokes(_)) { 0.0 } else { envelope };
        let (radius, circumradius) = (shape.focal_reach(), shape.circumradius());
        Ok(Self { values, sizes, radius, circumradius, tail, shape: shape.clone() })
    }

    /// Returns the highest degree that is known.
    pub fn degree(&self) -> usize {
        self.sizes.len() - 1
    }

    /// Returns whether there are no moments of higher degrees: for a point, a sphere and Stokes coefficients.
    pub fn is_complete(&self) -> bool {
        self.sizes.len() == 1 || matches!(self.shape, Shape::Stokes(_))
    }

    /// Returns the moments up to another degree.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn to_degree(&self, degree: usize, arch: Arch, interrupt: &mut InterruptCheck) -> Result<Self> {
        Self::new(&self.shape, degree, arch, interrupt)
    }

    /// Returns the derivatives of the moments up to a degree in units of the circumscribed radius: with
    /// respect to the semi-axes of an ellipsoid, or to a factor of all lengths of a polyhedron.
    pub fn by_lengths(&self, degree: usize, arch: Arch) -> Vec<Vec<f64>> {
        match &self.shape {
            Shape::Ellipsoid(ellipsoid) => Vec::from(by_semi_axes(ellipsoid, degree, arch)),
            Shape::Polyhedron(_) => {
                let mut by_scale = self.values.to_vec();
                scale_degrees(&mut by_scale, |l| l as f64);
                vec![by_scale]
            }
            Shape::Stokes(_) | Shape::Point => Vec::new(),
        }
    }
}

/// Returns the sizes of the degrees of moments, and the bound of those of all degrees above.
pub(in crate::mutual) fn sizes_and_tail(values: &[f64]) -> (Vec<f64>, f64) {
    let values_of_degree = |l: usize| &values[l * l..count(l)];
    let degrees = values.len().isqrt();
    let sizes: Vec<f64> =
        (0..degrees).map(|l| values_of_degree(l).iter().map(|m| m * m).sum::<f64>().sqrt()).collect();
    let last = degrees.saturating_sub(ENVELOPE).max(1);
    let tail = sizes[last.min(degrees)..].iter().fold(0.0, |a: f64, b| a.max(*b));
    (sizes, tail)
}

/// Returns the Stokes coefficients of a body up to a degree from 2 to 60 in its own frame, with the
/// circumradius as the reference radius.
///
/// # Errors
/// [`Error::InvalidInput`] for another degree and for a point, and [`Error::Interrupted`].
pub fn harmonics(body: &Body, degree: usize, interrupt: &mut InterruptCheck) -> Result<StokesCoefficients> {
    const MAX_DEGREE: usize = 60;
    if !(2..=MAX_DEGREE).contains(&degree) {
        return Err(Error::invalid("degree", degree, format!("a whole number from 2 to {MAX_DEGREE}")));
    }
    body.require_vertices()?;
    let radius = body.circumradius();
    require_positive(&format!("radius of {}", body.name()), radius)?;
    let mut sums = vec![0.0; count(degree)];
    for part in body.parts() {
        let part_moments = Moments::new(&part.shape, degree, Arch::Scalar, interrupt)?;
        let mut means = part_moments.values.to_vec();
        means.resize(count(degree.max(part_moments.degree())), 0.0);
        let (centre, rotation) = (part.position() / radius, part.rotation() * (part_moments.radius / radius));
        let moved = moved(&means, degree, |x| centre + rotation * x);
        sums.iter_mut().zip(moved).for_each(|(sum, mean)| *sum += part.mass / body.mass() * mean);
    }
    scale_degrees(&mut sums, |l| 1.0 / ((2 * l + 1) as f64).sqrt());
    // Rounding would move the centre of mass and the principal axes.
    sums[0] = 1.0;
    StokesCoefficients::VANISHING.iter().for_each(|&index| sums[index] = 0.0);
    let mean_inertia = body.inertia().sum() / 3.0 / body.mass();
    StokesCoefficients::new(InputCoefficients {
        coefficients: sums,
        reference_radius: radius,
        mean_inertia,
        radius,
    })
}

fn is_sphere(ellipsoid: &Ellipsoid) -> bool {
    let [a, b, c] = ellipsoid.semi_axes();
    a == b && b == c
}

/// Points of an ellipsoid, in a unit near its size, with weights.
#[derive(Debug, Default)]
struct WeightedPoints {
    points: [Vec<f64>; 3],
    weights: Vec<f64>,
}

impl WeightedPoints {
    fn push(&mut self, point: Vec3, weight: f64) {
        self.points.iter_mut().zip(point.iter()).for_each(|(list, x)| list.push(*x));
        self.weights.push(weight);
    }

    /// Returns the means of the harmonics up to a degree that do not vanish by the symmetry of an ellipsoid
    /// in x, y and z; the others are zero.
    fn means(mut self, degree: usize, arch: Arch, vanishes: impl Fn(usize, isize) -> bool) -> Vec<f64> {
        let length = self.weights.len().next_multiple_of(BLOCK);
        self.points.iter_mut().chain([&mut self.weights]).for_each(|list| list.resize(length, 0.0));
        let mut sums = vec![0.0; count(degree)];
        let ([x, y, z], weights) = (&self.points, &*self.weights);
        arch.dispatch(WeightedHarmonics { points: [x, y, z], weights, degree, sums: &mut sums });
        for (l, m) in degrees_and_orders(degree) {
            if vanishes(l, m) {
                sums[index(l, m)] = 0.0;
            }
        }
        sums
    }
}

/// Iterates over degrees and orders.
fn degrees_and_orders(degree: usize) -> impl Iterator<Item = (usize, isize)> {
    (0..=degree).flat_map(|l| (-(l as isize)..=l as isize).map(move |m| (l, m)))
}

/// Returns the nodes and weights of Gauss's rule for means over an interval from -1 to 1.
fn gauss(count: usize) -> impl Iterator<Item = (f64, f64)> {
    let rule = GaussLegendre::new(NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN));
    let nodes: Vec<_> = rule.nodes().zip(rule.weights()).map(|(&x, &weight)| (x, 0.5 * weight)).collect();
    nodes.into_iter()
}

/// Iterates over equal angles: cosine and sine.
fn angles(count: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..count).map(move |k| {
        let (sin, cos) = (2.0 * PI * k as f64 / count as f64).sin_cos();
        (cos, sin)
    })
}

/// Returns whether the moments of an order vanish, since an ellipsoid is symmetric in x, y and z.
fn vanishes(l: usize, m: isize) -> bool {
    l % 2 == 1 || m < 0 || m % 2 == 1
}

/// Returns the moments of an ellipsoid: means over its focal ellipse with the density in proportion to
/// t = sqrt(1 - rho^2), rho being one on its edge.
fn ellipsoid_moments(ellipsoid: &Ellipsoid, degree: usize, arch: Arch) -> Vec<f64> {
    let [long, short] = ellipsoid.focal_axes();
    let to_body = ellipsoid.canonical().transpose();
    let mut nodes = WeightedPoints::default();
    for (x, weight) in gauss(degree / 2 + 2) {
        let t = 0.5 * (1.0 + x);
        let rho = (1.0 - t * t).sqrt();
        for (cos, sin) in angles(degree + 2) {
            let point = Vec3::new(rho * cos, rho * sin * (short / long), 0.0);
            nodes.push(to_body * point, 3.0 * t * t * weight / (degree + 2) as f64);
        }
    }
    nodes.means(degree, arch, vanishes)
}

/// Returns the derivatives of the moments of an ellipsoid with respect to its semi-axes: 3/(l + 3) times the
/// means of u_k dS_lm/dx_k (A u) over the directions u.
fn by_semi_axes(ellipsoid: &Ellipsoid, degree: usize, arch: Arch) -> [Vec<f64>; 3] {
    let unit = 1.0 / ellipsoid.sorted()[0];
    let axes = Vec3::from(ellipsoid.semi_axes()) * unit;
    [0, 1, 2].map(|axis| {
        let mut nodes = WeightedPoints::default();
        for (z, weight) in gauss(degree / 2 + 1) {
            let ring = (1.0 - z * z).sqrt();
            for (cos, sin) in angles(degree + 2) {
                let u = Vec3::new(ring * cos, ring * sin, z);
                nodes.push(axes.component_mul(&u), weight * u[axis] * unit / (degree + 2) as f64);
            }
        }
        let lower = nodes.means(degree, arch, |_, _| false);
        let mut derivatives = displacement_derivatives(&lower[..degree * degree], axis);
        for (l, m) in degrees_and_orders(degree) {
            derivatives[index(l, m)] *= if vanishes(l, m) { 0.0 } else { 3.0 / (l + 3) as f64 };
        }
        derivatives
    })
}
