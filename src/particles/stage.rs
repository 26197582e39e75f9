//! The stages of an embedded Runge-Kutta pair for a block of particles, with errors and polynomials, each
//! lane with its own time and step.

use super::attraction::{ParticleAttractor, by_body};
use super::body_ephemeris::{BodyEphemeris, COLUMNS, LaneBlock};
use super::external_forces::ExternalForces;
use crate::error::Result;
use crate::integrate::{Segment, Tableau};
use crate::math::Vec3;
use crate::math::compensated::two_sum;
use crate::math::lanes::{BLOCK, Lanes};
use pulp::{Arch, Simd, WithSimd};

/// Positions and velocities of the particles of a block.
pub type MotionBlock = [LaneBlock; 6];

/// The bodies' ephemeris and gravity, with the integrator's pair.
#[derive(Debug, Clone, Copy)]
pub struct FlightModel<'a> {
    /// The ephemeris of the bodies.
    pub ephemeris: &'a BodyEphemeris<'a>,
    /// The gravity of the bodies.
    pub attractors: &'a [ParticleAttractor],
    /// The Runge-Kutta pair.
    pub tableau: &'static Tableau,
    /// The vector instructions.
    pub arch: Arch,
}

/// A block of particles within a step.
#[derive(Debug, Clone)]
pub struct Stages<'a> {
    model: FlightModel<'a>,
    external_forces: ExternalForces,
    /// The times at which the steps begin.
    pub time: LaneBlock,
    /// The sizes of the steps.
    pub size: LaneBlock,
    /// The positions relative to the nominal barycentre and the velocities, where the steps begin.
    pub motion: MotionBlock,
    /// The low parts of positions and velocities.
    pub low: MotionBlock,
    /// The area-to-mass ratios.
    pub area_to_mass: LaneBlock,
    /// The rates at the stages.
    rates: Vec<MotionBlock>,
    /// The bodies' columns at the last evaluation of the rates.
    columns: Vec<LaneBlock>,
    cursors: [usize; BLOCK],
    trial: MotionBlock,
    times: LaneBlock,
    /// The squared distance from the nearest centre and the potential of the centres, where the steps begin.
    pub nearness: [LaneBlock; 2],
}

impl<'a> Stages<'a> {
    pub fn new(model: FlightModel<'a>, external_forces: ExternalForces) -> Self {
        let none = [0.0; BLOCK];
        Self {
            model,
            external_forces,
            time: none,
            size: none,
            motion: [none; 6],
            low: [none; 6],
            area_to_mass: none,
            rates: vec![[none; 6]; model.tableau.a.len()],
            columns: vec![none; COLUMNS * model.ephemeris.bodies()],
            cursors: [0; BLOCK],
            trial: [none; 6],
            times: none,
            nearness: [none; 2],
        }
    }

    /// Returns the bodies' columns at the last evaluation of the rates.
    pub fn columns(&self) -> &[LaneBlock] {
        &self.columns
    }

    /// Returns the acceleration of a lane at the beginning of its step.
    pub fn first(&self, lane: usize) -> Vec3 {
        Vec3::from([3, 4, 5].map(|c| self.rates[0][c][lane]))
    }

    /// Evaluates the rates at the beginning of the steps.
    pub fn begin(&mut self) -> Result<()> {
        (self.times, self.trial) = (self.time, self.motion);
        self.nearness = [[f64::INFINITY; BLOCK], [0.0; BLOCK]];
        self.rate(0, true)
    }

    /// Evaluates the other stages of the pair.
    pub fn attempt(&mut self) -> Result<()> {
        (1..self.model.tableau.stages).try_for_each(|stage| self.stage(stage))
    }

    /// Evaluates the stages of the interpolant.
    pub fn complete(&mut self) -> Result<()> {
        (self.model.tableau.stages..self.model.tableau.a.len()).try_for_each(|stage| self.stage(stage))
    }

    fn stage(&mut self, stage: usize) -> Result<()> {
        let tableau = self.model.tableau;
        let low = tableau.a_low.get(stage).map_or(&[][..], Vec::as_slice);
        self.combine(&tableau.a[stage], low);
        for c in 0..6 {
            for lane in 0..BLOCK {
                self.trial[c][lane] = self.motion[c][lane] + (self.low[c][lane] + self.trial[c][lane]);
            }
        }
        for lane in 0..BLOCK {
            self.times[lane] = self.time[lane] + tableau.c[stage] * self.size[lane];
        }
        self.rate(stage, false)
    }

    /// Returns the end of the steps in two parts.
    pub fn end(&mut self) -> (MotionBlock, MotionBlock) {
        self.combine(&self.model.tableau.b, &self.model.tableau.b_low);
        let (mut high, mut low) = (self.motion, self.low);
        for c in 0..6 {
            for lane in 0..BLOCK {
                let (sum, error) = two_sum(high[c][lane], self.trial[c][lane]);
                (high[c][lane], low[c][lane]) = two_sum(sum, error + low[c][lane]);
            }
        }
        (high, low)
    }

