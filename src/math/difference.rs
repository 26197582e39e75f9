//! Central differences of eighth order, which give about thirteen digits of the derivative of a smooth
//! function.

/// The step, in units of the natural size of the number.
pub const STEP: f64 = 2e-3;

/// Returns one to four steps to either side, and the weights of a function's values there in its derivative.
pub fn steps(step: f64) -> impl Iterator<Item = (f64, f64)> {
    let sides =
        move |k: usize| [1.0, -1.0].map(|sign| (sign * (k + 1) as f64 * step, sign * WEIGHTS[k] / step));
    (0..WEIGHTS.len()).flat_map(sides)
}

const WEIGHTS: [f64; 4] = [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0];
