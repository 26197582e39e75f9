//! The condition under which a secondary is locked to the body that it moves about, as a function of the
//! state whose zeros are the switches of BYORP.
//!
//! With r and v the secondary's position and velocity from the other body, h = r x v, n = h/|h|, and inertial
//! vectors a and s along the body axes of its smallest and largest moments of inertia, it is locked while
//!
//! - s is within 45 degrees of the orbit's normal: |s.n| > 1/sqrt(2), and
//! - the angle psi between a and the line of the centres is that of a pendulum that does not turn over:
//!   psi'^2 + w^2 sin^2 psi < w^2,
//!   w^2 = 3 (B - A)/C mu/r^3, with psi' = spin.n - |h|/r^2.
//!
//! The margin is the smaller of |s.n| - 1/sqrt(2) and cos^2 psi - psi'^2/w^2, with cos^2 psi = (a.l)^2 / (1 -
//! (a.n)^2), l = r/|r|.

use super::snapshot::MotionSnapshot;
use crate::error::{Error, Result};
use crate::math::rotation::rotate_back;
use crate::math::{Mat3, Vec3, ascending};
use crate::shape::Body;
use std::f64::consts::FRAC_1_SQRT_2;

/// The margin of a state in which the orbit has no normal or the libration no frequency: no secondary is
/// locked there.
const NEVER: f64 = -1.0;

/// A secondary and the body that it moves about, with the constants of its libration.
#[derive(Debug, Clone)]
pub(super) struct Lock {
    pub on: usize,
    pub about: usize,
    /// The body axes of the smallest, the middle and the largest moment of inertia.
    pub axes: [usize; 3],
    inertia: Vec3,
    /// The constant 3 (B - A) / C of the moments of inertia.
    elongation: f64,
    /// G times the mass of both bodies.
    mu: f64,
}

/// The derivatives of the margin.
#[derive(Debug, Clone, Copy)]
pub struct MarginGradient {
    /// Derivatives with respect to the secondary's position relative to the other body, inertial.
    pub by_position: Vec3,
    /// Derivatives with respect to the secondary's velocity relative to the other body, inertial.
    pub by_velocity: Vec3,
    /// Derivatives with respect to a rotation vector of the secondary, body frame.
    pub by_rotation: Vec3,
    /// Derivatives with respect to the secondary's spin, body frame.
    pub by_spin: Vec3,
    /// Derivatives with respect to the secondary's principal moments of inertia.
    pub by_inertia: Vec3,
    /// The derivative with respect to the logarithm of mu.
    pub by_mu: f64,
}

/// The quantities of which the margin consists.
struct Geometry {
    r: Vec3,
    v: Vec3,
    distance: f64,
    /// The length |h|.
    momentum: f64,
    normal: Vec3,
    line: Vec3,
    /// The inertial axes of the smallest and the largest moment, and the inertial spin.
    long: Vec3,
    short: Vec3,
    spin: Vec3,
    /// The rate psi' and the square w^2.
    rate: f64,
    frequency: f64,
    /// The numbers a.l, a.n and 1 - (a.n)^2.
    cosine: f64,
    height: f64,
    horizontal_squared: f64,
}

impl Lock {
    /// Makes the lock of two bodies; returns an error for a secondary without a longest axis.
    pub fn new(
        name: &str,
        [on, about]: [usize; 2],
        bodies: &[Body],
        gravitational_constant: f64,
    ) -> Result<Self> {
        let inertia = bodies[on].inertia();
        let axes = ascending(inertia.into());
        let [long, middle, short] = axes;
        if inertia[middle] <= inertia[long] {
            let axes_text = format!("{:?}", bodies[on].semi_axes());
            let expected = format!("one longest, which {name} can keep towards {}", bodies[about].name);
            return Err(Error::invalid(format!("semi-axes of {}", bodies[on].name), axes_text, expected));
        }
        let elongation = 3.0 * (inertia[middle] - inertia[long]) / inertia[short];
        let mu = gravitational_constant * (bodies[on].mass + bodies[about].mass);
        Ok(Self { on, about, axes, inertia, elongation, mu })
    }

    /// Returns a bound of the rounding error of a margin of zero: the spin and the orbit's rate nearly cancel
    /// in psi'.
    pub fn rounding(&self) -> f64 {
        32.0 * f64::EPSILON * (1.0 + 1.0 / self.elongation.sqrt())
    }

    /// Returns the margin, which is above zero while the secondary is locked.
    #[inline(always)]
    pub fn margin(&self, snapshot: MotionSnapshot) -> f64 {
        self.geometry(snapshot)
            .map_or(NEVER, |geometry| self.upright_margin(&geometry).min(self.libration_margin(&geometry)))
    }

    #[inline(always)]
    fn upright_margin(&self, geometry: &Geometry) -> f64 {
        geometry.short.dot(&geometry.normal).abs() - FRAC_1_SQRT_2
    }

