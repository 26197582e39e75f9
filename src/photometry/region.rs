//! The part of a triangle that remains when convex polygons are subtracted from it, as convex pieces. Each side of
//! a piece has the number of the line on which it lies.

/// A line on which sides of a region lie: one of the triangle's own sides, 0 to 2, or another one.
pub type Line = u32;

/// A corner of a piece, in shares of the triangle's first two sides, with the line of the side that follows.
#[derive(Debug, Clone, Copy)]
pub struct Corner {
    pub at: [f64; 2],
    pub line: Line,
}

/// A point that is nearer to a line than this is on it, and an edge must be longer than this.
const LEAST_DISTANCE: f64 = 1e-14;
/// Pieces of less than twice this area do not count: rounding makes them between polygons that share a side.
const LEAST_AREA: f64 = 1e-14;

/// The part of a triangle that is still visible and illuminated, as convex pieces.
#[derive(Debug, Default)]
pub struct Region {
    /// The ends of the edges along which [`Region::cut`] cuts, with their lines.
    pub edges: Vec<[Corner; 2]>,
    corners: Vec<Corner>,
    /// The first corner of each piece and the one after its last.
    pieces: Vec<[usize; 2]>,
    /// Buffers: the pieces of the next region, and the remainder of one piece.
    next: (Vec<Corner>, Vec<[usize; 2]>),
    remainder: [Vec<Corner>; 2],
    distances: Vec<f64>,
}

fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn length(from: &Corner, to: &Corner) -> f64 {
    ((to.at[0] - from.at[0]).powi(2) + (to.at[1] - from.at[1]).powi(2)).sqrt()
}

/// Returns twice the area of a polygon, above zero if it is counterclockwise.
fn area(corners: &[Corner]) -> f64 {
    (2..corners.len()).map(|k| cross(corners[0].at, corners[k - 1].at, corners[k].at)).sum()
}

/// A side must be longer than this for its direction to separate polygons.
const LONG_SIDE: f64 = 1e-4;

/// A side of a polygon: a point, the unit vector to the left, and the line.
type Side = ([f64; 2], [f64; 2], Line);

/// Returns the distance of a point from the line of a side, above zero to the left of it.
#[inline]
fn signed_distance((from, inward, _): &Side, at: [f64; 2]) -> f64 {
    inward[0] * (at[0] - from[0]) + inward[1] * (at[1] - from[1])
}

/// Returns the side from one corner to another one.
fn side_from(from: &Corner, to: &Corner) -> Side {
    let scale = length(from, to).recip();
    (from.at, [(from.at[1] - to.at[1]) * scale, (to.at[0] - from.at[0]) * scale], from.line)
}

/// Returns whether all corners are to the right of one of a polygon's long sides, or on it.
fn is_separated(corners: &[Corner], polygon: &[Corner]) -> bool {
    sides(polygon).any(|(from, to)| {
        let size = (to.at[0] - from.at[0]).abs() + (to.at[1] - from.at[1]).abs();
        size > LONG_SIDE
            && corners.iter().all(|corner| cross(from.at, to.at, corner.at) <= LEAST_DISTANCE * size)
    })
}

/// Iterates over the sides of a polygon.
pub fn sides(corners: &[Corner]) -> impl Iterator<Item = (&Corner, &Corner)> {
    corners.iter().zip(corners.iter().cycle().skip(1))
}

impl Region {
    /// Sets the region to the whole triangle.
    pub fn reset(&mut self) {
        self.corners.clear();
        self.corners.extend(
            [([0.0, 0.0], 0), ([1.0, 0.0], 1), ([0.0, 1.0], 2)].map(|(at, line)| Corner { at, line }),
        );
        self.pieces.clear();
        self.pieces.push([0, 3]);
    }

    /// Iterates over the pieces that are left, counterclockwise.
    pub fn pieces(&self) -> impl Iterator<Item = &[Corner]> {
        self.pieces.iter().map(|&[from, to]| &self.corners[from..to])
    }

    /// Returns whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Removes all pieces.
    pub fn clear(&mut self) {
        self.pieces.clear();
    }

    /// Returns the share of the triangle that is left.
    pub fn share(&self) -> f64 {
        self.pieces().map(area).sum()
    }

    /// Returns the share of the triangle that is left, and the sums of it times its coordinates, which are shares
    /// of the triangle's first two sides.
    pub fn moments(&self) -> [f64; 3] {
        let mut all = [0.0; 3];
        for corners in self.pieces() {
            for pair in corners.windows(2).skip(1) {
                let triangle = [corners[0].at, pair[0].at, pair[1].at];
                let share = cross(triangle[0], triangle[1], triangle[2]);
                let [u, v] = [0, 1].map(|k| triangle.iter().map(|at| at[k]).sum::<f64>() / 3.0);
                all.iter_mut().zip([share, share * u, share * v]).for_each(|(sum, part)| *sum += part);
            }
        }
        all
    }

