//! The core for a page in a browser: a system with an initial state, and runs of it.
//!
//! All arrays are flat, in C order, with the shapes that the documentation of each function gives. Units are
//! those of the system. A system is described by the JSON that `explorer/build.py` writes.

use fullbody::dynamics::{Parameter, Settings, State, System};
use fullbody::error::{Error, Result as CoreResult};
use fullbody::forces::Force;
use fullbody::integrate::Tolerance;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Mat3, Vec3, rotation};
use fullbody::orbit::KeplerElements;
use fullbody::photometry::{Law, Photometer, Surface, View};
use fullbody::shape::Body;
use fullbody::trajectory::{Integrator, Output, Run, Simulation, Trajectory};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::time::Duration;
use wasm_bindgen::prelude::*;
use web_time::Instant;

/// The longest time that a call may take, since the page does not respond meanwhile.
const TIME_LIMIT: Duration = Duration::from_secs(5);

/// The description of a [`Model`].
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    bodies: Vec<Body>,
    gravitational_constant: f64,
    settings: Settings,
    forces: Vec<Force>,
    time: f64,
    position: Vec<[f64; 3]>,
    velocity: Vec<[f64; 3]>,
    attitude: Vec<[f64; 4]>,
    spin: Vec<[f64; 3]>,
}

/// A system and the initial state of its runs. It never changes: methods that change a number return another
/// model.
#[wasm_bindgen]
pub struct Model {
    system: System,
    state: State,
}

type Result<T> = std::result::Result<T, JsError>;

impl Model {
    /// Returns the model with other positions and velocities.
    fn with_orbit(&self, position: Vec<Vec3>, velocity: Vec<Vec3>) -> CoreResult<Self> {
        let state = &self.state;
        let state =
            State::new(state.time(), position, velocity, state.attitude().to_vec(), state.spin().to_vec())?;
        Ok(Self { system: self.system.clone(), state })
    }

    /// Integrates over a duration, with samples at the ends of equal intervals.
    fn simulate(&self, duration: f64, intervals: usize) -> CoreResult<Motion> {
        let start = self.state.time();
        let mut simulation =
            Simulation::new(&self.system, &self.state, Integrator::Verner98(Tolerance::new(1e-13, 1e-13)?))?;
        let mut record = Trajectory::new(self.system.bodies().len());
        let times = (0..=intervals).map(|k| start + duration * k as f64 / intervals as f64).collect();
        let mut hook = time_limit();
        let output = Output::Times(times);
        let outcome = simulation.run(start + duration, Run::new(&output), &mut record, &mut |_, _| hook());
        Ok(Motion { system: self.system.clone(), record, error: outcome.err().map(message_of) })
    }
}

#[wasm_bindgen]
impl Model {
    /// Makes a model from its description in JSON.
    ///
    /// # Errors
    /// A message for a description of another form, and for values that the core refuses.
    #[wasm_bindgen(constructor)]
    pub fn new(description: &str) -> Result<Model> {
        let description: Description = serde_json::from_str(description)?;
        let system =
            System::new(description.bodies, description.gravitational_constant, description.settings)?
                .with_forces(description.forces)?;
        let vectors = |rows: Vec<[f64; 3]>| rows.into_iter().map(Vec3::from).collect();
        let (position, velocity, spin) =
            (vectors(description.position), vectors(description.velocity), vectors(description.spin));
        Ok(Self {
            system,
            state: State::new(description.time, position, velocity, description.attitude, spin)?,
        })
    }

    /// Returns the names and values of the parameters of the system, such as masses and semi-axes, as JSON.
    pub fn parameters(&self) -> Result<String> {
        let values: BTreeMap<_, _> = self.system.parameter_values().into_iter().collect();
        Ok(serde_json::to_string(&values)?)
    }

