//! The recorder of a run, which adds samples, events, the continuous solution and tangent vectors to the record after
//! each step.

use super::approach::Contact;
use super::dense::{piece_at, state_within};
use super::events::EventDetector;
use super::output::Times;
use super::tangent::{TangentOptions, Tangents};
use super::{Dense, Event, Output, Simulation, StopReason, Trajectory};
use crate::dynamics::{NominalChange, State, SteadyRotation};
use crate::error::{Result, require_finite};
use crate::interrupt::InterruptCheck;

/// The options of a run.
#[derive(Debug)]
pub struct Run<'a, 'f> {
    /// The times at which samples are recorded.
    pub output: &'a Output,
    /// The events that are searched for.
    pub events: &'a mut [Event<'f>],
    /// Whether the continuous solution is kept.
    pub dense: bool,
    /// Which tangent vectors are integrated beside the run.
    pub tangent_options: &'a TangentOptions,
}

impl<'a, 'f> Run<'a, 'f> {
    /// Makes the options of a run with samples at the times of `output`, without events, continuous solution,
    /// derivatives or chaos indicators.
    pub fn new(output: &'a Output) -> Self {
        Self { output, events: &mut [], dense: false, tangent_options: &TangentOptions::NONE }
    }
}

/// The recorder of a run, which advances a simulation and records its motion.
pub(super) struct Recorder<'r, 'f> {
    /// The end of the run.
    pub until: f64,
    forward: bool,
    /// Whether the interior of every step is needed, for events or the continuous solution.
    pub needs_interior: bool,
    times: Times<'r>,
    detector: EventDetector,
    events: &'r mut [Event<'f>],
    tangents: Tangents,
    with_tangents: bool,
    record: &'r mut Trajectory,
    /// The buffer for the vector of a sample.
    sample: Vec<f64>,
}

/// The event or switch that ends a step before its own end.
#[derive(Default)]
struct StepEnd {
    /// The index of the first terminal event in the list of events, and its time.
    event: Option<(usize, f64)>,
    contact: Option<Contact>,
    /// The force that switches at the end of the step.
    switch: Option<usize>,
}

impl<'r, 'f> Recorder<'r, 'f> {
    /// Makes the recorder of a run, or returns an error for a run that the simulation cannot make.
    pub fn new(
        simulation: &mut Simulation,
        until: f64,
        run: Run<'r, 'f>,
        record: &'r mut Trajectory,
    ) -> Result<Self> {
        require_finite("until", &[until])?;
        simulation.propagator.check_step_count(until)?;
        let start = simulation.time();
        let vector = simulation.propagator.vector().0;
        simulation.motion.equations.check_external_forces(start, until, vector)?;
        let equations = &simulation.motion.equations;
        let Run { output, events, dense, tangent_options } = run;
        let recorder = Self {
            needs_interior: dense || !events.is_empty(),
            until,
            forward: until >= start,
            times: Times::new(start, until, output)?,
            detector: EventDetector::new(equations, events, simulation.state_was_set)?,
            events,
            tangents: Tangents::new(
                tangent_options,
                &simulation.motion,
                &simulation.propagator,
                &simulation.state(),
                simulation.nominal.as_ref(),
            )?,
            with_tangents: *tangent_options != TangentOptions::default(),
            record,
            sample: vec![0.0; simulation.frame().layout.dimension()],
        };
        if dense {
            recorder.record.dense = Some(Dense::new(simulation.frame(), simulation.state()));
        }
        Ok(recorder)
    }

    /// Records the start of the run.
    pub fn begin(&mut self, simulation: &mut Simulation, interrupt: &mut InterruptCheck) -> Result<()> {
        let conserved = simulation.invariants(interrupt)?;
        self.record.start.get_or_insert(conserved);
        let work_and_impulse = || simulation.work_and_impulse().to_vec();
        self.record.start_work_and_impulse.get_or_insert_with(work_and_impulse);
        if self.times.due(simulation.time()) {
            self.record_present(simulation, interrupt)?;
        }
        Ok(())
    }