    /// Returns the estimated errors of position and velocity at the ends.
    pub fn errors(&mut self) -> [LaneBlock; 2] {
        let tableau = self.model.tableau;
        let mut weights = [0.0; 32];
        for (weight, (b, b_hat)) in weights.iter_mut().zip(tableau.b.iter().zip(&tableau.b_hat)) {
            *weight = b - b_hat;
        }
        self.combine(&weights[..tableau.b.len()], &[]);
        let mut errors = [[0.0; BLOCK]; 2];
        for lane in 0..BLOCK {
            let square = |c: usize| self.trial[c][lane] * self.trial[c][lane];
            errors[0][lane] = (square(0) + square(1) + square(2)).sqrt();
            errors[1][lane] = (square(3) + square(4) + square(5)).sqrt();
        }
        errors
    }

    /// Writes the polynomial of a lane's step, once the stages of the interpolant have been evaluated.
    pub fn segment(&self, lane: usize, out: &mut Segment) {
        let weights = &self.model.tableau.interpolant.weights;
        let number = |vector: &MotionBlock| [0, 1, 2, 3, 4, 5].map(|c| vector[c][lane]);
        let (high, low) = (number(&self.motion), number(&self.low));
        out.refill((self.time[lane], self.size[lane]), (&high, &low), |term, c| {
            let weighted = weights.iter().zip(&self.rates);
            weighted.map(|(row, rates)| row.get(term).map_or(0.0, |w| w * rates[c][lane])).sum()
        });
    }

    /// Writes the size of the steps times a weighted sum of the rates into the trial vector.
    fn combine(&mut self, weights: &[f64], low: &[f64]) {
        let (rates, size, out) = (&self.rates, &self.size, &mut self.trial);
        self.model.arch.dispatch(Combination { weights, low, rates, size, out });
    }

    /// Evaluates the rates at the trial vector.
    fn rate(&mut self, stage: usize, first: bool) -> Result<()> {
        let out = &mut self.rates[stage];
        self.model.arch.dispatch(Rates {
            model: self.model,
            times: &self.times,
            at: &self.trial,
            cursors: &mut self.cursors,
            columns: &mut self.columns,
            nearness: first.then_some(&mut self.nearness),
            out,
        });
        let ([x, y, z, ..], [_, _, _, ax, ay, az]) = (&self.trial, out);
        let (position, mut acceleration) = ([*x, *y, *z], [*ax, *ay, *az]);
        for (attractor, columns) in self.model.attractors.iter().zip(by_body(&self.columns)) {
            attractor.add_pointwise(columns, &position, &mut acceleration);
        }
        if !self.external_forces.is_empty() {
            for lane in 0..BLOCK {
                let x = Vec3::from([0, 1, 2].map(|c| position[c][lane]));
                let (time, ratio) = (self.times[lane], self.area_to_mass[lane]);
                let more = self.external_forces.acceleration(time, &x, ratio, &self.columns, lane)?;
                (0..3).for_each(|c| acceleration[c][lane] += more[c]);
            }
        }
        (*ax, *ay, *az) = (acceleration[0], acceleration[1], acceleration[2]);
        Ok(())
    }
}

/// Computes the sum of rates with the weights and their low parts, times the size.
struct Combination<'a> {
    weights: &'a [f64],
    low: &'a [f64],
    rates: &'a [MotionBlock],
    size: &'a LaneBlock,
    out: &'a mut MotionBlock,
}

impl WithSimd for Combination<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for block in 0..Lanes::<S>::PER_BLOCK {
            let size: Lanes<S> = Lanes::load(simd, self.size, block);
            for c in 0..6 {
                let zero = Lanes::splat(simd, 0.0);
                let (mut sum, mut tail) = (zero, zero);
                for (stage, &weight) in self.weights.iter().enumerate() {
                    if weight != 0.0 {
                        let rate = Lanes::load(simd, &self.rates[stage][c], block);
                        sum = rate.mul_add(zero.constant(weight), sum);
                        if let Some(&low) = self.low.get(stage) {
                            tail = rate.mul_add(zero.constant(low), tail);
                        }
                    }
                }
                (size * tail + size * sum).store(&mut self.out[c], block);
            }
        }
    }
}

/// Evaluates the rates of a block: velocities, and the bodies' gravity.
struct Rates<'a> {
    model: FlightModel<'a>,
    times: &'a LaneBlock,
    at: &'a MotionBlock,
    cursors: &'a mut [usize; BLOCK],
    columns: &'a mut Vec<LaneBlock>,
    nearness: Option<&'a mut [LaneBlock; 2]>,
    out: &'a mut MotionBlock,
}

impl WithSimd for Rates<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.model.ephemeris.columns_at(simd, self.times, self.cursors, self.columns);
        let [x, y, z, vx, vy, vz] = *self.at;
        let mut acceleration = [[0.0; BLOCK]; 3];
        for (attractor, columns) in self.model.attractors.iter().zip(by_body(self.columns)) {
            attractor.add(simd, columns, &[x, y, z], &mut acceleration, self.nearness.as_deref_mut());
        }
        let [ax, ay, az] = acceleration;
        *self.out = [vx, vy, vz, ax, ay, az];
    }
}
