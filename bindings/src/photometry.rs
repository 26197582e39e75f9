//! Bindings of the brightness of bodies and of the recoil of sunlight.

use super::arrays::{array, from_vectors, rows, vectors};
use super::bodies::PyBody;
use super::listening::listening;
use crate::errors::Result;
use fullbody::error::Error;
use fullbody::math::Vec3;
use fullbody::photometry::{Hapke, Law, Photometer, Surface, View};
use fullbody::shape::Body;
use numpy::{PyArrayDyn, PyReadonlyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;
/// The brightness, and its derivatives with respect to bodies, directions, vertices and areas.
type PartialArrays<'py> = (Array<'py>, Array<'py>, Array<'py>, Vec<Array<'py>>, Vec<Array<'py>>);

/// A scattering law as Python passes it: the factors of Lommel-Seeliger's and of Lambert's law, or the parameters
/// of Hapke's law in the order of [`Hapke`]'s fields.
#[derive(FromPyObject)]
enum PyLaw {
    Sum([f64; 2]),
    Hapke([f64; 5]),
}

impl From<PyLaw> for Law {
    fn from(law: PyLaw) -> Self {
        match law {
            PyLaw::Sum(factors) => Self::Sum(factors),
            PyLaw::Hapke(
                [single_scattering_albedo, opposition_amplitude, opposition_width, asymmetry, roughness],
            ) => Self::Hapke(Hapke {
                single_scattering_albedo,
                opposition_amplitude,
                opposition_width,
                asymmetry,
                roughness,
            }),
        }
    }
}

/// Computes the brightness of bodies with given surfaces at any number of epochs.
#[pyclass(frozen, name = "Photometer", module = "fullbody._core")]
pub struct PyPhotometer {
    inner: Photometer,
}

/// K epochs of N bodies as Python passes them: times (K,), positions (K N, 3), attitudes (K N, 4), vectors to the
/// observer and to the Sun (K, 3 each), velocities divided by the speed of light (K N, 3; or (0, 3) to neglect
/// light times), and whether the observer and the Sun are infinitely far.
#[derive(FromPyObject)]
pub struct Epochs<'py>(
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArrayDyn<'py, f64>,
    PyReadonlyArrayDyn<'py, f64>,
    PyReadonlyArrayDyn<'py, f64>,
    PyReadonlyArrayDyn<'py, f64>,
    PyReadonlyArrayDyn<'py, f64>,
    bool,
);

/// Epochs in the types of the core.
pub struct EpochData {
    pub times: Vec<f64>,
    positions: Vec<Vec3>,
    attitudes: Vec<[f64; 4]>,
    directions: [Vec<Vec3>; 2],
    velocities: Vec<Vec3>,
    distant: bool,
}

impl Epochs<'_> {
    /// Copies the epochs, and checks the lengths of the arrays for this number of bodies.
    pub fn read(&self, bodies: usize) -> Result<EpochData, Error> {
        let times = self.0.as_array().to_vec();
        let epoch_data = EpochData {
            positions: vectors("position", &self.1)?,
            attitudes: rows::<4>("attitude", &self.2)?,
            directions: [vectors("to_observer", &self.3)?, vectors("to_sun", &self.4)?],
            velocities: vectors("velocity", &self.5)?,
            distant: self.6,
            times,
        };
        let count = epoch_data.times.len();
        let velocities = if epoch_data.velocities.is_empty() { 0 } else { count * bodies };
        let lengths = [
            ("velocities", epoch_data.velocities.len(), velocities),
            ("positions", epoch_data.positions.len(), count * bodies),
            ("attitudes", epoch_data.attitudes.len(), count * bodies),
            ("directions to the observer", epoch_data.directions[0].len(), count),
            ("directions to the Sun", epoch_data.directions[1].len(), count),
        ];
        for (what, length, expected) in lengths {
            if length != expected {
                return Err(Error::invalid(format!("number of {what}"), length, expected.to_string()));
            }
        }
        Ok(epoch_data)
    }
}

impl EpochData {
    /// Returns the view at each epoch.
    pub fn views(&self, bodies: usize) -> Vec<View<'_>> {
        let view = |(k, time): (usize, &f64)| View {
            time: *time,
            position: &self.positions[k * bodies..(k + 1) * bodies],
            attitude: &self.attitudes[k * bodies..(k + 1) * bodies],
            velocity: self.velocities.get(k * bodies..(k + 1) * bodies).unwrap_or_default(),
            to_observer: self.directions[0][k],
            to_sun: self.directions[1][k],
            distant: self.distant,
        };
        self.times.iter().enumerate().map(view).collect()
    }
}

#[pymethods]
impl PyPhotometer {
    #[new]
    fn new(
        bodies: Vec<PyRef<'_, PyBody>>,
        laws: Vec<PyLaw>,
        albedo: Vec<Vec<f64>>,
        mutual: bool,
        sun_radius: f64,
    ) -> Result<Self> {
        let bodies = bodies.iter().map(|body| body.inner.clone()).collect();
        let surfaces = laws.into_iter().zip(albedo);
        let surfaces = surfaces.map(|(law, albedo)| Surface { law: law.into(), albedo }).collect();
        Ok(Self { inner: Photometer::new(bodies, surfaces, mutual, sun_radius)? })
    }

