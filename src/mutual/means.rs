//! A body's attraction as the mean of the other body's g, r x g and Phi over points that represent it.
//!
//! All three are harmonic functions within a body that does not touch the other one. Their means over a
//! homogeneous ellipsoid equal means over its surface or its focal ellipse alone. By the third law they are
//! the force, torque and energy of the pair.
//!
//! Focal rule: outside itself, an ellipsoid (a >= b >= c) attracts like its focal ellipse, x^2/(a^2-c^2) +
//! y^2/(b^2-c^2) <= 1, with mass in proportion to sqrt(1 - x^2/(a^2-c^2) - y^2/(b^2-c^2)). This is
//! Maclaurin's theorem on confocal ellipsoids, applied to the flattest one.
//!
//! Surface rule: by Green's second identity an ellipsoid attracts like its surface y = (a u, b v, c w) over
//! the unit sphere, with mass in proportion to u^2/a^2 + v^2/b^2 + w^2/c^2 per solid angle; see
//! [`Nodes::surface`]. These are the paper's surface integrals in another form. In the paper's form the force
//! across a thin or small body is a difference of pressures that are nearly equal on both faces, divided by
//! the thickness; in this form all terms have one sign.

use super::{Balance, Roles};
use crate::gravity::FieldKernel;
use crate::math::Vec3;
use crate::math::lanes::{INTERLEAVED, Lanes, Total, splat_vector, total_vector};
use crate::quadrature::{NodeRange, Nodes};
use pulp::{Arch, Simd, WithSimd};
use std::ops::AddAssign;

/// Returns force and torques; `node_scales` are the factors from the nodes' coordinates to the body's
/// canonical frame.
pub(super) fn force_and_torque<const D: usize>(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    node_scales: [f64; D],
    roles: &Roles,
) -> Balance {
    let axes = std::array::from_fn(|k| roles.rotation.column(k) * node_scales[k]);
    let origin = roles.origin;
    let sums =
        nodes.sum(|nodes| arch.dispatch(ForceSum(NodesInField::<_, D> { kernel, nodes, origin, axes })));
    Balance {
        force: sums.force,
        torque: (1..D).fold(axes[0].cross(&sums.moment[0]), |sum, k| sum + axes[k].cross(&sums.moment[k])),
        torque_field: sums.torque_field,
    }
}

/// Returns the mean of Phi.
pub(super) fn mean_potential<const D: usize>(
    arch: Arch,
    kernel: impl FieldKernel,
    nodes: &Nodes,
    node_scales: [f64; D],
    roles: &Roles,
) -> f64 {
    let axes = std::array::from_fn(|k| roles.rotation.column(k) * node_scales[k]);
    let origin = roles.origin;
    nodes.sum(|nodes| arch.dispatch(PotentialSum(NodesInField::<_, D> { kernel, nodes, origin, axes })))
}

/// The nodes of a body in the field of another one.
pub(super) struct NodesInField<'a, K, const D: usize> {
    pub kernel: K,
    pub nodes: NodeRange<'a>,
    pub origin: Vec3,
    /// The vectors of the nodes' coordinates.
    pub axes: [Vec3; D],
}

struct ForceSum<'a, K, const D: usize>(NodesInField<'a, K, D>);

struct ForceMeans<const D: usize> {
    /// The mean of g.
    force: Vec3,
    /// The means of y_k g, with y the node.
    moment: [Vec3; D],
    /// The mean of -x cross g.
    torque_field: Vec3,
}

impl<const D: usize> AddAssign for ForceMeans<D> {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque_field += other.torque_field;
        self.moment.iter_mut().zip(other.moment).for_each(|(sum, more)| *sum += more);
    }
}

impl<K: FieldKernel, const D: usize> WithSimd for ForceSum<'_, K, D> {
    type Output = ForceMeans<D>;

    /// Processes six registers side by side, and the remainder in fives, fours or twos, to hide the latency
    /// of the instructions.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> ForceMeans<D> {
        let zero = Total::zero(simd);
        let mut running = ForceAccumulator { force: [zero; 3], moments: [[zero; 3]; D], torque: [zero; 3] };
        let registers = self.0.nodes.count.div_ceil(S::F64_LANES);
        let grouped = registers - registers % 6;
        for register in (0..grouped).step_by(6) {
            running.add::<_, 6>(simd, &self.0, register);
        }
        match registers - grouped {
            5 => running.add::<_, 5>(simd, &self.0, grouped),
            3 | 4 => running.add::<_, 4>(simd, &self.0, grouped),
            1 | 2 => running.add::<_, 2>(simd, &self.0, grouped),
            _ => {}
        }
        let mut moment = [Vec3::zeros(); D];
        for k in 0..D {
            moment[k] = -total_vector(running.moments[k]);
        }
        let torque_field = total_vector(running.torque);
        ForceMeans { force: -total_vector(running.force), moment, torque_field }
    }
}

