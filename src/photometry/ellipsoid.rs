//! The brightness of one ellipsoid, alone or with others before it, and its derivatives by all that it depends on.
//!
//! With B = abc b(p, q, outlines), p = A^-1 R^T e and q = A^-1 R^T s: the derivatives of b by p and q are integrals over the
//! visible and lit part. Of an outline the tangent point X on the hiding ellipsoid and the point x on the other surface behind
//! it, X = x + reach d, count with the normal N at X: where they move, the level of the outline at x changes by
//! 2 N.(dx + reach dd - dX), the terms of the way itself being across N.

use super::kernel::{Kernel, PARTIALS};
use super::law::Law;
use super::lune::Lune;
use super::outline::{Hiding, Light, Outline};
use super::rule::Rule;
use super::strips::{Moments, Strips};
use crate::math::{Mat3, Vec3};
use std::f64::consts::FRAC_PI_2;

/// An ellipsoid at its place.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Its place in the list of bodies.
    pub body: usize,
    /// Semi-axes along its own axes.
    pub semi_axes: Vec3,
    /// Centre, inertial.
    pub position: Vec3,
    /// From its own axes into the inertial frame.
    pub rotation: Mat3,
}

/// Derivatives by the pose and the size of one body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ByBody {
    /// By the position, inertial.
    pub position: Vec3,
    /// By the rotation vector, in the body frame.
    pub rotation: Vec3,
    /// By the semi-axes.
    pub semi_axes: Vec3,
}

/// Derivatives of a brightness.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Partials {
    /// By each body.
    pub by_body: Vec<ByBody>,
    /// By the unit vectors to the observer and to the Sun, across them, inertial.
    pub by_direction: [Vec3; 2],
}

/// An ellipsoid under light.
pub struct Lit<'a> {
    placed: &'a Placed,
    law: &'a Law,
    rule: &'a Rule,
    /// To the observer and to the Sun, inertial.
    directions: [Vec3; 2],
    /// The same in the ellipsoid's own axes.
    lights: [Vec3; 2],
    lune: Lune,
    phase: f64,
    hiding: Vec<Hiding>,
    outlines: Vec<Outline>,
}

impl<'a> Lit<'a> {
    /// An ellipsoid, with unit vectors to the observer and to the Sun, and what hides these from it.
    pub fn new(
        placed: &'a Placed,
        law: &'a Law,
        rule: &'a Rule,
        directions: [Vec3; 2],
        before: impl Iterator<Item = (Light, &'a Placed)>,
    ) -> Self {
        let lights = directions.map(|direction| placed.rotation.tr_mul(&direction));
        let [p, q] = lights.map(|light| light.component_div(&placed.semi_axes));
        let lune = Lune::new(&p, &q);
        let phase = directions[0].cross(&directions[1]).norm().atan2(directions[0].dot(&directions[1]));
        let (mut hiding, mut outlines) = (Vec::new(), Vec::<Outline>::new());
        for (light, other) in before {
            let from = other.position - placed.position;
            let direction = &directions[light as usize];
            let one = Hiding {
                light,
                semi_axes: other.semi_axes,
                rotation: placed.rotation.tr_mul(&other.rotation),
                // Without the part along the light, whose rounding would remain.
                centre: placed.rotation.tr_mul(&(from - direction * from.dot(direction))),
                body: other.body,
            };
            let outline = Outline::new(&lune, &placed.semi_axes, &one);
            if !outline.misses() {
                outlines.push(outline);
                hiding.push(Hiding { centre: placed.rotation.tr_mul(&from), ..one });
            }
        }
        Self { placed, law, rule, directions, lights, lune, phase, hiding, outlines }
    }

    fn kernel(&self) -> Kernel<'_> {
        let mut kernel = Kernel {
            lune: &self.lune,
            law: self.law,
            semi_axes: &self.placed.semi_axes,
            scattering: self.law.at(self.phase),
            rule: self.rule,
            constant: self.law.constant().filter(|_| !self.lune.is_thin()),
            scale: self.lune.size(),
        };
        kernel.scale *= kernel.factor(self.lune.centre(), 0.0, 1.0).abs();
        kernel
    }

