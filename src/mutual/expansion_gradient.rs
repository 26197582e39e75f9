//! The derivatives of force and torques by the expansion of [`super::expansion`].
//!
//! A rotation of a body by dtheta changes its polynomial p by dtheta . V p with V p = dp/dk x k, so that the
//! torque is U with V p instead of p. The derivative of the torque with respect to the other body's rotation
//! has V on both polynomials, and the derivative with respect to its own rotation has V V p. The separation
//! takes further derivatives of 1/r. Lengths act through the moments: those of the exponent n along an axis
//! are proportional to a^n.

use super::derivatives::Derivatives;
use super::expansion::{Expansion, Polynomials, product, variation};
use super::series_jacobian::{index, symmetric};
use super::{Interaction, Jacobian, Method, Pose, ShapeDerivatives};
use crate::math::matrix::{times, transposed_times};
use crate::math::monomials::{count, offset};
use crate::math::rotation::turned_back;
use crate::math::{Mat3, Vec3};

const DERIVATIVES: usize = offset(Method::BEYOND + 2);

impl Expansion {
    /// Returns the derivatives of force and torques with respect to the pose.
    pub fn jacobian(&self, pose: &Pose) -> Jacobian {
        let scale = pose.separation.norm();
        let (a, b) = self.turned(pose, scale);
        let degree = self.degree();
        let derivatives = Derivatives::<DERIVATIVES>::new(&(pose.separation / scale), degree + 2);
        let (mut gradient, mut hessian) = ([0.0; 3], [0.0; 6]);
        let (mut torques, mut by_position) = ([[0.0; 3]; 2], [[[0.0; 3]; 3]; 2]);
        let mut by_turn = [[Mat3::zeros(); 2]; 2];
        for d in 0..=degree {
            for e in 0..=degree - d {
                let all = d + e;
                let (p, q) = (a.of(d), b.of(e));
                let both = product(p, d, q, e);
                derivatives.add_higher(&mut gradient, &both[..count(all)], all, 1);
                derivatives.add_higher(&mut hessian, &both[..count(all)], all, 2);
                let [vp, vq] = [(p, d), (q, e)].map(|(p, d)| [0, 1, 2].map(|i| variation(p, d, i)));
                for i in 0..3 {
                    let own = [product(&vp[i][..count(d)], d, q, e), product(p, d, &vq[i][..count(e)], e)];
                    for body in 0..2 {
                        torques[body][i] += derivatives.contract(&own[body][..count(all)], all);
                        derivatives.add_higher(&mut by_position[body][i], &own[body][..count(all)], all, 1);
                    }
                    for j in 0..3 {
                        let crossed = product(&vp[i][..count(d)], d, &vq[j][..count(e)], e);
                        by_turn[0][1][(i, j)] += derivatives.contract(&crossed[..count(all)], all);
                        let twice = product(&variation(&vp[j][..count(d)], d, i)[..count(d)], d, q, e);
                        by_turn[0][0][(i, j)] += derivatives.contract(&twice[..count(all)], all);
                        let twice = product(p, d, &variation(&vq[j][..count(e)], e, i)[..count(e)], e);
                        by_turn[1][1][(i, j)] += derivatives.contract(&twice[..count(all)], all);
                    }
                }
            }
        }
        let rotations = [&pose.rotation_first, &pose.rotation_second];
        let torques = [0, 1].map(|body| turned_back(rotations[body], &Vec3::from(torques[body])) / scale);
        let rows = |rows: &[[f64; 3]; 3]| Mat3::from_fn(|i, j| rows[i][j]);
        let in_bodies =
            |i: usize, j: usize| transposed_times(rotations[i], &times(&by_turn[i][j], rotations[j])) / scale;
        Jacobian {
            loads: Interaction {
                force_on_first: -Vec3::from(gradient) / (scale * scale),
                torque_first: torques[0],
                torque_second: torques[1],
            },
            force_by_separation: -symmetric(|i, j| hessian[index([i, j])]) / (scale * scale * scale),
            torque_by_separation: [0, 1]
                .map(|body| transposed_times(rotations[body], &rows(&by_position[body])) / (scale * scale)),
            torque_by_rotation: [0, 1].map(|body| in_bodies(body, body) + torques[body].cross_matrix()),
            torque_first_by_second: in_bodies(0, 1),
        }
    }

    /// Returns the derivatives of force and torques with respect to the lengths of both bodies.
    pub fn shape_derivatives(&self, pose: &Pose) -> ShapeDerivatives {
        let mut out = ShapeDerivatives::none();
        for body in 0..2 {
            let with = |lengths: &Polynomials| {
                let mut bodies = self.bodies;
                bodies[body] = *lengths;
                self.with_moments(bodies).interaction(pose)
            };
            if let Some(axes) = self.semi_axes[body] {
                for (axis, length) in axes.into_iter().enumerate() {
                    out.axes[body][axis] = with(&self.bodies[body].weighted(|e| e[axis] as f64 / length));
                }
            } else {
                out.scale[body] = with(&self.bodies[body].weighted(|e| (e[0] + e[1] + e[2]) as f64));
            }
        }
        out
    }
}
