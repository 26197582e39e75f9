//! Conversion of Kepler elements, many at a time.

use super::arrays::{array, from_vectors, rows, vectors};
use super::listening::listening;
use crate::errors::Result;
use fullbody::error::Error;
use fullbody::orbit::KeplerElements;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Units of work of a conversion.
const WORK: u64 = 20;

fn elements(row: [f64; 6]) -> Result<KeplerElements, Error> {
    let [a, e, i, node, periapsis, anomaly] = row;
    KeplerElements::new(a, e, i, node, periapsis, anomaly)
}

/// Returns positions and velocities (K, 3) for elements (K, 6).
#[pyfunction]
pub fn elements_to_cartesian<'py>(
    py: Python<'py>,
    values: PyReadonlyArrayDyn<'py, f64>,
    mu: f64,
) -> Result<(Array<'py>, Array<'py>)> {
    let rows = rows::<6>("elements", &values)?;
    let (positions, velocities): (Vec<_>, Vec<_>) = listening(py, |interrupt| {
        let convert = |row| {
            interrupt.charge(WORK, 0.0)?;
            elements(row)?.to_cartesian(mu)
        };
        rows.into_iter().map(convert).collect::<Result<Vec<_>, Error>>()
    })?
    .into_iter()
    .unzip();
    Ok((from_vectors(py, &positions)?, from_vectors(py, &velocities)?))
}

/// Returns elements (K, 6) for positions and velocities (K, 3).
#[pyfunction]
pub fn cartesian_to_elements<'py>(
    py: Python<'py>,
    position: PyReadonlyArrayDyn<'py, f64>,
    velocity: PyReadonlyArrayDyn<'py, f64>,
    mu: f64,
) -> Result<Array<'py>> {
    let (position, velocity) = (vectors("position", &position)?, vectors("velocity", &velocity)?);
    if position.len() != velocity.len() {
        let expected = format!("{}, as of positions", position.len());
        return Err(Error::invalid("number of velocities", velocity.len(), expected).into());
    }
    let values = listening(py, |interrupt| {
        let mut values = Vec::with_capacity(6 * position.len());
        for (r, v) in position.iter().zip(&velocity) {
            interrupt.charge(WORK, 0.0)?;
            let k = KeplerElements::from_cartesian(r, v, mu)?;
            values.extend([
                k.semi_major_axis,
                k.eccentricity,
                k.inclination,
                k.longitude_of_node,
                k.argument_of_periapsis,
                k.mean_anomaly,
            ]);
        }
        Ok(values)
    })?;
    array(py, values, &[position.len(), 6])
}

/// Returns orbital periods (K,) for elements (K, 6).
#[pyfunction]
pub fn period<'py>(py: Python<'py>, values: PyReadonlyArrayDyn<'py, f64>, mu: f64) -> Result<Array<'py>> {
    let values = rows::<6>("elements", &values)?;
    let periods = values.into_iter().map(|row| elements(row)?.period(mu)).collect::<Result<Vec<_>, _>>()?;
    let count = periods.len();
    array(py, periods, &[count])
}
