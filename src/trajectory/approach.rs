//! Decides whether bodies touch within a step.
//!
//! Every step is checked: first by bounds that cost next to nothing, and on the continuous solution only
//! where these do not decide. The bounds limit how far the path between the step's ends can depart from the
//! straight line between them.

use super::encounter::Encounter;
use crate::dynamics::{Layout, System};
use crate::error::{Error, Result};
use crate::integrate::{Segment, Step};
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::shape::{Part, least_distance};
use pulp::Arch;

/// The relative excess over the bounds that rounding and the integration within fixed steps may cause.
const MARGIN: f64 = 1e-9;

/// The units of work of a pair in a bound, for [`InterruptCheck`].
const PAIR: u64 = 5;

/// The first touch of two bodies in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    /// Indices of the bodies in the system.
    pub bodies: [usize; 2],
    /// The index of the piece of the step.
    pub piece: usize,
    /// The fraction of the piece at which the surfaces touch.
    pub theta: f64,
    /// The time at which they touch.
    pub time: f64,
}

impl Contact {
    /// Returns whether this is the contact of these two bodies.
    pub fn is_of(&self, first: usize, second: usize) -> bool {
        self.bodies == [first.min(second), first.max(second)]
    }

    /// Returns the error that the two bodies overlap from this time on.
    pub fn error(&self, system: &System) -> Error {
        let [first, second] = self.bodies.map(|body| system.bodies()[body].name.clone());
        Error::BodiesOverlap { first, second, time: self.time }
    }
}

/// The check of all pairs of a system for contacts.
#[derive(Debug, Clone)]
pub(super) struct Approach {
    bodies: Vec<BodyExtent>,
    /// Whether a body has an extent: points cannot overlap.
    extended: bool,
    /// The largest deviation of each body's path from a straight line, without the part that the unknown
    /// accelerations by the other bodies cause.
    sagittas: Vec<f64>,
    /// The largest change of the rates from stage to stage, in the layout of the vector of rates.
    changes: Vec<f64>,
    /// The largest acceleration of each body, and the largest accelerations of two bodies together at unit
    /// distance.
    attractions: Vec<f64>,
    attraction: f64,
    /// The least separation of each pair of centres along straight lines.
    nearest: Vec<f64>,
    /// The positions at both ends of the piece that is searched.
    ends: Vec<[Vec3; 2]>,
}

#[derive(Debug, Clone)]
struct BodyExtent {
    name: String,
    /// The parts that can touch another body.
    parts: Vec<Part>,
    radius: f64,
    /// The extent from the centre of an equivalent mass distribution with the same exterior field: that of the focal
    /// ellipses of the parts.
    focal: f64,
    /// G times the mass, increased by the tolerance of the quadrature; the masses of voids are added, not
    /// subtracted.
    mu: f64,
    /// The ratio of the mass of matter and voids together to the mass.
    terms: f64,
}

impl Approach {
    pub fn new(system: &System) -> Self {
        let extent = |body: &crate::shape::Body| BodyExtent {
            name: body.name.clone(),
            parts: body.outer_parts().cloned().collect(),
            radius: body.circumradius(),
            focal: body
                .parts()
                .iter()
                .map(|p| p.position().norm() + p.shape.focal_reach())
                .fold(0.0, f64::max),
            mu: system.gravitational_constant()
                * body.mass_without_signs()
                * (1.0 + system.settings().gravity_tolerance),
            terms: body.mass_without_signs() / body.mass,
        };
        let bodies: Vec<BodyExtent> = system.bodies().iter().map(extent).collect();
        let n = bodies.len();
        let total: f64 = bodies.iter().map(|body| body.mu).sum();
        let terms = bodies.iter().map(|body| body.terms).fold(1.0, f64::max);
        let attraction = if n == 2 { total } else { 2.0 * total } * terms;
        Self {
            extended: n > 1 && bodies.iter().any(|body| body.radius > 0.0),
            bodies,
            sagittas: vec![0.0; n],
            changes: Vec::new(),
            attractions: vec![0.0; n],
            attraction,
            nearest: vec![0.0; n * n.saturating_sub(1) / 2],
            ends: vec![[Vec3::zeros(); 2]; n],
        }
    }

