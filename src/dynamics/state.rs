//! The state of a system as users see it.

use crate::error::{Error, Result, require_finite};
use crate::math::{Vec3, rotation};

/// Position and velocity (inertial), attitude and spin (body frame) of every body at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Time in the system's units.
    pub time: f64,
    /// Centres, inertial.
    pub position: Vec<Vec3>,
    /// Velocities of the centres, inertial.
    pub velocity: Vec<Vec3>,
    /// Unit quaternions `[w, x, y, z]`, body frame to inertial.
    pub attitude: Vec<[f64; 4]>,
    /// Angular velocities in the body frames.
    pub spin: Vec<Vec3>,
}

impl State {
    /// A state of values per body; quaternions of any non-zero length are scaled to one.
    pub fn new(
        time: f64,
        position: Vec<Vec3>,
        velocity: Vec<Vec3>,
        attitude: Vec<[f64; 4]>,
        spin: Vec<Vec3>,
    ) -> Result<Self> {
        require_finite("time", &[time])?;
        let count = position.len();
        if count == 0 {
            return Err(Error::invalid("number of bodies in position", 0, "at least one"));
        }
        for (what, length) in
            [("velocity", velocity.len()), ("attitude", attitude.len()), ("spin", spin.len())]
        {
            if length != count {
                return Err(Error::invalid(
                    format!("number of bodies in {what}"),
                    length,
                    format!("{count}, as in position"),
                ));
            }
        }
        for body in 0..count {
            require_finite(&format!("position of body {body}"), position[body].as_slice())?;
            require_finite(&format!("velocity of body {body}"), velocity[body].as_slice())?;
            require_finite(&format!("attitude of body {body}"), &attitude[body])?;
            require_finite(&format!("spin of body {body}"), spin[body].as_slice())?;
        }
        let attitude = attitude
            .iter()
            .enumerate()
            .map(|(body, &q)| {
                let largest = q.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
                if largest == 0.0 {
                    return Err(Error::invalid(
                        format!("attitude of body {body}"),
                        "[0, 0, 0, 0]",
                        "a quaternion [w, x, y, z] of non-zero length",
                    ));
                }
                let length = q.iter().map(|c| c * c).sum::<f64>();
                // A quaternion that is already of unit length keeps its bits.
                let unit = (length - 1.0).abs() < 4.0 * f64::EPSILON;
                Ok(if unit { q } else { rotation::normalised(q.map(|c| c / largest)) })
            })
            .collect::<Result<_>>()?;
        Ok(Self { time, position, velocity, attitude, spin })
    }

    /// A state of the paper's angles (phi, theta, psi) instead of quaternions.
    pub fn from_tait_bryan(
        time: f64,
        position: Vec<Vec3>,
        velocity: Vec<Vec3>,
        angles: &[[f64; 3]],
        spin: Vec<Vec3>,
    ) -> Result<Self> {
        for (body, angles) in angles.iter().enumerate() {
            require_finite(&format!("angles of body {body}"), angles)?;
        }
        let attitude = angles.iter().map(|&a| rotation::from_tait_bryan(a)).collect();
        Self::new(time, position, velocity, attitude, spin)
    }

    /// Number of bodies.
    pub fn bodies(&self) -> usize {
        self.position.len()
    }
}
