//! Forces on a particle other than the bodies' gravity: third bodies, and the radiation of one of them.
//!
//! Radiation accelerates a particle away from its source by (strength / d^2) (area-to-mass ratio) (visible
//! part of the source's disc).

use super::body_ephemeris::{COLUMNS, LaneBlock};
use super::shadow::Disc;
use crate::dynamics::{BarycentricFrame, State, System};
use crate::error::{Error, Result, require_finite};
use crate::forces::{ForceModel, PointAttraction};
use crate::interrupt::InterruptCheck;
use crate::math::rotation::matrix;
use crate::math::{Mat3, Vec3};
use crate::shape::Body;

/// The radiation of a third body.
#[derive(Debug, Clone, PartialEq)]
pub struct Radiation {
    /// The third body's name.
    pub by: String,
    /// The force on a unit area at a unit distance: luminosity / (4 pi c).
    pub strength: f64,
    /// The third body's radius.
    pub radius: f64,
}

/// The external forces on particles, prepared for evaluation.
#[derive(Debug, Clone)]
pub struct ExternalForces {
    attractions: Vec<PointAttraction>,
    light: Option<RadiationSource>,
}

#[derive(Debug, Clone)]
struct RadiationSource {
    /// The index of the source among the third bodies.
    source: usize,
    strength: f64,
    disc: Disc,
}

impl ExternalForces {
    /// Takes the third bodies of a force model, with the radiation of one of them.
    pub fn new(force_model: &ForceModel, radiation: Option<&Radiation>, bodies: &[Body]) -> Result<Self> {
        let attractions = force_model.on_points();
        let light = |radiation: &Radiation| {
            let source = attractions
                .iter()
                .position(|attraction| attraction.name() == radiation.by)
                .ok_or_else(|| {
                    let names: Vec<_> = attractions.iter().map(PointAttraction::name).collect();
                    let expected = format!("the name of a third body of the system, one of {names:?}");
                    Error::invalid("by of Radiation", format!("{:?}", radiation.by), expected)
                })?;
            for (what, value) in [("strength", radiation.strength), ("radius", radiation.radius)] {
                require_finite(&format!("{what} of Radiation"), &[value])?;
                if value < 0.0 {
                    return Err(Error::invalid(format!("{what} of Radiation"), value, "zero or more"));
                }
            }
            Ok(RadiationSource {
                source,
                strength: radiation.strength,
                disc: Disc::new(radiation.radius, bodies),
            })
        };
        Ok(Self { light: radiation.map(light).transpose()?, attractions })
    }

    /// Returns an error for times at which a path is not given.
    pub fn covers(&self, from: f64, to: f64) -> Result<()> {
        self.attractions.iter().try_for_each(|attraction| attraction.covers(from, to))
    }

    /// Returns whether there are no forces.
    pub fn is_empty(&self) -> bool {
        self.attractions.is_empty()
    }

    /// Returns whether there is radiation.
    pub fn is_lit(&self) -> bool {
        self.light.is_some()
    }

    /// Returns the acceleration of a particle at a position relative to the nominal barycentre, where the
    /// bodies are as in this lane of the columns.
    pub fn acceleration(
        &mut self,
        time: f64,
        x: &Vec3,
        area_to_mass: f64,
        columns: &[LaneBlock],
        lane: usize,
    ) -> Result<Vec3> {
        let mut sum = Vec3::zeros();
        for (index, attraction) in self.attractions.iter_mut().enumerate() {
            let source = attraction.position(time)?;
            sum += attraction.acceleration(&source, x);
            if let Some(light) = &mut self.light
                && light.source == index
                && area_to_mass != 0.0
            {
                let towards = source.position - x;
                let seen = light.disc.visible(&towards, |body| {
                    let number = |c: usize| columns[COLUMNS * body + c][lane];
                    (matrix([3, 4, 5, 6].map(number)), x - Vec3::from([0, 1, 2].map(number)))
                });
                let square = towards.norm_squared();
                sum -= towards * (light.strength * area_to_mass * seen / (square * square.sqrt()));
            }
        }
        Ok(sum)
    }

    /// Returns the visible part of the source's disc from a position; `pose_from` returns a body's rotation
    /// and the position relative to its centre. Without radiation it is one.
    pub fn seen(&mut self, time: f64, x: &Vec3, pose_from: impl FnMut(usize) -> (Mat3, Vec3)) -> Result<f64> {
        let Some(light) = &mut self.light else { return Ok(1.0) };
        let towards = self.attractions[light.source].position(time)?.position - x;
        Ok(light.disc.visible(&towards, pose_from))
    }
}

/// Returns the visible part of a third body's disc from positions in a state, in the state's coordinates. The
/// barycentre of the state counts as the nominal one.
pub fn visible_from(
    system: &System,
    state: &State,
    radiation: &Radiation,
    points: &[Vec3],
    interrupt: &mut InterruptCheck,
) -> Result<Vec<f64>> {
    system.check(state, interrupt)?;
    let mut external_forces = ExternalForces::new(system.force_model(), Some(radiation), system.bodies())?;
    external_forces.covers(state.time, state.time)?;
    let (frame, ..) = BarycentricFrame::new(system.layout(), &system.masses(), state);
    let origin = frame.nominal_at(state.time);
    let rotations: Vec<Mat3> = state.attitude.iter().map(|&q| matrix(q)).collect();
    let part = |point: &Vec3| {
        interrupt.charge(100, state.time)?;
        external_forces
            .seen(state.time, &(point - origin), |body| (rotations[body], point - state.position[body]))
    };
    points.iter().map(part).collect()
}
