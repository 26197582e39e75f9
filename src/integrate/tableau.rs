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
    /// Weights of the solution.
    pub b: &'static [f64],
    /// Weights of the comparison.
    pub b_hat: &'static [f64],
    /// Continuous extension.
    pub interpolant: Option<Interpolant>,
}

/// Continuous extension: y(t + theta h) = y + h sum_i b_i(theta) k_i.
#[derive(Debug)]
pub struct Interpolant {
    /// Order.
    pub order: u32,
    /// Row i: coefficients of theta^0, theta^1, ... in b_i.
    pub weights: &'static [&'static [f64]],
}
