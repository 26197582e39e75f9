"""Pictures of the bodies in the sky: places, areas in light and in shadow, and films."""

import astropy.units as u
import fullbody
import matplotlib
import numpy as np
import pytest
from fullbody import observing
from PIL import Image
from support import body_list, refused

#: One km is one mas at this distance.
DISTANCE = (1.0 * u.rad).to_value("mas")
NIGHT = 0.13


def at_rest(sun, positions=((0.0, 0.0, 0.0), (0.0, 5.0, 0.0))):
    """Spheres of radius 2 and 1 km, seen along +x, so that y is east and z is north."""
    bodies = body_list(A=(fullbody.Sphere(2.0), 9e12), B=(fullbody.Sphere(1.0), 1e9))
    system = fullbody.System(bodies, units=True, frame="equatorial", gravity="point")
    run = system.integrate(fullbody.State(np.array(positions), np.zeros((2, 3))), 0.02, dense=True)
    lines = {"to_observer": [-DISTANCE, 0, 0] * u.km, "to_sun": np.array(sun) * u.km}
    return run, observing.Geometry([-1.0, 1.0] * u.h, **lines, light_time=False)


pytestmark = pytest.mark.filterwarnings("ignore:. has a density")


def faces(ax):
    """The areas (F,) and greys (F,) of the faces of each body, the farther one first."""
    for drawn in ax.collections:
        a, b, c = np.moveaxis(np.array([path.vertices[:3] for path in drawn.get_paths()]), 1, 0)
        (x, y), (z, w) = (b - a).T, (c - a).T
        yield 0.5 * np.abs(x * w - y * z), drawn.get_facecolor()[:, 0]


def test_north_is_up_and_east_to_the_left_and_the_sizes_are_those_in_the_sky():
    run, geometry = at_rest([-1e10, 0.0, 0.0])
    ax = run.plot.sky(0.0, geometry)
    assert ax.xaxis_inverted()
    assert ax.get_xlabel() == "east [mas]"
    positions = {text.get_text(): text.get_position() for text in ax.texts}
    assert positions["B"][0] == pytest.approx(5.0, abs=0.01)
    assert positions["B"][1] > 1.0
    assert positions["N"][1] > positions["E"][1]
    assert positions["E"][0] > positions["N"][0]
    areas = sorted(area.sum() for area, _ in faces(ax))
    np.testing.assert_allclose(areas, [np.pi, 4.0 * np.pi], rtol=5e-3)
    # A scale of a round length.
    scale = next(line for line in ax.lines if line.get_color() == "white")
    assert np.ptp(scale.get_xdata()) == pytest.approx(2.0, rel=1e-4)
    assert "2 km" in positions
    assert "phase angle 0.0°" in ax.get_title()
    matplotlib.pyplot.close("all")


def test_half_of_a_sphere_is_dark_at_quadrature():
    run, geometry = at_rest([0.0, 0.0, 1e10])
    for area, grey in faces(run.plot.sky(0.0, geometry)):
        assert area[grey > NIGHT].sum() == pytest.approx(0.5 * area.sum(), rel=0.02)
    matplotlib.pyplot.close("all")


def test_a_shadow_has_the_area_of_the_body_that_casts_it():
    # B is between A and the Sun, beside the line of sight.
    run, geometry = at_rest([-1e10, 1e9, 0.0], ((0.0, 0.0, 0.0), (-40.0, 4.0, 0.0)))
    (area, grey), (small_area, small_grey) = faces(run.plot.sky(0.0, geometry))
    lit = area[grey > NIGHT].sum()
    dark = observing.light_curve(run, [0.0] * u.h, geometry, per_body=True)
    assert np.isfinite(dark).all()
    # The shadow is seen at 5.7 degrees from the Sun; the terminator hides 0.25 % of the disc.
    assert area.sum() - lit == pytest.approx(np.pi + 0.0025 * 4.0 * np.pi, rel=0.05)
    assert small_area[small_grey > NIGHT].sum() > 0.98 * small_area.sum()
    # Behind A, seen from the Sun, B is dark.
    run, geometry = at_rest([-1e10, 1e9, 0.0], ((0.0, 0.0, 0.0), (40.0, -4.0, 0.0)))
    (_, grey), _ = faces(run.plot.sky(0.0, geometry))
    assert (grey == NIGHT).all()
    matplotlib.pyplot.close("all")


def test_a_film_of_the_sky_has_the_light_curve_beside_it(tmp_path):
    run, geometry = at_rest([-1e10, 1e9, 0.0])
    path = run.animate(tmp_path / "sky.gif", seconds=0.3, fps=10, dpi=40, geometry=geometry, view="sky")
    with Image.open(path) as film:
        assert (film.n_frames, film.size) == (3, (384, 192))
        picture = np.asarray(film.convert("L"), dtype=int)
    # The left half has the black sky, the right one white paper.
    assert (picture[:, :192] == 0).mean() > 0.2
    assert (picture[:, 230:] == 255).mean() > 0.5
    refused("geometry is None, but view='sky'", lambda: run.animate(tmp_path / "x.gif", view="sky"))
    refused("view is 'Sky'", lambda: run.animate(tmp_path / "x.gif", view="Sky", geometry=geometry))


def test_times_and_geometries_are_checked():
    run, geometry = at_rest([-1e10, 0.0, 0.0])
    refused("a picture of the sky is", lambda: run.plot.sky(5.0 * u.h, geometry))
    without = observing.Geometry([-1.0, 1.0] * u.h, to_observer=[-DISTANCE, 0, 0] * u.km, light_time=False)
    refused("Sun", lambda: run.plot.sky(0.0, without))
