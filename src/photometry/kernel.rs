//! Integrals of the brightness along a parallel of an ellipsoid's unit sphere, and their derivatives.

use super::law::{Law, Scattering};
use super::lune::{Longitude, Lune};
use super::rule::RULE;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;

/// The number of integrals with derivatives: the brightness, and its derivatives with respect to the components of p
/// and of q along p + q, across it and along the pole, to the semi-axes through the cosines alone, and to the phase
/// angle.
pub const PARTIALS: usize = 11;

/// The relative error of the brightness.
const TOLERANCE: f64 = 2e-14;
/// The relative error of derivatives.
pub const PARTIAL_TOLERANCE: f64 = 1e-10;

/// Units of work of an integral along a parallel.
const NODES: u64 = 60;

/// The brightness of the surface elements of an ellipsoid by a scattering law.
#[derive(Debug, Clone)]
pub struct ScatteringKernel<'a> {
    pub lune: &'a Lune,
    pub law: &'a Law,
    pub scattering: Scattering,
    pub semi_axes: &'a Vec3,
    /// The time, which an interruption names.
    pub time: f64,
    /// The constant T of a law whose integrals have closed forms.
    pub constant: Option<f64>,
    /// The size of the brightness over a b c.
    pub scale: f64,
}

impl ScatteringKernel<'_> {
    /// Returns mu and mu0 at a point, and n = |A^-1 u|.
    fn cosines(&self, u: &Vec3, sight: f64, light: f64) -> [f64; 3] {
        let n = u.component_div(self.semi_axes).norm();
        [sight / n, light / n, n]
    }

    /// Returns the component of the normal along e x s, for laws with edges: e x s = abc A^-1 (p x q).
    fn out_of_plane(&self, l: Longitude, z: f64, rho: f64) -> f64 {
        if !self.law.has_edges() {
            return 0.0;
        }
        let u = self.lune.point(l, z, rho);
        let n = u.component_div(self.semi_axes);
        let [p, q] = self.lune.lengths;
        let across = self.lune.frame[2].component_div(self.semi_axes) * (p * q * self.lune.angle.sin);
        self.semi_axes.product() * across.dot(&n) / n.norm()
    }

    /// Returns T at a longitude and height.
    pub fn factor(&self, l: Longitude, z: f64, rho: f64) -> f64 {
        if let Some(constant) = self.law.constant() {
            return constant;
        }
        let [_, sight, light] = self.lune.kernel(l);
        let [mu, mu0, _] = self.cosines(&self.lune.point(l, z, rho), rho * sight, rho * light);
        self.scattering.factor(mu, mu0, self.out_of_plane(l, z, rho))
    }

    /// Returns the integral of the brightness between two longitudes of a parallel; if W is four, then also the
    /// integrals of the brightness times the components of u along p + q, across it and along the pole.
    pub fn between<const W: usize>(
        &self,
        from: Longitude,
        to: Longitude,
        z: f64,
        rho: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<[f64; W]> {
        if let Some(constant) = self.constant {
            return Ok(self.lune.between(from, to, z, rho).map(|sum: f64| constant * sum));
        }
        let mut f = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let l = Longitude { sin, cos };
            let light = rho * self.lune.kernel(l)[0] * self.factor(l, z, rho);
            let [x, y, z] = if W > 1 { self.lune.components(l, z, rho) } else { [0.0; 3] };
            let all = [light, light * x, light * y, light * z];
            Ok(std::array::from_fn(|k| all[k]))
        };
        let mut total = [0.0; W];
        for ends in self.pieces(from, to, z, rho) {
            interrupt.charge(NODES, self.time)?;
            let sums = RULE.integrate(ends, &[self.tolerance(); W], &mut f, &mut |_| {})?;
            total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
        }
        Ok(total)
    }

    /// Iterates over the intervals in which the law is smooth. A rough surface has edges where
    /// the cosines are equal, (p - q).u = 0, and where the normal is in the plane of the two directions,
    /// k.A^-2 u = 0.
    fn pieces(&self, from: Longitude, to: Longitude, z: f64, rho: f64) -> impl Iterator<Item = [f64; 2]> {
        let [low, high] = [from, to].map(|l| l.sin.atan2(l.cos));
        let mut ends = [low, high, high, high, high];
        if self.law.has_edges() {
            let [p, q] = self.lune.lengths;
            let Longitude { sin, cos } = self.lune.angle;
            ends[2] = (p - q * cos).atan2(q * sin);
            let [across, along, up] = self.edge();
            let (size, angle) = (across.hypot(along), along.atan2(across));
            let half_width = (-up * z / (size * rho).max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0).acos();
            (ends[3], ends[4]) = (angle - half_width, angle + half_width);
        }
        ends[2..].iter_mut().for_each(|end| *end = end.clamp(low, high));
        ends.sort_unstable_by(f64::total_cmp);
        (1..ends.len()).map(move |k| [ends[k - 1], ends[k]]).filter(|[low, high]| low < high)
    }

    /// Returns A^-2 k in the lune's frame.
    fn edge(&self) -> [f64; 3] {
        let pole = self.lune.frame[2].component_div(self.semi_axes).component_div(self.semi_axes);
        self.lune.frame.map(|axis| axis.dot(&pole))
    }

    /// Returns the heights between which the edge of a rough surface crosses each parallel twice.
    pub fn edge_heights(&self) -> Option<[f64; 2]> {
        self.law.has_edges().then(|| {
            let [across, along, up] = self.edge();
            let side = across.hypot(along);
            let z = side / side.hypot(up);
            [-z, z]
        })
    }

    /// Returns the integral between two longitudes with its derivatives.
    pub fn partials_between(
        &self,
        from: Longitude,
        to: Longitude,
        z: f64,
        rho: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<[f64; PARTIALS]> {
        let lune = self.lune;
        if let Some(constant) = self.constant {
            let (low, high) = (lune.squares(from), lune.squares(to));
            let mut all = [0.0; PARTIALS];
            [all[0]] = self.between(from, to, z, rho, interrupt)?;
            for k in 0..2 {
                let [constant_part, cos, sin] = [0, 1, 2].map(|i| constant * (high[k][i] - low[k][i]));
                all[1 + 3 * k..4 + 3 * k].copy_from_slice(&[rho * cos, rho * sin, z * constant_part]);
            }
            return Ok(all);
        }
        let mut f = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let l = Longitude { sin, cos };
            let [g, sight, light] = lune.kernel(l);
            let u = lune.point(l, z, rho);
            let [mu, mu0, n] = self.cosines(&u, rho * sight, rho * light);
            let [factor, by_mu, by_mu0, by_phase] = self.scattering.factor_with_partials(mu, mu0);
            let f = rho * g;
            let [share, other_share] = lune.shares(l);
            let by_p = share * share * factor + f * by_mu / n;
            let by_q = other_share * other_share * factor + f * by_mu0 / n;
            let components = lune.components(l, z, rho);
            let mut all = [0.0; PARTIALS];
            all[0] = f * factor;
            for i in 0..3 {
                all[1 + i] = components[i] * by_p;
                all[4 + i] = components[i] * by_q;
                let stretch = u[i] * u[i] / (self.semi_axes[i].powi(3) * n * n);
                all[7 + i] = f * (by_mu * mu + by_mu0 * mu0) * stretch;
            }
            all[10] = f * by_phase;
            Ok(all)
        };
        let mut total = [0.0; PARTIALS];
        for ends in self.pieces(from, to, z, rho) {
            interrupt.charge(NODES, self.time)?;
            let sums = RULE.integrate(ends, &self.tolerances(), &mut f, &mut |_| {})?;
            total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
        }
        Ok(total)
    }

    /// Returns the relative tolerance of an integral along a parallel, raised above the rounding error of positions
    /// on the lune, which grows as the lune narrows.
    fn above_rounding(&self, tolerance: f64) -> f64 {
        let Longitude { sin, cos } = self.lune.angle;
        // The formulas of a rough surface cancel where emission and incidence graze.
        let roundings = if self.law.has_edges() { 1024.0 } else { 16.0 };
        tolerance + roundings * f64::EPSILON / sin.atan2(-cos)
    }

    /// Returns the tolerance of the brightness over a b c. It is wide for a rough surface, whose edges have ends,
    /// near which the brightness is not a smooth function.
    pub fn tolerance(&self) -> f64 {
        self.scale * self.above_rounding(if self.law.has_edges() { 1e-9 } else { TOLERANCE })
    }

    /// Returns the tolerances of [`Self::partials_between`].
    pub fn tolerances(&self) -> [f64; PARTIALS] {
        let mut all = [self.above_rounding(PARTIAL_TOLERANCE) * self.scale; PARTIALS];
        all[0] = self.above_rounding(PARTIAL_TOLERANCE * 1e-2) * self.scale;
        for k in 0..2 {
            all[1 + 3 * k..4 + 3 * k].iter_mut().for_each(|t| *t /= self.lune.lengths[k]);
        }
        (0..3).for_each(|i| all[7 + i] /= self.semi_axes[i]);
        all
    }
}
