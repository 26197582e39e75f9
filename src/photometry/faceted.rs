//! The brightness of a body by the facets of its parts, and its derivatives with respect to poses, vertices and
//! directions.

use super::convex::ConvexBody;
use super::ellipsoid::{Lit, Partials};
use super::facets::{FacetedPart, SurfaceLight};
use super::mesh::Mesh;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::{Mat3, Vec3};

/// A body in sunlight, described by the facets of its parts.
pub struct FacetedBody<'a> {
    pub parts: Vec<FacetedPart<'a>>,
    pub surface: SurfaceLight<'a>,
}

/// A body in sunlight: an ellipsoid about its centre of mass, a convex body that is known by the areas of its
/// facets, or a body of any other shape.
pub enum Target<'a> {
    Ellipsoid(Lit<'a>),
    Convex(ConvexBody<'a>),
    Facets(FacetedBody<'a>),
}

impl Target<'_> {
    /// Returns the brightness in squared length; if W is four, then the sums of it times the components of the vector
    /// from the body's centre, inertial. The light of an ellipsoid does not contain the albedo.
    pub fn light<const W: usize>(&self, interrupt: &mut InterruptCheck) -> Result<[f64; W]> {
        match self {
            Self::Ellipsoid(lit) => lit.light(interrupt),
            // Without vertices the light has no centre, for which `Photometer::moments_in` refuses such bodies.
            Self::Convex(body) => {
                let brightness = body.brightness(interrupt)?;
                Ok(std::array::from_fn(|k| if k == 0 { brightness } else { 0.0 }))
            }
            Self::Facets(body) => body.parts.iter().try_fold([0.0; W], |mut sums, part| {
                let mut light = part.light::<W>(&body.surface, interrupt)?;
                if let [brightness, x, y, z] = &mut light[..] {
                    let (position, pose) = &part.mesh.pose;
                    let moment = Vec3::new(*x, *y, *z) + pose.tr_mul(position) * *brightness;
                    [*x, *y, *z] = (part.rotation * moment).into();
                }
                sums.iter_mut().zip(light).for_each(|(sum, part)| *sum += part);
                Ok(sums)
            }),
        }
    }

    /// Returns the brightness and adds its derivatives to `partials`.
    pub fn partials(&self, partials: &mut Partials, interrupt: &mut InterruptCheck) -> Result<f64> {
        match self {
            Self::Ellipsoid(lit) => lit.partials(partials, interrupt),
            Self::Convex(body) => body.partials(partials, interrupt),
            Self::Facets(body) => body.parts.iter().try_fold(0.0, |sum, part| {
                let (brightness, gradient) = part.partials(&body.surface, interrupt)?;
                add(partials, part.mesh, &part.rotation, 1.0, &gradient.vertices);
                for (occluder, by_vertex) in part.occluders.iter().zip(&gradient.occluders) {
                    let rotation = part.rotation * occluder.rotation;
                    add(partials, occluder.mesh, &rotation, occluder.growth, by_vertex);
                }
                for (k, by_light) in gradient.lights.iter().enumerate() {
                    partials.by_direction[k] += part.rotation * by_light;
                }
                Ok(sum + brightness)
            }),
        }
    }
}

/// Adds the derivatives that follow from those with respect to the vertices of a part, in its frame. The
/// part has this rotation to the inertial frame, and is scaled by `growth`.
fn add(partials: &mut Partials, mesh: &Mesh, rotation: &Mat3, growth: f64, by_vertex: &[Vec3]) {
    let [body, _] = mesh.indices;
    let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
    for (vertex, derivative) in mesh.vertices.iter().zip(by_vertex) {
        force += derivative;
        torque += vertex.cross(derivative);
    }
    let (position, pose) = &mesh.pose;
    partials.by_body[body].position += rotation * force / growth;
    partials.by_body[body].rotation += pose * torque + position.cross(&(pose * force));
    if let Some(sums) = partials.by_vertex.get_mut(body) {
        sums.iter_mut().zip(by_vertex).for_each(|(sum, derivative)| *sum += pose * derivative);
    }
}
