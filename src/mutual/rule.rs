//! The quadrature of a pair: which body is integrated over, with which nodes, in which form of the other's field.

use crate::gravity::{FarCut, Near};
use crate::quadrature::{Nodes, Order};
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
    pub(super) nodes: Arc<Nodes>,
    pub(super) kernel: Kernel,
    /// Smallest separation that the kernel is made for, in the pair's unit.
    pub(super) valid_from: f64,
}

impl Rule {
    /// Number of points.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }
}

/// The form of the other body's field.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kernel {
    Far(FarCut),
    Near(Near),
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

/// The points that stand for the body that is integrated over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Carrier {
    /// Its surface, by the potential: the paper's integrals.
    Pressures,
    /// Its surface, by the field; the semi-axes are in the canonical frame.
    Surface([f64; 3]),
    /// Its focal ellipse.
    FocalEllipse,
    /// Its centre: a sphere, whose focal ellipse has shrunk to it, or a point mass.
    Centre,
}

/// Nodes by order, each made once.
#[derive(Debug, Clone, Default)]
pub(super) struct NodeStore(Vec<(Order, Carrier, Arc<Nodes>)>);

impl NodeStore {
    pub(super) fn get(&mut self, order: Order, carrier: Carrier) -> Arc<Nodes> {
        if let Some((.., nodes)) = self.0.iter().find(|(o, c, _)| *o == order && *c == carrier) {
            return nodes.clone();
        }
        let nodes = Arc::new(match carrier {
            Carrier::Pressures => Nodes::sphere(order),
            Carrier::Surface(semi_axes) => Nodes::surface(order, semi_axes),
            Carrier::FocalEllipse => Nodes::focal(order),
            Carrier::Centre => Nodes::centre(),
        });
        self.0.push((order, carrier, nodes.clone()));
        nodes
    }
}
