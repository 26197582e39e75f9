//! The embedded Runge-Kutta pairs. Their coefficients are files of numbers, which are read when a pair is used
//! for the first time.

use super::tableau::{Tableau, read};
use std::sync::LazyLock;

/// The pair of Dormand and Prince of orders 5 and 4, with its interpolant of order 4.
///
/// The pair is that of Dormand & Prince (1980), J. Comput. Appl. Math. 6, 19, and the interpolant that of
/// Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, section II.6 (their program DOPRI5).
/// Stage 6 is the rate at the step's end.
pub static DORMAND_PRINCE54: LazyLock<Tableau> =
    LazyLock::new(|| read(include_str!("tableaux/dormand_prince54.json")));

/// Verner's "most efficient" Runge-Kutta pair of orders 6 and 5.
///
/// The coefficients are those of J. H. Verner (2010), Numer. Algor. 53, 383, as published by the author.
/// Stages 0-8 are the pair. The 6 further stages serve the interpolant only. It has order 6 by repeated
/// Hermite-Birkhoff interpolation (Enright, Jackson, Norsett & Thomsen 1986, ACM Trans. Math. Softw. 12,
/// 193): the cubic through the step's two ends gives rates inside the step, these give a quartic, and so on,
/// and each polynomial raises the order by one. The nodes of these stages minimise the error inside a step of
/// Kepler's problem relative to the error of the step itself.
pub static VERNER65: LazyLock<Tableau> = LazyLock::new(|| read(include_str!("tableaux/verner65.json")));

/// Verner's "most efficient" Runge-Kutta pair of orders 7 and 6: stages 0-9, and 11 for an interpolant of
/// order 7 that is made like that of [`VERNER65`].
pub static VERNER76: LazyLock<Tableau> = LazyLock::new(|| read(include_str!("tableaux/verner76.json")));

/// Verner's "most efficient" Runge-Kutta pair of orders 8 and 7: stages 0-12, and 16 for an interpolant of
/// order 8 that is made like that of [`VERNER65`].
pub static VERNER87: LazyLock<Tableau> = LazyLock::new(|| read(include_str!("tableaux/verner87.json")));

/// Verner's "most efficient" Runge-Kutta pair of orders 9 and 8, with the interpolant of order 9.
///
/// The coefficients are those of RKV98.IIa.Efficient as published by the author, J. H. Verner (2010), Numer.
/// Algor. 53, 383. Stages 0-15 are the pair. Stages 16-25 serve the interpolant only; stage 16 is the rate at
/// the step's end, which is stage 0 of the next step.
pub static VERNER98: LazyLock<Tableau> = LazyLock::new(|| read(include_str!("tableaux/verner98.json")));

/// Verner's pair with a comparison solution of order 6, for errors far below the rounding errors of the
/// pair's own estimate.
///
/// The estimate of the pair itself is accurate to about 1e-16 of the rates, times weights of at most 2.6:
/// where steps are to err by 1e-19 it is noise. The part of the rates that varies with the sixth power of the
/// time within a step is still well above noise, and tells how far the step is from the nearest singularity,
/// as the last coefficient does in IAS15 (Rein & Spiegel 2015, Mon. Not. R. Astron. Soc. 446, 1424). That
/// part is h sum_i p_i k_i, where p is the polynomial of degree 6 in the nodes that is orthogonal to all
/// lower degrees over the stages 0 and 8 to 14, with sum_i p_i^2 = 1. The stages are of order 5, so that b -
/// p has order 6.
pub static VERNER96: LazyLock<Tableau> = LazyLock::new(|| Tableau {
    name: "Verner 9(6)".to_owned(),
    error_order: 6,
    b_hat: read(include_str!("tableaux/verner96_comparison.json")),
    ..read(include_str!("tableaux/verner98.json"))
});
