import numpy as np
from fullbody import Body, Ellipsoid

from reproduction.kw4_radar import study


def test_the_equivalent_of_an_ellipsoid_is_itself():
    body = Body(Ellipsoid(3.0, 2.0, 1.0), mass=5.0)
    np.testing.assert_allclose(study.equivalent(body).semi_axes, [3.0, 2.0, 1.0], rtol=1e-14)


def test_radar_shapes_conserve_and_differ_from_their_ellipsoids(tmp_path):
    path = study.write(tmp_path, draft=True, progress=False)
    assert path.read_text().startswith("# 1999 KW4 with its radar shapes\n\nA draft")
    assert (tmp_path / "libration.png").stat().st_size > 1e4
    found = {name: study.measure(run) for name, (run, _) in study.runs(100.0).items()}
    for numbers in found.values():
        assert numbers["energy drift, of the orbit's"] < 1e-12
        assert numbers["angular momentum drift"] < 1e-13
    # The quadrupoles are equal: the mean period differs by less than a thousandth, but by more than errors of the runs.
    radar, smooth = (numbers["mean period, h"] for numbers in found.values())
    assert 1e-9 < abs(radar / smooth - 1.0) < 1e-3
