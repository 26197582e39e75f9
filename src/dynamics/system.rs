//! A system: bodies, gravitational constant, method.

use super::{AttitudeChart, Layout, State};
use crate::environment::{Environment, Force};
use crate::error::{Error, Result, require_finite};
use crate::math::lanes::VectorPath;
use crate::math::rotation;
use crate::mutual::{Link, Method, Pose, Store};
use crate::names::Named;
use crate::patience::Patience;
use crate::quadrature::Order;
use crate::shape::{Body, Meeting, Shape};
use pulp::Arch;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The farthest separation, in the system's units and in sizes of a body, whose inverse cube is safely a double.
const REACH: f64 = 1e100;

/// Units of work of looking at a pair's separation, for [`Patience`].
const CHECK: u64 = 10;

/// How the gravity of a system is computed and its attitudes are kept. This is the description of the settings: archives and
/// the Python package have theirs from it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The method of the interactions.
    pub gravity: Method,
    /// Tolerance of the quadrature, relative to the force.
    pub gravity_tolerance: f64,
    /// A fixed order of the quadrature instead of the tolerance.
    pub order: Option<Order>,
    /// The attitudes' chart.
    #[serde(with = "crate::names")]
    pub attitude_chart: AttitudeChart,
    /// The instructions of the hot loops.
    #[serde(with = "crate::names")]
    pub vector_path: VectorPath,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            gravity: Method::Focal,
            gravity_tolerance: 1e-14,
            order: None,
            attitude_chart: AttitudeChart::default(),
            vector_path: VectorPath::default(),
        }
    }
}

/// Bodies under their mutual gravity.
#[derive(Debug, Clone)]
pub struct System {
    pub(super) bodies: Vec<Body>,
    pub(super) gravitational_constant: f64,
    pub(super) settings: Settings,
    forces: Vec<Force>,
    arch: Arch,
    store: Arc<Store>,
}

