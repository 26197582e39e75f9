//! Osculating elements from position and velocity.
//!
//! Takes position, velocity and mu; gives elements as near to the exact ones of these numbers as doubles
//! allow. They follow from two quantities: h = r x v, and u = r v^2 / mu, which is 1 on a circle and 2 on a
//! parabola. Both are formed in twice the working precision, and the rest follows without cancellation:
//!
//!   r/a = 2 - u,   e cos E = u - 1,   e sin E = r.v / sqrt(mu a),   1 - e^2 = (p/r) (r/a),   p = h^2 / mu.

use super::anomaly::{elliptic_mean, hyperbolic_mean, wrapped};
use super::elements::{KeplerElements, OrbitAxes};
use crate::error::{Error, Result, require_finite, require_positive};
use crate::math::Vec3;
use crate::math::compensated::{Compensated, two_product};

/// The eccentricity below which an orbit counts as a circle: rounding gives as much to the state of a circle.
const CIRCULAR: f64 = 4.0 * f64::EPSILON;

impl KeplerElements {
    /// Returns the elements of the orbit through a position and a velocity, for mu = G (m_1 + m_2).
    ///
    /// # Errors
    /// [`Error::InvalidInput`] if `mu` is not above zero, if a component is not finite, for coinciding
    /// centres, for motion along a straight line, and for a parabola.
    pub fn from_cartesian(position: &Vec3, velocity: &Vec3, mu: f64) -> Result<Self> {
        require_positive("mu", mu)?;
        require_finite("position", position.as_slice())?;
        require_finite("velocity", velocity.as_slice())?;
        let square = dot(position, position);
        if square.high == 0.0 {
            return Err(Error::invalid("distance", 0.0, "above zero: the bodies' centres coincide"));
        }

        let h = cross(position, velocity);
        if h == Vec3::zeros() {
            return Err(Error::invalid(
                "angular momentum",
                0.0,
                "above zero: motion along a straight line has no Kepler elements",
            ));
        }
        let radius = square_root(square);
        let u = over(times(radius, dot(velocity, velocity)), mu);
        let (r, r_dot_v) = (radius.high, dot(position, velocity).value());
        let p_over_r = h.norm_squared() / mu / r;
        for (what, value) in [("r v^2 / mu", u.value()), ("h^2 / (mu r)", p_over_r), ("r . v", r_dot_v)] {
            require_finite(what, &[value])?;
        }

        let r_over_a = plus(2.0, minus(u)).value();
        if r_over_a == 0.0 {
            return Err(Error::invalid(
                "orbital energy",
                0.0,
                "other than zero: a parabola has no semi-major axis",
            ));
        }
        let u_minus_one = plus(-1.0, u).value();
        let orbit = PlaneOrbit::new(p_over_r, r_over_a, u_minus_one, r_dot_v, mu * r)?;

        let inclination = h.x.hypot(h.y).atan2(h.z);
        let longitude_of_node = if h.x == 0.0 && h.y == 0.0 { 0.0 } else { wrapped(h.x.atan2(-h.y)) };
        let axes = OrbitAxes::new(longitude_of_node, inclination);
        let latitude = axes.ahead.dot(position).atan2(axes.node.dot(position));
        let (argument_of_periapsis, mean_anomaly) = match orbit.anomalies {
            None => (0.0, wrapped(latitude)),
            Some(Anomalies { true_anomaly, mean }) => {
                let mean = if orbit.eccentricity < 1.0 { wrapped(mean) } else { mean };
                (wrapped(latitude - true_anomaly), mean)
            }
        };
        Self::new(
            r / r_over_a,
            orbit.eccentricity,
            inclination,
            longitude_of_node,
            argument_of_periapsis,
            mean_anomaly,
        )
    }
}

/// The shape of the orbit and the position along it, in the orbital plane.
struct PlaneOrbit {
    eccentricity: f64,
    /// The position along the orbit; `None` on a circle.
    anomalies: Option<Anomalies>,
}

struct Anomalies {
    true_anomaly: f64,
    mean: f64,
}

impl PlaneOrbit {
    /// Derives the orbit from p/r, r/a, u - 1, r.v and mu r.
    fn new(p_over_r: f64, r_over_a: f64, u_minus_one: f64, r_dot_v: f64, mu_r: f64) -> Result<Self> {
        let one_minus_square = p_over_r * r_over_a;
        // e cos nu and e sin nu are the components of the eccentricity vector along the position and across
        // it.
        let low_eccentricity = one_minus_square > 0.5;
        let cosine = if low_eccentricity { u_minus_one - r_dot_v * (r_dot_v / mu_r) } else { p_over_r - 1.0 };
        let sine = p_over_r.sqrt() * (r_dot_v / mu_r.sqrt());
        // Near e = 1 the length of this vector does not tell on which side of 1 the eccentricity lies; 1 -
        // e^2 does.
        let e =
            if one_minus_square.abs() < 0.5 { (1.0 - one_minus_square).sqrt() } else { cosine.hypot(sine) };
        if e < CIRCULAR {
            return Ok(Self { eccentricity: 0.0, anomalies: None });
        }
        if e == 1.0 {
            return Err(Error::invalid(
                "eccentricity",
                format!("1 to the last digit (1 - e^2 = {one_minus_square:e})"),
                "an orbit further from a parabola and from a straight line",
            ));
        }
        let true_anomaly = sine.atan2(cosine);
        let gap = (one_minus_square / (1.0 + e)).abs();
        let eccentric_sine = r_dot_v * (r_over_a.abs() / mu_r).sqrt();
        let mean = if e < 1.0 {
            elliptic_mean(eccentric_sine.atan2(u_minus_one), e, gap)
        } else {
            hyperbolic_mean(eccentric_sine / e, gap)
        };
        Ok(Self { eccentricity: e, anomalies: Some(Anomalies { true_anomaly, mean }) })
    }
}

/// Returns a . b in twice the working precision.
fn dot(a: &Vec3, b: &Vec3) -> Compensated {
    let mut total = Compensated::default();
    for (x, y) in a.iter().zip(b.iter()) {
        let (product, error) = two_product(*x, *y);
        total.add(product);
        total.add(error);
    }
    total
}

/// Returns a x b with every component accurate to its last digits, for nearly parallel vectors too.
fn cross(a: &Vec3, b: &Vec3) -> Vec3 {
    let component =
        |j: usize, k: usize| dot(&Vec3::new(a[j], -a[k], 0.0), &Vec3::new(b[k], b[j], 0.0)).value();
    Vec3::new(component(1, 2), component(2, 0), component(0, 1))
}

fn plus(a: f64, mut b: Compensated) -> Compensated {
    b.add(a);
    b
}

fn minus(a: Compensated) -> Compensated {
    Compensated { high: -a.high, low: -a.low }
}

fn times(a: Compensated, b: Compensated) -> Compensated {
    let (high, error) = two_product(a.high, b.high);
    let mut product = Compensated::new(high);
    product.add(error + a.high.mul_add(b.low, a.low * b.high));
    product
}

/// Returns the quotient: the first quotient plus the quotient of its remainder.
fn over(a: Compensated, b: f64) -> Compensated {
    let quotient = a.high / b;
    let mut result = Compensated::new(quotient);
    result.add(((-quotient).mul_add(b, a.high) + a.low) / b);
    result
}

/// Returns the square root: the first root plus one step of Newton on its remainder.
fn square_root(a: Compensated) -> Compensated {
    let root = a.high.sqrt();
    let mut result = Compensated::new(root);
    result.add(((-root).mul_add(root, a.high) + a.low) / (2.0 * root));
    result
}
