//! Particles at surfaces: what a contact does, and those that lie on a body until they lift off.

use super::course::Block;
use super::fate::{Contact, End, Fate, Place};
use super::push::Batch;
use super::surface::{Landing, Meeting};
use crate::error::Result;
use crate::integrate::{Controller, root};
use crate::math::Vec3;
use crate::math::lanes::BLOCK;
use crate::math::rotation::turned_back;

/// Looks for a lift-off in each step of the bodies.
const LOOKS: usize = 4;

impl Batch<'_, '_> {
    /// Takes a particle that does not fly to the end of the stretch, or to where it lifts off. Whether it is to fly then.
    pub(super) fn carry(&mut self, index: usize) -> Result<bool> {
        let particle = &self.particles[index];
        let Place::On { body, place, normal, held } = particle.place else {
            return Ok(matches!(particle.place, Place::Flying { .. }) && particle.time != self.flying.end);
        };
        let (start, end) = (particle.time, self.flying.end);
        let off = if held { None } else { self.lift(index, body, (&place, &normal), start, end)? };
        let until = off.unwrap_or(end);
        let course = self.flying.world.course;
        while let Some(time) = self.due(index, until, true) {
            let (x, v) = course.pose(body, time).without(&place, &Vec3::zeros());
            self.record(index, &x, &v);
        }
        let (x, v) = course.pose(body, until).without(&place, &Vec3::zeros());
        let particle = &mut self.particles[index];
        particle.put(until, &x, &v);
        if off.is_some() {
            particle.place = Place::Flying { departing: true };
            particle.next = 0.0;
            particle.end = End::default();
        }
        Ok(off.is_some() && until != end)
    }

    /// A particle at a surface.
    pub(super) fn strike(
        &mut self,
        index: usize,
        body: usize,
        meeting: Meeting,
        x: &Vec3,
        v: &Vec3,
    ) -> Result<()> {
        let time = meeting.time;
        let pose = self.flying.world.course.pose(body, time);
        let landing = self.flying.surfaces[body].landing(&pose, meeting.part, (x, v));
        let Landing { place, normal, velocity } = landing;
        let inwards = velocity.dot(&normal);
        let across = velocity - normal * inwards;
        let end = End {
            fate: Fate::Impact,
            time,
            body: Some(body),
            longitude: place.y.atan2(place.x),
            latitude: place.z.atan2(place.x.hypot(place.y)),
            speed: velocity.norm(),
            incidence: across.norm().atan2(-inwards),
        };
        let held = Place::On { body, place, normal, held: true };
        self.particles[index].strikes += 1;
        let (moving, end, place) = match self.flying.rules.contact {
            Contact::Stop => (pose.without(&place, &Vec3::zeros()), end, held),
            Contact::Remove => ((*x, *v), end, Place::Gone),
            Contact::Bounce { normal: along, tangential, rest } => {
                let out = across * tangential - normal * (along * inwards);
                // Where a particle at rest would be lifted, one that goes against the rotation may be pressed down, and would
                // bounce without an end.
                let coriolis = -2.0 * normal.dot(&pose.spin.cross(&out));
                if -along * inwards < rest
                    && self.pushes(index, body, (&place, &normal), [time; BLOCK])?[0] + coriolis < 0.0
                {
                    let lying = Place::On { body, place, normal, held: false };
                    let end = End { fate: Fate::Rest, ..end };
                    (pose.without(&place, &Vec3::zeros()), end, lying)
                } else {
                    let particle = &mut self.particles[index];
                    (particle.next, particle.controller) = (0.0, Controller::new());
                    (pose.without(&place, &out), End::default(), Place::Flying { departing: true })
                }
            }
        };
        let particle = &mut self.particles[index];
        (particle.end, particle.place) = (end, place);
        particle.put(time, &moving.0, &moving.1);
        Ok(())
    }

    /// How strongly a particle at rest on a body is pushed outwards along the normal, relative to the surface, at the times of a
    /// block.
    fn pushes(
        &mut self,
        index: usize,
        body: usize,
        (place, normal): (&Vec3, &Vec3),
        times: Block,
    ) -> Result<Block> {
        let course = self.flying.world.course;
        let probe = &mut self.probe;
        probe.time = times;
        probe.area_to_mass = [self.particles[index].area_to_mass; BLOCK];
        let poses = times.map(|time| course.pose(body, time));
        for (lane, pose) in poses.iter().enumerate() {
            let (x, v) = pose.without(place, &Vec3::zeros());
            for c in 0..3 {
                (probe.motion[c][lane], probe.motion[3 + c][lane]) = (x[c], v[c]);
            }
        }
        probe.begin()?;
        Ok(std::array::from_fn(|lane| {
            let (acceleration, turning) = course.rates(body, times[lane]);
            let spin = poses[lane].spin;
            let pull = turned_back(&poses[lane].rotation, &(probe.first(lane) - acceleration));
            normal.dot(&(pull - turning.cross(place) - spin.cross(&spin.cross(place))))
        }))
    }

    /// When a particle at rest lifts off.
    fn lift(
        &mut self,
        index: usize,
        body: usize,
        at: (&Vec3, &Vec3),
        start: f64,
        end: f64,
    ) -> Result<Option<f64>> {
        let course = self.flying.world.course;
        let mut last = (start, self.pushes(index, body, at, [start; BLOCK])?[0]);
        if last.1 > 0.0 {
            return Ok(Some(start));
        }
        while last.0 != end {
            // A few places of each step of the bodies, one after the other.
            let mut time = last.0;
            let times: Block = std::array::from_fn(|_| {
                let [from, to] = course.ends(course.index(time));
                let stride = (to - from) / LOOKS as f64;
                time = if end - time > stride { time + stride } else { end };
                time
            });
            let pushes = self.pushes(index, body, at, times)?;
            for next in times.into_iter().zip(pushes) {
                if next.1 > 0.0 {
                    let push = |time: f64| Ok(self.pushes(index, body, at, [time; BLOCK])?[0]);
                    return root(push, last, next).map(Some);
                }
                last = next;
            }
        }
        Ok(None)
    }
}
