//! Shapes and bodies.

use super::arrays::{array, vectors};
use super::listening::listening;
use super::polyhedra::PyPolyhedron;
use super::stokes::PyStokesCoefficients;
use crate::errors::Result;
use fullbody::error::Error;
use fullbody::mutual::harmonics;
use fullbody::shape::{Body, Facets, InputPart, Shape};
use numpy::{PyArrayDyn, PyReadonlyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;
/// A part in the working frame: shape, mass or density, position, attitude.
type NewPart<'py> = (PyShape<'py>, Option<f64>, Option<f64>, [f64; 3], [f64; 4]);
/// A part in the working frame: shape, mass, position, attitude.
type PartTuple<'py> = (PyShape<'py>, f64, [f64; 3], [f64; 4]);
/// A part in the body frame: shape, mass, position, rotation matrix.
type PlacedPart<'py> = (PyShape<'py>, f64, [f64; 3], [[f64; 3]; 3]);

/// A shape: a polyhedron, Stokes coefficients, semi-axes, or none for a point.
#[derive(FromPyObject, IntoPyObject)]
pub enum PyShape<'py> {
    Polyhedron(Bound<'py, PyPolyhedron>),
    Stokes(Bound<'py, PyStokesCoefficients>),
    Axes(Option<[f64; 3]>),
}

impl<'py> PyShape<'py> {
    fn new(py: Python<'py>, shape: &Shape) -> Result<Self> {
        Ok(match shape {
            Shape::Ellipsoid(e) => Self::Axes(Some(e.semi_axes())),
            Shape::Polyhedron(p) => Self::Polyhedron(Bound::new(py, PyPolyhedron::from(p.clone()))?),
            Shape::Stokes(stokes) => {
                Self::Stokes(Bound::new(py, PyStokesCoefficients::from(stokes.clone()))?)
            }
            Shape::Point => Self::Axes(None),
            other => return Err(Error::invalid("shape", format!("{other:?}"), "one that Python has").into()),
        })
    }

    fn shape(self) -> Result<Shape, Error> {
        match self {
            Self::Polyhedron(p) => Ok(Shape::Polyhedron(p.get().inner.clone())),
            Self::Stokes(stokes) => Ok(Shape::Stokes(stokes.get().inner.clone())),
            Self::Axes(axes) => axes.map_or(Ok(Shape::Point), Shape::ellipsoid),
        }
    }
}

/// A body of one part or several. A point has the semi-axes `None`.
#[pyclass(frozen, name = "Body", module = "fullbody._core")]
pub struct PyBody {
    pub inner: Body,
}

#[pymethods]
impl PyBody {
    #[new]
    #[pyo3(signature = (name, shape, mass=None, density=None))]
    fn new(name: String, shape: PyShape<'_>, mass: Option<f64>, density: Option<f64>) -> Result<Self> {
        let shape = shape.shape()?;
        let inner = match (mass, density) {
            (Some(mass), None) => Body::with_mass(name, shape, mass),
            (None, Some(density)) => Body::with_density(name, shape, density),
            (Some(_), Some(_)) => {
                Err(Error::invalid(name, "given both a mass and a density", "one of the two"))
            }
            (None, None) => Err(Error::invalid(name, "given neither mass nor density", "one of the two")),
        }?;
        Ok(Self { inner })
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.inner.mass()
    }

    /// Makes a body that is known by the normals (F, 3) and areas (F,) of its facets.
    #[staticmethod]
    fn of_facets(
        name: String,
        normals: PyReadonlyArrayDyn<'_, f64>,
        areas: PyReadonlyArray1<'_, f64>,
        mass: f64,
    ) -> Result<Self> {
        let facets = Facets::new(&vectors("normals", &normals)?, &areas.as_array().to_vec())?;
        Ok(Self { inner: Body::of_facets(name, facets, mass)? })
    }

    /// Makes a body of several parts, each (shape, mass, density, position, attitude) with either a mass or a
    /// density.
    #[staticmethod]
    fn composite(name: String, parts: Vec<NewPart<'_>>) -> Result<Self> {
        let input =
            parts.into_iter().enumerate().map(|(index, (shape, mass, density, position, attitude))| {
                let what = format!("part {index} of {name}");
                let shape = shape.shape().map_err(|error| error.of(&what))?;
                let mass = match (mass, density) {
                    (Some(mass), None) => mass,
                    (None, Some(density)) => InputPart::mass_of(&what, &shape, density)?,
                    _ => {
                        return Err(Error::invalid(
                            what,
                            "not given just one of mass and density",
                            "one of the two",
                        ));
                    }
                };
                Ok(InputPart { shape, mass, position, attitude })
            });
        let input = input.collect::<Result<Vec<_>, _>>()?;
        Ok(Self { inner: Body::composite(name, input)? })
    }

    /// Returns the parts of a composite as they were given, in its working frame; empty for an ordinary body.
    #[getter]
    fn input_parts<'py>(&self, py: Python<'py>) -> Result<Vec<PartTuple<'py>>> {
        let tuple =
            |part: &InputPart| Ok((PyShape::new(py, &part.shape)?, part.mass, part.position, part.attitude));
        self.inner.input_parts().iter().map(tuple).collect()
    }

    /// Returns all parts in the body frame.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Result<Vec<PlacedPart<'py>>> {
        let parts = self.inner.parts().iter();
        parts
            .map(|part| {
                let rotation = part.rotation().transpose();
                Ok((PyShape::new(py, &part.shape)?, part.mass, part.position().into(), rotation.into()))
            })
            .collect()
    }

    /// Returns position and attitude of the working frame of a composite or a polyhedron in the body frame.
    #[getter]
    fn working_frame(&self) -> Option<([f64; 3], [f64; 4])> {
        self.inner.working_frame().map(|frame| (frame.position.into(), frame.attitude))
    }

    /// Returns the semi-axes of an ordinary body, or those of the homogeneous ellipsoid with a composite's
    /// mass and inertia.
    #[getter]
    fn semi_axes(&self) -> [f64; 3] {
        self.inner.semi_axes()
    }

    /// Returns the largest distance of the body's points from its centre of mass, or an upper bound of it.
    #[getter]
    fn circumradius(&self) -> f64 {
        self.inner.circumradius()
    }

    /// Returns the volume; for a composite, that of the ellipsoid with its semi-axes.
    #[getter]
    fn volume(&self) -> f64 {
        self.inner.volume()
    }

    /// Returns the Stokes coefficients up to a degree in the body frame, as `StokesCoefficients` takes them; the
    /// reference radius is the circumradius.
    fn harmonics(&self, py: Python<'_>, degree: usize) -> Result<PyStokesCoefficients> {
        let inner = listening(py, |interrupt| harmonics(&self.inner, degree, interrupt))?;
        Ok(inner.into())
    }

    /// Returns the areas (F,) of the facets of a body that is known by these.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyArrayDyn<f64>>>> {
        let facets = self.inner.facets();
        facets.map(|facets| array(py, facets.areas().to_vec(), &[facets.areas().len()])).transpose()
    }

    #[getter]
    fn inertia<'py>(&self, py: Python<'py>) -> Result<Array<'py>> {
        array(py, self.inner.inertia().as_slice().to_vec(), &[3])
    }
}
