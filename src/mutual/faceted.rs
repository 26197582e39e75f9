//! The choice of the rule for a pair with a polyhedron, made between steps.
//!
//! - Beside a point or a sphere, the polyhedron's field at the centre of that body is taken.
//! - Far apart, the polyhedron's layer is taken in the other body's field. The degree of the layer follows
//!   from the rate at which the other body's potential converges in the polyhedron's circumscribed sphere, as
//!   over an ellipsoid's surface.
//! - Near each other, the polyhedron's faces are divided into cells that shrink towards the other body, with
//!   as many points as make two rules agree.
//!
//! Near the body, the field of a polyhedron is computed exactly from its facets. From a distance it is that
//! of its layer, without the facets' cancellation, and cheaper where there are many.

use super::choice::MARGIN;
use super::rule::Kernel;
use super::store::NodeKind;
use super::{Interaction, Pair, Pose};
use crate::error::{Error, Result};
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::quadrature::{Division, Order, layer_degree};
use std::ops::Range;

/// The least number of digits for which cells are made.
const FEWEST_DIGITS: usize = 2;
/// The largest number of digits for which cells are made.
pub(super) const MOST_DIGITS: usize = 22;
/// The number of additional digits of the rule by which the error is measured.
pub(super) const FINER: usize = 2;
/// The relative difference below which two rules over faces agree to round-off.
const AGREEMENT_OVER_FACES: f64 = 2e-14;
/// The ratio of differences that shows that a sum is limited by rounding. A sum whose terms cancel has no
/// more digits than rounding permits: where a finer pair of rules differs by no less than this fraction of
/// the coarser pair's difference, and by less than `CANCELLED`, the sum has the digits that it can have.
const SETTLED: f64 = 0.3;
const CANCELLED: f64 = 1e-12;
/// The ratio of circumscribed radii beyond which the smaller polyhedron is integrated over.
const MUCH_SMALLER: f64 = 2.0;
/// The largest number of evaluations of a facet at a point in one sum over the faces: a second or two.
pub(super) const MOST_EVALUATIONS: u64 = 100_000_000;
/// The work of a facet's field at a point, in units of the work of a point of a layer.
const FACET: usize = 8;
/// The distance, in sizes of the body, beyond which its facets lose digits.
const FACETS_LOSE_DIGITS: f64 = 4.0;

impl Pair {
    /// Chooses the rule; see [`Pair::prepare`].
    pub(super) fn prepare_faceted(
        &mut self,
        pose: &Pose,
        reach: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let is_spherical =
            |k: usize| self.bodies[k].polyhedron().is_none() && self.bodies[k].focal_axes()[0] == 0.0;
        if let Some(integrated) = (0..2).find(|&k| is_spherical(k)) {
            return self.adopt(integrated, 0, Order { gauss: 1, angles: 1 }, reach, interrupt);
        }
        self.prepare_over_polyhedron(pose, reach, interrupt)
    }

    /// Chooses the rule over a polyhedron, also beside a sphere.
    pub(super) fn prepare_over_polyhedron(
        &mut self,
        pose: &Pose,
        reach: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let cost = |k: usize| self.layer(k, reach).map(|degree| (degree, k));
        if let Some((degree, integrated)) = [cost(0), cost(1)].into_iter().flatten().min() {
            let reusable = self.rule.as_ref().filter(|rule| {
                rule.node_kind == NodeKind::Layer
                    && rule.integrated == integrated
                    && (degree..=degree + 2).contains(&rule.degree)
            });
            let degree = reusable.map_or(degree, |rule| rule.degree);
            return self.adopt(integrated, degree, layer(degree), reach, interrupt);
        }
        self.adopt_over_faces(pose, reach, interrupt)
    }

    /// Returns the degree of the layer of a body in the field of the other one, where they are far enough
    /// apart.
    fn layer(&self, integrated: usize, reach: f64) -> Option<usize> {
        let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
        let radius = set.polyhedron()?.circumradius();
        // The layer's points must be outside the other body.
        if MARGIN * reach <= radius + field.shape.circumradius() {
            return None;
        }
        layer_degree((reach - field.shape.focal_reach()) / radius, self.tolerance)
    }

