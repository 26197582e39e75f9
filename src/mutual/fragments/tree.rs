//! The tree of a polyhedron's fragments.
//!
//! A plane through the centre of mass, across the longest extent, cuts a fragment into two halves, and these
//! again, to any depth. Each fragment is a closed surface of triangles. The section that closes a half is a
//! fan of triangles from one of its points: where the section is not convex or has several outlines,
//! triangles of the fan have opposite orientations where they lie outside it, and cancel in every integral.

use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::mutual::harmonic::sizes_and_tail;
use crate::shape::{BoundingBox, Polyhedron, solid_moments};
use pulp::Arch;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

type Triangle = [Vec3; 3];

/// A part of a polyhedron between planes that divide it.
#[derive(Debug)]
pub(in crate::mutual) struct Fragment {
    /// The centre of mass in the polyhedron's frame.
    pub centre: Vec3,
    /// The radius of the sphere about the centre that contains the fragment.
    pub radius: f64,
    /// The fragment's share of the polyhedron's volume.
    pub share: f64,
    /// An upper bound of the field of the fragment at any point, per unit of its GM: that of the body of this
    /// volume and density that attracts most strongly.
    pub field_bound: f64,
    /// The moments about the centre in units of the radius, and their sizes in each degree and beyond.
    pub moments: Vec<f64>,
    pub sizes: Vec<f64>,
    pub tail: f64,
    triangles: Vec<Triangle>,
    halves: OnceLock<Box<[Fragment; 2]>>,
}

/// The fragments of a polyhedron, which are made when they are first needed, and do not depend on the order in
/// which they are made.
#[derive(Debug)]
pub(in crate::mutual) struct FragmentTree {
    pub root: Fragment,
    pub degree: usize,
    volume: f64,
    count: AtomicUsize,
    arch: Arch,
}

impl FragmentTree {
    /// The number of fragments above which the tree is made again, which bounds its memory.
    pub const MOST_FRAGMENTS: usize = 1 << 16;

    /// Makes the tree, with moments of the whole polyhedron up to a degree.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn new(
        polyhedron: &Polyhedron,
        degree: usize,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        let triangles = (0..polyhedron.faces().len()).map(|face| polyhedron.corners(face)).collect();
        let volume = polyhedron.volume();
        let root = Fragment::new(triangles, volume, degree, arch, interrupt)?;
        Ok(Self { root, degree, volume, count: AtomicUsize::new(1), arch })
    }

    /// Returns the number of fragments that have been made.
    pub fn count(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }

    /// Returns the halves of a fragment, which it makes if they do not exist yet.
    #[inline]
    pub fn halves<'a>(&'a self, fragment: &'a Fragment) -> &'a [Fragment; 2] {
        fragment.halves.get_or_init(|| {
            let halves = self.split(fragment, &mut InterruptCheck::never());
            halves.unwrap_or_else(|_| Box::new([0, 1].map(|_| Fragment::none())))
        })
    }

    /// Makes the halves of a fragment unless they exist.
    ///
    /// # Errors
    /// [`crate::error::Error::Interrupted`].
    pub fn make_halves(&self, fragment: &Fragment, interrupt: &mut InterruptCheck) -> Result<()> {
        if fragment.halves.get().is_none() {
            // If another thread has set the halves meanwhile, they are the same.
            let _ = fragment.halves.set(self.split(fragment, interrupt)?);
        }
        Ok(())
    }

    /// Makes the halves of a fragment.
    fn split(&self, fragment: &Fragment, interrupt: &mut InterruptCheck) -> Result<Box<[Fragment; 2]>> {
        self.count.fetch_add(2, Ordering::Relaxed);
        let [low, high] = split(&fragment.triangles, &fragment.centre);
        let mut make =
            |triangles| Fragment::new(triangles, self.volume, self.degree, self.arch, &mut *interrupt);
        Ok(Box::new([make(low)?, make(high)?]))
    }
}

