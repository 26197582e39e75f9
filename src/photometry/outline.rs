//! The outline of an occulting or eclipsing ellipsoid on the unit sphere of another one.
//!
//! What an ellipsoid hides along a direction d lies in its cylinder along d. In the sphere's coordinates u =
//! A^-1 x the cylinder runs along A^-1 d, which is p or q, and its section is an ellipse in the plane across
//! that. The plane's coordinates are z = u.k, the height above the lune's equator, which p and q share, and x
//! across it. With the rows r_x and r_z of the map from space to the plane, D the vector between the centres and
//! Q = R diag(a^2) R^T of the hiding ellipsoid, the ellipse has its centre at (r_x.D, r_z.D) and the
//! covariance r_i.Q r_j. At a height z it covers one interval of x, and x = rho sin(l') with l' the longitude
//! from p or q.
//!
//! The outline of an ellipsoid that is much larger than the other one is a nearly straight line on the
//! sphere, where its centre and its size cancel. It is computed from its level at the sphere's centre, which
//! the bodies' positions give in twice the working precision: the two ends of a parallel's interval are the
//! roots of x^2 - 2 m(z) x + P(z), and P(0) is the level.

use super::lune::{Longitude, Lune};
use crate::integrate::polynomial_roots;
use crate::math::compensated::Compensated;
use crate::math::{Mat3, Vec3};

/// Which light is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// The observer's: an occultation.
    Sight = 0,
    /// The Sun's: an eclipse.
    Sun = 1,
}

/// An ellipsoid that hides light from another one.
#[derive(Debug, Clone)]
pub struct HidingEllipsoid {
    /// The light that it hides.
    pub light: Light,
    /// Semi-axes.
    pub semi_axes: Vec3,
    /// The rotation from the body's frame into that of the ellipsoid on which it casts its outline.
    pub rotation: Mat3,
    /// Its centre in that frame.
    pub centre: Vec3,
    /// The level of its cylinder at the other ellipsoid's centre: see [`cylinder_level`].
    pub level: f64,
    /// The index of its body.
    pub body: usize,
}

/// Returns the level of an ellipsoid's cylinder along a light at a point: zero on its surface and -1 on its axis.
/// The centre is relative to that point.
pub fn cylinder_level(centre: [Compensated; 3], semi_axes: &Vec3, rotation: &Mat3, light: &Vec3) -> f64 {
    // With D to the centre, c = R^T (D x d) and w = R^T d the level is |A c|^2 / |det(A) A^-1 w|^2 - 1.
    let zero = Compensated::default();
    let light = [0, 1, 2].map(|i| Compensated::new(light[i]));
    let minus = |a: Compensated| Compensated { high: -a.high, low: -a.low };
    let across = [(1, 2), (2, 0), (0, 1)]
        .map(|(j, k)| centre[j].times(light[k]).plus(minus(centre[k].times(light[j]))));
    // A sphere has no axes, whose rounding errors would count.
    let in_unit_sphere = |v: [Compensated; 3]| match semi_axes.max() == semi_axes.min() {
        true => v,
        false => [0, 1, 2]
            .map(|i| (0..3).fold(zero, |sum, j| sum.plus(v[j].times(Compensated::new(rotation[(j, i)]))))),
    };
    let axes = [0, 1, 2].map(|i| Compensated::new(semi_axes[i]));
    let squares = |v: [Compensated; 3]| v.into_iter().fold(zero, |sum, x| sum.plus(x.times(x)));
    let [across, along] = [in_unit_sphere(across), in_unit_sphere(light)];
    let outer = squares([0, 1, 2].map(|i| across[i].times(axes[i])));
    let inner = squares([0, 1, 2].map(|i| along[i].times(axes[(i + 1) % 3]).times(axes[(i + 2) % 3])));
    outer.plus(minus(inner)).value() / inner.value()
}

/// The outline of an ellipsoid in the plane across the light.
#[derive(Debug, Clone)]
pub struct Outline {
    /// The light that is hidden.
    pub light: Light,
    /// Centre (x, z).
    centre: [f64; 2],
    /// x changes with z along the ellipse's middle line by this slope.
    slope: f64,
    /// Half the width along x through the centre, and half the extent in z.
    half: [f64; 2],
    /// The heights of its lower and its upper end.
    tips: [f64; 2],
    /// The coefficients of P(z), for a large outline.
    product: Option<[f64; 3]>,
    /// Unit vectors of the hiding ellipsoid's unit sphere: the tangent point on it is side cos(theta) v_0 +
    /// sin(theta) v_1.
    tangents: [Vec3; 2],
}

