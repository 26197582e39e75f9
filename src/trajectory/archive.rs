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
//! The contents hold the set-up once, as text, and all that decides how the run goes on, in binary: a run that goes on from
//! them equals the unbroken one bit for bit, on a machine with the same vector instructions.

use super::checkpoint::Checkpoint;
use super::motion::Motion;
use super::mover::Mover;
use super::{Integrator, Simulation};
use crate::dynamics::{BarycentricFrame, Invariants, Settings, State, System};
use crate::environment::{Call, Force};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::patience::Patience;
use crate::shape::Body;
use serde::{Deserialize, Serialize};

/// The layout that is written, and the only one that is read.
pub const ARCHIVE_VERSION: u32 = 4;

const MAGIC: &[u8; 8] = b"FULLBODY";
const HEADER: usize = 24;
/// The bytes that the Python package of version 0.1.0, whose layout was 1, wrote before the core's.
const BEFORE_LAYOUT_1: &[u8] = b"fullbody simulation\n";

/// What a simulation was made with. There is no other description of it: archives hold this one, and the Python package makes
/// its own objects from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// The bodies.
    pub bodies: Vec<Body>,
    /// The gravitational constant.
    #[serde(rename = "G")]
    pub gravitational_constant: f64,
    /// How gravity is computed and attitudes are kept.
    pub settings: Settings,
    /// The forces from outside.
    pub forces: Vec<Force>,
    /// The integrator.
    pub integrator: Integrator,
}

/// Layout 4. These fields and those of their types stay as they are: a change makes a new layout.
#[derive(Serialize, Deserialize)]
struct Contents {
    producer: String,
    /// The [`Setup`] as JSON: everything in it has a name.
    setup: String,
    /// The caller's text.
    notes: String,
    start: Start,
    now: Checkpoint,
}

/// The numbers of the start that the whole run depends on, and those that drifts are measured against.
#[derive(Serialize, Deserialize)]
struct Start {
    /// The [`BarycentricFrame`]: time, position and velocity of the barycentre.
    epoch: f64,
    barycentre: [f64; 3],
    barycentre_velocity: [f64; 3],
    /// Per body the scales of position, velocity and spin, to which absolute tolerances refer.
    scales: Vec<[f64; 3]>,
    /// The conserved quantities there, as [`Invariants::numbers`] gives them.
    conserved: [f64; 8],
}

impl Start {
    /// Refuses numbers that no simulation starts with.
    fn check(&self) -> Result<()> {
        require_finite("epoch of a simulation", &[self.epoch])?;
        require_finite("barycentre of a simulation", &self.barycentre)?;
        require_finite("velocity of the barycentre of a simulation", &self.barycentre_velocity)?;
        let scales = self.scales.iter().flatten();
        scales.copied().try_for_each(|scale| require_positive("scale of a simulation", scale))?;
        require_finite("what is conserved in a simulation", &self.conserved)
    }
}

impl Simulation {
    /// What the simulation was made with.
    pub fn setup(&self) -> Setup {
        let system = self.system();
        Setup {
            bodies: system.bodies().to_vec(),
            gravitational_constant: system.gravitational_constant(),
            settings: *system.settings(),
            forces: system.forces().to_vec(),
            integrator: self.integrator,
        }
    }

