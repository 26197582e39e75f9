//! Whether bodies meet within a step.
//!
//! Every step is checked: first by bounds that cost next to nothing, and on the continuous solution only where they
//! leave a doubt. The bounds compare the line between the step's ends with how far the path between them can bend away
//! from it.

use super::encounter::Encounter;
use crate::dynamics::{Layout, System};
use crate::error::{Error, Result};
use crate::integrate::{Segment, Step};
use crate::math::Vec3;
use crate::patience::Patience;
use crate::shape::Part;
use pulp::Arch;

/// By how much rounding, and the bridge between the ends of fixed steps, may exceed the motion that the bounds are made
/// for.
const MARGIN: f64 = 1e-9;

/// Units of work of a pair in a bound, for [`Patience`].
const PAIR: u64 = 5;

/// Where two bodies meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    /// Their places in the system.
    pub bodies: [usize; 2],
    /// The piece of the step.
    pub piece: usize,
    /// The fraction of the piece at which their surfaces touch.
    pub theta: f64,
    /// The time at which they touch.
    pub time: f64,
}

impl Contact {
    /// Whether these two bodies meet in it.
    pub fn is_of(&self, first: usize, second: usize) -> bool {
        self.bodies == [first.min(second), first.max(second)]
    }

    /// The error that the two overlap from then on.
    pub fn error(&self, system: &System) -> Error {
        let [first, second] = self.bodies.map(|body| system.bodies()[body].name.clone());
        Error::BodiesOverlap { first, second, time: self.time }
    }
}

/// Watches every pair of a system.
#[derive(Debug, Clone)]
pub(super) struct Approach {
    bodies: Vec<Reach>,
    /// Whether a body has an extent: points have nothing to overlap with.
    extended: bool,
    /// By how much each body's path can bend from a line, without the unknown part of the other bodies' pull.
    bends: Vec<f64>,
    /// By how much accelerations change from stage to stage, where they lie in the vector of rates.
    changes: Vec<f64>,
    /// The largest pull on each body, and on two together at unit distance from all others.
    pulls: Vec<f64>,
    pull: f64,
    /// How near the centres of each pair come on straight lines.
    nearest: Vec<f64>,
    /// Ends of the piece at hand.
    ends: Vec<[Vec3; 2]>,
}

#[derive(Debug, Clone)]
struct Reach {
    name: String,
    /// The parts that can touch another body.
    parts: Vec<Part>,
    radius: f64,
    /// How far from the centre the mass reaches that attracts like the body: the focal ellipses of its parts.
    focal: f64,
    /// G times the mass, with what the quadrature may add to it; voids count like matter.
    mu: f64,
    /// How many times its mass the matter and the voids together are.
    terms: f64,
}

