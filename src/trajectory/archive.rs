//! A simulation as bytes, exactly.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `FULLBODY` |
//! | 4 | number of the format, little-endian |
//! | 8 | length of the contents |
//! | 4 | CRC-32 of the contents |
//! | | the contents in the postcard format |
//!
//! The contents hold the description as text and, in binary, all numbers on which the continuation of the run depends.
//! A run that is resumed from them equals the uninterrupted run bit for bit on a machine with the same vector
//! instructions.

use super::checkpoint::Checkpoint;
use super::motion::Motion;
use super::propagator::Propagator;
use super::{Integrator, Simulation};
use crate::dynamics::{BarycentricFrame, Invariants, Settings, State, System};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::forces::{Call, Force};
use crate::interrupt::InterruptCheck;
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// The number of the format that is written, and the only one that is read.
pub const ARCHIVE_FORMAT: u32 = 2;

const MAGIC: &[u8; 8] = b"FULLBODY";
const HEADER: usize = 24;

/// The description of a simulation: everything that it was made with. Archives contain it, and the Python
/// package makes its own objects from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationDescription {
    /// The bodies.
    pub bodies: Vec<Body>,
    /// The gravitational constant.
    #[serde(rename = "G")]
    pub gravitational_constant: f64,
    /// The settings of gravity and attitudes.
    pub settings: Settings,
    /// The external forces.
    pub forces: Vec<Force>,
    /// The integrator.
    pub integrator: Integrator,
}

/// The contents of format 2. A change of these fields, or of those of their types, makes a new format.
#[derive(Serialize, Deserialize)]
struct Contents {
    producer: String,
    /// The [`SimulationDescription`] as JSON: everything in it has a name.
    description: String,
    /// The text that the caller keeps with the simulation.
    notes: String,
    start: Start,
    present: Checkpoint,
}

/// The numbers at the start on which the whole run depends, and those against which drifts are measured.
#[derive(Serialize, Deserialize)]
struct Start {
    /// The [`BarycentricFrame`]: time, position and velocity of the barycentre.
    epoch: f64,
    barycentre: [f64; 3],
    barycentre_velocity: [f64; 3],
    /// For each body the scales of position, velocity and spin, to which absolute tolerances refer.
    scales: Vec<[f64; 3]>,
    /// The conserved quantities at the start, as [`Invariants::numbers`] returns them.
    conserved: [f64; 8],
}

impl Start {
    /// Returns an error for numbers with which no simulation starts.
    fn check(&self) -> Result<()> {
        require_finite("epoch of a simulation", &[self.epoch])?;
        require_finite("barycentre of a simulation", &self.barycentre)?;
        require_finite("velocity of the barycentre of a simulation", &self.barycentre_velocity)?;
        let scales = self.scales.iter().flatten();
        scales.copied().try_for_each(|scale| require_positive("scale of a simulation", scale))?;
        require_finite("conserved quantities of a simulation", &self.conserved)
    }
}

impl Simulation {
    /// Returns the description of the simulation.
    pub fn description(&self) -> SimulationDescription {
        let system = self.system();
        SimulationDescription {
            bodies: system.bodies().to_vec(),
            gravitational_constant: system.gravitational_constant(),
            settings: *system.settings(),
            forces: system.forces().to_vec(),
            integrator: self.integrator,
        }
    }

    /// Writes the simulation as bytes.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a simulation that an archive cannot hold.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let unwritable = |error: &dyn std::fmt::Display| {
            Error::invalid("a simulation", error, "one that an archive can hold")
        };
        let contents = Contents {
            producer: format!("fullbody {}", env!("CARGO_PKG_VERSION")),
            description: serde_json::to_string(&self.description()).map_err(|error| unwritable(&error))?,
            notes: self.notes.clone(),
            start: Start {
                epoch: self.frame().epoch,
                barycentre: self.frame().barycentre,
                barycentre_velocity: self.frame().barycentre_velocity,
                scales: self.motion.initial.clone(),
                conserved: self.start.numbers(),
            },
            present: self.checkpoint(),
        };
        let contents = postcard::to_stdvec(&contents).map_err(|error| unwritable(&error))?;
        let mut bytes = Vec::with_capacity(HEADER + contents.len());
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&ARCHIVE_FORMAT.to_le_bytes());
        bytes.extend_from_slice(&(contents.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&crc32fast::hash(&contents).to_le_bytes());
        bytes.extend_from_slice(&contents);
        Ok(bytes)
    }

    /// Reads a simulation that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] says what is wrong with other bytes, or names a force that is a function, and
    /// [`Error::Interrupted`](crate::error::Error::Interrupted).
    pub fn from_bytes(bytes: &[u8], interrupt: &mut InterruptCheck) -> Result<Self> {
        Self::from_bytes_with(bytes, |_| None, interrupt)
    }

    /// Reads a simulation with forces that are functions, which an archive cannot hold: `functions` returns
    /// the function of a force by its name.
    ///
    /// # Errors
    /// Returns the errors of [`Self::from_bytes`]; a function is missing where `functions` returns `None`.
    pub fn from_bytes_with(
        bytes: &[u8],
        functions: impl Fn(&str) -> Option<Call>,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        read(bytes)?.restore(functions, interrupt)
    }

    /// Returns the description of the simulation in such bytes, and the text that is kept with it.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] says what is wrong with other bytes.
    pub fn described(bytes: &[u8]) -> Result<(SimulationDescription, String)> {
        let contents = read(bytes)?;
        Ok((contents.description()?, contents.notes))
    }
}

