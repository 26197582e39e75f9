//! The brightness of bodies in sunlight, with mutual occultations and eclipses, and the recoil of sunlight.
//!
//! Takes bodies, their scattering laws, positions and attitudes, and the directions to the observer and to
//! the Sun. Gives the brightness of each body and its derivatives: the integral of mu mu0 / (mu + mu0) T dS
//! over the visible and illuminated surface, times the albedo, in squared length. Ellipsoids are exact to
//! round-off; other shapes are represented by their facets.

mod convex;
mod ellipsoid;
mod facet_gradient;
mod faceted;
mod facets;
mod kernel;
mod law;
mod limb;
mod lune;
mod mesh;
mod outline;
mod parallel;
mod photometer;
mod recoil;
mod region;
mod rule;
mod scene;
mod silhouette;
mod snapshot;
mod strips;

pub(crate) use facets::FacetedPart;
pub(crate) use outline::Light;
pub(crate) use parallel::in_parallel;
pub(crate) use region::{Corner, Region};
pub(crate) use rule::RULE;
pub(crate) use scene::Scene;
pub(crate) use snapshot::Snapshot;

pub use ellipsoid::{ByBody, Partials};
pub use law::{Hapke, Law};
pub use limb::{Limb, LimbDistance};
pub use photometer::Photometer;
pub use recoil::recoil;
pub use scene::Surface;
pub use snapshot::View;
