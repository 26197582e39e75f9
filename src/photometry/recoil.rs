//! The force and torque of sunlight on a body whose surface scatters and radiates by Lambert's law and has no
//! thermal inertia.
//!
//! A facet of normal n takes the momentum of the light that falls on it from the direction s, and sends the same
//! power out at once, reflected or as heat. The recoil of light sent out by Lambert's law is two thirds of that of
//! a beam along the normal. With the pressure P of sunlight and the lit area A the force is
//!
//! F = -P A n.s (s + 2/3 n),
//!
//! whatever the albedo is, and acts at the centroid of the lit area. J. McMahon & D. Scheeres (2010), Icarus 209,
//! 494, define it so: it is that of their program YORPLib for a surface without specular reflection. Light that a
//! facet receives from another one is neglected.

use super::facets::{FacetedPart, Occluder, shares};
use super::mesh::Mesh;
use super::parallel::in_parallel;
use super::region::Region;
use crate::error::{Error, Result, require_finite};
use crate::interrupt::{InterruptCheck, UNITS};
use crate::math::{Mat3, Vec3};
use crate::shape::{Body, Proximity};

/// The units of work of a facet, and of one of which a part may be hidden.
const WORK: [u64; 2] = [1, 20];

/// The recoil of a Lambertian facet, divided by that of a beam along its normal.
const LAMBERT: f64 = 2.0 / 3.0;

/// Computes the force and the torque about the centre of mass for unit pressure of sunlight, in the body frame, for
/// each of these directions to the Sun, vectors of any length in the body frame. The light is parallel. Parts of
/// the body hide light from each other, and so do other bodies at fixed positions in the body frame, whose axes
/// are parallel to those of the body. Ellipsoids have the facets of a subdivided icosahedron.
///
/// # Errors
/// [`Error::InvalidInput`] for a body without a surface and for numbers that are not finite,
/// [`Error::BodiesOverlap`], and [`Error::Interrupted`].
pub fn recoil(
    body: &Body,
    others: &[(Body, Vec3)],
    to_sun: &[Vec3],
    interrupt: &mut InterruptCheck,
) -> Result<Vec<[Vec3; 2]>> {
    let surface = RecoilingSurface::new(body, others, interrupt)?;
    for (index, direction) in to_sun.iter().enumerate() {
        require_finite(&format!("direction {index} to the Sun"), direction.as_slice())?;
        if *direction == Vec3::zeros() {
            let what = format!("direction {index} to the Sun");
            return Err(Error::invalid(what, "zero", "a direction, of any length above zero"));
        }
    }
    let work = WORK[1] * surface.meshes_of_body().map(|mesh| mesh.facets.len() as u64).sum::<u64>();
    let recoils = |to_sun: &[Vec3], interrupt: &mut InterruptCheck| {
        to_sun.iter().map(|direction| surface.recoil(&direction.normalize(), interrupt)).collect()
    };
    if work > 5 * UNITS {
        return recoils(to_sun, interrupt);
    }
    in_parallel(to_sun, (UNITS / work.max(1)).max(1) as usize, &|_| 0.0, interrupt, recoils)
}

/// The facets of the parts of a body, and those of other bodies that hide light from it.
struct RecoilingSurface {
    /// The facets of all parts; those of the body itself have the index 0 of bodies.
    meshes: Vec<Mesh>,
    /// The positions of all bodies in the body frame; that of the body itself is zero.
    centres: Vec<Vec3>,
}

impl RecoilingSurface {
    fn new(body: &Body, others: &[(Body, Vec3)], interrupt: &mut InterruptCheck) -> Result<Self> {
        let mut bodies = vec![(body, Vec3::zeros())];
        for (other, position) in others {
            require_finite(&format!("position of {}", other.name), position.as_slice())?;
            let axes = Mat3::identity();
            if Proximity::compute([body, other], position, [&axes; 2], 0.0, interrupt)?.overlap {
                let [first, second] = [body, other].map(|body| body.name.clone());
                return Err(Error::BodiesOverlap { first, second, time: 0.0 });
            }
            bodies.push((other, *position));
        }
        let mut meshes = Vec::new();
        for (k, (body, _)) in bodies.iter().enumerate() {
            body.require_surface()?;
            meshes.extend(body.outer_parts().enumerate().filter_map(|(i, part)| Mesh::new([k, i], part)));
        }
        let surface = Self { meshes, centres: bodies.into_iter().map(|(_, position)| position).collect() };
        if surface.meshes_of_body().next().is_none() {
            return Err(Error::invalid(
                &body.name,
                "a point",
                "a body with a surface, which sunlight pushes",
            ));
        }
        for mesh in surface.meshes_of_body() {
            mesh.horizons(interrupt)?;
        }
        Ok(surface)
    }

    /// Iterates over the parts of the body itself.
    fn meshes_of_body(&self) -> impl Iterator<Item = &Mesh> {
        self.meshes.iter().filter(|mesh| mesh.indices[0] == 0)
    }

    /// Returns the force and the torque for unit pressure of sunlight from a unit vector, in the body frame.
    fn recoil(&self, to_sun: &Vec3, interrupt: &mut InterruptCheck) -> Result<[Vec3; 2]> {
        let mut load = [Vec3::zeros(); 2];
        for mesh in self.meshes_of_body() {
            interrupt.charge(WORK[0] * mesh.facets.len() as u64, 0.0)?;
            let (origin, rotation) = mesh.pose;
            let light = rotation.tr_mul(to_sun);
            let others = self.meshes.iter().filter(|other| other.indices != mesh.indices);
            let occluders = others.filter_map(|other| {
                let from = self.centres[other.indices[0]] + other.pose.0 - origin;
                let pose = (rotation.tr_mul(&from), rotation.tr_mul(&other.pose.1));
                Occluder::new(mesh, other, pose, 1.0, 0, &light)
            });
            let occluders = occluders.collect();
            let horizons = mesh.horizons(interrupt)?;
            FacetedPart { mesh, horizons, rotation, lights: [light], occluders }
                .add_recoil(&mut load, interrupt)?;
        }
        Ok(load)
    }
}

impl FacetedPart<'_, 1> {
    /// Adds the force and the torque for unit pressure, in the body frame.
    fn add_recoil(&self, load: &mut [Vec3; 2], interrupt: &mut InterruptCheck) -> Result<()> {
        let ([s], (position, rotation), mut region) = (&self.lights, self.mesh.pose, Region::default());
        for (index, facet) in self.mesh.facets.iter().enumerate() {
            let mu0 = facet.normal.dot(s);
            if mu0 <= 0.0 {
                continue;
            }
            let partly = self.clip(facet, Some((index, [mu0])), &mut region);
            if partly {
                interrupt.charge(WORK[1], 0.0)?;
            }
            let [share, x, y, z] = shares(facet, partly.then_some(&region));
            let force = rotation * (s + facet.normal * LAMBERT) * (-mu0 * facet.area);
            load[0] += force * share;
            load[1] += (position * share + rotation * Vec3::new(x, y, z)).cross(&force);
        }
        Ok(())
    }
}
