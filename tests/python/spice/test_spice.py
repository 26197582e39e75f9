"""Runs as SPICE kernels, read back by SPICE itself, and states from kernels."""

from contextlib import contextmanager

import fullbody
import numpy as np
import pytest
import spiceypy
from astropy import units as u
from fullbody.errors import PrecisionWarning
from fullbody.spice import state as state_from_spice
from support import body_list, refused

IDS = {"Alpha": 920066391, "Beta": 120066391}
CENTRE = 20066391
START = 0.1234567
EPOCH = "2025-05-25T00:00:00 TDB"
#: Days from noon of 2000-01-01, by the calendar: 25 years with 7 leap days, 31+28+31+30+24 days, less half a day.
ET = (25 * 365 + 7 + 144 - 0.5) * 86400.0
#: From the ecliptic of J2000 to the equator by the obliquity alone; astropy's axes differ from it by less than 0.1".
OBLIQUITY = np.deg2rad(84381.406 / 3600)


@pytest.fixture(scope="module")
def system():
    return fullbody.systems.kw4(units=True)[0].with_options(epoch=EPOCH, frame="ecliptic")


@pytest.fixture(scope="module")
def start():
    """A start away from the origin, and at a time that is no whole second."""
    state = fullbody.systems.kw4(units=True)[1]
    position, velocity = state.position + [30, -20, 10] * u.km, state.velocity + [0.2, 0, 0.1] * u.km / u.h
    return state.replace(position=position, velocity=velocity, time=START * u.h)


@pytest.fixture(scope="module")
def run(system, start):
    return system.integrate(start, 40.0, dense=True)


