//! A force of the user, given by a pointer to a C function, which may be compiled from any language or call
//! an interpreter.

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

/// A pointer to a function, and the object that keeps it alive.
#[derive(Clone)]
pub struct Call {
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
        Some(Self { function, data, success, owner })
    }
}

impl std::fmt::Debug for Call {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "Call({:#x})", self.function as usize)
    }
}

impl PartialEq for Call {
    fn eq(&self, other: &Self) -> bool {
        (self.function as usize, self.data) == (other.function as usize, other.data)
            && Arc::ptr_eq(&self.owner, &other.owner)
    }
}

impl Function {
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
        let [position, velocity, force, torque] = std::array::from_fn(|_| zeros.clone());
        Ok(FunctionForce {
            call,
            unknown: (!self.depends_on_velocity).then(|| all(f64::NAN)),
            position,
            velocity,
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

    #[allow(unsafe_code)]
    fn load<S: Simd>(&mut self, _: S, name: &str, snapshot: MotionSnapshot) -> Result<()> {
        let [position, velocity] = [0, 1].map(|k| snapshot.nominal[k] + snapshot.barycentre_offset[k]);
        for body in 0..self.points.len() {
            self.position[body] = position + Vec3::from(snapshot.position[body]);
            self.velocity[body] = velocity + Vec3::from(snapshot.velocity[body]);
        }
        assert!(
            [snapshot.attitude.len(), snapshot.spin.len()] == [self.points.len(); 2],
            "one of each for every body"
        );
        let (velocity, spin) = match &self.unknown {
            Some(unknown) => (unknown.as_ptr().cast(), unknown.as_ptr().cast()),
            None => (self.velocity.as_ptr().cast(), snapshot.spin.as_ptr().cast()),
        };
        self.force.fill(Vec3::zeros());
        self.torque.fill(Vec3::zeros());
        // SAFETY: the caller of `Call::new` has guaranteed the signature, and the arrays have the lengths
        // that it states.
        let answer = unsafe {
            (self.call.function)(
                snapshot.time,
                self.points.len() as i64,
                self.position.as_ptr().cast(),
                velocity,
                snapshot.attitude.as_ptr().cast(),
                spin,
                self.force.as_mut_ptr().cast(),
                self.torque.as_mut_ptr().cast(),
                self.call.data as *mut c_void,
            )
        };
        let failed = |detail: String, answer| {
            Err(Error::ForceFailed { force: name.to_owned(), time: snapshot.time, detail, answer })
        };
        if answer != self.call.success {
            let detail = format!("its function answers {answer}, where {} is success", self.call.success);
            return failed(detail, Some(answer));
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
