"""Radar spectra and delay-Doppler images as data: predictions, unknowns, derivatives, fits, tables, refusals."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import Ellipsoid, observing
from fullbody.errors import InconsistentInput
from support import body_list, refused, worst
from support.displacements import by_start

TIMES = np.array([2.0, 3.5, 5.0, 6.5]) * u.h
EDGES = np.linspace(-14.0, 14.0, 29) * u.Hz
DELAYS = np.linspace(-20.0, 20.0, 41) * u.us
RADAR = {"transmit_frequency": 2.38 * u.GHz, "law": observing.Cosine(1.0, 0.3)}


def binary(a=0.8, mass=0.03, rate=1.5):
    """A binary of two ellipsoids with a tilted primary."""
    bodies = body_list(A=(Ellipsoid(a, 0.7, 0.6), 2.0e12), B=(Ellipsoid(0.3, 0.25, 0.2), 2.0e12 * mass))
    system = fullbody.System(bodies, units=("km", "hour", "kg"), gravity="focal")
    share = mass / (1.0 + mass)
    speed = np.sqrt(system.G.value * 2e12 * (1 + mass) / 2.5)
    position, velocity = np.outer([-share, 1 - share], [2.5, 0, 0]), np.outer([-share, 1 - share], [0, speed, 0])
    spin = [[0.0, 0.3 * rate, 0.95 * rate], [0, 0, speed / 2.5]]
    return system, fullbody.State(position, velocity, spin=spin)


@pytest.fixture(scope="module")
def run():
    system, state = binary()
    return system.integrate(state, "8 h", dense=True)


@pytest.fixture(scope="module")
def geometry():
    """A flyby at 0.02 au with 10 km/s."""
    rows = np.linspace(-1.0, 10.0, 12)
    positions = np.stack([3e6 + 0 * rows, 3.6e4 * (rows - 4.0), 1e6 + 1e4 * rows], axis=1)
    return observing.Geometry(rows * u.h, to_observer=positions * u.km)


@pytest.fixture(scope="module")
def spectra(run, geometry):
    return observing.radar_spectrum(run, TIMES, geometry, EDGES, **RADAR).power


@pytest.fixture(scope="module")
def images(run, geometry):
    return observing.delay_doppler(run, TIMES, geometry, DELAYS, EDGES, **RADAR).power


def spectrum_data(power, sigma, geometry, **options):
    options = {"frequencies": EDGES, "geometry": geometry, **RADAR, **options}
    return observing.RadarSpectrum(TIMES, power, sigma, **options)


def image_data(power, sigma, geometry, **options):
    options = {"delays": DELAYS, "frequencies": EDGES, "geometry": geometry, **RADAR, **options}
    return observing.DelayDoppler(TIMES, power, sigma, **options)


def test_data_predict_what_the_functions_compute(run, geometry, spectra, images):
    for data, power in ((spectrum_data(spectra.to("m2"), 1e-3 * u.km**2, geometry), spectra),
                        (image_data(images.to("m2"), 1e-3 * u.km**2, geometry), images)):  # fmt: skip
        result = data.predict(run)
        assert result.unit == u.m**2
        assert worst(result.to_value("km2"), power.to_value("km2")) < 1e-12
        assert data.chi2(run) < 1e-12
    off = spectrum_data(spectra + 2e-3 * u.km**2, 1e-3 * u.km**2, geometry)
    assert off.chi2(run) == pytest.approx(4.0 * spectra.size, rel=1e-9)
    np.testing.assert_allclose(off.residuals(run).to_value("km2"), 2e-3, atol=1e-12)


def test_a_free_gain_is_that_of_the_data(run, geometry, spectra, images):
    noise = np.random.default_rng(1).normal(size=spectra.shape)
    data = spectrum_data(30.0 * spectra.value + noise, 1.0, geometry, gain="free")
    gain = data.linear_values(run)["gain"]
    expected = np.sum(spectra.value * (30.0 * spectra.value + noise)) / np.sum(spectra.value**2)
    assert gain == pytest.approx(expected, rel=1e-11)
    assert data.chi2(run) == pytest.approx(np.sum((30.0 * spectra.value + noise - gain * spectra.value) ** 2), rel=1e-9)
    both = image_data(5.0 * images.value, 1.0, geometry, gain="free")
    assert both.linear_values(run)["gain"] == pytest.approx(5.0, rel=1e-12)
    fixed = spectrum_data(30.0 * spectra.value, 1.0, geometry, gain=30.0)
    assert fixed.chi2(run) < 1e-12


def test_offsets_move_an_echo_by_whole_bins(run, geometry, spectra, images):
    shifted = np.roll(spectra.value, 2, axis=1) * u.km**2
    data = spectrum_data(shifted, 1e-3 * u.km**2, geometry, frequency_offset=2.0 * u.Hz)
    assert data.chi2(run) < 1e-10
    # The delay grows by 2 us in all, which is three and then five bins, and the frequency falls by F times the rate.
    rate = 1.0 * u.us / (1.5 * u.h)
    shifted_images = np.stack([np.roll(image, k, axis=0) for image, k in zip(images.value, (3, 4, 5, 6), strict=True)])
    options = {"delay_correction": (4.5 * u.us, rate), "frequency_offset": (rate * 2.38 * u.GHz).to("Hz")}
    assert (
        worst(
            image_data(shifted_images * u.km**2, 1.0 * u.km**2, geometry, **options).predict(run).value, shifted_images
        )
        < 1e-9
    )


def test_looks_add_the_noise_of_the_echo_itself(geometry):
    data = spectrum_data(np.full((4, 28), 3.0), 1.0, geometry, gain="free", looks=9, polarization="OC")
    np.testing.assert_allclose(data.sigma, 1.0 + 3.0 / 3.0)
    np.testing.assert_allclose(spectrum_data(np.full((4, 28), -3.0), 2.0, geometry, looks=9).sigma, 2.0)
    assert data.polarization == "OC"


@pytest.mark.parametrize("kind", ["spectrum", "image"])
def test_derivatives_are_differences_of_runs(run, geometry, spectra, images, kind):
    # One row, whose bins are sums over ten of those of the others, to keep the test short.
    wide = {"frequencies": np.linspace(-15, 15, 7) * u.Hz, "geometry": geometry, **RADAR}
    if kind == "spectrum":
        data = observing.RadarSpectrum(TIMES[:1], np.ones((1, 6)), 0.1, exposure=300 * u.s, **wide)
    else:
        delays = np.linspace(-20, 20, 6) * u.us
        data = observing.DelayDoppler(TIMES[:1], np.ones((1, 5, 6)), 0.1, delays=delays, gain="free", **wide)
    state = run(data.emission(run.system)[0])
    steps = {"position": 1e-4, "velocity": 1e-4, "rotation": 1e-4, "spin": 1e-4}
    exact, differences = by_start(data, run.system, state, steps)
    assert worst(exact, differences) < 3e-6
    names = ["mass of B", "semi-axis a of A"]
    fixed = run.system.integrate(state, state.time * (1 + 1e-9), derivatives=names, output="ends", dense=False)
    # A larger body has a larger echo; the mass of the other one moves the barycentre.
    by = data.derivatives(fixed).by_parameter
    system = run.system
    for name, step in zip(names, (1e8, 1e-5), strict=True):
        ends = [
            data.pulls(
                system.changed(name, sign * step).integrate(state, state.time * (1 + 1e-9), output="ends", dense=False)
            )
            for sign in (1, -1)
        ]
        assert worst(np.ravel(by[name]), np.ravel(ends[0] - ends[1]) / (2 * step)) < 1e-4, name


def test_a_fit_finds_size_rate_and_offset_from_an_image_and_spectra(run, geometry, spectra, images):
    rng = np.random.default_rng(3)
    noise = rng.normal(size=(1, 8, 14)), rng.normal(size=spectra.shape)
    image = 200.0 * images.value[:1].reshape(1, 8, 5, 14, 2).sum(axis=(2, 4)) + noise[0]
    options = {"delays": DELAYS[::5], "frequencies": EDGES[::2], "geometry": geometry, **RADAR, "gain": "free"}

    def shifted(offset):
        return observing.DelayDoppler(TIMES[:1], image, 1.0, frequency_offset=offset * u.Hz, **options)

    data = [shifted, spectrum_data(200.0 * spectra.value + noise[1], 1.0, geometry, gain="free")]
    fit = fullbody.fit(binary, {"a": 0.805, "rate": 1.51, "offset": 0.02}, data)
    for name, (truth, error) in {"a": (0.8, 0.02), "rate": (1.5, 0.02), "offset": (0.0, 0.2)}.items():
        assert abs(fit.values[name] - truth) < 4.0 * fit.sigma[name], name
        assert fit.sigma[name] < error, name
    assert fit.chi2 / fit.dof == pytest.approx(1.0, abs=0.2)


def test_a_jitter_widens_each_bin(run, geometry, spectra):
    data = spectrum_data(spectra, 3e-3 * u.km**2, geometry).with_jitter(4e-3 * u.km**2)
    np.testing.assert_allclose(data.sigma.to_value("km2"), 5e-3)
    errors = data.errors(run.system)
    np.testing.assert_allclose(errors.covariance, 25e-6)
    np.testing.assert_allclose(errors.without_jitter, 9e-6)


def test_tables_hold_spectra_and_rows_with_gaps_are_left_out(run, geometry, spectra):
    data = spectrum_data(spectra, 1e-3 * u.km**2, geometry)
    options = {"frequencies": EDGES, "geometry": geometry, **RADAR}
    again = observing.RadarSpectrum.from_table(data.to_table(), **options)
    assert again.chi2(run) < 1e-12
    assert again.power.shape == spectra.shape
    gap = spectra.copy()
    gap[1, 3] = np.nan
    with pytest.warns(InconsistentInput, match="1 of 4 rows of RadarSpectrum"):
        left = spectrum_data(gap, 1e-3 * u.km**2, geometry)
    assert left.rows.tolist() == [0, 2, 3]
    assert left.predict(run).shape == (3, 28)
    assert "28" in repr(left._tables())
    assert "bins" in repr(left._tables())


REFUSED = [
    (r"power of RadarSpectrum has shape \(4, 27\); expected \(K, 28\)", {"power": np.ones((4, 27))}),
    ("sigma of RadarSpectrum has the value 0", {"sigma": 0.0}),
    ("sigma of RadarSpectrum has shape", {"sigma": np.ones((1, 4, 28))}),
    ("only one of power and sigma has a unit", {"sigma": 1.0 * u.km**2}),
    ("gain of RadarSpectrum is 'any'", {"gain": "any"}),
    ("looks of RadarSpectrum is 0", {"looks": 0}),
    ("polarization of RadarSpectrum is 3", {"polarization": 3}),
    ("geometry of RadarSpectrum is 3", {"geometry": 3}),
]


@pytest.mark.parametrize(("match", "given"), REFUSED, ids=[row[0] for row in REFUSED])
def test_bad_spectra_are_refused_by_name(geometry, match, given):
    options = {"power": np.ones((4, 28)), "sigma": 1.0, "frequencies": EDGES, "geometry": geometry, **RADAR} | given
    refused(match, lambda: observing.RadarSpectrum(TIMES, options.pop("power"), options.pop("sigma"), **options))


def test_data_are_drawn_over_their_predictions(run, geometry, spectra, images):
    data = spectrum_data(spectra + 1e-3 * u.km**2, 1e-3 * u.km**2, geometry)
    axes = data.plot(run, row=1)
    points = axes[0, 0].containers[0][0]
    np.testing.assert_allclose(points.get_xdata(), 0.5 * (EDGES[1:] + EDGES[:-1]).value)
    np.testing.assert_allclose(points.get_ydata(), spectra[1].value + 1e-3)
    np.testing.assert_allclose(axes[1, 0].containers[0][0].get_ydata(), 1e-3, rtol=1e-9)
    assert axes[1, 0].get_xlabel() == "Doppler frequency [Hz]"
    shown = image_data(images * 1.5, 1e-3 * u.km**2, geometry).plot(run, row=2)
    values = [ax.collections[0].get_array() for ax in shown[0]]
    for result, expected in zip(values, (1.5 * images[2].value, images[2].value, 500.0 * images[2].value), strict=True):
        np.testing.assert_allclose(result, expected, rtol=1e-9, atol=1e-12)
    refused("row is 4", data.plot, run, row=4)


def test_runs_draw_their_echoes(run, geometry, spectra, images):
    ax = run.plot.radar_spectrum(TIMES[0], geometry, EDGES, bodies=True, **RADAR)
    np.testing.assert_allclose(ax.patches[0].get_data().values, spectra[0].value)
    assert [patch.get_label() for patch in ax.patches] == ["all bodies", "A", "B"]
    ax = run.plot.delay_doppler(TIMES[0], geometry, DELAYS, EDGES, **RADAR)
    np.testing.assert_allclose(ax.collections[0].get_array() ** 2, images[0].value, atol=1e-15)
    assert ax.yaxis_inverted()
    assert ax.get_ylabel().startswith("delay [")


def test_derivatives_of_light_over_an_exposure_are_differences_of_runs(run):
    vectors = {"to_observer": [0.1, 0.02, 0.03] * u.au, "to_sun": [0.9, 0.5, 0.0] * u.au}
    view = observing.Geometry([0.0, 12.0] * u.h, **vectors)
    data = observing.Photometry([3.0] * u.h, [0.0], 1.0, geometry=view, zero=0.0, exposure=1800 * u.s)
    state = run(data.emission(run.system)[0])
    steps = {"position": 1e-5, "velocity": 1e-5, "rotation": 1e-5, "spin": 1e-5}
    exact, differences = by_start(data, run.system, state, steps)
    assert worst(exact, differences) < 1e-6