    /// Returns whether the step's ends and stages alone prove that no two bodies touch on the interpolant of
    /// a step.
    ///
    /// The interpolant of the positions belongs to an acceleration. That acceleration is known at the pair's
    /// own stages, and [`Self::are_apart`] bounds it at the interpolant's further stages. [`Step::spread`] bounds
    /// the distance of the interpolant from the chord that both permit.
    pub fn excludes(
        &mut self,
        arch: Arch,
        layout: Layout,
        step: &Step,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        if !self.extended {
            return Ok(true);
        }
        let velocities = layout.velocity(0)..layout.velocity(self.bodies.len());
        self.changes.resize(step.stride(), 0.0);
        step.changes(arch, velocities.clone(), &mut self.changes);
        let [first_coefficient, change_coefficient] = step.spread();
        let square = step.size * step.size;
        let sagitta = |first: f64, change: f64| {
            square * ((0.125 + change_coefficient) * first.sqrt() + first_coefficient * change.sqrt())
        };
        let (first, change) = (&step.first_rates()[velocities.clone()], &self.changes[velocities]);
        let largest = |values: &[f64]| {
            values
                .as_chunks::<3>()
                .0
                .iter()
                .map(|v| v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
                .fold(0.0, larger)
        };
        let lines = Lines { layout, time: step.time, start: step.start, end: step.end, tangent: 0.0 };
        if self.are_certainly_apart(
            &lines,
            sagitta(largest(first), largest(change)),
            square * change_coefficient,
            interrupt,
        )? {
            return Ok(true);
        }
        for (body, body_sagitta) in self.sagittas.iter_mut().enumerate() {
            let squared = |values: &[f64]| vector(values, 3 * body).norm_squared();
            *body_sagitta = sagitta(squared(first), squared(change));
        }
        self.are_apart(&lines, square * change_coefficient, interrupt)
    }

    /// Returns whether no two bodies can touch between the ends of a fixed step, on the motion that is
    /// integrated from its start and then adjusted linearly so that it ends where the step ended.
    ///
    /// With t the time since the start, that motion departs before the adjustment by at most t^2/2 times the
    /// acceleration from the straight line along the first velocities. After it the motion departs by at most
    /// an eighth of the squared step times the acceleration from the chord.
    pub fn excludes_between(
        &mut self,
        layout: Layout,
        time: f64,
        [start, end]: [&[f64]; 2],
        size: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        if !self.extended {
            return Ok(true);
        }
        let lines = Lines { layout, time, start, end, tangent: size };
        let weight = 0.5 * size * size;
        if self.are_certainly_apart(&lines, 0.0, weight, interrupt)? {
            return Ok(true);
        }
        self.sagittas.fill(0.0);
        self.are_apart(&lines, weight, interrupt)
    }

    /// Returns whether all pairs stay apart where bodies move along their lines, except for their `sagittas`
    /// and for `weight` times the largest acceleration.
    ///
    /// While two bodies are no nearer than half way from the least separation on their lines to contact,
    /// their acceleration is at most G m / (d - p_1 - p_2)^2 there: each attracts like mass on its focal
    /// ellipse, which extends p from its centre. If with this acceleration no pair moves further than half
    /// its gap, then no pair has been nearer, and none has touched. The same bound holds for the series of
    /// any degree, whose terms of degree n are at most n + 1 times ((p_1 + p_2) / d)^n of the first.
    fn are_apart(&mut self, lines: &Lines, weight: f64, interrupt: &mut InterruptCheck) -> Result<bool> {
        self.attractions.fill(0.0);
        let n = self.bodies.len();
        let mut index = 0;
        for i in 0..n {
            interrupt.charge(PAIR * (n - i) as u64, lines.time)?;
            for j in i + 1..n {
                let [from, to, along] = lines.separations(i, j);
                self.nearest[index] =
                    least_distance(&from, &(to - from)).min(least_distance(&from, &(along - from)));
                let (a, b) = (&self.bodies[i], &self.bodies[j]);
                let inner = 0.5 * (self.nearest[index] + a.radius + b.radius) - (a.focal + b.focal);
                if weight > 0.0 {
                    let per_mu = if inner > 0.0 { 1.0 / (inner * inner) } else { f64::INFINITY };
                    self.attractions[i] += a.terms * b.mu * per_mu;
                    self.attractions[j] += b.terms * a.mu * per_mu;
                }
                index += 1;
            }
        }
        let mut pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).zip(&self.nearest);
        // A NaN makes the answer false.
        Ok(pairs.all(|((i, j), near)| {
            let sagitta =
                self.sagittas[i] + self.sagittas[j] + weight * (self.attractions[i] + self.attractions[j]);
            sagitta + MARGIN * near <= 0.5 * (near - (self.bodies[i].radius + self.bodies[j].radius))
        }))
    }

