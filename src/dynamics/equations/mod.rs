//! The equations of motion over the integrator's vector.

pub(super) mod changes;
pub(super) mod evaluation;
pub(super) mod invariants;
mod jacobi;
pub(super) mod layout;
pub(super) mod parameter;
pub(super) mod plausibility;
pub(super) mod quadrature;
pub(super) mod rejected;
mod rules;
mod scales;
mod snapshot_buffer;
pub(super) mod splitting;
pub(super) mod state;
pub(super) mod system;

use crate::error::Result;
use crate::forces::{ForceModel, LoadSum};
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3, rotation};
use crate::mutual::{Interaction, Link, Pair, Pose, TooNear};
use invariants::Energy;
use layout::{AttitudeChart, BarycentricFrame, Layout, vector};
use rejected::Rejected;
use snapshot_buffer::SnapshotBuffer;
use std::ops::Range;
use system::System;

/// The least cos theta of a trial state in Tait-Bryan angles. An accepted state within ten times that
/// distance of the pole ends the run.
const POLE: f64 = 1e-4;

/// The units of work of a link beside its nodes, and of making a link.
const LINK: u64 = 20;
const NEW: u64 = 300;

/// The equations of motion of one system, with their quadrature rules and buffers.
#[derive(Debug, Clone)]
pub struct Dynamics {
    pub(super) system: System,
    pub(super) layout: Layout,
    pub(super) links: Vec<(usize, usize, Link)>,
    /// The units of work of one evaluation with the rules in use.
    pub(super) work: u64,
    /// The parts of an evaluation: ranges of links, and of the nodes of their rules.
    pub(super) parts: Vec<(Range<usize>, Range<usize>)>,
    inertia: Vec<Vec3>,
    /// The attitudes of the last vector that was evaluated.
    pub(super) view: SnapshotBuffer,
    pub(super) acceleration: Vec<Vec3>,
    pub(super) torque: Vec<Vec3>,
    pub(super) external_forces: ForceModel,
    /// The sum of the external forces.
    pub(super) external_loads: LoadSum,
    /// The acceleration of the barycentre by the external forces.
    pub(super) barycentre_acceleration: Vec3,
}

impl System {
    /// Makes the equations of motion in a frame.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`]: systems of very many bodies take seconds.
    pub fn dynamics(&self, frame: &BarycentricFrame, interrupt: &mut InterruptCheck) -> Result<Dynamics> {
        Dynamics::new(self, frame, interrupt)
    }
}

impl Dynamics {
    fn new(system: &System, frame: &BarycentricFrame, interrupt: &mut InterruptCheck) -> Result<Self> {
        let n = system.bodies().len();
        system.check_polyhedra(interrupt)?;
        let external_forces = system.force_model().clone();
        // The list is allocated once: a thousand bodies have half a million pairs.
        let mut links = Vec::with_capacity(system.count_links());
        for (i, j) in system.pairs() {
            for link in system.links(i, j) {
                interrupt.charge(NEW, 0.0)?;
                links.push((i, j, link));
            }
        }
        Ok(Self {
            layout: system.layout(),
            work: 0,
            parts: vec![(0..links.len(), Pair::ALL)],
            links,
            inertia: system.bodies().iter().map(|body| body.inertia()).collect(),
            view: SnapshotBuffer::new(*frame, external_forces.needs_attitudes()),
            acceleration: vec![Vec3::zeros(); n],
            torque: vec![Vec3::zeros(); n],
            external_forces,
            external_loads: LoadSum::none(system.bodies()),
            barycentre_acceleration: Vec3::zeros(),
            system: system.clone(),
        })
    }

    /// Returns the system.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Returns the layout of the integrator's vector.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Returns the frame of the vectors.
    pub fn frame(&self) -> &BarycentricFrame {
        &self.view.frame
    }

    /// Returns the external forces.
    pub fn external_forces(&self) -> &ForceModel {
        &self.external_forces
    }

