//! Contacts of particles with surfaces: bounces and impacts, and particles at rest until they lift off.

use super::batch::Batch;
use super::body_ephemeris::LaneBlock;
use super::fate::{ContactResponse, End, Fate, ParticleStatus};
use super::surface::{Landing, SurfaceHit};
use crate::error::Result;
use crate::integrate::{Controller, root};
use crate::math::Vec3;
use crate::math::lanes::BLOCK;
use crate::math::rotation::rotate_back;

/// The number of times in each step of the bodies at which a lift-off is tested.
const LIFT_TESTS: usize = 4;

/// The least push, relative to the sum of the accelerations of which it consists, with which a particle lifts
/// off or flies on after a slow bounce. With a smaller push it would not leave the surface by more than the
/// rounding of its position.
const LIFT: f64 = 1e-7;

/// The time between leaving a surface and striking it again, in units of the time in which the particle would
/// pass its distance from the body's centre, below which the particle has returned at once. After a number of
/// such returns in a row, as in a crease between two faces, it stays for a while.
const AT_ONCE: f64 = 1e-6;
const RETURNS: u32 = 100;
const STAY: f64 = 1e-3;

impl Batch<'_, '_> {
    /// Advances a particle that is not flying to the end of the range, or to where it lifts off. Returns
    /// whether it flies from there.
    pub(super) fn advance_on_surface(&mut self, index: usize) -> Result<bool> {
        let particle = &self.particles[index];
        let ParticleStatus::On { body, point, normal, held } = particle.status else {
            return Ok(
                matches!(particle.status, ParticleStatus::Flying { .. }) && particle.time != self.context.end
            );
        };
        let (start, end) = (particle.time, self.context.end);
        // Particles lift off only in flights forwards in time.
        let from = start.max(held);
        let off = if from < end { self.lift(index, body, (&point, &normal), from, end)? } else { None };
        let until = off.unwrap_or(end);
        let ephemeris = self.context.model.ephemeris;
        while let Some(time) = self.due(index, until, true) {
            let (x, v) = ephemeris.pose(body, time).in_inertial_frame(&point, &Vec3::zeros());
            self.record(index, &x, &v);
        }
        let (x, v) = ephemeris.pose(body, until).in_inertial_frame(&point, &Vec3::zeros());
        let particle = &mut self.particles[index];
        particle.set_motion(until, &x, &v);
        if off.is_some() {
            particle.status = ParticleStatus::Flying { leaving: true };
            particle.next = 0.0;
            particle.left_at = until;
            particle.end = End::default();
        }
        Ok(off.is_some() && until != end)
    }

    /// Handles a particle that has reached a surface.
    pub(super) fn strike(
        &mut self,
        index: usize,
        body: usize,
        hit: SurfaceHit,
        x: &Vec3,
        v: &Vec3,
    ) -> Result<()> {
        let time = hit.time;
        let pose = self.context.model.ephemeris.pose(body, time);
        let landing = self.context.surfaces[body].landing(&pose, hit.part, (x, v));
        let Landing { point, normal, velocity } = landing;
        let inwards = velocity.dot(&normal);
        let across = velocity - normal * inwards;
        let end = End {
            fate: Fate::Impact,
            time,
            body: Some(body),
            longitude: point.y.atan2(point.x),
            latitude: point.z.atan2(point.x.hypot(point.y)),
            speed: velocity.norm(),
            incidence: across.norm().atan2(-inwards),
        };
        let held = |until: f64| ParticleStatus::On { body, point, normal, held: until };
        self.particles[index].strikes += 1;
        let (moving, end, status) = match self.context.rules.contact {
            ContactResponse::Stop => {
                (pose.in_inertial_frame(&point, &Vec3::zeros()), end, held(f64::INFINITY))
            }
            ContactResponse::Remove => ((*x, *v), end, ParticleStatus::Gone),
            ContactResponse::Bounce { normal: along, tangential, rest } => {
                let out = across * tangential - normal * (along * inwards);
                let distance = point.norm();
                let passing = distance / (v.norm() + (self.context.mu / distance).sqrt());
                let particle = &mut self.particles[index];
                let at_once = (time - particle.left_at).abs() <= AT_ONCE * passing;
                particle.returns = if at_once { particle.returns + 1 } else { 0 };
                let stays = particle.returns > RETURNS;
                let slow = -along * inwards < rest;
                // The acceleration is computed with the velocity after the bounce: where a particle at rest
                // would be lifted, one that moves against the rotation may be pressed down, and would bounce
                // forever.
                if stays
                    || slow
                        && self.outward_acceleration(index, body, (&point, &normal, &out), [time; BLOCK])?[0]
                            <= LIFT
                {
                    let end = End { fate: Fate::Rest, ..end };
                    let until = if stays { time + STAY * passing } else { time };
                    (pose.in_inertial_frame(&point, &Vec3::zeros()), end, held(until))
                } else {
                    let particle = &mut self.particles[index];
                    (particle.next, particle.controller, particle.left_at) = (0.0, Controller::new(), time);
                    (
                        pose.in_inertial_frame(&point, &out),
                        End::default(),
                        ParticleStatus::Flying { leaving: true },
                    )
                }
            }
        };
        let particle = &mut self.particles[index];
        (particle.end, particle.status) = (end, status);
        particle.set_motion(time, &moving.0, &moving.1);
        Ok(())
    }

