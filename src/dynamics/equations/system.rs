//! A system: bodies, gravitational constant, settings and external forces.

use super::layout::{AttitudeChart, Layout};
use super::state::State;
use crate::error::{Error, Result, require_finite};
use crate::forces::{Force, ForceModel};
use crate::interrupt::InterruptCheck;
use crate::math::exchange::Exchange;
use crate::math::lanes::VectorPath;
use crate::math::rotation;
use crate::mutual::{LEAST_TOLERANCE, Link, Method, Pose, Store};
use crate::names::Named;
use crate::quadrature::Order;
use crate::shape::{Body, Proximity, Shape};
use pulp::Arch;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The largest separation, in the system's units and in sizes of a body, whose inverse cube is safely a
/// double.
const LARGEST_SEPARATION: f64 = 1e100;

/// The units of work of checking a pair's separation, for [`InterruptCheck`].
const CHECK: u64 = 10;

/// The units of work of making a link with its rule.
const NEW: u64 = 500;

/// The settings of a system, which determine how gravity is computed and attitudes are stored. Archives and
/// the Python package use this description.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The method of mutual gravity; the focal rule by default.
    pub gravity: Method,
    /// The tolerance of the quadrature, relative to the force; 1e-14 by default.
    pub gravity_tolerance: f64,
    /// A fixed order of the quadrature instead of the tolerance; none by default.
    pub order: Option<Order>,
    /// The chart of the attitudes; quaternions by default.
    #[serde(with = "crate::names")]
    pub attitude_chart: AttitudeChart,
    /// The vector instructions of the hot loops; by default the widest that the machine has.
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

/// A system: bodies under their mutual gravity, with settings and external forces.
///
/// ```
/// use fullbody::dynamics::{Settings, State, System};
/// use fullbody::math::Vec3;
/// use fullbody::shape::{Body, Shape};
///
/// let ball = |name, mass| Body::with_mass(name, Shape::ellipsoid([1.0, 1.0, 1.0])?, mass);
/// let system = System::new(vec![ball("One", 2.0)?, ball("Two", 3.0)?], 1.0, Settings::default())?;
///
/// let (rest, upright) = (vec![Vec3::zeros(); 2], vec![[1.0, 0.0, 0.0, 0.0]; 2]);
/// let position = vec![Vec3::zeros(), Vec3::new(4.0, 0.0, 0.0)];
/// let state = State::new(0.0, position, rest.clone(), upright, rest)?;
/// // Balls attract each other as points do: G m m / r^2.
/// let interaction = system.interactions(&state)?;
/// assert!((interaction.force[0].x - 6.0 / 16.0).abs() < 1e-15);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct System {
    pub(super) bodies: Vec<Body>,
    pub(super) gravitational_constant: f64,
    pub(super) settings: Settings,
    forces: Vec<Force>,
    /// The external forces, prepared for evaluation and not yet evaluated.
    force_model: Arc<ForceModel>,
    arch: Arch,
    store: Arc<Store>,
}

