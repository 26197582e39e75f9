//! A block of particles under an embedded Runge-Kutta pair: stages, errors and polynomials, each lane with its own time and step.

use super::course::{Block, COLUMNS, Course};
use super::outside::Outside;
use super::pull::{Puller, by_body};
use crate::error::Result;
use crate::integrate::{Segment, Tableau};
use crate::math::Vec3;
use crate::math::compensated::two_sum;
use crate::math::lanes::{BLOCK, Lanes};
use pulp::{Arch, Simd, WithSimd};

/// Position and velocity of a block.
pub type Motion = [Block; 6];

/// What moves the particles.
#[derive(Debug, Clone, Copy)]
pub struct World<'a> {
    /// The bodies.
    pub course: &'a Course<'a>,
    /// Their gravity.
    pub pullers: &'a [Puller],
    /// The pair.
    pub tableau: &'static Tableau,
    /// The instructions.
    pub arch: Arch,
}

/// A block of particles in the middle of a step.
#[derive(Debug, Clone)]
pub struct Stages<'a> {
    world: World<'a>,
    outside: Outside,
    /// Times at which the steps begin.
    pub time: Block,
    /// Their sizes.
    pub size: Block,
    /// Positions from the nominal barycentre and velocities relative to it, where the steps begin.
    pub motion: Motion,
    /// What rounding dropped of them.
    pub low: Motion,
    /// Area-to-mass ratios.
    pub area_to_mass: Block,
    /// Rates at the stages.
    rates: Vec<Motion>,
    /// Bodies' columns where rates were last taken.
    columns: Vec<Block>,
    cursors: [usize; BLOCK],
    trial: Motion,
    times: Block,
    /// Squared distance from the nearest centre and potential of the centres, where the steps begin.
    pub nearness: [Block; 2],
}

impl<'a> Stages<'a> {
    pub fn new(world: World<'a>, outside: Outside) -> Self {
        let none = [0.0; BLOCK];
        Self {
            world,
            outside,
            time: none,
            size: none,
            motion: [none; 6],
            low: [none; 6],
            area_to_mass: none,
            rates: vec![[none; 6]; world.tableau.a.len()],
            columns: vec![none; COLUMNS * world.course.bodies()],
            cursors: [0; BLOCK],
            trial: [none; 6],
            times: none,
            nearness: [none; 2],
        }
    }

    /// The bodies' columns where rates were last taken.
    pub fn columns(&self) -> &[Block] {
        &self.columns
    }

    /// The acceleration of a lane at the beginning of its step.
    pub fn first(&self, lane: usize) -> Vec3 {
        Vec3::from([3, 4, 5].map(|c| self.rates[0][c][lane]))
    }

    /// Takes the rates at the beginning of the steps.
    pub fn begin(&mut self) -> Result<()> {
        (self.times, self.trial) = (self.time, self.motion);
        self.nearness = [[f64::INFINITY; BLOCK], [0.0; BLOCK]];
        self.rate(0, true)
    }

    /// Takes the other stages of the pair.
    pub fn attempt(&mut self) -> Result<()> {
        (1..self.world.tableau.stages).try_for_each(|stage| self.stage(stage))
    }

    /// Takes the stages of the interpolant.
    pub fn complete(&mut self) -> Result<()> {
        (self.world.tableau.stages..self.world.tableau.a.len()).try_for_each(|stage| self.stage(stage))
    }