/// The running sums over the nodes.
struct ForceAccumulator<S: Simd, const D: usize> {
    force: [Total<S>; 3],
    moments: [[Total<S>; 3]; D],
    torque: [Total<S>; 3],
}

impl<S: Simd, const D: usize> ForceAccumulator<S, D> {
    /// Adds the nodes of `N` registers, starting from one.
    #[inline(always)]
    fn add<K: FieldKernel, const N: usize>(
        &mut self,
        simd: S,
        sum: &NodesInField<'_, K, D>,
        register: usize,
    ) {
        let positions: NodePositions<S, D, N> = NodePositions::new(simd, &sum.origin, &sum.axes);
        let (y, weight) = load(simd, &sum.nodes, register);
        let x = positions.at(y);
        let field = sum.kernel.field(x);
        let wx = [weight * x[0], weight * x[1], weight * x[2]];
        for i in 0..3 {
            let attraction = wx[i] * field.rd[i];
            self.force[i].add_product(wx[i], field.rd[i]);
            for k in 0..D {
                self.moments[k][i].add_product(attraction, y[k]);
            }
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.torque[i].add_product(wx[j] * x[k], field.rd_difference[i]);
        }
    }
}

struct PotentialSum<'a, K, const D: usize>(NodesInField<'a, K, D>);

impl<K: FieldKernel, const D: usize> WithSimd for PotentialSum<'_, K, D> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let NodesInField { kernel, nodes, origin, axes } = self.0;
        let [u, v, w] = nodes.points;
        let (u, v, w) = (Lanes::blocks(simd, u), Lanes::blocks(simd, v), Lanes::blocks(simd, w));
        let weights = Lanes::blocks(simd, nodes.weights);
        let positions: NodePositions<S, D> = NodePositions::new(simd, &origin, &axes);
        let mut sum = Total::zero(simd);
        for (((u, v), w), weight) in u.zip(v).zip(w).zip(weights) {
            sum.add_product(weight, kernel.potential(positions.at([u, v, w])));
        }
        sum.value()
    }
}

/// Loads the nodes of `N` registers, starting from one, and their weights.
#[inline(always)]
pub(super) fn load<S: Simd, const N: usize>(
    simd: S,
    nodes: &NodeRange<'_>,
    register: usize,
) -> ([Lanes<S, N>; 3], Lanes<S, N>) {
    let from = register * S::F64_LANES;
    let mut y = [Lanes::splat(simd, 0.0); 3];
    for i in 0..3 {
        y[i] = Lanes::load(simd, &nodes.points[i][from..], 0);
    }
    (y, Lanes::load(simd, &nodes.weights[from..], 0))
}

/// Maps nodes to their positions from the field body's centre.
#[derive(Clone, Copy)]
pub(super) struct NodePositions<S: Simd, const D: usize, const N: usize = INTERLEAVED> {
    origin: [Lanes<S, N>; 3],
    axes: [[Lanes<S, N>; 3]; D],
}

impl<S: Simd, const D: usize, const N: usize> NodePositions<S, D, N> {
    #[inline(always)]
    pub fn new(simd: S, origin: &Vec3, vectors: &[Vec3; D]) -> Self {
        let origin = splat_vector(simd, origin);
        let mut axes = [origin; D];
        for k in 0..D {
            axes[k] = splat_vector(simd, &vectors[k]);
        }
        Self { origin, axes }
    }

    #[inline(always)]
    /// Returns the position of a node with these coordinates.
    pub fn at(self, y: [Lanes<S, N>; 3]) -> [Lanes<S, N>; 3] {
        let mut x = self.origin;
        for k in (0..D).rev() {
            for i in 0..3 {
                x[i] = self.axes[k][i].mul_add(y[k], x[i]);
            }
        }
        x
    }
}
