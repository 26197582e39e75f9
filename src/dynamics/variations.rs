//! The equations of small departures from a motion, in relative coordinates.
//!
//! A departure has 12 numbers a body: position and velocity (inertial), a rotation vector theta in the body frame, R -> R exp(theta),
//! and spin. The centres are taken from the first body's, d_k = dx_k - dx_0, and their rates e_k likewise, since the barycentre's
//! departure moves uniformly. With q = (d, theta) and p = (e, dspin),
//!
//!   dd/dt = e,   dtheta/dt = dspin - spin x theta,   dp/dt = A q + B p,
//!
//! A from the Jacobians of the pairs, B from Euler's equations. Many departures are one matrix, a column each; behind the columns of
//! the initial state there is one for every parameter, with the derivative of the rates by the parameter as a further term.

use super::layout::vector;
use super::{Dynamics, Parameter, State};
use crate::error::Result;
use crate::math::compensated::sum;
use crate::math::rows::{DEPTH, Product};
use crate::math::{Mat3, Vec3};
use crate::mutual::Jacobian;
use crate::patience::Patience;

/// Numbers of a departure per body.
pub const DEPARTURE: usize = 12;

/// Units of work of a pair's Jacobian for each of its nodes.
const GRADIENT: u64 = 2;

/// What departures from a motion obey at one of its moments.
#[derive(Debug, Clone)]
pub struct Variations {
    bodies: usize,
    masses: Vec<f64>,
    parameters: Vec<Parameter>,
    /// Rows of A, with zeros behind.
    matrix: Vec<f64>,
    stride: usize,
    spin: Vec<Vec3>,
    /// (I_k - I_j) / I_i for every body.
    ratios: Vec<Vec3>,
    inverse_inertia: Vec<Vec3>,
    /// Derivatives of dp/dt by the parameters, one after the other.
    forcing: Vec<f64>,
}

impl Variations {
    /// Of a system and the parameters that count.
    pub fn new(dynamics: &Dynamics, parameters: Vec<Parameter>) -> Self {
        let system = dynamics.system();
        let bodies = system.bodies().len();
        let inertia: Vec<Vec3> = system.bodies().iter().map(|body| body.inertia()).collect();
        let positive = |i: &Vec3, value: Vec3| if i.min() > 0.0 { value } else { Vec3::zeros() };
        let half = 6 * bodies - 3;
        let stride = half.next_multiple_of(DEPTH);
        Self {
            bodies,
            masses: system.masses(),
            matrix: vec![0.0; half * stride],
            stride,
            spin: vec![Vec3::zeros(); bodies],
            ratios: inertia
                .iter()
                .map(|i| positive(i, Vec3::new(i.z - i.y, i.x - i.z, i.y - i.x).component_div(i)))
                .collect(),
            inverse_inertia: inertia.iter().map(|i| positive(i, i.map(|x| 1.0 / x))).collect(),
            forcing: vec![0.0; half * parameters.len()],
            parameters,
        }
    }

    /// Half the numbers of a departure in relative coordinates.
    pub fn half(&self) -> usize {
        6 * self.bodies - 3
    }

    /// Columns: one for every number of the initial departure, and one for every parameter.
    pub fn width(&self) -> usize {
        2 * self.half() + self.parameters.len()
    }

    /// The matrix of departures at the start of the motion.
    pub fn start(&self) -> Vec<f64> {
        let (rows, width) = (2 * self.half(), self.width());
        let mut columns = vec![0.0; rows * width];
        (0..rows).for_each(|k| columns[k * width + k] = 1.0);
        columns
    }

    /// Row of the first number of a body's place in d, which the first body does not have.
    fn place(&self, body: usize) -> Option<usize> {
        (body > 0).then(|| 3 * (body - 1))
    }

    /// Row of the first number of a body's theta.
    fn turn(&self, body: usize) -> usize {
        3 * (self.bodies - 1) + 3 * body
    }

    /// Units of work of [`Self::look`] and [`Self::rates`].
    pub fn work(&self, dynamics: &Dynamics) -> u64 {
        GRADIENT * dynamics.work() * dynamics.parts() as u64 + (self.matrix.len() * self.width() / 64) as u64
    }

    /// Takes A, B and the derivatives by the parameters at a vector of the motion. Allocates nothing.
    pub fn look(&mut self, dynamics: &mut Dynamics, y: &[f64]) {
        dynamics.turn(y);
        let g = dynamics.system.gravitational_constant;
        self.matrix.fill(0.0);
        self.forcing.fill(0.0);
        for body in 0..self.bodies {
            self.spin[body] = vector(y, dynamics.layout.spin(body));
        }
        for (i, j, link) in &dynamics.links {
            let jacobian = link.jacobian(&dynamics.pose(y, *i, *j));
            self.add(&jacobian, [*i, *j], g);
        }
    }

