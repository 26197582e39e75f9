//! The equations of motion as two flows, each solved exactly.
//!
//! | | drift | kick |
//! |---|---|---|
//! | [`DriftKind::Kepler`] | Kepler motion in Jacobi's coordinates, free rotation | the rest of the forces,
//! all torques |
//! | [`DriftKind::Free`] | straight motion, discrete free rotation | all forces, all torques |
//!
//! The Kepler drift belongs to the splittings of Wisdom & Holman (1991), Astron. J. 102, 1528: in Jacobi's
//! coordinates body i moves about the barycentre of the bodies before it with mu = G (m_0 + ... + m_i). For
//! two bodies this is their relative orbit. The free drift, between two half kicks, makes the Lie group
//! variational integrator.

mod failures;

use super::Dynamics;
use super::jacobi::Jacobi;
use super::layout::{AttitudeChart, BodyBlocks, vector};
use super::rejected::Rejected;
use crate::dynamics::rotation::discrete_rotor::variational_rotation;
use crate::dynamics::rotation::free_rotors::{FreeRotors, MAX_ROTATION_ANGLE, RotorStates};
use crate::error::{Error, Result};
use crate::forces::WORK_AND_IMPULSE;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::math::compensated::{add, add_all, add_multiples};
use pulp::{Simd, WithSimd};

/// The units of work of rotating a body by one rad, for [`InterruptCheck`].
const ROTATION: f64 = 200.0;

/// The motion of the drift, the large part of the splitting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriftKind {
    /// Kepler motion and free rotation.
    Kepler,
    /// Straight motion and the discrete free rotation.
    Free,
}

/// The two flows of a system, with their buffers.
#[derive(Debug, Clone)]
pub struct Splitting {
    drift_kind: DriftKind,
    jacobi: Jacobi,
    inertia: Vec<Vec3>,
    rotors: FreeRotors,
    acceleration: Vec<[f64; 3]>,
    spin_rate: Vec<[f64; 3]>,
    /// Whether the accelerations and rates of spin belong to the present vector.
    has_loads: bool,
    /// The time and the size of the step.
    time: f64,
    step: f64,
    /// The changes of attitudes and spins by a drift.
    change: Vec<f64>,
    /// The time within the step that the drifts have covered.
    covered: f64,
    /// The units of work of rotating each body through the step, for [`InterruptCheck`].
    work: Vec<u64>,
    /// The velocities and spins in the middle of a kick, for the work of external forces.
    middle: [Vec<[f64; 3]>; 2],
}

impl Splitting {
    /// Prepares the flows of a system whose attitudes are quaternions.
    pub fn new(dynamics: &Dynamics, drift_kind: DriftKind) -> Result<Self> {
        if dynamics.layout().chart != AttitudeChart::Quaternion {
            return Err(Error::invalid(
                "attitude_chart",
                "the Tait-Bryan angles",
                "\"quaternion\": symplectic integrators rotate bodies on the rotation group itself",
            ));
        }
        if let Some(force) = dynamics.system().forces().iter().find(|force| force.depends_on_velocity()) {
            return Err(Error::invalid(
                "integrator",
                format!("one of fixed steps, with the force {}, which depends on velocities", force.name()),
                "Verner98 or another Runge-Kutta pair: the kicks of a splitting change velocities at \
                 fixed positions",
            ));
        }
        let masses = dynamics.system().masses();
        let n = masses.len();
        let inertia: Vec<Vec3> = dynamics.system().bodies().iter().map(|body| body.inertia()).collect();
        let zeros = vec![[0.0; 3]; n];
        Ok(Self {
            drift_kind,
            jacobi: Jacobi::new(&masses, dynamics.system().gravitational_constant()),
            rotors: FreeRotors::new(&inertia),
            inertia,
            acceleration: zeros.clone(),
            spin_rate: zeros.clone(),
            has_loads: false,
            time: 0.0,
            step: 0.0,
            change: vec![0.0; 7 * n],
            covered: 0.0,
            work: vec![0; n],
            middle: [zeros.clone(), zeros],
        })
    }

