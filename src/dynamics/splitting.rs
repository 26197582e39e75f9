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

mod failures;

use super::discrete_rotor::variational_rotation;
use super::jacobi::Jacobi;
use super::layout::{Blocks, vector};
use super::tops::{Bodies, FARTHEST, Tops};
use super::{AttitudeChart, Dynamics, Rejected};
use crate::environment::BOOK;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::math::compensated::{add, add_all, add_each};
use crate::patience::Patience;
use pulp::{Simd, WithSimd};

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
    inertia: Vec<Vec3>,
    tops: Tops,
    acceleration: Vec<[f64; 3]>,
    spin_rate: Vec<[f64; 3]>,
    /// Whether the two above belong to the present vector.
    loaded: bool,
    /// Time and size of the step.
    time: f64,
    step: f64,
    /// What a drift adds to attitudes and spins.
    change: Vec<f64>,
    /// How much of the step the drifts have covered.
    covered: f64,
    /// Units of work of turning each body through the step, for [`Patience`].
    work: Vec<u64>,
    /// Velocities and spins in the middle of a kick, for the books.
    middle: [Vec<[f64; 3]>; 2],
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
        let zeros = vec![[0.0; 3]; n];
        Ok(Self {
            parts,
            jacobi: Jacobi::new(&masses, dynamics.system().gravitational_constant()),
            tops: Tops::new(&inertia),
            inertia,
            acceleration: zeros.clone(),
            spin_rate: zeros.clone(),
            loaded: false,
            time: 0.0,
            step: 0.0,
            change: vec![0.0; 7 * n],
            covered: 0.0,
            work: vec![0; n],
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
                let mu =
                    dynamics.system().gravitational_constant() * (bodies[body].mass + bodies[other].mass);
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
        self.loaded.then(|| both.map(|([a, b, c], [x, y, z])| [*a, *b, *c, *x, *y, *z]).collect())
    }

    /// The inverse of [`Self::loads`].
    pub fn recall(&mut self, loads: &[[f64; 6]]) {
        for (body, &[a, b, c, x, y, z]) in loads.iter().enumerate().take(self.inertia.len()) {
            (self.acceleration[body], self.spin_rate[body]) = ([a, b, c], [x, y, z]);
        }
        self.loaded = loads.len() == self.inertia.len();
    }

    /// Notes the step that comes. Forces from outside are computed anew, with what they put into the books.
    pub fn begin(&mut self, dynamics: &Dynamics, time: f64, y: &[f64], step: f64) {
        let layout = dynamics.layout();
        (self.time, self.step, self.covered) = (time, step, 0.0);
        self.jacobi.reset();
        self.loaded &= layout.forces == 0;
        for (body, work) in self.work.iter_mut().enumerate() {
            let angle = (2.0 * vector(y, layout.spin(body)).amax() * step).abs();
            // Too large a number counts as the limit, and so does NaN.
            *work = (ROTATION * (1.0 + angle.min(FARTHEST))) as u64;
        }
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
            for c in d..d + 3 {
                let change = size * high[c + 3];
                add(&mut high[c], &mut low[c], change);
            }
        }
        let arch = dynamics.system().arch();
        arch.dispatch(Drift { splitting: self, dynamics, size, high, low, patience })
    }

    /// Moves the bodies without forces, or on Kepler's orbits.
    #[inline(always)]
    fn orbits(&mut self, dynamics: &Dynamics, size: f64, high: &mut Blocks, low: &mut Blocks) -> Result<()> {
        match self.parts {
            Parts::Free => {
                for body in 0..high.position.len() {
                    add_each(&mut high.position[body], &mut low.position[body], size, &high.velocity[body]);
                }
                Ok(())
            }
            Parts::Kepler => self.jacobi.drift(size, high, low).map_err(|body| self.unsolved(dynamics, body)),
        }
    }

    /// The changes of attitudes and spins without torques.
    #[inline(always)]
    fn rotations<S: Simd>(
        &mut self,
        simd: S,
        dynamics: &Dynamics,
        size: f64,
        high: &Blocks,
        patience: &mut Patience,
    ) -> Result<()> {
        let (attitude, spin, work, now) = (&*high.attitude, &*high.spin, &self.work, self.time);
        let (turn, change) = self.change.split_at_mut(4 * spin.len());
        let (turn, change) = (turn.as_chunks_mut().0, change.as_chunks_mut().0);
        let mut ask = |body: usize| patience.spend(work[body], now);
        let too_far = match self.parts {
            Parts::Kepler => self.tops.turn(simd, size, Bodies { attitude, spin, turn, change }, ask)?,
            Parts::Free => {
                for body in 0..spin.len() {
                    ask(body)?;
                    let (inertia, own) = (self.inertia[body], spin[body].into());
                    let Some((turned, changed)) = variational_rotation(inertia, attitude[body], own, size)
                    else {
                        return Err(self.too_far(dynamics, body, own));
                    };
                    (turn[body], change[body]) = (turned, changed.into());
                }
                None
            }
        };
        too_far.map_or(Ok(()), |body| Err(self.too_far(dynamics, body, spin[body].into())))
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
        let evaluations = u64::from(!self.loaded);
        if !self.loaded {
            for part in 0..dynamics.parts() {
                patience.spend(dynamics.work(), self.time)?;
                let loaded = dynamics.load(part, self.time + self.covered, high);
                loaded.map_err(|rejected| self.refused(dynamics, rejected))?;
            }
        }
        let arch = dynamics.system().arch();
        arch.dispatch(Kick { splitting: self, dynamics, size, high, low });
        if !self.loaded {
            return Err(self.refused(dynamics, Rejected::NotFinite));
        }
        if dynamics.layout().forces > 0 {
            self.enter(dynamics, size, high, low);
        }
        Ok(evaluations)
    }

    /// The barycentre's kick, and what the kick of the bodies by the present loads, which has been made, puts into the books: the power
    /// with the velocities of its middle is just what the kick adds to the energy.
    fn enter(&mut self, dynamics: &Dynamics, size: f64, high: &mut [f64], low: &mut [f64]) {
        let layout = dynamics.layout();
        let kick = dynamics.barycentre_acceleration();
        let departing = layout.departure() + 3;
        let (bodies, books) = high.split_at_mut(layout.book(0));
        let mut scene = dynamics.scene(self.time + self.covered, bodies);
        let [velocity, spin] = &mut self.middle;
        for body in 0..layout.bodies {
            for c in 0..3 {
                velocity[body][c] = scene.velocity[body][c] - 0.5 * size * self.acceleration[body][c];
                spin[body][c] = scene.spin[body][c] - 0.5 * size * self.spin_rate[body][c];
            }
        }
        (scene.velocity, scene.spin) = (velocity, spin);
        scene.departure[1] += 0.5 * size * kick;
        let lows = low[layout.book(0)..].as_chunks_mut::<BOOK>().0;
        for (force, (high, low)) in books.as_chunks_mut::<BOOK>().0.iter_mut().zip(lows).enumerate() {
            add_each(high, low, size, &dynamics.outside().book(scene, force));
        }
        (0..3).for_each(|c| add(&mut high[departing + c], &mut low[departing + c], size * kick[c]));
    }

    /// Takes over the loads that have been computed, less those of the Kepler motion, and kicks by them.
    #[inline(always)]
    fn settle(&mut self, dynamics: &Dynamics, size: f64, high: &mut Blocks, low: &mut Blocks) {
        let n = high.spin.len();
        let (acceleration, torque) = dynamics.loads();
        let (acceleration, torque, inertia) = (&acceleration[..n], &torque[..n], &self.inertia[..n]);
        let (own, rate) = (&mut self.acceleration[..n], &mut self.spin_rate[..n]);
        let mut sum = 0.0;
        let mut centre = Vec3::zeros();
        for body in (0..n).rev() {
            let kepler = match self.parts {
                Parts::Kepler => self.jacobi.acceleration(body, &mut centre),
                Parts::Free => Vec3::zeros(),
            };
            let (inertia, torque) = (&inertia[body], &torque[body]);
            for c in 0..3 {
                own[body][c] = acceleration[body][c] - kepler[c];
                rate[body][c] = if inertia[c] > 0.0 { torque[c] / inertia[c] } else { 0.0 };
                sum += 0.0 * (own[body][c] + rate[body][c]);
            }
            add_each(&mut high.velocity[body], &mut low.velocity[body], size, &own[body]);
            add_each(&mut high.spin[body], &mut low.spin[body], size, &rate[body]);
        }
        // Otherwise one of them is infinite or not a number.
        self.loaded = sum == 0.0;
    }
}

