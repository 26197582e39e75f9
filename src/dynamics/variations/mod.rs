//! The variational equations: the linear equations of small changes of a motion, in relative coordinates.
//!
//! A tangent vector has 12 numbers for each body: position and velocity (inertial), a rotation vector theta
//! in the body frame, R -> R exp(theta), and spin. The centres are relative to the first body's, d_k = dx_k -
//! dx_0, and so are their rates e_k. With external forces the change X of the barycentre offset and its rate
//! V follow; without them the barycentre moves uniformly. With q = (d, theta, X) and p = (e, dspin, V),
//!
//!   dd/dt = e,   dtheta/dt = dspin - spin x theta,   dX/dt = V,   dp/dt = A q + B p,
//!
//! where A and B follow from the derivatives of the loads, and B also from Euler's equations. Many tangent
//! vectors are the columns of one matrix. After the columns for the initial state there is one for every
//! parameter, with the derivative of the rates with respect to the parameter as an additional term.

pub(super) mod collocation;
pub(super) mod jacobian;
pub(super) mod nominal;
mod products;
mod saltation;
mod splitting;
mod sweeps;
pub(super) mod tangent;

use super::equations::parameter::PairFactors;
use super::{Dynamics, Parameter};
use crate::error::{Error, Result};
use crate::forces::{Load, LoadJacobian};
use crate::gravity::{BodyChange, ExtendedAttraction, HarmonicField};
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::math::compensated::sum;
use crate::math::harmonics::count;
use crate::mutual::Interaction;
use crate::shape::PartDerivative;
use products::DEPTH;

/// The largest number of bodies; the matrix of tangent vectors of more bodies would keep a caller waiting too
/// long.
const MOST_BODIES: usize = 64;

/// The units of work of a pair's Jacobian for each of its nodes.
const GRADIENT: u64 = 2;

/// The coefficients of the variational equations at one time of a motion.
#[derive(Debug, Clone)]
pub struct Variations {
    bodies: usize,
    /// Whether the barycentre offset is among the numbers of a tangent vector.
    free: bool,
    masses: Vec<f64>,
    /// The masses relative to the total mass.
    share: Vec<f64>,
    parameters: Vec<Parameter>,
    inertia: Vec<Vec3>,
    jacobian: LoadJacobian,
    /// The rows of A and, where a force depends on velocities or spins, of the force's contribution to B,
    /// padded with zeros.
    by_pose: Vec<f64>,
    by_rate: Vec<f64>,
    stride: usize,
    spin: Vec<Vec3>,
    torque: Vec<Vec3>,
    /// For every parameter the body whose moments of inertia change with it, and their derivatives.
    by_inertia: Vec<Option<(usize, Vec3)>>,
    /// For every parameter the composite that changes with it, and its derivatives.
    by_part: Vec<Option<(usize, PartDerivative)>>,
    /// With third bodies, the bodies whose semi-axes are parameters, with the excess of their attraction.
    attractions: Vec<(usize, ExtendedAttraction)>,
    /// With third bodies, the parameters with which a body's own field changes.
    changes: Vec<(usize, usize, BodyChange)>,
    /// The number of columns for the initial state.
    initial: usize,
    /// Derivatives of the bodies' accelerations and rates of spin with respect to the parameters, one
    /// parameter after the other.
    forcing: Vec<[Vec3; 2]>,
}