    /// Returns the motion of the drift.
    pub fn drift_kind(&self) -> DriftKind {
        self.drift_kind
    }

    /// Returns an approximate upper bound of the angle by which any body rotates, or moves in its orbit, in a
    /// drift from a vector.
    pub fn farthest(&self, dynamics: &Dynamics, y: &[f64], size: f64) -> f64 {
        let (layout, bodies) = (dynamics.layout(), dynamics.system().bodies());
        let mut rate: f64 = 0.0;
        for body in 0..layout.bodies {
            rate = rate.max(vector(y, layout.spin(body)).norm());
            for other in 0..body {
                let r = vector(y, layout.position(body)) - vector(y, layout.position(other));
                let mu =
                    dynamics.system().gravitational_constant() * (bodies[body].mass + bodies[other].mass);
                rate = rate.max((mu / r.norm().powi(3)).sqrt());
            }
        }
        (rate * size).abs()
    }

    /// Forgets the forces of the present vector.
    pub fn reset(&mut self) {
        self.has_loads = false;
    }

    /// Returns the accelerations and rates of spin of the present vector, where they are known: together with
    /// the vector they determine how a run continues.
    pub fn loads(&self) -> Option<Vec<[f64; 6]>> {
        let pairs = self.acceleration.iter().zip(&self.spin_rate);
        self.has_loads.then(|| pairs.map(|([a, b, c], [x, y, z])| [*a, *b, *c, *x, *y, *z]).collect())
    }

    /// Restores what [`Self::loads`] returned.
    pub fn set_loads(&mut self, loads: &[[f64; 6]]) {
        for (body, &[a, b, c, x, y, z]) in loads.iter().enumerate().take(self.inertia.len()) {
            (self.acceleration[body], self.spin_rate[body]) = ([a, b, c], [x, y, z]);
        }
        self.has_loads = loads.len() == self.inertia.len();
    }

    /// Prepares the next step. External forces are evaluated again.
    pub fn begin(&mut self, dynamics: &Dynamics, time: f64, y: &[f64], step: f64) {
        let layout = dynamics.layout();
        (self.time, self.step, self.covered) = (time, step, 0.0);
        self.jacobi.reset();
        self.has_loads &= layout.forces == 0;
        for (body, work) in self.work.iter_mut().enumerate() {
            let angle = (2.0 * vector(y, layout.spin(body)).amax() * step).abs();
            // Too large a number counts as the limit, and so does NaN.
            *work = (ROTATION * (1.0 + angle.min(MAX_ROTATION_ANGLE))) as u64;
        }
    }

