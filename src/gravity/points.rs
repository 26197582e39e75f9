//! The gravity of bodies at many points, in blocks that are spread over the cores.

use super::block::{BlockGravity, Workspace, width};
use super::body_field::{Attractor, PartField, PartFieldKind};
use crate::error::{Error, Result, require_finite};
use crate::interrupt::{InterruptCheck, UNITS};
use crate::math::Vec3;
use pulp::Arch;
#[cfg(feature = "threads")]
use rayon::prelude::*;

/// The quantities to compute, with the arrays that receive them in C order.
#[derive(Debug)]
#[non_exhaustive]
pub enum GravityOutput<'a> {
    /// Potentials Phi (P,) and fields g (P, 3).
    Field(&'a mut [f64], &'a mut [f64]),
    /// Gradients dg/dx (P, 3, 3).
    Gradient(&'a mut [f64]),
}

impl Default for GravityOutput<'_> {
    fn default() -> Self {
        Self::Gradient(&mut [])
    }
}

impl GravityOutput<'_> {
    /// Splits the arrays after this many points.
    pub fn split_at(self, count: usize) -> (Self, Self) {
        match self {
            Self::Field(potential, field) => {
                let (potential, field) = (potential.split_at_mut(count), field.split_at_mut(3 * count));
                (Self::Field(potential.0, field.0), Self::Field(potential.1, field.1))
            }
            Self::Gradient(gradient) => {
                let (first, remaining) = gradient.split_at_mut(9 * count);
                (Self::Gradient(first), Self::Gradient(remaining))
            }
        }
    }
}

/// Points, in C order, at which the gravity of bodies is computed.
///
/// ```
/// use fullbody::gravity::{Attractor, BodyField, GravityOutput, Points};
/// use fullbody::interrupt::InterruptCheck;
/// use fullbody::math::{Mat3, Vec3};
/// use fullbody::pulp;
/// use fullbody::shape::{Body, Shape};
///
/// let ball = Body::with_mass("ball", Shape::ellipsoid([1.0, 1.0, 1.0])?, 3.0)?;
/// // The vector instructions of this machine.
/// let (arch, interrupt) = (pulp::Arch::new(), &mut InterruptCheck::never());
/// // G = 1.
/// let field = BodyField::new(&ball, 1.0, arch, interrupt)?;
/// let attractor = Attractor { field: &field, position: Vec3::zeros(), rotation: Mat3::identity() };
/// let points = Points { coordinates: &[2.0, 0.0, 0.0, 0.0, 0.0, -4.0], shape: &[2], first_index: 0 };
/// let (mut potential, mut g) = ([0.0; 2], [0.0; 6]);
/// points.gravity(&[attractor], GravityOutput::Field(&mut potential, &mut g), arch, interrupt)?;
/// assert!((potential[0] - 3.0 / 2.0).abs() < 1e-15 && (g[0] + 3.0 / 4.0).abs() < 1e-15);
/// assert!((potential[1] - 3.0 / 4.0).abs() < 1e-15 && (g[5] - 3.0 / 16.0).abs() < 1e-15);
/// # Ok::<(), fullbody::error::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Points<'a> {
    /// Coordinates (P, 3).
    pub coordinates: &'a [f64],
    /// The shape of the caller's array of points, for error messages.
    pub shape: &'a [usize],
    /// The number of the caller's points before these.
    pub first_index: usize,
}

/// The largest number of points in a block.
const CHUNK: usize = 512;

/// The largest work of a block, and of all blocks between two readings of the clock, in facets of a
/// polyhedron.
const BLOCK_WORK: usize = 100_000;
const GROUP_WORK: usize = 2_000_000;

/// Runs jobs on all cores and returns the first index that one of them returns.
#[cfg(feature = "threads")]
fn in_parallel<J: Send, W: Send>(
    jobs: &mut [J],
    workspace: impl Fn() -> W + Sync + Send,
    run: impl Fn(&mut W, &mut J) -> Option<usize> + Sync + Send,
) -> Option<usize> {
    jobs.par_iter_mut().map_init(workspace, run).flatten().min()
}

/// Runs jobs one after the other and returns the first index that one of them returns.
#[cfg(not(feature = "threads"))]
fn in_parallel<J, W>(
    jobs: &mut [J],
    workspace: impl Fn() -> W,
    run: impl Fn(&mut W, &mut J) -> Option<usize>,
) -> Option<usize> {
    let mut workspace = workspace();
    jobs.iter_mut().find_map(|job| run(&mut workspace, job))
}

