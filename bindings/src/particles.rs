//! Flights of particles.

use super::arrays::{array, from_vectors, vectors};
use super::descriptions::from_python;
use super::listening::{Listener, listening};
use super::runs::{PyDense, Sampling};
use super::systems::{PyState, PySystem};
use crate::errors::Result;
use fullbody::error::Error;
use fullbody::math::Vec3;
use fullbody::particles::{
    BodySurface, ContactResponse, Escape, Fate, FlightPlan, FlightRecord, Particle, ParticleCondition,
    ParticleEvent, ParticleFunction, Radiation, Rules, visible_from,
};
use fullbody::trajectory::{Integrator, Output, Progress};
use numpy::{PyArrayDyn, PyReadonlyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::num::NonZeroUsize;
use std::sync::Arc;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// The particles of a flight: time, positions (P, 3), velocities (P, 3), area-to-mass ratios (P,).
type ParticleArrays<'py> =
    (f64, PyReadonlyArrayDyn<'py, f64>, PyReadonlyArrayDyn<'py, f64>, PyReadonlyArray1<'py, f64>);

/// The response to a contact: `"stop"`, `"remove"`, or the numbers of a bounce.
#[derive(FromPyObject)]
pub enum PyContactResponse {
    Bounce(f64, f64, f64),
    Named(String),
}

/// An event: `"shadow"` with the visible part of the disc, `"periapsis"` with the body's index, or
/// `"function"` with the function; then the direction.
type ParticleEventSpec<'py> = (String, Bound<'py, PyAny>, i8);

/// Flies particles along a run. Returns the record, and the error that ended the flight early, if any.
///
/// The GIL is released; about every 25 ms it is taken to check for Ctrl-C and to call `progress(start, time,
/// end)`.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn fly<'py>(
    py: Python<'py>,
    system: &PySystem,
    dense: &PyDense,
    particles: ParticleArrays<'py>,
    until: f64,
    output: Sampling<'py>,
    integrator: &Bound<'py, PyDict>,
    contact: PyContactResponse,
    escape: Option<(f64, bool)>,
    radiation: Option<(String, f64, f64)>,
    spec: Vec<ParticleEventSpec<'py>>,
    threads: Option<NonZeroUsize>,
    progress: Option<Py<PyAny>>,
) -> Result<(Bound<'py, PyDict>, Option<PyErr>)> {
    let integrator: Integrator = from_python(integrator)?;
    let Some((tableau, tolerance)) = integrator.pair() else {
        let expected = "one with step control, such as Verner98";
        return Err(Error::invalid("integrator", "one of fixed steps", expected).into());
    };
    let (start, positions, velocities, ratios) = particles;
    let (positions, velocities) = (vectors("position", &positions)?, vectors("velocity", &velocities)?);
    let ratios = ratios.as_array().to_vec();
    let output = match Output::from(output) {
        Output::Steps => Vec::new(),
        output => output.times(start, until)?,
    };
    let rules = Rules {
        tableau,
        tolerance,
        contact: match contact {
            PyContactResponse::Bounce(normal, tangential, rest) => {
                ContactResponse::Bounce { normal, tangential, rest }
            }
            PyContactResponse::Named(name) if name == "remove" => ContactResponse::Remove,
            PyContactResponse::Named(_) => ContactResponse::Stop,
        },
        escape: escape.map(|(distance, unbound)| Escape { distance, unbound }),
    };
    let radiation = radiation.map(|(by, strength, radius)| Radiation { by, strength, radius });
    let listener = Arc::new(Listener::default());
    let events = spec.into_iter().map(|spec| event(spec, &listener)).collect::<Result<Vec<_>>>()?;
    let mut flying: Vec<Particle> = positions
        .iter()
        .zip(&velocities)
        .zip(&ratios)
        .map(|((x, v), ratio)| Particle::new(start, x, v, *ratio))
        .collect();
    drop((positions, velocities, ratios));
    let mut record = FlightRecord::default();
    let plan = FlightPlan {
        system: &system.inner,
        dense: &dense.inner,
        until,
        output: &output,
        rules: &rules,
        radiation: radiation.as_ref(),
        events: &events,
        threads,
    };
    let outcome = py.detach(|| {
        let mut hook = |p: Progress| {
            listener.ask(|py| {
                if let Some(progress) = &progress {
                    progress.call1(py, (p.start, p.time, p.end))?;
                }
                Ok(())
            })
        };
        plan.fly(&mut flying, &mut record, &mut hook)
    });
    let error = outcome.err().map(|error| listener.explain(error));
    Ok((arrays(py, &flying, record, &output)?, error))
}

/// Returns the outermost points (P, 3) of a body's surface in directions (P, 3) from its centre, and the
/// outward normals, in the body frame.
#[pyfunction]
pub fn surface<'py>(
    py: Python<'py>,
    system: &PySystem,
    body: usize,
    directions: PyReadonlyArrayDyn<'py, f64>,
) -> Result<(Array<'py>, Array<'py>)> {
    let body = &system.inner.bodies()[body];
    body.require_surface()?;
    let surface = BodySurface::new(body);
    let directions = vectors("directions", &directions)?;
    let (points, normals): (Vec<_>, Vec<_>) = listening(py, |interrupt| {
        let outermost = |direction: &Vec3| {
            interrupt.charge(surface.work(), 0.0)?;
            surface.outermost(direction).ok_or_else(|| {
                let expected = "a body with a surface in all directions from its centre";
                Error::invalid("body", format!("{:?}", body.name()), expected)
            })
        };
        directions.iter().map(outermost).collect::<Result<Vec<_>, _>>()
    })?
    .into_iter()
    .unzip();
    Ok((from_vectors(py, &points)?, from_vectors(py, &normals)?))
}