@pytest.fixture(scope="module")
def kernels(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kernels")
    return [run.to_spk(folder / "kw4.bsp", IDS, CENTRE), *run.to_ck(folder / "kw4.bc", IDS)]


@contextmanager
def kernels_loaded(*paths):
    spiceypy.furnsh([str(path) for path in paths])
    try:
        yield
    finally:
        spiceypy.kclear()


@pytest.fixture
def loaded(kernels):
    with kernels_loaded(*kernels):
        yield


def seconds(run, count=60):
    """Times between the nodes, as SPICE's doubles, and the run's states then."""
    ets = ET + 3600.0 * np.random.default_rng(5).uniform(*(end.value for end in run.dense.range), count)
    return [(et, run((et - ET) / 3600.0)) for et in ets]


def angle(matrix, other):
    """The angle of the rotation from one matrix to the other."""
    difference = matrix @ other.T
    return (
        np.linalg.norm(
            [
                difference[2, 1] - difference[1, 2],
                difference[0, 2] - difference[2, 0],
                difference[1, 0] - difference[0, 1],
            ]
        )
        / 2
    )


def axes():
    """The axes of the system in those of SPICE."""
    return fullbody.frames.rotation("ecliptic", "equatorial")


def test_axes_are_those_of_the_ecliptic():
    c, s = np.cos(OBLIQUITY), np.sin(OBLIQUITY)
    assert angle(axes(), np.array([[1, 0, 0], [0, c, -s], [0, s, c]])) < np.deg2rad(0.1 / 3600)


def test_positions_and_velocities_between_the_nodes(run, loaded):
    mass = run.system.masses.value
    for et, state in seconds(run):
        centre = mass @ state.position.value / mass.sum()
        for k, body in enumerate(IDS.values()):
            result, _ = spiceypy.spkgeo(body, et, "J2000", CENTRE)
            assert np.abs(result[:3] - axes() @ (state.position[k].value - centre)).max() < 1e-9
        apart, _ = spiceypy.spkezr(str(IDS["Beta"]), et, "J2000", "NONE", str(IDS["Alpha"]))
        moving = axes() @ (state.velocity[1] - state.velocity[0]).to_value("km/s")
        assert np.abs(apart[3:] - moving).max() < 1e-12


def test_attitudes_and_spins_between_the_nodes(run, loaded):
    clock = -IDS["Alpha"]
    for et, state in seconds(run):
        for k, (name, body) in enumerate(IDS.items()):
            # Rows of SPICE's matrix are the body's axes.
            expected = (axes() @ state.rotation_matrix[k]).T
            assert angle(spiceypy.pxform("J2000", f"{name.upper()}_FIXED", et), expected) < 1e-12
            matrix, spin, _ = spiceypy.ckgpav(-body, spiceypy.sce2c(clock, et), 0.0, "J2000")
            assert angle(matrix, expected) < 1e-12
            turning = axes() @ state.rotation_matrix[k] @ state.spin[k].to_value("rad/s")
            assert np.abs(spin - turning).max() < 1e-11 * np.linalg.norm(turning)


def test_names_and_fixed_frames_are_known_to_spice(loaded):
    assert spiceypy.bodn2c("Beta") == IDS["Beta"]
    assert spiceypy.cnmfrm("BETA")[1] == "BETA_FIXED"
    assert "fullbody" in spiceypy.dafec(spiceypy.kdata(0, "SPK")[3], 10)[1][0]


def test_the_state_is_read_back_from_kernels(system, run, kernels):
    result = state_from_spice(system, IDS, CENTRE, time="11 h", kernels=kernels)
    expected = run(11.0)
    mass = system.masses.value
    for values, wanted in ((result.position, expected.position), (result.velocity, expected.velocity)):
        about = wanted.value - mass @ wanted.value / mass.sum()
        assert np.abs(values.value - about).max() < 1e-9
        assert values.unit == wanted.unit
    assert max(map(angle, result.rotation_matrix, expected.rotation_matrix)) < 1e-12
    assert np.abs((result.spin - expected.spin).value).max() < 1e-11
    assert result.time == expected.time
    # Nothing stays loaded, and it is the start of a run like the one it comes from.
    assert spiceypy.ktotal("ALL") == 0
    again = system.integrate(result, 20.0, output="ends")[-1]
    apart = (again.position[1] - again.position[0]) - (run(20.0).position[1] - run(20.0).position[0])
    assert np.abs(apart.value).max() < 1e-7


def test_kernels_that_are_loaded_stay_loaded(system, kernels, loaded):
    state_from_spice(system, IDS, CENTRE, time=1.0, kernels=kernels, frames={"Beta": "BETA_FIXED"})
    assert spiceypy.ktotal("ALL") == 4
    result = state_from_spice(system, IDS, CENTRE, time=1.0, frames={"Beta": "ALPHA_FIXED"})
    assert np.array_equal(result.attitude[0], result.attitude[1])


def test_runs_back_in_time_and_in_other_units_are_written(start, tmp_path):
    # The epoch in UTC is 69.184 s and less than 2 ms behind.
    hours = fullbody.systems.kw4(units=True)[0]
    bodies = [fullbody.Body(b.shape, mass=b.mass, name=b.name) for b in hours]
    system = fullbody.System(bodies, units=("m", "s", "kg"), epoch="2025-05-25T00:00:00 UTC", frame="equatorial")
    run = system.integrate(start, -18000.0, dense=True)
    assert run.dense.range[0] > run.dense.range[1]
    with kernels_loaded(run.to_spk(tmp_path / "b.bsp", IDS, CENTRE)):
        result, _ = spiceypy.spkgeo(IDS["Beta"], ET + 69.184 - 9000.0, "J2000", IDS["Alpha"])
    state = run(-9000.0)
    apart = (state.position[1] - state.position[0]).to_value("km")
    speed = np.linalg.norm(result[3:])
    assert np.linalg.norm(result[:3] - apart) < 2e-3 * speed


@pytest.mark.parametrize("direction", [1, -1])
def test_samples_alone_serve_where_they_are_dense_enough(system, start, run, direction, tmp_path):
    # Times are rounded to 1e-7 s, in which Alpha rotates by 4e-11 rad.
    state = run[0] if direction == 1 else run(10.0)
    close = system.integrate(state, 10.0 if direction == 1 else START, output=0.0413)
    path = close.to_spk(tmp_path / "close.bsp", IDS, CENTRE)
    attitudes = close.to_ck(tmp_path / "close.bc", IDS)
    with kernels_loaded(path, *attitudes):
        for hour in (0.13, 3.33, 9.99):
            et = ET + 3600.0 * hour
            state = run((et - ET) / 3600.0)
            result, _ = spiceypy.spkgeo(IDS["Beta"], et, "J2000", IDS["Alpha"])
            apart = state.position[1] - state.position[0]
            assert np.abs(result[:3] - axes() @ apart.value).max() < 1e-9
            expected = (axes() @ state.rotation_matrix[0]).T
            assert angle(spiceypy.pxform("J2000", "ALPHA_FIXED", et), expected) < 1e-12


def test_samples_that_are_too_far_apart_are_refused(system, start, tmp_path):
    wide = system.integrate(start, 40.0, output=2.0)
    message = r"follows from the others only to within .* km; integrate with dense=True"
    with pytest.warns(PrecisionWarning, match=message):
        wide.to_spk(tmp_path / "wide.bsp", IDS, CENTRE)
    with pytest.warns(PrecisionWarning, match="rad; integrate with dense=True"):
        wide.to_ck(tmp_path / "wide.bc", IDS)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"epoch": None}, r"needs the system's epoch; give fullbody.System\(..., epoch='"),
        ({"frame": None}, r"needs the system's frame; give fullbody.System\(..., frame='ecliptic'\)"),
        ({"frame": "orbit"}, "cannot rotate from the frame 'orbit'"),
    ],
)
def test_missing_units_epochs_and_frames_are_named(system, start, change, message, tmp_path):
    run = system.with_options(**change).integrate(start, 1.0, dense=True)
    for write in (lambda: run.to_spk(tmp_path / "a.bsp", IDS, CENTRE), lambda: run.to_ck(tmp_path / "a.bc", IDS)):
        refused(message, write)
    assert not list(tmp_path.iterdir())


