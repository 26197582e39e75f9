//! A simulation as bytes, exactly.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `FULLBODY` |
//! | 4 | version of the layout, little-endian |
//! | 8 | length of the contents |
//! | 4 | CRC-32 of the contents |
//! | | the contents in the postcard format |
//!
//! The contents hold all that decides how a run goes on: the bodies, the low parts of the vector, the controller's memory, the
//! quadrature rules in force. A run that goes on from them equals the unbroken one bit for bit, on a machine with
//! the same vector instructions.

use super::motion::Motion;
use super::mover::Mover;
use super::{Integrator, Simulation};
use crate::dynamics::{AttitudeChart, Inner, Settings, System};
use crate::error::{Error, Result};
use crate::integrate::{Memory, Scheme, Tolerance};
use crate::math::lanes::VectorPath;
use crate::mutual::RuleMemory;
use crate::patience::Patience;
use crate::quadrature::Order;
use crate::shape::{Body, Shape};
use serde::{Deserialize, Serialize};

/// The layout that is written. Earlier ones are still read.
pub const ARCHIVE_VERSION: u32 = 1;

const MAGIC: &[u8; 8] = b"FULLBODY";
const HEADER: usize = 24;

/// Layout 1. Its fields and theirs stay as they are: a change is a new layout.
#[derive(Serialize, Deserialize)]
struct Contents {
    producer: String,
    bodies: Vec<BodyData>,
    gravitational_constant: f64,
    gravity: String,
    gravity_tolerance: f64,
    order: Option<[u32; 2]>,
    chart: u8,
    vector_path: u8,
    integrator: String,
    parameters: [f64; 2],
    epoch: f64,
    barycentre: [f64; 3],
    barycentre_velocity: [f64; 3],
    scales: Vec<[f64; 3]>,
    rules: Vec<Option<RuleMemory>>,
    memory: Memory,
    loads: Option<Vec<[f64; 6]>>,
}

#[derive(Serialize, Deserialize)]
struct BodyData {
    name: String,
    semi_axes: Option<[f64; 3]>,
    mass: f64,
}

const CHARTS: [AttitudeChart; 2] = [AttitudeChart::Quaternion, AttitudeChart::TaitBryan];
const PATHS: [VectorPath; 4] = [VectorPath::Auto, VectorPath::Portable, VectorPath::Avx2, VectorPath::Avx512];

impl Simulation {
    /// The simulation as bytes.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let system = self.system();
        let settings = system.settings();
        let place = |found: Option<usize>| found.unwrap_or_default() as u8;
        let (integrator, parameters) = describe(self.integrator);
        let (memory, loads) = self.mover.memory();
        let contents = Contents {
            producer: format!("fullbody {}", env!("CARGO_PKG_VERSION")),
            bodies: system
                .bodies()
                .iter()
                .map(|body| BodyData {
                    name: body.name.clone(),
                    semi_axes: match body.shape {
                        Shape::Ellipsoid(e) => Some(e.semi_axes()),
                        Shape::Point => None,
                    },
                    mass: body.mass,
                })
                .collect(),
            gravitational_constant: system.gravitational_constant(),
            gravity: settings.gravity.to_string(),
            gravity_tolerance: settings.gravity_tolerance,
            order: settings.order.map(|order| [order.gauss as u32, order.angles as u32]),
            chart: place(CHARTS.iter().position(|chart| *chart == settings.attitude_chart)),
            vector_path: place(PATHS.iter().position(|path| *path == settings.vector_path)),
            integrator: integrator.to_owned(),
            parameters,
            epoch: self.inner.epoch,
            barycentre: self.inner.barycentre,
            barycentre_velocity: self.inner.barycentre_velocity,
            scales: self.motion.initial.clone(),
            rules: self.motion.equations.memory(),
            memory,
            loads,
        };
        let contents = postcard::to_stdvec(&contents)
            .map_err(|error| Error::invalid("a simulation", error, "one that an archive can hold"))?;
        let mut bytes = Vec::with_capacity(HEADER + contents.len());
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&ARCHIVE_VERSION.to_le_bytes());
        bytes.extend_from_slice(&(contents.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&crc32fast::hash(&contents).to_le_bytes());
        bytes.extend_from_slice(&contents);
        Ok(bytes)
    }

    /// The simulation that [`Self::to_bytes`] wrote; says what is wrong with bytes that it did not.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let contents: Contents = postcard::from_bytes(contents(bytes)?)
            .map_err(|error| refuse(format!("unreadable ({error})"), "the contents of layout 1"))?;
        contents.restore()
    }
}

