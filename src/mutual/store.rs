//! What pairs of equal shapes have in common, made once.

use crate::gravity::FarSeries;
use crate::quadrature::{Nodes, Order};
use crate::shape::Shape;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, PoisonError};

/// Points of nodes, and series, of which a store forgets all when it has more: some thirty megabytes and four.
const MOST_POINTS: usize = 1 << 20;
const MOST_SERIES: usize = 1 << 12;

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

impl Carrier {
    fn nodes(self, order: Order) -> Nodes {
        match self {
            Self::Pressures => Nodes::sphere(order),
            Self::Surface(semi_axes) => Nodes::surface(order, semi_axes),
            Self::FocalEllipse => Nodes::focal(order),
            Self::Centre => Nodes::centre(),
        }
    }

    /// The same as something that can be looked up.
    fn key(self) -> (u8, [u64; 3]) {
        match self {
            Self::Pressures => (0, [0; 3]),
            Self::Surface(semi_axes) => (1, semi_axes.map(f64::to_bits)),
            Self::FocalEllipse => (2, [0; 3]),
            Self::Centre => (3, [0; 3]),
        }
    }
}

type NodesKey = (Order, (u8, [u64; 3]));

/// Nodes by order and far-field series by shape, for all pairs that are given the same store, in whatever threads they are.
///
/// A pair looks here when it is made and when it takes an order that is new to it, never while it is evaluated. What it
/// finds has the same bits as what it would make itself.
#[derive(Debug, Default)]
pub struct Store {
    nodes: Mutex<HashMap<NodesKey, Arc<Nodes>>>,
    series: Mutex<HashMap<[u64; 3], Arc<FarSeries>>>,
}

impl Store {
    /// The nodes of an order.
    pub(super) fn nodes(&self, order: Order, carrier: Carrier) -> Arc<Nodes> {
        kept(&self.nodes, (order, carrier.key()), Nodes::len, MOST_POINTS, || carrier.nodes(order))
    }

    /// The far-field series of a shape.
    pub(super) fn series(&self, shape: &Shape) -> Arc<FarSeries> {
        let key = shape.semi_axes().map(f64::to_bits);
        kept(&self.series, key, |_| 1, MOST_SERIES, || FarSeries::new(shape))
    }

    /// How many rules and series there are.
    pub fn len(&self) -> [usize; 2] {
        [count(&self.nodes), count(&self.series)]
    }

    /// Whether nothing has been made yet.
    pub fn is_empty(&self) -> bool {
        self.len() == [0, 0]
    }
}

fn count<K, V>(map: &Mutex<HashMap<K, V>>) -> usize {
    map.lock().unwrap_or_else(PoisonError::into_inner).len()
}

/// What is kept under a key; made where there is nothing. Other threads wait meanwhile, since they mostly want the same.
fn kept<K: Eq + Hash, V>(
    map: &Mutex<HashMap<K, Arc<V>>>,
    key: K,
    size: impl Fn(&V) -> usize,
    most: usize,
    make: impl FnOnce() -> V,
) -> Arc<V> {
    let mut map = map.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = map.get(&key) {
        return found.clone();
    }
    let made = Arc::new(make());
    if map.values().map(|value| size(value)).sum::<usize>() > most {
        map.clear();
    }
    map.insert(key, made.clone());
    made
}
