//! A Runge-Kutta pair as data.

/// Coefficients of an explicit embedded pair.
#[derive(Debug)]
pub struct Tableau {
    /// Name with orders.
    pub name: &'static str,
    /// Order of the solution that is carried on.
    pub order: u32,
    /// Order of the one it is compared with.
    pub error_order: u32,
    /// Stages of the pair.
    pub stages: usize,
    /// Nodes, those of the interpolant's stages included.
    pub c: &'static [f64],
    /// Row i holds the coefficients of the earlier stages in stage i.
    pub a: &'static [&'static [f64]],
    /// What rounding to doubles drops of the pair's rows: left out, it would be the same error in every step, and grow with
    /// their number and not with its root.
    pub a_low: &'static [&'static [f64]],
    /// Weights of the solution.
    pub b: &'static [f64],
    /// What rounding to doubles drops of them.
    pub b_low: &'static [f64],
    /// Weights of the comparison.
    pub b_hat: &'static [f64],
    /// Continuous extension.
    pub interpolant: Interpolant,
}

/// Continuous extension: y(t + theta h) = y + h sum_i b_i(theta) k_i.
#[derive(Debug)]
pub struct Interpolant {
    /// Order.
    pub order: u32,
    /// Row i: w_0, w_1, ... in b_i = theta sum_k w_k T_k(2 theta - 1), T_k Chebyshev's polynomials.
    ///
    /// In powers of theta the coefficients are of order 1e4 and cancel; in this basis they are of order one.
    pub weights: &'static [&'static [f64]],
}

impl Interpolant {
    /// Number of coefficients of every b_i.
    pub fn terms(&self) -> usize {
        self.weights.iter().map(|row| row.len()).max().unwrap_or(0)
    }
}