/// A point at which an outline crosses a parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// The point of the unit sphere of the hiding ellipsoid at which the ray is tangent to it.
    pub tangent: Vec3,
    /// Half the width of the outline along x, over the cosine of the position on the outline: the shift of x
    /// with the level of its equation, doubled.
    pub shift: f64,
}

impl Outline {
    /// Computes the outline that an ellipsoid casts on another one, which has this lune and these semi-axes.
    pub fn new(lune: &Lune, semi_axes: &Vec3, hiding: &HidingEllipsoid) -> Self {
        let [first, second, pole] = &lune.frame;
        let across = match hiding.light {
            Light::Sight => *second,
            Light::Sun => second * lune.angle.cos - first * lune.angle.sin,
        };
        let rows = [across.component_div(semi_axes), pole.component_div(semi_axes)];
        let [h, v] = rows.map(|row| hiding.rotation.tr_mul(&row).component_mul(&hiding.semi_axes));
        let square = v.norm_squared();
        let slope = h.dot(&v) / square;
        let across = h - v * slope;
        let half = [across.norm(), square.sqrt()];
        let centre = rows.map(|row| row.dot(&hiding.centre));
        let (level, ratio, at_zero) = (hiding.level, half[0] / half[1], centre[0] - slope * centre[1]);
        let product = [
            half[0] * half[0] * level,
            2.0 * (at_zero * slope - ratio * ratio * centre[1]),
            slope * slope + ratio * ratio,
        ];
        // The number has two formulas; the one with the smaller terms is evaluated.
        let farthest = half[0].max(at_zero.abs());
        let is_large = product.iter().map(|c| c.abs()).sum::<f64>() < farthest * farthest;
        let [x, z, radius] = [at_zero / half[0], centre[1] / half[1], half[1] * half[1]];
        let from_level = is_large && (x * x).max(level.abs()) < (z * z).max(1.0);
        let far = centre[1] + half[1].copysign(centre[1]);
        let near = radius * if from_level { level - x * x } else { (z - 1.0) * (z + 1.0) } / far;
        Self {
            light: hiding.light,
            centre,
            slope,
            tips: [near.min(far), near.max(far)],
            product: is_large.then_some(product),
            tangents: [across / half[0], v / half[1]],
            half,
        }
    }

    /// Returns whether no point of the lune's sphere can lie within the outline.
    pub fn is_beside_sphere(&self) -> bool {
        let [x, z] = self.centre;
        let reach = 1.0 + (self.half[0] + (self.slope * self.half[1]).abs()).hypot(self.half[1]);
        x * x + z * z > reach * reach
    }

    /// Returns whether the outline covers points of parallels between two heights.
    pub fn meets_parallels(&self, low: f64, high: f64) -> bool {
        self.tips[0] < high && self.tips[1] > low
    }

    /// Returns the middle of the outline on the parallel at z and half its width on it; `None` if the outline does
    /// not extend to this height.
    #[inline]
    fn span(&self, z: f64) -> Option<[f64; 2]> {
        let square = (z - self.tips[0]) * (self.tips[1] - z);
        (square > 0.0).then(|| {
            let middle = self.centre[0] + self.slope * (z - self.centre[1]);
            [middle, self.half[0] / self.half[1] * square.sqrt()]
        })
    }

    /// Returns the least and the largest x of the outline on the parallel at z.
    #[inline]
    fn ends(&self, z: f64) -> Option<[f64; 2]> {
        let [middle, width] = self.span(z)?;
        let mut ends = [middle - width, middle + width];
        if let Some([p, q, r]) = self.product {
            let (near, far) = if middle < 0.0 { (1, ends[0]) } else { (0, ends[1]) };
            if far * far > p.abs() + q.abs() + r {
                ends[near] = (p + z * (q + z * r)) / far;
            }
        }
        Some(ends)
    }