impl Variations {
    /// Prepares the full matrix of tangent vectors from the start of a motion, with these parameters.
    pub fn new(dynamics: &Dynamics, parameters: Vec<Parameter>) -> Result<Self> {
        let all = Self::single(dynamics)?;
        parameters.iter().try_for_each(|parameter| parameter.check(&dynamics.system))?;
        let forcing = vec![[Vec3::zeros(); 2]; all.bodies * parameters.len()];
        let bodies = dynamics.system.bodies();
        let by_inertia = parameters.iter().map(|parameter| parameter.inertia_derivatives(bodies)).collect();
        let has_axis_parameter =
            |body: usize| parameters.iter().any(|p| p.semi_axis().is_some_and(|(of, _)| of == body));
        let has_third_body = dynamics.external_forces().has_third_body();
        let attracted =
            bodies.iter().enumerate().filter(|(body, _)| has_third_body && has_axis_parameter(*body));
        let attractions = attracted
            .filter_map(|(body, of)| Some((body, ExtendedAttraction::ellipsoidal(&of.parts()[0].shape)?)))
            .collect();
        let by_part = parameters.iter().map(|parameter| parameter.part_derivative(bodies));
        let by_part = by_part.collect::<Result<Vec<_>>>()?;
        let body_change = |(k, parameter): (usize, &Parameter)| match (parameter, &by_part[k]) {
            (Parameter::Scale(body), _) => Some((k, *body, BodyChange::Scale)),
            (_, Some((body, derivative))) => Some((k, *body, BodyChange::Part(derivative.clone()))),
            _ => parameter.moment_derivative(bodies).map(|(body, index, factor)| {
                let mut moments = vec![0.0; count(index.isqrt())];
                moments[index] = factor;
                let radius = bodies[body].circumradius();
                (k, body, BodyChange::Moment(HarmonicField::new(&moments, radius)))
            }),
        };
        let changes =
            parameters.iter().enumerate().filter(|_| has_third_body).filter_map(body_change).collect();
        Ok(Self {
            initial: 2 * all.half(),
            parameters,
            by_inertia,
            by_part,
            attractions,
            changes,
            forcing,
            ..all
        })
    }

    /// Prepares a single tangent vector.
    pub fn single(dynamics: &Dynamics) -> Result<Self> {
        let system = dynamics.system();
        let bodies = system.bodies().len();
        if bodies > MOST_BODIES {
            let expected = format!("{MOST_BODIES} bodies at most");
            return Err(Error::invalid("derivatives", format!("of {bodies} bodies"), expected));
        }
        let masses = system.masses();
        let total = sum(masses.iter().copied());
        let free = !system.forces().is_empty();
        let by_rate = system.forces().iter().any(|force| force.depends_on_velocity());
        let half = 6 * bodies - if free { 0 } else { 3 };
        let stride = half.next_multiple_of(DEPTH);
        Ok(Self {
            bodies,
            free,
            share: masses.iter().map(|m| m / total).collect(),
            masses,
            inertia: system.bodies().iter().map(|body| body.inertia()).collect(),
            jacobian: LoadJacobian::new(bodies, by_rate),
            by_pose: vec![0.0; half * stride],
            by_rate: vec![0.0; if by_rate { half * stride } else { 0 }],
            stride,
            spin: vec![Vec3::zeros(); bodies],
            torque: vec![Vec3::zeros(); bodies],
            initial: 1,
            by_inertia: Vec::new(),
            by_part: Vec::new(),
            attractions: Vec::new(),
            changes: Vec::new(),
            forcing: Vec::new(),
            parameters: Vec::new(),
        })
    }

    /// Returns the derivatives of the rate of change of a body's spin with respect to the parameters, from the
    /// last evaluation.
    pub fn spin_rates(&self, body: usize) -> impl Iterator<Item = &Vec3> {
        self.forcing.iter().skip(body).step_by(self.bodies).map(|[_, spin_rate]| spin_rate)
    }

    /// Returns half of the numbers of a tangent vector in relative coordinates.
    pub fn half(&self) -> usize {
        6 * self.bodies - if self.free { 0 } else { 3 }
    }

    /// Returns the number of columns: those for the initial state, and one for every parameter.
    pub fn width(&self) -> usize {
        self.initial + self.parameters.len()
    }

    /// Returns the matrix of all tangent vectors at the start of the motion.
    pub fn start(&self) -> Vec<f64> {
        let (rows, width) = (2 * self.half(), self.width());
        let mut columns = vec![0.0; rows * width];
        (0..rows).for_each(|k| columns[k * width + k] = 1.0);
        columns
    }

    /// Writes the inverse natural size of every number of a tangent vector, from the natural sizes of each
    /// body's position, velocity and spin. The size of rotations is one, and is not written.
    pub fn inverse_sizes(&self, sizes: &[[f64; 3]], inverse: &mut [f64]) {
        let mut put = |row: usize, size: f64| inverse[row..row + 3].fill(1.0 / size);
        for (body, [length, speed, spin]) in sizes.iter().enumerate() {
            let rows = [self.position_row(body), self.barycentre().filter(|_| body == 0)];
            for row in rows.into_iter().flatten() {
                put(row, *length);
                put(self.half() + row, *speed);
            }
            put(self.half() + self.rotation_row(body), *spin);
        }
    }