    fn stage(&mut self, stage: usize) -> Result<()> {
        let tableau = self.world.tableau;
        let low = tableau.a_low.get(stage).copied().unwrap_or(&[]);
        self.combine(tableau.a[stage], low);
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

    /// Where the steps end, and what rounding drops of that.
    pub fn end(&mut self) -> (Motion, Motion) {
        self.combine(self.world.tableau.b, self.world.tableau.b_low);
        let (mut high, mut low) = (self.motion, self.low);
        for c in 0..6 {
            for lane in 0..BLOCK {
                let (sum, error) = two_sum(high[c][lane], self.trial[c][lane]);
                (high[c][lane], low[c][lane]) = two_sum(sum, error + low[c][lane]);
            }
        }
        (high, low)
    }

    /// Estimated errors of position and velocity at the ends.
    pub fn errors(&mut self) -> [Block; 2] {
        let tableau = self.world.tableau;
        let mut weights = [0.0; 32];
        for (weight, (b, b_hat)) in weights.iter_mut().zip(tableau.b.iter().zip(tableau.b_hat)) {
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

    /// The polynomial of a lane's step, once the stages of the interpolant are there.
    pub fn segment(&self, lane: usize, out: &mut Segment) {
        let weights = self.world.tableau.interpolant.weights;
        let number = |vector: &Motion| [0, 1, 2, 3, 4, 5].map(|c| vector[c][lane]);
        let (high, low) = (number(&self.motion), number(&self.low));
        out.refill((self.time[lane], self.size[lane]), (&high, &low), |term, c| {
            let weighted = weights.iter().zip(&self.rates);
            weighted.map(|(row, rates)| row.get(term).map_or(0.0, |w| w * rates[c][lane])).sum()
        });
    }

    /// Size times a weighted sum of the rates, into the trial vector.
    fn combine(&mut self, weights: &[f64], low: &[f64]) {
        let (rates, size, out) = (&self.rates, &self.size, &mut self.trial);
        self.world.arch.dispatch(Combination { weights, low, rates, size, out });
    }

    /// Takes the rates at the trial vector.
    fn rate(&mut self, stage: usize, first: bool) -> Result<()> {
        let out = &mut self.rates[stage];
        self.world.arch.dispatch(Rates {
            world: self.world,
            times: &self.times,
            at: &self.trial,
            cursors: &mut self.cursors,
            columns: &mut self.columns,
            nearness: first.then_some(&mut self.nearness),
            out,
        });
        let ([x, y, z, ..], [_, _, _, ax, ay, az]) = (&self.trial, out);
        let (place, mut acceleration) = ([*x, *y, *z], [*ax, *ay, *az]);
        for (puller, columns) in self.world.pullers.iter().zip(by_body(&self.columns)) {
            puller.add_polyhedra(columns, &place, &mut acceleration);
        }
        if !self.outside.is_empty() {
            for lane in 0..BLOCK {
                let x = Vec3::from([0, 1, 2].map(|c| place[c][lane]));
                let (time, ratio) = (self.times[lane], self.area_to_mass[lane]);
                let more = self.outside.acceleration(time, &x, ratio, &self.columns, lane)?;
                (0..3).for_each(|c| acceleration[c][lane] += more[c]);
            }
        }
        (*ax, *ay, *az) = (acceleration[0], acceleration[1], acceleration[2]);
        Ok(())
    }
}

/// The sum of rates by the weights and their low parts, times the size.
struct Combination<'a> {
    weights: &'a [f64],
    low: &'a [f64],
    rates: &'a [Motion],
    size: &'a Block,
    out: &'a mut Motion,
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

/// Rates at the places of a block at its times: velocities, and the bodies' gravity.
struct Rates<'a> {
    world: World<'a>,
    times: &'a Block,
    at: &'a Motion,
    cursors: &'a mut [usize; BLOCK],
    columns: &'a mut Vec<Block>,
    nearness: Option<&'a mut [Block; 2]>,
    out: &'a mut Motion,
}

impl WithSimd for Rates<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.world.course.places(simd, self.times, self.cursors, self.columns);
        let [x, y, z, vx, vy, vz] = *self.at;
        let mut acceleration = [[0.0; BLOCK]; 3];
        for (puller, columns) in self.world.pullers.iter().zip(by_body(self.columns)) {
            puller.add(simd, columns, &[x, y, z], &mut acceleration, self.nearness.as_deref_mut());
        }
        let [ax, ay, az] = acceleration;
        *self.out = [vx, vy, vz, ax, ay, az];
    }
}
