//! Central differences of eighth order, which give some thirteen digits of the derivative of a smooth
//! function.

/// The step, in units of the natural size of the number.
pub const STEP: f64 = 2e-3;

/// The weights of the differences over one to four steps to either side.
pub const WEIGHTS: [f64; 4] = [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0];
