//! The quadrature of a pair: which body is integrated over, with which nodes, in which form of the other's field.

use super::BodyGravity;
use super::store::{Carrier, Store};
use crate::error::Result;
use crate::gravity::{FarCut, Layer, Near};
use crate::patience::Patience;
use crate::quadrature::{Nodes, Order};
use pulp::Arch;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The quadrature in force.
#[derive(Debug, Clone)]
pub struct Rule {
    /// 0 where the first body is integrated over.
    pub integrated: usize,
    /// The order of the rule.
    pub order: Order,
    /// The polynomial degree it was made for.
    pub(super) degree: usize,
    pub(super) carrier: Carrier,
    pub(super) nodes: Arc<Nodes>,
    /// Number of points; over faces where the rule was chosen.
    pub(super) points: usize,
    /// Where the second and later pieces of a sum over faces begin.
    pub(super) begins: Vec<usize>,
    pub(super) kernel: Kernel,
    /// Smallest separation that the kernel is made for, in the pair's unit.
    pub(super) valid_from: f64,
}

impl Rule {
    /// Number of points; over faces, whose cells follow the other body, it is that of the pose for which the rule was chosen.
    pub fn nodes(&self) -> usize {
        self.points
    }
}

/// Nodes for the means of the field's gradient, with the rule that they belong to.
#[derive(Debug, Clone)]
pub(super) struct GradientNodes {
    pub integrated: usize,
    pub order: Order,
    pub carrier: Carrier,
    pub nodes: Arc<Nodes>,
}

/// The form of the other body's field.
#[derive(Debug, Clone)]
pub(super) enum Kernel {
    Far(FarCut),
    Near(Near),
    /// A polyhedron's exact field.
    Facets,
    /// A polyhedron's field from a distance.
    Layer(Arc<Layer>),
}

/// The numbers from which a rule is made again, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RuleMemory {
    /// 0 where the first body is integrated over.
    pub integrated: u8,
    /// Gauss nodes and angles.
    pub order: [u32; 2],
    /// The polynomial degree the rule was made for.
    pub degree: u32,
    /// Smallest separation that its kernel is made for.
    pub valid_from: f64,
}

/// The nodes that a pair has had, by order.
#[derive(Debug, Clone)]
pub(super) struct NodeStore {
    own: Vec<(Order, Carrier, Arc<Nodes>)>,
    shared: Arc<Store>,
}

impl NodeStore {
    pub(super) fn new(shared: Arc<Store>) -> Self {
        Self { own: Vec::new(), shared }
    }

    /// The nodes of a body; those of a layer take its moments.
    pub(super) fn get(
        &mut self,
        order: Order,
        carrier: Carrier,
        set: &BodyGravity,
        arch: Arch,
        patience: &mut Patience,
    ) -> Result<Arc<Nodes>> {
        let order = carrier.order(order);
        if let Some((.., nodes)) = self.own.iter().find(|(o, c, _)| *o == order && *c == carrier) {
            return Ok(nodes.clone());
        }
        let nodes = match self.shared.nodes(order, carrier) {
            Some(nodes) => nodes,
            None => Arc::new(Nodes::layer(&*set.layer(order.gauss - 1, arch, patience)?)),
        };
        self.own.push((order, carrier, nodes.clone()));
        Ok(nodes)
    }
}