    fn add(&mut self, jacobian: &Jacobian, [i, j]: [usize; 2], g: f64) {
        let masses = [self.masses[i], self.masses[j]];
        let torque = [&jacobian.torque_by_separation[0], &jacobian.torque_by_separation[1]];
        let force = [-torque[0].transpose(), -torque[1].transpose()];
        let of_force = [&jacobian.force_by_separation, &force[0], &force[1]];
        let other = jacobian.torque_first_by_second.transpose();
        let of_torques = [
            [torque[0], &jacobian.torque_by_rotation[0], &jacobian.torque_first_by_second],
            [torque[1], &other, &jacobian.torque_by_rotation[1]],
        ];
        // The force on the first body; the second feels the opposite. What the body at the origin of d feels, all others do less.
        for (body, factor) in [(i, g * masses[1]), (j, -g * masses[0])] {
            match self.place(body) {
                Some(row) => self.add_row(row, [i, j], of_force, &Vec3::repeat(factor)),
                None => (1..self.bodies).for_each(|other| {
                    self.add_row(3 * (other - 1), [i, j], of_force, &Vec3::repeat(-factor))
                }),
            }
        }
        let loads = &jacobian.loads;
        for (k, body) in [i, j].into_iter().enumerate() {
            let factor = self.inverse_inertia[body] * (g * masses[0] * masses[1]);
            self.add_row(self.turn(body), [i, j], of_torques[k], &factor);
        }
        for (parameter, forcing) in
            self.parameters.iter().zip(self.forcing.chunks_exact_mut(6 * self.bodies - 3))
        {
            let by = parameter.of_pair([i, j], g, masses);
            let bodies = self.bodies;
            let mut push = |row: usize, value: Vec3| (0..3).for_each(|c| forcing[row + c] += value[c]);
            for (body, acceleration) in [
                (i, loads.force_on_first * by.acceleration[0]),
                (j, loads.force_on_first * -by.acceleration[1]),
            ] {
                match body {
                    0 => (1..bodies).for_each(|other| push(3 * (other - 1), -acceleration)),
                    _ => push(3 * (body - 1), acceleration),
                }
            }
            for (k, (body, torque)) in
                [(i, loads.torque_first), (j, loads.torque_second)].into_iter().enumerate()
            {
                let row = 3 * (bodies - 1) + 3 * body;
                push(row, torque.component_mul(&self.inverse_inertia[body]) * by.torque[k]);
            }
        }
    }

    /// Adds to three rows of A: blocks by the separation of two bodies and the turns of both.
    fn add_row(&mut self, row: usize, [i, j]: [usize; 2], blocks: [&Mat3; 3], factor: &Vec3) {
        let mut put = |column: usize, block: &Mat3, sign: f64| {
            for r in 0..3 {
                for c in 0..3 {
                    self.matrix[(row + r) * self.stride + column + c] += sign * factor[r] * block[(r, c)];
                }
            }
        };
        let (n, place) = (self.bodies, |body: usize| (body > 0).then(|| 3 * (body - 1)));
        if let Some(column) = place(j) {
            put(column, blocks[0], 1.0);
        }
        if let Some(column) = place(i) {
            put(column, blocks[0], -1.0);
        }
        put(3 * (n - 1) + 3 * i, blocks[1], 1.0);
        put(3 * (n - 1) + 3 * j, blocks[2], 1.0);
    }

