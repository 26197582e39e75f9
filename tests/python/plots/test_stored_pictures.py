"""Each plot at 6 x 4 inches is legible, and looks like the picture that is stored beside this file.

``pytest --mpl-generate-path=tests/python/plots/pictures tests/python/plots/test_stored_pictures.py`` stores them anew.
"""

import astropy.units as u
import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from fullbody import analysis, fields, observing, plots
from fullbody.plots.scene import new_axes
from support.fits import START, VIEW, pair, pair_radar
from support.legibility import faults, small, without_text

QUICK = fullbody.Verner98(rtol=1e-9, atol=1e-9)


def figure(rows=1, columns=1, projection=None):
    """Axes in a figure of 6 x 4 inches, or higher for more than three rows."""
    if projection == "3d":
        return new_axes(plt.figure(figsize=(6.0, 4.0)))
    return plt.subplots(rows, columns, figsize=(6.0, max(4.0, 1.2 * rows)), layout="constrained")[1]


@pytest.fixture(scope="module")
def month(kw4_run):
    """Forty days of 1999 KW4, in which its orbit and its rotation are too fast for lines."""
    return kw4_run.system.integrate(kw4_run[0], 40 * u.day, output=1 * u.hour, integrator=QUICK)


@pytest.fixture(scope="module")
def forced():
    """Didymos with the Sun and a tide, with the frame that observations need."""
    system, state = fullbody.systems.didymos(units=True, frame="ecliptic", sun=True)
    tide = fullbody.forces.Tide("Didymos", "Dimorphos", k2=1e-5, lag="5 s")
    return system.with_forces([*system.forces, tide]).integrate(state, 24.0, output=0.5, dense=True)


@pytest.fixture(scope="module")
def geometry():
    vectors = {"to_observer": [0.1, 0.02, 0.0] * u.au, "to_sun": [0.9, 0.5, 0.0] * u.au}
    return observing.Geometry([-1.0, 30.0] * u.h, **vectors)


@pytest.fixture(scope="module")
def seen(forced, geometry):
    return forced, geometry


@pytest.fixture(scope="module")
def rotating():
    """The rotating frame of two spheres on a circle."""
    balls = [fullbody.Body(fullbody.Sphere(0.2), mass=m, name=n) for n, m in (("A", 0.9), ("B", 0.1))]
    state = fullbody.State(position=[[-0.1, 0, 0], [0.9, 0, 0]], velocity=[[0, -0.1, 0], [0, 0.9, 0]])
    return fields.Synodic(fullbody.System(balls, G=1.0), state)


def kicked(speed, spin):
    """Case 1 with a kick along x and faster rotation; some cases are refused."""
    system, state = fullbody.systems.case1()
    if speed > 0.25 and spin > 1.2:
        raise ValueError("refused")
    return system, state.kick("B", [speed, 0.0, 0.0]).replace(spin=spin * state.spin)


def last_eccentricity(run):
    return {"eccentricity": run.elements().e[-1]}


@pytest.fixture(scope="module")
def swept():
    parameters = {"speed": np.linspace(0.0, 0.4, 4), "spin": np.linspace(0.5, 1.5, 4)}
    return fullbody.sweep(kicked, parameters, 20.0, output=1.0, measure=last_eccentricity)


@pytest.fixture(scope="module")
def tracked():
    """A fit of the distance of two points, and the astrometry in it."""
    options = {"body": 1, "about": 0, "geometry": VIEW, "frame": "equatorial"}

    def setup(a):
        system, state = pair(a=a)
        return fullbody.System([*system], G=1.0, gravity="point", frame="equatorial"), state

    times, zero, random = np.linspace(1.0, 25.0, 12), np.zeros(12), np.random.default_rng(3)
    system, state = setup(2.55)
    run = system.integrate(state, 30.0, dense=True)
    exact = observing.Astrometry(times, zero, zero, 1e-4, **options).predict(run)
    measured = exact + random.normal(scale=1e-4, size=exact.shape)
    return fullbody.fit(setup, {"a": 2.54}, observing.Astrometry(times, *measured.T, 1e-4, **options))


def of_runs(name, rows=1, columns=1, run="kw4_run", **options):
    """A picture by a method of ``run.plot``."""

    def draw(request):
        axes = figure(rows, columns)
        getattr(request.getfixturevalue(run).plot, name)(axes, **options)
        return np.ravel(axes)[0].figure

    return draw


