//! The state of a system.

use crate::error::{Error, Result, require_finite};
use crate::math::{Vec3, rotation};

/// Position and velocity (inertial), attitude and spin (body frame) of every body at a time.
///
/// A state is checked when it is made and cannot be changed after that: every list has one entry for each
/// body, all numbers are finite, and quaternions have length one.
///
/// ```
/// use fullbody::dynamics::State;
/// use fullbody::math::Vec3;
///
/// let (rest, upright) = (vec![Vec3::zeros(); 2], vec![[1.0, 0.0, 0.0, 0.0]; 2]);
/// let position = vec![Vec3::zeros(), Vec3::new(2.5, 0.0, 0.0)];
/// let state = State::new(0.0, position.clone(), rest.clone(), upright.clone(), rest.clone())?;
/// assert_eq!(state.position()[1].x, 2.5);
///
/// let error = State::new(0.0, position, rest.clone(), upright, vec![Vec3::zeros()]).unwrap_err();
/// assert_eq!(error.to_string(), "number of bodies in spin is 1; expected 2, as in position");
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The time in the system's units.
    pub(crate) time: f64,
    /// The positions of the bodies' centres, inertial.
    pub(crate) position: Vec<Vec3>,
    /// The velocities of the centres, inertial.
    pub(crate) velocity: Vec<Vec3>,
    /// The attitudes: unit quaternions `[w, x, y, z]`, body frame to inertial.
    pub(crate) attitude: Vec<[f64; 4]>,
    /// The angular velocities, body frames.
    pub(crate) spin: Vec<Vec3>,
}

impl State {
    /// Makes a state from values for each body; quaternions of any non-zero length are scaled to one.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] names the list whose length differs from that of `position`, and the body
    /// whose number is not finite or whose quaternion is zero.
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
                // A quaternion that has unit length already keeps its bits.
                let unit = (length - 1.0).abs() < 4.0 * f64::EPSILON;
                Ok(if unit { q } else { rotation::normalised(q.map(|c| c / largest)) })
            })
            .collect::<Result<_>>()?;
        Ok(Self { time, position, velocity, attitude, spin })
    }

    /// Makes a state from the paper's angles (phi, theta, psi) instead of quaternions.
    ///
    /// # Errors
    /// The errors are those of [`Self::new`].
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

    /// Makes a state from positions and attitudes alone, for quantities that depend on nothing else:
    /// velocities and spins are NaN.
    ///
    /// # Errors
    /// The errors are those of [`Self::new`].
    #[doc(hidden)]
    pub fn from_poses(time: f64, position: Vec<Vec3>, attitude: Vec<[f64; 4]>) -> Result<Self> {
        let zeros = vec![Vec3::zeros(); position.len()];
        let state = Self::new(time, position, zeros.clone(), attitude, zeros)?;
        let unknown = vec![Vec3::from_element(f64::NAN); state.bodies()];
        Ok(Self { velocity: unknown.clone(), spin: unknown, ..state })
    }

    /// Returns the state at another time.
    ///
    /// # Errors
    /// Returns an error for a time that is not finite.
    pub fn with_time(self, time: f64) -> Result<Self> {
        Self::new(time, self.position, self.velocity, self.attitude, self.spin)
    }

    /// Returns the state with other centres.
    ///
    /// # Errors
    /// The errors are those of [`Self::new`].
    pub fn with_position(self, position: Vec<Vec3>) -> Result<Self> {
        Self::new(self.time, position, self.velocity, self.attitude, self.spin)
    }

    /// Returns the state with other velocities.
    ///
    /// # Errors
    /// The errors are those of [`Self::new`].
    pub fn with_velocity(self, velocity: Vec<Vec3>) -> Result<Self> {
        Self::new(self.time, self.position, velocity, self.attitude, self.spin)
    }

    /// Returns the state with other attitudes.
    ///
    /// # Errors
    /// The errors are those of [`Self::new`].
    pub fn with_attitude(self, attitude: Vec<[f64; 4]>) -> Result<Self> {
        Self::new(self.time, self.position, self.velocity, attitude, self.spin)
    }

    /// Returns the state with other spins.
    ///
    /// # Errors
    /// The errors are those of [`Self::new`].
    pub fn with_spin(self, spin: Vec<Vec3>) -> Result<Self> {
        Self::new(self.time, self.position, self.velocity, self.attitude, spin)
    }

    /// Returns the time in the system's units.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the positions of the bodies' centres, inertial frame.
    pub fn position(&self) -> &[Vec3] {
        &self.position
    }

    /// Returns the velocities of the centres, inertial frame.
    pub fn velocity(&self) -> &[Vec3] {
        &self.velocity
    }

    /// Returns the attitudes: unit quaternions `[w, x, y, z]`, body frame to inertial frame.
    pub fn attitude(&self) -> &[[f64; 4]] {
        &self.attitude
    }

    /// Returns the angular velocities, each in its body's frame.
    pub fn spin(&self) -> &[Vec3] {
        &self.spin
    }

    /// Returns the number of bodies.
    pub fn bodies(&self) -> usize {
        self.position.len()
    }
}