    /// Moves the simulation to the end of the run along a closed form of its motion, and records it.
    pub fn follow_closed_form(
        &mut self,
        rotation: SteadyRotation,
        simulation: &mut Simulation,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let y = simulation.propagator.vector().0.to_vec();
        self.tangents.begin_closed_form(&mut simulation.motion.equations, &rotation, &y, interrupt)?;
        while let Some(time) = self.times.take_before(self.until) {
            interrupt.charge(simulation.motion.equations.work(), time)?;
            self.record_closed_form(&rotation, time, simulation, interrupt)?;
        }
        let last = rotation.state(self.until);
        let y = simulation.closed_form_vector(&rotation, &last);
        if self.times.due(self.until) {
            self.record_closed_form(&rotation, self.until, simulation, interrupt)?;
        }
        simulation.propagator.leap(self.until, &y);
        simulation.state_was_set = false;
        if let Some(solution) = &mut self.record.dense {
            solution.set_closed_form(rotation, last);
        }
        Ok(())
    }

    fn record_closed_form(
        &mut self,
        rotation: &SteadyRotation,
        time: f64,
        simulation: &mut Simulation,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let state = rotation.state(time);
        let y = simulation.closed_form_vector(rotation, &state);
        let conserved = simulation.invariants_of(&y, &state, interrupt)?;
        self.tangents.record_closed_form(rotation, time, self.record);
        self.record.push(&state, &conserved, simulation.frame().layout.work_and_impulse(&y));
        Ok(())
    }

