//! Nodes and weights of the rules.

use super::Order;
use super::cells::MOST_POINTS;
use super::convergence::angles_of_ring;
use crate::gravity::Layer;
use crate::math::lanes::BLOCK;
use crate::math::triangle::{self, TriangleNode};
use gauss_quad::GaussLegendre;
use std::f64::consts::TAU;
use std::num::NonZeroUsize;
use std::ops::{AddAssign, Range};

/// Points with weights that add up to one, stored by component and padded with weightless points to whole
/// blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Nodes {
    /// The coordinates of the points; the focal rule has no third one.
    pub points: [Vec<f64>; 3],
    /// The weights of the points.
    pub weights: Vec<f64>,
    count: usize,
}

/// A range of a rule's nodes, in whole blocks.
#[derive(Clone, Copy)]
pub struct NodeRange<'a> {
    /// The coordinates of the points.
    pub points: [&'a [f64]; 3],
    /// The weights of the points.
    pub weights: &'a [f64],
    /// The number of points with a weight, which come first.
    pub count: usize,
}

/// The largest number of nodes in a partial sum.
const LONGEST: usize = 64 * BLOCK;

impl Nodes {
    /// Returns the rule for means over the unit sphere: Gauss-Legendre in z = cos(theta), trapezoidal in
    /// alpha.
    ///
    /// The surface point of the paper's `eq:Rotated_local_point` is (a x, b y, c z), and the surface elements
    /// are n dS = (b c x, c a y, a b z) dOmega, which is `eq:Force_element` with z in units of c.
    pub fn sphere(order: Order) -> Self {
        let mut nodes = Self::empty();
        let rule = GaussLegendre::new(nonzero(order.gauss));
        for (&z, &weight) in rule.nodes().zip(rule.weights()) {
            nodes.ring(((1.0 - z) * (1.0 + z)).sqrt(), z, 0.5 * weight, order.angles);
        }
        nodes.padded()
    }

    /// Returns the rule for means over a homogeneous ellipsoid of functions that are harmonic in it. It takes
    /// only points of the surface (a x, b y, c z), and its nodes are those of the unit sphere.
    ///
    /// Green's second identity with P = 1 - sum y_i^2/a_i^2, which vanishes on the surface and whose
    /// Laplacian is -2 sum 1/a_i^2, makes the mean of a harmonic h equal to 3 <h sum x_i^2/a_i^2> / sum
    /// 1/a_i^2, with <.> the mean over the sphere.
    pub fn surface(order: Order, semi_axes: [f64; 3]) -> Self {
        let shortest = semi_axes.into_iter().fold(f64::INFINITY, f64::min);
        let share = semi_axes.map(|a| (shortest / a) * (shortest / a));
        let sum: f64 = share.iter().sum();
        let Self { points, mut weights, count } = Self::sphere(order);
        for (k, weight) in weights.iter_mut().enumerate() {
            *weight *= 3.0 * (0..3).map(|i| points[i][k] * points[i][k] * share[i]).sum::<f64>() / sum;
        }
        Self { points, weights, count }
    }

    /// Returns the rule for means over the unit disc with density proportional to t = sqrt(1 - x^2 - y^2).
    ///
    /// With x = sqrt(1 - t^2) cos(alpha) the mean is int 3 t^2 dt over [0, 1] of the mean over alpha, which
    /// is even in t. The Gauss rule of n points for the weight t^2 on [-1, 1] is the Gauss-Legendre rule of 2
    /// n + 1 points without the one at zero, with each weight times t^2: P_{2n+1}(t)/t is orthogonal to all
    /// lower powers under t^2.
    ///
    /// The outermost ring has the angles of the order; with a tolerance the inner rings have no more than
    /// they need for it.
    pub fn focal(order: Order, tolerance: f64) -> Self {
        let mut nodes = Self::empty();
        let rule = GaussLegendre::new(nonzero(2 * order.gauss + 1));
        let positive = rule.nodes().zip(rule.weights()).filter(|(t, _)| **t > 1e-9);
        let ring = |(&t, &weight): (&f64, &f64)| (((1.0 - t) * (1.0 + t)).sqrt(), 3.0 * t * t * weight);
        let rings: Vec<_> = positive.map(ring).collect();
        let outermost = rings.iter().copied().fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        for (radius, weight) in rings {
            let angles = angles_of_ring(order.angles, outermost.0 / radius, weight / outermost.1, tolerance);
            nodes.ring(radius, 0.0, weight, angles);
        }
        nodes.padded()
    }

