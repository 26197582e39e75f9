//! External forces in the equations of motion, with their work and impulse.

mod switching;

use super::{Dynamics, Parameter, Rejected};
use crate::error::Result;
use crate::forces::{Load, LoadJacobian, MotionSnapshot, WORK_AND_IMPULSE};
use crate::gravity::{BodyChange, ExtendedAttraction};
use crate::math::Vec3;
use pulp::{Scalar, Simd, WithSimd};

impl Dynamics {
    /// Returns an error for a run, from a vector at a time to another time, over which an external force is
    /// not defined.
    pub fn check_external_forces(&mut self, time: f64, until: f64, y: &[f64]) -> Result<()> {
        if self.layout.forces > 0 {
            self.update_rotations(y);
            self.external_forces.check(self.view.take_snapshot(time, y), until)?;
        }
        Ok(())
    }

    /// Adds the external forces to the loads.
    pub(super) fn add_external_loads(&mut self, time: f64, y: &[f64]) -> std::result::Result<(), Rejected> {
        self.system.arch().dispatch(LoadExternalForces { dynamics: self, time, y })
    }

    /// Adds the external forces to the accelerations of the bodies relative to the barycentre, and computes that of the
    /// barycentre.
    #[inline(always)]
    fn load_external_forces<S: Simd>(
        &mut self,
        simd: S,
        time: f64,
        y: &[f64],
    ) -> std::result::Result<(), Rejected> {
        let snapshot = self.view.take_snapshot(time, y);
        // The external loads are summed separately first, so that these sums do not wait for the mutual
        // gravity.
        self.external_loads.clear();
        let loaded = self.external_forces.load(simd, snapshot, &mut self.external_loads);
        loaded.map_err(|error| Rejected::Failed(Box::new(error)))?;
        self.barycentre_acceleration = self.external_loads.add_to(&mut self.acceleration, &mut self.torque);
        Ok(())
    }

    /// Returns the acceleration of the barycentre by the external forces.
    pub fn barycentre_acceleration(&self) -> Vec3 {
        self.barycentre_acceleration
    }

    /// Writes the rates of work and impulse at the time and the vector of the last evaluation.
    pub fn quadratures(&self, time: f64, y: &[f64], rate: &mut [f64]) {
        if self.layout.forces > 0 {
            let work_and_impulse =
                rate[self.layout.work_and_impulse_index(0)..].as_chunks_mut::<WORK_AND_IMPULSE>().0;
            self.system.arch().dispatch(WriteWorkAndImpulse { dynamics: self, time, y, work_and_impulse });
        }
    }

    /// Adds the derivatives of the external loads.
    pub(super) fn add_external_jacobian(
        &mut self,
        time: f64,
        y: &[f64],
        jacobian: &mut LoadJacobian,
    ) -> Result<()> {
        let snapshot = self.view.take_snapshot(time, y);
        self.external_forces.load(Scalar, snapshot, &mut ())?;
        self.external_forces.add_jacobian(snapshot, jacobian)
    }

    /// Passes to the sink the derivatives of the external loads with respect to a parameter, at the vector of
    /// the last evaluation. They are not zero for a parameter of a force and for one that changes the orbits
    /// of third bodies.
    pub(super) fn external_loads_by_parameter(
        &mut self,
        time: f64,
        y: &[f64],
        parameter: Parameter,
        masses: &[f64],
        sink: &mut impl FnMut(&Load, f64),
    ) -> Result<()> {
        let (g, snapshot) = (self.system.gravitational_constant(), self.view.last_snapshot(time, y));
        if let Parameter::Force(force, number) = parameter {
            return self.external_forces.by_parameter(snapshot, force, number, g, sink);
        }
        let by = parameter.total_mu_derivative(g, masses);
        // A mu that is given by a mass is proportional to G.
        let by_g = if parameter == Parameter::GravitationalConstant && g > 0.0 { 1.0 / g } else { 0.0 };
        (0..self.external_forces.count())
            .try_for_each(|force| self.external_forces.by_total_mu(snapshot, force, by, by_g, sink))
    }

    /// Computes the derivatives of the loads of third bodies on a body whose own field changes, at the vector
    /// of the last evaluation.
    pub(super) fn external_loads_by_change(
        &mut self,
        time: f64,
        y: &[f64],
        body: usize,
        change: &BodyChange,
    ) -> Result<[Vec3; 2]> {
        self.external_forces.by_change(self.view.last_snapshot(time, y), body, change)
    }

    /// Returns the derivatives of the loads of third bodies on a body with respect to its semi-axes, at the
    /// vector of the last evaluation.
    pub(super) fn external_semi_axis_derivatives(
        &mut self,
        time: f64,
        y: &[f64],
        body: usize,
        attraction: &mut ExtendedAttraction,
    ) -> Result<[[Vec3; 2]; 3]> {
        self.external_forces.semi_axis_derivatives(self.view.last_snapshot(time, y), body, attraction)
    }

    /// Returns a snapshot of the vector of the last evaluation, or of one with the same attitudes.
    #[inline(always)]
    pub(super) fn snapshot<'a>(&'a self, time: f64, y: &'a [f64]) -> MotionSnapshot<'a> {
        self.view.last_snapshot(time, y)
    }
}

/// [`Dynamics::load_external_forces`], compiled for the instructions of each path.
struct LoadExternalForces<'a> {
    dynamics: &'a mut Dynamics,
    time: f64,
    y: &'a [f64],
}

impl WithSimd for LoadExternalForces<'_> {
    type Output = std::result::Result<(), Rejected>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        self.dynamics.load_external_forces(simd, self.time, self.y)
    }
}

/// The rates of work and impulse, compiled for the instructions of each path.
struct WriteWorkAndImpulse<'a> {
    dynamics: &'a Dynamics,
    time: f64,
    y: &'a [f64],
    work_and_impulse: &'a mut [[f64; WORK_AND_IMPULSE]],
}

impl WithSimd for WriteWorkAndImpulse<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let snapshot = self.dynamics.snapshot(self.time, self.y);
        for (force, entry) in self.work_and_impulse.iter_mut().enumerate() {
            *entry = self.dynamics.external_forces.work_and_impulse_rates(snapshot, force);
        }
    }
}