/// Returns the visible part (P,) of a third body's disc from points (P, 3) in a state.
#[pyfunction]
pub fn visible<'py>(
    py: Python<'py>,
    system: &PySystem,
    state: &PyState,
    radiation: (String, f64, f64),
    points: PyReadonlyArrayDyn<'py, f64>,
) -> Result<Array<'py>> {
    let (by, strength, radius) = radiation;
    let (radiation, points) = (Radiation { by, strength, radius }, vectors("points", &points)?);
    let parts =
        listening(py, |interrupt| visible_from(&system.inner, &state.inner, &radiation, &points, interrupt))?;
    let count = parts.len();
    array(py, parts, &[count])
}

/// Returns the record as arrays by their names.
fn arrays<'py>(
    py: Python<'py>,
    particles: &[Particle],
    record: FlightRecord,
    output: &[f64],
) -> Result<Bound<'py, PyDict>> {
    let (p, k) = (particles.len(), output.len());
    let dict = PyDict::new(py);
    dict.set_item("time", array(py, output.to_vec(), &[k])?)?;
    dict.set_item("samples", array(py, record.samples, &[p, k, 6])?)?;
    let per_particle = |number: &dyn Fn(&Particle) -> f64| particles.iter().map(number).collect::<Vec<f64>>();
    let set = |name: &str, number: &dyn Fn(&Particle) -> f64| -> Result<()> {
        Ok(dict.set_item(name, array(py, per_particle(number), &[p])?)?)
    };
    set("fate_time", &|particle| particle.end.time)?;
    set("longitude", &|particle| particle.end.longitude)?;
    set("latitude", &|particle| particle.end.latitude)?;
    set("speed", &|particle| particle.end.speed)?;
    set("incidence", &|particle| particle.end.incidence)?;
    set("last_time", &|particle| particle.time)?;
    let motion: Vec<f64> = particles.iter().flat_map(|particle| particle.motion).collect();
    dict.set_item("last", array(py, motion, &[p, 6])?)?;
    let number = |fate: Fate| Fate::ALL.iter().position(|(_, other)| *other == fate).unwrap_or(0) as i8;
    let fates: Vec<i8> = particles.iter().map(|particle| number(particle.end.fate)).collect();
    dict.set_item("fate", numpy::PyArray1::from_vec(py, fates))?;
    let body = |particle: &Particle| particle.end.body.map_or(-1, |body| body as i32);
    dict.set_item(
        "fate_body",
        numpy::PyArray1::from_vec(py, particles.iter().map(body).collect::<Vec<i32>>()),
    )?;
    let strikes: Vec<u32> = particles.iter().map(|particle| particle.strikes).collect();
    dict.set_item("strikes", numpy::PyArray1::from_vec(py, strikes))?;
    let occurrences = record.occurrences;
    let n = occurrences.len();
    let vectors = |f: fn(&fullbody::particles::ParticleOccurrence) -> &Vec3| {
        occurrences.iter().map(f).flat_map(|v| [v.x, v.y, v.z]).collect::<Vec<f64>>()
    };
    dict.set_item("event", occurrences.iter().map(|h| h.event).collect::<Vec<_>>())?;
    dict.set_item("event_particle", occurrences.iter().map(|h| h.particle).collect::<Vec<_>>())?;
    dict.set_item("event_rising", occurrences.iter().map(|h| h.rising).collect::<Vec<_>>())?;
    dict.set_item("event_time", array(py, occurrences.iter().map(|h| h.time).collect(), &[n])?)?;
    dict.set_item("event_position", array(py, vectors(|h| &h.position), &[n, 3])?)?;
    dict.set_item("event_velocity", array(py, vectors(|h| &h.velocity), &[n, 3])?)?;
    Ok(dict)
}

/// Makes the core's event. The first exception of a function goes to `listener`.
fn event((kind, what, direction): ParticleEventSpec<'_>, listener: &Arc<Listener>) -> Result<ParticleEvent> {
    let condition = match kind.as_str() {
        "shadow" => ParticleCondition::Shadow { visible: what.extract()? },
        "periapsis" => ParticleCondition::Periapsis { body: what.extract()? },
        _ => {
            let (listener, f) = (listener.clone(), what.unbind());
            let function: Box<ParticleFunction> = Box::new(move |time, position, velocity| {
                let arguments = |v: &Vec3| [v.x, v.y, v.z];
                let value = Python::attach(|py| {
                    f.call1(py, (time, arguments(position), arguments(velocity)))?.extract::<f64>(py)
                });
                value.map_err(|error| {
                    listener.keep(error);
                    Error::invalid("value of an event's function", "an exception", "a number")
                })
            });
            ParticleCondition::Function(function)
        }
    };
    Ok(ParticleEvent { condition, direction })
}
