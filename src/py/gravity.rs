//! The gravity of bodies at points.

use super::arrays::{rows, vectors};
use super::bodies::PyBody;
use super::listening::listening;
use crate::error::Error;
use crate::gravity::{Attractor, BodyField, Points, Wanted};
use crate::math::Vec3;
use crate::math::lanes::VectorPath;
use crate::math::rotation;
use crate::names::Named;
use crate::patience::Patience;
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArrayDyn};
use pulp::Arch;
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// The gravity of bodies, ready for points.
#[pyclass(frozen, name = "Attraction", module = "fullbody._core")]
pub struct PyAttraction {
    fields: Vec<BodyField>,
    arch: Arch,
}

/// Points, each with the state that it belongs to.
struct Query<'a> {
    /// Positions and attitudes of all bodies, state by state.
    positions: Vec<Vec3>,
    attitudes: Vec<[f64; 4]>,
    /// For each point the place of its state.
    states: &'a [i64],
    points: &'a [f64],
    /// The shape in which the caller counts the points.
    shape: &'a [usize],
    /// The one body of which the gravity is wanted.
    body: Option<usize>,
}

#[pymethods]
impl PyAttraction {
    #[new]
    fn new(
        py: Python<'_>,
        bodies: Vec<PyRef<'_, PyBody>>,
        gravitational_constant: f64,
        vector_path: &str,
    ) -> PyResult<Self> {
        // A path that the machine lacks has been refused with the system.
        let arch = VectorPath::named(vector_path)?.arch().unwrap_or(Arch::Scalar);
        let bodies: Vec<_> = bodies.iter().map(|body| body.inner.clone()).collect();
        let fields = listening(py, |patience| {
            bodies.iter().map(|body| BodyField::new(body, gravitational_constant, arch, patience)).collect()
        })?;
        Ok(Self { fields, arch })
    }

    /// At points (P, 3) the potential (P,) and the field (P, 3), or the gradient (P, 3, 3) alone. The bodies are where the state
    /// of each point, a place (P,) in positions (K N, 3) and attitudes (K N, 4), has them. Errors count points in a shape.
    #[expect(clippy::too_many_arguments)]
    fn gravity<'py>(
        &self,
        py: Python<'py>,
        positions: PyReadonlyArrayDyn<'py, f64>,
        attitudes: PyReadonlyArrayDyn<'py, f64>,
        states: PyReadonlyArray1<'py, i64>,
        points: PyReadonlyArray2<'py, f64>,
        shape: Vec<usize>,
        body: Option<usize>,
        gradient: bool,
    ) -> PyResult<Vec<Array<'py>>> {
        let (points, states) = (points.as_slice()?, states.as_slice()?);
        let (positions, attitudes) = (vectors("positions", &positions)?, rows::<4>("attitudes", &attitudes)?);
        let query = Query { positions, attitudes, states, points, shape: &shape, body };
        let count = states.len();
        // Memory of numpy's own comes in large pages, which many points are filled in the faster for.
        let zeros = |shape: &[usize]| PyArrayDyn::<f64>::zeros(py, shape, false);
        if gradient {
            let all = zeros(&[count, 3, 3]);
            let mut write = all.try_readwrite()?;
            let wanted = Wanted::Gradient(write.as_slice_mut()?);
            listening(py, |patience| self.each(&query, wanted, patience))?;
            return Ok(vec![all]);
        }
        let (potential, field) = (zeros(&[count]), zeros(&[count, 3]));
        let (mut first, mut second) = (potential.try_readwrite()?, field.try_readwrite()?);
        let wanted = Wanted::Field(first.as_slice_mut()?, second.as_slice_mut()?);
        listening(py, |patience| self.each(&query, wanted, patience))?;
        Ok(vec![potential, field])
    }
}

impl PyAttraction {
    /// The gravity at the points, those of one state after the other.
    fn each(&self, query: &Query<'_>, wanted: Wanted<'_>, patience: &mut Patience) -> Result<(), Error> {
        let (mut wanted, mut before) = (wanted, 0);
        let bodies = self.fields.len();
        for states in query.states.chunk_by(|one, next| one == next) {
            let places = query.body.map_or(0..bodies, |body| body..body + 1);
            let attractors: Vec<_> = places
                .map(|body| {
                    let row = states[0] as usize * bodies + body;
                    Attractor {
                        field: &self.fields[body],
                        position: query.positions[row],
                        rotation: rotation::matrix(query.attitudes[row]),
                    }
                })
                .collect();
            let end = before + states.len();
            let (now, later) = wanted.split_at(states.len());
            let coordinates = &query.points[3 * before..3 * end];
            let points = Points { coordinates, shape: query.shape, before };
            points.gravity(&attractors, now, self.arch, patience)?;
            (wanted, before) = (later, end);
        }
        Ok(())
    }
}
