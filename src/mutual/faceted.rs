//! The choice of the rule of a pair with a polyhedron, made between steps.
//!
//! - A point or a sphere beside it: the polyhedron's field at the centre.
//! - Well apart: the polyhedron's layer in the other's field. The layer's degree follows from the rate at which the other's
//!   potential converges in the polyhedron's circumscribed sphere, as over an ellipsoid's surface.
//! - Near: its faces, with as many points on each as make two rules agree.
//!
//! The field of a polyhedron is exact by its facets near by; from a distance it is that of its layer, without the facets'
//! cancellation, and cheaper where there are many.

use super::choice::MARGIN;
use super::rule::Kernel;
use super::store::Carrier;
use super::{BodyGravity, Interaction, Pair, Pose};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::patience::Patience;
use crate::quadrature::{Order, layer_degree};

/// Points along a face's side that near bodies are tried with.
const LADDER: [usize; 14] = [2, 3, 4, 5, 6, 8, 10, 13, 16, 20, 26, 34, 44, 56];
/// Two rules never agree better than this.
const ROUND_OFF: f64 = 2e-14;
/// Most evaluations of a facet at a point that one sum over the faces may take: some seconds.
const MOST: usize = 300_000_000;
/// A facet's field at a point takes this many times what a point of a layer takes.
const FACET: usize = 8;
/// Sizes of the body beyond which its facets lose digits.
const FACETS_TELL: f64 = 4.0;

impl Pair {
    /// Chooses the rule; see [`Pair::prepare`].
    pub(super) fn prepare_faceted(&mut self, pose: &Pose, reach: f64, patience: &mut Patience) -> Result<()> {
        let round = |k: usize| self.bodies[k].polyhedron().is_none() && self.bodies[k].focal_axes()[0] == 0.0;
        if let Some(integrated) = (0..2).find(|&k| round(k)) {
            return self.adopt(integrated, 0, Order { gauss: 1, angles: 1 }, reach, patience);
        }
        let cost = |k: usize| self.layer(k, reach).map(|degree| (degree, k));
        if let Some((degree, integrated)) = [cost(0), cost(1)].into_iter().flatten().min() {
            let kept = self.rule.as_ref().filter(|rule| {
                rule.carrier == Carrier::Layer
                    && rule.integrated == integrated
                    && (degree..=degree + 2).contains(&rule.degree)
            });
            let degree = kept.map_or(degree, |rule| rule.degree);
            return self.adopt(integrated, degree, layer(degree), reach, patience);
        }
        self.over_faces(pose, reach, patience)
    }

    /// The degree of the layer of a body in the field of the other one, where they are far enough apart.
    fn layer(&self, integrated: usize, reach: f64) -> Option<usize> {
        let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
        let radius = set.polyhedron()?.circumradius();
        // The layer's points are outside the other body.
        if MARGIN * reach <= radius + field.shape.circumradius() {
            return None;
        }
        layer_degree((reach - field.shape.focal_reach()) / radius, self.tolerance)
    }

    /// Raises the number of points on the faces until a rule agrees with a finer one.
    fn over_faces(&mut self, pose: &Pose, reach: f64, patience: &mut Patience) -> Result<()> {
        let faces = |body: &BodyGravity| body.polyhedron().map(|p| p.faces().len());
        // The body with fewer points: the other one's field is exact.
        let integrated = match [faces(&self.bodies[0]), faces(&self.bodies[1])] {
            [Some(first), Some(second)] => usize::from(second < first),
            [None, _] => 1,
            _ => 0,
        };
        let count = faces(&self.bodies[integrated]).unwrap_or(0);
        let each = faces(&self.bodies[1 - integrated]).unwrap_or(1);
        let order = |level: usize| Order { gauss: LADDER[level], angles: LADDER[level] };
        let used = self.rule.as_ref().filter(|r| r.integrated == integrated && r.carrier == Carrier::Faces);
        let mut level = used.and_then(|rule| LADDER.iter().position(|&n| n == rule.degree)).unwrap_or(0);
        self.adopt(integrated, LADDER[level], order(level), reach, patience)?;
        let mut coarse = self.asking(pose, patience)?;
        let mut difference = f64::INFINITY;
        while level + 1 < LADDER.len() && count * LADDER[level + 1].pow(2) * each <= MOST {
            self.adopt(integrated, LADDER[level + 1], order(level + 1), reach, patience)?;
            let fine = self.asking(pose, patience)?;
            difference = self.change(&fine, &coarse);
            if difference <= self.tolerance.max(ROUND_OFF) {
                if difference < 1e-3 * self.tolerance && level > 0 {
                    self.adopt(integrated, LADDER[level - 1], order(level - 1), reach, patience)?;
                    if self.change(&self.asking(pose, patience)?, &fine) <= 0.1 * self.tolerance {
                        return Ok(());
                    }
                }
                return self.adopt(integrated, LADDER[level], order(level), reach, patience);
            }
            coarse = fine;
            level += 1;
        }
        self.reset();
        Err(Error::NotConverged {
            what: format!(
                "quadrature over the faces of {}, beside {},",
                self.bodies[integrated].name,
                self.bodies[1 - integrated].name
            ),
            detail: format!(
                "at separation {} two rules of up to {} points a face differ by {difference:.1e}, more than the tolerance \
                 {:e}; use a larger gravity_tolerance, or smaller faces",
                pose.separation.norm() * self.unit,
                LADDER[level].pow(2),
                self.tolerance,
            ),
        })
    }

    /// Largest difference of two evaluations: of the force, and of the torques by the body's radius, relative to the force.
    pub(super) fn change(&self, one: &Interaction, other: &Interaction) -> f64 {
        let force = one.force_on_first.norm();
        let torque =
            |a: &Vec3, b: &Vec3, body: usize| (a - b).norm() / self.bodies[body].shape.circumradius();
        let change = (one.force_on_first - other.force_on_first).norm();
        change.max(torque(&one.torque_first, &other.torque_first, 0)).max(torque(
            &one.torque_second,
            &other.torque_second,
            1,
        )) / force
    }

    /// The points that stand for the body that is integrated over.
    pub(super) fn carrier(&self, integrated: usize, order: Order) -> Carrier {
        match self.bodies[integrated].polyhedron() {
            None => self.carriers[integrated],
            Some(_) if order.gauss == order.angles => Carrier::Faces,
            Some(_) => Carrier::Layer,
        }
    }

    /// The form of the field body's field down to a separation.
    pub(super) fn kernel_of(
        &self,
        integrated: usize,
        valid_from: f64,
        patience: &mut Patience,
    ) -> Result<Kernel> {
        let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
        let closest = valid_from - set.polyhedron().map_or(0.0, |p| p.circumradius());
        let Some(polyhedron) = field.polyhedron() else {
            return Ok(if set.polyhedron().is_some() {
                self.kernel_from(integrated, closest)
            } else {
                self.kernel(integrated, valid_from)
            });
        };
        let rate = closest / polyhedron.circumradius();
        let Some(degree) = layer_degree(rate, 0.1 * self.tolerance) else { return Ok(Kernel::Facets) };
        let order = layer(degree);
        let points = order.gauss * order.angles;
        if rate < FACETS_TELL && points > FACET * polyhedron.faces().len() {
            return Ok(Kernel::Facets);
        }
        Ok(Kernel::Layer(field.layer(degree, self.arch, patience)?))
    }
}

/// The order of a layer.
fn layer(degree: usize) -> Order {
    Order { gauss: degree + 1, angles: 2 * degree + 1 }
}
