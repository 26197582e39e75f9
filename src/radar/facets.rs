//! The echo of facets in bins of frequency and of delay.
//!
//! On a facet the cosine of incidence is constant, and delay and frequency are linear functions of the position. What
//! others do not hide of a facet are convex polygons: each is cut at the edges of the bins of delay, and the area of a
//! triangle below a frequency is a quadratic function of it on either side of the middle corner.

use super::ellipsoid::Linear;
use super::law::Law;
use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::math::ascending;
use crate::photometry::{Corner, FacetedPart, Region};

/// The number of facets between two interrupt checks.
const GROUP: usize = 512;
/// Units of work of a facet of which a part may be hidden.
const WORK: u64 = 20;

/// A corner of a polygon on a facet: its coordinates in shares of the first two sides, its frequency and its delay.
#[derive(Debug, Clone, Copy)]
struct Vertex {
    at: [f64; 2],
    frequency: f64,
    delay: f64,
}

/// The facets of a part of a body as the radar sees them, and the edges of bins.
pub struct Facets<'a> {
    pub part: &'a FacetedPart<'a>,
    pub law: &'a Law,
    /// The frequency and the delay in the part's own frame, from its origin.
    pub frequency: Linear,
    pub delay: Linear,
    pub time: f64,
}

impl Facets<'_> {
    /// Adds the cross section in each bin to `power`: the bins of frequency, or for each bin of delay those of
    /// frequency. Without edges of delay all delays count.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::error::Error::Interrupted).
    pub fn add(
        &self,
        frequencies: &[f64],
        delays: &[f64],
        power: &mut [f64],
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        let [e, s] = &self.part.lights;
        let bisector = (e + s).normalize();
        let (mut region, mut polygon, mut below) = (Region::default(), Vec::new(), Vec::new());
        for (index, facet) in self.part.mesh.facets.iter().enumerate() {
            if index % GROUP == GROUP - 1 {
                interrupt.charge(GROUP as u64, self.time)?;
            }
            let [mu, mu0] = [e, s].map(|direction| facet.normal.dot(direction));
            let cosine = facet.normal.dot(&bisector);
            if mu <= 0.0 || mu0 <= 0.0 || cosine <= self.law.least_cosine {
                continue;
            }
            let strength = self.law.cross_section(cosine) * facet.area;
            if !self.part.clip(facet, Some((index, [mu, mu0])), &mut region) {
                region.reset();
            }
            interrupt.charge(WORK, self.time)?;
            let [a, b, c] = facet.corners;
            let on_facet = |linear: &Linear| {
                let gradient = &linear.gradient;
                [linear.at_centre + gradient.dot(&a), gradient.dot(&(b - a)), gradient.dot(&(c - a))]
            };
            let [frequency, delay] = [on_facet(&self.frequency), on_facet(&self.delay)];
            let value =
                |[start, first, second]: [f64; 3], at: [f64; 2]| start + first * at[0] + second * at[1];
            for piece in region.pieces() {
                polygon.clear();
                polygon.extend(piece.iter().map(|Corner { at, .. }| Vertex {
                    at: *at,
                    frequency: value(frequency, *at),
                    delay: value(delay, *at),
                }));
                // A facet may cover many bins.
                interrupt.charge((frequencies.len() + delays.len()) as u64 / 8, self.time)?;
                if delays.is_empty() {
                    add_polygon(&polygon, strength, frequencies, power);
                } else {
                    add_strips(&mut polygon, &mut below, strength, frequencies, delays, power);
                }
            }
        }
        Ok(())
    }
}

/// Cuts a convex polygon at the edges of delay and adds the parts to their bins.
fn add_strips(
    polygon: &mut Vec<Vertex>,
    below: &mut Vec<Vertex>,
    strength: f64,
    frequencies: &[f64],
    delays: &[f64],
    power: &mut [f64],
) {
    let bins = frequencies.len() - 1;
    let nearest = polygon.iter().map(|vertex| vertex.delay).fold(f64::INFINITY, f64::min);
    let first = delays.partition_point(|delay| *delay <= nearest);
    for (k, limit) in delays.iter().enumerate().skip(first) {
        split(polygon, below, *limit);
        if k > 0 && !below.is_empty() {
            add_polygon(below, strength, frequencies, &mut power[(k - 1) * bins..k * bins]);
        }
        if polygon.is_empty() {
            return;
        }
    }
}

/// Moves the part of a convex polygon with a delay below a limit to `below`.
fn split(polygon: &mut Vec<Vertex>, below: &mut Vec<Vertex>, limit: f64) {
    below.clear();
    let mut above = Vec::with_capacity(polygon.len() + 1);
    for (k, vertex) in polygon.iter().enumerate() {
        let next = &polygon[(k + 1) % polygon.len()];
        let [from, to] = [vertex.delay - limit, next.delay - limit];
        if from < 0.0 {
            below.push(*vertex)
        } else {
            above.push(*vertex)
        }
        if (from < 0.0) != (to < 0.0) {
            let share = from / (from - to);
            let between = |one: f64, other: f64| one + share * (other - one);
            let at = [0, 1].map(|i| between(vertex.at[i], next.at[i]));
            let crossing = Vertex { at, frequency: between(vertex.frequency, next.frequency), delay: limit };
            below.push(crossing);
            above.push(crossing);
        }
    }
    *polygon = if above.len() > 2 { above } else { Vec::new() };
}

/// Adds the echo of a convex polygon to bins of frequency; `strength` is that of the whole facet.
fn add_polygon(polygon: &[Vertex], strength: f64, frequencies: &[f64], power: &mut [f64]) {
    for k in 2..polygon.len() {
        let [a, b, c] = [0, k - 1, k].map(|corner| polygon[corner]);
        let [u, v] = [b, c].map(|corner| [corner.at[0] - a.at[0], corner.at[1] - a.at[1]]);
        let share = u[0] * v[1] - u[1] * v[0];
        add_triangle([a, b, c].map(|corner| corner.frequency), strength * share, frequencies, power);
    }
}

/// Adds the echo of a triangle, given the frequencies of its corners, to bins.
fn add_triangle(corners: [f64; 3], strength: f64, frequencies: &[f64], power: &mut [f64]) {
    let [low, middle, high] = ascending(corners).map(|k| corners[k]);
    let share_below = |frequency: f64| {
        if frequency <= low {
            0.0
        } else if frequency < middle {
            (frequency - low) * (frequency - low) / ((middle - low) * (high - low))
        } else if frequency < high {
            1.0 - (high - frequency) * (high - frequency) / ((high - middle) * (high - low))
        } else {
            1.0
        }
    };
    // A triangle of one frequency belongs to the bin that begins there.
    let first = frequencies.partition_point(|edge| *edge <= low);
    let mut lower = 0.0;
    for (k, edge) in frequencies.iter().enumerate().skip(first) {
        let upper = if *edge >= high { 1.0 } else { share_below(*edge) };
        if k > 0 {
            power[k - 1] += strength * (upper - lower);
        }
        if *edge >= high {
            break;
        }
        lower = upper;
    }
}
