//! The variational equations over a step, by Gauss's collocation method.
//!
//! With n nodes the method has order 2 n and evaluates the derivatives of the loads n times a step. It
//! conserves every quadratic invariant of the equations to round-off, among them the symplectic form. Within
//! a step the rotation vectors are in inertial axes, where the body's own rotation does not enter their
//! equation: theta' = R dspin. The remaining terms couple the numbers weakly, so that a few iterations
//! ("sweeps") over the step's equations converge. They begin with the extrapolated polynomial of the previous
//! step.

use super::Variations;
use super::products::DEPTH;
use super::sweeps::{CollocationStep, Sweeps, TOGETHER};
use crate::dynamics::Dynamics;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::gauss::Gauss;
use crate::math::lanes::few;
use crate::math::{Mat3, Vec3};
use std::num::NonZeroUsize;

/// The approximate number of sweeps of a step, for [`InterruptCheck`].
const SWEEPS: usize = 6;

/// The share of a tangent vector's size below which the last terms of its polynomial count as rounding errors.
/// The integral of the Legendre polynomial of degree k over a part of [0, 1] is at most 1 / (2 k + 1).
const RESOLVED: f64 = 512.0 * f64::EPSILON;

/// The largest number of nodes for which the sweeps are compiled, which are 3, 4, 5 and twice as many.
const MOST_NODES: usize = 10;

/// Returns the number of nodes with which the end of a step has at least an order, if it is one of the numbers
/// for which the sweeps are compiled.
fn nodes_of_order(order: u32) -> usize {
    (order as usize / 2 + 1).clamp(3, MOST_NODES / 2)
}

/// A step of tangent vectors: their equations at its nodes, and its solution.
#[derive(Debug, Clone)]
pub struct Collocation {
    gauss: Gauss,
    half: usize,
    width: usize,
    /// The number of columns that belong to the initial state.
    initial: usize,
    stride: usize,
    rotation_row: usize,
    bodies: usize,
    /// The matrices A and B at the nodes, one after the other. The columns of A for rotations refer to
    /// rotation vectors in inertial axes.
    by_pose: Vec<f64>,
    by_rate: Vec<f64>,
    /// The derivatives of the rates with respect to the parameters, at the nodes, as rows of columns.
    forcing: Vec<f64>,
    /// Attitudes at the nodes, body by body, and at the step's ends.
    attitudes: Vec<Mat3>,
    ends: [Vec<Mat3>; 2],
    /// The factors of the two spins in each of Euler's equations.
    euler: Vec<[f64; 2]>,
    sizes: Vec<[f64; 3]>,
    inverse: Vec<f64>,
    inverse_rates: Vec<f64>,
    /// The rates of p at the nodes of the previous step and of the present one.
    p_rates: [Vec<f64>; 2],
    /// The size of the previous step, where this step continues from its end.
    previous_size: Option<f64>,
    /// The tangent vectors at the end of the step.
    end_columns: Vec<f64>,
    work: Vec<f64>,
    /// The vectors at the start of the step and their rates at the nodes, one node after the other, with rotation
    /// vectors in inertial axes; empty unless values within the step are computed.
    start: Vec<f64>,
    rates: Vec<f64>,
}

impl Collocation {
    /// Prepares steps for these variations, of at least the given order at their ends.
    pub fn new(variations: &Variations, order: u32) -> Self {
        Self::with_nodes(variations, nodes_of_order(order))
    }

    /// Prepares steps for these variations, of at least the given order at any time within them.
    pub fn interior(variations: &Variations, order: u32) -> Self {
        let count = 2 * nodes_of_order(order);
        let numbers = 2 * variations.half() * variations.width();
        let (start, rates) = (vec![0.0; numbers], vec![0.0; count * numbers]);
        Self { start, rates, ..Self::with_nodes(variations, count) }
    }

