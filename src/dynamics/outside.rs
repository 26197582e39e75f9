//! Forces from outside in the equations of motion, and their books.

use super::{Dynamics, Rejected};
use crate::environment::{BOOK, Environment, LoadSlopes};
use crate::error::Result;
use crate::math::Vec3;
use pulp::{Simd, WithSimd};

impl Dynamics {
    /// Refuses a run for which the forces from outside do not hold, from a vector at a time to another time.
    pub fn check_outside(&mut self, time: f64, until: f64, y: &[f64]) -> Result<()> {
        if self.layout.forces > 0 {
            self.turn(y);
            self.show(time, y);
            self.outside.check(time, until)?;
        }
        Ok(())
    }

    /// Adds what comes from outside to the loads.
    pub(super) fn add_outside(&mut self, time: f64, y: &[f64]) -> std::result::Result<(), Rejected> {
        self.system.arch().dispatch(LoadOutside { dynamics: self, time, y })
    }

    /// To the bodies' motion about the barycentre, and to that of the barycentre.
    #[inline(always)]
    fn load_outside(&mut self, time: f64, y: &[f64]) -> std::result::Result<(), Rejected> {
        self.show(time, y);
        self.outside.load().map_err(|error| Rejected::Failed(Box::new(error)))?;
        let mut total = Vec3::zeros();
        for load in self.outside.loads() {
            total += load.force;
            self.acceleration[load.on] += load.force * self.inverse_mass[load.on];
            if load.turns {
                self.torque[load.on] += load.torque;
            }
        }
        self.barycentre_acceleration = total * self.inverse_total;
        self.acceleration.iter_mut().for_each(|a| *a -= self.barycentre_acceleration);
        Ok(())
    }

    /// What forces from outside give the barycentre.
    pub fn barycentre_acceleration(&self) -> Vec3 {
        self.barycentre_acceleration
    }

    /// The rates of the books at the vector of the last evaluation.
    pub fn quadratures(&self, rate: &mut [f64]) {
        if self.layout.forces > 0 {
            let books = rate[self.layout.book(0)..].as_chunks_mut::<BOOK>().0;
            self.system.arch().dispatch(WriteBooks { outside: &self.outside, books });
        }
    }

    /// Adds what the forces from outside have of the derivatives.
    pub(super) fn slopes_outside(&mut self, time: f64, y: &[f64], slopes: &mut LoadSlopes) -> Result<()> {
        self.show(time, y);
        self.outside.load()?;
        self.outside.slopes(slopes)
    }

    /// Shows a vector whose rotations are known to the forces from outside.
    #[inline(always)]
    pub(super) fn show(&mut self, time: f64, y: &[f64]) {
        let attitudes = self.outside.wants_attitudes();
        self.frame.show(time, y, attitudes, &mut self.outside.scene);
    }
}

/// [`Dynamics::load_outside`], compiled for the instructions of each path.
struct LoadOutside<'a> {
    dynamics: &'a mut Dynamics,
    time: f64,
    y: &'a [f64],
}

impl WithSimd for LoadOutside<'_> {
    type Output = std::result::Result<(), Rejected>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        self.dynamics.load_outside(self.time, self.y)
    }
}

/// The rates of the books, likewise.
struct WriteBooks<'a> {
    outside: &'a Environment,
    books: &'a mut [[f64; BOOK]],
}

impl WithSimd for WriteBooks<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let bodies = &self.outside.scene.bodies;
        for (force, book) in self.books.iter_mut().enumerate() {
            *book = self.outside.book(force, |body| (bodies[body].velocity, bodies[body].spin));
        }
    }
}