def test_the_ends_of_a_run_are_within_it(system, start, tmp_path):
    for until in np.linspace(0.3, 0.4, 8):
        run = system.integrate(start, until, dense=True)
        path = str(run.to_spk(tmp_path / "a.bsp", {"Beta": 5}, CENTRE))
        first, last = np.ravel(spiceypy.wnfetd(spiceypy.spkcov(path, 5), 0))
        assert first - ET == pytest.approx(3600 * START, abs=2e-7)
        assert last - ET == pytest.approx(3600 * until, abs=2e-7)


@pytest.mark.parametrize(
    ("path", "ids", "barycentre", "message"),
    [
        ("a.spk", IDS, CENTRE, "ends in one of .bsp"),
        ("a.bsp", {}, CENTRE, "ids names no body; expected such as {'Alpha': 9"),
        ("a.bsp", 7, CENTRE, "ids is 7; expected NAIF's numbers by name"),
        ("a.bsp", {"Gamma": 3}, CENTRE, "ids has 'Gamma'; .*Alpha, Beta"),
        ("a.bsp", {"Alpha": 1.5}, CENTRE, "the id of Alpha is 1.5; expected the number that NAIF gives it"),
        ("a.bsp", {"Alpha": 2**31}, CENTRE, "the id of Alpha is 2147483648"),
        ("a.bsp", {"Alpha": 7, "Beta": 7}, CENTRE, "the id of Beta is 7, that of another body"),
        ("a.bsp", IDS, IDS["Beta"], "barycentre is 120066391, the id of a body"),
        ("a.bsp", IDS, "Sun", "barycentre is 'Sun'; expected the number"),
    ],
)
def test_bad_arguments_of_kernels_are_refused(run, path, ids, barycentre, message, tmp_path):
    refused(message, lambda: run.to_spk(tmp_path / path, ids, barycentre))
    assert not list(tmp_path.iterdir())