impl Points<'_> {
    /// Computes the sum of the gravity of bodies.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] refuses arrays of lengths that do not belong together, and names the point at
    /// which gravity is not a finite number.
    pub fn gravity(
        &self,
        attractors: &[Attractor<'_>],
        output: GravityOutput<'_>,
        arch: Arch,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let (count, remainder) = (self.coordinates.len() / 3, self.coordinates.len() % 3);
        let (lengths, fits) = match &output {
            GravityOutput::Field(potential, field) => (
                format!("{} potentials and {} numbers of the field", potential.len(), field.len()),
                potential.len() == count && field.len() == 3 * count,
            ),
            GravityOutput::Gradient(gradient) => {
                (format!("{} numbers of the gradient", gradient.len()), gradient.len() == 9 * count)
            }
        };
        if !fits || remainder != 0 {
            let expected = "three coordinates, one potential, three and nine numbers for each point";
            let lengths = format!("{lengths} for {} coordinates", self.coordinates.len());
            return Err(Error::invalid("lengths of the arrays of gravity at points", lengths, expected));
        }
        let parts = attractors.iter().flat_map(|attractor| &attractor.field.parts);
        let work: usize = parts.map(PartField::work).sum();
        let length = (BLOCK_WORK / work.max(1)).clamp(1, CHUNK);
        let mut jobs = jobs(self.coordinates, output, length);
        let group = (GROUP_WORK / (work * length).max(1)).max(1);
        for jobs in jobs.chunks_mut(group) {
            interrupt.charge(UNITS / 2, 0.0)?;
            let workspace = || Workspace::new(length.min(self.coordinates.len() / 3));
            // A small amount of work is finished before other threads have started.
            let invalid = if jobs.len() * length * work >= 2000 {
                in_parallel(jobs, workspace, |workspace, job| job.run(attractors, arch, workspace))
            } else {
                let mut workspace = workspace();
                jobs.iter_mut().find_map(|job| job.run(attractors, arch, &mut workspace))
            };
            if let Some(index) = invalid {
                return Err(self.invalid_point(attractors, index));
            }
        }
        Ok(())
    }

    /// Returns the error for a point at which the gravity is not finite.
    fn invalid_point(&self, attractors: &[Attractor<'_>], index: usize) -> Error {
        let x = Vec3::from_column_slice(&self.coordinates[3 * index..][..3]);
        let what = self.label(index);
        if let Err(error) = require_finite(&what, x.as_slice()) {
            return error;
        }
        let value = format!("[{}, {}, {}]", x.x, x.y, x.z);
        for attractor in attractors {
            let name = &attractor.field.name;
            for part in &attractor.field.parts {
                let (position, rotation) = part.pose_in_points_frame(attractor);
                match &part.kind {
                    PartFieldKind::Ellipsoidal(point) if point.is_point() && x == position => {
                        let expected = format!("one away from the point mass of {name}");
                        return Error::invalid(what, value, expected);
                    }
                    PartFieldKind::Pointwise(field) if (x - position).norm() < field.least_distance() => {
                        let expected = format!(
                            "one at least {} from the centre of {name}, whose Stokes coefficients give the \
                             gravity outside this sphere alone",
                            field.least_distance()
                        );
                        return Error::invalid(what, value, expected);
                    }
                    PartFieldKind::Pointwise(field) if field.is_surface(&(rotation * (x - position))) => {
                        let expected = format!(
                            "one off the surface of {name}, where the gradient jumps and is infinite on edges"
                        );
                        return Error::invalid(what, value, expected);
                    }
                    _ => {}
                }
            }
        }
        let expected = "one where gravity is a finite number; choose units that keep the numbers in range";
        Error::invalid(what, value, expected)
    }

    /// Returns the index of a point as the caller counts it.
    fn label(&self, index: usize) -> String {
        let mut remainder = index + self.first_index;
        let mut indices: Vec<String> = Vec::new();
        for &length in self.shape.iter().rev() {
            indices.push((remainder % length.max(1)).to_string());
            remainder /= length.max(1);
        }
        indices.reverse();
        match indices.as_slice() {
            [] => "point".to_owned(),
            [index] => format!("point {index}"),
            _ => format!("point ({})", indices.join(", ")),
        }
    }
}

impl PartField {
    /// Returns the work at a point, in facets.
    fn work(&self) -> usize {
        match &self.kind {
            PartFieldKind::Ellipsoidal(_) => 4,
            PartFieldKind::Pointwise(field) => field.work(),
        }
    }
}

/// A block of points and the arrays for its results.
struct Job<'a> {
    start: usize,
    points: &'a [f64],
    output: GravityOutput<'a>,
}

fn jobs<'a>(coordinates: &'a [f64], output: GravityOutput<'a>, length: usize) -> Vec<Job<'a>> {
    let mut remainder = output;
    let blocks = coordinates.chunks(3 * length).enumerate();
    let job = |(block, points): (usize, &'a [f64])| {
        let (output, remaining) = std::mem::take(&mut remainder).split_at(points.len() / 3);
        remainder = remaining;
        Job { start: block * length, points, output }
    };
    blocks.map(job).collect()
}

impl Job<'_> {
    /// Computes the results. Returns the index of the first point whose result is not finite.
    fn run(&mut self, attractors: &[Attractor<'_>], arch: Arch, workspace: &mut Workspace) -> Option<usize> {
        let points = self.points.as_chunks::<3>().0;
        let (finite, width) = match &mut self.output {
            GravityOutput::Field(potential, field) => {
                let finite = arch.dispatch(BlockGravity::<false> { attractors, points, workspace });
                let [phi, x, y, z, ..] = &workspace.out;
                potential.copy_from_slice(&phi[..points.len()]);
                let g = field.as_chunks_mut::<3>().0.iter_mut().zip(x).zip(y).zip(z);
                g.for_each(|(((g, x), y), z)| *g = [*x, *y, *z]);
                (finite, width(false))
            }
            GravityOutput::Gradient(gradient) => {
                let finite = arch.dispatch(BlockGravity::<true> { attractors, points, workspace });
                let out = &workspace.out;
                for (k, matrix) in gradient.as_chunks_mut::<9>().0.iter_mut().enumerate() {
                    let [xx, xy, xz, yy, yz, zz] = [0, 1, 2, 3, 4, 5].map(|column| out[column][k]);
                    *matrix = [xx, xy, xz, xy, yy, yz, xz, yz, zz];
                }
                (finite, width(true))
            }
        };
        if finite {
            return None;
        }
        let invalid = |k: &usize| workspace.out[..width].iter().any(|column| !column[*k].is_finite());
        (0..points.len()).find(invalid).map(|index| self.start + index)
    }
}
