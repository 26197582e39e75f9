//! A force of the user: a closure, or a pointer to a C function, which may be compiled from any language or
//! call an interpreter.

use super::evaluator::Evaluator;
use super::{Load, LoadJacobian, MotionSnapshot};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::shape::Body;
use pulp::Simd;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::ffi::{c_int, c_void};
use std::sync::Arc;

/// The function's signature in C: `int f(double time, int64_t bodies, const double *position, const double
/// *velocity, const double *attitude, const double *spin, double *force, double *torque, void *data)`.
///
/// Arrays are (bodies, 3), attitudes (bodies, 4), in C order: positions, velocities and forces in the
/// coordinates of the states, spins and torques in body frames. Forces and torques are zero when the function
/// is called. The run ends if the function returns anything but the value for success.
pub type ForceFunction = unsafe extern "C" fn(
    f64,
    i64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *mut f64,
    *mut f64,
    *mut c_void,
) -> c_int;

/// The bodies at a time, as a force of the user receives them.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// The time.
    pub time: f64,
    /// The positions of the centres, inertial frame.
    pub position: &'a [Vec3],
    /// The velocities of the centres, inertial frame; NaN for a force that depends on no velocities.
    pub velocity: &'a [Vec3],
    /// The attitudes: unit quaternions `[w, x, y, z]`, body frames to inertial frame.
    pub attitude: &'a [[f64; 4]],
    /// The spins, body frames; NaN for a force that depends on no velocities.
    pub spin: &'a [Vec3],
}

/// A closure that adds forces (inertial frame) and torques (body frames) of each body to zeros, or says why it
/// cannot.
type Closure = dyn Fn(&Motion, &mut [Vec3], &mut [Vec3]) -> Result<(), String> + Send + Sync;

/// A force that a function computes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Function {
    /// The name of the force.
    pub name: String,
    /// Whether the force depends on velocities or spins.
    pub depends_on_velocity: bool,
    /// The function. Archives do not contain it: it must be given again when one is loaded.
    #[serde(skip)]
    pub call: Option<Call>,
}

/// A function of the user, with what keeps it alive.
#[derive(Clone)]
pub struct Call(Callee);

#[derive(Clone)]
enum Callee {
    Closure(Arc<Closure>),
    Pointer(Pointer),
}

/// A pointer to a C function and to its data, with the object that keeps them alive.
#[derive(Clone)]
struct Pointer {
    function: ForceFunction,
    data: usize,
    success: c_int,
    owner: Arc<dyn Any + Send + Sync>,
}

impl Call {
    /// Takes the addresses of a function and of its data, and the value that it returns for success. `owner`
    /// is kept as long as they are used.
    ///
    /// # Safety
    ///
    /// The function must have the signature of [`ForceFunction`] and may be called from any thread. It and
    /// its data must stay valid while `owner` lives.
    #[allow(unsafe_code)]
    pub unsafe fn new(
        function: usize,
        data: usize,
        success: c_int,
        owner: Arc<dyn Any + Send + Sync>,
    ) -> Option<Self> {
        if function == 0 {
            return None;
        }
        // SAFETY: the caller guarantees the signature, and the address is not null.
        let function =
            unsafe { std::mem::transmute::<*const c_void, ForceFunction>(function as *const c_void) };
        Some(Self(Callee::Pointer(Pointer { function, data, success, owner })))
    }