def test_names_that_give_no_frames_are_refused(system, start, tmp_path):
    bodies = [fullbody.Body(b.shape, mass=b.mass, name=name) for b, name in zip(system, ("a!", "A?"), strict=True)]
    twins = fullbody.System(bodies, units=True, epoch=EPOCH, frame="icrs")
    run = twins.integrate(start, 1.0, dense=True)
    refused("the name of a! gives 'A_FIXED' for its frame", lambda: run.to_ck(tmp_path / "a.bc", {"a!": 1, "A?": 2}))
    run.to_ck(tmp_path / "a.bc", {"a!": -658030})
    assert "FRAME_A_FIXED = -658030000" in (tmp_path / "a.tf").read_text()


def test_files_are_replaced_atomically(run, tmp_path):
    path = run.to_spk(tmp_path / "a.bsp", {"Beta": 5}, CENTRE)
    content = path.read_bytes()
    with pytest.raises(FileNotFoundError):
        run.to_spk(tmp_path / "none" / "a.bsp", IDS, CENTRE)
    run.to_spk(path, {"Beta": 5}, CENTRE)
    assert path.read_bytes() == content
    assert [p.name for p in tmp_path.iterdir()] == ["a.bsp"]


def test_a_single_time_and_numbers_without_units_are_no_run_for_a_kernel(system, start, tmp_path):
    for dense, message in ((False, "the run has 1 samples; a kernel needs three or more"), (True, "a stretch of time")):
        moment = system.integrate(start, START, dense=dense)
        refused(message, moment.to_spk, tmp_path / "a.bsp", IDS, CENTRE)
    system, state = fullbody.systems.kw4()
    run = system.with_options(epoch=EPOCH, frame="ecliptic").integrate(state, 1.0, dense=True)
    refused("an SPK kernel needs the system's units", lambda: run.to_spk(tmp_path / "a.bsp", IDS, CENTRE))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"time": "41 h"}, r"not contain the position of Alpha \(920066391\) from 20066391 at 41 h after 2025-05-25"),
        ({"frames": {"Alpha": "NO_SUCH"}}, r"the attitude of Alpha \(920066391\) at 1.0 after"),
        ({"frames": {"Gamma": "X"}}, "a body in frames is 'Gamma'"),
        ({"ids": {"Alpha": 5}}, "ids has no number of Beta; expected those of Alpha, Beta"),
        ({"kernels": ["none.bsp"]}, "none.bsp is not a kernel that SPICE can load"),
        ({"frames": 3}, "frames is 3; expected names of frames"),
        ({"frames": {"Alpha": 3}}, "frame of Alpha is 3; expected the name of a frame"),
        ({"kernels": "kw4.bsp"}, "kernels is 'kw4.bsp'; expected a sequence of paths"),
        ({"kernels": 3}, "kernels is 3; expected a sequence of paths"),
        ({"kernels": [3]}, "kernels has 3; expected paths"),
    ],
)
def test_kernels_that_lack_a_body_or_frame_are_named(system, kernels, options, message):
    arguments = {"ids": IDS, "barycentre": CENTRE, "kernels": kernels, "time": 1.0} | options
    refused(message, lambda: state_from_spice(system, **arguments))
    assert spiceypy.ktotal("ALL") == 0


def test_points_need_no_frame(start, kernels):
    bodies = body_list(Alpha=(fullbody.PointMass(), "2e12 kg"), Beta=(fullbody.Sphere("0.2 km"), "1e11 kg"))
    system = fullbody.System(bodies, units=True, epoch=EPOCH, frame="ecliptic")
    result = state_from_spice(system, IDS, CENTRE, time=1.0, kernels=kernels, frames={"Beta": "BETA_FIXED"})
    assert result.attitude[0].tolist() == [1, 0, 0, 0]
    assert result.spin[1].value[2] > 0.1
