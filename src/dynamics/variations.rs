//! The equations of small departures from a motion, in relative coordinates.
//!
//! A departure has 12 numbers a body: position and velocity (inertial), a rotation vector theta in the body frame, R -> R exp(theta),
//! and spin. The centres are taken from the first body's, d_k = dx_k - dx_0, and their rates e_k likewise; with forces from outside
//! the barycentre's departure X and its rate V come after them, and without it moves uniformly. With q = (d, theta, X) and
//! p = (e, dspin, V),
//!
//!   dd/dt = e,   dtheta/dt = dspin - spin x theta,   dX/dt = V,   dp/dt = A q + B p,
//!
//! A and B from the derivatives of the loads, B also from Euler's equations. Many departures are one matrix, a column each; behind the
//! columns of the initial state there is one for every parameter, with the derivative of the rates by the parameter as a further term.

use super::products::DEPTH;
use super::{Dynamics, Parameter};
use crate::environment::{Environment, LoadSlopes};
use crate::error::{Error, Result};
use crate::gravity::ExtendedPull;
use crate::math::Vec3;
use crate::math::compensated::sum;
use crate::patience::Patience;

/// A matrix of departures of more bodies takes longer than a caller is to wait for an answer.
const MOST_BODIES: usize = 64;

/// Units of work of a pair's Jacobian for each of its nodes.
const GRADIENT: u64 = 2;

/// What departures from a motion obey at one of its moments.
#[derive(Debug, Clone)]
pub struct Variations {
    pub(super) bodies: usize,
    /// Whether the barycentre's departure is among the numbers.
    pub(super) free: bool,
    pub(super) masses: Vec<f64>,
    /// Masses over the total.
    pub(super) share: Vec<f64>,
    pub(super) parameters: Vec<Parameter>,
    pub(super) inertia: Vec<Vec3>,
    pub(super) slopes: LoadSlopes,
    /// Rows of A and, where a force depends on motions, of its part of B, with zeros behind.
    pub(super) by_place: Vec<f64>,
    pub(super) by_motion: Vec<f64>,
    pub(super) stride: usize,
    pub(super) spin: Vec<Vec3>,
    pub(super) torque: Vec<Vec3>,
    /// For every parameter the body whose moments change with it, and their derivatives.
    by_inertia: Vec<Option<(usize, Vec3)>>,
    /// Beside third bodies those whose semi-axes are parameters, with their pull.
    pulls: Vec<(usize, ExtendedPull)>,
    /// Columns of initial departures.
    pub(super) initial: usize,
    /// Derivatives of the bodies' accelerations and rates of spin by the parameters, one after the other.
    pub(super) forcing: Vec<[Vec3; 2]>,
}

impl Variations {
    /// Of a system and the parameters that count, for all departures from the start of a motion.
    pub fn new(dynamics: &Dynamics, parameters: Vec<Parameter>) -> Result<Self> {
        let all = Self::of_one(dynamics)?;
        let forcing = vec![[Vec3::zeros(); 2]; all.bodies * parameters.len()];
        let bodies = dynamics.system.bodies();
        let by_inertia = parameters.iter().map(|parameter| parameter.of_inertia(bodies)).collect();
        let of_axes =
            |body: usize| parameters.iter().any(|p| p.semi_axis().is_some_and(|(of, _)| of == body));
        let beside = dynamics.outside().has_third_body();
        let pulled = bodies.iter().enumerate().filter(|(body, _)| beside && of_axes(*body));
        let pulls = pulled
            .filter_map(|(body, of)| Some((body, ExtendedPull::of_ellipsoid(&of.parts()[0].shape)?)))
            .collect();
        Ok(Self { initial: 2 * all.half(), parameters, by_inertia, pulls, forcing, ..all })
    }