def of(fixture, function, projection=None, rows=1):
    """A picture by a function of a fixture and axes."""

    def draw(request):
        axes = figure(rows, projection=projection)
        function(request.getfixturevalue(fixture), axes)
        return np.ravel(axes)[0].figure

    return draw


def slopes(run):
    return fields.surface(run.system, run[0], "Alpha", rows=24)


def impacts(run, ax):
    """Grains off Beta of 1999 KW4, where they strike Alpha."""
    system, state = fullbody.systems.kw4()
    options = {"longitude": 1.0, "latitude": 0.3, "speed": np.linspace(0.1, 1.5, 80), "n": 80, "rng": 3}
    grains = fullbody.Particles.ejecta(system, state, "Beta", **options)
    plots.impacts(system.fly(state, grains, 20.0, output=0.5), "Alpha", ax)


def section(system, ax):
    """Periapses of three motions near 1999 KW4."""
    system, state = fullbody.systems.kw4()
    starts = [state.kick(1, [0.0, speed, 0.0]) for speed in (0.0, 0.01, 0.02)]
    result = analysis.section(system, starts, 300.0, fullbody.events.Periapsis(0, 1))
    result.plot(distance, lambda state: np.linalg.norm(state.velocity[1]), ax)


def distance(state):
    return np.linalg.norm(state.position[1] - state.position[0])


def in_sunlight(run, ax):
    """Two spheres, of which one is in the shadow of the other."""
    balls = [fullbody.Body(fullbody.Sphere(r), mass=1.0, name=n) for r, n in ((2.0, "A"), (1.0, "B"))]
    state = fullbody.State(position=[[0, 0, 0], [3.0, -3.0, 0.8]], velocity=[[0, 0, 0], [0.4, 0.3, 0]])
    run = fullbody.System(balls, G=1.0).integrate(state, 0.1)
    vectors = {"to_observer": [0.1, 0.02, 0.0], "to_sun": [1.0, -1.0, 0.1], "light_time": False}
    run.plot.scene(ax=ax, geometry=observing.Geometry([-1.0, 20.0], **vectors))


def spectrum(seen, ax):
    """The Doppler spectrum of Didymos and Dimorphos at 8,560 MHz."""
    run, geometry = seen
    options = {"transmit_frequency": 8.56 * u.GHz, "bodies": True}
    run.plot.radar_spectrum(8.0 * u.h, geometry, np.linspace(-20.0, 20.0, 161) * u.Hz, ax, **options)


def image(seen, ax):
    """The delay-Doppler image of Didymos and Dimorphos at 8,560 MHz."""
    run, geometry = seen
    delays, frequencies = np.linspace(-10.0, 10.0, 101) * u.us, np.linspace(-20.0, 20.0, 101) * u.Hz
    run.plot.delay_doppler(8.0 * u.h, geometry, delays, frequencies, ax, transmit_frequency=8.56 * u.GHz)


def chords(forced, ax):
    """Chords of Didymos and Dimorphos, one with a single contact and one miss."""
    path = {"to_observer": [[1e7, -2.0, 0.0], [1e7, 4.0, 0.0]] * u.km, "frame": "ecliptic"}
    heights = np.array([-0.25, -0.1, 0.0, 0.1, 0.25, 0.6])
    stations = np.stack([0.0 * heights, 0.0 * heights, heights], axis=1) * u.km
    star, geometry = [-1.0, 0.0, 0.0], observing.Geometry([0.0, 300.0] * u.s, **path)
    seen = observing.occultation_chords(forced, star, stations, geometry)
    ends = {name: np.full(6, np.nan) for name in ("disappearance", "reappearance")}
    for chord in (chord for chord in seen if chord.body == "Didymos"):
        for name, values in ends.items():
            values[chord.station] = getattr(chord, name).to_value("s")
    ends["reappearance"][4] = np.nan
    times = {name: values * u.s for name, values in ends.items()}
    where = {"star": star, "stations": stations, "geometry": geometry, "body": "Didymos"}
    observing.StellarOccultation(**times, sigma=0.5 * u.s, **where).plot(forced, ax)


def residuals_of_data(request):
    """Astrometry with its predictions and residuals, in a figure of its own size."""
    fit = request.getfixturevalue("tracked")
    return fit.observations[0].plot(fit.run)[0, 0].figure


