//! Convex shapes that are known by the areas and normals of their facets.

use crate::error::{Error, Result};
use crate::math::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::Arc;

/// The facets of a convex shape: unit normals and areas, from which its light follows without its vertices.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "FacetTable", into = "FacetTable")]
pub struct Facets {
    normals: Arc<[Vec3]>,
    areas: Arc<[f64]>,
}

/// The rows of normals, with the areas.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FacetTable {
    normals: Vec<[f64; 3]>,
    areas: Vec<f64>,
}

impl Facets {
    /// Takes unit normals and areas of the same number of facets.
    ///
    /// # Errors
    /// [`Error::InvalidInput`] for other numbers of areas, for normals that are not of length one, and for areas
    /// that are not finite numbers, zero or above, with a sum above zero.
    pub fn new(normals: &[Vec3], areas: &[f64]) -> Result<Self> {
        if normals.len() != areas.len() {
            let expected = format!("{}, one for each normal", normals.len());
            return Err(Error::invalid("number of areas", areas.len(), expected));
        }
        if let Some(index) = normals.iter().position(|n| !(1.0 - 1e-9..=1.0 + 1e-9).contains(&n.norm())) {
            return Err(Error::invalid(format!("length of normal {index}"), normals[index].norm(), "one"));
        }
        if let Some(index) = areas.iter().position(|area| !(*area >= 0.0 && area.is_finite())) {
            let expected = "a finite number, zero or above";
            return Err(Error::invalid(format!("area of facet {index}"), areas[index], expected));
        }
        let surface = areas.iter().sum::<f64>();
        if !(surface > 0.0 && surface.is_finite()) {
            return Err(Error::invalid("sum of the areas of facets", surface, "a finite number above zero"));
        }
        Ok(Self { normals: normals.into(), areas: areas.into() })
    }

    /// Returns the unit normals.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Returns the areas.
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// Returns the radius of the sphere with the same surface.
    pub fn radius(&self) -> f64 {
        (self.areas.iter().sum::<f64>() / (4.0 * PI)).sqrt()
    }
}

impl TryFrom<FacetTable> for Facets {
    type Error = Error;

    fn try_from(table: FacetTable) -> Result<Self> {
        let normals: Vec<_> = table.normals.into_iter().map(Vec3::from).collect();
        Self::new(&normals, &table.areas)
    }
}

impl From<Facets> for FacetTable {
    fn from(facets: Facets) -> Self {
        Self {
            normals: facets.normals.iter().map(|&normal| normal.into()).collect(),
            areas: facets.areas.to_vec(),
        }
    }
}