    /// For one departure alone.
    pub fn of_one(dynamics: &Dynamics) -> Result<Self> {
        let system = dynamics.system();
        let bodies = system.bodies().len();
        if bodies > MOST_BODIES {
            let expected = format!("{MOST_BODIES} bodies at most");
            return Err(Error::invalid("derivatives", format!("of {bodies} bodies"), expected));
        }
        let masses = system.masses();
        let total = sum(masses.iter().copied());
        let free = !system.forces().is_empty();
        let by_motion = system.forces().iter().any(|force| force.depends_on_velocity());
        let half = 6 * bodies - if free { 0 } else { 3 };
        let stride = half.next_multiple_of(DEPTH);
        Ok(Self {
            bodies,
            free,
            share: masses.iter().map(|m| m / total).collect(),
            masses,
            inertia: system.bodies().iter().map(|body| body.inertia()).collect(),
            slopes: LoadSlopes::new(bodies, by_motion),
            by_place: vec![0.0; half * stride],
            by_motion: vec![0.0; if by_motion { half * stride } else { 0 }],
            stride,
            spin: vec![Vec3::zeros(); bodies],
            torque: vec![Vec3::zeros(); bodies],
            initial: 1,
            by_inertia: Vec::new(),
            pulls: Vec::new(),
            forcing: Vec::new(),
            parameters: Vec::new(),
        })
    }

    /// Half the numbers of a departure in relative coordinates.
    pub fn half(&self) -> usize {
        6 * self.bodies - if self.free { 0 } else { 3 }
    }

    /// Columns: those of initial departures, and one for every parameter.
    pub fn width(&self) -> usize {
        self.initial + self.parameters.len()
    }

    /// The matrix of all departures at the start of the motion.
    pub fn start(&self) -> Vec<f64> {
        let (rows, width) = (2 * self.half(), self.width());
        let mut columns = vec![0.0; rows * width];
        (0..rows).for_each(|k| columns[k * width + k] = 1.0);
        columns
    }

    /// One over the natural size of every number of a departure, from those of each body's position, velocity and spin. Rotations have
    /// one, and are left out.
    pub fn inverse_sizes(&self, sizes: &[[f64; 3]], inverse: &mut [f64]) {
        let mut put = |row: usize, size: f64| inverse[row..row + 3].fill(1.0 / size);
        for (body, [length, speed, spin]) in sizes.iter().enumerate() {
            let rows = [self.place(body), self.barycentre().filter(|_| body == 0)];
            for row in rows.into_iter().flatten() {
                put(row, *length);
                put(self.half() + row, *speed);
            }
            put(self.half() + self.turn(body), *spin);
        }
    }

    /// Row of the first number of a body's place in d, which the first body does not have.
    pub(super) fn place(&self, body: usize) -> Option<usize> {
        (body > 0).then(|| 3 * (body - 1))
    }

    /// Row of the first number of a body's theta.
    pub(super) fn turn(&self, body: usize) -> usize {
        3 * (self.bodies - 1) + 3 * body
    }

    /// Row of the first number of the barycentre's departure.
    pub(super) fn barycentre(&self) -> Option<usize> {
        self.free.then(|| 6 * self.bodies - 3)
    }

    /// Units of work of [`Self::look`].
    pub fn work(&self, dynamics: &Dynamics) -> u64 {
        GRADIENT * dynamics.work() * dynamics.parts() as u64 + (self.by_place.len() / 64) as u64
    }

    /// Takes A, B and the derivatives by the parameters at a vector of the motion. Allocates nothing.
    pub fn look(&mut self, dynamics: &mut Dynamics, time: f64, y: &[f64]) -> Result<()> {
        self.take(dynamics, time, y, true)
    }

