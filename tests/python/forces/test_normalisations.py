"""Coefficients of radiation mean what the papers that define them say; the formulas here are the papers' own."""

import fullbody
import numpy as np
import pytest
import scipy.interpolate
from fullbody.forces import Byorp, Yorp, solar_pressure
from support import inertia, refused

u = pytest.importorskip("astropy.units")
C = 299792458.0
AU = 1.495978707e11
LUMINOSITY = 3.828e26
#: 1999 KW4's orbit round the Sun.
SOLAR = (0.642 * AU, 0.688)
AXES = np.array([0.285, 0.2315, 0.1745])
RADIUS = float(np.cbrt(AXES.prod()))
ON_BETA = {"on": "Beta", "about": "Alpha"}


def pair(ratio=0.05):
    """A sphere and a locked secondary of the same density on a circular orbit; km, hours, kg."""
    density = 2000e9
    primary = fullbody.Body(fullbody.Sphere(RADIUS / np.cbrt(ratio)), density=density, name="Alpha")
    secondary = fullbody.Body(fullbody.Ellipsoid(*AXES), density=density, name="Beta")
    system = fullbody.System([primary, secondary], units=("km", "hour", "kg"))
    G, a = system.G.value, 3.0
    n = float(np.sqrt(G * 4.0 / 3.0 * np.pi * density * RADIUS**3 * (1.0 + 1.0 / ratio) / a**3))
    shares = np.array([-ratio, 1.0])[:, None] / (1.0 + ratio)
    position, velocity = shares * [a, 0, 0] * u.km, shares * [0, n * a, 0] * u.km / u.hour
    state = fullbody.State(position, velocity, spin=[[0, 0, 0], [0, 0, n]] * u.rad / u.hour)
    return system, state, a * 1e3, n / 3600.0, density * 1e-9


def strength(force):
    """The force on Beta along its motion, N."""
    system, state, *_ = pair()
    loads = system.with_forces([force]).loads(state)[force.name]
    assert not loads.torque.value.any()
    assert not loads.force[0].value.any()
    return loads.force[1, 1].to_value(u.N)


def test_solar_pressure_is_the_mean_along_the_orbit():
    a, e = SOLAR
    eccentric = np.linspace(0.0, 2.0 * np.pi, 2000, endpoint=False)
    distance = a * (1.0 - e * np.cos(eccentric))
    # The time goes as (1 - e cos E) dE.
    mean = np.mean(LUMINOSITY / (4.0 * np.pi * C * distance**2) * (distance / a))
    assert solar_pressure(a * u.m, e).to_value(u.Pa) / mean == pytest.approx(1.0, rel=1e-12)
    # The solar constant, 1361 W/m2.
    assert solar_pressure("1 au").to_value(u.Pa) * C == pytest.approx(1361.0, rel=2e-4)


@pytest.mark.parametrize("ratio", [0.02, 0.3])
def test_byorp_drift_is_that_of_jacobson_and_scheeres(ratio):
    """Their drift of a is 3 H B a^(3/2) / (2 pi omega_d rho R_p^2 q^(1/3)), in radii of the primary.

    H is F_s / (a^2 sqrt(1 - e^2)) of the orbit about the Sun, with F_s rounded to 1e17 N.
    """
    system, state, a, n, density = pair(ratio)
    B, H = -3e-3, 1e17 / (SOLAR[0] ** 2 * np.sqrt(1.0 - SOLAR[1] ** 2))
    force = Byorp(**ON_BETA, coefficient=B, normalization="jacobson_scheeres_2011", pressure=H * u.Pa)
    F = system.with_forces([force]).loads(state)["BYORP on Beta"].force[1, 1].to_value(u.N)
    mass = system["Beta"].mass.to_value(u.kg)
    primary = 1e3 * RADIUS / np.cbrt(ratio)
    G = system.G.to_value(u.m**3 / u.kg / u.s**2)
    breakup = np.sqrt(4.0 / 3.0 * np.pi * G * density)
    theirs = 3.0 * H * B * (a / primary) ** 1.5 / (2.0 * np.pi * breakup * density * primary**2 * np.cbrt(ratio))
    # They take the mean motion of a secondary without mass.
    assert 2.0 * F / (mass * n) * np.sqrt(1.0 + ratio) / primary / theirs == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "factor"),
    [("quillen_2022", 1.0), ("steinberg_sari_2011", 2.0 * np.pi / 3.0), ("wang_hou_2021", 2.0 * np.pi / 3.0)],
)
def test_byorp_forces_are_those_of_quillen_of_steinberg_and_sari_and_of_wang_and_hou(name, factor):
    """The papers give torques about the primary at a distance a.

    Quillen et al.: f P R^2 a. Steinberg & Sari: f = (3/2) torque / (pi R^2 a P). Wang & Hou: (2/3) P pi R^2 f a.
    """
    F = strength(Byorp(**ON_BETA, coefficient=1.7e-3, normalization=name, pressure="4.5e-6 Pa", radius="0.2 km"))
    assert F / (factor * 1.7e-3 * 4.5e-6 * 200.0**2) == pytest.approx(1.0, rel=1e-12)


def alpha_torque(force):
    """Torque on Alpha along its spin, N m, and its moment of inertia, kg m^2."""
    system, state = fullbody.systems.kw4(units=True)
    loads = system.with_forces([force]).loads(state)[force.name]
    C_alpha = inertia(2.353e12, 1e3 * np.array([1.417, 1.361, 1.183]) / 2.0).max()
    return loads.torque[0].to_value(u.N * u.m), C_alpha


