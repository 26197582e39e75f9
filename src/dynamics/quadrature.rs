//! Which quadrature is in force for which pair.

use super::system::pose;
use super::{Dynamics, State};
use crate::mutual::Method;
use crate::quadrature::Order;

/// How the interaction of two bodies, or of a part of one and a part of the other, is computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature {
    /// Places of the bodies in the system.
    pub bodies: [usize; 2],
    /// Numbers of the parts in their bodies; none of two ordinary bodies.
    pub parts: Option<[usize; 2]>,
    /// The method.
    pub method: Method,
    /// The rule in force; a series has none.
    pub rule: Option<QuadratureRule>,
}

/// A rule in force.
#[derive(Debug, Clone, PartialEq)]
pub struct QuadratureRule {
    /// Place of the body that is integrated over.
    pub integrated: usize,
    /// Number of points.
    pub points: usize,
    /// The rule's order.
    pub order: Order,
}

impl Dynamics {
    /// The quadratures in force, with the points that they take at a state. Two points take none and are left out.
    pub fn quadratures_at(&self, state: &State) -> Vec<Quadrature> {
        let row = |(i, j, link): &(usize, usize, crate::mutual::Link)| {
            let bodies = [*i, *j];
            let rule = link.pair.rule().map(|rule| QuadratureRule {
                integrated: bodies[rule.integrated],
                points: link.points(&pose(state, *i, *j)).unwrap_or(0),
                order: rule.order,
            });
            Quadrature { bodies, parts: link.parts(), method: link.pair.method(), rule }
        };
        self.links.iter().map(row).filter(|row| row.method != Method::Point).collect()
    }
}
