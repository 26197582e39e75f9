//! The equations of motion as two flows, each solved exactly.
//!
//! | | drift | kick |
//! |---|---|---|
//! | [`Parts::Kepler`] | Kepler motion in Jacobi's coordinates, free rotation | the rest of the forces, all torques |
//! | [`Parts::Free`] | straight motion, discrete free rotation | all forces, all torques |
//!
//! The first is for the splittings of Wisdom & Holman (1991), Astron. J. 102, 1528: in Jacobi's coordinates body i moves about
//! the barycentre of the bodies before it with mu = G (m_0 + ... + m_i). For two bodies this is their relative orbit. The
//! second makes the Lie group variational integrator of half a kick, a drift and half a kick.

use super::jacobi::Jacobi;
use super::layout::vector;
use super::rotor::{FARTHEST, Top, farthest_turn, variational_rotation};
use super::{AttitudeChart, Dynamics, Layout, Rejected};
use crate::environment::BOOK;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::math::compensated::two_sum;
use crate::orbit::kepler_change;
use crate::patience::Patience;

/// Units of work of turning a body by a rad, for [`Patience`].
const ROTATION: f64 = 200.0;

/// Which motion is the large part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parts {
    /// Kepler motion and free rotation.
    Kepler,
    /// Straight motion and the discrete free rotation.
    Free,
}

/// The two flows of a system, with their scratch.
#[derive(Debug, Clone)]
pub struct Splitting {
    parts: Parts,
    jacobi: Jacobi,
    gravitational_constant: f64,
    inertia: Vec<Vec3>,
    tops: Vec<Top>,
    position: Vec<Vec3>,
    velocity: Vec<Vec3>,
    acceleration: Vec<Vec3>,
    spin_rate: Vec<Vec3>,
    /// Whether the two above belong to the present vector.
    loaded: bool,
    /// Time and size of the step.
    time: f64,
    step: f64,
    /// What a drift or a kick adds to the numbers of the bodies.
    change: Vec<f64>,
    /// How much of the step the drifts have covered.
    covered: f64,
    /// Velocities and spins in the middle of a kick, for the books.
    middle: [Vec<Vec3>; 2],
}

impl Splitting {
    /// For a system whose attitudes are quaternions.
    pub fn new(dynamics: &Dynamics, parts: Parts) -> Result<Self> {
        if dynamics.layout().chart != AttitudeChart::Quaternion {
            return Err(Error::invalid(
                "attitude_chart",
                "the Tait-Bryan angles",
                "\"quaternion\": symplectic integrators turn bodies on the rotation group itself",
            ));
        }
        if let Some(force) = dynamics.system().forces().iter().find(|force| force.depends_on_velocity()) {
            return Err(Error::invalid(
                "integrator",
                format!("one of fixed steps, with the force {}, which depends on velocities", force.name()),
                "Verner98 or another Runge-Kutta pair: the kicks of a splitting change velocities at places alone",
            ));
        }
        let masses = dynamics.system().masses();
        let n = masses.len();
        let inertia: Vec<Vec3> = dynamics.system().bodies().iter().map(|body| body.inertia()).collect();
        let zeros = vec![Vec3::zeros(); n];
        Ok(Self {
            parts,
            jacobi: Jacobi::new(&masses),
            gravitational_constant: dynamics.system().gravitational_constant(),
            tops: inertia.iter().map(|moments| Top::new(*moments)).collect(),
            inertia,
            position: zeros.clone(),
            velocity: zeros.clone(),
            acceleration: zeros.clone(),
            spin_rate: zeros.clone(),
            loaded: false,
            time: 0.0,
            step: 0.0,
            change: vec![0.0; dynamics.layout().departure()],
            covered: 0.0,
            middle: [zeros.clone(), zeros],
        })
    }

    /// Which motion is the large part.
    pub fn parts(&self) -> Parts {
        self.parts
    }

