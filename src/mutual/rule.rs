//! The quadrature of a pair: which body is integrated over, with which nodes, and in which form of the field
//! of the other body.

use super::PartGravity;
use super::store::{NodeKind, Store};
use crate::error::Result;
use crate::gravity::{FarTruncation, Layer, Near};
use crate::interrupt::InterruptCheck;
use crate::quadrature::{Nodes, Order};
use pulp::Arch;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The quadrature in use.
#[derive(Debug, Clone)]
pub struct Rule {
    /// The index of the body that is integrated over, 0 or 1.
    pub integrated: usize,
    /// The order of the rule.
    pub order: Order,
    /// The polynomial degree for which the rule was made.
    pub(super) degree: usize,
    pub(super) node_kind: NodeKind,
    pub(super) nodes: Arc<Nodes>,
    /// The number of points; over faces, it is the number at the pose for which the rule was chosen.
    pub(super) points: usize,
    /// The indices at which the second and later pieces of a sum over faces begin.
    pub(super) begins: Vec<usize>,
    pub(super) kernel: Kernel,
    /// The smallest separation for which the kernel is valid, in the pair's unit.
    pub(super) valid_from: f64,
}

impl Rule {
    /// Returns the number of points. Over faces, whose cells depend on the other body, it is the number at
    /// the pose for which the rule was chosen.
    pub fn nodes(&self) -> usize {
        self.points
    }
}

/// Nodes for the means of the field's gradient, with the rule to which they belong.
#[derive(Debug, Clone)]
pub(super) struct GradientNodes {
    pub integrated: usize,
    pub order: Order,
    pub node_kind: NodeKind,
    pub nodes: Arc<Nodes>,
}

/// The quadratures of the derivatives of a pair with a polyhedron.
#[derive(Debug, Clone)]
pub(super) struct FacetedRules {
    /// The quadrature for the derivatives with respect to the pose.
    pub pose: Rule,
    /// The quadrature over the polyhedron for the derivatives with respect to the semi-axes of a sphere,
    /// where the pose's rule takes the sphere's centre alone.
    pub lengths: Option<Rule>,
}

/// The form in which the other body's field is evaluated.
#[derive(Debug, Clone)]
pub(super) enum Kernel {
    Far(FarTruncation),
    Near(Near),
    /// A polyhedron's exact field.
    Facets,
    /// A polyhedron's field from a distance.
    Layer(Arc<Layer>),
}

/// The numbers from which a rule is reconstructed, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum RuleMemory {
    /// A quadrature.
    Quadrature {
        /// The index of the body that is integrated over, 0 or 1.
        integrated: u8,
        /// The numbers of Gauss nodes and of angles.
        order: [u32; 2],
        /// The polynomial degree for which the rule was made.
        degree: u32,
        /// The smallest separation for which the kernel is valid.
        valid_from: f64,
    },
    /// A harmonic series.
    Harmonic {
        /// The highest degrees of both bodies.
        degrees: [u32; 2],
        /// The degrees to which their moments are known.
        moment_degrees: [u32; 2],
        /// The smallest separation for which they reach the tolerance.
        valid_from: f64,
    },
    /// A sum over fragments.
    Fragments {
        /// The number of shares of the tolerance.
        shares: u32,
        /// The work of an evaluation at the pose for which the rule was chosen.
        work: u64,
    },
}

impl RuleMemory {
    /// Returns the smallest separation for which the rule is valid.
    pub fn valid_from(&self) -> f64 {
        match *self {
            Self::Quadrature { valid_from, .. } | Self::Harmonic { valid_from, .. } => valid_from,
            Self::Fragments { .. } => 0.0,
        }
    }
}

/// The order and the kind of nodes, and for those of a layer the identity of the polyhedron.
type NodeKey = (Order, NodeKind, Option<(usize, u64)>);

/// The nodes that a pair has used.
#[derive(Debug, Clone)]
pub(super) struct NodeStore {
    local: Vec<(NodeKey, Arc<Nodes>)>,
    shared: Arc<Store>,
}

impl NodeStore {
    pub(super) fn new(shared: Arc<Store>) -> Self {
        Self { local: Vec::new(), shared }
    }

    /// Returns the nodes of a body, computing those of a layer from its moments.
    pub(super) fn get(
        &mut self,
        order: Order,
        node_kind: NodeKind,
        set: &PartGravity,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Arc<Nodes>> {
        let order = node_kind.order(order);
        let polyhedron = set.polyhedron().filter(|_| node_kind == NodeKind::Layer).map(|p| p.identity());
        let key = (order, node_kind, polyhedron);
        if let Some((_, nodes)) = self.local.iter().find(|(stored, _)| *stored == key) {
            return Ok(nodes.clone());
        }
        let nodes = match self.shared.nodes(order, node_kind) {
            Some(nodes) => nodes,
            None => Arc::new(Nodes::layer(&*set.layer(order.gauss - 1, arch, interrupt)?)),
        };
        self.local.push((key, nodes.clone()));
        Ok(nodes)
    }
}