    /// Returns the semi-axes (N, 3) of the bodies; those of other shapes are zero.
    #[wasm_bindgen(js_name = semiAxes)]
    pub fn semi_axes(&self) -> Vec<f64> {
        self.system.bodies().iter().flat_map(Body::semi_axes).collect()
    }

    /// Returns the model in which a parameter of the system has this value; its names are those of
    /// [`Self::parameters`].
    #[wasm_bindgen(js_name = withParameter)]
    pub fn with_parameter(&self, name: &str, value: f64) -> Result<Model> {
        let parameter = Parameter::named(name, &self.system)?;
        let system = parameter.changed(&self.system, value - parameter.value(&self.system))?;
        Ok(Self { system, state: self.state.clone() })
    }

    /// Returns the osculating elements (6,) of a body about the first one: semi-major axis, eccentricity,
    /// inclination, longitude of the ascending node, argument of periapsis and mean anomaly, angles in
    /// radians.
    pub fn elements(&self, body: usize) -> Result<Vec<f64>> {
        let mu = mu(&self.system, body)?;
        let (x, v) = (self.state.position(), self.state.velocity());
        Ok(numbers(&KeplerElements::from_cartesian(&(x[body] - x[0]), &(v[body] - v[0]), mu)?))
    }

    /// Returns the model in which a body has these osculating elements about the first one. The barycentre of
    /// the two keeps its position and velocity; attitudes and spins remain.
    #[wasm_bindgen(js_name = withElements)]
    pub fn with_elements(&self, body: usize, elements: &[f64]) -> Result<Model> {
        let mu = mu(&self.system, body)?;
        let &[a, e, i, node, periapsis, anomaly] = elements else {
            return Err(JsError::new("the number of elements has to be six"));
        };
        let (x, v) = KeplerElements::new(a, e, i, node, periapsis, anomaly)?.to_cartesian(mu)?;
        let masses = [0, body].map(|k| self.system.bodies()[k].mass());
        let about_barycentre = |vectors: &[Vec3], relative: Vec3| {
            let mut vectors = vectors.to_vec();
            let centre = (vectors[0] * masses[0] + vectors[body] * masses[1]) / (masses[0] + masses[1]);
            vectors[0] = centre - relative * (masses[1] / (masses[0] + masses[1]));
            vectors[body] = centre + relative * (masses[0] / (masses[0] + masses[1]));
            vectors
        };
        let position = about_barycentre(self.state.position(), x);
        Ok(self.with_orbit(position, about_barycentre(self.state.velocity(), v))?)
    }

    /// Returns the model in which a body is rotated by an angle, in radians, about its own x axis, while its
    /// spin in its body frame remains.
    #[wasm_bindgen(js_name = withTilt)]
    pub fn with_tilt(&self, body: usize, angle: f64) -> Result<Model> {
        let state = &self.state;
        let mut attitude = state.attitude().to_vec();
        let count = attitude.len();
        let tilted =
            attitude.get_mut(body).ok_or_else(|| JsError::new(&format!("body has to be below {count}")))?;
        *tilted = rotation::product(*tilted, rotation::exponential(&Vec3::new(angle, 0.0, 0.0)));
        let (position, velocity) = (state.position().to_vec(), state.velocity().to_vec());
        let state = State::new(state.time(), position, velocity, attitude, state.spin().to_vec())?;
        Ok(Self { system: self.system.clone(), state })
    }

    /// Returns the model in which a momentum (3,), in the inertial frame, has been added to a body at its
    /// centre.
    #[wasm_bindgen(js_name = withMomentum)]
    pub fn with_momentum(&self, body: usize, momentum: &[f64]) -> Result<Model> {
        mu(&self.system, body)?;
        let &[x, y, z] = momentum else {
            return Err(JsError::new("the number of components has to be three"));
        };
        let mut velocity = self.state.velocity().to_vec();
        velocity[body] += Vec3::new(x, y, z) / self.system.bodies()[body].mass();
        Ok(self.with_orbit(self.state.position().to_vec(), velocity)?)
    }