    /// The brightness, in squared length.
    pub fn brightness(&self) -> f64 {
        if self.lune.is_empty() {
            return 0.0;
        }
        let kernel = self.kernel();
        let over = match (kernel.constant, self.outlines.is_empty()) {
            // Over the parallels rho^2 has the integral of cos^2 b.
            (Some(_), true) => FRAC_PI_2 * kernel.between(self.lune.terminator(), self.lune.limb(), 0.0, 1.0),
            _ => Strips { kernel: &kernel, outlines: &self.outlines }.brightness(),
        };
        over * self.placed.semi_axes.product()
    }

    /// The brightness; its derivatives are added.
    pub fn partials(&self, partials: &mut Partials) -> f64 {
        if self.lune.is_empty() {
            return 0.0;
        }
        let kernel = self.kernel();
        let (sums, moments) = match (kernel.constant, self.outlines.is_empty()) {
            (Some(_), true) => {
                let all = kernel.partials_between(self.lune.terminator(), self.lune.limb(), 0.0, 1.0);
                // The integral of z is that of an odd function.
                (all.map(|value| value * FRAC_PI_2), Vec::new())
            }
            _ => {
                let strips = Strips { kernel: &kernel, outlines: &self.outlines };
                strips.partials(&self.hiding, &self.lights)
            }
        };
        let volume = self.placed.semi_axes.product();
        self.add_own(&sums, volume, partials);
        for (hiding, moments) in self.hiding.iter().zip(&moments) {
            self.add_outline(hiding, moments, volume, partials);
        }
        sums[0] * volume
    }

    /// Adds what the ellipsoid's own turn and size, and the directions, do to what is seen of it.
    fn add_own(&self, sums: &[f64; PARTIALS], volume: f64, partials: &mut Partials) {
        let Placed { semi_axes, rotation, body, .. } = self.placed;
        let own = &mut partials.by_body[*body];
        for k in 0..2 {
            let by = self.lune.vector_of([sums[1 + 3 * k], sums[2 + 3 * k], sums[3 + 3 * k]]) * volume;
            // Of the direction in body axes, d: p = A^-1 d, and a turn by phi makes it d + d x phi.
            let by_light = by.component_div(semi_axes);
            own.rotation += by_light.cross(&self.lights[k]);
            own.semi_axes -= by_light.component_mul(&self.lights[k]).component_div(semi_axes);
            partials.by_direction[k] += rotation * by_light;
        }
        own.semi_axes += (semi_axes.map(|a| sums[0] / a) + Vec3::new(sums[7], sums[8], sums[9])) * volume;
        let sin = self.phase.sin();
        if sin > 0.0 {
            let [e, s] = self.directions;
            partials.by_direction[0] -= s * (sums[10] * volume / sin);
            partials.by_direction[1] -= e * (sums[10] * volume / sin);
        }
    }

    /// Adds what the shift of an outline does.
    fn add_outline(&self, hiding: &Hiding, moments: &Moments, volume: f64, partials: &mut Partials) {
        let Placed { semi_axes, rotation, body, .. } = self.placed;
        // The normals in the frame of the ellipsoid that is seen.
        let normals = hiding.rotation * Mat3::from_diagonal(&hiding.semi_axes.map(|a| volume / a));
        let (push, turn) = (rotation * (normals * moments.v), normals * moments.v_u);
        let with_surface = turn * Mat3::from_diagonal(semi_axes);
        let own = &mut partials.by_body[*body];
        own.position += push;
        own.rotation += axial(&with_surface.transpose());
        own.semi_axes += turn.diagonal();
        partials.by_direction[hiding.light as usize] += rotation * (normals * moments.reach_v);
        let other = &mut partials.by_body[hiding.body];
        other.position -= push;
        let [stretch, shrink] = [hiding.semi_axes, hiding.semi_axes.map(|a| volume / a)];
        let on_surface = Mat3::from_diagonal(&stretch) * moments.v_v * Mat3::from_diagonal(&shrink);
        other.rotation -= axial(&on_surface);
        other.semi_axes -= moments.v_v.diagonal().component_mul(&shrink);
    }
}

/// The sum of x cross y from that of x y^T.
fn axial(m: &Mat3) -> Vec3 {
    Vec3::new(m[(1, 2)] - m[(2, 1)], m[(2, 0)] - m[(0, 2)], m[(0, 1)] - m[(1, 0)])
}