fn read(bytes: &[u8]) -> Result<Contents> {
    let expected = format!("the contents of format {ARCHIVE_FORMAT}");
    let (contents, trailing): (Contents, _) = postcard::take_from_bytes(contents(bytes)?)
        .map_err(|error| refuse(format!("unreadable ({error})"), &expected))?;
    if !trailing.is_empty() {
        return Err(refuse(format!("of {} bytes more than its contents", trailing.len()), &expected));
    }
    Ok(contents)
}

/// Checks the header and returns the contents behind it.
fn contents(bytes: &[u8]) -> Result<&[u8]> {
    if !bytes.starts_with(MAGIC) {
        return Err(refuse("something else".to_owned(), "a file that begins with FULLBODY"));
    }
    let Some((header, contents)) = bytes.split_at_checked(HEADER) else {
        return Err(refuse(format!("{} bytes long", bytes.len()), "a header of 24 bytes: it is truncated"));
    };
    let number = |from: usize, to: usize| {
        header[from..to].iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte))
    };
    let (format, length, checksum) = (number(8, 12), number(12, 20), number(20, 24));
    if format != u64::from(ARCHIVE_FORMAT) {
        let expected =
            format!("format {ARCHIVE_FORMAT}: a simulation is read by the version of fullbody that wrote it");
        return Err(refuse(format!("of format {format}"), &expected));
    }
    if contents.len() as u64 != length {
        let what = if (contents.len() as u64) < length { "truncated" } else { "too long" };
        return Err(refuse(
            format!("{what}: {} bytes of contents", contents.len()),
            &format!("{length} bytes"),
        ));
    }
    let computed = crc32fast::hash(contents);
    if u64::from(computed) != checksum {
        return Err(refuse(
            format!("altered: its checksum is {computed:08x}"),
            &format!("the checksum {checksum:08x} that it was written with"),
        ));
    }
    Ok(contents)
}

fn refuse(value: String, expected: &str) -> Error {
    Error::invalid("the archive", value, expected)
}

impl Contents {
    fn description(&self) -> Result<SimulationDescription> {
        serde_json::from_str(&self.description).map_err(|error| {
            refuse(format!("of a description that is damaged ({error})"), "one that can be read")
        })
    }

    fn restore(
        self,
        functions: impl Fn(&str) -> Option<Call>,
        interrupt: &mut InterruptCheck,
    ) -> Result<Simulation> {
        let mut description = self.description()?;
        for force in &mut description.forces {
            if let Force::Function(function) = force {
                function.call = functions(&function.name);
            }
        }
        let system =
            System::new(description.bodies, description.gravitational_constant, description.settings)?
                .with_forces(description.forces)?;
        let frame = BarycentricFrame {
            layout: system.layout(),
            epoch: self.start.epoch,
            barycentre: self.start.barycentre,
            barycentre_velocity: self.start.barycentre_velocity,
        };
        self.present.check(frame.layout)?;
        if self.start.scales.len() != frame.layout.bodies {
            let expected = format!("{}, as of bodies", frame.layout.bodies);
            return Err(refuse(format!("of {} scales", self.start.scales.len()), &expected));
        }
        self.start.check()?;
        let (time, high, low) = self.present.vector();
        let State { position, velocity, attitude, spin, .. } = frame.state(time, high, low);
        State::new(time, position, velocity, attitude, spin)?;
        let mut motion = Motion::new(system.dynamics(&frame, interrupt)?, high);
        motion.initial = self.start.scales;
        let propagator = Propagator::new(description.integrator, &motion, time, high.to_vec(), low.to_vec())?;
        let mut simulation = Simulation {
            motion,
            integrator: description.integrator,
            propagator,
            state_was_set: false,
            start: Invariants::from_numbers(self.start.conserved),
            nominal: None,
            notes: self.notes,
        };
        simulation.restore_checkpoint(&self.present, interrupt)?;
        Ok(simulation)
    }
}
