//! A tree of bounding boxes around faces, which finds the faces near a point or a box.

use crate::math::Vec3;
use std::ops::ControlFlow;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingBox {
    /// The least coordinates.
    pub low: Vec3,
    /// The largest coordinates.
    pub high: Vec3,
}

impl BoundingBox {
    /// Returns the smallest box that holds these points.
    pub fn around(points: &[Vec3]) -> Self {
        let (low, high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        points.iter().fold(Self { low, high }, |b, p| Self { low: b.low.inf(p), high: b.high.sup(p) })
    }

    fn with(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }

    /// Returns the distance from a point; zero within.
    pub fn distance(&self, point: &Vec3) -> f64 {
        (self.low - point).sup(&(point - self.high)).sup(&Vec3::zeros()).norm()
    }

    /// Returns the distance of two boxes; zero where they meet.
    pub fn apart(&self, other: &Self) -> f64 {
        (self.low - other.high).sup(&(other.low - self.high)).sup(&Vec3::zeros()).norm()
    }

    /// Returns the box multiplied by a factor above zero.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { low: self.low * factor, high: self.high * factor }
    }

    /// Returns the centre, and the distance of the corners from it.
    pub fn sphere(&self) -> (Vec3, f64) {
        (0.5 * (self.low + self.high), 0.5 * (self.high - self.low).norm())
    }
}

/// A tree of bounding boxes.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    nodes: Vec<Node>,
    /// The items; the items of a leaf are adjacent.
    items: Vec<u32>,
}

#[derive(Debug, Clone, PartialEq)]
struct Node {
    block: BoundingBox,
    /// The items of a leaf, or the index of the second branch; the first branch is the next node.
    content: Content,
}

#[derive(Debug, Clone, PartialEq)]
enum Content {
    Leaf(std::ops::Range<usize>),
    Branches(usize),
}

/// The largest number of items in a leaf.
const LEAF: usize = 4;

impl Tree {
    /// Builds the tree over items from their boxes.
    pub fn new(blocks: &[BoundingBox]) -> Self {
        let mut tree = Self { nodes: Vec::new(), items: (0..blocks.len() as u32).collect() };
        let mut items = std::mem::take(&mut tree.items);
        tree.grow(blocks, &mut items, 0);
        tree.items = items;
        tree
    }

    fn grow(&mut self, blocks: &[BoundingBox], items: &mut [u32], start: usize) -> usize {
        let block = items
            .iter()
            .map(|&i| blocks[i as usize])
            .reduce(|a, b| a.with(&b))
            .unwrap_or(BoundingBox::around(&[]));
        let index = self.nodes.len();
        self.nodes.push(Node { block, content: Content::Leaf(start..start + items.len()) });
        if items.len() > LEAF {
            let axis = (block.high - block.low).imax();
            let middle = items.len() / 2;
            let centre = |i: &u32| blocks[*i as usize].low[axis] + blocks[*i as usize].high[axis];
            items.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)).then(a.cmp(b)));
            let (left, right) = items.split_at_mut(middle);
            self.grow(blocks, left, start);
            let second = self.grow(blocks, right, start + middle);
            self.nodes[index].content = Content::Branches(second);
        }
        index
    }

    /// Returns the box around all items.
    pub fn bounding_box(&self) -> BoundingBox {
        self.nodes[0].block
    }

    /// Calls `visit` with every item whose box meets the given box.
    pub fn meeting(&self, block: &BoundingBox, mut visit: impl FnMut(u32)) {
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            if node.block.meets(block) {
                match &node.content {
                    Content::Leaf(range) => self.items[range.clone()].iter().for_each(|&i| visit(i)),
                    Content::Branches(second) => stack.extend([*second, index + 1]),
                }
            }
        }
    }

    /// Calls `visit` with the items of all boxes that `enter` lets pass, until it breaks.
    pub fn search(
        &self,
        enter: impl Fn(&BoundingBox) -> bool,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        // Branches halve the items, so that the tree is not deeper than the bits of their number.
        let (mut stack, mut ahead) = ([0; 1 + u32::BITS as usize], 1);
        while ahead > 0 {
            ahead -= 1;
            let index = stack[ahead];
            let node = &self.nodes[index];
            if enter(&node.block) {
                match &node.content {
                    Content::Leaf(range) => self.items[range.clone()].iter().try_for_each(|&i| visit(i))?,
                    Content::Branches(second) => {
                        (stack[ahead], stack[ahead + 1]) = (*second, index + 1);
                        ahead += 2;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Returns the least value over the items that is below `limit`, or `limit`. `bound` returns a lower bound for all
    /// items in a box; `value` takes an item and the least value so far.
    ///
    /// # Errors
    /// Returns the errors of `value`.
    pub fn least<E>(
        &self,
        limit: f64,
        bound: impl Fn(&BoundingBox) -> f64,
        mut value: impl FnMut(u32, f64) -> Result<f64, E>,
    ) -> Result<f64, E> {
        let mut best = limit;
        let mut stack = vec![(bound(&self.nodes[0].block), 0)];
        while let Some((least, index)) = stack.pop() {
            if least >= best {
                continue;
            }
            match &self.nodes[index].content {
                Content::Leaf(range) => {
                    for &item in &self.items[range.clone()] {
                        best = best.min(value(item, best)?);
                    }
                }
                Content::Branches(second) => {
                    let mut next =
                        [index + 1, *second].map(|branch| (bound(&self.nodes[branch].block), branch));
                    // The nearer branch is searched first.
                    if next[0].0 < next[1].0 {
                        next.swap(0, 1);
                    }
                    stack.extend(next);
                }
            }
        }
        Ok(best)
    }
}
