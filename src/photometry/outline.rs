//! The outline of an occulting or eclipsing ellipsoid on the unit sphere of another one.
//!
//! What an ellipsoid hides along a direction d lies in its cylinder along d. In the sphere's coordinates u =
//! A^-1 x the cylinder runs along A^-1 d, which is p or q, and its section is an ellipse in the plane across
//! that. The plane's coordinates are z = u.k, the height above the lune's equator, which p and q share, and x
//! across. With the rows r_x and r_z of the map from space to the plane, D the vector between the centres and
//! Q = R diag(a^2) R^T of the hiding ellipsoid, the ellipse has its centre at (r_x.D, r_z.D) and the
//! covariance r_i.Q r_j. At a height z it covers one interval of x, and x = rho sin(l') with l' the longitude
//! from p or q.

use super::lune::{Longitude, Lune};
use crate::integrate::polynomial_roots;
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
pub struct Hiding {
    /// The light that it hides.
    pub light: Light,
    /// Semi-axes.
    pub semi_axes: Vec3,
    /// From its centre's frame into that of the ellipsoid on which it casts its outline.
    pub rotation: Mat3,
    /// Its centre in that frame.
    pub centre: Vec3,
    /// Its place in the list of bodies.
    pub body: usize,
}

/// The outline in the plane across the light.
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
    /// Unit vectors of the hiding ellipsoid's unit sphere: the tangent point on it is side cos(theta) v_0 +
    /// sin(theta) v_1.
    tangents: [Vec3; 2],
}

/// Where an outline crosses a parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// The point of the unit sphere of the hiding ellipsoid at which the ray is tangent to it.
    pub tangent: Vec3,
    /// Half the width of the outline along x, over the cosine of the position on the outline: the shift of x
    /// with the level of its equation, doubled.
    pub shift: f64,
}

impl Outline {
    /// The outline that an ellipsoid casts on one of these semi-axes, whose lune this is.
    pub fn new(lune: &Lune, semi_axes: &Vec3, hiding: &Hiding) -> Self {
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
        Self {
            light: hiding.light,
            centre: rows.map(|row| row.dot(&hiding.centre)),
            slope,
            tangents: [across / half[0], v / half[1]],
            half,
        }
    }

    /// Whether no point of the lune's sphere can lie within the outline.
    pub fn misses(&self) -> bool {
        let [x, z] = self.centre;
        let reach = 1.0 + (self.half[0] + (self.slope * self.half[1]).abs()).hypot(self.half[1]);
        x * x + z * z > reach * reach
    }

    /// Whether the outline reaches over parallels between two heights.
    pub fn reaches(&self, low: f64, high: f64) -> bool {
        self.centre[1] - self.half[1] < high && self.centre[1] + self.half[1] > low
    }

    /// Whether the outline reaches over the parallel at z; if so, the sine of the position on it.
    #[inline]
    fn position(&self, z: f64) -> Option<f64> {
        let sin = (z - self.centre[1]) / self.half[1];
        (sin.abs() < 1.0).then_some(sin)
    }

    /// The interval of longitudes of the lune that the outline covers on a parallel. The flags tell which
    /// ends are the outline's, rather than the lune's.
    #[inline(always)]
    pub fn covers(&self, lune: &Lune, z: f64, rho: f64) -> Option<[(Longitude, bool); 2]> {
        let sin = self.position(z)?;
        let middle = self.centre[0] + self.slope * (z - self.centre[1]);
        let width = self.half[0] * ((1.0 - sin) * (1.0 + sin)).sqrt();
        let [low, high] = self.edges(lune);
        let ends = [middle - width, middle + width].map(|x| x / rho);
        if ends[0] >= high || ends[1] <= low {
            return None;
        }
        let from_own = |sin: f64| {
            let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
            match self.light {
                Light::Sight => Longitude { sin, cos },
                Light::Sun => Longitude {
                    sin: sin * lune.angle.cos + cos * lune.angle.sin,
                    cos: (cos * lune.angle.cos - sin * lune.angle.sin).max(0.0),
                },
            }
        };
        let start = if ends[0] > low { (from_own(ends[0]), true) } else { (lune.terminator(), false) };
        let end = if ends[1] < high { (from_own(ends[1]), true) } else { (lune.limb(), false) };
        Some([start, end])
    }

    /// Whether a point of the outline's plane is over the lune, rounding aside.
    fn within(&self, lune: &Lune, x: f64, z: f64) -> bool {
        const ROUNDING: f64 = 1e-9;
        let rho = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt() + ROUNDING;
        let [low, high] = self.edges(lune);
        x >= rho * low - ROUNDING && x <= rho * high + ROUNDING
    }