    fn with_nodes(variations: &Variations, count: usize) -> Self {
        let (half, width, bodies) = (variations.half(), variations.width(), variations.bodies);
        let stride = half.next_multiple_of(DEPTH);
        let forced = if width > variations.initial { count * half * width } else { 0 };
        let lanes = width.next_multiple_of(TOGETHER);
        Self {
            gauss: Gauss::new(NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN)),
            half,
            width,
            initial: variations.initial,
            stride,
            rotation_row: variations.rotation_row(0),
            bodies,
            by_pose: vec![0.0; count * half * stride],
            by_rate: vec![0.0; count * variations.by_rate.len()],
            forcing: vec![0.0; forced],
            attitudes: vec![Mat3::identity(); count * bodies],
            ends: [0, 1].map(|_| vec![Mat3::identity(); bodies]),
            euler: vec![[0.0; 2]; 3 * count * bodies],
            sizes: vec![[1.0; 3]; bodies],
            inverse: vec![1.0; 2 * half],
            inverse_rates: vec![1.0; half],
            p_rates: [0, 1].map(|_| vec![0.0; half * count * lanes]),
            previous_size: None,
            end_columns: vec![0.0; 2 * half * width],
            work: vec![0.0; half * (2 * count + 3) * TOGETHER],
            start: Vec::new(),
            rates: Vec::new(),
        }
    }

    /// Returns the method's nodes and coefficients, as fractions of a step.
    pub fn gauss(&self) -> &Gauss {
        &self.gauss
    }

    /// Stores the coefficients of the variational equations at a node, as they were last evaluated, with the
    /// motion's vector there.
    pub fn load(&mut self, node: usize, dynamics: &Dynamics, variations: &Variations, y: &[f64]) {
        let Self { half, width, initial, stride, rotation_row, bodies, .. } = *self;
        let rows = node * half * stride..(node + 1) * half * stride;
        let by_pose = &mut self.by_pose[rows.clone()];
        by_pose.copy_from_slice(&variations.by_pose);
        for body in 0..bodies {
            let attitude = dynamics.attitude(y, body);
            self.attitudes[body * self.gauss.nodes.len() + node] = attitude;
            for row in by_pose.chunks_exact_mut(stride) {
                let by_rotation = &mut row[rotation_row + 3 * body..][..3];
                let [x, y, z] = [by_rotation[0], by_rotation[1], by_rotation[2]];
                (0..3).for_each(|c| {
                    by_rotation[c] = attitude[(c, 0)] * x + attitude[(c, 1)] * y + attitude[(c, 2)] * z;
                });
            }
            self.euler[3 * (node * bodies + body)..][..3].copy_from_slice(&variations.euler(body));
        }
        if !self.by_rate.is_empty() {
            self.by_rate[rows].copy_from_slice(&variations.by_rate);
        }
        if !self.forcing.is_empty() {
            let forcing = &mut self.forcing[node * half * width..(node + 1) * half * width];
            // The columns of the initial state have no forcing, and stay zero.
            forcing.chunks_exact_mut(width).for_each(|row| row[initial..].fill(0.0));
            variations.force(|row, column, value| forcing[row * width + column] += value);
        }
    }

    /// Stores the motion's vectors at the ends of a step.
    pub fn load_ends(&mut self, dynamics: &Dynamics, variations: &Variations, ends: [&[f64]; 2]) {
        for (attitudes, y) in self.ends.iter_mut().zip(ends) {
            for (body, attitude) in attitudes.iter_mut().enumerate() {
                *attitude = dynamics.attitude(y, body);
            }
        }
        dynamics.scales(ends[0], &mut self.sizes);
        variations.inverse_sizes(&self.sizes, &mut self.inverse);
    }

    /// Forgets the previous step, so that nothing is extrapolated.
    pub fn forget(&mut self) {
        self.previous_size = None;
    }

    /// Solves the equations of a step, given by its start and size; `follows` says that it continues the step
    /// that was remembered last. Returns whether the sweeps converged; then [`Self::end_columns`] returns the
    /// solution at the end.
    pub fn solve(
        &mut self,
        dynamics: &Dynamics,
        step: [f64; 2],
        columns: &[f64],
        follows: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        let previous_size = self.previous_size.filter(|_| follows);
        match self.gauss.nodes.len() {
            3 => self.solve_with::<3>(dynamics, step, columns, previous_size, interrupt),
            4 => self.solve_with::<4>(dynamics, step, columns, previous_size, interrupt),
            5 => self.solve_with::<5>(dynamics, step, columns, previous_size, interrupt),
            6 => self.solve_with::<6>(dynamics, step, columns, previous_size, interrupt),
            8 => self.solve_with::<8>(dynamics, step, columns, previous_size, interrupt),
            _ => self.solve_with::<10>(dynamics, step, columns, previous_size, interrupt),
        }
    }

    fn solve_with<const N: usize>(
        &mut self,
        dynamics: &Dynamics,
        [from, size]: [f64; 2],
        columns: &[f64],
        previous_size: Option<f64>,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        let Self { half, width, initial, stride, rotation_row, .. } = *self;
        let rates = self.inverse_rates.iter_mut().zip(&self.inverse[half..]);
        rates.for_each(|(rate, inverse)| *rate = size.abs() * inverse);
        let [previous_rates, p_rates] = &mut self.p_rates;
        // The polynomial of the previous step does not reach into a much longer one.
        let growth =
            previous_size.map(|previous| size / previous).filter(|growth| (0.0..=2.0).contains(growth));
        let factors = growth.map(|growth| {
            let mut factors = [[0.0; N]; N];
            for (row, node) in factors.iter_mut().zip(&self.gauss.nodes) {
                self.gauss.factors(1.0 + node * growth, row);
            }
            factors
        });
        let step = CollocationStep::<N> {
            size: [half, width],
            initial,
            integrals: std::array::from_fn(|i| std::array::from_fn(|j| size * self.gauss.integrals[i][j])),
            weights: std::array::from_fn(|i| size * self.gauss.weights[i]),
            by_pose: &self.by_pose,
            by_rate: &self.by_rate,
            stride,
            forcing: &self.forcing,
            rotation_row,
            attitudes: &self.attitudes,
            ends: [&self.ends[0], &self.ends[1]],
            euler: &self.euler,
            inverse: &self.inverse,
            inverse_rates: &self.inverse_rates,
            columns,
            previous_rates,
            factors,
        };
        let work = SWEEPS * TOGETHER * (self.by_pose.len() + self.by_rate.len()) / 64;
        for first in (0..width).step_by(TOGETHER) {
            interrupt.charge(work as u64, from)?;
            let range = first..width.min(first + TOGETHER);
            let arch = few(dynamics.system().arch(), range.len());
            let (out, work, rates) = (&mut self.end_columns, &mut self.work, &mut self.rates);
            if !arch.dispatch(Sweeps { step: &step, range, out, p_rates, work, rates }) {
                return Ok(false);
            }
        }
        if !self.rates.is_empty() {
            let mut start = std::mem::take(&mut self.start);
            start.copy_from_slice(columns);
            self.rotate(|body| self.ends[0][body], &mut start);
            self.start = start;
        }
        Ok(true)
    }

    /// Returns the tangent vectors at the end of the step that was solved last.
    pub fn end_columns(&self) -> &[f64] {
        &self.end_columns
    }

    /// Writes the tangent vectors at a fraction of the step that was solved last, where the motion's vector is
    /// `y`. The steps have been prepared by [`Self::interior`].
    pub fn within(&self, dynamics: &Dynamics, (fraction, size): (f64, f64), y: &[f64], out: &mut [f64]) {
        let mut weights = [0.0; MOST_NODES];
        self.gauss.integrals_to(fraction, &mut weights[..self.gauss.nodes.len()]);
        dynamics.system().arch().dispatch(|| {
            out.copy_from_slice(&self.start);
            for (rates, weight) in self.rates.chunks_exact(out.len()).zip(weights) {
                out.iter_mut().zip(rates).for_each(|(out, rate)| *out += size * weight * rate);
            }
        });
        self.rotate(|body| dynamics.attitude(y, body).transpose(), out);
    }

    /// Returns whether the tangent vectors within the step that was solved last, which has this size, are
    /// polynomials up to rounding errors, which the size of their last terms shows.
    pub fn is_resolved(&self, size: f64) -> bool {
        let Self { width, half, start, rates, inverse, .. } = self;
        let numbers = start.len();
        (0..*width).all(|column| {
            let (mut scale, mut last) = (f64::MIN_POSITIVE, 0.0_f64);
            for row in 0..2 * half {
                let first = row * width + column;
                let at_nodes = rates[first..].iter().step_by(numbers);
                let highest: f64 = at_nodes.zip(self.gauss.highest()).map(|(rate, by)| rate * by).sum();
                scale += (start[first].abs() + size.abs() * rates[first].abs()) * inverse[row];
                last = last.max(size.abs() * highest.abs() * inverse[row]);
            }
            last <= 2.0 * self.gauss.nodes.len() as f64 * RESOLVED * scale
        })
    }

    /// Multiplies the rotation vectors of columns by a matrix for each body.
    fn rotate(&self, matrix: impl Fn(usize) -> Mat3, columns: &mut [f64]) {
        for body in 0..self.bodies {
            let (matrix, first) = (matrix(body), (self.rotation_row + 3 * body) * self.width);
            for column in first..first + self.width {
                let rows = [column, column + self.width, column + 2 * self.width];
                let rotated = matrix * Vec3::from(rows.map(|row| columns[row]));
                (0..3).for_each(|c| columns[rows[c]] = rotated[c]);
            }
        }
    }

    /// Stores the polynomial of the step that was solved, which has this size, as the start for the next one.
    pub fn remember(&mut self, size: f64) {
        self.p_rates.swap(0, 1);
        self.previous_size = Some(size);
    }

    /// Iterates over a single tangent vector at a node of the step that was solved last, with its rotation
    /// vectors in inertial axes.
    pub fn at_node(&self, node: usize) -> impl Iterator<Item = &f64> {
        self.work.chunks_exact(self.gauss.nodes.len()).take(2 * self.half).map(move |row| &row[node])
    }
}