impl Approach {
    pub fn new(system: &System) -> Self {
        let reach = |body: &crate::shape::Body| Reach {
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
        let bodies: Vec<Reach> = system.bodies().iter().map(reach).collect();
        let n = bodies.len();
        let all: f64 = bodies.iter().map(|body| body.mu).sum();
        let terms = bodies.iter().map(|body| body.terms).fold(1.0, f64::max);
        let pull = if n == 2 { all } else { 2.0 * all } * terms;
        Self {
            extended: n > 1 && bodies.iter().any(|body| body.radius > 0.0),
            bodies,
            bends: vec![0.0; n],
            changes: Vec::new(),
            pulls: vec![0.0; n],
            pull,
            nearest: vec![0.0; n * n.saturating_sub(1) / 2],
            ends: vec![[Vec3::zeros(); 2]; n],
        }
    }

    /// Whether no two bodies can have met on the interpolant of a step, by the step's ends and stages alone.
    ///
    /// The interpolant of the positions is that of an acceleration, known at the pair's own stages. At those of the interpolant
    /// alone it is bounded by [`Self::apart`]. How far both bend it from the chord is [`Step::spread`].
    pub fn excludes(
        &mut self,
        arch: Arch,
        layout: Layout,
        step: &Step,
        patience: &mut Patience,
    ) -> Result<bool> {
        if !self.extended {
            return Ok(true);
        }
        let velocities = layout.velocity(0)..layout.velocity(self.bodies.len());
        self.changes.resize(step.stride(), 0.0);
        step.changes(arch, velocities.clone(), &mut self.changes);
        let [known, unknown] = step.spread();
        let square = step.size * step.size;
        let bend =
            |first: f64, change: f64| square * ((0.125 + unknown) * first.sqrt() + known * change.sqrt());
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
        if self.roughly_apart(&lines, bend(largest(first), largest(change)), square * unknown, patience)? {
            return Ok(true);
        }
        for (body, own) in self.bends.iter_mut().enumerate() {
            let squared = |values: &[f64]| vector(values, 3 * body).norm_squared();
            *own = bend(squared(first), squared(change));
        }
        self.apart(&lines, square * unknown, patience)
    }

    /// Whether no two bodies can have met between the ends of a fixed step, on the motion from its start that is then tilted to end
    /// where the step ended.
    ///
    /// Before it is tilted that motion is within half the square of the time, times the acceleration, of the straight line along
    /// the first velocities, and afterwards within an eighth of it of the chord.
    pub fn excludes_between(
        &mut self,
        layout: Layout,
        time: f64,
        [start, end]: [&[f64]; 2],
        size: f64,
        patience: &mut Patience,
    ) -> Result<bool> {
        if !self.extended {
            return Ok(true);
        }
        let lines = Lines { layout, time, start, end, tangent: size };
        let weight = 0.5 * size * size;
        if self.roughly_apart(&lines, 0.0, weight, patience)? {
            return Ok(true);
        }
        self.bends.fill(0.0);
        self.apart(&lines, weight, patience)
    }

    /// Whether all pairs stay apart where bodies go along their lines, but for their bends and `weight` times the largest
    /// acceleration.
    ///
    /// While two bodies are no nearer than half way from the nearest place on their lines to contact, their acceleration is at
    /// most G m / (d - p_1 - p_2)^2 there: each attracts like mass on its focal ellipse, which reaches p from its centre. If with
    /// this acceleration no pair goes farther than half its gap, then none has been nearer, and none has met. The same bound holds
    /// for the series of any degree, whose terms of degree n are at most n + 1 times ((p_1 + p_2) / d)^n of the first.
    fn apart(&mut self, lines: &Lines, weight: f64, patience: &mut Patience) -> Result<bool> {
        self.pulls.fill(0.0);
        let n = self.bodies.len();
        let mut index = 0;
        for i in 0..n {
            patience.spend(PAIR * (n - i) as u64, lines.time)?;
            for j in i + 1..n {
                let [from, to, along] = lines.of(i, j);
                self.nearest[index] = nearest(&from, &to).min(nearest(&from, &along));
                let (a, b) = (&self.bodies[i], &self.bodies[j]);
                let inner = 0.5 * (self.nearest[index] + a.radius + b.radius) - (a.focal + b.focal);
                if weight > 0.0 {
                    let per_mu = if inner > 0.0 { 1.0 / (inner * inner) } else { f64::INFINITY };
                    self.pulls[i] += a.terms * b.mu * per_mu;
                    self.pulls[j] += b.terms * a.mu * per_mu;
                }
                index += 1;
            }
        }
        let mut pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).zip(&self.nearest);
        // A NaN leaves a doubt.
        Ok(pairs.all(|((i, j), near)| {
            let bend = self.bends[i] + self.bends[j] + weight * (self.pulls[i] + self.pulls[j]);
            bend + MARGIN * near <= 0.5 * (near - (self.bodies[i].radius + self.bodies[j].radius))
        }))
    }