    /// Returns the unit vector (3,) of a body's velocity relative to the first body.
    #[wasm_bindgen(js_name = direction)]
    pub fn direction(&self, body: usize) -> Result<Vec<f64>> {
        mu(&self.system, body)?;
        let velocity = self.state.velocity()[body] - self.state.velocity()[0];
        Ok(velocity.normalize().as_slice().to_vec())
    }

    /// Integrates over a duration and returns the motion at the ends of equal intervals, or up to the error
    /// that ended it early.
    pub fn integrate(&self, duration: f64, intervals: usize) -> Result<Motion> {
        if intervals == 0 {
            return Err(JsError::new("the number of intervals has to be at least one"));
        }
        Ok(self.simulate(duration, intervals)?)
    }
}

/// A run of a [`Model`] at K times.
#[wasm_bindgen]
pub struct Motion {
    system: System,
    record: Trajectory,
    error: Option<String>,
}

impl Motion {
    /// Returns the position and velocity of a body relative to the first one in sample `k`.
    fn relative(&self, k: usize, body: usize) -> (Vec3, Vec3) {
        let record = &self.record;
        (record.position(k, body) - record.position(k, 0), record.velocity(k, body) - record.velocity(k, 0))
    }
}

#[wasm_bindgen]
impl Motion {
    /// Returns the times (K,).
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> Vec<f64> {
        self.record.time.clone()
    }

    /// Returns the positions (K, N, 3).
    #[wasm_bindgen(getter)]
    pub fn position(&self) -> Vec<f64> {
        self.record.position.clone()
    }

    /// Returns the attitudes (K, N, 4), as unit quaternions with the scalar first.
    #[wasm_bindgen(getter)]
    pub fn attitude(&self) -> Vec<f64> {
        self.record.attitude.clone()
    }

    /// Returns the change (K,) of the energy since the start, relative to the sum of the translational and
    /// the potential energy at the start.
    #[wasm_bindgen(getter, js_name = energyDrift)]
    pub fn energy_drift(&self) -> Vec<f64> {
        let energy = &self.record.energy;
        let Some(&[total, translational, _, potential]) = energy.first_chunk::<4>() else {
            return Vec::new();
        };
        let scale = (translational + potential).abs();
        energy.chunks_exact(4).map(|row| (row[0] - total) / scale).collect()
    }

    /// Returns the message of the error that ended the run early.
    #[wasm_bindgen(getter)]
    pub fn error(&self) -> Option<String> {
        self.error.clone()
    }

    /// Returns roll, pitch and yaw (K, 3), in radians, of a body in the frame of its orbit about the first
    /// one, whose x axis points from the body to the first one and whose z axis is the orbit normal. If the
    /// x axis of the body starts at more than 90 degrees from that of the orbit, the body's x and y axes are
    /// reversed. Roll and yaw have no jumps.
    #[wasm_bindgen(js_name = rollPitchYaw)]
    pub fn roll_pitch_yaw(&self, body: usize) -> Result<Vec<f64>> {
        mu(&self.system, body)?;
        let mut roll_pitch_yaw: Vec<f64> = Vec::with_capacity(3 * self.record.len());
        let mut sign = 1.0;
        for k in 0..self.record.len() {
            let (position, velocity) = self.relative(k, body);
            let (x, z) = (-position.normalize(), position.cross(&velocity).normalize());
            let orbit = Mat3::from_columns(&[x, z.cross(&x), z]);
            let mut r = orbit.transpose() * rotation::matrix(self.record.state(k).attitude()[body]);
            if k == 0 && r[(0, 0)] < 0.0 {
                sign = -1.0;
            }
            r = Mat3::from_columns(&[r.column(0) * sign, r.column(1) * sign, r.column(2).into()]);
            let mut angles =
                [r[(2, 1)].atan2(r[(2, 2)]), -r[(2, 0)].clamp(-1.0, 1.0).asin(), r[(1, 0)].atan2(r[(0, 0)])];
            if k > 0 {
                for axis in [0, 2] {
                    let last = roll_pitch_yaw[3 * (k - 1) + axis];
                    angles[axis] += TAU * ((last - angles[axis]) / TAU).round();
                }
            }
            roll_pitch_yaw.extend(angles);
        }
        Ok(roll_pitch_yaw)
    }