/// The contents behind a sound header.
fn contents(bytes: &[u8]) -> Result<&[u8]> {
    if bytes.len() < MAGIC.len() || !bytes.starts_with(MAGIC) {
        return Err(refuse("something else".to_owned(), "a file that begins with FULLBODY"));
    }
    let Some((header, contents)) = bytes.split_at_checked(HEADER) else {
        return Err(refuse(format!("{} bytes long", bytes.len()), "a header of 24 bytes: it is truncated"));
    };
    let number = |from: usize, to: usize| {
        header[from..to].iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte))
    };
    let (version, length, checksum) = (number(8, 12), number(12, 20), number(20, 24));
    if version != u64::from(ARCHIVE_VERSION) {
        let expected = format!("layout {ARCHIVE_VERSION}; a newer fullbody may read it");
        return Err(refuse(format!("of layout {version}"), &expected));
    }
    if contents.len() as u64 != length {
        let what = if (contents.len() as u64) < length { "truncated" } else { "too long" };
        return Err(refuse(
            format!("{what}: {} bytes of contents", contents.len()),
            &format!("{length} bytes"),
        ));
    }
    let found = crc32fast::hash(contents);
    if u64::from(found) != checksum {
        return Err(refuse(
            format!("altered: its checksum is {found:08x}"),
            &format!("the checksum {checksum:08x} that it was written with"),
        ));
    }
    Ok(contents)
}

fn refuse(value: String, expected: &str) -> Error {
    Error::invalid("the archive", value, expected)
}

impl Contents {
    fn restore(self) -> Result<Simulation> {
        let bodies = self
            .bodies
            .iter()
            .map(|body| {
                let shape = body.semi_axes.map_or(Ok(Shape::Point), Shape::ellipsoid)?;
                Body::with_mass(body.name.clone(), shape, body.mass)
            })
            .collect::<Result<Vec<_>>>()?;
        let unknown = |what: &str, value: u8| refuse(format!("of {what} {value}"), "a known one");
        let settings = Settings {
            gravity: self.gravity.parse()?,
            gravity_tolerance: self.gravity_tolerance,
            order: self.order.map(|[gauss, angles]| Order { gauss: gauss as usize, angles: angles as usize }),
            attitude_chart: *CHARTS
                .get(usize::from(self.chart))
                .ok_or_else(|| unknown("chart", self.chart))?,
            vector_path: *PATHS
                .get(usize::from(self.vector_path))
                .ok_or_else(|| unknown("vector path", self.vector_path))?,
        };
        let system = System::new(bodies, self.gravitational_constant, settings)?;
        let layout = system.layout();
        let dimension = layout.dimension();
        let sound = self.memory.high.len() == dimension
            && self.memory.low.len() == dimension
            && self.scales.len() == layout.bodies
            && self.loads.as_ref().is_none_or(|loads| loads.len() == layout.bodies);
        if !sound {
            return Err(refuse(
                "of vectors that do not fit its bodies".to_owned(),
                &format!("{dimension} numbers"),
            ));
        }
        let integrator = recognise(&self.integrator, self.parameters)?;
        let inner = Inner {
            layout,
            high: self.memory.high.clone(),
            low: self.memory.low.clone(),
            epoch: self.epoch,
            barycentre: self.barycentre,
            barycentre_velocity: self.barycentre_velocity,
        };
        let mut motion = Motion::new(system.dynamics(&mut Patience::endless())?, &inner.high);
        motion.initial = self.scales;
        motion.equations.recall(&self.rules)?;
        let mut mover = Mover::new(integrator, &motion, &inner, self.memory.time[0])?;
        mover.recall(&self.memory, self.loads.as_deref());
        Ok(Simulation { motion, inner, integrator, mover })
    }
}

fn describe(integrator: Integrator) -> (&'static str, [f64; 2]) {
    let pair = |name, t: Tolerance| (name, [t.relative, t.absolute]);
    match integrator {
        Integrator::DormandPrince54(t) => pair("DormandPrince54", t),
        Integrator::Verner65(t) => pair("Verner65", t),
        Integrator::Verner76(t) => pair("Verner76", t),
        Integrator::Verner87(t) => pair("Verner87", t),
        Integrator::Verner98(t) => pair("Verner98", t),
        Integrator::LieGroupVariational { step } => ("LieGroupVariational", [step, 0.0]),
        Integrator::SymplecticSplitting { step, scheme } => (scheme.name(), [step, 0.0]),
    }
}

fn recognise(name: &str, [first, second]: [f64; 2]) -> Result<Integrator> {
    // A splitting is written under its scheme's name.
    match name.parse::<Scheme>() {
        Ok(scheme) => Ok(Integrator::SymplecticSplitting { step: first, scheme }),
        Err(_) => Integrator::named(name, (first, second), first, ""),
    }
}