    /// Adds forces and torques at a motion to zeros; an error has the answer of a C function, if it is one.
    #[allow(unsafe_code)]
    fn add(
        &self,
        motion: &Motion,
        force: &mut [Vec3],
        torque: &mut [Vec3],
    ) -> Result<(), (String, Option<c_int>)> {
        let Pointer { function, data, success, .. } = match &self.0 {
            Callee::Closure(closure) => return closure(motion, force, torque).map_err(|why| (why, None)),
            Callee::Pointer(pointer) => pointer,
        };
        let bodies = force.len();
        let lengths =
            [motion.position.len(), motion.velocity.len(), motion.attitude.len(), motion.spin.len()];
        assert!(lengths == [bodies; 4] && torque.len() == bodies, "one of each for every body");
        // SAFETY: the caller of `Call::new` has guaranteed the signature, and the arrays have the lengths
        // that it states.
        let answer = unsafe {
            function(
                motion.time,
                bodies as i64,
                motion.position.as_ptr().cast(),
                motion.velocity.as_ptr().cast(),
                motion.attitude.as_ptr().cast(),
                motion.spin.as_ptr().cast(),
                force.as_mut_ptr().cast(),
                torque.as_mut_ptr().cast(),
                *data as *mut c_void,
            )
        };
        if answer == *success {
            return Ok(());
        }
        Err((format!("its function answers {answer}, where {success} is success"), Some(answer)))
    }
}

impl std::fmt::Debug for Call {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match &self.0 {
            Callee::Closure(_) => write!(f, "Call(closure)"),
            Callee::Pointer(pointer) => write!(f, "Call({:#x})", pointer.function as usize),
        }
    }
}

impl PartialEq for Call {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Callee::Closure(one), Callee::Closure(other)) => Arc::ptr_eq(one, other),
            (Callee::Pointer(one), Callee::Pointer(other)) => {
                (one.function as usize, one.data) == (other.function as usize, other.data)
                    && Arc::ptr_eq(&one.owner, &other.owner)
            }
            _ => false,
        }
    }
}

impl Function {
    /// Makes a force from a closure, which adds the force (inertial frame) and the torque (body frame) of each
    /// body to zeros, or returns why it cannot, which ends the run. `depends_on_velocity` says whether it uses
    /// velocities or spins. It may be called from any thread. A run ends with
    /// [`Error::ForceFailed`] where it returns an error or a number that is not finite.
    ///
    /// ```
    /// use fullbody::dynamics::{Settings, State, System};
    /// use fullbody::forces::{Force, Function};
    /// use fullbody::integrate::Tolerance;
    /// use fullbody::math::Vec3;
    /// use fullbody::shape::{Body, Shape};
    /// use fullbody::trajectory::{Integrator, Output, Simulation, Trajectory};
    ///
    /// // A ball in a medium that slows it down: v = exp(-0.5 t).
    /// let ball = Body::with_mass("Ball", Shape::ellipsoid([1.0, 1.0, 1.0])?, 2.0)?;
    /// let drag = Function::new("drag", true, |motion, force, _torque| {
    ///     force[0] = -motion.velocity[0];
    ///     Ok(())
    /// });
    /// let system = System::new(vec![ball], 0.0, Settings::default())?.with_forces(vec![Force::Function(drag)])?;
    /// let (at, speed) = (vec![Vec3::zeros()], vec![Vec3::x()]);
    /// let state = State::new(0.0, at.clone(), speed, vec![[1.0, 0.0, 0.0, 0.0]], at)?;
    /// let mut simulation = Simulation::new(&system, &state, Integrator::Verner98(Tolerance::new(1e-13, 1e-13)?))?;
    /// let mut run = Trajectory::new(1);
    /// simulation.integrate(3.0, &Output::Ends, &mut run)?;
    /// assert!((run.velocity(1, 0).x - (-1.5_f64).exp()).abs() < 1e-12);
    /// // The work of the drag is what the ball has lost.
    /// assert!((run.conserved_energy(1) - run.energy(0).total).abs() < 1e-12);
    /// # Ok::<(), fullbody::error::Error>(())
    /// ```
    pub fn new(
        name: impl Into<String>,
        depends_on_velocity: bool,
        function: impl Fn(&Motion, &mut [Vec3], &mut [Vec3]) -> Result<(), String> + Send + Sync + 'static,
    ) -> Self {
        let call = Some(Call(Callee::Closure(Arc::new(function))));
        Self { name: name.into(), depends_on_velocity, call }
    }