    /// The simulation as bytes.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let unwritable = |error: &dyn std::fmt::Display| {
            Error::invalid("a simulation", error, "one that an archive can hold")
        };
        let contents = Contents {
            producer: format!("fullbody {}", env!("CARGO_PKG_VERSION")),
            setup: serde_json::to_string(&self.setup()).map_err(|error| unwritable(&error))?,
            notes: self.notes.clone(),
            start: Start {
                epoch: self.frame().epoch,
                barycentre: self.frame().barycentre,
                barycentre_velocity: self.frame().barycentre_velocity,
                scales: self.motion.initial.clone(),
                conserved: self.start.numbers(),
            },
            now: self.checkpoint(),
        };
        let contents = postcard::to_stdvec(&contents).map_err(|error| unwritable(&error))?;
        let mut bytes = Vec::with_capacity(HEADER + contents.len());
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&ARCHIVE_VERSION.to_le_bytes());
        bytes.extend_from_slice(&(contents.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&crc32fast::hash(&contents).to_le_bytes());
        bytes.extend_from_slice(&contents);
        Ok(bytes)
    }

    /// The simulation that [`Self::to_bytes`] wrote; says what is wrong with bytes that it did not.
    pub fn from_bytes(bytes: &[u8], patience: &mut Patience) -> Result<Self> {
        Self::from_bytes_with(bytes, |_| None, patience)
    }

    /// The same of a simulation with forces that are functions, which no archive can hold: `functions` gives those of a name.
    pub fn from_bytes_with(
        bytes: &[u8],
        functions: impl Fn(&str) -> Option<Call>,
        patience: &mut Patience,
    ) -> Result<Self> {
        read(bytes)?.restore(functions, patience)
    }

    /// What such bytes were made with, and the caller's text in them.
    pub fn described(bytes: &[u8]) -> Result<(Setup, String)> {
        let contents = read(bytes)?;
        Ok((contents.setup()?, contents.notes))
    }
}

fn read(bytes: &[u8]) -> Result<Contents> {
    let expected = format!("the contents of layout {ARCHIVE_VERSION}");
    let (contents, rest): (Contents, _) = postcard::take_from_bytes(contents(bytes)?)
        .map_err(|error| refuse(format!("unreadable ({error})"), &expected))?;
    if !rest.is_empty() {
        return Err(refuse(format!("of {} bytes more than its contents", rest.len()), &expected));
    }
    Ok(contents)
}

/// The contents behind a sound header.
fn contents(bytes: &[u8]) -> Result<&[u8]> {
    if bytes.starts_with(BEFORE_LAYOUT_1) {
        return Err(other_layout(1));
    }
    if !bytes.starts_with(MAGIC) {
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
        return Err(other_layout(version));
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

fn other_layout(version: u64) -> Error {
    let from = match version {
        1 => ", that of fullbody 0.1.0",
        3 => ", that of fullbody 0.2.0",
        version if version > u64::from(ARCHIVE_VERSION) => ", that of a newer fullbody",
        _ => "",
    };
    refuse(
        format!("of layout {version}{from}"),
        &format!("layout {ARCHIVE_VERSION}: a simulation is read by the version of fullbody that wrote it"),
    )
}

fn refuse(value: String, expected: &str) -> Error {
    Error::invalid("the archive", value, expected)
}

impl Contents {
    fn setup(&self) -> Result<Setup> {
        serde_json::from_str(&self.setup)
            .map_err(|error| refuse(format!("of a set-up that is damaged ({error})"), "one that can be read"))
    }

    fn restore(
        self,
        functions: impl Fn(&str) -> Option<Call>,
        patience: &mut Patience,
    ) -> Result<Simulation> {
        let mut setup = self.setup()?;
        for force in &mut setup.forces {
            if let Force::Function(function) = force {
                function.call = functions(&function.name);
            }
        }
        let system = System::new(setup.bodies, setup.gravitational_constant, setup.settings)?
            .with_forces(setup.forces)?;
        let frame = BarycentricFrame {
            layout: system.layout(),
            epoch: self.start.epoch,
            barycentre: self.start.barycentre,
            barycentre_velocity: self.start.barycentre_velocity,
        };
        self.now.check(frame.layout)?;
        if self.start.scales.len() != frame.layout.bodies {
            let expected = format!("{}, as of bodies", frame.layout.bodies);
            return Err(refuse(format!("of {} scales", self.start.scales.len()), &expected));
        }
        self.start.check()?;
        let (time, high, low) = self.now.place();
        let State { time: now, position, velocity, attitude, spin } = frame.state(time, high, low);
        State::new(now, position, velocity, attitude, spin)?;
        let mut motion = Motion::new(system.dynamics(&frame, patience)?, high);
        motion.initial = self.start.scales;
        let mover = Mover::new(setup.integrator, &motion, time, high.to_vec(), low.to_vec())?;
        let mut simulation = Simulation {
            motion,
            integrator: setup.integrator,
            mover,
            given: false,
            start: Invariants::from_numbers(self.start.conserved),
            notes: self.notes,
        };
        simulation.go_back(&self.now, patience)?;
        Ok(simulation)
    }
}