    /// The least and the largest x / rho on the lune.
    fn edges(&self, lune: &Lune) -> [f64; 2] {
        match self.light {
            Light::Sight => [-lune.angle.cos, 1.0],
            Light::Sun => [-1.0, lune.angle.cos],
        }
    }

    /// How the outline crosses the parallel at z, at the lower end of the covered interval or at the upper
    /// one.
    pub fn crossing(&self, z: f64, upper: bool) -> Option<Crossing> {
        let sin = self.position(z)?;
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        let [across, along] = &self.tangents;
        let tangent = across * if upper { cos } else { -cos } + along * sin;
        Some(Crossing { tangent, shift: self.half[0] / cos })
    }

    /// Adds the heights at which the part of the lune that the outline covers changes its kind: where the
    /// outline begins and ends, and where it crosses the limb and the terminator.
    pub fn breaks(&self, lune: &Lune, out: &mut Vec<f64>) {
        let ([x, z], tip) = (self.centre, self.slope * self.half[1]);
        let tips = [[x - tip, z - self.half[1]], [x + tip, z + self.half[1]]];
        out.extend(tips.iter().filter(|[x, z]| self.within(lune, *x, *z)).map(|[_, z]| z));
        // x = rho where the hidden light grazes, up to the sign, and x^2 = (1 - z^2) cos^2 A where the other
        // one does.
        let own = match self.light {
            Light::Sight => 1.0,
            Light::Sun => -1.0,
        };
        for edge in [own, -own * lune.angle.cos] {
            for side in Half::both(self) {
                let level = side.x.squared() + (side.z.squared() - side.one.squared()) * (edge * edge);
                side.roots(&level, |x, z| x * edge >= 0.0 && self.within(lune, x, z), out);
            }
        }
    }

    /// Adds the heights at which this outline crosses another one; some may lie on the far side of the
    /// sphere.
    pub fn crossings(&self, other: &Self, lune: &Lune, out: &mut Vec<f64>) {
        // The other outline's x is x cos(turn) + w sin(turn) with w the height of this one's plane.
        let (cos, sin) = match (self.light, other.light) {
            (Light::Sight, Light::Sun) => (lune.angle.cos, -lune.angle.sin),
            (Light::Sun, Light::Sight) => (lune.angle.cos, lune.angle.sin),
            _ => (1.0, 0.0),
        };
        let [width, height] = other.half;
        for side in Half::both(self) {
            let z = side.z - side.one * other.centre[1];
            let x = side.x * cos - side.one * other.centre[0] - z * other.slope;
            // ((x + w sin) / width)^2 + (z / height)^2 = 1, with w^2 = 1 - x^2 - z^2.
            let w = side.one.squared() - side.x.squared() - side.z.squared();
            let even = (x.squared() + w * (sin * sin)) * width.powi(-2) + z.squared() * height.powi(-2)
                - side.one.squared();
            let level = if sin == 0.0 {
                even
            } else {
                let odd = x * (2.0 * sin * width.powi(-2));
                even.squared() - w.times(&odd.squared())
            };
            side.roots(&level, |x, z| self.within(lune, x, z), out);
        }
    }
}

/// Half of an outline, from -90 to 90 degrees about its end at large x or at small x: coordinates times 1 +
/// t^2 as polynomials of t, the tangent of half the angle.
struct Half {
    x: Polynomial,
    z: Polynomial,
    one: Polynomial,
}

impl Half {
    fn both(outline: &Outline) -> [Self; 2] {
        let [x, z] = outline.centre;
        let [width, height] = outline.half;
        [1.0, -1.0].map(|side| {
            let of = |centre: f64, cos: f64, sin: f64| {
                Polynomial::of([centre + side * cos, 2.0 * side * sin, centre - side * cos])
            };
            Self { x: of(x, width, outline.slope * height), z: of(z, 0.0, height), one: of(1.0, 0.0, 0.0) }
        })
    }

    /// Adds the heights of a polynomial's roots where (x, z) is accepted.
    fn roots(&self, polynomial: &Polynomial, accepts: impl Fn(f64, f64) -> bool, out: &mut Vec<f64>) {
        polynomial_roots(&polynomial.0, &mut |t| {
            let [x, z] = [&self.x, &self.z].map(|coordinate| coordinate.at(t) / self.one.at(t));
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

    /// The product, of the eighth degree at most.
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