    /// Returns the polyhedron to integrate over. Of like sizes it is the one with more faces: the cells
    /// follow from the gap, so that the work grows with the facets of the other one's field. A much smaller
    /// one is always integrated over, for its facets' field loses digits at the far side of a large body.
    fn integrated_over_faces(&self) -> usize {
        let [Some(first), Some(second)] = [0, 1].map(|k| self.bodies[k].polyhedron()) else {
            return usize::from(self.bodies[0].polyhedron().is_none());
        };
        let ratio = second.circumradius() / first.circumradius();
        if ratio.max(1.0 / ratio) > MUCH_SMALLER || second.faces().len() == first.faces().len() {
            usize::from(ratio < 1.0)
        } else {
            usize::from(second.faces().len() > first.faces().len())
        }
    }

    /// Raises the digits for which the cells are made until a rule agrees with a finer one.
    fn adopt_over_faces(&mut self, pose: &Pose, reach: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        let integrated = self.integrated_over_faces();
        let used =
            self.rule.as_ref().filter(|r| r.integrated == integrated && r.node_kind == NodeKind::Faces);
        let first = (-self.tolerance.log10()).ceil().clamp(FEWEST_DIGITS as f64, MOST_DIGITS as f64) as usize;
        let mut digits = used.map_or(first, |rule| rule.degree);
        let (mut coarse, mut difference) = (None, f64::INFINITY);
        let mut settled = false;
        while digits + FINER <= MOST_DIGITS {
            let Some(coarser) =
                coarse.or(self.interaction_by_cells(integrated, digits, pose, reach, interrupt)?)
            else {
                break;
            };
            let Some(fine) = self.interaction_by_cells(integrated, digits + FINER, pose, reach, interrupt)?
            else {
                break;
            };
            let scale = self.natural_force(pose).max(fine.force_on_first.norm());
            let last = std::mem::replace(&mut difference, self.change(&fine, &coarser) / scale);
            settled |= difference >= SETTLED * last;
            let permitted = if settled { CANCELLED } else { AGREEMENT_OVER_FACES };
            if difference <= self.tolerance.max(permitted) {
                if difference < 1e-2 * self.tolerance && digits > FEWEST_DIGITS {
                    let lower = self.interaction_by_cells(integrated, digits - 1, pose, reach, interrupt)?;
                    if lower.is_some_and(|lower| self.change(&lower, &fine) <= 0.1 * self.tolerance * scale) {
                        return Ok(());
                    }
                }
                return self.adopt_cells(integrated, digits, pose, reach, interrupt).map(drop);
            }
            coarse = Some(fine);
            digits += FINER;
        }
        self.reset();
        let why = if difference.is_finite() {
            format!("two rules differ by {difference:.1e}, more than the tolerance {:e}", self.tolerance)
        } else {
            self.too_many_evaluations()
        };
        Err(self.not_converged(integrated, pose, &why))
    }

    pub(super) fn too_many_evaluations(&self) -> String {
        format!(
            "the tolerance {:e} takes more than {:e} evaluations of a face",
            self.tolerance, MOST_EVALUATIONS as f64
        )
    }

    pub(super) fn not_converged(&self, integrated: usize, pose: &Pose, why: &str) -> Error {
        let [set, field] = [integrated, 1 - integrated].map(|body| &self.bodies[body].name);
        Error::NotConverged {
            what: format!("quadrature over the faces of {set}, beside {field},"),
            detail: format!(
                "at separation {} {why}; use a larger gravity_tolerance",
                pose.separation.norm() * self.unit
            ),
        }
    }