    /// The rates of change of a matrix of departures where [`Self::look`] was last. Allocates nothing.
    pub fn rates(&self, arch: pulp::Arch, columns: &[f64], rates: &mut [f64]) {
        let (half, width) = (self.half(), self.width());
        let (q, p) = columns.split_at(half * width);
        let (rate_q, rate_p) = rates.split_at_mut(half * width);
        rate_q.copy_from_slice(p);
        arch.dispatch(Product { matrix: &self.matrix, stride: self.stride, columns: q, width, out: rate_p });
        for body in 0..self.bodies {
            let (spin, ratio, row) = (&self.spin[body], &self.ratios[body], self.turn(body));
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let at = |c: usize| (row + c) * width..(row + c + 1) * width;
                // -(spin x theta) and -(I_k - I_j)/I_i (spin_k dspin_j + spin_j dspin_k).
                add(&mut rate_q[at(i)], -spin[j], &q[at(k)], spin[k], &q[at(j)]);
                add(&mut rate_p[at(i)], -ratio[i] * spin[k], &p[at(j)], -ratio[i] * spin[j], &p[at(k)]);
            }
        }
        let first = 2 * half;
        for (column, forcing) in self.forcing.chunks_exact(half).enumerate() {
            for (row, value) in forcing.iter().enumerate() {
                rate_p[row * width + first + column] += value;
            }
        }
    }

    /// The transition matrix (12 N, 12 N) of departures, from their matrix after an `elapsed` time, and the sensitivities (P, 12 N) to
    /// the parameters, given the states at both ends. Per body: position, velocity, rotation vector, spin.
    pub fn expand(&self, columns: &[f64], start: &State, now: &State) -> (Vec<f64>, Vec<f64>) {
        let (n, half, width) = (self.bodies, self.half(), self.width());
        let size = DEPARTURE * n;
        let elapsed = now.time - start.time;
        let total = sum(self.masses.iter().copied());
        let share: Vec<f64> = self.masses.iter().map(|m| m / total).collect();
        // From a combination of columns and the barycentre's departure and rate to the bodies' own.
        let spread = |combination: &[(usize, f64)],
                      barycentre: Vec3,
                      moving: Vec3,
                      out: &mut dyn FnMut(usize, f64)| {
            let number = |row: usize| {
                combination.iter().map(|(c, factor)| factor * columns[row * width + c]).sum::<f64>()
            };
            for (block, centre) in [(0, barycentre + moving * elapsed), (1, moving)] {
                for c in 0..3 {
                    let relative =
                        |body: usize| self.place(body).map_or(0.0, |row| number(block * half + row + c));
                    let first = centre[c] - (1..n).map(|body| share[body] * relative(body)).sum::<f64>();
                    for body in 0..n {
                        out(DEPARTURE * body + 3 * block + c, first + relative(body));
                        out(DEPARTURE * body + 6 + 3 * block + c, number(block * half + self.turn(body) + c));
                    }
                }
            }
        };
        let mut transition = vec![0.0; size * size];
        let mut combination = Vec::new();
        for body in 0..n {
            for kind in 0..4 {
                for c in 0..3 {
                    combination.clear();
                    let (mut centre, mut moving) = (Vec3::zeros(), Vec3::zeros());
                    let block = kind % 2;
                    match (kind < 2, self.place(body)) {
                        (false, _) => combination.push((block * half + self.turn(body) + c, 1.0)),
                        (true, Some(row)) => combination.push((block * half + row + c, 1.0)),
                        (true, None) => {
                            combination
                                .extend((1..n).map(|other| (block * half + 3 * (other - 1) + c, -1.0)));
                        }
                    }
                    if kind < 2 {
                        let part = if kind == 0 { &mut centre } else { &mut moving };
                        part[c] = share[body];
                    }
                    let column = DEPARTURE * body + 3 * kind + c;
                    spread(&combination, centre, moving, &mut |row, value| {
                        transition[row * size + column] = value;
                    });
                }
            }
        }
        let mut sensitivity = vec![0.0; size * self.parameters.len()];
        for (k, (parameter, out)) in
            self.parameters.iter().zip(sensitivity.chunks_exact_mut(size.max(1))).enumerate()
        {
            // The barycentre's own place changes with the masses.
            let by_share: Vec<f64> = (0..n).map(|body| parameter.of_mass(body) / total).collect();
            let change = by_share.iter().sum::<f64>();
            let moved = |of: &dyn Fn(usize) -> Vec3| {
                (0..n).map(|body| (by_share[body] - share[body] * change) * of(body)).sum::<Vec3>()
            };
            let (centre, moving) = (moved(&|b| start.position[b]), moved(&|b| start.velocity[b]));
            spread(&[(2 * half + k, 1.0)], centre, moving, &mut |row, value| out[row] = value);
            let (centre, moving) = (moved(&|b| now.position[b]), moved(&|b| now.velocity[b]));
            for body in 0..n {
                (0..3).for_each(|c| out[DEPARTURE * body + c] -= centre[c]);
                (0..3).for_each(|c| out[DEPARTURE * body + 3 + c] -= moving[c]);
            }
        }
        (transition, sensitivity)
    }
}

/// Adds two rows times factors to a row.
fn add(out: &mut [f64], a: f64, x: &[f64], b: f64, y: &[f64]) {
    for (out, (x, y)) in out.iter_mut().zip(x.iter().zip(y)) {
        *out += a * x + b * y;
    }
}

impl Dynamics {
    /// Makes ready, with the rules in force, for [`Variations::look`]. May allocate: call it between steps.
    pub fn prepare_variations(&mut self, time: f64, patience: &mut Patience) -> Result<()> {
        for (.., link) in &mut self.links {
            link.prepare_jacobian(patience).map_err(|error| error.at(time))?;
        }
        Ok(())
    }
}