    /// Takes one step of the simulation and records it; returns the reason if the run ends in it.
    pub fn step(
        &mut self,
        simulation: &mut Simulation,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<StopReason>> {
        let step_end = self.advance(simulation, interrupt)?;
        let now = simulation.time();
        let end = step_end.contact.map_or(now, |contact| contact.time);
        self.record_before(step_end.event.map_or(end, |(_, time)| time), simulation, interrupt)?;
        if let Some((event, time)) = step_end.event {
            self.tangents.move_to(&mut simulation.last_step(interrupt), time)?;
            simulation.propagator.move_to(time, self.detector.vector());
            simulation.state_was_set = true;
            self.record_present(simulation, interrupt)?;
            return Ok(Some(StopReason::Event(event)));
        }
        if let Some(contact) = step_end.contact {
            simulation.propagator.undo();
            return Err(contact.error(simulation.system()));
        }
        let advanced = self.tangents.advance(&mut simulation.motion, &simulation.propagator, interrupt);
        let tangents = Some(&mut self.tangents);
        let advanced = advanced
            .and_then(|()| step_end.switch.map_or(Ok(()), |force| simulation.switch(force, tangents)));
        advanced.inspect_err(|_| simulation.propagator.undo())?;
        if self.times.due(now) {
            self.record_present(simulation, interrupt)?;
        }
        Ok(None)
    }

    /// Takes one step and finds the event or switch that ends it early. After an error within the step, the
    /// step is taken back with everything found in it, so that a run that continues misses nothing.
    fn advance(&mut self, simulation: &mut Simulation, interrupt: &mut InterruptCheck) -> Result<StepEnd> {
        let (until, with_tangents) = (self.until, self.with_tangents);
        simulation.switch_overdue(Some(&mut self.tangents))?;
        if !self.needs_interior {
            let due = |now| self.times.pending(now).is_some();
            let (contact, switch) = simulation.advance(until, with_tangents, due, interrupt)?;
            return Ok(StepEnd { event: None, contact, switch });
        }
        let (checkpoint, first_event) = (simulation.checkpoint(), self.record.events.len());
        let (contact, switch) = simulation.advance(until, with_tangents, |_| true, interrupt)?;
        let event = self.examine_interior(simulation, contact, interrupt);
        match event.and_then(|event| self.differentiate(first_event, simulation, interrupt).map(|()| event)) {
            Ok(event) => Ok(StepEnd { event, contact, switch }),
            Err(error) => {
                self.record.events.truncate(first_event);
                simulation.restore_checkpoint(&checkpoint, &mut InterruptCheck::never())?;
                Err(error)
            }
        }
    }

    /// Finds the events of the last step and keeps its continuous solution, up to the first terminal event,
    /// whose index and time are returned, or up to the contact of two bodies.
    fn examine_interior(
        &mut self,
        simulation: &Simulation,
        contact: Option<Contact>,
        interrupt: &mut InterruptCheck,
    ) -> Result<Option<(usize, f64)>> {
        let (vector, pieces) = (simulation.propagator.vector().0, simulation.propagator.pieces());
        let Self { detector, events, record, sample, .. } = self;
        let mut stop = None;
        if !events.is_empty() {
            let (end, equations) = ((simulation.time(), vector), &simulation.motion.equations);
            stop = detector.scan(
                equations,
                (pieces, pieces),
                end,
                contact,
                events,
                &mut record.events,
                interrupt,
            )?;
        }
        if let Some(solution) = &mut record.dense {
            let last = match (record.events.last().filter(|_| stop.is_some()), contact) {
                (Some(last), _) => last.state.clone(),
                (None, Some(contact)) => {
                    state_within(simulation.frame(), &pieces[contact.piece], contact.time, sample)
                }
                (None, None) => simulation.state(),
            };
            solution.extend(pieces, last);
        }
        Ok(stop)
    }

    /// Adds the derivatives of the state to each event of the last step; these are the events from the index
    /// `first_event` on.
    fn differentiate(
        &mut self,
        first_event: usize,
        simulation: &mut Simulation,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        for occurrence in &mut self.record.events[first_event..] {
            occurrence.derivatives =
                self.tangents.at(&mut simulation.last_step(interrupt), &occurrence.state)?;
        }
        Ok(())
    }

    /// Records the samples of the last step that are due before a time.
    fn record_before(
        &mut self,
        end: f64,
        simulation: &mut Simulation,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let mut sample = std::mem::take(&mut self.sample);
        while let Some(time) = self.times.take_before(end) {
            let piece = piece_at(simulation.propagator.pieces(), time, self.forward);
            let state = state_within(simulation.frame(), piece, time, &mut sample);
            self.record_state(simulation, &sample, &state, interrupt)?;
        }
        self.sample = sample;
        Ok(())
    }

    /// Returns how the nominal barycentre of third bodies changes with the state at the end of a run that is
    /// differentiated.
    pub fn nominal(&self, simulation: &Simulation) -> Option<NominalChange> {
        let is_needed = simulation.motion.equations.external_forces().has_third_body();
        is_needed.then(|| self.tangents.nominal(&simulation.state()))?
    }

    /// Records the state at which an error ends the run, unless it or a later one has been recorded. A state
    /// whose energy is not finite is left out, since the caller is to receive the error itself.
    pub fn record_last(&mut self, simulation: &mut Simulation) {
        let remaining = (self.until - simulation.time()).abs();
        if self.record.time.last().is_none_or(|last| (self.until - last).abs() > remaining) {
            let _ = self.record_present(simulation, &mut InterruptCheck::never());
        }
    }

    fn record_present(&mut self, simulation: &mut Simulation, interrupt: &mut InterruptCheck) -> Result<()> {
        let state = simulation.state();
        let high = simulation.propagator.vector().0.to_vec();
        self.record_state(simulation, &high, &state, interrupt)
    }

    fn record_state(
        &mut self,
        simulation: &mut Simulation,
        y: &[f64],
        state: &State,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let conserved = simulation.invariants_of(y, state, interrupt)?;
        self.tangents.record(&mut simulation.last_step(interrupt), state, self.record)?;
        self.record.push(state, &conserved, simulation.frame().layout.work_and_impulse(y));
        Ok(())
    }
}
