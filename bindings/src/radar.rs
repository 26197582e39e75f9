//! The radar echoes of bodies.

use super::arrays::{array, rows, vectors};
use super::bodies::PyBody;
use super::listening::listening;
use super::photometry::Epochs;
use crate::errors::Result;
use fullbody::error::Error;
use fullbody::radar::{Bins, BodyEcho, EchoView, Law, Radar};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;

/// Bodies with their radar scattering laws, for which echoes at any number of epochs are computed.
#[pyclass(frozen, name = "Radar", module = "fullbody._core")]
pub struct PyRadar {
    inner: Radar,
}

/// A scattering law: its name, C, R, and the angle of incidence from which on nothing is reflected.
type PyLaw = (String, f64, f64, f64);

fn law((name, c, reflectivity, cutoff): PyLaw) -> Result<Law, Error> {
    match name.as_str() {
        "cosine" => Law::cosine(c, reflectivity),
        "gaussian" => Law::gaussian(c, reflectivity, cutoff),
        "hagfors" => Law::hagfors(c, reflectivity, cutoff),
        _ => Err(Error::invalid("name of a radar scattering law", name, "cosine, gaussian or hagfors")),
    }
}

#[pymethods]
impl PyRadar {
    #[new]
    fn new(bodies: Vec<PyRef<'_, PyBody>>, laws: Vec<PyLaw>, mutual: bool) -> Result<Self> {
        let laws = bodies.iter().zip(laws).map(|(body, given)| {
            law(given)
                .map_err(|error| error.of(&format!("the radar scattering law of {}", body.inner.name())))
        });
        let laws = laws.collect::<Result<_, _>>()?;
        let bodies = bodies.iter().map(|body| body.inner.clone()).collect();
        Ok(Self { inner: Radar::new(bodies, laws, mutual)? })
    }

    /// Returns the cross section (K, N, D, F) in bins of delay and frequency, with D = 1 without edges of delay.
    /// The epochs are those of a photometer, with the transmitter in place of the Sun. The echoes of the bodies'
    /// centres have frequencies and delays (K N, 2), and these have gradients along the surface (K N, 6).
    fn echo<'py>(
        &self,
        py: Python<'py>,
        epochs: Epochs<'py>,
        at_centre: PyReadonlyArrayDyn<'py, f64>,
        gradients: PyReadonlyArrayDyn<'py, f64>,
        frequencies: Vec<f64>,
        delays: Vec<f64>,
    ) -> Result<Bound<'py, PyArrayDyn<f64>>> {
        let count = self.inner.bodies().len();
        let epoch_data = epochs.read(count)?;
        let times = epoch_data.times.len();
        let (at_centre, gradients) = (rows::<2>("at_centre", &at_centre)?, vectors("gradients", &gradients)?);
        for (what, length, expected) in
            [("at_centre", at_centre.len(), times * count), ("gradients", gradients.len(), 2 * times * count)]
        {
            if length != expected {
                return Err(Error::invalid(format!("rows of {what}"), length, expected.to_string()).into());
            }
        }
        let echoes: Vec<BodyEcho> = at_centre
            .into_iter()
            .zip(gradients.as_chunks::<2>().0)
            .map(|(at_centre, gradients)| BodyEcho { at_centre, gradients: *gradients })
            .collect();
        let bins = Bins::new(&frequencies, &delays)?;
        let views: Vec<EchoView<'_>> = epoch_data
            .views(count)
            .into_iter()
            .zip(echoes.chunks_exact(count))
            .map(|(view, echoes)| EchoView { view, echoes })
            .collect();
        let power = listening(py, |interrupt| self.inner.echo(&views, &bins, interrupt))?;
        let shape = [times, count, delays.len().saturating_sub(1).max(1), frequencies.len() - 1];
        array(py, power, &shape)
    }
}