    /// Returns the row of the first number of a body's position in d; the first body has none.
    fn position_row(&self, body: usize) -> Option<usize> {
        (body > 0).then(|| 3 * (body - 1))
    }

    /// Returns the row of the first number of a body's theta.
    fn rotation_row(&self, body: usize) -> usize {
        3 * (self.bodies - 1) + 3 * body
    }

    /// Returns the row of the first number of the barycentre offset.
    fn barycentre(&self) -> Option<usize> {
        self.free.then(|| 6 * self.bodies - 3)
    }

    /// Returns the units of work of [`Self::evaluate`].
    pub fn work(&self, dynamics: &Dynamics) -> u64 {
        GRADIENT * dynamics.work() * dynamics.parts() as u64 + (self.by_pose.len() / 64) as u64
    }

    /// Evaluates A, B and the derivatives with respect to the parameters at a vector of the motion. Allocates
    /// nothing.
    pub fn evaluate(
        &mut self,
        dynamics: &mut Dynamics,
        time: f64,
        y: &[f64],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.evaluate_coefficients(dynamics, time, y, true, interrupt)
    }

    /// Evaluates the coefficients, without the spins where they are not needed.
    fn evaluate_coefficients(
        &mut self,
        dynamics: &mut Dynamics,
        time: f64,
        y: &[f64],
        with_spins: bool,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        dynamics.update_rotations(y);
        let g = dynamics.system.gravitational_constant();
        self.jacobian.clear();
        self.clear(dynamics.layout, y, with_spins);
        for (i, j, link) in &dynamics.links {
            let (i, j) = (*i, *j);
            let pose = dynamics.pose(y, i, j);
            let parts = link.jacobian_of_parts(&pose, interrupt).map_err(|error| error.at(time))?;
            let jacobian = link.about_centres(&pose, &parts);
            let masses = [self.masses[i], self.masses[j]];
            let strength = g * masses[0] * masses[1];
            self.jacobian.add_pair(&jacobian, [i, j], strength);
            let loads = &jacobian.loads;
            self.torque[i] += strength * loads.torque_first;
            self.torque[j] += strength * loads.torque_second;
            let unit_factors =
                PairFactors { acceleration: [g * masses[1], g * masses[0]], torque: [strength; 2] };
            let inertia = &self.inertia;
            let add = |forcing: &mut [[Vec3; 2]], by: &Interaction, of: &PairFactors| {
                forcing[i][0] += by.force_on_first * of.acceleration[0];
                forcing[j][0] -= by.force_on_first * of.acceleration[1];
                forcing[i][1] += per_inertia(&(by.torque_first * of.torque[0]), &inertia[i]);
                forcing[j][1] += per_inertia(&(by.torque_second * of.torque[1]), &inertia[j]);
            };
            let mut by_lengths = None;
            let all = self.parameters.iter().zip(&self.by_part);
            for ((parameter, by_part), forcing) in all.zip(self.forcing.chunks_exact_mut(self.bodies)) {
                if parameter.shape_body().is_some_and(|body| body == i || body == j) {
                    let derivatives = match by_lengths {
                        Some(derivatives) => derivatives,
                        None => link.shape_derivatives(&pose, interrupt).map_err(|error| error.at(time))?,
                    };
                    by_lengths = Some(derivatives);
                    let Some(loads) = parameter.shape_derivative([i, j], &derivatives) else { continue };
                    add(forcing, &loads, &unit_factors);
                } else if let Some((body, derivative)) = by_part {
                    let Some(which) = [i, j].iter().position(|other| other == body) else { continue };
                    add(forcing, &link.by_part(&pose, &parts, which, derivative), &unit_factors);
                    // This is the effect of the body's own mass.
                    let sign = if which == 0 { 1.0 } else { -1.0 };
                    let attraction = sign * g * masses[1 - which] * derivative.mass / masses[which];
                    forcing[*body][0] -= loads.force_on_first * attraction;
                } else if let Some((body, index, factor)) =
                    parameter.moment_derivative(dynamics.system.bodies())
                {
                    let Some(which) = [i, j].iter().position(|other| *other == body) else { continue };
                    add(forcing, &link.by_moment(&pose, which, index).times(factor), &unit_factors);
                } else {
                    add(forcing, loads, &parameter.pair_factors([i, j], g, masses));
                }
            }
        }
        if self.free {
            dynamics.add_external_jacobian(time, y, &mut self.jacobian)?;
            self.external_forcing(dynamics, time, y)?;
            self.force_by_axes(dynamics, time, y)?;
        }
        self.force_by_inertia();
        let (mut by_pose, mut by_rate) =
            (std::mem::take(&mut self.by_pose), std::mem::take(&mut self.by_rate));
        self.reduce(&self.jacobian.by_pose, &mut by_pose);
        if !by_rate.is_empty() {
            self.reduce(&self.jacobian.by_rate, &mut by_rate);
        }
        (self.by_pose, self.by_rate) = (by_pose, by_rate);
        Ok(())
    }

