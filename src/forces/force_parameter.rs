//! The parameters of forces by which motions can be differentiated.

/// A parameter of a force by which motions can be differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ForceParameter {
    /// G times the mass of a third body.
    Mu,
    /// The mass of a third body, where the mass was given.
    Mass,
    /// An element of the orbit of a third body: a, e, i, Omega, omega, M, and the epoch of M.
    Element(usize),
    /// The Love number k2 of a tide.
    K2,
    /// The time lag of a tide.
    Lag,
    /// The YORP torque along the spin, independent of the obliquity.
    Along,
    /// The YORP torque across the spin.
    Across,
    /// A factor of the YORP torques of a table, or of the force of heat on a secondary; its value is one.
    Factor,
    /// The component of the BYORP force along the motion.
    AlongMotion,
}