PICTURES = {
    "orbit": of_runs("orbit"),
    "elements": of_runs("elements", 3, 2),
    "elements_of_a_month": of_runs("elements", 3, 2, run="month"),
    "spins": of_runs("spins", 2),
    "angles": of_runs("angles", 2, 3),
    "angles_of_a_month": of_runs("angles", 2, 3, run="month"),
    "libration": of_runs("libration"),
    "libration_of_a_month": of_runs("libration", run="month"),
    "energy": of_runs("energy"),
    "work": of_runs("work", run="forced"),
    "orbits_of_three": of_runs("orbit", run="triple_run"),
    "scene": of("kw4_run", lambda run, ax: run.plot.scene(ax=ax), "3d"),
    "shadow": of("kw4_run", in_sunlight, "3d"),
    "zero_velocity": of("rotating", lambda frame, ax: plots.zero_velocity(frame, ax=ax)),
    "roche_lobes": of("rotating", lambda frame, ax: plots.roche_lobes(frame, ax, rows=16), "3d"),
    "surface_map": of("kw4_run", lambda run, ax: plots.surface_map(slopes(run), ax=ax)),
    "surface_scene": of("kw4_run", lambda run, ax: plots.surface_scene(slopes(run), ax=ax), "3d"),
    "impacts": of("kw4_run", impacts),
    "sweep": of("swept", lambda found, ax: plots.sweep(found, "eccentricity", ax)),
    "sweep_of_one": of("swept", lambda found, ax: plots.sweep(found.isel(spin=-1), "eccentricity", ax)),
    "sky": of("seen", lambda seen, ax: seen[0].plot.sky(5.0 * u.h, seen[1], ax)),
    "radar_spectrum": of("seen", spectrum),
    "delay_doppler": of("seen", image),
    "chords": of("forced", chords),
    "data": residuals_of_data,
    "sky_track": of("tracked", lambda fit, ax: fit.plot.sky(ax)),
    "residuals": of("tracked", lambda fit, ax: fit.plot.residuals([ax])),
    "branch": of("locked", lambda equilibrium, ax: analysis.branch(equilibrium, "separation", until=1.9).plot(ax)),
    "modes": of("locked", lambda equilibrium, axes: equilibrium.modes.plot(axes), rows=7),
    "section": of("kw4_run", section),
}


def compared():
    """Compare the figures of a test with the stored pictures, in matplotlib's own style.

    These have no texts, so that versions of matplotlib with other letters draw the same.
    """
    style = {"style": "default", "backend": "agg", "savefig_kwargs": {"dpi": 40}, "tolerance": 5.0}
    return pytest.mark.mpl_image_compare(baseline_dir="pictures", **style)


@compared()
@pytest.mark.parametrize("name", PICTURES)
def test_plot(name, request):
    drawn = PICTURES[name](request)
    assert faults(drawn) == ([], [])
    assert not small(drawn)
    return without_text(drawn)


@compared()
def test_light_curve(forced, geometry):
    ax = figure()
    forced.plot.light_curve(np.linspace(1.0, 12.0, 200) * u.h, geometry, ax, views=4)
    assert faults(ax.figure) == ([], [])
    return without_text(ax.figure)


@compared()
def test_light_curve_of_each_body(forced, geometry):
    axes = figure(3)
    forced.plot.light_curve(np.linspace(1.0, 12.0, 200) * u.h, geometry, axes, bodies=True, views=3)
    assert faults(axes[0].figure) == ([], [])
    return without_text(axes[0].figure)


@compared()
def test_corner():
    """Draws from the normal distribution of a fit of two numbers; of its own size."""
    drawn = fullbody.fit(pair, START, pair_radar()).plot.corner(n=2000)
    assert faults(drawn) == ([], [])
    assert not small(drawn)
    return without_text(drawn)


@compared()
def test_sky(forced, geometry):
    ax = figure()
    forced.plot.sky(8.0 * u.h, geometry, ax)
    assert faults(ax.figure) == ([], [])
    assert not small(ax.figure)
    return without_text(ax.figure)


@compared()
@pytest.mark.parametrize("which", ["month", "triple_run"])
def test_page(which, request):
    page = request.getfixturevalue(which).plot()
    assert faults(page.figure) == ([], [])
    return without_text(page.figure)