    #[inline(always)]
    fn libration_margin(&self, geometry: &Geometry) -> f64 {
        // A long axis along the normal has no angle from the line of centres; the secondary is then not
        // upright.
        let aligned = if geometry.horizontal_squared > 0.0 {
            geometry.cosine * geometry.cosine / geometry.horizontal_squared
        } else {
            0.0
        };
        aligned - geometry.rate * geometry.rate / geometry.frequency
    }

    /// Returns the quantities of the margin; `None` where there is no normal or no frequency.
    #[inline(always)]
    fn geometry(&self, snapshot: MotionSnapshot) -> Option<Geometry> {
        let (r, v) = snapshot.relative(self.on, self.about);
        let (distance, h) = (r.norm(), r.cross(&v));
        let (momentum, frequency) = (h.norm(), self.elongation * self.mu / (distance * distance * distance));
        // The comparisons are written so that they are false for NaN.
        let is_defined = momentum > 0.0 && frequency > 0.0;
        if !is_defined {
            return None;
        }
        let [long, _, short] = self.axes;
        let rotation: &Mat3 = &snapshot.rotation[self.on];
        let (long, short): (Vec3, Vec3) = (rotation.column(long).into(), rotation.column(short).into());
        let (normal, line, spin) = (h / momentum, r / distance, snapshot.inertial_spin(self.on));
        let (cosine, sine) = (long.dot(&line), long.dot(&normal.cross(&line)));
        Some(Geometry {
            rate: spin.dot(&normal) - momentum / (distance * distance),
            cosine,
            height: long.dot(&normal),
            horizontal_squared: sine * sine + cosine * cosine,
            r,
            v,
            distance,
            momentum,
            normal,
            line,
            long,
            short,
            spin,
            frequency,
        })
    }

    /// Returns the derivatives of the margin; `None` where the margin is [`NEVER`].
    pub fn gradient(&self, snapshot: MotionSnapshot) -> Option<MarginGradient> {
        let geometry = self.geometry(snapshot)?;
        let rotation = &snapshot.rotation[self.on];
        // This gives the derivatives of b.n, since |h| dn is the component of dh = dr x v + r x dv
        // perpendicular to n, and those of |h|.
        let of_normal = |b: Vec3| {
            let b = (b - geometry.normal * geometry.normal.dot(&b)) / geometry.momentum;
            [geometry.v.cross(&b), b.cross(&geometry.r)]
        };
        // This gives the derivative of b.a, where a = R e changes by R (theta x e).
        let of_axis = |axis: &Vec3, b: Vec3| rotate_back(rotation, &axis.cross(&b));
        if self.upright_margin(&geometry) < self.libration_margin(&geometry) {
            let sign = geometry.short.dot(&geometry.normal).signum();
            let [by_position, by_velocity] = of_normal(geometry.short * sign);
            return Some(MarginGradient {
                by_position,
                by_velocity,
                by_rotation: of_axis(&geometry.short, geometry.normal * sign),
                by_spin: Vec3::zeros(),
                by_inertia: Vec3::zeros(),
                by_mu: 0.0,
            });
        }
        let square = geometry.distance * geometry.distance;
        let (by_cosine, by_height) = (
            2.0 * geometry.cosine / geometry.horizontal_squared,
            2.0 * geometry.cosine * geometry.cosine * geometry.height
                / (geometry.horizontal_squared * geometry.horizontal_squared),
        );
        let (by_rate, share) =
            (-2.0 * geometry.rate / geometry.frequency, geometry.rate * geometry.rate / geometry.frequency);
        let [mut by_position, mut by_velocity] =
            of_normal(geometry.long * by_height + geometry.spin * by_rate);
        by_position += (geometry.long - geometry.line * geometry.cosine) * (by_cosine / geometry.distance);
        let by_momentum = -by_rate / square;
        by_position += geometry.v.cross(&geometry.normal) * by_momentum;
        by_velocity += geometry.normal.cross(&geometry.r) * by_momentum;
        by_position += geometry.line
            * (2.0 * by_rate * geometry.momentum / (square * geometry.distance)
                - 3.0 * share / geometry.distance);
        let normal = rotate_back(rotation, &geometry.normal);
        let mut by_inertia = Vec3::zeros();
        let [long, middle, short] = self.axes;
        by_inertia[middle] += 3.0 * share / (self.elongation * self.inertia[short]);
        by_inertia[long] -= 3.0 * share / (self.elongation * self.inertia[short]);
        by_inertia[short] -= share / self.inertia[short];
        Some(MarginGradient {
            by_position,
            by_velocity,
            by_rotation: of_axis(&geometry.long, geometry.line * by_cosine + geometry.normal * by_height)
                + Vec3::from(snapshot.spin[self.on]).cross(&normal) * by_rate,
            by_spin: normal * by_rate,
            by_inertia,
            by_mu: share,
        })
    }
}
