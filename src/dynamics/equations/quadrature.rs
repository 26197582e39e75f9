//! The quadrature in use for each pair.

use super::Dynamics;
use super::state::State;
use super::system::pose;
use crate::mutual::Method;
use crate::quadrature::Order;

/// The quadrature of the interaction of two bodies, or of a part of one body and a part of the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature {
    /// The indices of the bodies in the system.
    pub bodies: [usize; 2],
    /// The indices of the parts in their bodies; `None` for two ordinary bodies.
    pub parts: Option<[usize; 2]>,
    /// The method of the interaction.
    pub method: Method,
    /// The rule in use; a series has none.
    pub rule: Option<QuadratureRule>,
}

/// A quadrature rule in use.
#[derive(Debug, Clone, PartialEq)]
pub struct QuadratureRule {
    /// The index of the body that is integrated over.
    pub integrated: usize,
    /// The number of points.
    pub points: usize,
    /// The order of the rule.
    pub order: Order,
}

impl Dynamics {
    /// Returns the quadratures in use, with the numbers of points that they take at a state. Pairs of points
    /// are omitted, since they have no quadrature.
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