    /// Subtracts a polygon of three or four corners, which is convex but for rounding, of either orientation.
    pub fn subtract(&mut self, mut polygon: &mut [Corner]) {
        let size = area(polygon);
        if size.abs() <= LEAST_AREA {
            return;
        }
        if size < 0.0 {
            // The line of a side is stored with the corner before it.
            polygon.reverse();
            let first = polygon[0].line;
            let count = polygon.len();
            (1..count).for_each(|k| polygon[k - 1].line = polygon[k].line);
            polygon[count - 1].line = first;
        }
        if let Some(dent) = (0..4).filter(|_| polygon.len() == 4).find(|&k| {
            let [last, corner, next] = [3, 0, 1].map(|step| polygon[(k + step) % 4].at);
            cross(last, corner, next) <= 0.0
        }) {
            // The corner coincides with its neighbour, or is on the line of two others.
            polygon.rotate_left(dent);
            if length(&polygon[3], &polygon[0]) < length(&polygon[0], &polygon[1]) {
                polygon[3].line = polygon[0].line;
            }
            polygon = &mut polygon[1..];
        }
        let polygon = &*polygon;
        let mut lines: [Side; 4] = [([0.0; 2], [0.0; 2], 0); 4];
        for (side, (from, to)) in lines.iter_mut().zip(sides(polygon)) {
            *side = side_from(from, to);
        }
        let lines = &lines[..polygon.len()];
        let mut all = std::mem::take(&mut self.next);
        all.0.clear();
        all.1.clear();
        for index in 0..self.pieces.len() {
            let [from, to] = self.pieces[index];
            let piece = &self.corners[from..to];
            let beside = |side| piece.iter().all(|corner| signed_distance(side, corner.at) <= LEAST_DISTANCE);
            if lines.iter().any(beside) || is_separated(polygon, piece) {
                let start = all.0.len();
                all.0.extend_from_slice(piece);
                all.1.push([start, all.0.len()]);
                continue;
            }
            self.remainder[0].clear();
            self.remainder[0].extend_from_slice(piece);
            lines.iter().for_each(|side| self.split(side, &mut all));
        }
        std::mem::swap(&mut self.corners, &mut all.0);
        std::mem::swap(&mut self.pieces, &mut all.1);
        self.next = all;
    }

    /// Cuts the pieces along the edges that cross them, and keeps those whose centre is not hidden. A piece that no
    /// edge crosses must be wholly hidden or wholly visible.
    pub fn cut(&mut self, hidden: impl Fn([f64; 2]) -> bool) {
        let edges = std::mem::take(&mut self.edges);
        let mut all = std::mem::take(&mut self.next);
        for edge in edges.iter().filter(|[from, to]| length(from, to) > LEAST_DISTANCE) {
            let side = side_from(&edge[0], &edge[1]);
            all.0.clear();
            all.1.clear();
            for index in 0..self.pieces.len() {
                let [from, to] = self.pieces[index];
                let piece = &self.corners[from..to];
                self.remainder[0].clear();
                self.remainder[0].extend_from_slice(piece);
                let beside = piece.iter().all(|corner| signed_distance(&side, corner.at) <= LEAST_DISTANCE);
                if !beside && !is_separated(edge, piece) {
                    self.split(&side, &mut all);
                }
                if !self.remainder[0].is_empty() {
                    let start = all.0.len();
                    all.0.extend_from_slice(&self.remainder[0]);
                    all.1.push([start, all.0.len()]);
                }
            }
            std::mem::swap(&mut self.corners, &mut all.0);
            std::mem::swap(&mut self.pieces, &mut all.1);
        }
        (self.next, self.edges) = (all, edges);
        let corners = &self.corners;
        self.pieces.retain(|&[from, to]| {
            let share = ((to - from) as f64).recip();
            let centre =
                [0, 1].map(|k| corners[from..to].iter().map(|corner| corner.at[k]).sum::<f64>() * share);
            !hidden(centre)
        });
    }

    /// Moves the part of the remainder to the right of a side to other pieces, and keeps the part to the left of it.
    fn split(&mut self, side: &Side, all: &mut (Vec<Corner>, Vec<[usize; 2]>)) {
        let [remainder, inside] = &mut self.remainder;
        self.distances.clear();
        self.distances.extend(remainder.iter().map(|corner| {
            let distance = signed_distance(side, corner.at);
            if distance.abs() <= LEAST_DISTANCE { 0.0 } else { distance }
        }));
        if self.distances.iter().all(|d| *d >= 0.0) {
            return;
        }
        inside.clear();
        let start = all.0.len();
        for k in 0..remainder.len() {
            let next = if k + 1 == remainder.len() { 0 } else { k + 1 };
            let (corner, [d, next_distance]) = (remainder[k], [self.distances[k], self.distances[next]]);
            let on_side = Corner { line: side.2, ..corner };
            if d >= 0.0 {
                inside.push(if d == 0.0 && next_distance < 0.0 { on_side } else { corner });
            }
            if d <= 0.0 {
                all.0.push(if d == 0.0 && next_distance > 0.0 { on_side } else { corner });
            }
            if d * next_distance < 0.0 {
                let share = d / (d - next_distance);
                let at = [0, 1].map(|i| corner.at[i] + share * (remainder[next].at[i] - corner.at[i]));
                let (before, after) = (Corner { at, line: corner.line }, Corner { at, line: side.2 });
                let [left, right] = if d > 0.0 { [after, before] } else { [before, after] };
                inside.push(left);
                all.0.push(right);
            }
        }
        // Pieces without an area are dropped.
        if area(&all.0[start..]) > LEAST_AREA {
            all.1.push([start, all.0.len()]);
        } else {
            all.0.truncate(start);
        }
        if area(inside) <= LEAST_AREA {
            inside.clear();
        }
        std::mem::swap(remainder, inside);
    }
}