    /// Returns the rule of one point, for a body whose focal ellipse is its centre: a sphere or a point mass.
    pub fn centre() -> Self {
        let mut nodes = Self::empty();
        nodes.ring(0.0, 0.0, 1.0, 1);
        nodes.padded()
    }

    /// Returns the points of a layer, in its unit of length.
    pub fn layer(layer: &Layer) -> Self {
        let Layer { points, weights, count } = layer.clone();
        Self { points, weights, count }
    }

    /// Returns all Gauss rules for triangles up to `MOST_POINTS` points along a side, one after the other.
    /// Points are given by their weights in the three corners; [`Self::triangle_start`] returns the index at which
    /// each rule begins.
    pub fn triangles() -> Self {
        let mut nodes = Self::empty();
        for n in 2..=MOST_POINTS {
            for TriangleNode { shares, weight } in triangle::rule(n) {
                nodes.points.iter_mut().zip(shares).for_each(|(p, share)| p.push(share));
                nodes.weights.push(weight);
            }
            nodes = nodes.padded();
        }
        nodes
    }

    /// Returns the index at which the triangle rule of n^2 points begins.
    pub fn triangle_start(n: usize) -> usize {
        (2..n).map(|m| (m * m).next_multiple_of(BLOCK)).sum()
    }

    /// Returns a sum over the nodes, made of partial sums. A plain sum of many nearly equal terms would lose
    /// digits in proportion to their number, since all are rounded to the same side.
    #[inline(always)]
    pub fn sum<T: AddAssign>(&self, over: impl Fn(NodeRange<'_>) -> T) -> T {
        let length = self.weights.len();
        let mut sum = over(self.part(0..length.min(LONGEST)));
        for from in (LONGEST..length).step_by(LONGEST) {
            sum += over(self.part(from..length.min(from + LONGEST)));
        }
        sum
    }

    /// Returns the nodes of a range, which ends between blocks.
    #[inline(always)]
    fn part(&self, range: Range<usize>) -> NodeRange<'_> {
        let [x, y, z] = &self.points;
        let points = [&x[range.clone()], &y[range.clone()], &z[range.clone()]];
        let count = self.count.min(range.end) - range.start;
        NodeRange { points, weights: &self.weights[range], count }
    }

    /// Returns the number of points with a weight.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Returns whether there is no point; no rule made here is empty.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    fn empty() -> Self {
        Self { points: Default::default(), weights: Vec::new(), count: 0 }
    }

    fn ring(&mut self, radius: f64, z: f64, weight: f64, angles: usize) {
        for k in 0..angles {
            let (sin, cos) = (TAU * (k as f64 + 0.5) / angles as f64).sin_cos();
            self.points[0].push(radius * cos);
            self.points[1].push(radius * sin);
            self.points[2].push(z);
            self.weights.push(weight / angles as f64);
        }
    }

    fn padded(mut self) -> Self {
        self.count = self.weights.len();
        let length = self.count.next_multiple_of(BLOCK);
        self.points.iter_mut().for_each(|p| p.resize(length, 0.0));
        self.weights.resize(length, 0.0);
        self
    }
}

fn nonzero(n: usize) -> NonZeroUsize {
    NonZeroUsize::new(n.max(1)).unwrap_or(NonZeroUsize::MIN)
}
