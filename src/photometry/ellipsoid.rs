//! The brightness of one ellipsoid, which others may occult or eclipse, and its derivatives with respect to
//! everything that it depends on.
//!
//! With e toward the observer, s toward the Sun, p = A^-1 R^T e and q = A^-1 R^T s the brightness is B = abc
//! b(p, q, outlines). The derivatives of b with respect to p and q are integrals over the part that is
//! visible and illuminated. An outline contributes an integral along itself. Let x be a point of it, d the
//! direction along which light is hidden, X = x + h d the point of the hiding ellipsoid at which the ray
//! from x is tangent, and N the normal at X. Where these change, the function that is zero on the outline
//! changes at x by 2 N.(dx + reach dd - dX); a change of h has no effect, since N is perpendicular to
//! d.

use super::kernel::{PARTIALS, ScatteringKernel};
use super::law::Law;
use super::lune::{Longitude, Lune};
use super::mesh::Facet;
use super::outline::{HidingEllipsoid, Light, Outline, cylinder_level};
use super::strips::{StripMoments, Strips};
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::compensated::Compensated;
use crate::math::rotation::rotate_back;
use crate::math::{Mat3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// The position, rotation and size of an ellipsoid.
#[derive(Debug, Clone, Copy)]
pub struct EllipsoidPose {
    /// Index of its body in the list of bodies.
    pub body: usize,
    /// Semi-axes along the ellipsoid's own axes.
    pub semi_axes: Vec3,
    /// Position of the centre, inertial.
    pub position: Vec3,
    /// Rotation matrix from the ellipsoid's own axes to the inertial frame.
    pub rotation: Mat3,
}

/// Derivatives of a brightness with respect to the pose and the size of one body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ByBody {
    /// Derivatives with respect to the position, inertial.
    pub position: Vec3,
    /// Derivatives with respect to the rotation vector, body frame.
    pub rotation: Vec3,
    /// Derivatives with respect to the semi-axes.
    pub semi_axes: Vec3,
}

/// Derivatives of the brightness of a body.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Partials {
    /// Derivatives with respect to pose and size of each body of the system.
    pub by_body: Vec<ByBody>,
    /// Derivatives with respect to the unit vectors to the observer and to the Sun, inertial; they are
    /// perpendicular to these vectors.
    pub by_direction: [Vec3; 2],
    /// Derivatives with respect to the vertices of each body that is one polyhedron, in its frame, if these
    /// were asked for; otherwise empty.
    pub by_vertex: Vec<Vec<Vec3>>,
    /// Likewise derivatives with respect to the areas of the facets of each body that is known by these.
    pub by_area: Vec<Vec<f64>>,
}

/// An ellipsoid in sunlight, with the outlines of what hides light from it.
pub struct LitEllipsoid<'a> {
    pose: &'a EllipsoidPose,
    law: &'a Law,
    time: f64,
    /// Unit vectors to the observer and to the Sun, inertial.
    directions: [Vec3; 2],
    /// Unit vectors to the observer and to the Sun in the ellipsoid's own axes.
    lights: [Vec3; 2],
    lune: Lune,
    hiding: Vec<HidingEllipsoid>,
    outlines: Vec<Outline>,
}

impl<'a> LitEllipsoid<'a> {
    /// Takes an ellipsoid, its law, the time, unit vectors to the observer and to the Sun, and the ellipsoids
    /// that may hide either of them from it.
    #[inline]
    pub fn new(
        pose: &'a EllipsoidPose,
        law: &'a Law,
        time: f64,
        directions: [Vec3; 2],
        in_front: impl Iterator<Item = (Light, EllipsoidPose)>,
    ) -> Self {
        let lights = directions.map(|direction| rotate_back(&pose.rotation, &direction));
        let [p, q] = lights.map(|light| light.component_div(&pose.semi_axes));
        let lune = Lune::new(&p, &q);
        let (mut hiding, mut outlines) = (Vec::new(), Vec::<Outline>::new());
        for (light, other) in in_front {
            let from = other.position - pose.position;
            let direction = &directions[light as usize];
            let shadow_caster = HidingEllipsoid {
                light,
                semi_axes: other.semi_axes,
                rotation: pose.rotation.tr_mul(&other.rotation),
                // The component along the light is left out, since it would add rounding errors.
                centre: pose.rotation.tr_mul(&(from - direction * from.dot(direction))),
                body: other.body,
                level: cylinder_level(
                    [0, 1, 2].map(|i| Compensated::difference(other.position[i], pose.position[i])),
                    &other.semi_axes,
                    &other.rotation,
                    direction,
                ),
            };
            let outline = Outline::new(&lune, &pose.semi_axes, &shadow_caster);
            if !outline.is_beside_sphere() {
                outlines.push(outline);
                hiding.push(HidingEllipsoid { centre: pose.rotation.tr_mul(&from), ..shadow_caster });
            }
        }
        Self { pose, law, time, directions, lights, lune, hiding, outlines }
    }