    /// Returns the pieces of the energy, where the rule in use integrates over faces.
    pub(super) fn pieces_of_faces(
        &self,
        pose: &Pose,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<Vec<Range<usize>>>> {
        let Some(rule) = &self.rule else { return Ok(None) };
        let roles = self.roles(rule.integrated, pose);
        let Some(faces) = self.faces(rule, &roles, &Self::ALL) else { return Ok(None) };
        let division =
            faces.energy_cells().divide(self.work_of_node(rule) as u64, MOST_EVALUATIONS, interrupt)?;
        let Some(Division { begins, .. }) = division else {
            return Err(self.not_converged(rule.integrated, pose, &self.too_many_evaluations()));
        };
        let starts = [0].into_iter().chain(begins.iter().copied());
        let ends = begins.iter().copied().chain([usize::MAX]);
        Ok(Some(starts.zip(ends).map(|(start, end)| start..end).collect()))
    }

    /// Returns the interaction by the cells for this many digits, which stay in use; `None` where they are
    /// too many.
    fn interaction_by_cells(
        &mut self,
        integrated: usize,
        digits: usize,
        pose: &Pose,
        reach: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<Interaction>> {
        if !self.adopt_cells(integrated, digits, pose, reach, interrupt)? {
            return Ok(None);
        }
        self.interaction_with(pose, interrupt).map(Some)
    }

    /// Puts the rule over the faces for this many digits in use, in pieces. Returns false where it takes too
    /// many points.
    fn adopt_cells(
        &mut self,
        integrated: usize,
        digits: usize,
        pose: &Pose,
        reach: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        let order = Order { gauss: digits, angles: digits };
        self.adopt(integrated, digits, order, reach, interrupt)?;
        let roles = self.roles(integrated, pose);
        let Some(rule) = &self.rule else { return Ok(false) };
        let Some(faces) = self.faces(rule, &roles, &Self::ALL) else { return Ok(false) };
        let cells = faces.cells();
        let division = cells.divide(self.work_of_node(rule) as u64, MOST_EVALUATIONS, interrupt)?;
        if let (Some(rule), Some(division)) = (&mut self.rule, &division) {
            (rule.points, rule.begins) = (division.points, division.begins.clone());
        }
        Ok(division.is_some())
    }

    /// Returns the force of two points at this separation, or where the circumscribed spheres overlap, at the
    /// sum of their radii. The bodies' own force may vanish by symmetry, as at the centre of a ring, while
    /// the terms of its sum do not.
    fn natural_force(&self, pose: &Pose) -> f64 {
        let touching: f64 = self.bodies.iter().map(|body| body.shape.circumradius()).sum();
        pose.separation.norm().max(touching).powi(-2)
    }

    /// Returns the largest difference of two evaluations: of the force, or of a torque over its body's
    /// radius.
    pub(super) fn change(&self, reference: &Interaction, other: &Interaction) -> f64 {
        let torque =
            |a: &Vec3, b: &Vec3, body: usize| (a - b).norm() / self.bodies[body].shape.circumradius();
        let change = (reference.force_on_first - other.force_on_first).norm();
        change.max(torque(&reference.torque_first, &other.torque_first, 0)).max(torque(
            &reference.torque_second,
            &other.torque_second,
            1,
        ))
    }

    /// Returns the kind of nodes for the body that is integrated over.
    pub(super) fn node_kind(&self, integrated: usize, order: Order) -> NodeKind {
        match self.bodies[integrated].polyhedron() {
            // Beside a polyhedron a sphere or a point is represented by its centre, whatever the method.
            None if self.bodies[1 - integrated].polyhedron().is_some() => NodeKind::Centre,
            None => self.node_kinds[integrated],
            Some(_) if order.gauss == order.angles => NodeKind::Faces,
            Some(_) => NodeKind::Layer,
        }
    }

    /// Returns the kernel of the field body's field down to a separation.
    pub(super) fn kernel_of(
        &self,
        integrated: usize,
        valid_from: f64,
        interrupt: &mut InterruptCheck,
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
        if rate < FACETS_LOSE_DIGITS && points > FACET * polyhedron.faces().len() {
            return Ok(Kernel::Facets);
        }
        Ok(Kernel::Layer(field.layer(degree, self.arch, interrupt)?))
    }
}

/// Returns the order of a layer.
fn layer(degree: usize) -> Order {
    Order { gauss: degree + 1, angles: 2 * degree + 1 }
}