    /// Returns the osculating elements (K, 6) of a body about the first one, in the order of
    /// [`Model::elements`].
    pub fn elements(&self, body: usize) -> Result<Vec<f64>> {
        let mu = mu(&self.system, body)?;
        let mut elements = Vec::with_capacity(6 * self.record.len());
        for k in 0..self.record.len() {
            let (position, velocity) = self.relative(k, body);
            elements.extend(numbers(&KeplerElements::from_cartesian(&position, &velocity, mu)?));
        }
        Ok(elements)
    }

    /// Returns the brightness (K,) of all bodies together, in squared length, by Lommel and Seeliger's law
    /// with occultations and eclipses, for constant directions (3,) to the observer and to the Sun.
    pub fn brightness(&self, to_observer: &[f64], to_sun: &[f64]) -> Result<Vec<f64>> {
        let (&[ex, ey, ez], &[sx, sy, sz]) = (to_observer, to_sun) else {
            return Err(JsError::new("the number of components of a direction has to be three"));
        };
        let bodies = self.system.bodies().to_vec();
        let surface = Surface { law: Law::Sum([1.0, 0.0]), albedo: vec![1.0] };
        let photometer = Photometer::new(bodies.clone(), vec![surface; bodies.len()], true, 0.0)?;
        let states: Vec<_> = (0..self.record.len()).map(|k| self.record.state(k)).collect();
        let view = |state| view(state, Vec3::new(ex, ey, ez), Vec3::new(sx, sy, sz));
        let views: Vec<_> = states.iter().map(view).collect();
        let mut hook = time_limit();
        let brightness = photometer.brightness_in(&views, &mut InterruptCheck::new(&mut hook));
        let by_body = brightness.map_err(|error| JsError::new(&message_of(error)))?;
        Ok(by_body.chunks_exact(bodies.len()).map(|row| row.iter().sum()).collect())
    }
}

/// Returns a hook that stops a computation after [`TIME_LIMIT`].
fn time_limit() -> impl FnMut() -> ControlFlow<()> {
    let start = Instant::now();
    move || if start.elapsed() > TIME_LIMIT { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Returns the message of an error, which gives the time reached if the computation took too long.
fn message_of(error: Error) -> String {
    match error {
        Error::Interrupted { time } => {
            format!("the computation was stopped at time {time:.6}, after {} seconds", TIME_LIMIT.as_secs())
        }
        error => error.to_string(),
    }
}

/// Returns G times the sum of the masses of the first body and another one.
///
/// # Errors
/// If `body` is not the index of another body.
fn mu(system: &System, body: usize) -> CoreResult<f64> {
    let bodies = system.bodies();
    if body == 0 || body >= bodies.len() {
        return Err(Error::invalid("body", body, format!("from 1 to {}", bodies.len() - 1)));
    }
    Ok(system.gravitational_constant() * (bodies[0].mass() + bodies[body].mass()))
}

/// Returns the view of a state by a distant observer.
fn view(state: &State, to_observer: Vec3, to_sun: Vec3) -> View<'_> {
    View {
        time: state.time(),
        position: state.position(),
        attitude: state.attitude(),
        velocity: &[],
        to_observer,
        to_sun,
        distant: true,
    }
}

/// Returns elements in the order of [`Model::elements`].
fn numbers(orbit: &KeplerElements) -> Vec<f64> {
    vec![
        orbit.semi_major_axis,
        orbit.eccentricity,
        orbit.inclination,
        orbit.longitude_of_node,
        orbit.argument_of_periapsis,
        orbit.mean_anomaly,
    ]
}
