"""Bodies on straight paths before a radar, and their spectra and images in plain numbers."""

import warnings

import numpy as np
from fullbody import State, System, observing
from fullbody.errors import InconsistentInput

from support import body_list

#: The transmitted frequency in Hz, and the speed of light in km/s.
F, C_LIGHT = 2.38e9, 299792.458
FULL = {"transmit_frequency": F, "law": observing.Cosine(C=1.0, R=0.3)}


def at_rest(toward=(1.0, 0.0, 0.0), **options):
    """A distant radar at rest."""
    return observing.Geometry([0.0], to_observer=toward, light_time=False, **options)


def run_of(*shapes, position=None, velocity=None, attitude=None, spin=None, masses=None, until=1e-3):
    """A run from time zero of bodies without forces worth the name."""
    masses = [1.0] * len(shapes) if masses is None else masses
    bodies = body_list(**{name: pair for name, pair in zip("ABC", zip(shapes, masses, strict=True), strict=False)})
    system = System(bodies, G=1e-30, units=("km", "s", "kg"), gravity="point")
    positions = np.zeros((len(shapes), 3)) if position is None else position
    state = State(positions, np.zeros_like(positions) if velocity is None else velocity, attitude=attitude, spin=spin)
    with warnings.catch_warnings():
        # The bodies move faster than their speed of escape, so that they go on straight.
        warnings.simplefilter("ignore", InconsistentInput)
        return system.integrate(state, until, dense=True)


def spectrum(run, edges, geometry=None, **options):
    result = observing.radar_spectrum(run, [0.0], at_rest() if geometry is None else geometry, edges, **FULL | options)
    return result.power.to_value("km2")[0]


def image(run, delays, edges, geometry=None, **options):
    geometry = at_rest() if geometry is None else geometry
    return observing.delay_doppler(run, [0.0], geometry, delays, edges, **FULL | options).power.to_value("km2")[0]
