//! Data that pairs of equal shapes share, computed once.

use super::fragments::FragmentTree;
use crate::error::Result;
use crate::gravity::{Facets, FarSeries, Layer};
use crate::interrupt::InterruptCheck;
use crate::quadrature::{Nodes, Order};
use crate::shape::{Polyhedron, Shape};
use pulp::Arch;
use std::collections::HashMap;
use std::hash::{Hash, Hasher};
use std::mem::{Discriminant, discriminant};
use std::sync::{Arc, Mutex, PoisonError};

/// The limits on a store: points of nodes, series, faces of polyhedra, and fragments. A store that exceeds one
/// drops all entries of that kind. The limits correspond to some thirty, four, thirty and three hundred
/// megabytes.
const MOST_POINTS: usize = 1 << 20;
const MOST_SERIES: usize = 1 << 12;
const MOST_FACES: usize = 1 << 17;

/// The kind of points that represent the body that is integrated over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum NodeKind {
    /// Points of the body's surface, with the potential as the integrand: the paper's integrals.
    SurfacePotential,
    /// Points of the body's surface, with the field as the integrand; the semi-axes are in the canonical
    /// frame.
    SurfaceField([f64; 3]),
    /// Points of the body's focal ellipse. Inner rings have as many angles as this tolerance needs, or as
    /// many as the outermost ring if it is zero.
    FocalEllipse(f64),
    /// The body's centre: for a sphere, whose focal ellipse is a point, or a point mass.
    Centre,
    /// The points of the layer on a polyhedron's circumscribed sphere.
    Layer,
    /// Points of the faces of a polyhedron.
    Faces,
}

impl NodeKind {
    /// Returns the order on which the nodes depend.
    pub(super) fn order(self, order: Order) -> Order {
        if self == Self::Faces { Order { gauss: 0, angles: 0 } } else { order }
    }

    /// Returns a key of the kind with its parameters, and the function that makes the nodes; `None` where
    /// nodes belong to one polyhedron.
    fn shared(self) -> Option<(u8, [f64; 3], Maker)> {
        Some(match self {
            Self::SurfacePotential => (0, [0.0; 3], |order, _| Nodes::sphere(order)),
            Self::SurfaceField(semi_axes) => (1, semi_axes, Nodes::surface),
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

/// A polyhedron as a key of a map. Copies of one polyhedron are equal, and the key keeps the polyhedron
/// alive.
#[derive(Debug, Clone)]
struct PolyhedronKey(Polyhedron);

impl PartialEq for PolyhedronKey {
    fn eq(&self, other: &Self) -> bool {
        self.0.identity() == other.0.identity()
    }
}

impl Eq for PolyhedronKey {}

impl Hash for PolyhedronKey {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.identity().hash(state);
    }
}

/// The key of a layer: the polyhedron, the degree, and the instructions with which the layer was computed.
type LayerKey = (PolyhedronKey, usize, Discriminant<Arch>);

/// Nodes by order, far-field series by shape, and facets and layers of polyhedra, shared by all pairs that
/// are given the same store, in any thread.
///
/// A pair looks up entries when it is made and when it changes its order, never while it is evaluated. An
/// entry has the same bits as one that the pair would compute itself.
#[derive(Debug, Default)]
pub struct Store {
    nodes: Mutex<HashMap<NodesKey, Arc<Nodes>>>,
    series: Mutex<HashMap<[u64; 3], Arc<FarSeries>>>,
    facets: Mutex<HashMap<PolyhedronKey, Arc<Facets>>>,
    layers: Mutex<HashMap<LayerKey, Arc<Layer>>>,
    fragments: Mutex<HashMap<LayerKey, Arc<FragmentTree>>>,
}

impl Store {
    /// Returns the nodes of an order; `None` where they belong to one polyhedron.
    pub(super) fn nodes(&self, order: Order, node_kind: NodeKind) -> Option<Arc<Nodes>> {
        let (number, more, make) = node_kind.shared()?;
        let key = (order, (number, more.map(f64::to_bits)));
        Some(cached(&self.nodes, key, Nodes::len, MOST_POINTS, || make(order, more)))
    }

    /// Returns the far-field series of a shape.
    pub(super) fn series(&self, shape: &Shape) -> Arc<FarSeries> {
        let key = shape.semi_axes().map(f64::to_bits);
        cached(&self.series, key, |_| 1, MOST_SERIES, || FarSeries::new(shape))
    }

    /// Returns the facets of a polyhedron.
    pub(super) fn facets(&self, polyhedron: &Polyhedron) -> Arc<Facets> {
        let (key, count) = (PolyhedronKey(polyhedron.clone()), polyhedron.faces().len());
        cached(&self.facets, key, |_| count, MOST_FACES, || Facets::new(polyhedron, 1.0))
    }

    /// Returns the layer of a polyhedron. Threads that need the same layer at the same time compute it
    /// separately.
    pub(super) fn layer(
        &self,
        polyhedron: &Polyhedron,
        degree: usize,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Arc<Layer>> {
        let key = (PolyhedronKey(polyhedron.clone()), degree, discriminant(&arch));
        let stored = self.layers.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if let Some(layer) = stored {
            return Ok(layer);
        }
        let layer = Layer::new(polyhedron, degree, arch, interrupt)?;
        Ok(cached(&self.layers, key, |layer| layer.count, MOST_POINTS, || layer))
    }

    /// Returns the tree of the fragments of a polyhedron, with moments up to a degree. A tree with too many
    /// fragments is begun anew.
    pub(super) fn fragments(
        &self,
        polyhedron: &Polyhedron,
        degree: usize,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Arc<FragmentTree>> {
        let key = (PolyhedronKey(polyhedron.clone()), degree, discriminant(&arch));
        let stored = self.fragments.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if let Some(tree) = stored.filter(|tree| tree.count() <= FragmentTree::MOST_FRAGMENTS) {
            return Ok(tree);
        }
        let tree = Arc::new(FragmentTree::new(polyhedron, degree, arch, interrupt)?);
        let mut map = self.fragments.lock().unwrap_or_else(PoisonError::into_inner);
        if map.values().map(|tree| tree.count()).sum::<usize>() > FragmentTree::MOST_FRAGMENTS {
            map.clear();
        }
        map.insert(key, tree.clone());
        Ok(tree)
    }

    /// Returns the numbers of rules, series, polyhedra with facets, and layers.
    pub fn len(&self) -> [usize; 4] {
        [count(&self.nodes), count(&self.series), count(&self.facets), count(&self.layers)]
    }

    /// Returns whether nothing has been stored yet.
    pub fn is_empty(&self) -> bool {
        self.len() == [0; 4]
    }
}

fn count<K, V>(map: &Mutex<HashMap<K, V>>) -> usize {
    map.lock().unwrap_or_else(PoisonError::into_inner).len()
}

/// Returns the entry of a key, and makes it where there is none. Other threads wait meanwhile, since they
/// mostly need the same entry.
fn cached<K: Eq + Hash, V>(
    map: &Mutex<HashMap<K, Arc<V>>>,
    key: K,
    size: impl Fn(&V) -> usize,
    limit: usize,
    make: impl FnOnce() -> V,
) -> Arc<V> {
    let mut map = map.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(stored) = map.get(&key) {
        return stored.clone();
    }
    let made = Arc::new(make());
    if map.values().map(|value| size(value)).sum::<usize>() > limit {
        map.clear();
    }
    map.insert(key, made.clone());
    made
}