    /// Advances by the flow of the larger part.
    pub fn drift(
        &mut self,
        dynamics: &Dynamics,
        size: f64,
        [high, low]: [&mut [f64]; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.has_loads = false;
        self.covered += size;
        let layout = dynamics.layout();
        if layout.forces > 0 {
            let d = layout.barycentre_offset();
            for c in d..d + 3 {
                let change = size * high[c + 3];
                add(&mut high[c], &mut low[c], change);
            }
        }
        let arch = dynamics.system().arch();
        arch.dispatch(DriftStep { splitting: self, dynamics, size, high, low, interrupt })
    }

    /// Moves the centres along straight lines or Kepler orbits.
    #[inline(always)]
    fn orbits(
        &mut self,
        dynamics: &Dynamics,
        size: f64,
        high: &mut BodyBlocks,
        low: &mut BodyBlocks,
    ) -> Result<()> {
        match self.drift_kind {
            DriftKind::Free => {
                for body in 0..high.position.len() {
                    add_multiples(
                        &mut high.position[body],
                        &mut low.position[body],
                        size,
                        &high.velocity[body],
                    );
                }
                Ok(())
            }
            DriftKind::Kepler => {
                self.jacobi.drift(size, high, low).map_err(|body| self.unsolved(dynamics, body))
            }
        }
    }

    /// Computes the changes of attitudes and spins without torques.
    #[inline(always)]
    fn rotations<S: Simd>(
        &mut self,
        simd: S,
        dynamics: &Dynamics,
        size: f64,
        high: &BodyBlocks,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let (attitude, spin, work, time) = (&*high.attitude, &*high.spin, &self.work, self.time);
        let (attitude_change, spin_change) = self.change.split_at_mut(4 * spin.len());
        let (attitude_change, spin_change) =
            (attitude_change.as_chunks_mut().0, spin_change.as_chunks_mut().0);
        let mut check = |body: usize| interrupt.charge(work[body], time);
        let too_far = match self.drift_kind {
            DriftKind::Kepler => self.rotors.rotate(
                simd,
                size,
                RotorStates { attitude, spin, attitude_change, spin_change },
                check,
            )?,
            DriftKind::Free => {
                for body in 0..spin.len() {
                    check(body)?;
                    let (inertia, old_spin) = (self.inertia[body], spin[body].into());
                    let Some((rotation, spin_increment)) =
                        variational_rotation(inertia, attitude[body], old_spin, size)
                    else {
                        return Err(self.too_far(dynamics, body, old_spin));
                    };
                    (attitude_change[body], spin_change[body]) = (rotation, spin_increment.into());
                }
                None
            }
        };
        too_far.map_or(Ok(()), |body| Err(self.too_far(dynamics, body, spin[body].into())))
    }

    /// Advances by the flow of the smaller part. Returns the number of evaluations.
    pub fn kick(
        &mut self,
        dynamics: &mut Dynamics,
        size: f64,
        [high, low]: [&mut [f64]; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<u64> {
        let evaluations = u64::from(!self.has_loads);
        if !self.has_loads {
            for part in 0..dynamics.parts() {
                interrupt.charge(dynamics.work(), self.time)?;
                let outcome = dynamics.load(part, self.time + self.covered, high);
                outcome.map_err(|rejected| self.refused(dynamics, rejected))?;
            }
        }
        let arch = dynamics.system().arch();
        arch.dispatch(KickStep { splitting: self, dynamics, size, high, low });
        if !self.has_loads {
            return Err(self.refused(dynamics, Rejected::NotFinite));
        }
        if dynamics.layout().forces > 0 {
            self.record_work_and_impulse(dynamics, size, high, low);
        }
        Ok(evaluations)
    }

    /// Kicks the barycentre, and adds work and impulse of the kick that the bodies have received from the
    /// present loads. The power with the velocities in the middle of the kick is exactly what the kick adds
    /// to the energy.
    fn record_work_and_impulse(&mut self, dynamics: &Dynamics, size: f64, high: &mut [f64], low: &mut [f64]) {
        let layout = dynamics.layout();
        let kick = dynamics.barycentre_acceleration();
        let offset_rate = layout.barycentre_offset() + 3;
        let (bodies, work_and_impulse) = high.split_at_mut(layout.work_and_impulse_index(0));
        let mut snapshot = dynamics.snapshot(self.time + self.covered, bodies);
        let [velocity, spin] = &mut self.middle;
        for body in 0..layout.bodies {
            for c in 0..3 {
                velocity[body][c] = snapshot.velocity[body][c] - 0.5 * size * self.acceleration[body][c];
                spin[body][c] = snapshot.spin[body][c] - 0.5 * size * self.spin_rate[body][c];
            }
        }
        (snapshot.velocity, snapshot.spin) = (velocity, spin);
        snapshot.barycentre_offset[1] += 0.5 * size * kick;
        let lows = low[layout.work_and_impulse_index(0)..].as_chunks_mut::<WORK_AND_IMPULSE>().0;
        for (force, (high, low)) in
            work_and_impulse.as_chunks_mut::<WORK_AND_IMPULSE>().0.iter_mut().zip(lows).enumerate()
        {
            add_multiples(
                high,
                low,
                size,
                &dynamics.external_forces().work_and_impulse_rates(snapshot, force),
            );
        }
        (0..3).for_each(|c| add(&mut high[offset_rate + c], &mut low[offset_rate + c], size * kick[c]));
    }

    /// Stores the loads that have been computed, minus those of the Kepler motion, and kicks by them.
    #[inline(always)]
    fn store_loads(&mut self, dynamics: &Dynamics, size: f64, high: &mut BodyBlocks, low: &mut BodyBlocks) {
        let n = high.spin.len();
        let (acceleration, torque) = dynamics.loads();
        let (acceleration, torque, inertia) = (&acceleration[..n], &torque[..n], &self.inertia[..n]);
        let (acceleration_change, rate) = (&mut self.acceleration[..n], &mut self.spin_rate[..n]);
        let mut sum = 0.0;
        let mut centre = Vec3::zeros();
        for body in (0..n).rev() {
            let kepler = match self.drift_kind {
                DriftKind::Kepler => self.jacobi.acceleration(body, &mut centre),
                DriftKind::Free => Vec3::zeros(),
            };
            let (inertia, torque) = (&inertia[body], &torque[body]);
            for c in 0..3 {
                acceleration_change[body][c] = acceleration[body][c] - kepler[c];
                rate[body][c] = if inertia[c] > 0.0 { torque[c] / inertia[c] } else { 0.0 };
                sum += 0.0 * (acceleration_change[body][c] + rate[body][c]);
            }
            add_multiples(
                &mut high.velocity[body],
                &mut low.velocity[body],
                size,
                &acceleration_change[body],
            );
            add_multiples(&mut high.spin[body], &mut low.spin[body], size, &rate[body]);
        }
        // The sum of these products is NaN unless all numbers are finite.
        self.has_loads = sum == 0.0;
    }
}

/// A drift, compiled for the instructions of a path.
struct DriftStep<'a, 'b> {
    splitting: &'a mut Splitting,
    dynamics: &'a Dynamics,
    size: f64,
    high: &'a mut [f64],
    low: &'a mut [f64],
    interrupt: &'a mut InterruptCheck<'b>,
}

impl WithSimd for DriftStep<'_, '_> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<()> {
        let Self { splitting, dynamics, size, high, low, interrupt } = self;
        let layout = dynamics.layout();
        let n = layout.bodies;
        // The rotations are added last: reading them as a whole waits until all their parts are in memory.
        splitting.rotations(simd, dynamics, size, &BodyBlocks::new(n, high), interrupt)?;
        splitting.orbits(dynamics, size, &mut BodyBlocks::new(n, high), &mut BodyBlocks::new(n, low))?;
        let attitudes = layout.attitude(0)..layout.barycentre_offset();
        add_all(simd, &mut high[attitudes.clone()], &mut low[attitudes], 1.0, &splitting.change);
        Ok(())
    }
}

/// A kick by the present loads, compiled for the instructions of a path.
struct KickStep<'a> {
    splitting: &'a mut Splitting,
    dynamics: &'a Dynamics,
    size: f64,
    high: &'a mut [f64],
    low: &'a mut [f64],
}

impl WithSimd for KickStep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { splitting, dynamics, size, high, low } = self;
        let n = dynamics.layout().bodies;
        let (high, low) = (&mut BodyBlocks::new(n, high), &mut BodyBlocks::new(n, low));
        if !splitting.has_loads {
            return splitting.store_loads(dynamics, size, high, low);
        }
        for body in 0..n {
            add_multiples(
                &mut high.velocity[body],
                &mut low.velocity[body],
                size,
                &splitting.acceleration[body],
            );
            add_multiples(&mut high.spin[body], &mut low.spin[body], size, &splitting.spin_rate[body]);
        }
    }
}
