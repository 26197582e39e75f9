//! The brightness of a body by the facets of its parts, and its derivatives with respect to poses, vertices,
//! semi-axes and directions.
//!
//! The brightness of an ellipsoid from which others hide light is B = W L / A, where W is its brightness without
//! occluders, and L and A are the sums over the facets of its mesh with and without occluders. The derivatives are
//! dW L / A + (dL - dA L / A) W / A. Their error is of the order of the facets' size; B itself has the share of
//! finer cells in place of L / A.

use super::convex::ConvexBody;
use super::ellipsoid::{EllipsoidPose, LitEllipsoid, Partials};
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
    Ellipsoid(LitEllipsoid<'a>),
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
                    let (position, part_rotation) = &part.mesh.pose;
                    let moment = Vec3::new(*x, *y, *z) + part_rotation.tr_mul(position) * *brightness;
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
                let brightness = match &part.mesh.polyhedron {
                    Some(_) => add_facets(part, &body.surface, partials, interrupt)?,
                    None => add_ellipsoid(part, &body.surface, partials, interrupt)?,
                };
                Ok(sum + brightness)
            }),
        }
    }
}

/// Returns the brightness of the facets of a part and adds its derivatives.
fn add_facets(
    part: &FacetedPart<'_>,
    surface: &SurfaceLight<'_>,
    partials: &mut Partials,
    interrupt: &mut InterruptCheck,
) -> Result<f64> {
    let (brightness, gradient) = part.partials(surface, interrupt)?;
    add(partials, part.mesh, &part.rotation, 1.0, &gradient.vertices);
    for (occluder, by_vertex) in part.occluders.iter().zip(&gradient.occluders) {
        let rotation = part.rotation * occluder.rotation;
        add(partials, occluder.mesh, &rotation, occluder.growth, by_vertex);
    }
    for (k, by_light) in gradient.lights.iter().enumerate() {
        partials.by_direction[k] += part.rotation * by_light;
    }
    Ok(brightness)
}

/// Returns the brightness of a part that is an ellipsoid and adds its derivatives.
fn add_ellipsoid(
    part: &FacetedPart<'_>,
    surface: &SurfaceLight<'_>,
    partials: &mut Partials,
    interrupt: &mut InterruptCheck,
) -> Result<f64> {
    let (mesh, [body, _], albedo) = (part.mesh, part.mesh.indices, surface.albedo[0]);
    let directions = part.lights.map(|light| part.rotation * light);
    let ellipsoid_pose =
        EllipsoidPose { body, semi_axes: mesh.semi_axes, position: Vec3::zeros(), rotation: part.rotation };
    let lit = LitEllipsoid::new(&ellipsoid_pose, surface.law, surface.time, directions, std::iter::empty());
    let mut ellipsoid_partials = partials.zeros();
    let unhidden = albedo * lit.partials(&mut ellipsoid_partials, interrupt)?;
    let by_body = &mut ellipsoid_partials.by_body[body];
    by_body.rotation = mesh.pose.1 * by_body.rotation;
    let mut add = |part: &Partials, factor: f64| partials.add(part, factor, [&directions; 2]);
    if part.occluders.is_empty() {
        add(&ellipsoid_partials, albedo);
        return Ok(unhidden);
    }
    let brightness = part.light::<1>(surface, interrupt)?[0];
    let [mut unhidden_partials, mut all_partials] = [ellipsoid_partials.zeros(), ellipsoid_partials.zeros()];
    let alone = FacetedPart { occluders: Vec::new(), ..*part };
    let left = add_facets(part, surface, &mut unhidden_partials, interrupt)?;
    let all = add_facets(&alone, surface, &mut all_partials, interrupt)?;
    // The facets give no light for a crescent that is thinner than they are.
    let (share, scale) = if all > 0.0 { (left / all, unhidden / all) } else { (brightness / unhidden, 0.0) };
    add(&ellipsoid_partials, albedo * share);
    add(&unhidden_partials, scale);
    add(&all_partials, -scale * share);
    Ok(brightness)
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
    let (position, part_rotation) = &mesh.pose;
    partials.by_body[body].position += rotation * force / growth;
    partials.by_body[body].rotation += part_rotation * torque + position.cross(&(part_rotation * force));
    if mesh.polyhedron.is_none() {
        // The vertices of an ellipsoid's facets stretch with its axes.
        let stretch = mesh.vertices.iter().zip(by_vertex).map(|(v, by)| v.component_mul(by)).sum::<Vec3>();
        partials.by_body[body].semi_axes += stretch.component_div(&mesh.semi_axes);
    }
    if let Some(sums) = partials.by_vertex.get_mut(body) {
        sums.iter_mut().zip(by_vertex).for_each(|(sum, derivative)| *sum += part_rotation * derivative);
    }
}