impl Fragment {
    fn new(
        triangles: Vec<Triangle>,
        total_volume: f64,
        degree: usize,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<Self> {
        /// The field at the pole of the body that attracts most strongly, over G rho V^(1/3): at most
        /// 2.648, where that of a ball is 2.599.
        const STRONGEST: f64 = 2.65;
        let origin = triangles.first().map_or(Vec3::zeros(), |t| t[0]);
        let (mut volume, mut first) = (0.0, Vec3::zeros());
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|v| v - origin);
            let v = a.dot(&b.cross(&c)) / 6.0;
            volume += v;
            first += v * 0.25 * (a + b + c);
        }
        // A cut may leave a sliver whose volume is zero within rounding.
        let share = volume / total_volume;
        if share <= f64::EPSILON * f64::EPSILON {
            return Ok(Self::none());
        }
        let degree = degree_of(share, degree);
        let centre = origin + first / volume;
        let radius = triangles.iter().flatten().map(|v| (v - centre).norm()).fold(0.0, f64::max);
        let scaled = triangles.iter().map(|triangle| triangle.map(|v| (v - centre) / radius));
        let moments = solid_moments(scaled, volume / radius.powi(3), degree, arch, interrupt)?;
        let (sizes, tail) = sizes_and_tail(&moments);
        let field_bound = STRONGEST * volume.powf(-2.0 / 3.0);
        let halves = OnceLock::new();
        Ok(Self { centre, radius, share, field_bound, moments, sizes, tail, triangles, halves })
    }

    /// Returns the highest degree of the moments.
    #[inline]
    pub fn degree(&self) -> usize {
        self.sizes.len() - 1
    }

    /// Returns a fragment without volume.
    fn none() -> Self {
        let (sizes, tail) = (vec![1.0], 0.0);
        Self {
            centre: Vec3::zeros(),
            radius: 0.0,
            share: 0.0,
            field_bound: 0.0,
            moments: vec![1.0],
            sizes,
            tail,
            triangles: Vec::new(),
            halves: OnceLock::new(),
        }
    }
}

/// Returns the degree of the moments of a fragment, where the polyhedron has moments up to `highest`.
///
/// The force between two fragments of equal size near each other scales as the share of either to the power of
/// 4/3, so that moments of a small fragment need fewer digits, of which each takes 2.4 degrees.
fn degree_of(share: f64, highest: usize) -> usize {
    const LEAST: usize = 8;
    const MORE: f64 = 8.0;
    let fewer = -2.4 * 4.0 / 3.0 * share.log10() - MORE;
    highest - (fewer.max(0.0) as usize).min(highest.saturating_sub(LEAST))
}

/// Cuts a closed surface by the plane through a point across its longest extent into two closed surfaces.
fn split(triangles: &[Triangle], through: &Vec3) -> [Vec<Triangle>; 2] {
    let extent = BoundingBox::around(triangles.as_flattened());
    let axis = (extent.high - extent.low).imax();
    let height = |v: &Vec3| v[axis] - through[axis];
    // Both triangles at an edge get the same point in the plane, to the last bit.
    let crossing = |u: &Vec3, v: &Vec3| {
        let (low, high) = if height(u) < 0.0 { (u, v) } else { (v, u) };
        let mut point = low + (high - low) * (height(low) / (height(low) - height(high)));
        point[axis] = through[axis];
        point
    };
    let mut sides: [Vec<Triangle>; 2] = Default::default();
    let mut corner = None;
    for triangle in triangles {
        let below = triangle.map(|v| height(&v) < 0.0);
        let apex = match below.iter().filter(|below| **below).count() {
            0 | 3 => {
                sides[usize::from(!below[0])].push(*triangle);
                continue;
            }
            count => below.iter().position(|is_below| *is_below == (count == 1)).unwrap_or(0),
        };
        let [a, b, c] = [0, 1, 2].map(|k| triangle[(apex + k) % 3]);
        let (p, q) = (crossing(&a, &b), crossing(&a, &c));
        let (apex_side, base_side) = if below[apex] { (0, 1) } else { (1, 0) };
        sides[apex_side].push([a, p, q]);
        sides[base_side].extend([[p, b, c], [p, c, q]]);
        let corner = *corner.get_or_insert(p);
        if corner != p && corner != q && p != q {
            sides[apex_side].push([corner, q, p]);
            sides[base_side].push([corner, p, q]);
        }
    }
    sides
}
