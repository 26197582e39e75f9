//! Forces from outside in the equations of motion, and their books.

use super::{Dynamics, Rejected};
use crate::environment::{BOOK, LoadSlopes, Scene};
use crate::error::Result;
use crate::gravity::ExtendedPull;
use crate::math::Vec3;
use pulp::{Scalar, Simd, WithSimd};

impl Dynamics {
    /// Refuses a run for which the forces from outside do not hold, from a vector at a time to another time.
    pub fn check_outside(&mut self, time: f64, until: f64, y: &[f64]) -> Result<()> {
        if self.layout.forces > 0 {
            self.turn(y);
            self.outside.check(self.view.show(time, y), until)?;
        }
        Ok(())
    }

    /// Adds what comes from outside to the loads.
    pub(super) fn add_outside(&mut self, time: f64, y: &[f64]) -> std::result::Result<(), Rejected> {
        self.system.arch().dispatch(LoadOutside { dynamics: self, time, y })
    }

    /// To the bodies' motion about the barycentre, and to that of the barycentre.
    #[inline(always)]
    fn load_outside<S: Simd>(&mut self, simd: S, time: f64, y: &[f64]) -> std::result::Result<(), Rejected> {
        let scene = self.view.show(time, y);
        // On their own at first: these sums do not wait for what the bodies do to each other.
        self.actions.clear();
        let loaded = self.outside.load(simd, scene, &mut self.actions);
        loaded.map_err(|error| Rejected::Failed(Box::new(error)))?;
        self.barycentre_acceleration = self.actions.add_to(&mut self.acceleration, &mut self.torque);
        Ok(())
    }

    /// What forces from outside give the barycentre.
    pub fn barycentre_acceleration(&self) -> Vec3 {
        self.barycentre_acceleration
    }

    /// The rates of the books at the time and the vector of the last evaluation.
    pub fn quadratures(&self, time: f64, y: &[f64], rate: &mut [f64]) {
        if self.layout.forces > 0 {
            let books = rate[self.layout.book(0)..].as_chunks_mut::<BOOK>().0;
            self.system.arch().dispatch(WriteBooks { dynamics: self, time, y, books });
        }
    }

    /// Adds what the forces from outside have of the derivatives.
    pub(super) fn slopes_outside(&mut self, time: f64, y: &[f64], slopes: &mut LoadSlopes) -> Result<()> {
        let scene = self.view.show(time, y);
        self.outside.load(Scalar, scene, &mut ())?;
        self.outside.slopes(scene, slopes)
    }

    /// The derivatives of what third bodies do to a body by its semi-axes, at the vector of the last evaluation.
    pub(super) fn by_axes_outside(
        &mut self,
        time: f64,
        y: &[f64],
        body: usize,
        pull: &mut ExtendedPull,
    ) -> Result<[[Vec3; 2]; 3]> {
        self.outside.by_axes(self.view.shown(time, y), body, pull)
    }

    /// The bodies of the vector of the last evaluation, or of one with the same attitudes.
    #[inline(always)]
    pub(super) fn scene<'a>(&'a self, time: f64, y: &'a [f64]) -> Scene<'a> {
        self.view.shown(time, y)
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
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        self.dynamics.load_outside(simd, self.time, self.y)
    }
}

/// The rates of the books, likewise.
struct WriteBooks<'a> {
    dynamics: &'a Dynamics,
    time: f64,
    y: &'a [f64],
    books: &'a mut [[f64; BOOK]],
}

impl WithSimd for WriteBooks<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let scene = self.dynamics.scene(self.time, self.y);
        for (force, book) in self.books.iter_mut().enumerate() {
            *book = self.dynamics.outside.book(scene, force);
        }
    }
}