    /// Returns the interval of longitudes of the lune that the outline covers on a parallel. The flags tell which
    /// ends are those of the outline; the others are those of the lune.
    #[inline(always)]
    pub fn covers(&self, lune: &Lune, z: f64, rho: f64) -> Option<[(Longitude, bool); 2]> {
        let ends = self.ends(z)?.map(|x| x / rho);
        let [low, high] = self.edges(lune);
        if ends[0] >= high || ends[1] <= low {
            return None;
        }
        let longitude_of = |sin: f64| {
            let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
            match self.light {
                Light::Sight => Longitude { sin, cos },
                Light::Sun => Longitude {
                    sin: sin * lune.angle.cos + cos * lune.angle.sin,
                    cos: (cos * lune.angle.cos - sin * lune.angle.sin).max(0.0),
                },
            }
        };
        let start = if ends[0] > low { (longitude_of(ends[0]), true) } else { (lune.terminator(), false) };
        let end = if ends[1] < high { (longitude_of(ends[1]), true) } else { (lune.limb(), false) };
        Some([start, end])
    }

    /// Returns whether a point of the outline's plane is over the lune within rounding.
    fn is_over_lune(&self, lune: &Lune, x: f64, z: f64) -> bool {
        let rho = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt() + ROUNDING;
        let [low, high] = self.edges(lune);
        x >= rho * low - ROUNDING && x <= rho * high + ROUNDING
    }

    /// Returns the least and the largest x / rho on the lune.
    fn edges(&self, lune: &Lune) -> [f64; 2] {
        match self.light {
            Light::Sight => [-lune.angle.cos, 1.0],
            Light::Sun => [-1.0, lune.angle.cos],
        }
    }

    /// Returns the crossing of the outline with the parallel at z, at the upper or the lower end of the covered
    /// interval.
    pub fn crossing(&self, z: f64, upper: bool) -> Option<Crossing> {
        let [_, width] = self.span(z)?;
        let [sin, cos] = [(z - self.centre[1]) / self.half[1], width / self.half[0]];
        let [across, along] = &self.tangents;
        let tangent = across * if upper { cos } else { -cos } + along * sin;
        Some(Crossing { tangent, shift: self.half[0] / cos })
    }

    /// Appends the heights at which the covered part of the parallels is not a smooth function: where the outline
    /// begins and ends, and where it crosses the limb and the terminator.
    pub fn breaks(&self, lune: &Lune, out: &mut Vec<f64>) {
        let tips = self.tips.map(|z| [self.centre[0] + self.slope * (z - self.centre[1]), z]);
        out.extend(tips.iter().filter(|[x, z]| self.is_over_lune(lune, *x, *z)).map(|[_, z]| z));
        // x = rho where the hidden light grazes, up to the sign, and x^2 = (1 - z^2) cos^2 A where the other
        // one does.
        let edge_of_light = match self.light {
            Light::Sight => 1.0,
            Light::Sun => -1.0,
        };
        for edge in [edge_of_light, -edge_of_light * lune.angle.cos] {
            for side in Half::pair(self) {
                let level =
                    side.x.squared() + (side.z.squared() - side.denominator.squared()) * (edge * edge);
                side.roots(&level, |x, z| x * edge > -ROUNDING && self.is_over_lune(lune, x, z), out);
            }
        }
    }

    /// Returns, approximately, the point of a large outline that is nearest to the sphere's centre, and the conjugate
    /// half axes toward it and across it; `None` where the line along the gradient of the level does not meet the
    /// outline.
    fn nearest(&self) -> Option<([f64; 2], [f64; 2], [f64; 2])> {
        let [p, q, r] = self.product?;
        let ([cx, cz], [width, height], slope) = (self.centre, self.half, self.slope);
        let square = |x: f64, z: f64| (x - slope * z).powi(2) + (width / height * z).powi(2);
        let down = [2.0 * (cx - slope * cz), -q];
        let steepness = down[0] * down[0] + down[1] * down[1];
        let root = (steepness * steepness - 4.0 * p * square(down[0], down[1])).sqrt();
        let step = 2.0 * p / (steepness + root);
        let [x, z] = down.map(|d| d * step);
        // The level does not change along the tangent.
        let tangent = [2.0 * slope * x - q - 2.0 * r * z, 2.0 * (x - cx - slope * (z - cz))];
        let size = square(tangent[0], tangent[1]).sqrt() / width;
        step.is_finite().then(|| ([x, z], [x - cx, z - cz], tangent.map(|t| t / size)))
    }

    /// Returns x^2 - 2 m(z) x + P(z) and its derivative with respect to x.
    fn level(&self, x: &Polynomial, z: &Polynomial, denominator: &Polynomial) -> [Polynomial; 2] {
        let [cx, cz] = self.centre;
        let above = *z - *denominator * cz;
        let aside = *x - *denominator * cx - above * self.slope;
        let level = match self.product {
            Some([p, q, r]) => {
                let product = denominator.squared() * p + z.times(denominator) * q + z.squared() * r;
                // x (x - 2 m), with x - m aside.
                x.times(&(aside * 2.0 - *x)) + product
            }
            None => {
                let ratio = self.half[0] / self.half[1];
                let below = above.squared() - denominator.squared() * self.half[1].powi(2);
                aside.squared() + below * (ratio * ratio)
            }
        };
        [level, aside * 2.0]
    }

