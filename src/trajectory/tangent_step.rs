//! Steps of the variational equations along the polynomials of the motion's last step.

use crate::dynamics::{Collocation, Dynamics, Variations};
use crate::error::{Error, Result};
use crate::integrate::Segment;
use crate::interrupt::InterruptCheck;

/// The shortest step of tangent vectors, as a fraction of the motion's step.
pub(super) const SHORTEST: f64 = 1e-6;

/// Numbers above this are outside of the range in which a step can be solved.
pub(super) const LARGEST: f64 = 1e280;

/// The pieces of a motion's last step, and what evaluates the equations along them.
pub(super) struct LastStep<'a, 'i> {
    pub equations: &'a mut Dynamics,
    pub pieces: &'a [Segment],
    pub interrupt: &'a mut InterruptCheck<'i>,
}

/// Loads the variational equations at the nodes of a step between two fractions of a piece of the motion. The
/// motion's vectors at the ends are left in `y`.
pub(super) fn load_nodes(
    collocation: &mut Collocation,
    variations: &mut Variations,
    equations: &mut Dynamics,
    (piece, [from, to]): (&Segment, [f64; 2]),
    [y, end]: [&mut [f64]; 2],
    interrupt: &mut InterruptCheck,
) -> Result<()> {
    for node in 0..collocation.gauss().nodes.len() {
        let fraction = from + collocation.gauss().nodes[node] * (to - from);
        piece.at(fraction, y);
        interrupt.charge(variations.work(equations), piece.time_at(from))?;
        variations.evaluate(equations, piece.time_at(fraction), y, interrupt)?;
        collocation.load(node, equations, variations, y);
    }
    piece.at(from, y);
    piece.at(to, end);
    collocation.load_ends(equations, variations, [y, end]);
    Ok(())
}

/// Makes the error for variational equations that are not solved even over a step of the shortest size.
pub(super) fn too_fast(time: f64, size: f64) -> Error {
    Error::NotConverged {
        what: format!("the variational equations at time {time}"),
        detail: format!("they change too fast even for a step of {size:e}"),
    }
}
