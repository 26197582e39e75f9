//! The gravity of bodies at the points of a block, over lanes of points.
//!
//! Points that need the same form of an ellipsoid's field are grouped, and the result in a lane does not
//! depend on the other lanes.

use super::body_field::{Attractor, PartFieldKind, Pointwise, columns};
use super::ellipsoidal::{Ellipsoidal, Gravity, MOST_FORMS, rotate};
use crate::math::lanes::{BLOCK, Lanes, Total, dot, load_vector, minus, splat_vector};
use crate::math::{Mat3, Vec3};
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// Returns the number of result columns: four for Phi and g, or six for the gradient.
pub const fn width(gradient: bool) -> usize {
    if gradient { 6 } else { 4 }
}

/// Buffers that a thread reuses. The buffers that hold the points of a block consist of whole vector
/// registers.
pub struct Workspace {
    points: [Vec<f64>; 3],
    /// The results, one list for each number of a point.
    pub out: [Vec<f64>; 6],
    /// The points in the frame and the unit of a part, and the form of the field that each point needs.
    local: [Vec<f64>; 3],
    form_indices: Vec<f64>,
    /// The points grouped by form, where each group fills whole registers, and the results there.
    sorted: [Vec<f64>; 3],
    results: [Vec<f64>; 6],
    order: Vec<u16>,
}

impl Workspace {
    /// Allocates the buffers for this many points.
    pub fn new(points: usize) -> Self {
        let lanes = points.next_multiple_of(BLOCK);
        let sorted = lanes + MOST_FORMS.min(points) * BLOCK;
        let list = |_| vec![0.0; lanes];
        Self {
            points: [(); 3].map(list),
            out: [(); 6].map(list),
            local: [(); 3].map(list),
            form_indices: list(()),
            sorted: [(); 3].map(|()| vec![0.0; sorted]),
            results: [(); 6].map(|()| vec![0.0; sorted]),
            order: vec![0; sorted],
        }
    }
}

/// Computes the gravity of bodies at the points of a block into `workspace.out`. Returns whether all of it is
/// finite.
pub struct BlockGravity<'a, const GRADIENT: bool> {
    pub attractors: &'a [Attractor<'a>],
    pub points: &'a [[f64; 3]],
    pub workspace: &'a mut Workspace,
}

impl<const GRADIENT: bool> WithSimd for BlockGravity<'_, GRADIENT> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { attractors, points, workspace } = self;
        let count = points.len();
        let [x, y, z] = &mut workspace.points;
        for (((x, y), z), point) in x.iter_mut().zip(y).zip(z).zip(points) {
            (*x, *y, *z) = (point[0], point[1], point[2]);
        }
        // The remaining lanes repeat the last point.
        for column in &mut workspace.points {
            let last = column[count - 1];
            column[count..count.next_multiple_of(BLOCK)].fill(last);
        }
        let mut overwrite = true;
        for attractor in attractors {
            for part in &attractor.field.parts {
                let pose = part.pose_in_points_frame(attractor);
                match &part.kind {
                    PartFieldKind::Ellipsoidal(kind) => {
                        add_ellipsoidal::<S, GRADIENT>(simd, kind, &pose, count, overwrite, workspace);
                    }
                    PartFieldKind::Pointwise(kind) => {
                        add_pointwise::<GRADIENT>(kind, &pose, points, overwrite, workspace)
                    }
                }
                overwrite = false;
            }
        }
        // 0 * x is NaN exactly when x is not finite, so that the sum of these products is zero only if all
        // results are finite.
        let zero = Lanes::<S>::splat(simd, 0.0);
        let mut sum = zero;
        for column in &workspace.out[..width(GRADIENT)] {
            for block in Lanes::<S>::blocks(simd, &column[..count.next_multiple_of(BLOCK)]) {
                sum = block.mul_add(zero, sum);
            }
        }
        let mut total = Total::zero(simd);
        total.add(sum);
        total.value() == 0.0
    }
}

/// Adds the gravity of a part point by point; the lanes are used within each point. The first part of
/// the first body overwrites the columns.
fn add_pointwise<const GRADIENT: bool>(
    part: &Pointwise,
    (position, rotation): &(Vec3, Mat3),
    points: &[[f64; 3]],
    overwrite: bool,
    workspace: &mut Workspace,
) {
    for (k, point) in points.iter().enumerate() {
        let x = rotation * (Vec3::from(*point) - position);
        let mut f = part.at(&x);
        f.field = rotation.tr_mul(&f.field);
        f.gradient = rotation.tr_mul(&(f.gradient * rotation));
        let all = if GRADIENT && part.is_surface(&x) { [f64::NAN; 10] } else { columns(&f) };
        let output = if GRADIENT { &all[4..] } else { &all[..4] };
        for (column, value) in workspace.out.iter_mut().zip(output) {
            column[k] = if overwrite { *value } else { column[k] + value };
        }
    }
}