impl System {
    /// A system of bodies with distinct names; G is in the units of everything else.
    pub fn new(bodies: Vec<Body>, gravitational_constant: f64, settings: Settings) -> Result<Self> {
        if bodies.is_empty() {
            return Err(Error::invalid("number of bodies", 0, "at least one"));
        }
        for (i, body) in bodies.iter().enumerate() {
            if bodies[..i].iter().any(|other| other.name == body.name) {
                return Err(Error::invalid(
                    "name of a body",
                    format!("{:?} twice", body.name),
                    "distinct names",
                ));
            }
        }
        require_finite("G", &[gravitational_constant])?;
        if gravitational_constant < 0.0 {
            return Err(Error::invalid("G", gravitational_constant, "a finite number, zero or above"));
        }
        let tolerance = settings.gravity_tolerance;
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(Error::invalid("gravity_tolerance", tolerance, "a number between 0 and 1"));
        }
        if let Some(order) = settings.order
            && !((1..=512).contains(&order.gauss) && (1..=1024).contains(&order.angles))
        {
            return Err(Error::invalid(
                "order",
                format!("({}, {})", order.gauss, order.angles),
                "(n, m) with n from 1 to 512 and m from 1 to 1024",
            ));
        }
        let faceted =
            bodies.iter().find(|b| b.parts().iter().any(|p| matches!(p.shape, Shape::Polyhedron(_))));
        if let (Some(body), Some(order)) = (faceted, settings.order) {
            let found = format!("({}, {})", order.gauss, order.angles);
            let expected =
                format!("none beside {}, a polyhedron: gravity_tolerance chooses the rules", body.name);
            return Err(Error::invalid("order", found, expected));
        }
        let arch = settings.vector_path.arch().ok_or_else(|| {
            Error::invalid(
                "vector_path",
                format!("{:?}", settings.vector_path.name()),
                format!(
                    "one that this machine has: {:?}",
                    VectorPath::available().into_iter().map(VectorPath::name).collect::<Vec<_>>()
                ),
            )
        })?;
        // Focal and surface rules settle at round-off; below that there is nothing to gain.
        let settings = Settings { gravity_tolerance: tolerance.max(1e-16), ..settings };
        let (forces, store) = (Vec::new(), Arc::default());
        Ok(Self { bodies, gravitational_constant, settings, forces, arch, store })
    }

    /// The same with forces from outside, of distinct names.
    pub fn with_forces(self, forces: Vec<Force>) -> Result<Self> {
        Environment::new(&forces, &self.bodies, self.gravitational_constant)?;
        Ok(Self { forces, ..self })
    }

    /// The same with what its pairs need kept where other systems have it too.
    pub fn sharing(self, store: Arc<Store>) -> Self {
        Self { store, ..self }
    }

    /// The bodies.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The gravitational constant.
    pub fn gravitational_constant(&self) -> f64 {
        self.gravitational_constant
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The forces from outside.
    pub fn forces(&self) -> &[Force] {
        &self.forces
    }

    /// The forces from outside, ready for computing.
    pub fn environment(&self) -> Result<Environment> {
        Environment::new(&self.forces, &self.bodies, self.gravitational_constant)
    }

    /// The instructions of the hot loops.
    pub fn arch(&self) -> Arch {
        self.arch
    }

    /// Where the numbers of this system's states lie in the integrator's vector.
    pub fn layout(&self) -> Layout {
        Layout { bodies: self.bodies.len(), chart: self.settings.attitude_chart, forces: self.forces.len() }
    }

    /// Masses of the bodies.
    pub fn masses(&self) -> Vec<f64> {
        self.bodies.iter().map(|body| body.mass).collect()
    }

    /// Refuses states of another number of bodies, bodies that overlap, and bodies too far apart for doubles.
    pub fn check(&self, state: &State, patience: &mut Patience) -> Result<()> {
        if state.bodies() != self.bodies.len() {
            return Err(Error::invalid(
                "number of bodies in the state",
                state.bodies(),
                format!("{}, as in the system", self.bodies.len()),
            ));
        }
        for (i, j) in self.pairs() {
            patience.spend(CHECK, state.time)?;
            let pose = pose(state, i, j);
            self.check_reach(i, j, &pose)?;
            self.check_apart(i, j, &pose, state.time, patience)?;
        }
        Ok(())
    }

    /// Refuses separations whose inverse cube, in the system's units or in the size of a body, leaves the range of
    /// doubles: the force would be zero without a word.
    fn check_reach(&self, i: usize, j: usize, pose: &Pose) -> Result<()> {
        let (first, second) = (&self.bodies[i], &self.bodies[j]);
        let largest = [first, second].map(|body| body.circumradius()).into_iter().fold(0.0, f64::max);
        let limit = if largest > 0.0 { REACH * largest.min(1.0) } else { REACH };
        let distance = pose.separation.amax();
        if distance <= limit {
            return Ok(());
        }
        Err(Error::invalid(
            format!("separation of {} and {}", first.name, second.name),
            format!("{distance:e}"),
            format!("at most {limit:e}; choose units that keep the numbers in range"),
        ))
    }

    /// Refuses bodies that overlap. Returns the factor by which the bodies must grow to touch: infinite where their
    /// circumscribed spheres are apart.
    pub(super) fn check_apart(
        &self,
        i: usize,
        j: usize,
        pose: &Pose,
        time: f64,
        patience: &mut Patience,
    ) -> Result<f64> {
        let (first, second) = (&self.bodies[i], &self.bodies[j]);
        let distance = pose.separation.norm();
        if distance > 0.0 && distance >= first.circumradius() + second.circumradius() {
            return Ok(f64::INFINITY);
        }
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let meeting = Meeting::of([first, second], &pose.separation, rotations, time, patience)?;
        if meeting.overlap {
            let (first, second) = (first.name.clone(), second.name.clone());
            return Err(Error::BodiesOverlap { first, second, time });
        }
        Ok(meeting.factor)
    }

    /// Checks polyhedra and computes what their links take from their moments, unless that has been done: it is kept with the shapes.
    pub(super) fn polyhedra(&self, patience: &mut Patience) -> Result<()> {
        for part in self.bodies.iter().flat_map(Body::parts) {
            let Shape::Polyhedron(polyhedron) = &part.shape else { continue };
            polyhedron.check(patience)?;
            if let Method::Multipole(degree) = self.settings.gravity {
                // Two degrees more tell what the series leaves out.
                polyhedron.monomial_means(degree + 2, patience)?;
            }
        }
        Ok(())
    }

    /// G m_i m_j.
    pub(super) fn strength(&self, i: usize, j: usize) -> f64 {
        self.gravitational_constant * self.bodies[i].mass * self.bodies[j].mass
    }

    pub(super) fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let n = self.bodies.len();
        (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
    }

    /// How the parts of two bodies interact.
    pub(super) fn links(&self, i: usize, j: usize) -> impl Iterator<Item = Link> {
        let bodies = [&self.bodies[i], &self.bodies[j]];
        let s = &self.settings;
        let [first, second] = Link::parts_of(bodies, s.gravity);
        let parts = (0..first).flat_map(move |a| (0..second).map(move |b| [a, b]));
        parts.map(move |parts| {
            Link::new(bodies, parts, s.gravity, s.gravity_tolerance, s.order, self.arch, &self.store)
        })
    }

    /// How many links all bodies have.
    pub(super) fn count_links(&self) -> usize {
        let counts = self
            .pairs()
            .map(|(i, j)| Link::parts_of([&self.bodies[i], &self.bodies[j]], self.settings.gravity));
        counts.map(|[first, second]| first * second).sum()
    }
}

/// The relative pose of two bodies of a state.
pub(super) fn pose(state: &State, i: usize, j: usize) -> Pose {
    Pose {
        separation: state.position[j] - state.position[i],
        rotation_first: rotation::matrix(state.attitude[i]),
        rotation_second: rotation::matrix(state.attitude[j]),
    }
}