    /// The same with the least and the largest values of all pairs in place of each pair's own, which is quick and
    /// mostly enough.
    fn roughly_apart(&self, lines: &Lines, bend: f64, weight: f64, patience: &mut Patience) -> Result<bool> {
        let (mut gap, mut inner) = (f64::INFINITY, f64::INFINITY);
        for (i, a) in self.bodies.iter().enumerate() {
            patience.spend(PAIR * (self.bodies.len() - i) as u64, lines.time)?;
            for (j, b) in self.bodies.iter().enumerate().skip(i + 1) {
                let [from, to, along] = lines.of(i, j);
                let way = larger((to - from).norm_squared(), (along - from).norm_squared());
                let near = (1.0 - 2.0 * MARGIN) * from.norm() - way.sqrt();
                let touching = a.radius + b.radius;
                // Written so that NaN leaves a doubt.
                let apart = near > touching;
                if !apart {
                    return Ok(false);
                }
                gap = gap.min(near - touching);
                inner = inner.min(0.5 * (near + touching) - (a.focal + b.focal));
            }
        }
        let square = inner * inner;
        Ok(inner > 0.0 && 2.0 * bend * square + weight * self.pull <= 0.5 * gap * square)
    }

    /// The first contact on a piece, which is the one with this index.
    pub fn search(
        &mut self,
        layout: Layout,
        piece: &Segment,
        index: usize,
        patience: &mut Patience,
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
            self.bends[body] = 0.125 * piece.rates(p, 3)[1];
        }
        let mut found: Option<Contact> = None;
        for i in 0..n {
            patience.spend(n as u64, piece.start())?;
            for j in i + 1..n {
                let (a, b) = (&self.bodies[i], &self.bodies[j]);
                let touching = a.radius + b.radius;
                let [from, to] = [0, 1].map(|k| self.ends[j][k] - self.ends[i][k]);
                let near = nearest(&from, &to);
                let bend = self.bends[i] + self.bends[j];
                if !(near - bend).is_finite() {
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
                if touching == 0.0 || near - bend > touching + MARGIN * near {
                    continue;
                }
                for parts in
                    a.parts.iter().flat_map(|first| b.parts.iter().map(move |second| [first, second]))
                {
                    let until = found.map_or(1.0, |contact| contact.theta);
                    let mut encounter = Encounter::new(piece, layout, [i, j], parts, [&a.name, &b.name]);
                    if let Some(theta) = encounter.first(until, patience)? {
                        let time = piece.time_at(theta);
                        found = Some(Contact { bodies: [i, j], piece: index, theta, time });
                    }
                }
            }
        }
        Ok(found)
    }
}

#[inline]
fn vector(y: &[f64], index: usize) -> Vec3 {
    let three = &y[index..index + 3];
    Vec3::new(three[0], three[1], three[2])
}

/// The larger of two numbers that are no NaN.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Straight lines that bodies might go along.
struct Lines<'a> {
    layout: Layout,
    /// The time of the start.
    time: f64,
    start: &'a [f64],
    end: &'a [f64],
    /// For how long along the first velocities.
    tangent: f64,
}

impl Lines<'_> {
    /// The separation of two bodies at the start, at the end, and where the first velocities lead.
    #[inline]
    fn of(&self, i: usize, j: usize) -> [Vec3; 3] {
        let between = |y: &[f64], i: usize, j: usize| vector(y, j) - vector(y, i);
        let (a, b) = (self.layout.position(i), self.layout.position(j));
        let from = between(self.start, a, b);
        let velocity = between(self.start, self.layout.velocity(i), self.layout.velocity(j));
        [from, between(self.end, a, b), from + velocity * self.tangent]
    }
}

/// How near the straight way between two places comes to the origin.
#[inline]
fn nearest(from: &Vec3, to: &Vec3) -> f64 {
    let path = to - from;
    let square = path.norm_squared();
    let part = if square > 0.0 { (-from.dot(&path) / square).clamp(0.0, 1.0) } else { 0.0 };
    (from + path * part).norm()
}