    pub(super) fn prepared(&self, of: usize, bodies: &[Body]) -> Result<FunctionForce> {
        let Some(call) = self.call.clone() else {
            return Err(Error::invalid(
                format!("function of {}", self.name),
                "missing: an archive keeps none",
                "it to be given again where the archive is loaded",
            ));
        };
        let all = |value| vec![Vec3::from_element(value); bodies.len()];
        let zeros = all(0.0);
        let [position, velocity, spin, force, torque] = std::array::from_fn(|_| zeros.clone());
        Ok(FunctionForce {
            call,
            unknown: (!self.depends_on_velocity).then(|| all(f64::NAN)),
            position,
            velocity,
            spin,
            force,
            torque,
            loads: (0..bodies.len()).map(|on| Load::none(of, on, true)).collect(),
            points: bodies
                .iter()
                .map(|body| (body.inertia() == Vec3::zeros()).then(|| body.name.clone()))
                .collect(),
        })
    }
}

/// The force of a function, with buffers for its arguments and results.
#[derive(Debug, Clone)]
pub(super) struct FunctionForce {
    call: Call,
    /// Arrays of NaN, passed as velocities and spins of a force that is declared to depend on neither, so
    /// that a function that uses them anyway fails.
    unknown: Option<Vec<Vec3>>,
    position: Vec<Vec3>,
    velocity: Vec<Vec3>,
    spin: Vec<Vec3>,
    force: Vec<Vec3>,
    torque: Vec<Vec3>,
    /// The name of each body that is a point, `None` for others.
    points: Vec<Option<String>>,
    loads: Vec<Load>,
}

impl Evaluator for FunctionForce {
    fn loads(&self) -> &[Load] {
        &self.loads
    }

    /// Counts some ten microseconds, which a function that is written in Python takes.
    fn work(&self) -> u64 {
        1000
    }

    fn add_jacobian(&mut self, name: &str, _: MotionSnapshot, _: &mut LoadJacobian) -> Result<()> {
        let expected = "a system without it: a function does not tell its derivatives";
        Err(Error::invalid("derivatives", format!("of the function {name}"), expected))
    }

    fn load<S: Simd>(&mut self, _: S, name: &str, snapshot: MotionSnapshot) -> Result<()> {
        let [position, velocity] = [0, 1].map(|k| snapshot.nominal[k] + snapshot.barycentre_offset[k]);
        for body in 0..self.points.len() {
            self.position[body] = position + Vec3::from(snapshot.position[body]);
            self.velocity[body] = velocity + Vec3::from(snapshot.velocity[body]);
            self.spin[body] = Vec3::from(snapshot.spin[body]);
        }
        let (velocity, spin) = self.unknown.as_ref().map_or((&self.velocity, &self.spin), |nan| (nan, nan));
        let attitude = snapshot.attitude;
        let motion = Motion { time: snapshot.time, position: &self.position, velocity, attitude, spin };
        self.force.fill(Vec3::zeros());
        self.torque.fill(Vec3::zeros());
        let failed = |detail: String, answer| {
            Err(Error::ForceFailed { force: name.to_owned(), time: snapshot.time, detail, answer })
        };
        if let Err((detail, answer)) = self.call.add(&motion, &mut self.force, &mut self.torque) {
            return failed(detail, answer);
        }
        if let Some(value) = self.force.iter().chain(&self.torque).flatten().find(|value| !value.is_finite())
        {
            let why = if self.unknown.is_some() {
                " (with depends_on_velocity=False it is called with nan for velocities and spins)"
            } else {
                ""
            };
            return failed(format!("its function gives {value}; expected finite numbers{why}"), None);
        }
        for (body, load) in self.loads.iter_mut().enumerate() {
            (load.force, load.torque) = (self.force[body], self.torque[body]);
            if let (Some(name), true) = (&self.points[body], load.torque != Vec3::zeros()) {
                let detail =
                    format!("its function gives a torque on {name}, a point, which nothing can turn");
                return failed(detail, None);
            }
        }
        Ok(())
    }
}
