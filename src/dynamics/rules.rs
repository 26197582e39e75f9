//! The rules of the quadratures: chosen between steps, kept in archives, put in force again.

use super::equations::{LINK, POLE};
use super::layout::vector;
use super::{AttitudeChart, Dynamics};
use crate::environment::Switch;
use crate::error::{Error, Result};
use crate::mutual::{Foreseen, Pair, Pose, RuleMemory};
use crate::patience::{Patience, UNITS};

/// Units of work of choosing a link's rule or putting one in force again, and of taking it over from another object.
const CHOICE: u64 = 50;
const COPY: u64 = 10;

impl Dynamics {
    /// The rules in force of all pairs, and which forces are switched on, for an archive.
    pub fn memory(&self) -> (Vec<Option<RuleMemory>>, Vec<Option<Switch>>) {
        (self.links.iter().map(|(_, _, link)| link.pair.memory()).collect(), self.outside.switches())
    }

    /// Puts in force what [`Self::memory`] gave.
    pub fn recall(
        &mut self,
        memory: &[Option<RuleMemory>],
        switches: &[Option<Switch>],
        patience: &mut Patience,
    ) -> Result<()> {
        self.outside.recall(switches)?;
        if memory.len() != self.links.len() {
            return Err(Error::invalid("number of rules", memory.len(), self.links.len().to_string()));
        }
        for ((.., link), memory) in self.links.iter_mut().zip(memory) {
            patience.spend(CHOICE, 0.0)?;
            link.pair.recall(memory.as_ref(), patience)?;
            patience.spend(link.pair.work(), 0.0)?;
        }
        Ok(())
    }

    /// Puts the rules in force that another object of the same system has in force.
    pub fn copy_rules(&mut self, from: &Self, patience: &mut Patience) -> Result<()> {
        for ((.., link), (.., from)) in self.links.iter_mut().zip(&from.links) {
            patience.spend(COPY, 0.0)?;
            link.pair.copy_rule(&from.pair);
        }
        self.parts.clone_from(&from.parts);
        self.work = from.work;
        Ok(())
    }

    /// Checks a state and chooses the rules for a step of size `step` from it.
    pub fn prepare(&mut self, time: f64, y: &[f64], step: f64, patience: &mut Patience) -> Result<()> {
        self.turn(y);
        if self.layout.chart == AttitudeChart::TaitBryan {
            for body in 0..self.layout.bodies {
                // Positive to begin with; the sign tells a pole that was stepped over.
                let cos_theta = y[self.layout.attitude(body) + 1].cos();
                if cos_theta < 10.0 * POLE {
                    let body = self.system.bodies()[body].name.clone();
                    return Err(Error::ChartSingularity { body, time, cos_theta });
                }
            }
        }
        if self.layout.forces > 0 {
            self.outside.switch(self.view.show(time, y), step)?;
        }
        let mut work = LINK + self.outside.work();
        let mut index = 0;
        while let Some(&(i, j, _)) = self.links.get(index) {
            patience.spend(CHOICE, time)?;
            let pose = self.pose(y, i, j);
            let growth = self.system.check_apart(i, j, &pose, time, patience)?;
            let foreseen = self.foresee(y, i, j, &pose, growth, step);
            while let Some((a, b, link)) = self.links.get_mut(index)
                && (*a, *b) == (i, j)
            {
                patience.spend(CHOICE, time)?;
                link.prepare(&pose, foreseen.as_ref(), patience).map_err(|error| error.at(time))?;
                work += LINK + link.pair.work();
                index += 1;
            }
        }
        self.divide(work);
        Ok(())
    }

    /// Divides an evaluation of so much work into parts: of as many links each, and a link that takes many units of several.
    fn divide(&mut self, work: u64) {
        let count = self.links.len();
        let wanted = work.div_ceil(UNITS).min(count as u64).max(1) as usize;
        let in_part = count.div_ceil(wanted);
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
        // One without links may still have forces from outside.
        if start < count || self.parts.is_empty() {
            self.parts.push((start..count, Pair::ALL));
        }
        self.work = work / self.parts.len() as u64;
    }

    /// How two bodies may move in a step: straight on, and falling from that line; none in a step of no size.
    fn foresee(
        &self,
        y: &[f64],
        i: usize,
        j: usize,
        pose: &Pose,
        growth: f64,
        step: f64,
    ) -> Option<Foreseen> {
        if step == 0.0 {
            return None;
        }
        let (vi, vj) = (self.layout.velocity(i), self.layout.velocity(j));
        let path = (vector(y, vj) - vector(y, vi)) * step;
        let distance = pose.separation.norm();
        let length = path.norm_squared();
        let bodies = self.system.bodies();
        let mu = self.system.gravitational_constant * (bodies[i].mass + bodies[j].mass);
        let fall = 0.5 * mu * (step / distance).powi(2);
        let nearest = if length > 0.0 { (-pose.separation.dot(&path) / length).clamp(0.0, 1.0) } else { 0.0 };
        let turn = |body: usize| vector(y, self.layout.spin(body)).norm() * step.abs();
        Some(Foreseen {
            reach: (pose.separation + path * nearest).norm() - fall,
            turns: [turn(i), turn(j)],
            growth,
        })
    }
}