    /// Iterates over the pairs with the rules in use: one for two ordinary bodies, and one for each two parts
    /// of composites.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize, &Pair)> {
        self.links.iter().map(|(i, j, link)| (*i, *j, &link.pair))
    }

    /// Returns the number of parts of an evaluation, between which interrupts can be checked. It is one
    /// except for very many bodies and for large polyhedra.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Returns the units of work of a part with the rules in use, for [`InterruptCheck`].
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Evaluates a part of the accelerations of the centres and of the torques on the bodies; after the last
    /// part [`Self::loads`] returns them. Allocates nothing.
    pub fn load(&mut self, part: usize, time: f64, y: &[f64]) -> std::result::Result<(), Rejected> {
        if part == 0 {
            self.update_rotations(y);
            self.acceleration.fill(Vec3::zeros());
            self.torque.fill(Vec3::zeros());
        }
        let g = self.system.gravitational_constant;
        let (links, nodes) = self.parts[part].clone();
        for (i, j, link) in &self.links[links] {
            let (i, j) = (*i, *j);
            let pose = self.pose(y, i, j);
            if let Some(TooNear { separation, valid_from }) = link.too_near(&pose) {
                return Err(Rejected::TooClose { bodies: [i, j], separation, valid_from });
            }
            let masses = [self.system.bodies[i].mass, self.system.bodies[j].mass];
            let loads = (&mut self.acceleration[..], &mut self.torque[..]);
            // Two separate calls are faster, since the result of a single call stays in registers.
            match link.ordinary() {
                Some(pair) if nodes == Pair::ALL => add(pair.interaction(&pose), [i, j], g, masses, loads),
                _ => add(link.interaction_of(&pose, nodes.clone()), [i, j], g, masses, loads),
            }
        }
        if self.layout.forces > 0 && part + 1 == self.parts.len() {
            self.add_external_loads(time, y)
        } else {
            Ok(())
        }
    }

    /// Returns the accelerations of the centres and the torques on the bodies.
    pub fn loads(&self) -> (&[Vec3], &[Vec3]) {
        (&self.acceleration, &self.torque)
    }

    /// Evaluates a part of the rates of change; the last part leaves them in `rate`. Allocates nothing.
    pub fn derivative(
        &mut self,
        part: usize,
        time: f64,
        y: &[f64],
        rate: &mut [f64],
    ) -> std::result::Result<(), Rejected> {
        self.load(part, time, y)?;
        if part + 1 < self.parts.len() {
            return Ok(());
        }
        let layout = self.layout;
        let positions = 3 * layout.bodies;
        let (velocities, other_rates) = rate.split_at_mut(positions);
        velocities.copy_from_slice(&y[positions..2 * positions]);
        // `total` is not finite as soon as one of the rates is not. It is formed from values that are still
        // in registers, since reading the rates back from memory would take longer.
        let mut total: f64 = y[positions..2 * positions].iter().sum();
        for body in 0..layout.bodies {
            let v = layout.velocity(body) - positions;
            let acceleration = &self.acceleration[body];
            other_rates[v..v + 3].copy_from_slice(acceleration.as_slice());
            let spin = vector(y, layout.spin(body));
            let a = layout.attitude(body);
            match layout.chart {
                AttitudeChart::Quaternion => {
                    let q = [y[a], y[a + 1], y[a + 2], y[a + 3]];
                    let attitude_rate = rotation::quaternion_rate(q, spin);
                    other_rates[a - positions..a - positions + 4].copy_from_slice(&attitude_rate);
                    total += attitude_rate.iter().sum::<f64>();
                }
                AttitudeChart::TaitBryan => {
                    let angles = [y[a], y[a + 1], y[a + 2]];
                    if angles[1].cos() < POLE {
                        return Err(Rejected::Pole);
                    }
                    let attitude_rate = rotation::tait_bryan_rate(angles, spin);
                    other_rates[a - positions..a - positions + 3].copy_from_slice(&attitude_rate);
                    total += attitude_rate.iter().sum::<f64>();
                }
            }
            let s = layout.spin(body) - positions;
            let change = euler(self.inertia[body], spin, self.torque[body]);
            other_rates[s..s + 3].copy_from_slice(change.as_slice());
            total += acceleration.sum() + change.sum();
        }
        if layout.forces > 0 {
            let d = layout.barycentre_offset();
            rate[d..d + 3].copy_from_slice(&y[d + 3..d + 6]);
            rate[d + 3..d + 6].copy_from_slice(self.barycentre_acceleration.as_slice());
            total += y[d + 3..d + 6].iter().sum::<f64>() + self.barycentre_acceleration.sum();
        }
        if total.is_finite() { Ok(()) } else { Err(Rejected::NotFinite) }
    }

    /// Returns the energy with the rules in use.
    pub fn energy(
        &mut self,
        time: f64,
        y: &[f64],
        velocities: &[Vec3],
        interrupt: &mut InterruptCheck,
    ) -> Result<Energy> {
        self.update_rotations(y);
        let mut potential = 0.0;
        for (i, j, link) in &self.links {
            let pose = self.pose(y, *i, *j);
            interrupt.charge(LINK, time)?;
            link.add_energy(&pose, self.system.strength(*i, *j), &mut potential, time, interrupt)?;
        }
        let translational =
            self.system.bodies.iter().zip(velocities).map(|(b, v)| 0.5 * b.mass * v.norm_squared()).sum();
        let rotational = (0..self.layout.bodies)
            .map(|b| {
                let spin = vector(y, self.layout.spin(b));
                0.5 * self.inertia[b].dot(&spin.component_mul(&spin))
            })
            .sum();
        Ok(Energy::new(translational, rotational, potential))
    }

    /// Returns the total angular momentum about the origin, for a vector at a time.
    pub fn angular_momentum(&self, time: f64, y: &[f64]) -> Vec3 {
        invariants::angular_momentum_of_vector(&self.system.bodies, &self.view.frame, time, y)
    }

    pub(super) fn update_rotations(&mut self, y: &[f64]) {
        for body in 0..self.layout.bodies {
            self.view.rotation[body] = self.attitude(y, body);
        }
    }

    /// Returns the rotation matrix of a body.
    #[inline(always)]
    pub(super) fn attitude(&self, y: &[f64], body: usize) -> Mat3 {
        let a = self.layout.attitude(body);
        match self.layout.chart {
            AttitudeChart::Quaternion => rotation::matrix([y[a], y[a + 1], y[a + 2], y[a + 3]]),
            AttitudeChart::TaitBryan => rotation::tait_bryan_matrix([y[a], y[a + 1], y[a + 2]]),
        }
    }

    #[inline(always)]
    pub(super) fn pose(&self, y: &[f64], i: usize, j: usize) -> Pose {
        Pose {
            separation: vector(y, self.layout.position(j)) - vector(y, self.layout.position(i)),
            rotation_first: self.view.rotation[i],
            rotation_second: self.view.rotation[j],
        }
    }
}