    /// An angle that no body turns beyond, nor moves in its orbit, in a drift from a vector: about the fastest of them.
    pub fn farthest(&self, dynamics: &Dynamics, y: &[f64], size: f64) -> f64 {
        let (layout, bodies) = (dynamics.layout(), dynamics.system().bodies());
        let mut rate: f64 = 0.0;
        for body in 0..layout.bodies {
            rate = rate.max(vector(y, layout.spin(body)).norm());
            for other in 0..body {
                let r = vector(y, layout.position(body)) - vector(y, layout.position(other));
                let mu = self.gravitational_constant * (bodies[body].mass + bodies[other].mass);
                rate = rate.max((mu / r.norm().powi(3)).sqrt());
            }
        }
        (rate * size).abs()
    }

    /// Forgets the forces of the present vector.
    pub fn reset(&mut self) {
        self.loaded = false;
    }

    /// The accelerations and rates of spin of the present vector, where they are known: with the vector they decide how a run
    /// goes on.
    pub fn loads(&self) -> Option<Vec<[f64; 6]>> {
        let both = self.acceleration.iter().zip(&self.spin_rate);
        self.loaded.then(|| both.map(|(a, s)| [a.x, a.y, a.z, s.x, s.y, s.z]).collect())
    }

    /// The inverse of [`Self::loads`].
    pub fn recall(&mut self, loads: &[[f64; 6]]) {
        for (body, load) in loads.iter().enumerate().take(self.tops.len()) {
            self.acceleration[body] = Vec3::new(load[0], load[1], load[2]);
            self.spin_rate[body] = Vec3::new(load[3], load[4], load[5]);
        }
        self.loaded = loads.len() == self.tops.len();
    }

    /// Notes the step that comes. Forces from outside are computed anew, with what they put into the books.
    pub fn begin(&mut self, dynamics: &Dynamics, time: f64, step: f64) {
        (self.time, self.step, self.covered) = (time, step, 0.0);
        self.loaded &= dynamics.layout().forces == 0;
    }

    /// The large part.
    pub fn drift(
        &mut self,
        dynamics: &Dynamics,
        size: f64,
        high: &mut [f64],
        low: &mut [f64],
        patience: &mut Patience,
    ) -> Result<()> {
        self.loaded = false;
        self.covered += size;
        let layout = dynamics.layout();
        if layout.forces > 0 {
            let d = layout.departure();
            (0..3).for_each(|c| add(high, low, d + c, size * high[d + 3 + c]));
        }
        match self.parts {
            Parts::Free => self.straight(layout, size, high),
            Parts::Kepler => self.orbits(layout, size, high, low)?,
        }
        self.rotations(dynamics, size, high, patience)?;
        add_all(high, low, &self.change);
        Ok(())
    }

    /// The changes of positions and velocities without forces.
    fn straight(&mut self, layout: Layout, size: f64, high: &[f64]) {
        let (positions, velocities) = (layout.velocity(0), layout.attitude(0));
        self.change[positions..velocities].fill(0.0);
        for (change, velocity) in self.change.iter_mut().zip(&high[positions..velocities]) {
            *change = size * velocity;
        }
    }

    /// The changes of positions and velocities on Kepler's orbits in Jacobi's coordinates.
    fn orbits(&mut self, layout: Layout, size: f64, high: &[f64], low: &[f64]) -> Result<()> {
        let parts = |index: usize| (high[index], low[index]);
        self.jacobi.enter(&mut self.position, |body, c| parts(layout.position(body) + c));
        self.jacobi.enter(&mut self.velocity, |body, c| parts(layout.velocity(body) + c));
        for body in 1..layout.bodies {
            let mu = self.gravitational_constant * self.jacobi.within[body];
            let (moved, turned) = kepler_change(&self.position[body], &self.velocity[body], mu, size)
                .ok_or_else(|| {
                    self.failed("Kepler's equation has no solution in doubles; use a shorter step")
                })?;
            self.position[body] = moved;
            self.velocity[body] = turned;
        }
        self.jacobi.leave(&mut self.position);
        self.jacobi.leave(&mut self.velocity);
        for body in 0..layout.bodies {
            let (p, v) = (layout.position(body), layout.velocity(body));
            self.change[p..p + 3].copy_from_slice(self.position[body].as_slice());
            self.change[v..v + 3].copy_from_slice(self.velocity[body].as_slice());
        }
        Ok(())
    }

