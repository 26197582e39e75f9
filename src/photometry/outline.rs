//! The outline of an occulting or eclipsing ellipsoid on the unit sphere of another one.
//!
//! What an ellipsoid hides along a direction d lies in its cylinder along d. In the sphere's coordinates u = A^-1 x the
//! cylinder runs along A^-1 d, which is p or q, and its section is an ellipse in the plane across that. The plane's
//! coordinates are z = u.k, the height above the lune's equator, which p and q share, and x across. With the rows r_x and
//! r_z of the map from space to the plane, D the vector between the centres and Q = R diag(a^2) R^T of the hiding ellipsoid,
//! the ellipse has its centre at (r_x.D, r_z.D) and the covariance r_i.Q r_j. At a height z it covers one interval of x,
//! and x = rho sin(l') with l' the longitude from p or q.

use super::lune::{Longitude, Lune};
use crate::integrate::polynomial_roots;
use crate::math::{Mat3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

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
    pub half: [f64; 2],
    /// The rounding of coordinates.
    rounding: f64,
    /// The rounding of [`Self::level`].
    pub level_rounding: f64,
    /// Unit vectors of the hiding ellipsoid's unit sphere: the tangent point on it is cos(angle) v_0 + sin(angle) v_1.
    tangents: [Vec3; 2],
}

/// A point of an outline on the lune.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    /// Its longitude.
    pub l: Longitude,
    /// Its height.
    pub z: f64,
    /// The radius of the parallel there.
    pub rho: f64,
    /// Whether the outline has it, rather than the limb onto which it was moved.
    pub own: bool,
}

