//! Steps that end where a force is switched.
//!
//! Within a step every force is on or off, so that the rates of change are smooth. Where the continuous
//! solution of a step comes to a switch, the step is repeated up to the switch, and the next step begins after it.

use super::Simulation;
use super::approach::Contact;
use super::tangent::Tangents;
use crate::error::Result;
use crate::integrate::first_fall_below_zero;
use crate::interrupt::InterruptCheck;

/// The distance from the end of a step, as a fraction of the step, within which a switch counts as being at
/// the end. It is ten times as large for each repetition of the step.
const AT_END: f64 = 1e-12;

/// The units of work of the search for a switch, for [`InterruptCheck`].
const SEARCH: u64 = 200;

impl Simulation {
    /// Returns the first switch in the last step before a contact: the force, and a time that is later than
    /// the switch by no more than the rounding of times. A switch at the end of the step has the time of that
    /// end; `repetitions` is the number of times that the step has been repeated.
    pub(super) fn next_switch(
        &mut self,
        contact: Option<Contact>,
        repetitions: i32,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<(usize, f64)>> {
        if !self.motion.equations.external_forces().nears_switch() {
            return Ok(None);
        }
        self.propagator.form(&mut self.motion, interrupt)?;
        let end = contact.map_or(1.0, |contact| contact.theta);
        let switched: Vec<usize> = self.motion.equations.external_forces().switched().collect();
        let Some(piece) = self.propagator.pieces().first() else { return Ok(None) };
        let mut y = vec![0.0; self.motion.equations.layout().dimension()];
        let mut first: Option<(usize, f64)> = None;
        for force in switched {
            interrupt.charge(SEARCH, piece.start())?;
            let equations = &mut self.motion.equations;
            let mut margin = |theta: f64| {
                piece.at(theta, &mut y);
                Ok(equations.switch_margin(force, piece.time_at(theta), &y))
            };
            let until = first.map_or(end, |(_, time)| piece.fraction(time));
            let Some((theta, behind)) = first_fall_below_zero(&mut margin, until)? else { continue };
            // The time must be after the root and after the start, by no more than the rounding of times.
            let (mut time, last) = (piece.time_at(theta), piece.time_at(behind));
            let mut by = (f64::EPSILON * time.abs()).max(f64::MIN_POSITIVE).copysign(piece.size());
            while time != last && (time == piece.start() || margin(piece.fraction(time))? >= 0.0) {
                let next = time + by;
                time = if (last - next) * by > 0.0 { next } else { last };
                by *= 2.0;
            }
            first = Some((force, time));
        }
        let Some((force, time)) = first.filter(|(_, time)| *time != piece.start()) else { return Ok(None) };
        let at_end = piece.fraction(time) >= 1.0 - AT_END * 10_f64.powi(repetitions);
        Ok(Some((force, if at_end { self.propagator.time() } else { time })))
    }

    /// Switches a force at the present state, and maps tangent vectors across the switch.
    pub(super) fn switch(&mut self, force: usize, tangents: Option<&mut Tangents>) -> Result<()> {
        let time = self.time();
        let equations = &mut self.motion.equations;
        let (jump, rate) = equations.switch_jump(force, time, self.propagator.vector().0)?;
        if let Some(tangents) = tangents {
            tangents.jump(equations, &jump, rate);
        }
        equations.switch(force);
        Ok(())
    }

    /// Switches the forces whose switch the present state has passed.
    pub(super) fn switch_overdue(&mut self, mut tangents: Option<&mut Tangents>) -> Result<()> {
        let time = self.time();
        while let Some(force) = self.motion.equations.overdue_switch(time, self.propagator.vector().0) {
            self.switch(force, tangents.as_deref_mut())?;
        }
        Ok(())
    }
}