    /// The changes of attitudes and spins without torques.
    fn rotations(
        &mut self,
        dynamics: &Dynamics,
        size: f64,
        high: &[f64],
        patience: &mut Patience,
    ) -> Result<()> {
        let layout = dynamics.layout();
        for body in 0..layout.bodies {
            let (a, s) = (layout.attitude(body), layout.spin(body));
            let q = [high[a], high[a + 1], high[a + 2], high[a + 3]];
            let spin = Vec3::new(high[s], high[s + 1], high[s + 2]);
            let inertia = self.inertia[body];
            // Too large a number counts as the limit, and so does NaN.
            patience.spend(
                (ROTATION * (1.0 + (2.0 * spin.amax() * size).abs().min(FARTHEST))) as u64,
                self.time,
            )?;
            let turn = match self.parts {
                Parts::Kepler => self.tops[body].turn(q, spin, size),
                Parts::Free => variational_rotation(inertia, q, spin, size),
            };
            let (turned, change) = turn.ok_or_else(|| self.too_far(dynamics, body, spin))?;
            self.change[a..a + 4].copy_from_slice(&turned);
            self.change[s..s + 3].copy_from_slice(change.as_slice());
        }
        Ok(())
    }

    /// The small part. Gives the number of evaluations.
    pub fn kick(
        &mut self,
        dynamics: &mut Dynamics,
        size: f64,
        high: &mut [f64],
        low: &mut [f64],
        patience: &mut Patience,
    ) -> Result<u64> {
        let layout = dynamics.layout();
        let evaluations = u64::from(!self.loaded);
        if !self.loaded {
            self.load(dynamics, high, low, patience)?;
        }
        if layout.forces > 0 {
            self.enter(dynamics, size, high, low);
        }
        for body in 0..layout.bodies {
            let (v, s) = (layout.velocity(body), layout.spin(body));
            for c in 0..3 {
                self.change[v + c] = size * self.acceleration[body][c];
                self.change[s + c] = size * self.spin_rate[body][c];
            }
        }
        for block in [layout.velocity(0)..layout.attitude(0), layout.spin(0)..layout.departure()] {
            add_all(&mut high[block.clone()], &mut low[block.clone()], &self.change[block]);
        }
        Ok(evaluations)
    }

    /// The barycentre's kick, and what a kick of the present loads puts into the books: the power with the velocities of its middle
    /// is just what the kick adds to the energy.
    fn enter(&mut self, dynamics: &Dynamics, size: f64, high: &mut [f64], low: &mut [f64]) {
        let layout = dynamics.layout();
        let kick = dynamics.barycentre_acceleration();
        let (departing, scene) = (layout.departure() + 3, &dynamics.outside().scene);
        let [velocity, spin] = &mut self.middle;
        for body in 0..layout.bodies {
            let at = &scene.bodies[body];
            velocity[body] = at.velocity + 0.5 * size * (self.acceleration[body] + kick);
            spin[body] = at.spin + 0.5 * size * self.spin_rate[body];
        }
        for force in 0..layout.forces {
            let book = dynamics.outside().book(force, |body| (velocity[body], spin[body]));
            let at = layout.book(force);
            (0..BOOK).for_each(|k| add(high, low, at + k, size * book[k]));
        }
        (0..3).for_each(|c| add(high, low, departing + c, size * kick[c]));
    }