    /// Returns the brightness (K, N) of each body.
    fn brightness<'py>(&self, py: Python<'py>, epochs: Epochs<'py>) -> Result<Array<'py>> {
        let count = self.inner.bodies().len();
        let epoch_data = epochs.read(count)?;
        let all = listening(py, |interrupt| self.inner.brightness_in(&epoch_data.views(count), interrupt))?;
        array(py, all, &[epoch_data.times.len(), count])
    }

    /// Returns the brightness of each body and its three first moments about the body's centre in the inertial
    /// frame (K, N, 4).
    fn moments<'py>(&self, py: Python<'py>, epochs: Epochs<'py>) -> Result<Array<'py>> {
        let count = self.inner.bodies().len();
        let epoch_data = epochs.read(count)?;
        let all = listening(py, |interrupt| self.inner.moments_in(&epoch_data.views(count), interrupt))?;
        let all = all.into_iter().flat_map(|(brightness, moment)| [brightness, moment.x, moment.y, moment.z]);
        array(py, all.collect(), &[epoch_data.times.len(), count, 4])
    }

    /// Returns the brightness (K, N) and its derivatives with respect to
    ///
    /// - position, rotation vector and semi-axes of each body (K, N, N, 9),
    /// - the unit vectors to the observer and to the Sun (K, N, 2, 3),
    /// - if `by_vertex`, for each body its V vertices (K, N, V, 3); V is zero unless it is one polyhedron,
    /// - if `by_vertex`, for each body its F areas of facets (K, N, F); F is zero unless it is given by these.
    fn partials<'py>(
        &self,
        py: Python<'py>,
        epochs: Epochs<'py>,
        by_vertex: bool,
    ) -> Result<PartialArrays<'py>> {
        let count = self.inner.bodies().len();
        let epoch_data = epochs.read(count)?;
        let views = epoch_data.views(count);
        let all = listening(py, |interrupt| self.inner.partials_in(&views, by_vertex, interrupt))?;
        let (mut brightness, mut by_body, mut by_direction) = (Vec::new(), Vec::new(), Vec::new());
        let mut vertices = vec![Vec::new(); if by_vertex { count } else { 0 }];
        let mut areas = vertices.clone();
        for (value, partials) in all {
            brightness.push(value);
            for by in partials.by_body {
                by_body.extend([by.position, by.rotation, by.semi_axes].iter().flat_map(|v| [v.x, v.y, v.z]));
            }
            by_direction.extend(partials.by_direction.iter().flat_map(|v| [v.x, v.y, v.z]));
            for (all, by) in vertices.iter_mut().zip(partials.by_vertex) {
                all.extend(by.iter().flat_map(|v| [v.x, v.y, v.z]));
            }
            areas.iter_mut().zip(partials.by_area).for_each(|(all, by)| all.extend(by));
        }
        let epochs = epoch_data.times.len();
        let vertex_array = |by: Vec<f64>| {
            let vertices = by.len() / (3 * count * epochs).max(1);
            array(py, by, &[epochs, count, vertices, 3])
        };
        let area_array = |by: Vec<f64>| {
            let facets = by.len() / (count * epochs).max(1);
            array(py, by, &[epochs, count, facets])
        };
        Ok((
            array(py, brightness, &[epochs, count])?,
            array(py, by_body, &[epochs, count, count, 9])?,
            array(py, by_direction, &[epochs, count, 2, 3])?,
            vertices.into_iter().map(vertex_array).collect::<Result<_>>()?,
            areas.into_iter().map(area_array).collect::<Result<_>>()?,
        ))
    }
}

/// Returns the recoil force and torque (M, 3 each) on a body for unit pressure of sunlight and directions to the
/// Sun (M, 3). Other bodies at `positions` (N, 3) hide light from it. All vectors are in the frame of the body.
#[pyfunction]
pub fn recoil<'py>(
    py: Python<'py>,
    body: PyRef<'py, PyBody>,
    others: Vec<PyRef<'py, PyBody>>,
    positions: PyReadonlyArrayDyn<'py, f64>,
    to_sun: PyReadonlyArrayDyn<'py, f64>,
) -> Result<(Array<'py>, Array<'py>)> {
    let (positions, to_sun) = (vectors("positions", &positions)?, vectors("directions to the Sun", &to_sun)?);
    let body = body.inner.clone();
    let others: Vec<(Body, Vec3)> = others.iter().map(|other| other.inner.clone()).zip(positions).collect();
    let loads = listening(py, |interrupt| fullbody::photometry::recoil(&body, &others, &to_sun, interrupt))?;
    let (forces, torques): (Vec<Vec3>, Vec<Vec3>) =
        loads.into_iter().map(|[force, torque]| (force, torque)).unzip();
    Ok((from_vectors(py, &forces)?, from_vectors(py, &torques)?))
}
