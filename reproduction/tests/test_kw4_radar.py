"""1999 KW4 with its radar shapes and with ellipsoids of the same moments of inertia."""

import fullbody
import numpy as np

from reproduction.kw4_radar import study


def test_runs_conserve_energy_and_differ_between_shapes_and_ellipsoids(tmp_path):
    path = study.write(tmp_path, draft=True, progress=False)
    assert ", a draft of 200 hours. A year of (66391) 1999 KW4" in path.read_text()
    assert (tmp_path / "libration.png").stat().st_size > 1e4
    results = {name: study.measure(run) for name, (run, _) in study.runs(100.0).items()}
    for numbers in results.values():
        assert numbers["energy drift, relative to the orbit's energy"] < 1e-12
        assert numbers["angular momentum drift"] < 1e-13
    # The quadrupoles are equal: the mean period differs by less than a thousandth, but by more than the runs' errors.
    radar, smooth = (numbers["mean period, h"] for numbers in results.values())
    assert 1e-9 < abs(radar / smooth - 1.0) < 1e-3


def test_forces_of_shapes_and_ellipsoids_differ_from_degree_three_on():
    radar, state = fullbody.systems.kw4(shape="radar")
    smooth = study.with_ellipsoids(radar)

    def force(system, degree):
        return system.with_options(gravity=f"multipole:{degree}").interactions(state).force[1]

    assert np.linalg.norm(force(radar, 2) - force(smooth, 2)) < 1e-13 * np.linalg.norm(force(radar, 2))
    assert np.linalg.norm(force(radar, 3) - force(smooth, 3)) > 1e-5 * np.linalg.norm(force(radar, 3))


def test_a_rate_that_a_run_does_not_define_is_a_dash_in_the_tables():
    numbers = dict.fromkeys(study.COLUMNS, 1.0) | {"apsidal rate, deg/day": None}
    result = study.tables({"year": {"radar shapes": numbers, "ellipsoids": numbers}, "degrees": {"exact": numbers}})
    assert "| apsidal rate, deg/day | - | - |" in result["year"]
    assert result["degrees"].endswith("| exact | 1 | 1 | 1 | 1 |")