    /// Adds the derivatives with respect to the parameters of the external forces and torques.
    fn external_forcing(&mut self, dynamics: &mut Dynamics, time: f64, y: &[f64]) -> Result<()> {
        let (g, external_forces) = (dynamics.system.gravitational_constant(), &dynamics.external_forces);
        for load in external_forces.loads() {
            let body = load.on;
            self.torque[body] += load.torque;
            let acceleration = load.force / self.masses[body];
            let angular_acceleration = per_inertia(&load.torque, &self.inertia[body]);
            for (k, parameter) in self.parameters.iter().enumerate() {
                let factors = parameter.rate_factors(load.of, body, external_forces, g, &self.masses);
                let forcing = &mut self.forcing[k * self.bodies + body];
                forcing[0] += acceleration * factors[0];
                forcing[1] += angular_acceleration * factors[1];
            }
        }
        let Self { parameters, forcing, masses, inertia, bodies, changes, .. } = self;
        for (parameter, forcing) in parameters.iter().zip(forcing.chunks_exact_mut(*bodies)) {
            let mut add = |load: &Load, factor: f64| {
                forcing[load.on][0] += load.force * (factor / masses[load.on]);
                forcing[load.on][1] += per_inertia(&(load.torque * factor), &inertia[load.on]);
            };
            dynamics.external_loads_by_parameter(time, y, *parameter, masses, &mut add)?;
        }
        for (k, body, change) in changes {
            let [force, torque] = dynamics.external_loads_by_change(time, y, *body, change)?;
            forcing[*k * *bodies + *body][0] += force / masses[*body];
            forcing[*k * *bodies + *body][1] += per_inertia(&torque, &inertia[*body]);
        }
        Ok(())
    }

    /// Adds the derivatives with respect to semi-axes of the loads of third bodies.
    fn force_by_axes(&mut self, dynamics: &mut Dynamics, time: f64, y: &[f64]) -> Result<()> {
        for (body, attraction) in &mut self.attractions {
            let semi_axis_derivatives =
                dynamics.external_semi_axis_derivatives(time, y, *body, attraction)?;
            for (parameter, forcing) in self.parameters.iter().zip(self.forcing.chunks_exact_mut(self.bodies))
            {
                let Some((_, axis)) = parameter.semi_axis().filter(|(of, _)| of == body) else { continue };
                let [force, torque] = semi_axis_derivatives[axis];
                forcing[*body][0] += force / self.masses[*body];
                forcing[*body][1] += per_inertia(&torque, &self.inertia[*body]);
            }
        }
        Ok(())
    }

    /// Adds the derivatives with respect to semi-axes of the moments of inertia in Euler's equations.
    fn force_by_inertia(&mut self) {
        for (of, forcing) in self.by_inertia.iter().zip(self.forcing.chunks_exact_mut(self.bodies)) {
            let Some((body, slope)) = *of else { continue };
            let (inertia, spin) = (&self.inertia[body], &self.spin[body]);
            let rate = per_inertia(&(self.torque[body] - spin.cross(&inertia.component_mul(spin))), inertia);
            let torque_change = spin.cross(&slope.component_mul(spin)) + slope.component_mul(&rate);
            forcing[body][1] -= per_inertia(&torque_change, inertia);
        }
    }

    /// Returns the derivative of a body's moments of inertia with respect to a parameter.
    fn by_inertia(&self, parameter: usize, body: usize) -> Vec3 {
        self.by_inertia[parameter].filter(|(of, _)| *of == body).map_or(Vec3::zeros(), |(_, slope)| slope)
    }