    /// Returns whether [`Self::are_apart`] is true even with the least and the largest values of all pairs in place of
    /// the values of each pair. This is quick and mostly sufficient.
    fn are_certainly_apart(
        &self,
        lines: &Lines,
        sagitta: f64,
        weight: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        let (mut gap, mut inner) = (f64::INFINITY, f64::INFINITY);
        for (i, a) in self.bodies.iter().enumerate() {
            interrupt.charge(PAIR * (self.bodies.len() - i) as u64, lines.time)?;
            for (j, b) in self.bodies.iter().enumerate().skip(i + 1) {
                let [from, to, along] = lines.separations(i, j);
                let path = larger((to - from).norm_squared(), (along - from).norm_squared());
                let near = (1.0 - 2.0 * MARGIN) * from.norm() - path.sqrt();
                let touching = a.radius + b.radius;
                // The comparison is written so that NaN makes the answer false.
                let is_apart = near > touching;
                if !is_apart {
                    return Ok(false);
                }
                gap = gap.min(near - touching);
                inner = inner.min(0.5 * (near + touching) - (a.focal + b.focal));
            }
        }
        let square = inner * inner;
        Ok(inner > 0.0 && 2.0 * sagitta * square + weight * self.attraction <= 0.5 * gap * square)
    }

    /// Returns the first contact on a piece, which has this index in the step.
    pub fn search(
        &mut self,
        layout: Layout,
        piece: &Segment,
        index: usize,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<Contact>> {
        if !self.extended {
            return Ok(None);
        }
        let n = self.bodies.len();
        let ends = [piece.basis(0.0), piece.basis(1.0)];
        for body in 0..n {
            let p = layout.position(body);
            let at = |basis| Vec3::from([0, 1, 2].map(|c| piece.number(basis, p + c)));
            self.ends[body] = [at(&ends[0]), at(&ends[1])];
            self.sagittas[body] = 0.125 * piece.derivative_bounds(p, 3)[1];
        }
        let mut contact: Option<Contact> = None;
        for i in 0..n {
            interrupt.charge(n as u64, piece.start())?;
            for j in i + 1..n {
                let (a, b) = (&self.bodies[i], &self.bodies[j]);
                let touching = a.radius + b.radius;
                let [from, to] = [0, 1].map(|k| self.ends[j][k] - self.ends[i][k]);
                let near = least_distance(&from, &(to - from));
                let sagitta = self.sagittas[i] + self.sagittas[j];
                if !(near - sagitta).is_finite() {
                    return Err(Error::NotConverged {
                        what: format!(
                            "the search for a contact of {} and {} at time {}",
                            a.name,
                            b.name,
                            piece.start()
                        ),
                        detail: "the squares of their coordinates overflow".to_owned(),
                    });
                }
                if touching == 0.0 || near - sagitta > touching + MARGIN * near {
                    continue;
                }
                for parts in
                    a.parts.iter().flat_map(|first| b.parts.iter().map(move |second| [first, second]))
                {
                    let until = contact.map_or(1.0, |contact| contact.theta);
                    let mut encounter = Encounter::new(piece, layout, [i, j], parts, [&a.name, &b.name]);
                    if let Some(theta) = encounter.first(until, interrupt)? {
                        let time = piece.time_at(theta);
                        contact = Some(Contact { bodies: [i, j], piece: index, theta, time });
                    }
                }
            }
        }
        Ok(contact)
    }
}

#[inline]
fn vector(y: &[f64], index: usize) -> Vec3 {
    let three = &y[index..index + 3];
    Vec3::new(three[0], three[1], three[2])
}

/// Returns the larger of two numbers that are not NaN.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Straight lines along which bodies might move.
struct Lines<'a> {
    layout: Layout,
    /// The time at the start.
    time: f64,
    start: &'a [f64],
    end: &'a [f64],
    /// The time over which the first velocities are followed.
    tangent: f64,
}

impl Lines<'_> {
    /// Returns the separation of two bodies at the start, at the end, and at the end of straight lines along the first
    /// velocities.
    #[inline]
    fn separations(&self, i: usize, j: usize) -> [Vec3; 3] {
        let between = |y: &[f64], i: usize, j: usize| vector(y, j) - vector(y, i);
        let (a, b) = (self.layout.position(i), self.layout.position(j));
        let from = between(self.start, a, b);
        let velocity = between(self.start, self.layout.velocity(i), self.layout.velocity(j));
        [from, between(self.end, a, b), from + velocity * self.tangent]
    }
}
