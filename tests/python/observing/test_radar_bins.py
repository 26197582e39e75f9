"""Bins of radar echoes: sums, symmetries, integrations, responses of receivers, units, and what is refused."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import Ellipsoid, PointMass, Sphere, observing
from scipy.spatial.transform import Rotation
from support import refused, worst
from support.echoes import FULL, F, at_rest, image, run_of, spectrum
from support.meshes import torus

EDGES = np.linspace(-6.0, 6.0, 25)
DELAYS = np.linspace(-2e-5, 2e-5, 41)


def scene(order=(0, 1, 2), rotation=None):
    """Three bodies, of which two are partly hidden, in an order and all rotated together."""
    shapes = [Ellipsoid(0.7, 0.6, 0.5), Ellipsoid(0.3, 0.2, 0.25), torus(0.3, 0.1)]
    rng = np.random.default_rng(5)
    position, velocity = np.array([[0, 0, 0], [2.0, 0.4, 0.3], [-1.5, 0.5, -0.3]]), 1e-4 * rng.normal(size=(3, 3))
    attitude, spin = Rotation.random(3, rng=rng), 2e-4 * rng.normal(size=(3, 3))
    if rotation is not None:
        position, velocity = rotation.apply(position), rotation.apply(velocity)
        attitude = rotation * attitude
    quaternions = attitude.as_quat(scalar_first=True)
    pick = list(order)
    masses = np.array([1.0, 1e-9, 1e-9])[pick]
    rows = {"position": position, "velocity": velocity, "attitude": quaternions, "spin": spin}
    return run_of(*(shapes[k] for k in pick), masses=masses, **{name: value[pick] for name, value in rows.items()})


def test_bins_add_up_to_wider_ones_and_to_spectra():
    run = scene()
    fine, wide = spectrum(run, EDGES, per_body=True), spectrum(run, EDGES[::4], per_body=True)
    assert worst(fine.reshape(3, -1, 4).sum(axis=2), wide) < 1e-11
    assert worst(spectrum(run, EDGES), fine.sum(axis=0)) < 1e-15
    images = image(run, DELAYS, EDGES, per_body=True)
    assert worst(images.sum(axis=1), fine) < 1e-11
    assert worst(image(run, DELAYS[::5], EDGES[::4]), images.sum(axis=0).reshape(8, 5, 6, 4).sum(axis=(1, 3))) < 1e-11
    assert images.min() == 0.0


def test_echoes_follow_the_names_of_bodies_and_the_axes_of_space():
    result = image(scene(), DELAYS, EDGES, per_body=True)
    assert worst(image(scene([2, 0, 1]), DELAYS, EDGES, per_body=True), result[[2, 0, 1]]) < 1e-12
    rotation = Rotation.from_rotvec([0.3, -0.8, 1.1])
    rotated = image(scene(rotation=rotation), DELAYS, EDGES, at_rest(rotation.apply([1.0, 0, 0])), per_body=True)
    assert worst(rotated, result) < 1e-9


def test_ellipsoids_keep_their_exact_echo_beside_polyhedra_that_hide_nothing_of_them():
    # The second ellipsoid and the ring are beside or behind the first one.
    run = scene()
    both = image(run, DELAYS, EDGES, per_body=True)
    assert worst(image(run, DELAYS, EDGES, per_body=True, mutual=False)[1], both[1]) == 0.0


def test_a_body_that_does_not_rotate_has_its_echo_in_one_bin():
    for spin in ([0.0, 0.0, 0.0], [1e-4, 0.0, 0.0]):
        for shape in (Ellipsoid(0.7, 0.6, 0.5), torus(0.3, 0.1)):
            run = run_of(shape, spin=[spin])
            result = spectrum(run, EDGES)
            assert np.flatnonzero(result).tolist() == [12], "the bin that begins at zero"
            assert worst(image(run, DELAYS, EDGES)[:, 12].sum(), result[12]) < 1e-11


def test_a_body_that_rotates_about_an_oblique_line_of_sight_has_its_echo_in_one_bin():
    for direction in np.random.default_rng(2).normal(size=(5, 3)):
        run = run_of(Ellipsoid(0.7, 0.6, 0.5), spin=[1e-4 * direction])
        result = spectrum(run, EDGES, at_rest(direction))
        assert np.flatnonzero(result).tolist() == [12], "the bin that begins at zero"


def test_an_exposure_beyond_the_run_is_refused_by_name():
    run = run_of(Sphere(0.5), until=10.0)
    refused("time of a radar echo", spectrum, run, EDGES, exposure=100.0)
    refused("exposure is nan|exposure is", spectrum, run, EDGES, exposure=np.nan)


def test_bands_and_bodies_without_an_echo_have_zeros():
    run = scene()
    assert (spectrum(run, [50.0, 60.0, 70.0]) == 0.0).all()
    assert (image(run, [1.0, 2.0], EDGES) == 0.0).all()
    assert (image(run, DELAYS, [-9.0, -8.0]) == 0.0).all()
    assert (
        spectrum(run_of(PointMass(), Sphere(0.1), position=[[0, 0, 0], [0, 1, 0]]), EDGES, per_body=True)[0] == 0.0
    ).all()


def test_an_echo_over_an_exposure_is_the_mean_of_many():
    # A body turns by a fifth of a radian in 40 s, and its band widens by some bins.
    motion = {"position": [[0, 0, 0], [0, 2, 0]], "velocity": [[0, 0, 0], [2e-5, 0, 0]], "masses": [1.0, 1e-9]}
    spin = [[0, 1e-5, 1e-4], [0, 0, 5e-3]]
    run = run_of(Sphere(0.5), Ellipsoid(0.4, 0.1, 0.1), spin=spin, until=100.0, **motion)
    view = observing.Geometry(
        np.array([-100.0, 0, 100]) * u.s, to_observer=[[1e6, -5e3, 0], [1e6, 0, 0], [1e6, 5e3, 0]] * u.km
    )
    edges, moment = np.linspace(-40.0, 40.0, 21) * u.Hz, 50.0
    options = FULL | {"transmit_frequency": F * u.Hz}
    result = observing.radar_spectrum(run, [moment] * u.s, view, edges, exposure=40.0 * u.s, **options).power.value[0]
    moments = moment - 20.0 + 40.0 * (np.arange(200) + 0.5) / 200
    each = observing.radar_spectrum(run, moments * u.s, view, edges, **options).power.value
    assert worst(result, each.mean(axis=0)) < 2e-3 < worst(each[0], each.mean(axis=0))


def test_light_over_an_exposure_is_the_mean_of_many():
    run = run_of(Ellipsoid(0.7, 0.3, 0.5), spin=[[0, 0, 2e-3]], until=2000.0)
    view = observing.Geometry(
        [0.0, 2000.0] * u.s, to_observer=[1, 0, 0] * u.au, to_sun=[1, 0.5, 0] * u.au, light_time=False
    )
    result = observing.light_curve(run, [1000.0] * u.s, view, exposure=600 * u.s)
    samples = observing.light_curve(run, (700.0 + 600.0 * (np.arange(400) + 0.5) / 400) * u.s, view)
    assert result[0] == pytest.approx(-2.5 * np.log10(np.mean(10 ** (-0.4 * samples))), abs=1e-6)
    assert abs(result[0] - observing.light_curve(run, [1000.0] * u.s, view)[0]) > 1e-3


def test_responses_of_the_receiver_spread_an_echo_by_their_own_form():
    # Without rotation the echo has one frequency, and that of a small ball one delay.
    run = run_of(Sphere(1e-3), position=[[0, 0, 0]])
    total = spectrum(run, [-1.0, 1.0])[0]
    middles = np.arange(-30.0, 31.0)
    edges = np.append(middles - 0.5, 30.5)
    result = spectrum(run, edges - 0.3, frequency_response="sinc2")
    # The echo is known to a cell, a sixteenth of a bin.
    assert worst(result, total * np.sinc(middles - 0.3) ** 2) < 0.08
    assert result.sum() == pytest.approx(total, rel=0.01)
    of_delay = image(run, 1e-6 * (edges - 0.3), [-1.0, 1.0], delay_response="triangle2")[:, 0]
    assert worst(of_delay, 1.5 * total * np.clip(1.0 - abs(middles - 0.3), 0.0, None) ** 2) < 0.12
    smooth = run_of(Sphere(0.5), spin=[[0, 0, 1e-4]])
    unresolved = image(smooth, DELAYS, EDGES)
    of_frequency = image(smooth, DELAYS, EDGES, frequency_response="sinc2")
    assert of_frequency.sum() == pytest.approx(unresolved.sum(), rel=0.02)
    # The squares of triangles add up to one only in the mean over the places of a narrow echo within a bin.
    seen = image(smooth, DELAYS, EDGES, frequency_response="sinc2", delay_response="triangle2")
    assert seen.sum() == pytest.approx(unresolved.sum(), rel=0.1)
    assert seen.max() < unresolved.max()
    assert (seen >= 0.0).all()


def test_units_and_names_come_with_the_echo():
    run = scene()
    edges, delays = EDGES * 1e-3 * u.kHz, DELAYS * u.s.to(u.us) * u.us
    options = FULL | {"transmit_frequency": 2.38 * u.GHz}
    result = observing.delay_doppler(run, [0.0], at_rest(), delays, edges, per_body=True, **options)
    assert worst(result.power.to_value("km2")[0], image(run, DELAYS, EDGES, per_body=True)) < 1e-9
    assert result.bodies == ("A", "B", "C")
    assert result.frequencies.unit == 1 / u.s
    assert result.delays.unit == u.s
    data = result.to_xarray()
    assert data.sizes == {"time": 1, "body": 3, "delay": 40, "frequency": 24}
    assert data.attrs["units"] == "km2"
    np.testing.assert_allclose(data.frequency, 0.5 * (EDGES[1:] + EDGES[:-1]))
    total = observing.radar_spectrum(run, [0.0, 0.0], at_rest(), edges, **options)
    assert total.to_xarray().dims == ("time", "frequency")
    assert total.delays is None
    laws = {"A": observing.Cosine(1.0, 0.3), "B": observing.Cosine(1.0, 0.6), "C": observing.Cosine(1.0, 0.0)}
    each = spectrum(run, EDGES, per_body=True, law=laws)
    assert worst(each, spectrum(run, EDGES, per_body=True) * np.array([[1.0], [2.0], [0.0]])) < 1e-14


def near(distance):
    """A radar at a distance in km."""
    return observing.Geometry([0.0], to_observer=[distance, 0, 0] * u.km, light_time=False)


REFUSED = [
    (r"frequencies has 1\.0 after 2\.0", {"frequencies": [0.0, 2.0, 1.0]}),
    (r"frequencies has 1\.0 after 1\.0", {"frequencies": [0.0, 1.0, 1.0]}),
    ("frequencies has 1 values", {"frequencies": [0.0]}),
    ("frequencies has shape", {"frequencies": np.zeros((2, 2))}),
    ("frequencies has nan|frequencies is", {"frequencies": [0.0, np.nan]}),
    ("transmit_frequency is .*999.* 1 MHz or more", {"transmit_frequency": 999.0 * u.kHz}),
    ("transmit_frequency", {"transmit_frequency": 1.0 * u.m}),
    ("law is LommelSeeliger", {"law": observing.LommelSeeliger()}),
    ("law has none for 'B'", {"law": {"A": observing.Cosine()}}),
    ("frequency_response is 'boxcar'", {"frequency_response": "boxcar"}),
    ("transmitter is 3", {"transmitter": 3}),
    ("expected distances of both, or directions of both", {"transmitter": near(1e6)}),
    ("transmitter as seen from A", {"transmitter": at_rest([-1.0, 0.0, 0.0])}),
    ("exposure is -1", {"exposure": -1.0}),
    ("per_body is 1", {"per_body": 1}),
    ("mutual is 1", {"mutual": 1}),
    ("receiver of the geometry is inside A", {"geometry": near(0.1)}),
    ("receiver of the geometry is too near", {"geometry": near(9.0)}),
]  # fmt: skip


@pytest.mark.parametrize(("match", "given"), REFUSED, ids=[row[0] for row in REFUSED])
def test_bad_options_of_a_radar_are_refused_by_name(match, given):
    options = {"geometry": at_rest(), "frequencies": EDGES} | FULL | given
    run = run_of(Sphere(0.7), Sphere(0.3), position=[[0, 0, 0], [0, 3, 0]], masses=[1.0, 1e-9])
    refused(match, lambda: observing.radar_spectrum(run, [0.0], **options))


def test_a_system_without_units_is_refused_and_so_are_laws_out_of_range():
    system, state = fullbody.systems.case1()
    run = system.integrate(state, 1.0)
    refused("needs the system's units", observing.radar_spectrum, run, [0.0], at_rest(), [0, 1], **FULL)
    for law, bad in (
        (observing.Cosine, {"C": -1.0}),
        (observing.Hagfors, {"C": 0.0}),
        (observing.Gaussian, {"C": 1, "cutoff": 2.0}),
    ):
        refused(f"of {law.__name__}", law, **bad)
