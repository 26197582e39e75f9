//! The radar echo of bodies: their cross section in bins of Doppler frequency, and of delay and frequency.
//!
//! Takes bodies, their scattering laws, positions and attitudes, the directions to the receiver and to the
//! transmitter, and for each body how delay and frequency of the echo change over its surface, of which they are
//! linear functions. Gives the cross section in each bin, in squared length: the integral of the law over
//! the surface that both antennas see. Ellipsoids are exact to 1e-12 of the echo; other shapes are represented by
//! their facets, whose echoes are exact.

mod arc;
mod echo;
mod ellipsoid;
mod facets;
mod law;
mod sphere;

pub use echo::{Bins, BodyEcho, EchoView, Radar};
pub use law::Law;