#[inline(always)]
fn add_ellipsoidal<S: Simd, const GRADIENT: bool>(
    simd: S,
    ellipsoidal: &Ellipsoidal,
    (position, rotation): &(Vec3, Mat3),
    count: usize,
    overwrite: bool,
    workspace: &mut Workspace,
) {
    let lanes = BLOCK / Lanes::<S>::PER_BLOCK;
    let centre = splat_vector(simd, position);
    let (mut nearest, mut farthest) = (Lanes::splat(simd, f64::INFINITY), Lanes::splat(simd, 0.0));
    for block in 0..count.div_ceil(lanes) {
        let x = load_vector(simd, &workspace.points, block);
        let from = ellipsoidal.in_unit(rotate(minus(x, centre), rotation));
        let form_index = ellipsoidal.form_index(dot(from, from));
        (nearest, farthest) = (nearest.min(form_index), farthest.max(form_index));
        form_index.store(&mut workspace.form_indices, block);
        for i in 0..3 {
            from[i].store(&mut workspace.local[i], block);
        }
    }
    let nearest = nearest.reduce_min();
    if nearest == farthest.reduce_max() {
        let blocks = 0..count.div_ceil(lanes);
        let Workspace { local, out, .. } = workspace;
        return evaluate::<S, GRADIENT>(
            simd,
            ellipsoidal,
            nearest as usize,
            rotation,
            local,
            blocks,
            overwrite,
            out,
        );
    }
    let runs = sort(&workspace.form_indices[..count], lanes, &mut workspace.order);
    for (sorted, local) in workspace.sorted.iter_mut().zip(&workspace.local) {
        let order = &workspace.order[..runs[MOST_FORMS - 1].end.next_multiple_of(lanes)];
        sorted.iter_mut().zip(order).for_each(|(to, from)| *to = local[*from as usize]);
    }
    for (form_index, Range { start, end }) in runs.into_iter().enumerate() {
        let blocks = start / lanes..end.div_ceil(lanes);
        evaluate::<S, GRADIENT>(
            simd,
            ellipsoidal,
            form_index,
            rotation,
            &workspace.sorted,
            blocks,
            true,
            &mut workspace.results,
        );
        for (column, results) in workspace.out.iter_mut().zip(&workspace.results).take(width(GRADIENT)) {
            for (index, result) in workspace.order[start..end].iter().zip(&results[start..end]) {
                let sum = &mut column[*index as usize];
                *sum = if overwrite { *result } else { *sum + result };
            }
        }
    }
}

/// Evaluates one form of the field at blocks of lanes, and overwrites the columns or adds to them.
#[expect(clippy::too_many_arguments)]
#[inline(always)]
fn evaluate<S: Simd, const GRADIENT: bool>(
    simd: S,
    ellipsoidal: &Ellipsoidal,
    form_index: usize,
    rotation: &Mat3,
    y: &[Vec<f64>; 3],
    blocks: Range<usize>,
    overwrite: bool,
    out: &mut [Vec<f64>; 6],
) {
    let Some(&(_, form)) = ellipsoidal.forms.get(form_index) else { return };
    let zero = Lanes::splat(simd, 0.0);
    for block in blocks {
        let Gravity { potential, field: [x, y, z], gradient } =
            ellipsoidal.evaluate(form, load_vector(simd, y, block)).rotate_back(rotation);
        let results = if GRADIENT { gradient } else { [potential, x, y, z, zero, zero] };
        for k in 0..width(GRADIENT) {
            let partial_sum = if overwrite { zero } else { Lanes::load(simd, &out[k], block) };
            (partial_sum + results[k]).store(&mut out[k], block);
        }
    }
}

/// Returns the range of each form's points after grouping, and writes the order that groups them. Each group
/// is filled up to whole registers with copies of its first point.
fn sort(form_indices: &[f64], lanes: usize, order: &mut [u16]) -> [Range<usize>; MOST_FORMS] {
    let mut runs = [const { 0..0_usize }; MOST_FORMS];
    form_indices.iter().for_each(|form_index| runs[*form_index as usize].end += 1);
    let mut start = 0;
    for run in &mut runs {
        let count = run.end;
        (run.start, run.end) = (start, start);
        start += count.next_multiple_of(lanes);
    }
    for (index, form_index) in form_indices.iter().enumerate() {
        let next = &mut runs[*form_index as usize].end;
        order[*next] = index as u16;
        *next += 1;
    }
    for run in runs.iter().filter(|run| !run.is_empty()) {
        let first = order[run.start];
        order[run.end..run.end.next_multiple_of(lanes)].fill(first);
    }
    runs
}