    /// The same, without the spins where they do not count.
    pub(super) fn take(
        &mut self,
        dynamics: &mut Dynamics,
        time: f64,
        y: &[f64],
        spinning: bool,
    ) -> Result<()> {
        dynamics.turn(y);
        let g = dynamics.system.gravitational_constant;
        self.slopes.clear();
        self.clear(dynamics.layout, y, spinning);
        for (i, j, link) in &dynamics.links {
            let (i, j) = (*i, *j);
            let jacobian = link.jacobian(&dynamics.pose(y, i, j));
            let masses = [self.masses[i], self.masses[j]];
            let strength = g * masses[0] * masses[1];
            self.slopes.add_pair(&jacobian, [i, j], strength);
            let loads = &jacobian.loads;
            self.torque[i] += strength * loads.torque_first;
            self.torque[j] += strength * loads.torque_second;
            let mut by_axes = None;
            for (parameter, forcing) in self.parameters.iter().zip(self.forcing.chunks_exact_mut(self.bodies))
            {
                if parameter.semi_axis().is_some_and(|(body, _)| body == i || body == j) {
                    let slopes = by_axes.get_or_insert_with(|| link.axis_slopes(&dynamics.pose(y, i, j)));
                    let Some(loads) = parameter.slopes([i, j], slopes) else { continue };
                    forcing[i][0] += loads.force_on_first * (g * masses[1]);
                    forcing[j][0] -= loads.force_on_first * (g * masses[0]);
                    forcing[i][1] += over(&(loads.torque_first * strength), &self.inertia[i]);
                    forcing[j][1] += over(&(loads.torque_second * strength), &self.inertia[j]);
                    continue;
                }
                let by = parameter.of_pair([i, j], g, masses);
                forcing[i][0] += loads.force_on_first * by.acceleration[0];
                forcing[j][0] -= loads.force_on_first * by.acceleration[1];
                forcing[i][1] += over(&(loads.torque_first * by.torque[0]), &self.inertia[i]);
                forcing[j][1] += over(&(loads.torque_second * by.torque[1]), &self.inertia[j]);
            }
        }
        if self.free {
            dynamics.slopes_outside(time, y, &mut self.slopes)?;
            self.force_outside(&dynamics.outside, g);
            self.force_by_axes(dynamics, time, y)?;
        }
        self.force_by_inertia();
        let (mut by_place, mut by_motion) =
            (std::mem::take(&mut self.by_place), std::mem::take(&mut self.by_motion));
        self.reduce(&self.slopes.by_place, &mut by_place);
        if !by_motion.is_empty() {
            self.reduce(&self.slopes.by_motion, &mut by_motion);
        }
        (self.by_place, self.by_motion) = (by_place, by_motion);
        Ok(())
    }

    /// What parameters do to the loads from outside, and these to the torques.
    fn force_outside(&mut self, outside: &Environment, g: f64) {
        for load in outside.loads() {
            let body = load.on;
            self.torque[body] += load.torque;
            let acceleration = load.force / self.masses[body];
            let turning = over(&load.torque, &self.inertia[body]);
            for (k, parameter) in self.parameters.iter().enumerate() {
                let factor = parameter.of_rates(load.of, body, outside, g, &self.masses);
                let forcing = &mut self.forcing[k * self.bodies + body];
                forcing[0] += acceleration * factor;
                forcing[1] += turning * factor;
            }
        }
    }

    /// What semi-axes do to the loads of third bodies.
    fn force_by_axes(&mut self, dynamics: &mut Dynamics, time: f64, y: &[f64]) -> Result<()> {
        for (body, pull) in &mut self.pulls {
            let by_axes = dynamics.by_axes_outside(time, y, *body, pull)?;
            for (parameter, forcing) in self.parameters.iter().zip(self.forcing.chunks_exact_mut(self.bodies))
            {
                let Some((_, axis)) = parameter.semi_axis().filter(|(of, _)| of == body) else { continue };
                let [force, torque] = by_axes[axis];
                forcing[*body][0] += force / self.masses[*body];
                forcing[*body][1] += over(&torque, &self.inertia[*body]);
            }
        }
        Ok(())
    }

    /// What a semi-axis does to a body's own moments in Euler's equations.
    pub(super) fn force_by_inertia(&mut self) {
        for (of, forcing) in self.by_inertia.iter().zip(self.forcing.chunks_exact_mut(self.bodies)) {
            let Some((body, slope)) = *of else { continue };
            let (inertia, spin) = (&self.inertia[body], &self.spin[body]);
            let rate = over(&(self.torque[body] - spin.cross(&inertia.component_mul(spin))), inertia);
            let turning = spin.cross(&slope.component_mul(spin)) + slope.component_mul(&rate);
            forcing[body][1] -= over(&turning, inertia);
        }
    }

