//! Starts that can be integrated but are probably mistakes: the numbers in the warnings about them.

use super::state::State;
use super::system::System;
use crate::math::Vec3;

/// The ratio of speed to speed of escape from which a body counts as unbound. If a day is mistaken for an
/// hour it is 24.
pub const FAST: f64 = 10.0;

/// The ratio of a pair's distance from the barycentre to its separation from which the pair counts as far:
/// the rounding of coordinates then exceeds the default tolerances.
pub const FAR: f64 = 1e3;

/// A body whose speed exceeds its speed of escape so far that a bound orbit was probably not intended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unbound {
    /// The index of the body.
    pub body: usize,
    /// The speed of the body relative to the barycentre of the others.
    pub speed: f64,
    /// The speed of escape at the body's position.
    pub escape: f64,
}

/// Two bodies near each other that are far from the barycentre, relative to which the integrators take
/// positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarFromBarycentre {
    /// The indices of a body and of its nearest neighbour.
    pub pair: [usize; 2],
    /// The distance between the two bodies of the pair.
    pub separation: f64,
    /// The index of the heavy body near which the barycentre lies.
    pub heavy: usize,
    /// The distance of the heavy body from the first body of the pair.
    pub distance: f64,
    /// The size of the rounding of the pair's coordinates.
    pub rounding: f64,
    /// The least tolerance that can be met: the smallest power of ten above the rounding relative to the
    /// distance of the pair.
    pub tolerance: f64,
}

impl System {
    /// Returns the body of a start that is fastest relative to its speed of escape, if the ratio exceeds
    /// `FAST`.
    pub fn unbound(&self, state: &State) -> Option<Unbound> {
        let masses = self.masses();
        let candidate = |body: usize| {
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
        let ratio = |unbound: &Unbound| unbound.speed / unbound.escape;
        // Without attraction no body is bound, and the run itself refuses numbers that are too large.
        let candidates = (0..masses.len())
            .map(candidate)
            .filter(|unbound| unbound.escape > 0.0 && ratio(unbound).is_finite());
        let fastest =
            candidates.reduce(|best, next| if ratio(&next) > ratio(&best) { next } else { best })?;
        (ratio(&fastest) > FAST).then_some(fastest)
    }

    /// Returns the body of a start that is farthest from the barycentre relative to the distance of its
    /// nearest neighbour, if the ratio exceeds `FAR` and the coordinates are too coarse for the tolerance.
    /// Fixed steps have no tolerance.
    pub fn far_from_barycentre(&self, state: &State, tolerance: Option<f64>) -> Option<FarFromBarycentre> {
        let masses = self.masses();
        let neighbours = |body: usize| {
            let separation = move |other: usize| (state.position[other] - state.position[body]).norm();
            (0..state.bodies())
                .filter(move |other| *other != body)
                .map(move |other| (other, separation(other)))
        };
        let total: f64 = masses.iter().sum();
        let barycentre: Vec3 = masses.iter().zip(&state.position).map(|(m, r)| r * (m / total)).sum();
        let candidate = |body: usize| {
            let (neighbour, separation) = neighbours(body).min_by(|a, b| a.1.total_cmp(&b.1))?;
            Some((body, neighbour, separation, (state.position[body] - barycentre).norm()))
        };
        let candidates = (0..state.bodies())
            .filter_map(candidate)
            .filter(|(.., separation, far_distance)| (far_distance / separation).is_finite());
        let (body, neighbour, separation, far_distance) =
            candidates.reduce(|best, next| if next.3 / next.2 > best.3 / best.2 { next } else { best })?;
        let rounding = far_distance.next_up() - far_distance;
        let sufficient = 10.0_f64.powf((rounding / separation).log10().ceil());
        if far_distance < FAR * separation || tolerance.is_some_and(|tolerance| tolerance >= sufficient) {
            return None;
        }
        let far = neighbours(body).filter(|(_, distance)| *distance >= 0.5 * FAR * separation);
        let (heavy, distance) =
            far.reduce(|best, next| if masses[next.0] > masses[best.0] { next } else { best })?;
        Some(FarFromBarycentre {
            pair: [body, neighbour],
            separation,
            heavy,
            distance,
            rounding,
            tolerance: sufficient,
        })
    }
}
