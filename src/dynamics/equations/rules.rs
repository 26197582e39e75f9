//! The quadrature rules: their choice between steps, and their form in archives.

use super::layout::{AttitudeChart, vector};
use super::{Dynamics, LINK, POLE};
use crate::error::{Error, Result};
use crate::forces::Switch;
use crate::interrupt::{InterruptCheck, UNITS};
use crate::mutual::{Pair, Pose, PredictedMotion, RuleMemory};
use crate::shape::least_distance;

/// The units of work of choosing or restoring a link's rule, and of copying it from another object.
const CHOICE: u64 = 50;
const COPY: u64 = 10;

impl Dynamics {
    /// Returns the rules in use of all pairs and the switches of the forces, for an archive.
    pub fn memory(&self) -> (Vec<Option<RuleMemory>>, Vec<Option<Switch>>) {
        (self.links.iter().map(|(_, _, link)| link.pair.memory()).collect(), self.external_forces.switches())
    }

    /// Restores the rules and switches that [`Self::memory`] returned.
    pub fn restore_memory(
        &mut self,
        memory: &[Option<RuleMemory>],
        switches: &[Option<Switch>],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.external_forces.set_switches(switches)?;
        if memory.len() != self.links.len() {
            return Err(Error::invalid("number of rules", memory.len(), self.links.len().to_string()));
        }
        for ((.., link), memory) in self.links.iter_mut().zip(memory) {
            interrupt.charge(CHOICE, 0.0)?;
            link.pair.restore_memory(memory.as_ref(), interrupt)?;
            interrupt.charge(link.pair.work(), 0.0)?;
        }
        Ok(())
    }

    /// Uses the rules that another object of the same system uses.
    pub fn copy_rules(&mut self, from: &Self, interrupt: &mut InterruptCheck) -> Result<()> {
        for ((.., link), (.., from)) in self.links.iter_mut().zip(&from.links) {
            interrupt.charge(COPY, 0.0)?;
            link.pair.copy_rule(&from.pair);
        }
        self.parts.clone_from(&from.parts);
        self.work = from.work;
        Ok(())
    }

    /// Checks a state and chooses the rules for a step of size `step` from it.
    pub fn prepare(&mut self, time: f64, y: &[f64], step: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        self.update_rotations(y);
        if self.layout.chart == AttitudeChart::TaitBryan {
            for body in 0..self.layout.bodies {
                // The cosine starts positive; a changed sign means that a step has passed over a pole.
                let cos_theta = y[self.layout.attitude(body) + 1].cos();
                if cos_theta < 10.0 * POLE {
                    let body = self.system.bodies()[body].name.clone();
                    return Err(Error::ChartSingularity { body, time, cos_theta });
                }
            }
        }
        if self.layout.forces > 0 {
            self.external_forces.begin_step(self.view.take_snapshot(time, y), step)?;
        }
        let mut work = LINK + self.external_forces.work();
        let mut index = 0;
        while let Some(&(i, j, _)) = self.links.get(index) {
            interrupt.charge(CHOICE, time)?;
            let pose = self.pose(y, i, j);
            let growth = self.system.check_overlap(i, j, &pose, time, interrupt)?;
            let predicted = self.predict(y, i, j, &pose, growth, step);
            while let Some((a, b, link)) = self.links.get_mut(index)
                && (*a, *b) == (i, j)
            {
                interrupt.charge(CHOICE, time)?;
                link.prepare(&pose, predicted.as_ref(), interrupt).map_err(|error| error.at(time))?;
                work += LINK + link.pair.work();
                index += 1;
            }
        }
        self.divide(work);
        Ok(())
    }

    /// Divides an evaluation of this much work into parts of about equally many links; a link with much work
    /// is divided into several parts.
    fn divide(&mut self, work: u64) {
        let count = self.links.len();
        let target = work.div_ceil(UNITS).min(count as u64).max(1) as usize;
        let in_part = count.div_ceil(target);
        self.parts.clear();
        let mut start = 0;
        for (index, (.., link)) in self.links.iter().enumerate() {
            let pieces = link.pair.pieces();
            if pieces.len() > 1 {
                if start < index {
                    self.parts.push((start..index, Pair::ALL));
                }
                self.parts.extend(pieces.map(|nodes| (index..index + 1, nodes)));
                start = index + 1;
            } else if index + 1 - start == in_part {
                self.parts.push((start..index + 1, Pair::ALL));
                start = index + 1;
            }
        }
        // A system without links may still have external forces.
        if start < count || self.parts.is_empty() {
            self.parts.push((start..count, Pair::ALL));
        }
        self.work = work / self.parts.len() as u64;
    }

    /// Returns the predicted motion of two bodies in a step, along straight lines and with the deviation from
    /// these by attraction; `None` for a step of size zero.
    fn predict(
        &self,
        y: &[f64],
        i: usize,
        j: usize,
        pose: &Pose,
        growth: f64,
        step: f64,
    ) -> Option<PredictedMotion> {
        if step == 0.0 {
            return None;
        }
        let (vi, vj) = (self.layout.velocity(i), self.layout.velocity(j));
        let path = (vector(y, vj) - vector(y, vi)) * step;
        let distance = pose.separation.norm();
        let bodies = self.system.bodies();
        let mu = self.system.gravitational_constant * (bodies[i].mass + bodies[j].mass);
        let fall = 0.5 * mu * (step / distance).powi(2);
        let rotation_angle = |body: usize| vector(y, self.layout.spin(body)).norm() * step.abs();
        Some(PredictedMotion {
            reach: least_distance(&pose.separation, &path) - fall,
            rotation_angles: [rotation_angle(i), rotation_angle(j)],
            growth,
        })
    }
}
