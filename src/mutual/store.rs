//! What pairs of equal shapes have in common, made once.

use crate::error::Result;
use crate::gravity::{Facets, FarSeries, Layer};
use crate::patience::Patience;
use crate::quadrature::{Nodes, Order};
use crate::shape::{Polyhedron, Shape};
use pulp::Arch;
use std::collections::HashMap;
use std::hash::{Hash, Hasher};
use std::mem::{Discriminant, discriminant};
use std::sync::{Arc, Mutex, PoisonError};

/// Points of nodes, series, and faces of polyhedra, of which a store forgets all when it has more: some thirty megabytes, four and
/// thirty.
const MOST_POINTS: usize = 1 << 20;
const MOST_SERIES: usize = 1 << 12;
const MOST_FACES: usize = 1 << 17;

/// The points that stand for the body that is integrated over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Carrier {
    /// Its surface, by the potential: the paper's integrals.
    Pressures,
    /// Its surface, by the field; the semi-axes are in the canonical frame.
    Surface([f64; 3]),
    /// Its focal ellipse, with as many angles on inner rings as a tolerance needs; as on the outermost one if that is zero.
    FocalEllipse(f64),
    /// Its centre: a sphere, whose focal ellipse has shrunk to it, or a point mass.
    Centre,
    /// The layer on a polyhedron's circumscribed sphere.
    Layer,
    /// A polyhedron's faces.
    Faces,
}

impl Carrier {
    /// The order that its nodes depend on.
    pub(super) fn order(self, order: Order) -> Order {
        if self == Self::Faces { Order { gauss: 0, angles: 0 } } else { order }
    }

    /// A number and three more to look it up by, and how its nodes are made from these; none where they belong to one polyhedron.
    fn shared(self) -> Option<(u8, [f64; 3], Maker)> {
        Some(match self {
            Self::Pressures => (0, [0.0; 3], |order, _| Nodes::sphere(order)),
            Self::Surface(semi_axes) => (1, semi_axes, Nodes::surface),
            Self::FocalEllipse(tolerance) => {
                (2, [tolerance, 0.0, 0.0], |order, [tolerance, ..]| Nodes::focal(order, tolerance))
            }
            Self::Centre => (3, [0.0; 3], |_, _| Nodes::centre()),
            Self::Faces => (4, [0.0; 3], |_, _| Nodes::triangles()),
            Self::Layer => return None,
        })
    }
}

type Maker = fn(Order, [f64; 3]) -> Nodes;
type NodesKey = (Order, (u8, [u64; 3]));

/// A polyhedron as a key: copies of one and the same are equal, and the key keeps it.
#[derive(Debug, Clone)]
struct Same(Polyhedron);

impl PartialEq for Same {
    fn eq(&self, other: &Self) -> bool {
        self.0.identity() == other.0.identity()
    }
}

impl Eq for Same {}

impl Hash for Same {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.identity().hash(state);
    }
}

/// A polyhedron, the degree of its layer, and the instructions by which that was made.
type LayerKey = (Same, usize, Discriminant<Arch>);

/// Nodes by order, far-field series by shape, and what polyhedra take, for all pairs that are given the same store, in whatever threads they are.
///
/// A pair looks here when it is made and when it takes an order that is new to it, never while it is evaluated. What it
/// finds has the same bits as what it would make itself.
#[derive(Debug, Default)]
pub struct Store {
    nodes: Mutex<HashMap<NodesKey, Arc<Nodes>>>,
    series: Mutex<HashMap<[u64; 3], Arc<FarSeries>>>,
    facets: Mutex<HashMap<Same, Arc<Facets>>>,
    layers: Mutex<HashMap<LayerKey, Arc<Layer>>>,
}

impl Store {
    /// The nodes of an order; none where they belong to one polyhedron.
    pub(super) fn nodes(&self, order: Order, carrier: Carrier) -> Option<Arc<Nodes>> {
        let (number, more, make) = carrier.shared()?;
        let key = (order, (number, more.map(f64::to_bits)));
        Some(kept(&self.nodes, key, Nodes::len, MOST_POINTS, || make(order, more)))
    }

    /// The far-field series of a shape.
    pub(super) fn series(&self, shape: &Shape) -> Arc<FarSeries> {
        let key = shape.semi_axes().map(f64::to_bits);
        kept(&self.series, key, |_| 1, MOST_SERIES, || FarSeries::new(shape))
    }

    /// The facets of a polyhedron.
    pub(super) fn facets(&self, polyhedron: &Polyhedron) -> Arc<Facets> {
        let (key, count) = (Same(polyhedron.clone()), polyhedron.faces().len());
        kept(&self.facets, key, |_| count, MOST_FACES, || Facets::new(polyhedron, 1.0))
    }

    /// The layer of a polyhedron. Threads that want the same one at a time make it each.
    pub(super) fn layer(
        &self,
        polyhedron: &Polyhedron,
        degree: usize,
        arch: Arch,
        patience: &mut Patience,
    ) -> Result<Arc<Layer>> {
        let key = (Same(polyhedron.clone()), degree, discriminant(&arch));
        let found = self.layers.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if let Some(layer) = found {
            return Ok(layer);
        }
        let layer = Layer::new(polyhedron, degree, arch, patience)?;
        Ok(kept(&self.layers, key, |layer| layer.count, MOST_POINTS, || layer))
    }

    /// How many rules, series, polyhedra with facets, and layers there are.
    pub fn len(&self) -> [usize; 4] {
        [count(&self.nodes), count(&self.series), count(&self.facets), count(&self.layers)]
    }

    /// Whether nothing has been made yet.
    pub fn is_empty(&self) -> bool {
        self.len() == [0; 4]
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