impl System {
    /// Makes a system of bodies with distinct names; G is in the units of everything else.
    ///
    /// # Errors
    /// Returns [`Error::InvalidInput`] if there are no bodies, for two bodies of one name, a negative or
    /// infinite G, a series of an odd degree or of one above 16, a tolerance outside (0, 1), an order that
    /// is out of range or given with polyhedra, and vector instructions that the machine lacks.
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
        if bodies.len() > 1 {
            bodies.iter().try_for_each(Body::require_vertices)?;
        }
        require_finite("G", &[gravitational_constant])?;
        if gravitational_constant < 0.0 {
            return Err(Error::invalid("G", gravitational_constant, "a finite number, zero or above"));
        }
        // A degree that the name of a method cannot have is refused where the name is read.
        settings.gravity.to_string().parse::<Method>()?;
        let tolerance = settings.gravity_tolerance;
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(Error::invalid("gravity_tolerance", tolerance, "a number between 0 and 1"));
        }
        let series = settings.gravity == Method::Harmonic;
        if let Some(order) = settings.order.filter(|_| series)
            && !(order.gauss == order.angles && (1..=Exchange::MAX_DEGREE).contains(&order.gauss))
        {
            return Err(Error::invalid(
                "order",
                format!("({}, {})", order.gauss, order.angles),
                format!(
                    "one degree for both bodies, from 1 to {}, with gravity=\"harmonic\"",
                    Exchange::MAX_DEGREE
                ),
            ));
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
        if let (Some(body), Some(order)) = (faceted, settings.order.filter(|_| !series)) {
            let value = format!("({}, {})", order.gauss, order.angles);
            let expected =
                format!("none beside {}, a polyhedron: gravity_tolerance chooses the rules", body.name);
            return Err(Error::invalid("order", value, expected));
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
        let settings = Settings { gravity_tolerance: tolerance.max(LEAST_TOLERANCE), ..settings };
        let force_model = Arc::new(ForceModel::new(&[], &bodies, gravitational_constant)?);
        let (forces, store) = (Vec::new(), Arc::default());
        Ok(Self { bodies, gravitational_constant, settings, forces, force_model, arch, store })
    }

    /// Returns the system with external forces, which must have distinct names.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] names the force whose name is not unique, whose body is not in the system, or
    /// whose number is out of its range.
    pub fn with_forces(self, forces: Vec<Force>) -> Result<Self> {
        let force_model = Arc::new(ForceModel::new(&forces, &self.bodies, self.gravitational_constant)?);
        Ok(Self { forces, force_model, ..self })
    }

    /// Returns the system with a store of shared data, in which other systems may already have stored data
    /// for its pairs.
    #[doc(hidden)]
    #[must_use]
    pub fn with_store(self, store: Arc<Store>) -> Self {
        Self { store, ..self }
    }

    /// Returns the bodies.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the gravitational constant.
    pub fn gravitational_constant(&self) -> f64 {
        self.gravitational_constant
    }

    /// Returns the settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the external forces.
    pub fn forces(&self) -> &[Force] {
        &self.forces
    }

    /// Returns the external forces prepared for evaluation; they are copied before they are evaluated.
    #[doc(hidden)]
    pub fn force_model(&self) -> &ForceModel {
        &self.force_model
    }

    /// Returns the vector instructions of the hot loops.
    pub fn arch(&self) -> Arch {
        self.arch
    }

    /// Returns the layout of this system's states in the integrator's vector.
    #[doc(hidden)]
    pub fn layout(&self) -> Layout {
        Layout { bodies: self.bodies.len(), chart: self.settings.attitude_chart, forces: self.forces.len() }
    }

    /// Returns the masses of the bodies.
    pub fn masses(&self) -> Vec<f64> {
        self.bodies.iter().map(|body| body.mass).collect()
    }

    /// Checks that a state is possible for the system.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for a state with another number of bodies or with bodies too far apart for
    /// doubles, [`Error::BodiesOverlap`] if two bodies overlap, and [`Error::Interrupted`].
    pub fn check(&self, state: &State, interrupt: &mut InterruptCheck) -> Result<()> {
        if state.bodies() != self.bodies.len() {
            return Err(Error::invalid(
                "number of bodies in the state",
                state.bodies(),
                format!("{}, as in the system", self.bodies.len()),
            ));
        }
        for (i, j) in self.pairs() {
            interrupt.charge(CHECK, state.time)?;
            let pose = pose(state, i, j);
            self.check_separation(i, j, &pose)?;
            self.check_overlap(i, j, &pose, state.time, interrupt)?;
        }
        Ok(())
    }

    /// Returns an error for a separation whose inverse cube, in the system's units or in the size of a body,
    /// leaves the range of doubles: the force would silently be zero.
    fn check_separation(&self, i: usize, j: usize, pose: &Pose) -> Result<()> {
        let (first, second) = (&self.bodies[i], &self.bodies[j]);
        let largest = [first, second].map(|body| body.circumradius()).into_iter().fold(0.0, f64::max);
        let limit = if largest > 0.0 { LARGEST_SEPARATION * largest.min(1.0) } else { LARGEST_SEPARATION };
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

    /// Returns an error for bodies that overlap, and otherwise the factor by which the bodies must grow to
    /// touch: infinite where their circumscribed spheres are apart.
    pub(super) fn check_overlap(
        &self,
        i: usize,
        j: usize,
        pose: &Pose,
        time: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<f64> {
        let (first, second) = (&self.bodies[i], &self.bodies[j]);
        let distance = pose.separation.norm();
        if distance > 0.0 && distance >= first.circumradius() + second.circumradius() {
            return Ok(f64::INFINITY);
        }
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let proximity = Proximity::compute([first, second], &pose.separation, rotations, time, interrupt)?;
        if proximity.overlap {
            let (first, second) = (first.name.clone(), second.name.clone());
            return Err(Error::BodiesOverlap { first, second, time });
        }
        Ok(proximity.factor)
    }

    /// Checks that the faces of all polyhedra bound solids, where that is not yet known.
    pub(super) fn check_polyhedra(&self, interrupt: &mut InterruptCheck) -> Result<()> {
        for part in self.bodies.iter().flat_map(Body::parts) {
            let Shape::Polyhedron(polyhedron) = &part.shape else { continue };
            polyhedron.check(interrupt)?;
        }
        Ok(())
    }

    /// Returns G m_i m_j.
    pub(super) fn strength(&self, i: usize, j: usize) -> f64 {
        self.gravitational_constant * self.bodies[i].mass * self.bodies[j].mass
    }

    pub(super) fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let n = self.bodies.len();
        (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
    }

    /// Makes the links between the parts of two bodies.
    pub(super) fn links(&self, i: usize, j: usize) -> impl Iterator<Item = Link> {
        let bodies = [&self.bodies[i], &self.bodies[j]];
        let s = &self.settings;
        let [first, second] = Link::parts_of(bodies, s.gravity);
        let parts = (0..first).flat_map(move |a| (0..second).map(move |b| [a, b]));
        parts.map(move |parts| {
            Link::new(bodies, parts, s.gravity, s.gravity_tolerance, s.order, self.arch, &self.store)
        })
    }

    /// Calls a function with each link between the parts of two bodies at a state: the link, for which the
    /// rule has been chosen, the two bodies and their pose.
    pub(super) fn for_each_link(
        &self,
        state: &State,
        interrupt: &mut InterruptCheck,
        mut visit: impl FnMut(&Link, [usize; 2], &Pose, &mut InterruptCheck) -> Result<()>,
    ) -> Result<()> {
        self.check(state, interrupt)?;
        self.check_polyhedra(interrupt).map_err(|error| error.at(state.time))?;
        for (i, j) in self.pairs() {
            let pose = pose(state, i, j);
            for mut link in self.links(i, j) {
                interrupt.charge(NEW, state.time)?;
                link.prepare(&pose, None, interrupt).map_err(|error| error.at(state.time))?;
                visit(&link, [i, j], &pose, interrupt)?;
            }
        }
        Ok(())
    }

    /// Returns the number of links between all bodies.
    pub(super) fn count_links(&self) -> usize {
        let counts = self
            .pairs()
            .map(|(i, j)| Link::parts_of([&self.bodies[i], &self.bodies[j]], self.settings.gravity));
        counts.map(|[first, second]| first * second).sum()
    }
}

/// Returns the relative pose of two bodies of a state.
pub(super) fn pose(state: &State, i: usize, j: usize) -> Pose {
    Pose {
        separation: state.position[j] - state.position[i],
        rotation_first: rotation::matrix(state.attitude[i]),
        rotation_second: rotation::matrix(state.attitude[j]),
    }
}