impl Outline {
    /// The outline that an ellipsoid at this distance casts on one of these semi-axes, whose lune this is.
    pub fn new(lune: &Lune, semi_axes: &Vec3, hiding: &Hiding, distance: f64) -> Self {
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
        let rounding = 16.0 * f64::EPSILON * (1.0 + distance / semi_axes.min());
        Self {
            rounding,
            level_rounding: rounding * (1.0 + (1.0 + slope.abs()) / half[0] + 1.0 / half[1]),
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

    /// The point of the plane at an angle along the outline.
    fn at(&self, (sin, cos): (f64, f64)) -> [f64; 2] {
        let along = self.half[1] * sin;
        [self.centre[0] + self.slope * along + self.half[0] * cos, self.centre[1] + along]
    }

    /// The angle at a point of the outline, from -90 to 270 degrees.
    fn angle(&self, x: f64, z: f64) -> f64 {
        let along = z - self.centre[1];
        let cos = (x - self.centre[0] - self.slope * along) / self.half[0];
        let angle = (along / self.half[1]).atan2(cos);
        if angle < -FRAC_PI_2 { angle + TAU } else { angle }
    }

    /// The point of the lune at an angle along the outline. Those beyond the limb are moved onto it; where the parallel does not
    /// exist, and beyond the terminator, where nothing is hidden, there is none.
    #[inline]
    pub fn spot(&self, lune: &Lune, angle: (f64, f64)) -> Option<Spot> {
        let [x, z] = self.at(angle);
        let square = (1.0 - z) * (1.0 + z);
        if square <= 0.0 {
            return None;
        }
        let rho = square.sqrt();
        let sin = x / rho;
        let [low, high] = self.edges_of(lune);
        // The integral along the parallel is flat at both edges, so that points within rounding of them may be moved too.
        if sin <= low + self.rounding {
            return None;
        }
        if sin >= high - self.rounding {
            return Some(Spot { l: lune.limb(), z, rho, own: false });
        }
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        let l = match self.light {
            Light::Sight => Longitude { sin, cos },
            Light::Sun => Longitude {
                sin: sin * lune.angle.cos + cos * lune.angle.sin,
                cos: (cos * lune.angle.cos - sin * lune.angle.sin).max(0.0),
            },
        };
        Some(Spot { l, z, rho, own: true })
    }

    /// The level of the outline's equation at a point of the lune: below zero within the outline.
    pub fn level(&self, lune: &Lune, spot: &Spot) -> f64 {
        let sin = match self.light {
            Light::Sight => spot.l.sin,
            Light::Sun => spot.l.sin * lune.angle.cos - spot.l.cos * lune.angle.sin,
        };
        let along = spot.z - self.centre[1];
        let across = spot.rho * sin - self.centre[0] - self.slope * along;
        (across / self.half[0]).powi(2) + (along / self.half[1]).powi(2) - 1.0
    }

    /// Whether a point of the outline's plane is over the lune, rounding aside.
    fn within(&self, lune: &Lune, x: f64, z: f64) -> bool {
        const ROUNDING: f64 = 1e-9;
        let rho = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt() + ROUNDING;
        let [low, high] = self.edges_of(lune);
        x >= rho * low - ROUNDING && x <= rho * high + ROUNDING
    }

    /// The least and the largest x / rho on the lune.
    fn edges_of(&self, lune: &Lune) -> [f64; 2] {
        match self.light {
            Light::Sight => [-lune.angle.cos, 1.0],
            Light::Sun => [-1.0, lune.angle.cos],
        }
    }

    /// The point of the hiding ellipsoid's unit sphere at which the ray is tangent to it, at an angle along the outline.
    pub fn tangent(&self, sin: f64, cos: f64) -> Vec3 {
        self.tangents[0] * cos + self.tangents[1] * sin
    }

    /// Finds the angles at which the outline reaches a height.
    fn at_height(&self, z: f64, mut found: impl FnMut(f64)) {
        let sin = (z - self.centre[1]) / self.half[1];
        if sin.abs() < 1.0 {
            let angle = sin.asin();
            found(angle);
            found(PI - angle);
        }
    }

    /// Finds the angles at which the outline reaches the heights of the poles.
    pub fn poles(&self, mut found: impl FnMut(f64)) {
        [-1.0, 1.0].into_iter().for_each(|z| self.at_height(z, &mut found));
    }

    /// Finds the angles at which the outline is at a height beyond the limb.
    pub fn beyond(&self, lune: &Lune, z: f64, mut found: impl FnMut(f64)) {
        self.at_height(z, |angle| {
            if self.spot(lune, angle.sin_cos()).is_some_and(|spot| !spot.own) {
                found(angle);
            }
        });
    }

    /// Finds the angles and heights at which the outline crosses the limb and the terminator.
    pub fn edges(&self, lune: &Lune, mut found: impl FnMut(f64, f64)) {
        // x = rho where the hidden light grazes, up to the sign, and x^2 = (1 - z^2) cos^2 A where the other one does.
        let own = match self.light {
            Light::Sight => 1.0,
            Light::Sun => -1.0,
        };
        for edge in [own, -own * lune.angle.cos] {
            for side in Half::both(self) {
                let level = side.x.squared() + (side.z.squared() - side.one.squared()) * (edge * edge);
                side.roots(&level, |angle, x, z| {
                    if x * edge >= 0.0 && self.within(lune, x, z) {
                        found(angle, z);
                    }
                });
            }
        }
    }

    /// Finds the angles, on this outline and on another one, at which they cross; some may lie on the far side of the sphere.
    pub fn crossings(&self, other: &Self, lune: &Lune, mut found: impl FnMut(f64, f64)) {
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
            let odd = x * (2.0 * sin * width.powi(-2));
            let mut add = |level: Polynomial| {
                side.roots(&level, |angle, x, z| {
                    if self.within(lune, x, z) {
                        let w = (1.0 - x * x - z * z).max(0.0).sqrt();
                        found(angle, other.angle(x * cos + w * sin, z));
                    }
                });
            };
            if sin != 0.0 {
                add(even.squared() - w.times(&odd.squared()));
            }
            // Beside the square of a large part that of a small one may be lost to rounding.
            if odd.size() < 1e-4 * even.size() {
                add(even);
            }
        }
    }
}

/// Half of an outline, from -90 to 90 degrees about its end at large x or at small x: coordinates times 1 + t^2 as polynomials
/// of t, the tangent of half the angle.
struct Half {
    /// The angle at its middle.
    middle: f64,
    x: Polynomial,
    z: Polynomial,
    one: Polynomial,
}

impl Half {
    fn both(outline: &Outline) -> [Self; 2] {
        let [x, z] = outline.centre;
        let [width, height] = outline.half;
        [(1.0, 0.0), (-1.0, PI)].map(|(side, middle)| {
            let of = |centre: f64, cos: f64, sin: f64| {
                Polynomial::of([centre + side * cos, 2.0 * side * sin, centre - side * cos])
            };
            Self {
                middle,
                x: of(x, width, outline.slope * height),
                z: of(z, 0.0, height),
                one: of(1.0, 0.0, 0.0),
            }
        })
    }

    /// Finds a polynomial's roots: their angles, x and z.
    fn roots(&self, polynomial: &Polynomial, mut found: impl FnMut(f64, f64, f64)) {
        polynomial_roots(&polynomial.0, &mut |t| {
            let [x, z] = [&self.x, &self.z].map(|coordinate| coordinate.at(t) / self.one.at(t));
            found(self.middle + 2.0 * t.atan(), x, z);
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

    /// The size of the coefficients.
    fn size(&self) -> f64 {
        self.0.iter().fold(0.0, |size, c| size.max(c.abs()))
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