    /// Converts derivatives of loads to those of rates in relative coordinates.
    fn reduce(&self, loads: &[f64], out: &mut [f64]) {
        let (n, size) = (self.bodies, 6 * self.bodies);
        out.fill(0.0);
        let mut put = |row: usize, from: usize, factor: f64| {
            let source = &loads[from * size..(from + 1) * size];
            let line = &mut out[row * self.stride..(row + 1) * self.stride];
            let mut total = [0.0; 3];
            for body in 0..n {
                let (by_position, by_rotation) =
                    (&source[6 * body..6 * body + 3], &source[6 * body + 3..6 * body + 6]);
                let at = self.rotation_row(body);
                for c in 0..3 {
                    line[at + c] += factor * by_rotation[c];
                    total[c] += factor * by_position[c];
                }
                if let Some(at) = self.position_row(body) {
                    (0..3).for_each(|c| line[at + c] += factor * by_position[c]);
                }
            }
            if let Some(at) = self.barycentre() {
                for c in 0..3 {
                    line[at + c] += total[c];
                    (1..n).for_each(|body| line[3 * (body - 1) + c] -= self.share[body] * total[c]);
                }
            }
        };
        for body in 0..n {
            let per_mass = 1.0 / self.masses[body];
            for c in 0..3 {
                match self.position_row(body) {
                    Some(row) => put(row + c, 6 * body + c, per_mass),
                    None => (1..n).for_each(|other| put(3 * (other - 1) + c, c, -per_mass)),
                }
                if let Some(row) = self.barycentre() {
                    put(row + c, 6 * body + c, self.share[body] * per_mass);
                }
                let inertia = self.inertia[body][c];
                if inertia > 0.0 {
                    put(self.rotation_row(body) + c, 6 * body + 3 + c, 1.0 / inertia);
                }
            }
        }
    }

    /// Returns the factors of dspin_j and dspin_k in the rate of dspin_i, with (i, j, k) in cyclic order:
    /// -(I_k - I_j)/I_i (spin_k dspin_j + spin_j dspin_k).
    fn euler(&self, body: usize) -> [[f64; 2]; 3] {
        let (spin, inertia) = (&self.spin[body], &self.inertia[body]);
        [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let ratio = if inertia[i] > 0.0 { (inertia[k] - inertia[j]) / inertia[i] } else { 0.0 };
            [-ratio * spin[k], -ratio * spin[j]]
        })
    }

    /// Passes the contributions of the parameters to the rates of p to `add`, by row, column and value.
    fn force(&self, mut add: impl FnMut(usize, usize, f64)) {
        for (k, forcing) in self.forcing.chunks_exact(self.bodies).enumerate() {
            let mut put = |row: usize, value: &Vec3, factor: f64| {
                (0..3).for_each(|c| add(row + c, self.initial + k, factor * value[c]));
            };
            for (body, [acceleration, angular_acceleration]) in forcing.iter().enumerate() {
                match self.position_row(body) {
                    Some(row) => put(row, acceleration, 1.0),
                    None => (1..self.bodies).for_each(|other| put(3 * (other - 1), acceleration, -1.0)),
                }
                if let Some(row) = self.barycentre() {
                    put(row, acceleration, self.share[body]);
                }
                put(self.rotation_row(body), angular_acceleration, 1.0);
            }
        }
    }
}

/// Returns a torque divided by the moments of inertia; zero for a body without inertia.
fn per_inertia(torque: &Vec3, inertia: &Vec3) -> Vec3 {
    torque.zip_map(inertia, |torque, inertia| if inertia > 0.0 { torque / inertia } else { 0.0 })
}

impl Dynamics {
    /// Prepares [`Variations::evaluate`] with the rules in use, for motions that begin at this vector. It may
    /// allocate and is called between steps only.
    pub fn prepare_variations(
        &mut self,
        variations: &Variations,
        time: f64,
        y: &[f64],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.update_rotations(y);
        for index in 0..self.links.len() {
            let (i, j) = (self.links[index].0, self.links[index].1);
            let pose = self.pose(y, i, j);
            let shaped = variations.parameters.iter().filter_map(|parameter| parameter.shape_body());
            let lengths = shaped.into_iter().any(|body| body == i || body == j);
            let link = &mut self.links[index].2;
            link.prepare_jacobian(&pose, lengths, interrupt).map_err(|error| error.at(time))?;
        }
        Ok(())
    }
}
