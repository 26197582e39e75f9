"""Kalliope's gravity from the fitted shape, and chi2 of the light with an iron core."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import fullbody
import numpy as np
import numpy.typing as npt
from fullbody.fitting import Fit

from .freeform import FreeForm, principal
from .model import INTEGRATOR, A, G, Light

__all__ = ["QUANTITIES", "Core", "Figure", "cored", "cores", "figure_of_fit", "oblateness"]

Floats = npt.NDArray[np.float64]

#: Densities of iron and of a mantle of silicates in kg / km^3.
IRON, MANTLE = 7.87e12, 3.3e12
#: The quantities that follow from the shape, with their units.
QUANTITIES = {"C20": "", "diameter": "km", "density": "g/cm3", "a": "km", "b": "km", "c": "km"}


def oblateness(body: fullbody.Body, radius: float) -> float:
    """Return C20 of a body, not normalised, for a reference radius in km."""
    series = body.harmonics(2)
    reference = float(getattr(series.reference_radius, "value", series.reference_radius))
    return float(np.sqrt(5.0) * series.C[2, 0] * (reference / radius) ** 2)


def figure(form: FreeForm, values: dict[str, Any]) -> Floats:
    """Return the numbers of :data:`QUANTITIES` for values of the parameters of a fit.

    The semi-axes are half the extents along the principal axes, and the radius of C20 is that of the sphere of equal
    volume. The density is that of both bodies, since the total mass follows from the separation and the period.
    """
    shape = principal(form.shape(values["size"], values["coefficients"]))
    body = fullbody.Body(shape, density=1.0)
    radius = np.cbrt(0.75 * body.mass / np.pi)
    volumes = body.mass + 4.0 / 3.0 * np.pi * values["radius"] ** 3
    density = total_mass(values["period"]) / volumes / 1e12
    return np.array(
        [oblateness(body, radius), 2.0 * radius, density, *(0.5 * np.ptp(np.asarray(shape.vertices), axis=0))]
    )


def total_mass(period: float) -> float:
    """Return the mass in kg of two points on the circle of the published separation."""
    return float(4.0 * np.pi**2 * A**3 / period**2 / G)


@dataclass(frozen=True)
class Figure:
    """The figure of Kalliope that a fit found.

    Attributes
    ----------
    values, errors : dict of float
        The numbers of :data:`QUANTITIES`, and their standard deviations over draws from the normal distribution of the
        fit.
    by_prior : dict of float
        The standard deviations over draws of the coefficients from their prior, with the other values of the fit.
    """

    values: dict[str, float]
    errors: dict[str, float]
    by_prior: dict[str, float]


def figure_of_fit(form: FreeForm, fit: Fit, scale: float, draws: int) -> Figure:
    """Return the figure with its errors, those of the fit times ``scale``, from draws."""
    values = {name: fit.values[name] for name in fit.parameters.arguments}
    random = np.random.default_rng(2)
    drawn = [figure(form, fit.parameters.named(row)) for row in fit.draws_as_array(draws, random)]
    by_prior = [figure(form, {**values, "coefficients": random.normal(scale=form.prior)}) for _ in range(draws)]
    return Figure(
        dict(zip(QUANTITIES, figure(form, values).tolist(), strict=True)),
        dict(zip(QUANTITIES, (scale * np.std(drawn, axis=0, ddof=1)).tolist(), strict=True)),
        dict(zip(QUANTITIES, np.std(by_prior, axis=0, ddof=1).tolist(), strict=True)),
    )


@dataclass(frozen=True)
class Core:
    """Kalliope with an interior.

    Attributes
    ----------
    name : str
    radius : float
        The radius of the core in km; zero without one.
    mantle : float
        The density outside the core in g/cm3.
    c20 : float
        C20 for the radius of equal volume.
    chi2 : float
        Chi2 of the light, with the shape and the orbit of the fit of the free form.
    """

    name: str
    radius: float
    mantle: float
    c20: float
    chi2: float


def cored(shape: fullbody.Polyhedron, mass: float, radius: float) -> fullbody.Composite:
    """Return a shape with a sphere of iron about its centre of mass, and a mantle that gives it a mass in kg.

    The parts are in the body frame of the homogeneous shape, whose principal axes are also those of the composite.
    """
    solid = principal(shape)
    body = fullbody.Body(solid, density=1.0)
    volume = 4.0 / 3.0 * np.pi * radius**3
    mantle = (mass - IRON * volume) / (body.mass - volume)
    parts = [fullbody.Part(solid, density=mantle), fullbody.Part(fullbody.Sphere(radius), density=IRON - mantle)]
    return fullbody.Composite(parts)


def cores(form: FreeForm, light: Light, fit: Fit) -> list[Core]:
    """Return Kalliope without a core, and with one that leaves the mantle the density of silicates, if it is denser."""
    values = {name: fit.values[name] for name in fit.parameters.arguments}
    albedo = values.pop("albedo")
    system, state = form.setup(**values)
    shape, mass = form.shape(values["size"], values["coefficients"]), float(system["Kalliope"].mass.to_value("kg"))
    body = fullbody.Body(shape, density=1.0)
    mean = np.cbrt(0.75 * body.mass / np.pi)
    iron = 0.75 / np.pi * (mass - MANTLE * body.mass) / (IRON - MANTLE)
    interiors = {"homogeneous": 0.0}
    if iron > 0.0:
        interiors["a sphere of iron in silicates"] = float(np.cbrt(iron))
    data = light.data(order=0, albedo=albedo)
    result = []
    for name, core in interiors.items():
        kalliope = cored(shape, mass, core) if core else shape
        simulation = fullbody.Simulation(system.with_body("Kalliope", kalliope), state, integrator=INTEGRATOR)
        times = np.sort(data.emission(system).to_value("day"))
        simulation.integrate(times[0])
        run = simulation.integrate(times[-1], dense=True)
        volume = 4.0 / 3.0 * np.pi * core**3
        mantle = (mass - IRON * volume) / (body.mass - volume) / 1e12
        c20 = oblateness(fullbody.Body(kalliope) if core else body, mean)
        result.append(Core(name, core, mantle, c20, data.chi2(run)))
    return result
