//! The quadrature of a pair: which body is integrated over, with which nodes, in which form of the other's field.

use super::store::{Carrier, Store};
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

    pub(super) fn get(&mut self, order: Order, carrier: Carrier) -> Arc<Nodes> {
        if let Some((.., nodes)) = self.own.iter().find(|(o, c, _)| *o == order && *c == carrier) {
            return nodes.clone();
        }
        let nodes = self.shared.nodes(order, carrier);
        self.own.push((order, carrier, nodes.clone()));
        nodes
    }
}