    /// Returns the phase angle.
    fn phase(&self) -> f64 {
        let [e, s] = &self.directions;
        e.cross(s).norm().atan2(e.dot(s))
    }

    /// Returns the constant T of a law whose integrals over this lune have closed forms.
    fn constant(&self) -> Option<f64> {
        self.law.constant().filter(|_| !self.lune.is_thin())
    }

    fn kernel(&self) -> ScatteringKernel<'_> {
        let mut kernel = ScatteringKernel {
            lune: &self.lune,
            law: self.law,
            semi_axes: &self.pose.semi_axes,
            scattering: self.law.at(self.phase()),
            time: self.time,
            constant: self.constant(),
            scale: self.lune.size(),
        };
        kernel.scale *= kernel.factor(self.lune.centre(), 0.0, 1.0).abs();
        kernel
    }

    /// Returns the brightness, in squared length; if W is four, then the sums of it times the components of the
    /// vector from the ellipsoid's centre, inertial.
    ///
    /// # Errors
    /// [`Error::NotConverged`](crate::error::Error::NotConverged) and
    /// [`Error::Interrupted`](crate::error::Error::Interrupted).
    #[inline]
    pub fn light<const W: usize>(&self, interrupt: &mut InterruptCheck) -> Result<[f64; W]> {
        if self.lune.is_empty() {
            return Ok([0.0; W]);
        }
        let mut all: [f64; W] = match self.constant() {
            Some(constant) if self.outlines.is_empty() => {
                let sums: [f64; W] = self.lune.between(self.lune.terminator(), self.lune.limb(), 0.0, 1.0);
                // The integral of rho^2 over the parallels is that of cos^2 b over the latitude, pi/2; that of
                // cos^3 b is 4/3.
                const SIZES: [f64; 4] = [FRAC_PI_2, 4.0 / 3.0, 4.0 / 3.0, 0.0];
                std::array::from_fn(|k| SIZES[k] * constant * sums[k])
            }
            _ => Strips { kernel: &self.kernel(), outlines: &self.outlines }.light(interrupt)?,
        };
        let EllipsoidPose { semi_axes, rotation, .. } = self.pose;
        if let [_, x, y, z] = &mut all[..] {
            let moment = self.lune.vector_of([*x, *y, *z]).component_mul(semi_axes);
            [*x, *y, *z] = (rotation * moment).into();
        }
        Ok(all.map(|sum| sum * semi_axes.product()))
    }

    /// Divides the lune by meridians and parallels into cells, each of two triangles, and returns these with
    /// numbers in proportion to their brightness. The thinner the lune, the nearer are its parallels.
    pub fn cells(&self) -> Vec<(Facet, f64)> {
        const ROWS: f64 = 64.0;
        const COLUMNS: f64 = 32.0;
        if self.lune.is_empty() {
            return Vec::new();
        }
        let (kernel, width) = (self.kernel(), self.lune.angle.sin.atan2(-self.lune.angle.cos));
        let finer = (1.0 - width.cos()).sqrt().recip().clamp(1.0, 4.0);
        let [rows, columns] = [ROWS * finer, COLUMNS / finer].map(f64::ceil);
        let [high, wide] = [PI / rows, width / columns];
        // With this growth a sphere's limb encloses the same area.
        let growth = (high / high.sin()).sqrt();
        let sphere_point = |row: f64, column: f64| {
            let angles = [row * high - FRAC_PI_2, FRAC_PI_2 - column * wide];
            let [(z, rho), (sin, cos)] = angles.map(f64::sin_cos);
            (Longitude { sin, cos }, z, rho)
        };
        let corner = |row: f64, column: f64| {
            let (l, z, rho) = sphere_point(row, column);
            let surface = self.lune.point(l, z, rho).component_mul(&self.pose.semi_axes);
            self.pose.position + self.pose.rotation * (surface * growth)
        };
        let mut all = Vec::with_capacity((2.0 * rows * columns) as usize);
        for (row, column) in (0..rows as u32).flat_map(|row| (0..columns as u32).map(move |c| (row, c))) {
            let [row, column] = [row, column].map(f64::from);
            let (l, z, rho) = sphere_point(row + 0.5, column + 0.5);
            let brightness = self.lune.kernel(l)[0] * kernel.factor(l, z, rho) * rho * rho;
            let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                .map(|(up, back)| corner(row + up, column + back));
            let halves = [[a, b, d], [c, d, b]].map(Facet::new);
            let area = halves[0].area + halves[1].area;
            // At a pole one of the two has no area.
            let halves = halves.into_iter().filter(|half| half.area > 1e-9 * area);
            all.extend(halves.map(|half| {
                let share = brightness * half.area / area;
                (half, share)
            }));
        }
        all
    }

    /// Returns the brightness, in squared length, and adds its derivatives to `partials`.
    ///
    /// # Errors
    /// Returns the errors of [`Self::brightness`].
    pub fn partials(&self, partials: &mut Partials, interrupt: &mut InterruptCheck) -> Result<f64> {
        if self.lune.is_empty() {
            return Ok(0.0);
        }
        let kernel = self.kernel();
        let (sums, moments) = match (kernel.constant, self.outlines.is_empty()) {
            (Some(_), true) => {
                let ends = [self.lune.terminator(), self.lune.limb()];
                let all = kernel.partials_between(ends[0], ends[1], 0.0, 1.0, interrupt)?;
                // The integral of the odd function z is zero.
                (all.map(|value| value * FRAC_PI_2), Vec::new())
            }
            _ => {
                let strips = Strips { kernel: &kernel, outlines: &self.outlines };
                strips.partials(&self.hiding, &self.lights, interrupt)?
            }
        };
        let volume = self.pose.semi_axes.product();
        self.add_by_semi_axes(&sums, volume, partials);
        for (hiding, moments) in self.hiding.iter().zip(&moments) {
            self.add_outline(hiding, moments, volume, partials);
        }
        Ok(sums[0] * volume)
    }

    /// Adds the derivatives with respect to the ellipsoid's own rotation and semi-axes and to the directions
    /// to the observer and to the Sun, with all outlines fixed.
    fn add_by_semi_axes(&self, sums: &[f64; PARTIALS], volume: f64, partials: &mut Partials) {
        let EllipsoidPose { semi_axes, rotation, body, .. } = self.pose;
        let partials_of_body = &mut partials.by_body[*body];
        for k in 0..2 {
            let by = self.lune.vector_of([sums[1 + 3 * k], sums[2 + 3 * k], sums[3 + 3 * k]]) * volume;
            // A derivative with respect to p becomes one with respect to the direction d in body axes: p =
            // A^-1 d, and a rotation by phi changes d to d + d x phi.
            let by_light = by.component_div(semi_axes);
            partials_of_body.rotation += by_light.cross(&self.lights[k]);
            partials_of_body.semi_axes -= by_light.component_mul(&self.lights[k]).component_div(semi_axes);
            partials.by_direction[k] += rotation * by_light;
        }
        partials_of_body.semi_axes +=
            (semi_axes.map(|a| sums[0] / a) + Vec3::new(sums[7], sums[8], sums[9])) * volume;
        let sin = self.phase().sin();
        if sin > 0.0 {
            let [e, s] = self.directions;
            partials.by_direction[0] -= s * (sums[10] * volume / sin);
            partials.by_direction[1] -= e * (sums[10] * volume / sin);
        }
    }

    /// Adds the derivatives that follow from the change of one outline.
    fn add_outline(
        &self,
        hiding: &HidingEllipsoid,
        moments: &StripMoments,
        volume: f64,
        partials: &mut Partials,
    ) {
        let EllipsoidPose { semi_axes, rotation, body, .. } = self.pose;
        // These are the normals of the hiding ellipsoid in the frame of the ellipsoid that is seen.
        let normals = hiding.rotation * Mat3::from_diagonal(&hiding.semi_axes.map(|a| volume / a));
        let (shift, rotation_part) = (rotation * (normals * moments.v), normals * moments.v_u);
        let with_surface = rotation_part * Mat3::from_diagonal(semi_axes);
        let partials_of_body = &mut partials.by_body[*body];
        partials_of_body.position += shift;
        partials_of_body.rotation += axial(&with_surface.transpose());
        partials_of_body.semi_axes += rotation_part.diagonal();
        partials.by_direction[hiding.light as usize] += rotation * (normals * moments.depth_v);
        let other = &mut partials.by_body[hiding.body];
        other.position -= shift;
        let [stretch, shrink] = [hiding.semi_axes, hiding.semi_axes.map(|a| volume / a)];
        let on_surface = Mat3::from_diagonal(&stretch) * moments.v_v * Mat3::from_diagonal(&shrink);
        other.rotation -= axial(&on_surface);
        other.semi_axes -= moments.v_v.diagonal().component_mul(&shrink);
    }
}

/// Returns the sum of x cross y, given the sum of x y^T.
fn axial(m: &Mat3) -> Vec3 {
    Vec3::new(m[(1, 2)] - m[(2, 1)], m[(2, 0)] - m[(0, 2)], m[(0, 1)] - m[(1, 0)])
}
