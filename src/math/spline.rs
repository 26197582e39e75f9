//! Cubic splines through tables of vectors.

use crate::error::{Error, Result, require_finite};

/// The cubic spline with two continuous derivatives and the "not a knot" end condition: the first two pieces
/// are one polynomial, and so are the last two.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline<const W: usize> {
    abscissae: Vec<f64>,
    /// The coefficients of every piece, by powers of the distance from its first abscissa.
    pieces: Vec<[[f64; W]; 4]>,
}

impl<const W: usize> Spline<W> {
    /// Interpolates values at four or more increasing abscissae; `what` names the abscissae in errors.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for abscissae that are fewer, not finite or
    /// not increasing.
    pub fn new(what: &str, abscissae: &[f64], values: &[[f64; W]]) -> Result<Self> {
        let n = abscissae.len();
        if n < 4 || values.len() != n {
            let expected = "four or more, and as many values";
            return Err(Error::invalid(
                format!("number of {what}"),
                format!("{n}, with {} values", values.len()),
                expected,
            ));
        }
        require_finite(what, abscissae)?;
        if let Some(pair) = abscissae.windows(2).find(|pair| pair[1] <= pair[0]) {
            return Err(Error::invalid(
                what,
                format!("{} followed by {}", pair[0], pair[1]),
                "rising numbers",
            ));
        }
        values.iter().try_for_each(|value| require_finite(&format!("values at {what}"), value))?;
        let width: Vec<f64> = abscissae.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut pieces = vec![[[0.0; W]; 4]; n - 1];
        for c in 0..W {
            let chord: Vec<f64> = (0..n - 1).map(|i| (values[i + 1][c] - values[i][c]) / width[i]).collect();
            let slope = slopes(&width, &chord);
            for i in 0..n - 1 {
                let (h, m) = (width[i], chord[i]);
                pieces[i][0][c] = values[i][c];
                pieces[i][1][c] = slope[i];
                pieces[i][2][c] = (3.0 * m - 2.0 * slope[i] - slope[i + 1]) / h;
                pieces[i][3][c] = (slope[i] + slope[i + 1] - 2.0 * m) / (h * h);
            }
        }
        Ok(Self { abscissae: abscissae.to_vec(), pieces })
    }

    /// Returns the first and the last abscissa.
    pub fn range(&self) -> (f64, f64) {
        (self.abscissae[0], self.abscissae[self.abscissae.len() - 1])
    }

    /// Returns the value and the first derivative. Outside of the range the nearest piece is extrapolated.
    pub fn at(&self, abscissa: f64) -> ([f64; W], [f64; W]) {
        let after = self.abscissae.partition_point(|p| *p <= abscissa);
        let index = after.clamp(1, self.pieces.len()) - 1;
        let t = abscissa - self.abscissae[index];
        let [a, b, c, d] = &self.pieces[index];
        (
            std::array::from_fn(|k| a[k] + t * (b[k] + t * (c[k] + t * d[k]))),
            std::array::from_fn(|k| b[k] + t * (2.0 * c[k] + t * 3.0 * d[k])),
        )
    }
}

/// Returns the first derivatives at the abscissae from the widths and slopes of the chords, by eliminating in
/// a tridiagonal system.
fn slopes(width: &[f64], chord: &[f64]) -> Vec<f64> {
    let n = width.len() + 1;
    let last = n - 1;
    let (mut diagonal, mut upper, mut right) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut lower = vec![0.0; n];
    for i in 1..last {
        lower[i] = width[i];
        diagonal[i] = 2.0 * (width[i - 1] + width[i]);
        upper[i] = width[i - 1];
        right[i] = 3.0 * (width[i] * chord[i - 1] + width[i - 1] * chord[i]);
    }
    let end = |near: f64, far: f64, first: f64, second: f64| {
        let both = near + far;
        (far, both, ((near + 2.0 * both) * far * first + near * near * second) / both)
    };
    (diagonal[0], upper[0], right[0]) = end(width[0], width[1], chord[0], chord[1]);
    (diagonal[last], lower[last], right[last]) =
        end(width[last - 1], width[last - 2], chord[last - 1], chord[last - 2]);
    for i in 1..n {
        let factor = lower[i] / diagonal[i - 1];
        diagonal[i] -= factor * upper[i - 1];
        right[i] -= factor * right[i - 1];
    }
    right[last] /= diagonal[last];
    for i in (0..last).rev() {
        right[i] = (right[i] - upper[i] * right[i + 1]) / diagonal[i];
    }
    right
}