    fn load(
        &mut self,
        dynamics: &mut Dynamics,
        high: &[f64],
        low: &[f64],
        patience: &mut Patience,
    ) -> Result<()> {
        let layout = dynamics.layout();
        for part in 0..dynamics.parts() {
            patience.spend(dynamics.work(), self.time)?;
            let loaded = dynamics.load(part, self.time + self.covered, high);
            loaded.map_err(|rejected| self.refused(dynamics, rejected))?;
        }
        let (acceleration, torque) = dynamics.loads();
        self.acceleration.copy_from_slice(acceleration);
        for (rate, (torque, inertia)) in self.spin_rate.iter_mut().zip(torque.iter().zip(&self.inertia)) {
            *rate =
                Vec3::from([0, 1, 2].map(|c| if inertia[c] > 0.0 { torque[c] / inertia[c] } else { 0.0 }));
        }
        if self.parts == Parts::Kepler {
            let parts = |index: usize| (high[index], low[index]);
            self.jacobi.enter(&mut self.position, |body, c| parts(layout.position(body) + c));
            for body in 1..layout.bodies {
                let mu = self.gravitational_constant * self.jacobi.within[body];
                let r = self.position[body];
                let distance = r.norm();
                self.position[body] = r * (-mu / (distance * distance * distance));
            }
            self.jacobi.leave(&mut self.position);
            self.acceleration.iter_mut().zip(&self.position).for_each(|(a, k)| *a -= k);
        }
        if self.acceleration.iter().chain(&self.spin_rate).all(|v| v.iter().all(|x| x.is_finite())) {
            self.loaded = true;
            Ok(())
        } else {
            Err(self.refused(dynamics, Rejected::NotFinite))
        }
    }

    /// That the forces cannot be had within the step.
    fn refused(&self, dynamics: &Dynamics, rejected: Rejected) -> Error {
        let reason = match rejected {
            Rejected::TooClose { bodies, separation, valid_from } => {
                let [first, second] = bodies.map(|body| {
                    let body = &dynamics.system().bodies()[body];
                    if body.is_composite() { format!("a part of {}", body.name) } else { body.name.clone() }
                });
                format!(
                    "{first} and {second} come to a separation of {separation:.6e} in it, where the quadrature of their \
                     forces was chosen for {valid_from:.6e} and more"
                )
            }
            Rejected::Failed(error) => return *error,
            other => other.reason().to_owned(),
        };
        self.failed(&format!("{reason}; use a shorter step"))
    }

    fn failed(&self, detail: &str) -> Error {
        let what = format!("a step of size {:e} at time {}", self.step, self.time);
        Error::NotConverged { what, detail: detail.to_owned() }
    }

    /// The error that a body turns too far in this step, with the step in which it would not.
    fn too_far(&self, dynamics: &Dynamics, body: usize, spin: Vec3) -> Error {
        let name = &dynamics.system().bodies()[body].name;
        let (inertia, step) = (self.inertia[body], self.step.abs());
        let (angle, shorter, limit) = match self.parts {
            Parts::Kepler => {
                let angle = farthest_turn(inertia, spin, step);
                (angle, 0.99 * step * FARTHEST / angle, format!("expected {FARTHEST} rad at most"))
            }
            Parts::Free => {
                let follows =
                    |step: &f64| variational_rotation(inertia, [1.0, 0.0, 0.0, 0.0], spin, *step).is_some();
                let shorter =
                    (1..1000).map(|k| 0.99 * step * 0.5_f64.powi(k)).find(follows).unwrap_or_default();
                (spin.norm() * step, shorter, "the discrete rotation has no solution there".to_owned())
            }
        };
        self.failed(&format!(
            "{name} turns by {angle:.3e} rad in it; {limit}; use a step of at most {shorter:.3e}"
        ))
    }
}

/// Adds to numbers in two parts.
#[inline]
fn add_all(high: &mut [f64], low: &mut [f64], changes: &[f64]) {
    for ((high, low), change) in high.iter_mut().zip(low).zip(changes) {
        let (sum, error) = two_sum(*high, *change);
        (*high, *low) = two_sum(sum, error + *low);
    }
}

#[inline]
fn add(high: &mut [f64], low: &mut [f64], index: usize, increment: f64) {
    add_all(&mut high[index..=index], &mut low[index..=index], &[increment]);
}
