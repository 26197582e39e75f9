//! Starts that can be integrated but are probably a mistake: the numbers behind the warnings about them.

use super::{State, System};
use crate::math::Vec3;

/// A body is taken as unbound from this many speeds of escape on. A day taken for an hour makes 24 of them.
pub const FAST: f64 = 10.0;

/// A pair is taken as far from the barycentre from this many of its own distances on, where the rounding of
/// coordinates exceeds the default tolerances.
pub const FAR: f64 = 1e3;

/// A body that is so much faster than the others' speed of escape that their attraction can hardly be meant
/// to hold it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unbound {
    /// The index of the body.
    pub body: usize,
    /// The speed of the body relative to the barycentre of the others.
    pub speed: f64,
    /// The speed of escape there.
    pub escape: f64,
}

/// Bodies near each other that are far from the barycentre, which the integrators count positions from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarFromBarycentre {
    /// The indices of a body and of its nearest neighbour.
    pub pair: [usize; 2],
    /// The distance between the two.
    pub apart: f64,
    /// The index of the body that draws the barycentre to itself.
    pub heavy: usize,
    /// The distance of that body from the first of the pair.
    pub distance: f64,
    /// The length at which the coordinates of the pair round.
    pub rounding: f64,
    /// The smallest power of ten that is above this rounding, relative to the distance of the pair:
    /// tolerances below it cannot be met.
    pub tolerance: f64,
}

impl System {
    /// Returns the body of a start that is fastest in units of its speed of escape, if it exceeds [`FAST`] of
    /// these.
    pub fn unbound(&self, state: &State) -> Option<Unbound> {
        let masses = self.masses();
        let of = |body: usize| {
            let (mut mass, mut momentum, mut potential) = (0.0, Vec3::zeros(), 0.0);
            for other in (0..masses.len()).filter(|other| *other != body) {
                mass += masses[other];
                momentum += state.velocity[other] * masses[other];
                potential += masses[other] / (state.position[other] - state.position[body]).norm();
            }
            let speed = (state.velocity[body] - momentum / mass).norm();
            let escape =
                (2.0 * self.gravitational_constant * (masses[body] + mass) * potential / mass).sqrt();
            Unbound { body, speed, escape }
        };
        let ratio = |found: &Unbound| found.speed / found.escape;
        // Without attraction no body is bound, and the run itself refuses numbers that are too large.
        let all = (0..masses.len()).map(of).filter(|found| found.escape > 0.0 && ratio(found).is_finite());
        let fastest = all.reduce(|most, next| if ratio(&next) > ratio(&most) { next } else { most })?;
        (ratio(&fastest) > FAST).then_some(fastest)
    }

    /// Returns the body of a start that is farthest from the barycentre in units of the distance of its
    /// nearest neighbour, if it exceeds [`FAR`] of these and the coordinates are too coarse for the
    /// tolerance. Fixed steps have no tolerance.
    pub fn far_from_barycentre(&self, state: &State, tolerance: Option<f64>) -> Option<FarFromBarycentre> {
        let masses = self.masses();
        let others = |body: usize| {
            let apart = move |other: usize| (state.position[other] - state.position[body]).norm();
            (0..state.bodies()).filter(move |other| *other != body).map(move |other| (other, apart(other)))
        };
        let total: f64 = masses.iter().sum();
        let barycentre: Vec3 = masses.iter().zip(&state.position).map(|(m, r)| r * (m / total)).sum();
        let of = |body: usize| {
            let (neighbour, apart) = others(body).min_by(|a, b| a.1.total_cmp(&b.1))?;
            Some((body, neighbour, apart, (state.position[body] - barycentre).norm()))
        };
        let all = (0..state.bodies()).filter_map(of).filter(|(.., apart, away)| (away / apart).is_finite());
        let (body, neighbour, apart, away) =
            all.reduce(|most, next| if next.3 / next.2 > most.3 / most.2 { next } else { most })?;
        let rounding = away.next_up() - away;
        let enough = 10.0_f64.powf((rounding / apart).log10().ceil());
        if away < FAR * apart || tolerance.is_some_and(|tolerance| tolerance >= enough) {
            return None;
        }
        let far = others(body).filter(|(_, distance)| *distance >= 0.5 * FAR * apart);
        let (heavy, distance) =
            far.reduce(|most, next| if masses[next.0] > masses[most.0] { next } else { most })?;
        Some(FarFromBarycentre {
            pair: [body, neighbour],
            apart,
            heavy,
            distance,
            rounding,
            tolerance: enough,
        })
    }
}