/// A drift, compiled with the instructions of a path.
struct Drift<'a, 'b> {
    splitting: &'a mut Splitting,
    dynamics: &'a Dynamics,
    size: f64,
    high: &'a mut [f64],
    low: &'a mut [f64],
    patience: &'a mut Patience<'b>,
}

impl WithSimd for Drift<'_, '_> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<()> {
        let Self { splitting, dynamics, size, high, low, patience } = self;
        let layout = dynamics.layout();
        let n = layout.bodies;
        // The turns are added last: what is read as a whole has to wait until all its parts are in memory.
        splitting.rotations(simd, dynamics, size, &Blocks::new(n, high), patience)?;
        splitting.orbits(dynamics, size, &mut Blocks::new(n, high), &mut Blocks::new(n, low))?;
        let turned = layout.attitude(0)..layout.departure();
        add_all(simd, &mut high[turned.clone()], &mut low[turned], 1.0, &splitting.change);
        Ok(())
    }
}

/// A kick by loads that are taken over where they are new.
struct Kick<'a> {
    splitting: &'a mut Splitting,
    dynamics: &'a Dynamics,
    size: f64,
    high: &'a mut [f64],
    low: &'a mut [f64],
}

impl WithSimd for Kick<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { splitting, dynamics, size, high, low } = self;
        let n = dynamics.layout().bodies;
        let (high, low) = (&mut Blocks::new(n, high), &mut Blocks::new(n, low));
        if !splitting.loaded {
            return splitting.settle(dynamics, size, high, low);
        }
        for body in 0..n {
            add_each(&mut high.velocity[body], &mut low.velocity[body], size, &splitting.acceleration[body]);
            add_each(&mut high.spin[body], &mut low.spin[body], size, &splitting.spin_rate[body]);
        }
    }
}