    /// Returns the outward acceleration along the normal of a particle on a body, with a velocity relative to
    /// the surface, at the times of a block: divided by the sum of the magnitudes of all accelerations.
    fn outward_acceleration(
        &mut self,
        index: usize,
        body: usize,
        (point, normal, velocity): (&Vec3, &Vec3, &Vec3),
        times: LaneBlock,
    ) -> Result<LaneBlock> {
        let ephemeris = self.context.model.ephemeris;
        let probe = &mut self.probe;
        probe.time = times;
        probe.area_to_mass = [self.particles[index].area_to_mass; BLOCK];
        let poses = times.map(|time| ephemeris.pose(body, time));
        for (lane, pose) in poses.iter().enumerate() {
            let (x, v) = pose.in_inertial_frame(point, &Vec3::zeros());
            for c in 0..3 {
                (probe.motion[c][lane], probe.motion[3 + c][lane]) = (x[c], v[c]);
            }
        }
        probe.begin()?;
        Ok(std::array::from_fn(|lane| {
            let (acceleration, angular_acceleration) = ephemeris.rates(body, times[lane]);
            let spin = poses[lane].spin;
            let parts = [
                rotate_back(&poses[lane].rotation, &(probe.first(lane) - acceleration)),
                -angular_acceleration.cross(point),
                -spin.cross(&spin.cross(point)),
                -2.0 * spin.cross(velocity),
            ];
            let size: f64 = parts.iter().map(Vec3::norm).sum();
            if size > 0.0 { normal.dot(&parts.iter().sum::<Vec3>()) / size } else { 0.0 }
        }))
    }

    /// Returns when a particle at rest lifts off.
    fn lift(
        &mut self,
        index: usize,
        body: usize,
        at: (&Vec3, &Vec3),
        start: f64,
        end: f64,
    ) -> Result<Option<f64>> {
        let ephemeris = self.context.model.ephemeris;
        let at = (at.0, at.1, &Vec3::zeros());
        let mut last = (start, self.outward_acceleration(index, body, at, [start; BLOCK])?[0] - LIFT);
        if last.1 > 0.0 {
            return Ok(Some(start));
        }
        while last.0 != end {
            // Several times in each step of the bodies are tested, one after the other.
            let mut time = last.0;
            let times: LaneBlock = std::array::from_fn(|_| {
                let [from, to] = ephemeris.ends(ephemeris.index(time));
                let stride = (to - from) / LIFT_TESTS as f64;
                time = if end - time > stride { time + stride } else { end };
                time
            });
            let accelerations = self.outward_acceleration(index, body, at, times)?;
            for next in times.into_iter().zip(accelerations.map(|outward| outward - LIFT)) {
                if next.1 > 0.0 {
                    let outward =
                        |time: f64| Ok(self.outward_acceleration(index, body, at, [time; BLOCK])?[0] - LIFT);
                    return root(outward, last, next).map(Some);
                }
                last = next;
            }
        }
        Ok(None)
    }
}