def test_a_measured_acceleration_changes_the_spin_by_itself():
    torque, C_alpha = alpha_torque(Yorp("Alpha", along="3.49e-8 rad / day2", normalization="acceleration"))
    assert torque / C_alpha == pytest.approx([0.0, 0.0, 3.49e-8 / 86400.0**2], rel=1e-12, abs=1e-30)
    # Degrees and a plain number in the system's own units mean the same.
    degrees, _ = alpha_torque(Yorp("Alpha", along=np.rad2deg(3.49e-8) * u.deg / u.day**2, normalization="acceleration"))
    unitless, _ = alpha_torque(Yorp("Alpha", along=3.49e-8 / 576.0, normalization="acceleration"))
    assert degrees == pytest.approx(torque, rel=1e-12)
    assert unitless == pytest.approx(torque, rel=1e-12)


def test_yorp_rate_is_that_of_rossi():
    """A rate of the spin F_s Y / (2 pi density R^2 d^2).

    The number is that of the notebook order_of_mag in Quillen's asteroid_binary: 2.21e-17 rad/s^2 for Y = 0.01.
    """
    radius, density = 390.0, 2141.3
    body = fullbody.Body(fullbody.Sphere(radius), density=density, name="Didymos")
    far = fullbody.Body(fullbody.PointMass(), mass=1.0, name="far")
    pressure = 3.8e26 / (4.0 * np.pi * 3e8 * 1.5e11**2)
    force = Yorp("Didymos", along=0.01, normalization="rossi_2009", pressure=pressure)
    system = fullbody.System([body, far], G=6.7e-11, forces=[force])
    state = fullbody.State([[0, 0, 0], [5e3, 0, 0]], np.zeros((2, 3)), spin=[[0, 0, 1e-3], [0, 0, 0]])
    rate = system.loads(state)[force.name].torque[0, 2] / (0.4 * 4.0 / 3.0 * np.pi * radius**5 * density)
    assert rate / 2.21e-17 == pytest.approx(1.0, rel=0.014)
    assert rate / (pressure * 0.01 / (2.0 * np.pi * density * radius**2)) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize(("name", "factor"), [("quillen_2022", 1.0), ("steinberg_sari_2011", 2.0 * np.pi / 3.0)])
def test_yorp_torques_are_those_of_quillen_and_of_steinberg_and_sari(name, factor):
    """Both papers scale a torque: Quillen et al. by F R^3 / c, Steinberg & Sari by two thirds of pi times that."""
    along, _ = alpha_torque(Yorp("Alpha", along=0.01, normalization=name, pressure="4.5e-6 Pa", radius="700 m"))
    assert along[2] == pytest.approx(factor * 0.01 * 4.5e-6 * 700.0**3, rel=1e-12)
    options = {"normalization": name, "pressure": "4.5e-6 Pa", "radius": "700 m"}
    both, _ = alpha_torque(Yorp("Alpha", along=0.01, across=0.02, **options))
    assert np.linalg.norm(both[:2]) == pytest.approx(2.0 * along[2], rel=1e-12)


def test_a_table_of_rates_is_read_at_the_obliquity():
    obliquity = np.deg2rad([0.0, 60.0, 120.0, 180.0])
    table = Yorp("Alpha", along=1e-9 * np.cos(obliquity), obliquity=obliquity, normalization="acceleration")
    linear, C_alpha = alpha_torque(table)
    spline = scipy.interpolate.CubicSpline(obliquity, 1e-9 * np.cos(obliquity), bc_type="not-a-knot")
    assert linear[2] / C_alpha * 3600.0**2 / spline(np.deg2rad(3.2)) == pytest.approx(1.0, rel=1e-9)


LIGHT = {"pressure": 1e-5}


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Byorp("Beta", "Alpha"), "force and coefficient of BYORP on Beta"),
        (lambda: Byorp("Beta", "Alpha", force=1.0, coefficient=1.0), "expected one of the two"),
        (lambda: Byorp("Beta", "Alpha", coefficient=1e-3, **LIGHT), "normalization of BYORP on Beta is not given"),
        (lambda: Byorp("Beta", "Alpha", coefficient=1e-3, normalization="mine", **LIGHT), "jacobson_scheeres_2011"),
        (lambda: Byorp("Beta", "Alpha", coefficient=1e-3, normalization="quillen_2022"), "pressure of BYORP on Beta"),
        (lambda: Byorp("Beta", "Alpha", force=1.0, **LIGHT), "expected none without a coefficient"),
        (lambda: Byorp("Beta", "Alpha", force=1.0, normalization="quillen_2022"), "none without a coefficient"),
        (lambda: Yorp("Alpha", along=1.0, normalization="quillen"), "expected 'acceleration'"),
        (lambda: Yorp("Alpha", along=1.0, normalization="rossi_2009"), "pressure of YORP on Alpha"),
        (lambda: Yorp("Alpha", along=1.0, across=1.0, normalization="rossi_2009", **LIGHT), "across of YORP on Alpha"),
        (lambda: Yorp("Alpha", along=1.0, radius=0.7, normalization="acceleration"), "radius of YORP on Alpha"),
        (lambda: solar_pressure(0.64), "semi_major_axis is 0.64"),
        (lambda: solar_pressure("0.64 au", 1.0), "eccentricity is 1.0"),
        (lambda: Yorp("Alpha", along=[1.0, 2.0], normalization="acceleration"), "one at each obliquity"),
        (lambda: Yorp("Alpha", along="1 N m", normalization="acceleration"), "unit such as"),
    ],
)
def test_inconsistent_arguments_of_radiation_are_refused(make, says):
    refused(says, make)