    /// The derivative of a body's moments by a parameter.
    pub(super) fn by_inertia(&self, parameter: usize, body: usize) -> Vec3 {
        self.by_inertia[parameter].filter(|(of, _)| *of == body).map_or(Vec3::zeros(), |(_, slope)| slope)
    }

    /// From derivatives of loads to those of rates in relative coordinates.
    fn reduce(&self, loads: &[f64], out: &mut [f64]) {
        let (n, size) = (self.bodies, 6 * self.bodies);
        out.fill(0.0);
        let mut put = |row: usize, from: usize, factor: f64| {
            let source = &loads[from * size..(from + 1) * size];
            let line = &mut out[row * self.stride..(row + 1) * self.stride];
            let mut whole = [0.0; 3];
            for body in 0..n {
                let (centre, turn) = (&source[6 * body..6 * body + 3], &source[6 * body + 3..6 * body + 6]);
                let at = self.turn(body);
                for c in 0..3 {
                    line[at + c] += factor * turn[c];
                    whole[c] += factor * centre[c];
                }
                if let Some(at) = self.place(body) {
                    (0..3).for_each(|c| line[at + c] += factor * centre[c]);
                }
            }
            if let Some(at) = self.barycentre() {
                for c in 0..3 {
                    line[at + c] += whole[c];
                    (1..n).for_each(|body| line[3 * (body - 1) + c] -= self.share[body] * whole[c]);
                }
            }
        };
        for body in 0..n {
            let per_mass = 1.0 / self.masses[body];
            for c in 0..3 {
                match self.place(body) {
                    Some(row) => put(row + c, 6 * body + c, per_mass),
                    None => (1..n).for_each(|other| put(3 * (other - 1) + c, c, -per_mass)),
                }
                if let Some(row) = self.barycentre() {
                    put(row + c, 6 * body + c, self.share[body] * per_mass);
                }
                let inertia = self.inertia[body][c];
                if inertia > 0.0 {
                    put(self.turn(body) + c, 6 * body + 3 + c, 1.0 / inertia);
                }
            }
        }
    }

    /// The factors of dspin_j and dspin_k in the rate of dspin_i, (i, j, k) in turn: -(I_k - I_j)/I_i (spin_k dspin_j + spin_j dspin_k).
    pub(super) fn euler(&self, body: usize) -> [[f64; 2]; 3] {
        let (spin, inertia) = (&self.spin[body], &self.inertia[body]);
        [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let ratio = if inertia[i] > 0.0 { (inertia[k] - inertia[j]) / inertia[i] } else { 0.0 };
            [-ratio * spin[k], -ratio * spin[j]]
        })
    }

    /// What the parameters add to the rates of p: by row, column and value.
    pub(super) fn force(&self, mut add: impl FnMut(usize, usize, f64)) {
        for (k, forcing) in self.forcing.chunks_exact(self.bodies).enumerate() {
            let mut push = |row: usize, value: &Vec3, factor: f64| {
                (0..3).for_each(|c| add(row + c, self.initial + k, factor * value[c]));
            };
            for (body, [acceleration, turning]) in forcing.iter().enumerate() {
                match self.place(body) {
                    Some(row) => push(row, acceleration, 1.0),
                    None => (1..self.bodies).for_each(|other| push(3 * (other - 1), acceleration, -1.0)),
                }
                if let Some(row) = self.barycentre() {
                    push(row, acceleration, self.share[body]);
                }
                push(self.turn(body), turning, 1.0);
            }
        }
    }
}

/// A torque over moments of inertia; zero for a body without any.
fn over(torque: &Vec3, inertia: &Vec3) -> Vec3 {
    torque.zip_map(inertia, |torque, inertia| if inertia > 0.0 { torque / inertia } else { 0.0 })
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
