//! The gravity of bodies at points.

use super::arrays::{rows, vectors};
use super::bodies::PyBody;
use super::listening::listening;
use crate::errors::Result;
use fullbody::error::Error;
use fullbody::gravity::{Attractor, BodyField, GravityOutput, Points};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::Vec3;
use fullbody::math::lanes::VectorPath;
use fullbody::math::rotation;
use fullbody::names::Named;
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArrayDyn, PyReadwriteArrayDyn};
use pulp::Arch;
use pyo3::prelude::*;
use std::ops::Range;

/// The gravity of bodies, prepared for evaluation at points.
#[pyclass(frozen, name = "Attraction", module = "fullbody._core")]
pub struct PyAttraction {
    fields: Vec<BodyField>,
    arch: Arch,
}

/// Points, each with the state to which it belongs.
struct Query<'a> {
    /// The positions and attitudes of all bodies, state by state.
    positions: Vec<Vec3>,
    attitudes: Vec<[f64; 4]>,
    /// The index of the state of each point, where there are several states.
    states: Option<&'a [i64]>,
    points: &'a [f64],
    /// The shape of the caller's array of points.
    shape: &'a [usize],
    /// The one body whose gravity is requested.
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
    ) -> Result<Self> {
        // A path that the machine lacks has been refused with the system.
        let arch = VectorPath::named(vector_path)?.arch().unwrap_or(Arch::Scalar);
        let bodies: Vec<_> = bodies.iter().map(|body| body.inner.clone()).collect();
        let fields = listening(py, |interrupt| {
            bodies.iter().map(|body| BodyField::new(body, gravitational_constant, arch, interrupt)).collect()
        })?;
        Ok(Self { fields, arch })
    }

    /// Fills arrays at points (P, 3): the potential (P,) and the field (P, 3), or the gradient (P, 3, 3)
    /// alone, depending on the number of arrays. The index (P,) of each point's state selects the bodies'
    /// positions (K N, 3) and attitudes (K N, 4); without indices there is one state. Errors name points by
    /// their index in an array of the given shape.
    #[expect(clippy::too_many_arguments)]
    fn gravity(
        &self,
        py: Python<'_>,
        positions: PyReadonlyArrayDyn<'_, f64>,
        attitudes: PyReadonlyArrayDyn<'_, f64>,
        states: Option<PyReadonlyArray1<'_, i64>>,
        points: PyReadonlyArray2<'_, f64>,
        shape: Vec<usize>,
        body: Option<usize>,
        mut out: Vec<PyReadwriteArrayDyn<'_, f64>>,
    ) -> Result<()> {
        let points = points.as_slice()?;
        let states = states.as_ref().map(|states| states.as_slice()).transpose()?;
        let (positions, attitudes) = (vectors("positions", &positions)?, rows::<4>("attitudes", &attitudes)?);
        let query = Query { positions, attitudes, states, points, shape: &shape, body };
        let output = match out.as_mut_slice() {
            [potential, field] => GravityOutput::Field(potential.as_slice_mut()?, field.as_slice_mut()?),
            [gradient] => GravityOutput::Gradient(gradient.as_slice_mut()?),
            others => {
                return Err(Error::invalid("out", format!("{} arrays", others.len()), "one or two").into());
            }
        };
        listening(py, |interrupt| self.by_state(&query, output, interrupt))
    }
}

impl PyAttraction {
    /// Evaluates the gravity at the points, state by state.
    fn by_state(
        &self,
        query: &Query<'_>,
        output: GravityOutput<'_>,
        interrupt: &mut InterruptCheck,
    ) -> Result<(), Error> {
        let Some(states) = query.states else {
            return query.points_of(0..query.points.len() / 3).gravity(
                &self.attractors(query, 0),
                output,
                self.arch,
                interrupt,
            );
        };
        let (mut output, mut first_index) = (output, 0);
        for states in states.chunk_by(|one, next| one == next) {
            let end = first_index + states.len();
            let (now, later) = output.split_at(states.len());
            let attractors = self.attractors(query, states[0] as usize);
            query.points_of(first_index..end).gravity(&attractors, now, self.arch, interrupt)?;
            (output, first_index) = (later, end);
        }
        Ok(())
    }

    /// Returns the requested bodies, placed as they are in a state.
    fn attractors(&self, query: &Query<'_>, state: usize) -> Vec<Attractor<'_>> {
        let bodies = self.fields.len();
        let indices = query.body.map_or(0..bodies, |body| body..body + 1);
        indices
            .map(|body| {
                let row = state * bodies + body;
                let (position, rotation) = (query.positions[row], rotation::matrix(query.attitudes[row]));
                Attractor { field: &self.fields[body], position, rotation }
            })
            .collect()
    }
}

impl Query<'_> {
    fn points_of(&self, range: Range<usize>) -> Points<'_> {
        let coordinates = &self.points[3 * range.start..3 * range.end];
        Points { coordinates, shape: self.shape, first_index: range.start }
    }
}