    /// Appends the heights at which this outline crosses another one; some may lie on the far side of the sphere.
    pub fn crossings(&self, other: &Self, lune: &Lune, out: &mut Vec<f64>) {
        // The other outline's x is x cos A + w sin A with A the angle between the lights and w along this one's light.
        let (cos, sin) = match (self.light, other.light) {
            (Light::Sight, Light::Sun) => (lune.angle.cos, -lune.angle.sin),
            (Light::Sun, Light::Sight) => (lune.angle.cos, lune.angle.sin),
            _ => (1.0, 0.0),
        };
        for side in Half::pair(self) {
            // With w^2 = 1 - x^2 - z^2 the level of the other outline is even + w odd.
            let w = side.denominator.squared() - side.x.squared() - side.z.squared();
            let [level, odd] = other.level(&(side.x * cos), &side.z, &side.denominator);
            let even = level + w * (sin * sin);
            let level = if sin == 0.0 { even } else { even.squared() - w.times(&(odd * sin).squared()) };
            side.roots(&level, |x, z| self.is_over_lune(lune, x, z), out);
        }
    }
}

/// The error that a coordinate of a root may have. It is generous, since a superfluous height only costs time,
/// while a missing one would cost accuracy.
const ROUNDING: f64 = 1e-6;

/// Half of an outline, from -90 to 90 degrees about one of its points, or its part over the sphere if it is
/// large: coordinates times 1 + s^2 as polynomials of t, with s in proportion to t the tangent of half the
/// angle.
struct Half {
    x: Polynomial,
    z: Polynomial,
    denominator: Polynomial,
}

impl Half {
    fn pair(outline: &Outline) -> [Self; 2] {
        let [cx, cz] = outline.centre;
        let [width, height] = outline.half;
        // With conjugate half axes u and v the outline is C + u cos + v sin.
        let upright = ([cx + width, cz], [width, 0.0], [outline.slope * height, height]);
        let near = outline.nearest();
        let (start, u, v) = near.unwrap_or(upright);
        let scale = if near.is_some() { (8.0 / v[0].hypot(v[1])).min(1.0) } else { 1.0 };
        [(start, 1.0), ([cx - u[0], cz - u[1]], -1.0)].map(|(start, side)| {
            let coordinate = |k: usize| {
                Polynomial::of([start[k], 2.0 * scale * v[k], scale * scale * (start[k] - 2.0 * side * u[k])])
            };
            Self {
                x: coordinate(0),
                z: coordinate(1),
                denominator: Polynomial::of([1.0, 0.0, scale * scale]),
            }
        })
    }

    /// Appends the heights of a polynomial's roots where (x, z) is accepted.
    fn roots(&self, polynomial: &Polynomial, accepts: impl Fn(f64, f64) -> bool, out: &mut Vec<f64>) {
        polynomial_roots(&polynomial.0, &mut |t| {
            let [x, z] = [&self.x, &self.z].map(|coordinate| coordinate.at(t) / self.denominator.at(t));
            if accepts(x, z) {
                out.push(z);
            }
        });
    }
}

/// A polynomial up to the eighth degree.
#[derive(Debug, Clone, Copy)]
struct Polynomial([f64; 9]);

impl Polynomial {
    fn of(low: [f64; 3]) -> Self {
        let mut all = [0.0; 9];
        all[..3].copy_from_slice(&low);
        Self(all)
    }

    fn at(&self, t: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Returns the product, of the eighth degree at most.
    fn times(&self, other: &Self) -> Self {
        let mut all = [0.0; 9];
        for (i, a) in self.0.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            all[i..].iter_mut().zip(&other.0).for_each(|(out, b)| *out += a * b);
        }
        Self(all)
    }

    fn squared(&self) -> Self {
        self.times(self)
    }
}

impl std::ops::Add for Polynomial {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a += b);
        self
    }
}

impl std::ops::Sub for Polynomial {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl std::ops::Mul<f64> for Polynomial {
    type Output = Self;
    fn mul(mut self, factor: f64) -> Self {
        self.0.iter_mut().for_each(|a| *a *= factor);
        self
    }
}
