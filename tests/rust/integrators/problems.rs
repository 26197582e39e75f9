//! Problems with closed forms.

use fullbody::error::{Refusal, Result};
use fullbody::integrate::{Equations, Tolerance};
use fullbody::interrupt::InterruptCheck;

/// Kepler's problem in the plane, mu = 1: `[x, y, vx, vy]`.
#[derive(Debug, Clone)]
pub struct Kepler;

impl Kepler {
    /// The state a time after periapsis, from Kepler's equation.
    pub fn exact(e: f64, time: f64) -> [f64; 4] {
        let mut anomaly = time;
        for _ in 0..60 {
            anomaly -= (anomaly - e * anomaly.sin() - time) / (1.0 - e * anomaly.cos());
        }
        let (s, c) = anomaly.sin_cos();
        let (b, rate) = ((1.0 - e * e).sqrt(), 1.0 / (1.0 - e * c));
        [c - e, b * s, -s * rate, b * c * rate]
    }
}

impl Equations for Kepler {
    fn prepare(&mut self, _: f64, _: &[f64], _: f64, _: &mut InterruptCheck) -> Result<()> {
        Ok(())
    }

    fn derivative(
        &mut self,
        _: usize,
        _: f64,
        y: &[f64],
        rate: &mut [f64],
    ) -> std::result::Result<(), Refusal> {
        let cube = (y[0] * y[0] + y[1] * y[1]).powf(1.5);
        rate.copy_from_slice(&[y[2], y[3], -y[0] / cube, -y[1] / cube]);
        Ok(())
    }

    fn norm(&mut self, _: &[f64], v: &[f64], tolerance: &Tolerance) -> f64 {
        v.iter().map(|x| x * x).sum::<f64>().sqrt() / (tolerance.relative() + tolerance.absolute())
    }

    fn restore(&mut self, _: &mut [f64], _: &mut [f64]) {}
}

/// Largest difference of two vectors.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}
