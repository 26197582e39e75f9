//! The brightness of bodies in sunlight, with mutual occultations and eclipses.
//!
//! Takes bodies, their scattering laws, positions and attitudes, and the directions to the observer and to the Sun; gives the
//! brightness of each body, the integral over what is seen and lit of mu mu0 / (mu + mu0) T dS times the albedo, in squared
//! length, and its derivatives. Ellipsoids are exact to round-off; other shapes are taken by their facets.

mod ellipsoid;
mod facets;
mod kernel;
mod law;
mod lune;
mod outline;
mod rule;
mod snapshot;
mod strips;

pub use ellipsoid::{ByBody, Partials};
pub use law::{Hapke, Law};
pub use snapshot::{Photometer, Surface, View};
