"""Hertha's chords: the frame of their file, and sizes from simulated chords."""

import astropy.units as u
import numpy as np
import pytest
from fullbody import observing

from reproduction.hertha import chords, model


def test_stations_of_the_file_move_with_the_rotation_of_the_earth():
    data = observing.StellarOccultation.read_koala(chords.CHORDS)
    times, _ = data.chords
    seconds = (times[:, 1] - times[:, 0]).to_value("s")
    positions = data.stations.vectors.to_value("km")
    east, north = ((positions[:, 1] - positions[:, 0]) / seconds[:, None]).T
    # The equator turns at 0.465 km/s; at midnight a station at latitude 32 degrees moves to the east by up to 0.39.
    assert (east > 0.15).all()
    assert (east < 0.39).all()
    assert (np.abs(north) < 0.2).all()
    # The shadow moves past it by 17.4 km/s in space, of which 5.4 are across the line of sight.
    assert len(data) == 36
    assert not (data.sign == 0.0).any()


def test_the_size_of_an_ellipsoid_follows_from_its_simulated_chords():
    real = observing.StellarOccultation.read_koala(chords.CHORDS, body="Hertha")
    system, state = chords.rotating(chords.ellipsoid(81.0, chords.RATIOS), 1.5)
    predicted = real.predict(system.integrate(state, 700.0, dense=True))
    exact = np.stack(
        [predicted[real.sign == sign][np.argsort(real.station[real.sign == sign])] for sign in (-1.0, 1.0)]
    )
    seconds = np.array([[(time - predicted[0]).to_value("s") for time in side] for side in exact]).T
    # Contacts that are continued beyond a graze are no chords.
    wide = seconds[:, 1] - seconds[:, 0] > 4.0
    times, positions = real.chords[0], real.stations.vectors.to_value("km")
    elapsed = (times - predicted[0]).to_value("s")
    share = ((seconds - elapsed[:, :1]) / (elapsed[:, 1:] - elapsed[:, :1]))[..., None]
    stations = positions[:, :1] + share * (positions[:, 1:] - positions[:, :1])
    middle = times[0, 0] + np.mean((times - times[0, 0]).to_value("s")) * u.s
    data = observing.StellarOccultation(
        star=-real.geometry.to_observer(middle).value,
        stations=stations[wide] * u.km,
        disappearance=predicted[0] + seconds[wide, 0] * u.s,
        reappearance=predicted[0] + seconds[wide, 1] * u.s,
        sigma=0.05 * u.s,
        geometry=real.geometry,
    )

    def setup(diameter):
        return chords.rotating(chords.ellipsoid(diameter, chords.RATIOS), 1.5)

    assert chords.size(setup, {"diameter": 74.0}, data).diameter == pytest.approx(81.0, rel=1e-5)


def test_a_polyhedron_rotates_about_the_pole_as_the_shape_of_the_inversion():
    # Areas of even degrees close without a change.
    coefficients = np.append(np.zeros(3), np.random.default_rng(3).normal(scale=0.1, size=5))
    pole, period = (272.0 * u.deg, 52.0 * u.deg), 8.4006 * u.h
    convex = model.setup(*pole, period, coefficients)
    solid = model.shape(coefficients).polyhedron()
    system, state = chords.rotating(solid, chords.rotation_angle(period), pole, period)
    elapsed = (chords.EPOCH - model.EPOCH).to_value("h")
    run = convex[0].integrate(convex[1], elapsed, output=[elapsed])
    directions = [0.6, 0.5, 0.3], [0.5, 0.6, 0.2]
    light = [
        observing.brightness(*pair, *directions)[0].to_value("km2") for pair in ((convex[0], run[-1]), (system, state))
    ]
    assert light[0] == pytest.approx(light[1], rel=0.02)
    rotated = chords.rotating(solid, chords.rotation_angle(period) + 0.5, pole, period)
    assert observing.brightness(*rotated, *directions)[0].to_value("km2") != pytest.approx(light[1], rel=0.02)