/// Adds the interaction of two bodies with these masses to accelerations and torques.
#[inline(always)]
fn add(
    f: Interaction,
    [i, j]: [usize; 2],
    g: f64,
    [mi, mj]: [f64; 2],
    (acceleration, torque): (&mut [Vec3], &mut [Vec3]),
) {
    acceleration[i] += g * mj * f.force_on_first;
    acceleration[j] -= g * mi * f.force_on_first;
    torque[i] += g * mi * mj * f.torque_first;
    torque[j] += g * mi * mj * f.torque_second;
}

/// Solves Euler's equations for the rate of the spin, the paper's `eq:DiffEq_phidott` to `eq:DiffEq_psidott`;
/// a body without inertia keeps its spin.
#[inline(always)]
fn euler(inertia: Vec3, spin: Vec3, torque: Vec3) -> Vec3 {
    let rate = |i: usize, j: usize, k: usize| {
        // The difference of the moments is formed first, so that the spin of a spheroid about its axis stays
        // exactly constant.
        let net_torque = torque[i] - (inertia[k] - inertia[j]) * spin[j] * spin[k];
        if inertia[i] > 0.0 { net_torque / inertia[i] } else { 0.0 }
    };
    Vec3::new(rate(0, 1, 2), rate(1, 2, 0), rate(2, 0, 1))
}
